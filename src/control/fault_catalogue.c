/* SPDX-License-Identifier: MIT */
/*
 * The catalogue of causes: what can happen to the physics and the wire of each kind of encoder,
 * and what it does then. A value is beyond the limits of the models as delivered; where a limit is
 * configuration (the S36's type label, 2120h) it may have to be chosen by WORLd instead.
 */
#include "control_private.h"
#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"

#define RS485 &dg_hf_stack
#define BISS &dg_biss_stack
#define CAN &dg_cia406_stack
#define IBUS &dg_ib_stack

/* A quantity of the world: kind, wire, size, offset. */
#define SENSE(member)                                                                              \
    DG_FAULT_WORLD, 0, sizeof(((struct dg_world *)0)->member), offsetof(struct dg_world, member)
#define WIRE(what) DG_FAULT_WIRE, DG_WIRE_##what, 0, 0

#define LED_WORN "the LED of the scanner is worn out: its current is regulated up"
#define LED_DARK "the LED of the scanner has no current"
#define HOT "the housing is too hot"
#define COLD "the housing is too cold"
#define BATTERY_LOW "the battery of the multiturn counter is run down"
#define BATTERY_NONE "the battery of the multiturn counter is not connected"
#define DIRT "dirt in front of the receiver of this track"
#define GAIN "the amplifier of this track has too much gain"
#define STRAY "stray light on the receiver of this track"
#define SCRATCH "the singleturn track cannot be read"
#define MT_WEAK "the multiturn sensor's magnet is too weak"
#define MT_SYNC "multiturn and singleturn do not agree: a gear has slipped"
#define MT_VECTOR "the multiturn sensor's vector is out of range: a foreign magnetic field"
#define SILENT "the EEPROM does not acknowledge on its I2C bus"
#define WATCHDOG "the processor hung, and its watchdog has reset it"
#define LATE_NS(ns) ((int64_t)(ns))

/* clang-format off */
const struct dg_fault_row dg_fault_rows[] = {
    /* S36 RS485. 'no.' counts the choices of its page. */
    {"led_current_high",    RS485, SENSE(led_current_ua),          40000, LED_WORN,     "1Dh on the error stack; 42h, 43h, 6Ah answer 1Dh; 44h channel 49h tells 40 mA", "5.1.3"},
    {"led_current_low",     RS485, SENSE(led_current_ua),              0, LED_DARK,     "44h channel 49h tells 0 mA, below the type label's minimum; no code", "5.1.2.3; no. 26"},
    {"temperature_high",    RS485, SENSE(temperature_mdegc),      125000, HOT,          "1Eh on the error stack; 44h channel 48h tells 125 degC", "5.1.3"},
    {"temperature_low",     RS485, SENSE(temperature_mdegc),      -45000, COLD,         "1Eh on the error stack; 44h channel 48h tells -45 degC", "5.1.3"},
    {"sin_amplitude_low",   RS485, SENSE(sin_amplitude_permille),    500, DIRT,         "the sine signal is half as high; 44h channel 4Ah tells 500 where it peaks; no code", "4.1.3; no. 26"},
    {"sin_amplitude_high",  RS485, SENSE(sin_amplitude_permille),   1500, GAIN,         "the sine signal is 1.5 times as high; 44h channel 4Ah tells 1500 where it peaks; no code", "4.1.3; no. 26"},
    {"cos_amplitude_low",   RS485, SENSE(cos_amplitude_permille),    500, DIRT,         "the cosine signal is half as high; 44h channel 4Ah tells 500 where it peaks; no code", "4.1.3; no. 26"},
    {"cos_amplitude_high",  RS485, SENSE(cos_amplitude_permille),   1500, GAIN,         "the cosine signal is 1.5 times as high; 44h channel 4Ah tells 1500 where it peaks; no code", "4.1.3; no. 26"},
    {"sin_offset",          RS485, SENSE(sin_offset_permille),       500, STRAY,        "the sine signal is shifted by half its peak; 44h channel 4Ah tells 1500 where it peaks; no code", "4.1.3; no. 26"},
    {"cos_offset",          RS485, SENSE(cos_offset_permille),       500, STRAY,        "the cosine signal is shifted by half its peak; 44h channel 4Ah tells 1500 where it peaks; no code", "4.1.3; no. 26"},
    {"singleturn_lost",     RS485, SENSE(singleturn_ok),               0, SCRATCH,      "42h, 43h, 6Ah answer 20h", "5.1.3"},
    {"multiturn_amplitude", RS485, SENSE(multiturn_amplitude_ok),      0, MT_WEAK,      "multiturn: 42h, 43h, 6Ah answer 21h", "5.1.3"},
    {"multiturn_sync",      RS485, SENSE(multiturn_sync_ok),           0, MT_SYNC,      "multiturn: 42h, 43h, 6Ah answer 22h", "5.1.3"},
    {"multiturn_vector",    RS485, SENSE(multiturn_vector_ok),         0, MT_VECTOR,    "multiturn: 42h, 43h, 6Ah answer 23h", "5.1.3"},
    {"eeprom_silent",       RS485, SENSE(eeprom_acknowledges),         0, SILENT,       "commands on the EEPROM answer 05h; when it starts so, 05h on the error stack, 42h, 43h, 6Ah answer 02h until the next start", "5.1.3.5; no. 2"},
    {"wire_drop",           RS485, WIRE(DROP),                         0, "the line driver is broken", "the reply does not come", "5.1.1"},
    {"wire_deaf",           RS485, WIRE(DEAF),                         0, "the line receiver is broken", "the request is not heard: no reply", "5.1.1"},
    {"wire_delay",          RS485, WIRE(DELAY), LATE_NS(DG_MS(300)),      "the firmware is busy", "the reply comes 300 ms late, after every command's longest reaction time", "5.1.2"},
    {"wire_damage",         RS485, WIRE(DAMAGE),                       0, "a disturbance on the line", "one bit of the reply is flipped: its check sum is wrong", "5.1.1"},
    {"wire_duplicate",      RS485, WIRE(DUPLICATE),                    0, "a repeater with an echo", "the reply comes twice", "5.1.1"},

    /* S36 BiSS. Every bit of 69h but 2 is in EMASK as delivered: nERR is low. */
    {"led_current_high",    BISS,  SENSE(led_current_ua),          40000, LED_WORN,     "69h bit 0, nERR low", "5.2.3"},
    {"temperature_high",    BISS,  SENSE(temperature_mdegc),      125000, HOT,          "69h bit 2 and nERR or nWARN low while 22h or 23h have bit 2; 6Ah, 6Bh tell 125 degC", "5.2.3; no. 20"},
    {"temperature_low",     BISS,  SENSE(temperature_mdegc),      -45000, COLD,         "69h bit 2 and nERR or nWARN low while 22h or 23h have bit 2; 6Ah, 6Bh tell -45 degC", "5.2.3; no. 20"},
    {"sin_amplitude_low",   BISS,  SENSE(sin_amplitude_permille),    500, DIRT,         "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"sin_amplitude_high",  BISS,  SENSE(sin_amplitude_permille),   1500, GAIN,         "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"cos_amplitude_low",   BISS,  SENSE(cos_amplitude_permille),    500, DIRT,         "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"cos_amplitude_high",  BISS,  SENSE(cos_amplitude_permille),   1500, GAIN,         "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"sin_offset",          BISS,  SENSE(sin_offset_permille),       500, STRAY,        "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"cos_offset",          BISS,  SENSE(cos_offset_permille),       500, STRAY,        "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"singleturn_lost",     BISS,  SENSE(singleturn_ok),               0, SCRATCH,      "69h bit 5, nERR low; 60h bit 0 clear", "5.2.3"},
    {"multiturn_amplitude", BISS,  SENSE(multiturn_amplitude_ok),      0, MT_WEAK,      "69h bit 6, nERR low; 60h bits 0 and 1 clear", "5.2.3; no. 22"},
    {"multiturn_sync",      BISS,  SENSE(multiturn_sync_ok),           0, MT_SYNC,      "69h bit 3, nERR low; 60h bit 0 clear", "5.2.3; no. 22"},
    {"multiturn_vector",    BISS,  SENSE(multiturn_vector_ok),         0, MT_VECTOR,    "69h bit 6, nERR low; 60h bits 0 and 1 clear", "5.2.3; no. 22"},
    {"eeprom_silent",       BISS,  SENSE(eeprom_acknowledges),         0, SILENT,       "69h bit 4, nERR low, user banks refused; when it starts so, until command 04 or the next start", "5.2.3; no. 11, 23"},
    {"watchdog_fired",      BISS,  SENSE(watchdog_fired),              1, WATCHDOG,     "69h bit 7, nERR low", "5.2.3"},
    {"wire_drop",           BISS,  WIRE(DROP),                         0, "the line driver is broken now and then", "SLO stays high for the frame: no Ack", "5.2.1.1"},
    {"wire_delay",          BISS,  WIRE(DELAY), LATE_NS(DG_US(100)),      "the conversion takes too long", "the start bit comes after 100 us; 40 us are the longest", "5.2.1.1"},
    {"wire_damage",         BISS,  WIRE(DAMAGE),                       0, "a disturbance on the line", "one bit behind the start bit is flipped: CDS, or the CRC is wrong", "5.2.1.2"},
    {"wire_break",          BISS,  WIRE(BREAK),                        0, "a wire of SLO is broken", "SLO reads high: no Ack in any frame", "5.2.1.1"},

    /* F36x8. Causes are looked for every 100 ms at least. */
    {"led_current_high",    CAN,   SENSE(led_current_ua),          40000, LED_WORN,     "EMCY 5200h, 1001h bit 0", "15; no. 6"},
    {"temperature_high",    CAN,   SENSE(temperature_mdegc),      125000, HOT,          "EMCY 4200h, 1001h 09h, 6505h bit 15, 2120h:4 BDh", "14, 15, 26"},
    {"temperature_low",     CAN,   SENSE(temperature_mdegc),      -45000, COLD,         "EMCY 4200h, 1001h 09h, 6505h bit 15, 2120h:4 13h", "14, 15, 26"},
    {"battery_low",         CAN,   SENSE(battery_mv),               2300, BATTERY_LOW,  "multiturn: EMCY 3200h, 1001h 01h, 6505h bit 4", "15, 26; C23"},
    {"battery_missing",     CAN,   SENSE(battery_mv),                  0, BATTERY_NONE, "multiturn: EMCY 3200h, 1001h 05h, 6505h bit 4, 2125h 3FFh", "15, 26; C23"},
    {"singleturn_lost",     CAN,   SENSE(singleturn_ok),               0, SCRATCH,      "EMCY 1000h, 1001h bit 0, 6503h bit 0, both LEDs fast", "15, 26, 29"},
    {"multiturn_amplitude", CAN,   SENSE(multiturn_amplitude_ok),      0, MT_WEAK,      "multiturn: EMCY 1000h, 1001h bit 0, 6503h bit 0, both LEDs fast", "15, 26, 29"},
    {"multiturn_sync",      CAN,   SENSE(multiturn_sync_ok),           0, MT_SYNC,      "multiturn: EMCY 1000h, 1001h bit 0, 6503h bit 0, both LEDs fast", "15, 26, 29"},
    {"multiturn_vector",    CAN,   SENSE(multiturn_vector_ok),         0, MT_VECTOR,    "multiturn: EMCY 1000h, 1001h bit 0, 6503h bit 0, both LEDs fast", "15, 26, 29"},
    {"eeprom_silent",       CAN,   SENSE(eeprom_acknowledges),         0, SILENT,       "EMCY 5100h and 1000h, 6503h bit 1; 1010h, 1011h, 2105h abort 06060000h; when it starts so, 5100h until the next start", "15, 26; no. 8"},
    {"watchdog_fired",      CAN,   SENSE(watchdog_fired),              1, WATCHDOG,     "6505h bit 2, both LEDs 300 ms; no EMCY", "26, 29; no. 10"},
    {"wire_drop",           CAN,   WIRE(DROP),                         0, "a bridge loses frames to the master", "what the node sends does not arrive", "CiA 301"},
    {"wire_deaf",           CAN,   WIRE(DEAF),                         0, "a bridge loses frames from the master", "what the master sends does not arrive", "CiA 301"},
    {"wire_delay",          CAN,   WIRE(DELAY), LATE_NS(DG_MS(50)),       "the bus is overloaded", "what the node sends comes 50 ms late", "CiA 301"},
    {"wire_damage",         CAN,   WIRE(DAMAGE),                       0, "a bridge with a faulty memory", "one data bit is flipped and the CRC is right: a frame that is valid and wrong", "CiA 301"},
    {"wire_duplicate",      CAN,   WIRE(DUPLICATE),                    0, "a disturbance in the last bit: the controller repeats what was received already", "what the node sends comes twice", "CiA 301"},
    {"bus_off",             CAN,   WIRE(BUS_OFF),                      0, "the bus is short-circuited", "silence, 1029h:1 at once, error LED on; EMCY 8140h when it is over", "15, 29; CANopen no. 1"},
    {"error_passive",       CAN,   WIRE(PASSIVE),                      0, "many damaged frames", "EMCY 8120h, 1001h 11h", "15"},
    {"overrun",             CAN,   WIRE(OVERRUN),                      0, "the processor was too slow to take a frame", "the frame is lost, EMCY 8110h and 0000h", "15"},

    /* OCD INTERBUS. A K3 says it in IN, K1 and K2 as a module error in the ID word. */
    {"singleturn_lost",     IBUS,  SENSE(singleturn_ok),               0, SCRATCH,      "IN bit 31; K1, K2: ID bit 13", "9.3; I19"},
    {"multiturn_amplitude", IBUS,  SENSE(multiturn_amplitude_ok),      0, MT_WEAK,      "multiturn: IN bit 31; K1, K2: ID bit 13", "9.3; I19"},
    {"multiturn_sync",      IBUS,  SENSE(multiturn_sync_ok),           0, MT_SYNC,      "multiturn: IN bit 31; K1, K2: ID bit 13", "9.3; I19"},
    {"multiturn_vector",    IBUS,  SENSE(multiturn_vector_ok),         0, MT_VECTOR,    "multiturn: IN bit 31; K1, K2: ID bit 13", "9.3; I19"},
    {"eeprom_silent",       IBUS,  SENSE(eeprom_acknowledges),         0, SILENT,       "K3: parameters answer 86000000h; when it starts so, IN 86000000h until the next start", "9.4; no. 1"},
    {"wire_drop",           IBUS,  WIRE(DROP),                         0, "a disturbance on the remote bus", "a cycle without data: IN as before", "2"},
    {"wire_damage",         IBUS,  WIRE(DAMAGE),                       0, "a disturbance on the incoming bus", "a transmission error at this device: no data in this cycle and five more, ID bit 14", "2; no. 5"},
    {"wire_tear",           IBUS,  WIRE(TEAR),                         0, "a master that does not take the words of a device together", "IN is half of this cycle, half of the one before", "2; I21"},
    {"wire_break",          IBUS,  WIRE(BREAK),                        0, "the incoming bus is cut", "the ring is interrupted here: no data, RD on at the device before; then an ID cycle comes first", "3.3; no. 6"},
};
/* clang-format on */

const size_t dg_fault_row_count = sizeof dg_fault_rows / sizeof dg_fault_rows[0];
