/* SPDX-License-Identifier: MIT */
/*
 * The S36 BiSS as an instrument. Every bit of 69h but 2 is in EMASK as delivered: what sets one
 * also makes nERR low. BISS: frames and registers through a wire that the host clocks.
 */
#include "drehgeber/biss.h"
#include "drehgeber/control.h"
#include "drehgeber/instruments.h"

static const struct dg_scpi_range addresses = {DG_SCPI_PLAIN, 0, 0, 0x7F};
static const struct dg_scpi_range sizes = {DG_SCPI_PLAIN, 0, 1, DG_BISS_BANK_SIZE};
static const struct dg_scpi_range bytes_range = {DG_SCPI_PLAIN, 0, 0, UINT8_MAX};

static const char *mode(const void *self, dg_ns now)
{
    const struct dg_biss *device = self;

    if (device->line.state == DG_BISS_OFF) {
        return "off";
    }
    if (now < device->ready_at) {
        return "initialising";
    }
    if (device->channel_off) {
        return "channel-off";
    }
    return device->control.state >= DG_BISS_CONTROL_ADDRESS ? "control" : "idle";
}

static void state(const void *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_biss *device = self;
    const struct dg_biss_counters *counters = &device->counters;
    const bool on = device->line.state != DG_BISS_OFF;
    const uint8_t flags = on ? dg_biss_flags(device, now) : 0;

    dg_state_word(to, "leds", "-");
    dg_state_error_bits(to, on ? dg_biss_errors(device, now) : 0);
    dg_state_number(to, "frames", counters->frames);
    dg_state_number(to, "reads", counters->reads);
    dg_state_number(to, "writes", counters->writes);
    dg_state_number(to, "refused", counters->refused);
    dg_state_number(to, "damaged", counters->damaged);
    dg_state_number(to, "commands", counters->commands);
    dg_state_number(to, "nerr", flags >> 1);
    dg_state_number(to, "nwarn", flags & 1u);
    dg_state_number(to, "life", device->life);
    dg_state_number(to, "bank", device->bank);
}

static const struct dg_biss_port_ops *biss_port_of(struct dg_scpi *session)
{
    return dg_control_port(session, &dg_biss_stack, "it is no BiSS encoder",
                           "no simulated BiSS wire");
}

static void put_frame(struct dg_scpi *session, const struct dg_biss_model *model, uint64_t bits)
{
    struct dg_biss_data data;

    dg_biss_frame_decode(model, bits, &data);
    dg_scpi_put_unsigned(session, data.position);
    dg_scpi_put_unsigned(session, data.n_err);
    dg_scpi_put_unsigned(session, data.n_warn);
    dg_scpi_put_unsigned(session, data.life);
    dg_scpi_put_unsigned(session, data.crc_ok);
}

static void frame(struct dg_scpi *session)
{
    const struct dg_encoder *encoder = dg_control_selected(session);
    const struct dg_biss_port_ops *port = biss_port_of(session);
    char detail[DG_SCPI_DETAIL_MAX + 1u] = "";
    uint64_t bits = 0;
    uint8_t count = 0;

    if (port == NULL) {
        return;
    }
    const int code = port->frame(encoder->port_ctx, &bits, &count, detail);
    if (code != DG_SCPI_NO_ERROR) {
        dg_scpi_raise(session, code, detail);
    } else if (count <= 1) {
        dg_control_refuse(session, DG_SCPI_HARDWARE, "no data in the frame");
    } else {
        const struct dg_biss *device = encoder->device;
        put_frame(session, device->setup.model, bits);
    }
}

static void read(struct dg_scpi *session)
{
    char detail[DG_SCPI_DETAIL_MAX + 1u] = "";
    uint8_t bytes[DG_BISS_BANK_SIZE] = {0};
    int64_t address;
    int64_t n = 1;

    if (!dg_scpi_number(session, &addresses, &address) ||
        (dg_scpi_more(session) && !dg_scpi_number(session, &sizes, &n))) {
        return;
    }
    const struct dg_biss_port_ops *port = biss_port_of(session);
    if (port == NULL) {
        return;
    }
    const int code = port->read(dg_control_selected(session)->port_ctx, (uint8_t)address, bytes,
                                (size_t)n, detail);
    dg_scpi_raise(session, code, detail);
    for (int64_t i = 0; code == DG_SCPI_NO_ERROR && i < n; i++) {
        dg_scpi_put_unsigned(session, bytes[i]);
    }
}

static void write(struct dg_scpi *session)
{
    char detail[DG_SCPI_DETAIL_MAX + 1u] = "";
    uint8_t bytes[DG_BISS_BANK_SIZE];
    int64_t address;
    int64_t byte;
    size_t n = 0;

    if (!dg_scpi_number(session, &addresses, &address)) {
        return;
    }
    do {
        if (!dg_scpi_number(session, &bytes_range, &byte)) {
            return;
        }
        bytes[n++] = (uint8_t)byte;
    } while (n < sizeof bytes && dg_scpi_more(session));
    if (dg_scpi_more(session)) {
        dg_scpi_raise(session, DG_SCPI_SUPERFLUOUS, "at most 64 bytes");
        return;
    }
    const struct dg_biss_port_ops *port = biss_port_of(session);
    if (port != NULL) {
        const int code =
            port->write(dg_control_selected(session)->port_ctx, (uint8_t)address, bytes, n, detail);
        dg_scpi_raise(session, code, detail);
    }
}

/* e1 and e2 are never late, and there is CDS between start bit and data. */
static void line_frame(const void *self, struct dg_line_frame *to)
{
    const struct dg_biss *device = self;

    to->lead = 2;
    to->waits = true;
    to->ahead = 1;
    to->bits = dg_biss_frame_bits(device->setup.model);
    to->open = true;
}

static bool clock_of(const void *self)
{
    const struct dg_biss *device = self;

    return device->line.ma;
}

static void seed(void *self, uint32_t value)
{
    struct dg_biss *device = self;

    device->noise = value;
}

/* clang-format off */
static const struct dg_fault_row faults[] = {
    {"led_current_high",    DG_FAULT_SENSES(led_current_ua),                       40000, DG_CAUSE_LED_WORN,  "69h bit 0, nERR low", "5.2.3"},
    {"temperature_high",    DG_FAULT_SENSES(temperature_mdegc),                   125000, DG_CAUSE_HOT,       "69h bit 2 and nERR or nWARN low while 22h or 23h have bit 2; 6Ah, 6Bh read 125 degC", "5.2.3; no. 20"},
    {"temperature_low",     DG_FAULT_SENSES(temperature_mdegc),                   -45000, DG_CAUSE_COLD,      "69h bit 2 and nERR or nWARN low while 22h or 23h have bit 2; 6Ah, 6Bh read -45 degC", "5.2.3; no. 20"},
    {"sin_amplitude_low",   DG_FAULT_SENSES(sin_amplitude_permille),                 500, DG_CAUSE_DIRT,      "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"sin_amplitude_high",  DG_FAULT_SENSES(sin_amplitude_permille),                1500, DG_CAUSE_GAIN,      "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"cos_amplitude_low",   DG_FAULT_SENSES(cos_amplitude_permille),                 500, DG_CAUSE_DIRT,      "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"cos_amplitude_high",  DG_FAULT_SENSES(cos_amplitude_permille),                1500, DG_CAUSE_GAIN,      "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"sin_offset",          DG_FAULT_SENSES(sin_offset_permille),                    500, DG_CAUSE_STRAY,     "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"cos_offset",          DG_FAULT_SENSES(cos_offset_permille),                    500, DG_CAUSE_STRAY,     "69h bit 1, nERR low", "5.2.3; no. 21"},
    {"singleturn_lost",     DG_FAULT_SENSES(singleturn_ok),                            0, DG_CAUSE_SCRATCH,   "69h bit 5, nERR low; 60h bit 0 clear", "5.2.3"},
    {"multiturn_amplitude", DG_FAULT_SENSES(multiturn_amplitude_ok),                   0, DG_CAUSE_MT_WEAK,   "69h bit 6, nERR low; 60h bits 0 and 1 clear", "5.2.3; no. 22"},
    {"multiturn_sync",      DG_FAULT_SENSES(multiturn_sync_ok),                        0, DG_CAUSE_MT_SYNC,   "69h bit 3, nERR low; 60h bit 0 clear", "5.2.3; no. 22"},
    {"multiturn_vector",    DG_FAULT_SENSES(multiturn_vector_ok),                      0, DG_CAUSE_MT_VECTOR, "69h bit 6, nERR low; 60h bits 0 and 1 clear", "5.2.3; no. 22"},
    {"eeprom_silent",       DG_FAULT_SENSES(eeprom_acknowledges),                      0, DG_CAUSE_SILENT,    "69h bit 4, nERR low, user banks refused; if it is silent at a start, until command 04 or the next start", "5.2.3; no. 11, 23"},
    {"watchdog_fired",      DG_FAULT_SENSES(watchdog_fired),                           1, DG_CAUSE_WATCHDOG,  "69h bit 7, nERR low", "5.2.3"},
    {"wire_drop",           DG_FAULT_ON_WIRE(DROP),                                    0, "the line driver is broken now and then", "SLO stays high for the frame: no Ack", "5.2.1.1"},
    {"wire_delay",          DG_FAULT_ON_WIRE(DELAY),                 (int64_t)DG_US(100), "the conversion takes too long", "the start bit comes after 100 us; 40 us are the longest", "5.2.1.1"},
    {"wire_damage",         DG_FAULT_ON_WIRE(DAMAGE),                                  0, "a disturbance on the line", "one bit after the start bit is flipped: CDS, or the CRC is wrong", "5.2.1.2"},
    {"wire_break",          DG_FAULT_ON_WIRE(BREAK),                                   0, "a wire of SLO is broken", "SLO reads high: no Ack in any frame", "5.2.1.1"},
};

static const struct dg_damage_row damage[] = {
    {NULL, "from the next start or command 04 on: 69h bit 4, nERR low; a damaged 'config' has its defaults", "5.2.3"},
};

static const struct dg_scpi_command commands[] = {
    {"BISS:FRAMe",            NULL,                        frame,                   0, "", "clock a frame of a simulated wire: position, nERR, nWARN, life counter, CRC valid"},
    {"BISS:REGister",         write,                       NULL,                    0, "ADDRESS,BYTE[,BYTE]...", "write registers over a simulated wire"},
    {"BISS:REGister",         NULL,                        read,                    0, "ADDRESS[,N]", "read N registers, one without N"},
};
/* clang-format on */

const struct dg_instrument dg_biss_instrument = {
    .stack = &dg_biss_stack,
    .faults = faults,
    .fault_count = DG_COUNT(faults),
    .damage = damage,
    .mode = mode,
    .state = state,
    .commands = {commands, DG_COUNT(commands)},
    .line_frame = line_frame,
    .clock = clock_of,
    .seed = seed,
};
