/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A memory one of whose operations fails: the one with this number, and no other. Enters through
 * struct dg_nvm only.
 */
#ifndef TESTS_SUPPORT_FAILING_NVM_H
#define TESTS_SUPPORT_FAILING_NVM_H

#include <stdint.h>

#include "drehgeber/hal.h"

struct failing_nvm {
    struct dg_nvm behind;
    uint32_t fails_at; /**< the first is 0 */
    uint32_t count;    /**< operations so far */
};

/** The operations on `self`, which goes on to `behind`. */
struct dg_nvm failing_nvm_port(struct failing_nvm *self, struct dg_nvm behind, uint32_t fails_at);

#endif
