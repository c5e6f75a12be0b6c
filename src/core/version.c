/* SPDX-License-Identifier: MIT */
#include "drehgeber/drehgeber.h"

const char *dg_version(void)
{
    return DG_VERSION; /* the build passes the project's version */
}
