/* SPDX-License-Identifier: MIT */
/*
 * All words; each are in their protocol's folder.
 */
#include "drehgeber/protocols.h"
#include "drehgeber/words.h"

#define ROW(prefix) &dg_##prefix##_words,
const struct dg_words *const dg_words_list[] = {DG_PROTOCOLS_IN_WORDS(ROW)};
#undef ROW

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
