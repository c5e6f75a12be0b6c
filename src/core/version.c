/* SPDX-License-Identifier: MIT */
#include "drehgeber/drehgeber.h"

const char *dg_version(void)
{
    return DG_VERSION;
}
