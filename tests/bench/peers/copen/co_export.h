/* SPDX-License-Identifier: MIT */
/* What c-open's CMake would write for a static library. */
#define CO_EXPORT
