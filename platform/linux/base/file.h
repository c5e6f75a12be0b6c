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

/** The folder that the files of a client of the control plane lie in: none that it names may be
 * anywhere else. */
struct lx_folder {
    int fd;     /**< -1: clients name no files */
    char *path; /**< as given, and without links; both owned */
    char *real;
};

/** No folder. */
#define LX_FOLDER_NONE ((struct lx_folder){.fd = -1})

/** Open a folder for the files of clients. @return 0, or -1 with one line in `error` */
int lx_folder_open(struct lx_folder *self, const char *path, struct lx_error *error);

/** Give it back; LX_FOLDER_NONE afterwards. */
void lx_folder_close(struct lx_folder *self);

/** What stands in each file of a kind that this program writes, and in no other one. */
struct lx_file_mark {
    size_t at; /**< bytes from the beginning */
    size_t n;  /**< 1..LX_FILE_MARK_MAX */
    const char *bytes;
};
#define LX_FILE_MARK_MAX 32u

/** A file that is to be written. */
struct lx_file_wanted {
    /** NULL: the user has named it, and whatever it was is replaced. A client's is in the folder,
     * a regular file that is new, empty or one of this program and this kind; no link leads to it.
     */
    const struct lx_folder *folder;
    const char *path;
    const struct lx_file_mark *mark; /**< NULL: none, so that a client replaces no such file */
};

/** A file whose first bytes wait. */
struct lx_file;

/**
 * A stream to the file, which is made, or emptied; others are kept off. Neither this nor a write
 * ever waits, as on a pipe that nobody reads.
 * @param held NULL: emptied at once. Else nothing that is on the disk changes before
 *        lx_file_release(*held); a stream that is closed before that leaves all as it was
 * @return NULL with one line in `error`
 */
FILE *lx_file_create(const struct lx_file_wanted *wanted, struct lx_file **held,
                     struct lx_error *error);

/** Empty the file and write what has waited; later bytes go there at once. Flush the stream first.
 * @return 0 or an errno: to be closed then, a file that was made for it is removed again */
int lx_file_release(struct lx_file *self);

/** Open a regular file for reading: of anything else nobody knows when it ends. `folder` as above.
 * @return NULL with one line in `error` */
FILE *lx_file_read(const struct lx_folder *folder, const char *path, struct lx_error *error);

#endif
