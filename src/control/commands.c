/* SPDX-License-Identifier: MIT */
#include "drehgeber/control.h"
