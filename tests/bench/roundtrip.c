/* SPDX-License-Identifier: MIT */
/*
 * How long a client waits for a running `drehgeber run`: from its request to the whole answer, one
 * at a time, over the real wire. Prints how many microseconds half of them took at most, and 99 of
 * 100. The figures are the machine's, too.
 *
 * roundtrip WIRE ADDRESS    WIRE slcan, pty (devices), can (interface), scpi (socket) or
 *                                 modbus (port of 127.0.0.1)
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#define ROUNDS_MAX 10000u
#define WARM_UP 100u
#define PATIENCE_MS 5000
#define QUIET_MS 200 /* after which a wire has said what it says by itself */
#define ANSWER_MAX 64u
#define NODE_ID 0x3Fu /* as delivered */

/* A request, and how its answer begins and ends. */
struct wire {
    const char *name;
    unsigned rounds;                  /* at most ROUNDS_MAX */
    int (*open)(const char *address); /* @return a descriptor, or -1 */
    const void *request;
    size_t request_length;
    const char *answer; /* its first bytes */
    size_t answer_begin;
    size_t answer_length; /* 0: a line */
};

static int open_terminal(const char *path)
{
    const int fd = open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);
    struct termios settings;

    if (fd < 0 || tcgetattr(fd, &settings) != 0) {
        return -1;
    }
    cfmakeraw(&settings);
    (void)cfsetspeed(&settings, B9600);
    return tcsetattr(fd, TCSANOW, &settings) == 0 ? fd : -1;
}

static int open_slcan(const char *path)
{
    static const char begin[] = "C\rS5\rO\r";
    const int fd = open_terminal(path);

    return fd >= 0 && write(fd, begin, sizeof begin - 1u) == (ssize_t)sizeof begin - 1 ? fd : -1;
}

static int open_can(const char *interface)
{
    const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    const struct can_filter answers = {.can_id = 0x580u + NODE_ID, .can_mask = CAN_SFF_MASK};
    const struct sockaddr_can address = {.can_family = AF_CAN,
                                         .can_ifindex = (int)if_nametoindex(interface)};

    if (fd < 0 || setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, &answers, sizeof answers) != 0) {
        return -1;
    }
    return bind(fd, (const struct sockaddr *)&address, sizeof address) == 0 ? fd : -1;
}

static int open_socket(const char *path)
{
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    struct sockaddr_un address = {.sun_family = AF_UNIX};

    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    return fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) == 0 ? fd : -1;
}

static int open_port(const char *port)
{
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port = htons((uint16_t)strtoul(port, NULL, 10)),
                                        .sin_addr = {htonl(INADDR_LOOPBACK)}};

    return fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) == 0 ? fd : -1;
}

/* Upload of 1000h, as a frame. */
static const struct can_frame upload = {
    .can_id = 0x600u + NODE_ID, .can_dlc = 8, .data = {0x40, 0x00, 0x10, 0x00}};
static const struct can_frame uploaded = {.can_id = 0x580u + NODE_ID};

/* clang-format off */
/* 42h: the encoder waits until it is sure that the request is over. */
static const struct wire wires[] = {
    {"slcan",  10000, open_slcan,    "t63F84000100000000000\r", 22, "z\rt5BF8430010", 13, 2 + 22},
    {"can",    10000, open_can,      &upload, sizeof upload, (const char *)&uploaded, 4, sizeof uploaded},
    {"pty",    300,   open_terminal, "\x40\x42\x02", 3, "\x40\x42", 2, 7},
    {"scpi",   10000, open_socket,   "SHAF:POS?\n", 10, "", 0, 0},
    /* 0, 2: input registers, IN of a K3 */
    {"modbus", 10000, open_port,     "\0\1\0\0\0\6\1\4\0\0\0\2", 12, "\0\1\0\0\0\7\1\4\4", 9, 13},
};
/* clang-format on */
#define WIRES (sizeof wires / sizeof wires[0])

static void fail(const struct wire *wire, const char *why)
{
    (void)fprintf(stderr, "roundtrip: %s: %s\n", wire->name, why);
    exit(1);
}

static double now_us(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e6 + (double)t.tv_nsec * 1e-3;
}

static bool readable(int fd, int ms)
{
    struct pollfd wait = {.fd = fd, .events = POLLIN};

    return poll(&wait, 1, ms) == 1;
}

static void calm_down(int fd)
{
    char bytes[ANSWER_MAX];

    while (readable(fd, QUIET_MS) && read(fd, bytes, sizeof bytes) > 0) {
    }
}

static bool is_whole(const struct wire *wire, const char *answer, size_t length)
{
    return wire->answer_length == 0 ? length > 0 && answer[length - 1] == '\n'
                                    : length == wire->answer_length;
}

/* @return microseconds */
static double round_trip(const struct wire *wire, int fd)
{
    char answer[ANSWER_MAX];
    size_t length = 0;
    const double begin = now_us();

    if (write(fd, wire->request, wire->request_length) != (ssize_t)wire->request_length) {
        fail(wire, "the request does not get out");
    }
    while (!is_whole(wire, answer, length)) {
        const ssize_t n =
            readable(fd, PATIENCE_MS) ? read(fd, answer + length, sizeof answer - length) : -1;
        if (n <= 0) {
            fail(wire, "no answer");
        }
        length += (size_t)n;
    }
    const double end = now_us();
    if (memcmp(answer, wire->answer, wire->answer_begin) != 0) {
        fail(wire, "not the answer");
    }
    return end - begin;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;

    return (x > y) - (x < y);
}

static void measure(const struct wire *wire, const char *address)
{
    static double times[ROUNDS_MAX];
    const int fd = wire->open(address);

    if (fd < 0) {
        fail(wire, "cannot open it");
    }
    calm_down(fd);
    for (unsigned i = 0; i < WARM_UP; i++) {
        (void)round_trip(wire, fd);
    }
    for (unsigned i = 0; i < wire->rounds; i++) {
        times[i] = round_trip(wire, fd);
    }
    qsort(times, wire->rounds, sizeof times[0], compare);
    (void)printf("%.1f %.1f\n", times[wire->rounds / 100u * 50u], times[wire->rounds / 100u * 99u]);
    (void)close(fd);
}

int main(int argc, char **argv)
{
    for (size_t i = 0; argc == 3 && i < WIRES; i++) {
        if (strcmp(argv[1], wires[i].name) == 0) {
            measure(&wires[i], argv[2]);
            return 0;
        }
    }
    (void)fprintf(stderr, "usage: roundtrip slcan|can|pty|scpi|modbus ADDRESS\n");
    return 2;
}
