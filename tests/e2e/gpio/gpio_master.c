/* SPDX-License-Identifier: MIT */
/*
 * A BiSS master behind the simulated GPIO chip of the kernel: it drives MA through the `pull` file
 * of one line and reads SLO from the `value` file of another, in the order and at the times of a
 * real master. Frames, control frames and check sums are its own, after the BiSS C protocol
 * description.
 *
 * usage: gpio_master MA SLO HALF_US PAUSE_US ACTION...
 *
 * - MA, SLO: folders of the lines in sysfs
 * - position MT ST LC: a frame; prints MT, ST, nERR, nWARN, LC in decimal, the CRC's verdict and
 *   the rate that the clock really had in Hz
 * - read ADDRESS N: registers, hexadecimal
 * - write ADDRESS BYTES: hexadecimal digits
 * - rush N: clocks, as fast as the machine can and with nobody else running
 *
 * The frame of `read` and `write` ends behind CDS, which the description allows.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sched.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define PAUSES_MAX 10u
#define START_CLOCKS_MAX 100u
#define ZERO_FRAMES 14u
#define BUSY_FRAMES_MAX 100u
#define CRC_BITS 6u
#define BYTES_MAX 64u
#define NS_PER_US 1000
#define SLICES 4
#define NS_PER_S 1000000000L

struct master {
    int ma;
    int slo;
    long half_ns;
    long pause_ns;
};

static void die(const char *what)
{
    (void)fprintf(stderr, "gpio_master: %s\n", what);
    exit(1);
}

static int open_file(const char *folder, const char *name, int flags)
{
    char path[512];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    const int fd = open(path, flags | O_CLOEXEC);
    if (fd < 0) {
        perror(path);
        exit(1);
    }
    return fd;
}

/* In slices: when the whole machine is held up, that takes one of them, and the encoder, held up as
   well, has the others. */
static void wait_ns(long ns)
{
    const long slice = ns / SLICES;
    const struct timespec span = {.tv_sec = slice / NS_PER_S, .tv_nsec = slice % NS_PER_S};
    for (unsigned i = 0; i < SLICES; i++) {
        (void)nanosleep(&span, NULL);
    }
}

static void drive(struct master *self, bool level)
{
    const char *pull = level ? "pull-up" : "pull-down";
    if (pwrite(self->ma, pull, strlen(pull), 0) < 0) {
        die("MA cannot be driven");
    }
}

static bool sample(const struct master *self)
{
    char value = '?';
    if (pread(self->slo, &value, 1, 0) != 1 || (value != '0' && value != '1')) {
        die("SLO cannot be read");
    }
    return value == '1';
}

/* A period; what the rising edge at its middle brings is looked at when it ends. */
static bool clock_bit(struct master *self)
{
    drive(self, false);
    wait_ns(self->half_ns);
    drive(self, true);
    wait_ns(self->half_ns);
    return sample(self);
}

/* Up to CDS, which it returns. */
static bool begin_frame(struct master *self)
{
    if (!clock_bit(self) || clock_bit(self)) {
        die("no Ack: SLO has to be 1 after the first clock and 0 after the second");
    }
    for (unsigned i = 0; !clock_bit(self); i++) {
        if (i == START_CLOCKS_MAX) {
            die("no start bit");
        }
    }
    return clock_bit(self);
}

static void end_frame(struct master *self, bool cdm)
{
    drive(self, !cdm);
    wait_ns(self->pause_ns);
    for (unsigned i = 0; !sample(self); i++) { /* the other side's pause may begin later */
        if (i == PAUSES_MAX) {
            die("SLO stays low after the timeout");
        }
        wait_ns(self->pause_ns);
    }
    drive(self, true);
    wait_ns(self->half_ns);
}

static bool frame(struct master *self, bool cdm)
{
    const bool cds = begin_frame(self);
    end_frame(self, cdm);
    return cds;
}

/* Inverted CRC with `n` bits of `polynomial`, start value 0. */
static unsigned crc(uint64_t bits, unsigned length, unsigned polynomial, unsigned n)
{
    unsigned value = 0;
    for (unsigned i = length; i > 0; i--) {
        const unsigned out = value >> (n - 1u) ^ (unsigned)(bits >> (i - 1u) & 1u);
        value = (value << 1 ^ ((out & 1u) != 0 ? polynomial : 0u)) & ((1u << n) - 1u);
    }
    return value ^ ((1u << n) - 1u);
}

static unsigned crc4(unsigned bits, unsigned length)
{
    return crc(bits, length, 0x03, 4);
}

static long now_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * NS_PER_S + now.tv_nsec;
}

static void position(struct master *self, unsigned mt, unsigned st, unsigned lc)
{
    const unsigned length = mt + st + 2u + lc;
    uint64_t data = 0;
    unsigned sum = 0;
    (void)begin_frame(self);
    const long begin = now_ns();
    for (unsigned i = 0; i < length; i++) {
        data = data << 1 | clock_bit(self);
    }
    for (unsigned i = 0; i < CRC_BITS; i++) {
        sum = sum << 1 | clock_bit(self);
    }
    if (clock_bit(self)) {
        die("SLO is high behind the CRC");
    }
    const long period_ns = (now_ns() - begin) / (long)(length + CRC_BITS + 1u);
    end_frame(self, false);
    const uint64_t angle = data >> (lc + 2u);
    (void)printf(
        "%llu %llu %u %u %u %s %ld\n", (unsigned long long)(angle >> st),
        (unsigned long long)(angle & ((1ULL << st) - 1u)), (unsigned)(data >> (lc + 1u)) & 1u,
        (unsigned)(data >> lc) & 1u, (unsigned)data & ((1u << lc) - 1u),
        sum == crc(data, length, 0x03, CRC_BITS) ? "valid" : "wrong", NS_PER_S / period_ns);
}

/* The last `n` bits of `bits`, one in each frame. @return the CDS bits */
static unsigned send_bits(struct master *self, unsigned bits, unsigned n)
{
    unsigned back = 0;
    for (unsigned i = n; i > 0; i--) {
        back = back << 1 | frame(self, (bits >> (i - 1u) & 1u) != 0);
    }
    return back;
}

/* Frames 0 to 18: start, CTS, ID 0, address, CRC, R, W, start. */
static void address(struct master *self, unsigned where, bool write)
{
    const unsigned word = 1u << 10 | where;
    (void)send_bits(self, 0, ZERO_FRAMES);
    (void)send_bits(self, 1, 1);
    (void)send_bits(self, word << 4 | crc4(word, 11), 15);
    /* CDS of a frame is the answer to the frame in front. */
    const unsigned back = send_bits(self, write ? 3 : 5, 3) & 3u;
    if (back != (write ? 1u : 2u)) {
        die("the access is refused");
    }
}

/* Frame 19: the start bit is repeated until it comes back. */
static void await_ready(struct master *self, bool cdm)
{
    for (unsigned i = 0; !begin_frame(self); i++) {
        if (i == BUSY_FRAMES_MAX) {
            die("busy for too long");
        }
        end_frame(self, true);
    }
    end_frame(self, cdm);
}

static void transfer(struct master *self, unsigned where, uint8_t *bytes, unsigned n, bool write)
{
    address(self, where, write);
    for (unsigned i = 0; i < n; i++) {
        const unsigned word = write ? (unsigned)bytes[i] << 4 | crc4(bytes[i], 8) : 0;
        await_ready(self, (word >> 11) != 0);
        /* Eleven bits to go and the stop bit; twelve come back. */
        const unsigned back = send_bits(self, (word << 1) & 0xFFFu, 12);
        const bool more = i + 1 < n;
        if (frame(self, more)) {
            die("the register is refused");
        }
        if ((back & 0xFu) != crc4(back >> 4, 8) || (write && back >> 4 != bytes[i])) {
            die("the CRC of a register is wrong");
        }
        bytes[i] = (uint8_t)(back >> 4);
    }
}

/* Nobody else runs: what the encoder gets it gets at once, afterwards. */
static void rush(struct master *self, unsigned clocks)
{
    const struct sched_param urgent = {.sched_priority = 1};
    const struct sched_param usual = {.sched_priority = 0};
    if (sched_setscheduler(0, SCHED_FIFO, &urgent) != 0) {
        die("no real-time priority");
    }
    for (unsigned i = 0; i < clocks; i++) {
        drive(self, false);
        drive(self, true);
    }
    (void)sched_setscheduler(0, SCHED_OTHER, &usual);
    wait_ns(self->pause_ns);
}

static unsigned number(const char *text, int base)
{
    char *end = NULL;
    const unsigned long value = text == NULL ? 0 : strtoul(text, &end, base);
    if (end == NULL || *end != '\0') {
        die("a number is missing");
    }
    return (unsigned)value;
}

static void read_registers(struct master *self, char **words)
{
    uint8_t bytes[BYTES_MAX] = {0};
    const unsigned n = number(words[1], 10);
    if (n > BYTES_MAX) {
        die("too many bytes");
    }
    transfer(self, number(words[0], 16), bytes, n, false);
    for (unsigned i = 0; i < n; i++) {
        (void)printf("%02X%c", bytes[i], i + 1 < n ? ' ' : '\n');
    }
}

static void write_registers(struct master *self, char **words)
{
    uint8_t bytes[BYTES_MAX] = {0};
    unsigned n = 0;
    for (const char *at = words[1]; at[0] != '\0' && at[1] != '\0' && n < BYTES_MAX; at += 2) {
        const char digits[3] = {at[0], at[1], '\0'};
        bytes[n++] = (uint8_t)number(digits, 16);
    }
    transfer(self, number(words[0], 16), bytes, n, true);
}

static void act_position(struct master *self, char **words)
{
    position(self, number(words[0], 10), number(words[1], 10), number(words[2], 10));
}

static void act_rush(struct master *self, char **words)
{
    rush(self, number(words[0], 10));
}

static const struct {
    const char *name;
    int words;
    void (*act)(struct master *self, char **words);
} actions[] = {
    {"position", 3, act_position},
    {"read", 2, read_registers},
    {"write", 2, write_registers},
    {"rush", 1, act_rush},
};
#define ACTION_COUNT (sizeof actions / sizeof actions[0])

/* @return the words of an action, its name included */
static int act(struct master *self, char **words, int count)
{
    for (size_t i = 0; i < ACTION_COUNT; i++) {
        if (strcmp(words[0], actions[i].name) == 0 && count > actions[i].words) {
            actions[i].act(self, words + 1);
            return actions[i].words + 1;
        }
    }
    die("unknown action");
    return count;
}

int main(int argc, char **argv)
{
    if (argc < 6) {
        die("usage: gpio_master MA SLO HALF_US PAUSE_US ACTION...");
    }
    struct master self = {
        .ma = open_file(argv[1], "pull", O_WRONLY),
        .slo = open_file(argv[2], "value", O_RDONLY),
        .half_ns = (long)number(argv[3], 10) * NS_PER_US,
        .pause_ns = (long)number(argv[4], 10) * NS_PER_US,
    };
    drive(&self, true);
    wait_ns(self.pause_ns);
    for (int at = 5; at < argc;) {
        at += act(&self, argv + at, argc - at);
    }
    return 0;
}
