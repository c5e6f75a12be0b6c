/* SPDX-License-Identifier: MIT */
/* EEPROM files of encoders from EDS files: those of another file, in words, and what fits of them.
 */
#ifndef DREHGEBER_TOOL_EDS_NVM_H
#define DREHGEBER_TOOL_EDS_NVM_H

#include "drehgeber/rig.h"
#include "error.h"
#include "say.h"

/* Whether the EEPROM files of all encoders of EDS files are theirs, as far as their own reader
   would only say that they are not. @return 0, or -1 with `error`: the objects that differ */
int eds_nvm_check(const struct dg_plan *plan, struct lx_error *error);

/* Make the EEPROM file `path`, a new one, of what fits of that of the one encoder, which has the
   new one from then on. @return 0, or -1 with `error` */
int eds_nvm_convert(struct dg_plan *plan, const char *path, const struct lx_say *say,
                    struct lx_error *error);

#endif
