/* SPDX-License-Identifier: MIT */
/* Control addresses, tokens, and the guard in front of a session. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "access.h"
#include "descriptors.h"
#include "endpoint.h"
#include "unix_listen.h"

#define TOKEN "0123456789abcdef"

/* --- addresses --- */

static const struct {
    const char *text;
    const char *where; /* NULL: refused */
    bool open;
    const char *file;
} addresses[] = {
    /* clang-format off */
    {"unix:s",                            "unix:s",            false, ""},
    {"unix:/a/b c",                       "unix:/a/b c",       false, ""},
    {"unix:a,b",                          "unix:a,b",          false, ""},
    {"unix:a,opened",                     "unix:a,opened",     false, ""},
    {"unix:a,token",                      "unix:a,token",      false, ""},
    {"unix:s,token=t",                    "unix:s",            false, "t"},
    {"unix:s,token=a,b",                  "unix:s",            false, "a,b"},
    {"tcp:127.0.0.1:5025",                "tcp:127.0.0.1:5025", false, ""},
    {"tcp:127.0.0.1:0,open",              "tcp:127.0.0.1:0",   true,  ""},
    {"tcp:[::]:5025,open",                "tcp:[::]:5025",     true,  ""},
    {"tcp:h:1,token=/a/t",                "tcp:h:1",           false, "/a/t"},
    {"tcp:h:1,open,token=t",              "tcp:h:1",           true,  "t"},
    {"tcp:h:1,token=t,open",              "tcp:h:1",           false, "t,open"},
    {"",                                  NULL, false, NULL},
    {"unix:",                             NULL, false, NULL},
    {",open",                             NULL, false, NULL},
    {",token=t",                          NULL, false, NULL},
    {"unix:s,open",                       NULL, false, NULL},
    {"unix:s,open,token=t",               NULL, false, NULL},
    {"unix:s,token=",                     NULL, false, NULL},
    {"tcp:h:1,token=",                    NULL, false, NULL},
    {"tcp:h:1,open,token=",               NULL, false, NULL},
    {"tcp:h:1,open,",                     NULL, false, NULL},
    {"tcp:h:1,open,open",                 NULL, false, NULL},
    {"tcp:h:1,opened",                    NULL, false, NULL},
    {"tcp:h:1,OPEN",                      NULL, false, NULL},
    {"tcp:h:1,shut",                      NULL, false, NULL},
    {"tcp:h:1,",                          NULL, false, NULL},
    {"tcp:h,open",                        NULL, false, NULL},
    {"tcp:h:65536",                       NULL, false, NULL},
    {"TCP:h:1",                           NULL, false, NULL},
    {"h:1",                               NULL, false, NULL},
    /* clang-format on */
};

static void test_addresses(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(addresses); i++) {
        struct lx_access access;
        struct lx_error error = {.right = ""};
        const int result = lx_access_parse(addresses[i].text, &access, &error);
        if (addresses[i].where == NULL) {
            assert_int_equal(result, -1);
            assert_string_not_equal(lx_error_line(&error).text, "");
            continue;
        }
        assert_int_equal(result, 0);
        assert_string_equal(access.where, addresses[i].where);
        assert_int_equal(access.tcp, addresses[i].text[0] == 't');
        assert_int_equal(access.open, addresses[i].open);
        assert_string_equal(access.token_file, addresses[i].file);
    }
}

/* Of an address and of a token's file: what fits, and one character more. */
static void test_long_addresses(void **state)
{
    static char text[LX_ACCESS_WHERE_MAX + PATH_MAX + 64u];
    struct lx_access access;
    struct lx_error error;
    (void)state;
    for (unsigned more = 0; more < 2; more++) {
        (void)snprintf(text, sizeof text, "tcp:%0*d:1", 250 + 6 * (int)more, 1);
        assert_int_equal(lx_access_parse(text, &access, &error), more == 0 ? 0 : -1);
        (void)snprintf(text, sizeof text, "tcp:h:1,token=%0*d", PATH_MAX - 1 + (int)more, 1);
        assert_int_equal(lx_access_parse(text, &access, &error), more == 0 ? 0 : -1);
    }
}

/* --- token files --- */

static const struct {
    const char *text;
    size_t n; /* 0: up to its zero */
    mode_t mode;
    const char *token; /* NULL: refused */
} files[] = {
    {TOKEN "\n", 0, 0600, TOKEN},
    {TOKEN, 0, 0600, TOKEN},
    {TOKEN "\n", 0, 0400, TOKEN},
    {TOKEN "\n", 0, 0640, NULL},
    {TOKEN "\n", 0, 0604, NULL},
    {TOKEN "\n", 0, 0620, NULL},
    {TOKEN "\n", 0, 0601, NULL},
    {"0123456789abcde\n", 0, 0600, NULL}, /* too short */
    {"", 0, 0600, NULL},
    {"\n", 0, 0600, NULL},
    {TOKEN "\n\n", 0, 0600, NULL},
    {TOKEN "\n" TOKEN "\n", 0, 0600, NULL},
    {TOKEN "\r\n", 0, 0600, NULL},
    {TOKEN " \n", 0, 0600, NULL},
    {TOKEN "\"\n", 0, 0600, NULL},
    {TOKEN "'\n", 0, 0600, NULL},
    {TOKEN "\xC3\xA4\n", 0, 0600, NULL},
    {TOKEN "\0\n", sizeof TOKEN + 1u, 0600, NULL},
    {TOKEN "\0" TOKEN, 2u * sizeof TOKEN - 1u, 0600, NULL},
};

static void write_file(const char *path, const char *text, size_t n, mode_t mode)
{
    (void)unlink(path);
    const int fd = open(path, O_WRONLY | O_CREAT | O_EXCL, 0600);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, n), n);
    assert_int_equal(fchmod(fd, mode), 0);
    assert_int_equal(close(fd), 0);
}

static void test_token_files(void **state)
{
    char folder[] = "/tmp/drehgeber-access-XXXXXX";
    char path[sizeof folder + 8u];
    char token[LX_ACCESS_TOKEN_MAX + 1u];
    char text[LX_ACCESS_TOKEN_MAX + 2u];
    struct lx_error error;
    (void)state;
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof path, "%s/token", folder);
    for (size_t i = 0; i < DG_COUNT(files); i++) {
        write_file(path, files[i].text, files[i].n > 0 ? files[i].n : strlen(files[i].text),
                   files[i].mode);
        const int result = lx_access_token(path, token, &error);
        assert_int_equal(result, files[i].token == NULL ? -1 : 0);
        if (files[i].token != NULL) {
            assert_string_equal(token, files[i].token);
        }
    }
    memset(text, 'x', sizeof text);
    for (size_t more = 0; more < 2; more++) {
        write_file(path, text, LX_ACCESS_TOKEN_MAX + more, 0600);
        assert_int_equal(lx_access_token(path, token, &error), more == 0 ? 0 : -1);
    }
    assert_int_equal(unlink(path), 0);
    assert_int_equal(lx_access_token(path, token, &error), -1); /* not there */
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(lx_access_token(path, token, &error), -1);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(lx_access_token(folder, token, &error), -1);
    assert_int_equal(rmdir(folder), 0);
}

/* --- the guard --- */

#define NO_END_IN_SIGHT "POST /aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"

enum where { UNIX, TCP, UNIX_TOKEN, TCP_TOKEN };

/* Pieces as they come in, and a letter for the verdict on each: Pass, Skip, Tell, Close. */
static const struct {
    enum where where;
    const char *pieces[5];
    const char *verdicts;
} sessions[] = {
    /* clang-format off */
    {UNIX, {"POST / HTTP/1.1\r", "\n", "\x16\x03\n", "\"x\"\n", "*IDN?\n"}, "PPPPP"},
    {UNIX, {"SYST:TOK \"" TOKEN "\"\n"}, "P"},

    /* SCPI */
    {TCP, {"*IDN?\n", "nothing of the kind\n", "\"x\"\n", "12\n", ":SHAF:POS 5\n"}, "PPPPP"},
    {TCP, {":SHAF:POS 5;VEL?\r", "\n", "12\n"}, "PPP"},
    {TCP, {"  \tSHAFt:POSition?\n", "12\n"}, "PP"},
    {TCP, {"A\n", "12\n"}, "PP"},
    {TCP, {"A_1:B2?\n", "12\n"}, "PP"},
    {TCP, {"A;B\n", "12\n"}, "PP"},
    {TCP, {"\n", "\r", " \n", "*CLS\n", "12\n"}, "PPPPP"},
    {TCP, {"GETTING:ON\n", "POSTED\n", "TRACE:STAR \"x.vcd\"\n", "TRAC:STOP\n"}, "PPPP"},
    {TCP, {"*CLS\n", "a line that has no end ", " in sight POST / HTTP/1.1", " and ends\n", "12\n"}, "PPPPP"},
    {TCP, {"SYST:TOK \"" TOKEN "\"\n", "12\n", "*CLS\n"}, "SPC"},
    {TCP, {"SYST:TOK \"any\"\n", "*CLS\n", "12\n"}, "SPP"},

    /* no SCPI: the first line is the session's, what follows is nobody's */
    {TCP, {"Host: x\r", "\n", "*CLS\n"}, "PPC"},
    {TCP, {"host:1\n", "*CLS\n"}, "PC"},
    {TCP, {"Content-Type: text/plain\n", "*CLS\n"}, "PC"},
    {TCP, {"12\n", "*CLS\n"}, "PC"},
    {TCP, {"\"*CLS\"\n", "*CLS\n"}, "PC"},
    {TCP, {"*\n", "*CLS\n"}, "PC"},
    {TCP, {":\n", "*CLS\n"}, "PC"},
    {TCP, {"A:\n", "*CLS\n"}, "PC"},
    {TCP, {"A::B\n", "*CLS\n"}, "PC"},
    {TCP, {"A??\n", "*CLS\n"}, "PC"},
    {TCP, {"A,\n", "*CLS\n"}, "PC"},
    {TCP, {"SSH-2.0-x\n", "*CLS\n"}, "PC"},
    {TCP, {"\x01*CLS\n", "*CLS\n"}, "PC"},
    {TCP, {"\xFF\n", "*CLS\n"}, "PC"},
    {TCP, {"\n", "\n", "12\n", "\n", "*CLS\n"}, "PPPPC"},

    /* HTTP and TLS */
    {TCP, {"GET / HTTP/1.1\r"}, "C"},
    {TCP, {"get /\n"}, "C"},
    {TCP, {"HEAD /\n"}, "C"},
    {TCP, {"POST /\n"}, "C"},
    {TCP, {"PUT /\n"}, "C"},
    {TCP, {"DELETE /\n"}, "C"},
    {TCP, {"CONNECT h:1\n"}, "C"},
    {TCP, {"OPTIONS *\n"}, "C"},
    {TCP, {"TRACE /\n"}, "C"},
    {TCP, {"PATCH /\n"}, "C"},
    {TCP, {"PRI * HTTP/2.0\r"}, "C"},
    {TCP, {"PROPFIND / HTTP/1.1\r"}, "C"},
    {TCP, {"A http/1.1\n", "A HTTP/1.1\n"}, "PC"},
    {TCP, {"  \tPOST /\n"}, "C"},
    {TCP, {"\r", "\n", "POST /\n"}, "PPC"},
    {TCP, {"*CLS\n", "POST / HTTP/1.1\n"}, "PC"},
    {TCP, {"\x16\x03\x01\n"}, "C"},
    {TCP, {"*CLS\n", "\x16\n"}, "PC"},
    {TCP, {NO_END_IN_SIGHT}, "C"},
    {TCP, {"A and no end"}, "C"},
    {TCP, {"     "}, "C"},
    {TCP, {"\n", "    "}, "PC"},

    /* with a token */
    {TCP_TOKEN, {"SYST:TOK \"" TOKEN "\"\r", "\n", "*CLS\n", "12\n"}, "SPPP"},
    {TCP_TOKEN, {"SYST:TOK \"" TOKEN "\"\n", "12\n", "*CLS\n"}, "SPC"},
    {TCP_TOKEN, {"SYST:TOK \"" TOKEN "\"\n", "SYST:TOK \"wrong\"\n", "*CLS\n"}, "SSP"},
    {TCP_TOKEN, {"SYST:TOK \"" TOKEN "\"\n", "*CLS\n", "POST /\n"}, "SPC"},
    {TCP_TOKEN, {"\n", " \n", "*CLS\n"}, "PPT"},
    {TCP_TOKEN, {"POST /\n"}, "C"},
    {TCP_TOKEN, {"     "}, "C"},
    {UNIX_TOKEN, {"     "}, "C"},
    {UNIX_TOKEN, {"POST /\n"}, "C"},
    {UNIX_TOKEN, {":syst:tok '" TOKEN "'\n", "*CLS\n"}, "SP"},
    {UNIX_TOKEN, {"SYSTem:TOKen  \t\"" TOKEN "\"\n", "*CLS\n"}, "SP"},
    {UNIX_TOKEN, {"SYST:TOKEN \"" TOKEN "\"\n", "*CLS\n"}, "SP"},
    {UNIX_TOKEN, {"SYSTEM:TOK \"" TOKEN "\"\n", "*CLS\n"}, "SP"},
    {UNIX_TOKEN, {"*CLS\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"0123456789abcdeX\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"X123456789abcdef\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"0123456789abcde\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"" TOKEN "0\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"" TOKEN TOKEN "\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"0123456789ABCDEF\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK " TOKEN "\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"" TOKEN "'\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK? \"" TOKEN "\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"" TOKEN "\";*CLS\n"}, "T"},
    {UNIX_TOKEN, {"*CLS;:SYST:TOK \"" TOKEN "\"\n"}, "T"},
    {UNIX_TOKEN, {"SYST:TOK \"no end"}, "C"},
    /* clang-format on */
};

static void test_guard(void **state)
{
    static const char letters[] = {[LX_GUARD_PASS] = 'P',
                                   [LX_GUARD_SKIP] = 'S',
                                   [LX_GUARD_TELL] = 'T',
                                   [LX_GUARD_CLOSE] = 'C'};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(sessions); i++) {
        const enum where where = sessions[i].where;
        struct lx_guard guard = {.tcp = where == TCP || where == TCP_TOKEN,
                                 .token = where == TCP_TOKEN || where == UNIX_TOKEN ? TOKEN : NULL};
        char said[6] = "";
        for (size_t n = 0; n < 5 && sessions[i].pieces[n] != NULL; n++) {
            const char *piece = sessions[i].pieces[n];
            said[n] = letters[lx_guard_line(&guard, piece, strlen(piece))];
        }
        if (strcmp(said, sessions[i].verdicts) != 0) {
            fail_msg("session %zu (%s): %s instead of %s", i, sessions[i].pieces[0], said,
                     sessions[i].verdicts);
        }
    }
}

static void test_guard_and_zeros(void **state)
{
    static const char zero[] = "\0*CLS\n";
    static const char token[] = "SYST:TOK \"" TOKEN "\0\"\n";
    struct lx_guard guard = {.tcp = true};
    (void)state;
    assert_int_equal(lx_guard_line(&guard, zero, sizeof zero - 1u), LX_GUARD_PASS);
    assert_int_equal(lx_guard_line(&guard, "*CLS\n", 5), LX_GUARD_CLOSE);
    guard = (struct lx_guard){.token = TOKEN};
    assert_int_equal(lx_guard_line(&guard, token, sizeof token - 1u), LX_GUARD_TELL);
}

static void a_port_that_is_refused_says_what_is_right(void **state)
{
    (void)state;
    assert_string_equal(lx_port_right(EACCES),
                        "expected a port from 1024 on, or the privilege CAP_NET_BIND_SERVICE");
    assert_string_equal(lx_port_right(EMFILE), "raise the limit of open files: ulimit -Hn, or "
                                               "LimitNOFILE= of a service");
    assert_string_equal(lx_port_right(ENFILE), "raise fs.file-max");
    assert_null(lx_port_right(EADDRINUSE));
}

/* --- sockets in the file system --- */

/* Nobody else may connect. A name is taken over from a socket that is dead, from nobody else. */
static void a_socket_has_one_owner(void **state)
{
    char folder[] = "/tmp/test_access.XXXXXX";
    char path[64];
    char taken[128];
    struct stat info;
    struct lx_error error = {.right = ""};
    (void)state;
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof path, "%s/sock", folder);
    (void)snprintf(taken, sizeof taken, "unix:%s: in use already; give another name", path);
    for (int i = 0; i < 2; i++) { /* the second time it takes the place of a dead one */
        const struct sockaddr_un address = lx_unix_address(path);
        const int fd = lx_unix_listen(path, &error);
        const int client = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
        assert_true(fd >= 0 && client >= 0);
        assert_int_equal(stat(path, &info), 0);
        assert_int_equal(info.st_mode, S_IFSOCK | 0600);
        assert_int_equal(fcntl(fd, F_GETFL) & O_NONBLOCK, O_NONBLOCK);
        assert_int_equal(fcntl(fd, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
        assert_int_equal(lx_unix_listen(path, &error), -1);
        assert_string_equal(lx_error_line(&error).text, taken);
        assert_int_equal(connect(client, (const struct sockaddr *)&address, sizeof address), 0);
        (void)close(client);
        (void)close(fd);
    }
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_addresses),
        cmocka_unit_test(test_long_addresses),
        cmocka_unit_test(test_token_files),
        cmocka_unit_test(test_guard),
        cmocka_unit_test(test_guard_and_zeros),
        cmocka_unit_test(a_port_that_is_refused_says_what_is_right),
        cmocka_unit_test(a_socket_has_one_owner),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests(tests, descriptors_note, NULL);
}
