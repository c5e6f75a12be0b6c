/* SPDX-License-Identifier: MIT */
/* For a header of the Linux port that names files: there are none here. */
#ifndef DREHGEBER_WEB_TYPES_H
#define DREHGEBER_WEB_TYPES_H

/** POSIX: a size or -1. */
typedef long ssize_t;
/** POSIX: a place in a file. */
typedef long off_t;
/** POSIX: a process. */
typedef int pid_t;

#endif
