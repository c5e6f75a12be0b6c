/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A file with a name that is in memory only, for what reads files: nothing is written on a disk.
 */
#ifndef SUPPORT_MEMORY_FILE_H
#define SUPPORT_MEMORY_FILE_H

#include <stddef.h>
#include <stdint.h>

/** Put `bytes` into the one such file of the process. Aborts when that fails.
 * @return its name, always the same */
const char *memory_file_write(const uint8_t *bytes, size_t n);

#endif
