/* SPDX-License-Identifier: MIT */
/* EEPROM files of encoders from EDS files, and of models that are texts: those of another file or
 * of other figures, in words, and what fits of them.
 */
#ifndef DREHGEBER_TOOL_NVM_CONVERT_H
#define DREHGEBER_TOOL_NVM_CONVERT_H

#include "drehgeber/rig.h"
#include "error.h"
#include "say.h"

/* Whether the EEPROM files of all encoders of files are theirs, as far as their own reader would
   only say that they are not. @return 0, or -1 with `error`: the objects or figures that differ */
int nvm_check(const struct dg_plan *plan, struct lx_error *error);

/* Make the EEPROM file `path`, a new one, of what fits of that of the one encoder, which has the
   new one from then on. @return 0, or -1 with `error` */
int nvm_convert(struct dg_plan *plan, const char *path, const struct lx_say *say,
                struct lx_error *error);

#endif
