/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder of an EDS file on a RAM EEPROM, in virtual time; what the reader notes is kept.
 */
#ifndef TESTS_SUPPORT_EDS_RIG_H
#define TESTS_SUPPORT_EDS_RIG_H

#include <stddef.h>
#include <stdint.h>

#include "co_rig.h"

#define EDS_RIG_NOTES 64u
#define EDS_RIG_MEMORY ((size_t)1u << 21u)
#define EDS_RIG_NODE 63u

struct eds_rig {
    struct dg_cia406_file file;
    struct dg_eds_note error;
    struct dg_eds_note notes[EDS_RIG_NOTES]; /**< the first EDS_RIG_NOTES of them */
    size_t note_count;
    _Alignas(max_align_t) uint8_t memory[EDS_RIG_MEMORY];
    struct co_rig co; /**< its encoder, once it has been started */
};

/** Read a file of `n` bytes, in `size` bytes of memory. @return as dg_cia406_read() */
int eds_rig_read(struct eds_rig *self, const char *text, size_t n, size_t size);
/** A text that can be read (cmocka assertion). */
void eds_rig_read_text(struct eds_rig *self, const char *text);
/** The same, and its encoder has power since 1 s, as node EDS_RIG_NODE. */
void eds_rig_start(struct eds_rig *self, const char *text);
/** Off and on again, with the memory as it is. */
void eds_rig_power_cycle(struct eds_rig *self);
/** Whether the reader has said so of a section; "": of none. */
bool eds_rig_is_noted(const struct eds_rig *self, const char *section, const char *what);

#endif
