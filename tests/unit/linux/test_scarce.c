/* SPDX-License-Identifier: MIT */
/*
 * A rig for which something is not to be had: of all that it asks for while it is planned and
 * opened, memory, descriptors, places in the loop, one is refused; or of what it asks for while it
 * serves a client. Then it says so, in words, and nothing of it is left: no memory, no descriptor,
 * no file. Nothing is left of one either that gets all of it.
 *
 * The calls of the port come here (the linker's --wrap); those of libraries do not.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <search.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <systemd/sd-event.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "give_up.h"
#include "rig_parts.h"
#include "timer.h"

/* --- what is refused --- */

static struct {
    pthread_mutex_t lock;
    unsigned left; /* calls until the one that is refused; 0: none is */
    const char *refused;
    int reason;          /* an errno */
    bool disk_is_broken; /* which close() says */
    void *live;          /* memory that is in use, a tree for tsearch() */
    unsigned lives;
} scarce = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* @return whether it does, and then says so by errno */
static bool refuses(const char *call, int reason)
{
    (void)pthread_mutex_lock(&scarce.lock);
    const bool now = scarce.left == 1;
    scarce.left -= scarce.left > 0 ? 1u : 0u;
    if (now) {
        scarce.refused = call;
        scarce.reason = reason;
    }
    (void)pthread_mutex_unlock(&scarce.lock);
    errno = now ? reason : errno;
    return now;
}

static int compare(const void *a, const void *b)
{
    return ((uintptr_t)a > (uintptr_t)b) - ((uintptr_t)a < (uintptr_t)b);
}

static void *note(void *memory)
{
    (void)pthread_mutex_lock(&scarce.lock);
    if (memory != NULL && tsearch(memory, &scarce.live, compare) != NULL) {
        scarce.lives++;
    }
    (void)pthread_mutex_unlock(&scarce.lock);
    return memory;
}

/* Memory that a library has taken is not known here. */
static void forget(const void *memory)
{
    (void)pthread_mutex_lock(&scarce.lock);
    if (memory != NULL && tdelete(memory, &scarce.live, compare) != NULL) {
        scarce.lives--;
    }
    (void)pthread_mutex_unlock(&scarce.lock);
}

/* CALL(TYPE, NAME, errno, what a refusal returns, (parameters), (arguments)) */
#define CALL(type, name, reason, refusal, parameters, arguments)                                   \
    type __real_##name parameters;                                                                 \
    type __wrap_##name parameters;                                                                 \
    type __wrap_##name parameters                                                                  \
    {                                                                                              \
        return refuses(#name, reason) ? (refusal) : __real_##name arguments;                       \
    }
/* The same, of what has to be freed. */
#define TAKE(name, parameters, arguments)                                                          \
    void *__real_##name parameters;                                                                \
    void *__wrap_##name parameters;                                                                \
    void *__wrap_##name parameters                                                                 \
    {                                                                                              \
        return refuses(#name, ENOMEM) ? NULL : note(__real_##name arguments);                      \
    }

TAKE(malloc, (size_t n), (n))
TAKE(calloc, (size_t count, size_t n), (count, n))
TAKE(strdup, (const char *text), (text))
TAKE(strndup, (const char *text, size_t n), (text, n))
TAKE(modbus_new_tcp_pi, (const char *node, const char *service), (node, service))

static int print(char **to, const char *format, va_list arguments)
{
    const int n = refuses("asprintf", ENOMEM) ? -1 : vasprintf(to, format, arguments);
    (void)note(n < 0 ? NULL : *to);
    return n;
}

int __wrap_asprintf(char **to, const char *format, ...);
int __wrap_asprintf(char **to, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int n = print(to, format, arguments);
    va_end(arguments);
    return n;
}

/* The same, with _FORTIFY_SOURCE. */
int __wrap___asprintf_chk(char **to, int flag, const char *format, ...);
int __wrap___asprintf_chk(char **to, int flag, const char *format, ...)
{
    (void)flag;
    va_list arguments;
    va_start(arguments, format);
    const int n = print(to, format, arguments);
    va_end(arguments);
    return n;
}

void __real_free(void *memory);
void __wrap_free(void *memory);
void __wrap_free(void *memory)
{
    forget(memory);
    __real_free(memory);
}

void __real_modbus_free(void *memory);
void __wrap_modbus_free(void *memory);
void __wrap_modbus_free(void *memory)
{
    forget(memory);
    __real_modbus_free(memory);
}

void *__real_reallocarray(void *memory, size_t count, size_t n);
void *__wrap_reallocarray(void *memory, size_t count, size_t n);
void *__wrap_reallocarray(void *memory, size_t count, size_t n)
{
    if (refuses("reallocarray", ENOMEM)) {
        return NULL;
    }
    forget(memory);
    return note(__real_reallocarray(memory, count, n));
}

void *__wrap_realloc(void *memory, size_t n);
void *__wrap_realloc(void *memory, size_t n)
{
    return __wrap_reallocarray(memory, 1, n);
}

char *__real_realpath(const char *path, char *to);
char *__wrap_realpath(const char *path, char *to);
char *__wrap_realpath(const char *path, char *to)
{
    char *found = refuses("realpath", ENOMEM) ? NULL : __real_realpath(path, to);
    return to == NULL ? note(found) : found;
}

CALL(int, socket, EMFILE, -1, (int domain, int type, int protocol), (domain, type, protocol))
CALL(int, listen, EADDRINUSE, -1, (int fd, int backlog), (fd, backlog))
CALL(int, eventfd, EMFILE, -1, (unsigned count, int flags), (count, flags))
CALL(int, posix_openpt, EMFILE, -1, (int flags), (flags))
CALL(FILE *, fopencookie, ENOMEM, NULL,
     (void *cookie, const char *mode, cookie_io_functions_t operations), (cookie, mode, operations))
/* Whoever closes one twice may close somebody else's. */
int __real_close(int fd);
int __wrap_close(int fd);
int __wrap_close(int fd)
{
    const int result = __real_close(fd);
    if (result != 0 && errno == EBADF) {
        give_up("closes what is not open", "a rig");
    }
    if (scarce.disk_is_broken) {
        errno = EIO;
        return -1;
    }
    return result;
}

CALL(FILE *, fdopen, ENOMEM, NULL, (int fd, const char *mode), (fd, mode))
CALL(int, pthread_create, EAGAIN, EAGAIN,
     (pthread_t * thread, const pthread_attr_t *attributes, void *(*run)(void *), void *ctx),
     (thread, attributes, run, ctx))
CALL(int, sd_event_add_io, ENOMEM, -ENOMEM,
     (sd_event * event, sd_event_source **source, int fd, uint32_t events,
      sd_event_io_handler_t handler, void *ctx),
     (event, source, fd, events, handler, ctx))
CALL(int, sd_event_add_time, ENOMEM, -ENOMEM,
     (sd_event * event, sd_event_source **source, clockid_t clock, uint64_t at, uint64_t accuracy,
      sd_event_time_handler_t handler, void *ctx),
     (event, source, clock, at, accuracy, handler, ctx))

/* --- rigs --- */

static const char *const rigs[] = {
    "[shaft main]\nmotion = motion.csv\n"
    "[encoder e]\nmodel = s3684-rs485\nwire = pty:link\nnvm = e.nvm\ntrace = e.vcd\n"
    "temperature = warm.csv\nsincos_us = 1000\nserial = 5\n",
    "[bus b]\nwire = slcan\naddress = tcp:127.0.0.1:0\ntrace = b.pcapng\npace = 1\n"
    "[encoder e]\nmodel = f3668\nbus = b\nnode = 1..2\nnvm = e.nvm\n"
    "temperature = 21\n",
    "[bus b]\nwire = sim\ntrace = b.vcd\n[encoder x]\nmodel = s3684-biss\nbus = b\nnvm = x.nvm\n"
    "[encoder y]\nmodel = s3674-biss\nbus = b\n",
    "[bus b]\nwire = modbus\naddress = 127.0.0.1:0\ntrace = b.csv\n"
    "[encoder x]\nmodel = ocd-ib-k3\nbus = b\nnvm = x.nvm\n[encoder y]\nmodel = ocd-ib-k2\nbus = b\n",
    "[bus b]\nwire = rs485\naddress = rfc2217:127.0.0.1:0\n"
    "[encoder e]\nmodel = s3684-rs485\nbus = b\naddress = 0x40..0x41\n",
    "[encoder e]\nmodel = ssi-25\nwire = sim\ntrace = e.vcd\n"
    "[encoder c]\nmodel = f3658\nwire = slcan\n"
    "[encoder d]\nmodel = f3658\nwire = socketcand:127.0.0.1:0\n",
};

static char folder[] = "/tmp/test_scarce.XXXXXX";

static void write_file(const char *name, const char *text)
{
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* All but what a rig begins with. */
static unsigned remove_files(void)
{
    unsigned count = 0;
    DIR *all = opendir(".");
    assert_non_null(all);
    for (const struct dirent *entry = readdir(all); entry != NULL; entry = readdir(all)) {
        count += entry->d_name[0] != '.' && unlink(entry->d_name) == 0 ? 1u : 0u;
    }
    (void)closedir(all);
    return count;
}

#define LEFT 0700 /* the mode that a socket of somebody else is known by here */

/* What a rig that was killed leaves. */
static void leave_socket(const char *name)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s", name);
    const int fd = __real_socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(chmod(name, LEFT), 0);
    (void)close(fd);
}

static void begin_with(const char *rig)
{
    (void)remove_files();
    leave_socket("sock");
    char text[512];
    (void)snprintf(text, sizeof text, "[rig]\nfiles = .\ncontrol = unix:sock\n%s", rig);
    write_file("rig.ini", text);
    write_file("motion.csv", "time_s,position_deg\n0,0\n1,360\n");
    write_file("warm.csv", "0,20\n1,30\n");
}

static int make_folder(void **state)
{
    (void)setenv("XDG_RUNTIME_DIR", "/dev/null", 1);
    (void)unsetenv("RUNTIME_DIRECTORY");
    return mkdtemp(folder) == NULL || chdir(folder) != 0 ? -1 : descriptors_note(state);
}

static int remove_folder(void **state)
{
    (void)state;
    (void)remove_files();
    return chdir("/") != 0 || rmdir(folder) != 0 ? -1 : 0;
}

/* What clients ask for, also in vain; each of it twice, so that what was there is given back. */
static const char *const commands[] = {
    "SHAF:PROF \"motion.csv\"",
    "SHAF:PROF \"60RPM\"",
    "SHAF:PROF \"none.csv\"",
    "SHAF:REC:STAR \"record.csv\",1MS",
    "SHAF:REC:STOP",
    "WORL:TEMP:PROF \"warm.csv,LOOP\"",
    "WORL:TEMP:PROF \"motion.csv,WRONG\"",
    "WORL:TEMP:PROF:POIN 0,20,1,30,LOOP",
    "WORL:TEMP:PROF:STAT OFF",
    "TRAC:LAST?",
    "TRAC:STOP",
    "TRAC:STAR \"c.vcd\"",
    "TRAC:STAR \"c.log\"",
    "TRAC:STAR \"c.csv\"",
    "TRAC:STAR \"no/c.log\"",
    "POW OFF;POW ON",
    "STAT?",
};
#define COMMANDS DG_COUNT(commands)

/* Of what was refused to the rig, a part. */
static const char *reason_of_refusal(void)
{
    return scarce.reason == ENOMEM ? "emory" : strerror(scarce.reason);
}

/* The latest answer of the control plane. */
struct answer {
    char text[256];
    size_t length;
};

static void keep_answer(void *ctx, const char *bytes, size_t n)
{
    struct answer *self = ctx;
    for (size_t i = 0; i < n && self->length < sizeof self->text - 1u; i++) {
        self->text[self->length++] = bytes[i];
    }
    self->text[self->length] = '\0';
}

static void send_line(struct dg_control *client, sd_event *event, const char *command)
{
    (void)dg_control_rx(client, lx_now(), command, strlen(command));
    (void)dg_control_rx(client, lx_now(), "\n", 1);
    while (client->session.executing) {
        (void)dg_control_step(client, lx_now());
    }
    while (sd_event_run(event, 0) > 0) {
    }
}

/* Until something is refused. @return whether the client is told so; else `error` says what it was
   told */
static bool serve_client(struct lx_rig *rig, sd_event *event, struct lx_error *error)
{
    struct dg_control client;
    struct answer answer = {.text = ""};
    bool told = true;
    dg_control_init(&client, rig->control, keep_answer, &answer);
    for (size_t i = 0; i < 2u * COMMANDS && scarce.refused == NULL; i++) {
        const char *command = commands[i / 2u];
        send_line(&client, event, command);
        answer.length = 0;
        send_line(&client, event, "SYST:ERR?");
        /* Without memory there are no last frames, which is an answer. */
        told = scarce.refused == NULL || strcmp(command, "TRAC:LAST?") == 0 ||
               strstr(answer.text, reason_of_refusal()) != NULL;
        (void)lx_fail(error, "%s: %s", command, answer.text);
    }
    dg_scpi_leave(&client.session);
    return told;
}

/* Read, opened, and closed. @return whether it works, or says what was refused: in `error`, or to a
   client */
static bool live_once(struct lx_error *error)
{
    static const struct lx_say quiet = {.quiet = true};
    struct dg_plan plan = {.wire_count = 0};
    struct lx_rig *rig = NULL;
    sd_event *event = NULL;
    assert_true(sd_event_new(&event) >= 0);
    bool good = lx_plan_read(&plan, "rig.ini", error) == 0;
    if (good) {
        const struct lx_rig_setup setup = {.event = event, .say = &quiet, .plan = &plan};
        good = lx_rig_open(&rig, &setup, lx_now(), error) == LX_RIG_OK;
        assert_true(good == (rig != NULL));
    }
    bool told = !good && scarce.refused != NULL &&
                strstr(lx_error_line(error).text, reason_of_refusal()) != NULL;
    if (good && scarce.refused == NULL) {
        told = serve_client(rig, event, error);
    }
    scarce.left = 0;
    struct lx_error at_end;
    assert_int_equal(lx_rig_close(rig, &at_end), 0);
    lx_plan_free(&plan);
    (void)sd_event_unref(event);
    return told;
}

/* Links and sockets that lead nowhere. What an EEPROM file or a trace has got so far may stay. */
static bool leads_nowhere(void)
{
    struct stat info;
    return lstat("link", &info) == 0 ||
           (lstat("sock", &info) == 0 && (info.st_mode & 0777) != LEFT);
}

/* The call number `n` is refused. @return whether there was one */
static bool live_without(const char *rig, unsigned n)
{
    struct lx_error error = {.what = "", .right = ""};
    begin_with(rig);
    const unsigned descriptors = descriptors_open();
    const unsigned lives = scarce.lives;
    scarce.refused = NULL;
    scarce.left = n;
    const bool told = live_once(&error);
    if (!told || leads_nowhere() || scarce.lives != lives || descriptors_open() != descriptors) {
        fail_msg("%s: %s, call %u is refused: \"%s\"; in use %u, before %u; open %u, before %u",
                 rig, scarce.refused == NULL ? "nothing" : scarce.refused, n,
                 lx_error_line(&error).text, scarce.lives, lives, descriptors_open(), descriptors);
    }
    return scarce.refused != NULL;
}

/* Whoever refuses it closes it, and the rig does not close it again. */
static void an_eeprom_file_that_is_none_is_closed_once(void **state)
{
    struct lx_error error = {.what = "", .right = ""};
    (void)state;
    begin_with("[encoder e]\nmodel = f3668\nwire = slcan\nnvm = empty.nvm\n");
    write_file("empty.nvm", "");
    const unsigned descriptors = descriptors_open();
    scarce.refused = NULL;
    scarce.left = 0;
    assert_false(live_once(&error));
    assert_non_null(strstr(lx_error_line(&error).text, "empty.nvm: 0 bytes"));
    assert_int_equal(descriptors_open(), descriptors);
}

/* What a disk says last: some of it is lost. */
static void a_file_that_closes_badly_is_not_whole(void **state)
{
    static const char *const rows[][2] = {
        {"TRAC:STAR \"c.vcd\"", "TRAC:STOP"},
        {"SHAF:REC:STAR \"record.csv\"", "SHAF:REC:STOP"},
    };
    static const struct lx_say quiet = {.quiet = true};
    struct dg_plan plan = {.wire_count = 0};
    struct lx_rig *rig = NULL;
    sd_event *event = NULL;
    struct lx_error error;
    struct dg_control client;
    struct answer answer = {.text = ""};
    (void)state;
    begin_with("[encoder e]\nmodel = s3684-biss\nwire = sim\n");
    assert_true(sd_event_new(&event) >= 0);
    assert_int_equal(lx_plan_read(&plan, "rig.ini", &error), 0);
    const struct lx_rig_setup setup = {.event = event, .say = &quiet, .plan = &plan};
    assert_int_equal(lx_rig_open(&rig, &setup, lx_now(), &error), LX_RIG_OK);
    dg_control_init(&client, rig->control, keep_answer, &answer);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        send_line(&client, event, rows[i][0]);
        scarce.disk_is_broken = true;
        send_line(&client, event, rows[i][1]);
        scarce.disk_is_broken = false;
        answer.length = 0;
        send_line(&client, event, "SYST:ERR?");
        if (strstr(answer.text, ": Input/output error") == NULL) {
            fail_msg("%s: %s", rows[i][1], answer.text);
        }
    }
    dg_scpi_leave(&client.session);
    assert_int_equal(lx_rig_close(rig, &error), 0);
    lx_plan_free(&plan);
    (void)sd_event_unref(event);
}

static void nothing_is_left_of_a_rig_that_something_was_refused_to(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rigs); i++) {
        unsigned n = 1;
        while (live_without(rigs[i], n)) {
            n++;
        }
        assert_true(n > 50); /* the linker has led them here */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_eeprom_file_that_is_none_is_closed_once),
        cmocka_unit_test(a_file_that_closes_badly_is_not_whole),
        cmocka_unit_test(nothing_is_left_of_a_rig_that_something_was_refused_to),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
