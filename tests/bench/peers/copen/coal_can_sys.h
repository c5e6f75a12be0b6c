/* SPDX-License-Identifier: MIT */
/* c-open's CAN channel is in copen.c. */
