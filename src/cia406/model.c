/* SPDX-License-Identifier: MIT */
/*
 * Models that are files: EDS and DCF files.
 */
#include <string.h>

#include "drehgeber/cia406.h"
#include "drehgeber/model.h"
#include "drehgeber/text.h"

#define ALIGN _Alignof(max_align_t)
/* Of the memory, in front of what the reader makes. */
#define OWN ((sizeof(struct dg_cia406_file) + ALIGN - 1u) / ALIGN * ALIGN)

static const char *const endings[] = {".eds", ".dcf", NULL};

static void count_lack(void *ctx, const struct dg_eds_note *note)
{
    struct dg_model_made *to = ctx;

    to->lacks += note->lacks ? 1u : 0u;
}

static int refuse_text(const struct dg_eds_note *wrong, struct dg_model_flaw *flaw)
{
    struct dg_text what = dg_text_in(flaw->what, sizeof flaw->what);
    struct dg_text right = dg_text_in(flaw->right, sizeof flaw->right);

    flaw->line = wrong->line;
    dg_co_say_place(wrong, &what);
    dg_text_add(&what, what.length > 0 ? ": " : "");
    dg_text_add(&what, wrong->what);
    dg_text_add(&right, wrong->right != NULL ? wrong->right : "");
    return DG_ERR_ARGUMENT;
}

static int read_file(const struct dg_model_source *from, struct dg_model_made *to,
                     struct dg_model_flaw *flaw)
{
    struct dg_cia406_file *self = from->memory;
    struct dg_eds_note wrong = {.what = ""};

    *to = (struct dg_model_made){.device = NULL};
    if (from->memory_size <= OWN) {
        return DG_ERR_SPACE;
    }
    const struct dg_eds_setup setup = {
        .size = sizeof setup,
        .text = from->text,
        .n = from->n,
        .memory = (uint8_t *)from->memory + OWN,
        .memory_size = from->memory_size - OWN,
        .note = count_lack,
        .ctx = to,
    };
    const int result = dg_cia406_read(self, &setup, &wrong);
    if (result != DG_OK) {
        return result == DG_ERR_SPACE ? result : refuse_text(&wrong, flaw);
    }
    to->device = &self->device;
    to->used = OWN + self->file.used;
    to->address = self->file.node_id;
    return DG_OK;
}

const struct dg_model_file dg_cia406_model_file = {.endings = endings, .read = read_file};
