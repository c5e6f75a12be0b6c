/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder of an EDS file on a handle, and an SDO client. Anything that may not fail is asserted.
 */
#ifndef TESTS_SUPPORT_EDS_CLIENT_H
#define TESTS_SUPPORT_EDS_CLIENT_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/cia406.h"
#include "drehgeber/host.h"

#define EDS_CLIENT_NODE 7u
#define EDS_CLIENT_NOTES 64u
#define EDS_CLIENT_SAVE 0x65766173u

/** One file, and one encoder of it. */
struct eds_client {
    struct dg_cia406_file file;
    struct dg_eds_note error;
    struct dg_eds_note kept[EDS_CLIENT_NOTES]; /* the first of them */
    unsigned notes;
    unsigned lacks;
    _Alignas(max_align_t) uint8_t memory[524288];
    _Alignas(DG_HOST_ALIGN) uint8_t handle[65536];
    struct dg_host *host;
    uint64_t now;
};

/** Read a file. @return as dg_cia406_read(); notes are counted */
int eds_client_read(struct eds_client *self, const char *text, size_t n);
/** Whether a note of a section says `what`, among other words. */
bool eds_client_noted(const struct eds_client *self, const char *section, const char *what);
/** A handle of it, without power, with node-ID EDS_CLIENT_NODE. */
void eds_client_make(struct eds_client *self);
/** Power, and a second behind it. */
void eds_client_switch_on(struct eds_client *self);
/** An SDO request and its answer, which may take 50 ms. */
struct dg_host_event eds_client_ask(struct eds_client *self, uint8_t command, uint16_t index,
                                    uint8_t sub, uint32_t value);
/** The value of an object of up to 4 bytes. */
uint32_t eds_client_upload(struct eds_client *self, uint16_t index, uint8_t sub);
/** Write `n` bytes (1..4). @return the abort code; 0: none */
uint32_t eds_client_download(struct eds_client *self, uint16_t index, uint8_t sub, uint32_t value,
                             uint8_t n);

#endif
