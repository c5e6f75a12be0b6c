/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Files that a user names: none of them may hold up the wires, and none is used twice at a time.
 */
#ifndef DREHGEBER_LINUX_FILE_H
#define DREHGEBER_LINUX_FILE_H

#include <stdio.h>
#include <sys/types.h>

#include "say.h"

/**
 * Keep everybody else off an open file who asks, in this process and in others, until it is closed.
 * @return 0, or an errno: EAGAIN when somebody else has it
 */
int lx_file_hold(int fd);

/** The process that keeps this open file from being held; 0: none, or it is not known. */
pid_t lx_file_holder(int fd);

/**
 * Make a file for a trace or a recording, or empty the one that is there. Neither this nor a write
 * ever waits, as on a pipe that nobody reads.
 * @return NULL with one line in `error`
 */
FILE *lx_file_create(const char *path, struct lx_error *error);

/** Open a regular file for reading: of anything else nobody knows when it ends. @return NULL with
 * one line in `error` */
FILE *lx_file_read(const char *path, struct lx_error *error);

#endif
