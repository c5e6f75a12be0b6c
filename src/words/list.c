/* SPDX-License-Identifier: MIT */
/*
 * All words; each are in their protocol's folder. The masters of BiSS and SSI tell their frames in
 * notes, which need no words.
 */
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "drehgeber/words.h"

const struct dg_words *const dg_words_list[] = {&dg_hf_words, &dg_cia406_words, &dg_ib_words};

const size_t dg_words_count = DG_COUNT(dg_words_list);

const struct dg_words *dg_words_of(const struct dg_stack *stack)
{
    for (size_t i = 0; i < dg_words_count; i++) {
        if (dg_words_list[i]->stack == stack) {
            return dg_words_list[i];
        }
    }
    return NULL;
}
