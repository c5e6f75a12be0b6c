/* SPDX-License-Identifier: MIT */
/*
 * The masters of a rig: each is a process on one wire that asks its encoders in a circle, as a
 * drive or a PLC does, and checks every answer against the angle that the shaft has by the control
 * plane.
 *
 * usage: masters [-n MOST] WIRE WHERE CONTROL [NAME,ADDRESS,STEPS,TURNS]...
 *
 * - MOST: it ends when it has asked so often, pauses no longer than the wire needs, and waits for
 *   answers that come late
 * - WIRE: can, rs485, ring or biss; clock looks at the machine's time, see master_clock.c
 * - WHERE: interface, or path of a terminal with SLCAN; terminal, perhaps with @BAUD behind it;
 * port of the coupler on 127.0.0.1; else -
 * - CONTROL: path of the control socket
 * - ADDRESS: node-ID, RS485 address, first input register
 *
 * A line for each change: "NAME STATE", with "ok", "silent", "garbled", "twice", "wrong ..." or
 * what the wire has to say. SIGTERM ends it with a line of figures:
 *
 *   figures WHERE exchanges=N wrong=N lost=N garbled=N longest_us=N
 *
 * An answer is right when the shaft was there between the request and the answer; longest_us is the
 * longest time from the one to the other.
 */
#define _GNU_SOURCE
#include "masters.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#define DEGREES_PER_TURN 360.0
#define LOOKS_APART NS_PER_S
#define PATIENCE (250 * NS_PER_MS)
/* Where every answer counts: a machine that stands still loses none. */
#define LONG_PATIENCE (2 * NS_PER_S)

static volatile sig_atomic_t ended;

static void on_signal(int number)
{
    (void)number;
    ended = 1;
}

bool goes_on(const struct master *self)
{
    return ended == 0 && (self->most == 0 || self->exchanges + self->lost < self->most);
}

int64_t now_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * NS_PER_S + now.tv_nsec;
}

void sleep_until(int64_t at)
{
    const struct timespec end = {.tv_sec = at / NS_PER_S, .tv_nsec = at % NS_PER_S};
    (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &end, NULL);
}

_Noreturn void die(const char *what)
{
    (void)fprintf(stderr, "masters: %s: %s\n", what, strerror(errno));
    exit(1);
}

bool readable(int fd, int64_t end)
{
    int result = -1;
    do {
        const int64_t now = now_ns();
        const int64_t left = end > now ? end - now : 0;
        const struct timespec span = {.tv_sec = left / NS_PER_S, .tv_nsec = left % NS_PER_S};
        struct pollfd one = {.fd = fd, .events = POLLIN};
        result = ppoll(&one, 1, &span, NULL);
    } while (result < 0 && errno == EINTR);
    return result > 0;
}

/* --- what is said --- */

void say(const char *name, const char *format, ...)
{
    va_list arguments;
    (void)printf("%s ", name);
    va_start(arguments, format);
    (void)vprintf(format, arguments);
    va_end(arguments);
    (void)putchar('\n');
}

void become(struct device *device, const char *state)
{
    if (strcmp(device->state, state) != 0) {
        (void)snprintf(device->state, sizeof device->state, "%s", state);
        say(device->name, "%s", state);
    }
}

void lose(struct master *self, struct device *device)
{
    self->lost++;
    become(device, "silent");
}

void garble(struct master *self, struct device *device)
{
    self->garbled++;
    become(device, "garbled");
}

/* --- the shaft --- */

void tell(const struct master *self, const char *line)
{
    if (write(self->control, line, strlen(line)) != (ssize_t)strlen(line)) {
        die("control");
    }
}

void hear(const struct master *self, char *line)
{
    const int64_t end = now_ns() + CONTROL_PATIENCE;
    size_t n = 0;
    while (n < LINE_SIZE - 1u && readable(self->control, end) &&
           read(self->control, &line[n], 1) == 1 && line[n] != '\n') {
        n++;
    }
    line[n] = '\0';
}

double number(const char **text)
{
    char *end = NULL;
    const double value = strtod(*text, &end);
    if (end == *text) {
        return NAN;
    }
    *text = *end == '\0' ? end : end + 1;
    return value;
}

/* Where the shaft is and when: both are of the same moment, that of the line. */
static double ask_turn(const struct master *self, const struct device *device, int64_t *at)
{
    char line[LINE_SIZE];
    const char *rest = line;
    (void)snprintf(line, sizeof line, "INST:SEL %s;:SHAF:POS?;:TIME?;:TIME:ORIG?\n", device->name);
    const int64_t before = now_ns();
    tell(self, line);
    hear(self, line);
    const double degrees = number(&rest);
    const double seconds = number(&rest);
    const double origin = number(&rest);
    if (isnan(degrees) || isnan(seconds) || isnan(origin)) {
        errno = EPROTO;
        die(line);
    }
    *at = llround(origin * (double)NS_PER_S) + llround(seconds * (double)NS_PER_S);
    if (*at < before || *at > now_ns()) {
        errno = ERANGE;
        die("the rig's clock is not CLOCK_MONOTONIC");
    }
    return degrees / DEGREES_PER_TURN;
}

/* The shafts turn evenly: two looks say how fast. */
static void ask_shafts(struct master *self)
{
    for (size_t i = 0; i < self->count; i++) {
        self->device[i].turn = ask_turn(self, &self->device[i], &self->device[i].at);
    }
    sleep_until(now_ns() + LOOKS_APART);
    for (size_t i = 0; i < self->count; i++) {
        int64_t at = 0;
        const double turn = ask_turn(self, &self->device[i], &at);
        self->device[i].per_ns = (turn - self->device[i].turn) / (double)(at - self->device[i].at);
    }
}

static double steps_at(const struct device *device, int64_t at)
{
    return (device->turn + device->per_ns * (double)(at - device->at)) * device->steps;
}

/* Whether the shaft was at `position` some time from `from` to `to`, within a step. */
static bool was_at(const struct device *device, uint64_t position, int64_t from, int64_t to)
{
    const double a = steps_at(device, from);
    const double b = steps_at(device, to);
    const double low = floor(fmin(a, b)) - 1.0;
    const double range = device->steps * device->turns;
    double above = fmod((double)position - low, range);
    above += above < 0 ? range : 0;
    return above <= floor(fmax(a, b)) + 1.0 - low;
}

bool check(struct master *self, struct device *device, uint64_t position, int64_t from)
{
    const int64_t to = now_ns() + self->ahead;
    self->exchanges++;
    if (was_at(device, position, from, to)) {
        return true;
    }
    self->wrong++;
    say(device->name, "wrong %llu, not %.0f to %.0f", (unsigned long long)position,
        steps_at(device, from), steps_at(device, to));
    return false;
}

void took(struct master *self, int64_t from)
{
    const int64_t time = now_ns() - from;
    self->longest = time > self->longest ? time : self->longest;
}

/* --- all of them --- */

static const struct {
    const char *name;
    void (*run)(struct master *self);
} wires[] = {
    {"can", run_can},   {"rs485", run_rs485}, {"ring", run_ring},
    {"biss", run_biss}, {"clock", run_clock},
};

static void connect_control(struct master *self, const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    self->control = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (self->control < 0 ||
        connect(self->control, (struct sockaddr *)&address, sizeof address) != 0) {
        die(path);
    }
}

/* NAME,ADDRESS,STEPS,TURNS */
static void take_device(struct master *self, const char *text)
{
    struct device *device = &self->device[self->count++];
    const size_t n = strcspn(text, ",");
    const char *rest = text + n + (text[n] == ',' ? 1 : 0);
    (void)snprintf(device->name, sizeof device->name, "%.*s", (int)n, text);
    const double address = number(&rest);
    device->address = (unsigned)address;
    device->steps = number(&rest);
    device->turns = number(&rest);
    if (isnan(address) || isnan(device->steps) || isnan(device->turns)) {
        errno = EINVAL;
        die(text);
    }
}

static void run(struct master *self, const char *wire)
{
    for (size_t i = 0; i < sizeof wires / sizeof wires[0]; i++) {
        if (strcmp(wires[i].name, wire) == 0) {
            wires[i].run(self);
            return;
        }
    }
    errno = EINVAL;
    die(wire);
}

int main(int argc, char **argv)
{
    struct master self = {.fd = -1, .patience = PATIENCE};
    const struct sigaction end = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    if (argc > 3 && strcmp(argv[1], "-n") == 0) {
        self.most = strtoul(argv[2], NULL, 10);
        self.patience = LONG_PATIENCE;
        argc -= 2;
        argv += 2;
    }
    if (argc < 4 || argc > 4 + (int)DEVICES_MAX) {
        (void)fprintf(stderr, "usage: masters [-n MOST] WIRE WHERE CONTROL "
                              "[NAME,ADDRESS,STEPS,TURNS]...\n");
        return 2;
    }
    (void)sigaction(SIGTERM, &end, NULL);
    (void)setvbuf(stdout, NULL, _IOLBF, 0);
    self.where = argv[2];
    connect_control(&self, argv[3]);
    for (int i = 4; i < argc; i++) {
        take_device(&self, argv[i]);
    }
    ask_shafts(&self);
    run(&self, argv[1]);
    (void)printf("figures %s exchanges=%lu wrong=%lu lost=%lu garbled=%lu longest_us=%lld\n",
                 self.where, self.exchanges, self.wrong, self.lost, self.garbled,
                 (long long)(self.longest / (NS_PER_MS / 1000)));
    return 0;
}
