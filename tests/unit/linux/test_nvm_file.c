/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "beside.h"
#include "descriptors.h"
#include "eeprom_rig.h"
#include "stderr_heard.h"

/* --- a file system that lacks something: these come before libc's own --- */

static int no_rename; /* errno of renameat2(); 0: it works */
static int no_link;
static void (*before_naming)(void); /* somebody else is faster */

int renameat2(int from_folder, const char *from, int to_folder, const char *to, unsigned flags)
{
    if (before_naming != NULL) {
        before_naming();
    }
    errno = no_rename;
    return no_rename != 0 ? -1
                          : (int)syscall(SYS_renameat2, from_folder, from, to_folder, to, flags);
}

int link(const char *from, const char *to)
{
    errno = no_link;
    return no_link != 0 ? -1 : (int)syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0);
}

static int fail_sync;  /* the one of the calls from now on that fails with EIO; 0: none */
static int syncs_fail; /* and so many behind it */

int fdatasync(int fd)
{
    const bool fails = fail_sync == 1 || (fail_sync == 0 && syncs_fail > 0);
    syncs_fail -= fail_sync == 0 && syncs_fail > 0 ? 1 : 0;
    fail_sync -= fail_sync > 0 ? 1 : 0;
    errno = EIO;
    return fails ? -1 : (int)syscall(SYS_fdatasync, fd);
}

static int tear_down(void **state)
{
    no_rename = no_link = syncs_fail = fail_sync = 0;
    before_naming = NULL;
    return eeprom_place_tear_down(state);
}

static void write_over(const char *path, const uint8_t *bytes, size_t n)
{
    const int fd = open(path, O_WRONLY);
    assert_int_equal(pwrite(fd, bytes, n, 0), (ssize_t)n);
    (void)close(fd);
}

static ssize_t read_bytes(const char *path, uint8_t *bytes, size_t n)
{
    const int fd = open(path, O_RDONLY);
    const ssize_t got = read(fd, bytes, n);
    (void)close(fd);
    return got;
}

static void a_new_file_is_complete_and_private(void **state)
{
    struct eeprom_place *place = *state;
    struct stat info;
    eeprom_make(place);
    assert_int_equal(stat(place->path, &info), 0);
    assert_int_equal(info.st_mode & 07777, 0600);
    assert_int_equal(info.st_nlink, 1);
    assert_int_equal(info.st_size, dg_store_size(&dg_hf_layout));
}

static void a_file_is_made_with_either_way_to_name_it(void **state)
{
    static const int ways[][2] = {{0, EPERM}, {EINVAL, 0}, {ENOSYS, 0}};
    struct eeprom_place *place = *state;
    struct stat info;
    for (size_t i = 0; i < DG_COUNT(ways); i++) {
        no_rename = ways[i][0];
        no_link = ways[i][1];
        eeprom_make(place);
        assert_int_equal(stat(place->path, &info), 0);
        assert_int_equal(info.st_mode & 07777, 0600);
        assert_int_equal(info.st_nlink, 1);
        assert_int_equal(info.st_size, dg_store_size(&dg_hf_layout));
        assert_int_equal(unlink(place->path), 0);
    }
}

/* rmdir() in tear_down() finds what is left behind. */
static void without_any_way_to_name_it_no_file_is_made(void **state)
{
    static const int ways[][2] = {{EINVAL, EPERM}, {ENOSYS, EOPNOTSUPP}, {EINVAL, ENOSYS}};
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error = {.right = ""};
    for (size_t i = 0; i < DG_COUNT(ways); i++) {
        no_rename = ways[i][0];
        no_link = ways[i][1];
        assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), -1);
        eeprom_close(&eeprom);
        assert_non_null(strstr(lx_error_line(&error).text, place->path));
        assert_non_null(strstr(lx_error_line(&error).text, "neither hard links nor a rename"));
        assert_int_equal(access(place->path, F_OK), -1);
    }
    no_rename = EROFS;
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), -1);
    eeprom_close(&eeprom);
    assert_non_null(strstr(lx_error_line(&error).text, strerror(EROFS)));
}

static struct eeprom_place *contended;

static void somebody_is_faster(void)
{
    eeprom_write_bytes(contended->path, (const uint8_t *)"theirs", 6);
}

static void of_two_that_make_a_file_one_wins(void **state)
{
    struct eeprom_place *place = *state;
    char bytes[8] = "";
    contended = place;
    before_naming = somebody_is_faster;
    for (int linked = 0; linked < 2; linked++) {
        struct eeprom eeprom;
        struct lx_error error = {.right = ""};
        no_rename = linked != 0 ? EINVAL : 0;
        assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), -1);
        eeprom_close(&eeprom);
        assert_non_null(strstr(lx_error_line(&error).text, "something else"));
        const int fd = open(place->path, O_RDONLY);
        assert_int_equal(read(fd, bytes, sizeof bytes), 6);
        (void)close(fd);
        assert_memory_equal(bytes, "theirs", 6);
        assert_int_equal(unlink(place->path), 0);
    }
}

static void what_is_written_is_there_the_next_time(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    uint8_t bytes[4] = {0};
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    const uint32_t at = eeprom.image.file.size - 4;
    assert_int_equal(eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, at, "abcd", 4),
                     DG_OK);
    assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx), DG_OK);
    eeprom_close(&eeprom);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_false(eeprom.image.file.created);
    assert_int_equal(eeprom.part.device.nvm.ops->read(eeprom.part.device.nvm.ctx, at, bytes, 4),
                     DG_OK);
    assert_memory_equal(bytes, "abcd", 4);
    assert_int_equal(eeprom.part.device.nvm.ops->read(eeprom.part.device.nvm.ctx, at, bytes, 5),
                     DG_ERR_IO);
    assert_int_equal(
        eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, at + 5, bytes, 1), DG_ERR_IO);
    eeprom_close(&eeprom);
}

/* Locks belong to processes, so the second one is a process. */
static void a_second_process_is_told_who_has_it(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error = {.right = ""};
    char pid[32];
    (void)snprintf(pid, sizeof pid, "process %ld;", (long)getpid());
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    const pid_t child = fork();
    if (child == 0) {
        struct eeprom second;
        const int result = eeprom_open(&second, place->path, place, &error);
        _exit(result == -1 && strstr(lx_error_line(&error).text, pid) != NULL ? 0 : 1);
    }
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    eeprom_close(&eeprom);
}

static void folders_and_missing_folders_are_refused(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error = {.right = ""};
    assert_int_equal(eeprom_open(&eeprom, place->folder, place, &error), -1);
    eeprom_close(&eeprom);
    assert_non_null(strstr(lx_error_line(&error).text, place->folder));
    assert_non_null(strstr(lx_error_line(&error).text, ": cannot open: Is a directory"));
    assert_int_equal(eeprom_open(&eeprom, "/no/such/folder/nvm", place, &error), -1);
    eeprom_close(&eeprom);
    assert_non_null(strstr(lx_error_line(&error).text, "/no/such/folder/nvm"));
}

/* A file size limit stands in for a full disk. */
static void a_full_disk_is_an_error_that_ends(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    struct rlimit limit;
    struct stderr_heard heard;
    char said[256];
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlim_t usual = limit.rlim_cur;
    (void)signal(SIGXFSZ, SIG_IGN);
    limit.rlim_cur = 1024; /* what is said goes into a file as well, and is shorter */
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    stderr_hear(&heard);
    const int full = eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, 1024, "a", 1);
    limit.rlim_cur = usual;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    stderr_heard(&heard, said, sizeof said);
    assert_int_equal(full, DG_ERR_IO);
    assert_non_null(strstr(said, ": File too large; "));
    assert_true(eeprom.image.file.failing);
    assert_int_equal(eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, 100, "a", 1),
                     DG_OK);
    assert_true(eeprom.image.file.failing); /* not before it is durable */
    assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx), DG_OK);
    assert_false(eeprom.image.file.failing);
    eeprom_close(&eeprom);
}

/* The kernel takes pages for clean whose write has failed, and may forget them: here all of them
   are lost, those of earlier syncs as well. */
static void after_a_failed_sync_all_is_written_again(void **state)
{
    struct eeprom_place *place = *state;
    static uint8_t bytes[2][8192];
    struct eeprom eeprom;
    struct lx_error error;
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    const uint32_t size = eeprom.image.file.size;
    for (int failures = 1; failures <= 3; failures++) {
        assert_int_equal(eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, 100, "a", 1),
                         DG_OK);
        syncs_fail = failures;
        for (int i = 0; i < failures; i++) {
            assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx),
                             DG_ERR_IO);
            assert_true(eeprom.image.file.failing);
        }
        memset(bytes[0], 0, size);
        write_over(place->path, bytes[0], size);
        assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx), DG_OK);
        assert_false(eeprom.image.file.failing);
        assert_int_equal(
            eeprom.part.device.nvm.ops->read(eeprom.part.device.nvm.ctx, 0, bytes[0], size), DG_OK);
        assert_int_equal(bytes[0][100], 'a');
        assert_int_equal(read_bytes(place->path, bytes[1], sizeof bytes[1]), size);
        assert_memory_equal(bytes[0], bytes[1], size);
    }
    /* and no sync after that writes more than there is to write */
    memset(bytes[0], 0, size);
    write_over(place->path, bytes[0], size);
    assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx), DG_OK);
    assert_int_equal(read_bytes(place->path, bytes[1], sizeof bytes[1]), size);
    assert_memory_equal(bytes[0], bytes[1], size);
    eeprom_close(&eeprom);
}

/* The value that the failed sync refused, and the one before it: through the store, as a device
   does it. What a device reads afterwards is what the next start finds. */
static void after_a_failed_sync_the_store_goes_on(void **state)
{
    struct eeprom_place *place = *state;
    static uint8_t bytes[8192];
    uint8_t user[2] = {0};
    for (int failing = 1; failing <= 2; failing++) { /* of the two syncs of a commit */
        struct eeprom eeprom;
        struct lx_error error;
        struct dg_store store;
        assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
        assert_int_equal(dg_store_mount(&store, &dg_hf_layout, eeprom.part.device.nvm), DG_OK);
        fail_sync = failing;
        assert_int_equal(dg_store_put(&store, DG_HF_REGION_USER, 0, "a", 1), DG_ERR_IO);
        memset(bytes, 0, eeprom.image.file.size);
        write_over(place->path, bytes, eeprom.image.file.size);
        assert_int_equal(dg_store_put(&store, DG_HF_REGION_USER, 1, "b", 1), DG_OK);
        eeprom_close(&eeprom);
        assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
        assert_int_equal(dg_store_mount(&store, &dg_hf_layout, eeprom.part.device.nvm), DG_OK);
        assert_int_equal(dg_store_read(&store, DG_HF_REGION_USER, 0, user, 2), DG_OK);
        assert_memory_equal(user, "ab", 2);
        eeprom_close(&eeprom);
    }
}

/* --- while it is in use --- */

static void set_aside(const struct eeprom_place *place, char *aside, size_t size)
{
    (void)snprintf(aside, size, "%s/aside", place->folder);
    assert_int_equal(rename(place->path, aside), 0);
}

/* Nothing is written, and what is read is what was there before. */
static void nothing_is_stored(struct eeprom *eeprom)
{
    const uint32_t at = eeprom->image.file.size - 4;
    uint8_t before[4];
    uint8_t after[4];
    assert_int_equal(eeprom->part.device.nvm.ops->read(eeprom->part.device.nvm.ctx, at, before, 4),
                     DG_OK);
    assert_int_equal(eeprom->part.device.nvm.ops->write(eeprom->part.device.nvm.ctx, at, "gone", 4),
                     DG_ERR_IO);
    assert_int_equal(eeprom->part.device.nvm.ops->sync(eeprom->part.device.nvm.ctx), DG_ERR_IO);
    assert_int_equal(eeprom->part.device.nvm.ops->read(eeprom->part.device.nvm.ctx, at, after, 4),
                     DG_OK);
    assert_memory_equal(before, after, 4);
    assert_true(eeprom->image.file.failing);
}

static void a_deleted_file_takes_nothing(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(unlink(place->path), 0);
    nothing_is_stored(&eeprom);
    eeprom_close(&eeprom);
}

/* As an editor does it, or a version control system; also with the same bytes. */
static void a_replaced_file_takes_nothing(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    char aside[64];
    eeprom_make(place);
    set_aside(place, aside, sizeof aside);
    eeprom_make(place);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(rename(aside, place->path), 0);
    nothing_is_stored(&eeprom);
    eeprom_close(&eeprom);
    eeprom_make(place); /* the other one is free, and an image as before */
}

static void a_moved_file_takes_writes_when_it_is_back(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    char aside[64];
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    set_aside(place, aside, sizeof aside);
    nothing_is_stored(&eeprom);
    assert_int_equal(rename(aside, place->path), 0);
    assert_int_equal(eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, 100, "a", 1),
                     DG_OK);
    assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx), DG_OK);
    assert_false(eeprom.image.file.failing);
    eeprom_close(&eeprom);
}

/* Between a write and its sync it is found by the sync. */
static void a_file_deleted_before_the_sync_is_found_by_it(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, 100, "a", 1),
                     DG_OK);
    assert_int_equal(unlink(place->path), 0);
    assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx), DG_ERR_IO);
    eeprom_close(&eeprom);
}

static void a_link_to_the_file_is_no_other_file(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    char aside[64];
    eeprom_make(place);
    set_aside(place, aside, sizeof aside);
    assert_int_equal(symlink("aside", place->path), 0);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    assert_int_equal(eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, 100, "a", 1),
                     DG_OK);
    assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx), DG_OK);
    eeprom_close(&eeprom);
    assert_int_equal(unlink(aside), 0);
}

static void only_a_file_that_was_made_is_unmade(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    char aside[64];
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    lx_nvm_file_unmake(&eeprom.image.file);
    eeprom_close(&eeprom);
    assert_int_equal(access(place->path, F_OK), -1);

    eeprom_make(place);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    lx_nvm_file_unmake(&eeprom.image.file);
    eeprom_close(&eeprom);
    assert_int_equal(unlink(place->path), 0);

    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    set_aside(place, aside, sizeof aside);
    eeprom_write_bytes(place->path, (const uint8_t *)"x", 1);
    lx_nvm_file_unmake(&eeprom.image.file);
    eeprom_close(&eeprom);
    assert_int_equal(eeprom_length_of(place->path), 1);
    assert_int_equal(unlink(aside), 0);
}

/* What is read does not change, and the next sync brings all of it back. */
static void a_file_cut_off_in_use_is_written_again_whole(void **state)
{
    struct eeprom_place *place = *state;
    static uint8_t bytes[2][8192];
    struct eeprom eeprom;
    struct lx_error error;
    for (off_t length = 0; length <= 100; length += 100) {
        assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
        const uint32_t size = eeprom.image.file.size;
        assert_int_equal(
            eeprom.part.device.nvm.ops->read(eeprom.part.device.nvm.ctx, 0, bytes[0], size), DG_OK);
        assert_int_equal(truncate(place->path, length), 0);
        assert_int_equal(
            eeprom.part.device.nvm.ops->read(eeprom.part.device.nvm.ctx, 0, bytes[1], size), DG_OK);
        assert_memory_equal(bytes[0], bytes[1], size);
        assert_int_equal(
            eeprom.part.device.nvm.ops->write(eeprom.part.device.nvm.ctx, size - 1, "z", 1), DG_OK);
        assert_int_equal(eeprom.part.device.nvm.ops->sync(eeprom.part.device.nvm.ctx), DG_OK);
        eeprom_close(&eeprom);
        bytes[0][size - 1] = 'z';
        const int fd = open(place->path, O_RDONLY);
        assert_int_equal(read(fd, bytes[1], sizeof bytes[1]), size);
        (void)close(fd);
        assert_memory_equal(bytes[0], bytes[1], size);
    }
}

/* A file that was too short when it was opened, and was written anew, is as long as any other one
 * from then on. */
static void a_file_written_anew_is_whole_when_it_is_cut_off(void **state)
{
    struct eeprom_place *place = *state;
    struct eeprom eeprom;
    struct lx_error error;
    eeprom_make(place);
    const off_t size = eeprom_length_of(place->path);
    assert_int_equal(truncate(place->path, size - 2), 0);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    struct lx_nvm_file *file = &eeprom.image.file;
    assert_int_equal(lx_nvm_file_replace(file, eeprom.image.memory.bytes, &error), 0);
    assert_int_equal(eeprom_length_of(place->path), size);
    assert_int_equal(truncate(place->path, size - 1), 0);
    const struct dg_nvm nvm = lx_nvm_file_port(file);
    assert_int_equal(nvm.ops->sync(nvm.ctx), DG_OK);
    assert_int_equal(eeprom_length_of(place->path), size);
    eeprom_close(&eeprom);
}

/* Nothing is left beside it either. */
static void a_file_that_cannot_take_its_place_is_told(void **state)
{
    struct eeprom_place *place = *state;
    char path[128];
    int fd = -1;
    (void)snprintf(path, sizeof path, "%s/taken", place->folder);
    assert_int_equal(lx_file_replace(path, "text", 4, 0, NULL), ENOENT);
    assert_int_equal(mkdir(path, 0700), 0);
    assert_int_equal(lx_file_replace(path, "text", 4, 0600, NULL), EISDIR);
    assert_int_equal(lx_file_replace(path, "text", 4, 0600, &fd), EISDIR);
    assert_int_equal(fd, -1);
    assert_int_equal(rmdir(path), 0);
    assert_int_equal(rmdir(place->folder), 0);
    assert_int_equal(mkdir(place->folder, 0700), 0);
}

#define IN_A_PLACE(test) cmocka_unit_test_setup_teardown(test, eeprom_place_set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_PLACE(a_new_file_is_complete_and_private),
        IN_A_PLACE(a_file_is_made_with_either_way_to_name_it),
        IN_A_PLACE(without_any_way_to_name_it_no_file_is_made),
        IN_A_PLACE(of_two_that_make_a_file_one_wins),
        IN_A_PLACE(what_is_written_is_there_the_next_time),
        IN_A_PLACE(a_second_process_is_told_who_has_it),
        IN_A_PLACE(folders_and_missing_folders_are_refused),
        IN_A_PLACE(a_full_disk_is_an_error_that_ends),
        IN_A_PLACE(after_a_failed_sync_all_is_written_again),
        IN_A_PLACE(after_a_failed_sync_the_store_goes_on),
        IN_A_PLACE(a_deleted_file_takes_nothing),
        IN_A_PLACE(a_replaced_file_takes_nothing),
        IN_A_PLACE(a_moved_file_takes_writes_when_it_is_back),
        IN_A_PLACE(a_file_deleted_before_the_sync_is_found_by_it),
        IN_A_PLACE(a_link_to_the_file_is_no_other_file),
        IN_A_PLACE(only_a_file_that_was_made_is_unmade),
        IN_A_PLACE(a_file_cut_off_in_use_is_written_again_whole),
        IN_A_PLACE(a_file_written_anew_is_whole_when_it_is_cut_off),
        IN_A_PLACE(a_file_that_cannot_take_its_place_is_told),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
