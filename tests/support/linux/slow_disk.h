/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A disk that takes as long as a test wants: fdatasync() of the program that is linked with this.
 */
#ifndef SUPPORT_SLOW_DISK_H
#define SUPPORT_SLOW_DISK_H

#define SLOW_DISK_FOLDER 32
#define SLOW_DISK_KEY (SLOW_DISK_FOLDER + 16)

/** From now on nothing gets onto the disk. Not twice. */
void slow_disk_take(void);

/** It does again; nothing, when it was not taken. */
void slow_disk_give(void);

/** Make a folder with room for one EEPROM file; its path goes to `folder`, the line of a rig file
 * that names it to `key`. */
void slow_disk_make_folder(char folder[SLOW_DISK_FOLDER], char key[SLOW_DISK_KEY]);

/** Remove it with its file; nothing, when `folder` is empty. */
void slow_disk_remove_folder(const char *folder);

#endif
