/* SPDX-License-Identifier: MIT */
/*
 * Which files are models; what is made of one is described in its protocol's folder.
 */
#include "drehgeber/devices.h"
#include "drehgeber/hal.h"
#include "drehgeber/model.h"
#include "drehgeber/protocols.h"
#include "drehgeber/text.h"

/* Longest name that is looked at. */
#define NAME_LONGEST 65535u

#define ROW(prefix) &dg_##prefix##_model_file,
static const struct dg_model_file *const files[] = {DG_PROTOCOLS_WITH_MODEL_FILE(ROW)};
#undef ROW

/* Something stands in front of the ending. */
static bool ends_so(const char *name, const char *ending)
{
    const size_t n = dg_text_length(name, NAME_LONGEST);
    const size_t length = dg_text_length(ending, NAME_LONGEST);

    return n > length && dg_text_same(name + n - length, ending, SIZE_MAX, dg_text_upper);
}

const struct dg_model_file *dg_model_file_of(const char *name)
{
    for (size_t i = 0; i < DG_COUNT(files); i++) {
        for (const char *const *ending = files[i]->endings; *ending != NULL; ending++) {
            if (ends_so(name, *ending)) {
                return files[i];
            }
        }
    }
    return NULL;
}
