/* SPDX-License-Identifier: MIT */
/* Where the control plane of a rig is when nobody says where: README.md of the port. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "server.h"

static char place[] = "/tmp/test_default_address.XXXXXX";

static int make_place(void **state)
{
    (void)state;
    return mkdtemp(place) == NULL || chdir(place) != 0 ? -1 : 0;
}

static int remove_place(void **state)
{
    (void)state;
    return chdir("/") != 0 || rmdir(place) != 0 ? -1 : 0;
}

static void set(const char *name, const char *value)
{
    assert_int_equal(value == NULL ? unsetenv(name) : setenv(name, value, 1), 0);
}

static void set_all(const char *service, const char *run, const char *tmp)
{
    set("RUNTIME_DIRECTORY", service);
    set("XDG_RUNTIME_DIR", run);
    set("TMPDIR", tmp);
}

/* The first of them that is there; %s is the number of the user. */
static void the_folder_follows_from_the_environment(void **state)
{
    static const struct {
        const char *service;
        const char *run;
        const char *tmp;
        const char *folder;
    } rows[] = {
        {"/run/rig", "/run/user/5", "/var/tmp", "/run/rig"},
        {"/run/rig:/run/other", NULL, NULL, "/run/rig"},
        {"rig", "/run/user/5", "/var/tmp", "/run/user/5/drehgeber"},
        {"", "/run/user/5", NULL, "/run/user/5/drehgeber"},
        {NULL, "/run/user/5", "/var/tmp", "/run/user/5/drehgeber"},
        {NULL, "run", "/var/tmp", "/var/tmp/drehgeber-%s"},
        {NULL, "", "tmp", "/tmp/drehgeber-%s"},
        {NULL, NULL, "", "/tmp/drehgeber-%s"},
        {NULL, NULL, NULL, "/tmp/drehgeber-%s"},
    };
    char user[24];
    (void)state;
    (void)snprintf(user, sizeof user, "%lu", (unsigned long)getuid());
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const char *mark = strstr(rows[i].folder, "%s");
        const size_t n = mark == NULL ? strlen(rows[i].folder) : (size_t)(mark - rows[i].folder);
        char wanted[64];
        char folder[64];
        (void)snprintf(wanted, sizeof wanted, "%.*s%s", (int)n, rows[i].folder,
                       mark == NULL ? "" : user);
        set_all(rows[i].service, rows[i].run, rows[i].tmp);
        assert_int_equal(lx_server_folder(folder, sizeof folder), 0);
        assert_string_equal(folder, wanted);
    }
}

/* To the last character, and its zero. */
static void a_folder_has_to_fit(void **state)
{
    static const char *const services[] = {"/run/rig", NULL, NULL};
    static const char *const runs[] = {NULL, "/run", NULL};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(services); i++) {
        char folder[64];
        set_all(services[i], runs[i], NULL);
        assert_int_equal(lx_server_folder(folder, sizeof folder), 0);
        const size_t n = strlen(folder);
        assert_int_equal(lx_server_folder(folder, n + 1u), 0);
        assert_int_equal(lx_server_folder(folder, n), -1);
    }
}

static void refuses(const char *run, const char *name, const char *line)
{
    char where[256];
    struct lx_error error = {.right = ""};
    set_all(NULL, run, NULL);
    assert_int_equal(lx_server_default(name, where, sizeof where, &error), -1);
    assert_string_equal(lx_error_line(&error).text, line);
}

static void the_folder_is_made_for_its_user_only(void **state)
{
    char where[256];
    char wanted[256];
    struct stat info;
    struct lx_error error;
    (void)state;
    set_all(NULL, place, NULL);
    for (unsigned i = 0; i < 2; i++) { /* the second time it is there */
        assert_int_equal(lx_server_default("rig", where, sizeof where, &error), 0);
        (void)snprintf(wanted, sizeof wanted, "unix:%s/drehgeber/rig.sock", place);
        assert_string_equal(where, wanted);
        assert_int_equal(stat("drehgeber", &info), 0);
        assert_int_equal(info.st_mode & 07777, 0700);
    }
    const size_t n = strlen(wanted);
    assert_int_equal(lx_server_default("rig", where, n + 1u, &error), 0);
    assert_int_equal(lx_server_default("rig", where, n, &error), -1);
    assert_string_equal(error.what, "rig: name too long");
    assert_int_equal(rmdir("drehgeber"), 0);
}

/* Somebody else could put a socket of his own there. */
static void a_folder_that_others_can_write_to_is_refused(void **state)
{
    static const mode_t modes[] = {0720, 0702, 0777};
    char line[256];
    (void)state;
    (void)snprintf(line, sizeof line,
                   "%s/drehgeber: not a folder that only you can write to; expected control = "
                   "unix:PATH",
                   place);
    assert_int_equal(mkdir("drehgeber", 0700), 0);
    for (size_t i = 0; i < DG_COUNT(modes); i++) {
        assert_int_equal(chmod("drehgeber", modes[i]), 0);
        refuses(place, "rig", line);
    }
    assert_int_equal(rename("drehgeber", "own"), 0);
    assert_int_equal(chmod("own", 0700), 0);
    assert_int_equal(symlink("own", "drehgeber"), 0);
    refuses(place, "rig", line);
    assert_int_equal(unlink("drehgeber"), 0);
    assert_int_equal(rmdir("own"), 0);
}

static void a_folder_that_cannot_be_made_is_told(void **state)
{
    char longest[LX_SERVER_ADDRESS_MAX + 8u] = "/";
    (void)state;
    refuses("/dev/null", "rig",
            "/dev/null/drehgeber: cannot make the folder: Not a directory; expected control = "
            "unix:PATH");
    memset(longest + 1, 'x', sizeof longest - 2u);
    refuses(longest, "rig",
            "RUNTIME_DIRECTORY or XDG_RUNTIME_DIR is too long; expected control = unix:PATH");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_folder_follows_from_the_environment),
        cmocka_unit_test(a_folder_has_to_fit),
        cmocka_unit_test(the_folder_is_made_for_its_user_only),
        cmocka_unit_test(a_folder_that_others_can_write_to_is_refused),
        cmocka_unit_test(a_folder_that_cannot_be_made_is_told),
    };
    return cmocka_run_group_tests(tests, make_place, remove_place);
}
