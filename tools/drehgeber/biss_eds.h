/* SPDX-License-Identifier: MIT */
/* The electronic data sheet in words. */
#ifndef DREHGEBER_TOOL_BISS_EDS_H
#define DREHGEBER_TOOL_BISS_EDS_H

#include <stdint.h>
#include <stdio.h>

/* Print the banks as tables with names, values, units. @return 0, or -1: a check sum is wrong */
int biss_eds_print(const uint8_t common[64], const uint8_t profile[64], FILE *to);

#endif
