/* SPDX-License-Identifier: MIT */
/* The same encoder, made of its EDS file. */
#include "canopen_from_eds.h"

#include <stdlib.h>
#include <string.h>

static struct {
    char text[65536];
    size_t n;
    _Alignas(max_align_t) uint8_t memory[65536];
    struct dg_cia406_file file;
} eds;

/* What does not fit makes a file that cannot be read as what it is. */
static void add_text(void *ctx, const char *text, size_t n)
{
    (void)ctx;
    if (n <= sizeof eds.text - eds.n) {
        memcpy(eds.text + eds.n, text, n);
        eds.n += n;
    }
}

const struct dg_co_device *canopen_from_eds(const struct dg_co_device *device)
{
    struct dg_eds_setup setup = {.size = sizeof setup,
                                 .text = eds.text,
                                 .memory = eds.memory,
                                 .memory_size = sizeof eds.memory};
    struct dg_eds_note error;

    if (getenv("DREHGEBER_FROM_EDS") == NULL || device == &dg_cia406_multiturn_32) {
        return device;
    }
    eds.n = 0;
    dg_co_eds(dg_cia406_sheet(device), add_text, NULL);
    setup.n = eds.n;
    return dg_cia406_read(&eds.file, &setup, &error) == DG_OK ? &eds.file.file.device : NULL;
}
