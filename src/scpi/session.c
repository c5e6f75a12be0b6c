/* SPDX-License-Identifier: MIT */
#include "drehgeber/scpi.h"
