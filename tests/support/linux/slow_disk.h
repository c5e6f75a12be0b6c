/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A disk that takes as long as a test wants: fdatasync() of the program that is linked with this.
 */
#ifndef SUPPORT_SLOW_DISK_H
#define SUPPORT_SLOW_DISK_H

/** From now on nothing gets onto the disk. Not twice. */
void slow_disk_take(void);

/** It does again; nothing, when it was not taken. */
void slow_disk_give(void);

#endif
