/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A test rig for the S36 with RS485: one device with its world, its EEPROM and a line in virtual
 * time. Everything lives in the struct; a rig may be saved and put back by assignment, to the same
 * place only (the device points to its world and its EEPROM).
 */
#ifndef TESTS_SUPPORT_HF_RIG_H
#define TESTS_SUPPORT_HF_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/hiperface.h"
#include "ram_nvm.h"

/** No reply. Other results of hf_rig_ask() are status codes (5.1.3), 0 for success. */
#define HF_RIG_SILENCE (-1)
/** Writes whose sizes are recorded. */
#define HF_RIG_WRITES_MAX 64u

struct hf_rig {
    struct dg_world world;
    dg_angle angle;       /**< of the shaft, at time 0 */
    int64_t angle_per_ms; /**< speed, at most 2^43 */
    struct ram_nvm nvm;   /**< the EEPROM */
    uint32_t accesses;    /**< to the EEPROM: reads, writes and syncs */
    uint32_t fail_from;   /**< the first access that fails ... */
    uint32_t fail_count;  /**< ... and how many do from there */
    uint32_t write_count; /**< sizes recorded; set to 0 to begin anew */
    uint16_t write_size[HF_RIG_WRITES_MAX];

    struct dg_hf device;
    dg_ns now;

    unsigned replies; /**< counted up */
    dg_ns reply_at;   /**< `now` of the last one */
    size_t reply_length;
    uint8_t reply[DG_HF_FRAME_MAX]; /**< of a longer one, its beginning */
};

/** A healthy world, shaft at angle 0, a formatted EEPROM, the device off. @return dg_hf_init()'s */
int hf_rig_init(struct hf_rig *self, const struct dg_hf_model *model);

/** What the rig hands over to its device. */
struct dg_hf_setup hf_rig_setup(struct hf_rig *self, const struct dg_hf_model *model);

/** The device's deadlines until it only waits for characters; the start-up window may be open. */
void hf_rig_run(struct hf_rig *self);

/** Power on, and wait for the end of the start-up window. @return dg_hf_power_on()'s */
int hf_rig_power_on(struct hf_rig *self);

/** Send characters at the device's data rate, then hf_rig_run(). @return length of the reply */
size_t hf_rig_send(struct hf_rig *self, const uint8_t *bytes, size_t n);

/**
 * Send a request.
 * @param command hexadecimal, blanks ignored: command code and data; the device's address and the
 *                check sum are added
 * @return HF_RIG_SILENCE or the status code. A reply to 50h always counts as success.
 */
int hf_rig_ask(struct hf_rig *self, const char *command);

/** The same for a command in binary. */
int hf_rig_ask_bytes(struct hf_rig *self, const uint8_t *command, size_t n);

/** Bytes of a hexadecimal text, blanks ignored. @return their number, at most `capacity` */
size_t hf_rig_hex(const char *text, uint8_t *bytes, size_t capacity);

/** XOR over `bytes`, worked out here and not by the library. */
uint8_t hf_rig_xor(const uint8_t *bytes, size_t n);

#endif
