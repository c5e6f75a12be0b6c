/* SPDX-License-Identifier: MIT */
/*
 * libgpiod 1.x for a program that is a master: an encoder of this tree is at the other end of its
 * lines. To be preloaded. Time is virtual in the whole process: each look at the clock and each access to
 * a line takes a little of it, a sleep takes what it asks for, and nothing else takes any. So a master in
 * real time meets an encoder in virtual time, always in the same way.
 *
 * DOUBLE_MODEL    a model with BiSS or SSI
 * DOUBLE_IMAGE    file of its EEPROM, which is made if there is none
 * DOUBLE_COUNT    position of the shaft, in counts
 * DOUBLE_RPM      its speed
 * DOUBLE_UNPOWERED  while this file is there the encoder has no supply
 * DOUBLE_LOG      file that gets what the encoder has counted
 * DOUBLE_LAG      ns that data comes late; then the encoder has the timeout of lines that are as slow
 * DOUBLE_ACCESS   ns that an access to a line takes; 300 if it is not set
 * DOUBLE_STALL    every so many accesses to a line one of them takes 1 ms
 * DOUBLE_FLICKER  every so many looks at data one of them sees the other level
 * DOUBLE_DEAF     from this edge of the clock on the encoder answers nothing
 * DOUBLE_DIE      the process is killed when the EEPROM is written for this time
 * DOUBLE_BARE     1: BiSS without life counter, registers, commands and processing time
 * DOUBLE_SPOIL    "crc": the last bit of frames with CDS = 1; "register": 79h; "again": the last bit of
 *                 words that come again; "return": MA that returns behind CDM = 1 is
 *                 e1; "link": a clock that is low for 20 us loses the encoder until it was high for 20 us;
 *                 "error": nERR is low
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <gpiod.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "drehgeber/biss.h"
#include "drehgeber/devices.h"
#include "drehgeber/ssi.h"

#define COST 100u
#define ACCESS 300u
#define STALL DG_MS(1)
#define SLOW DG_MS(20)
#define LINK DG_US(20)
#define LINES 8u

struct gpiod_chip {
    bool open;
};
struct gpiod_line {
    unsigned offset;
};

/* Settings, as they were at the beginning. */
struct setting {
    unsigned long lag;
    unsigned long access;
    unsigned long stall;
    unsigned long flicker;
    unsigned long deaf;
    unsigned long die;
    const char *spoil;
    const char *unpowered;
};

static struct {
    struct setting setting;
    dg_ns now;
    const struct dg_device *device; /* NULL: not made yet */
    struct dg_world world;
    dg_angle from;
    int64_t rpm;
    struct dg_biss_model biss_model;
    struct dg_biss biss;
    struct dg_ssi_model ssi_model;
    struct dg_ssi ssi;
    dg_ns deadline;
    int image;
    unsigned long written; /* how often */
    unsigned long accesses;
    unsigned long looks; /* at data */
    unsigned long edges;
    bool powered;
    bool clock;
    unsigned since; /* rising edges behind the start bit, or since the position was stored */
    bool cds;       /* of this frame */
    dg_ns moved;    /* the clock, at the latest */
    bool unlinked;
    bool data[2]; /* before the latest change, and behind it */
    dg_ns changed;
    struct gpiod_chip chip;
    struct gpiod_line lines[LINES];
} self = {.now = DG_S(100), .deadline = DG_NEVER};

/* --- settings --- */

static unsigned long figure_of(const char *name)
{
    const char *text = getenv(name);
    return text == NULL ? 0 : strtoul(text, NULL, 0);
}

static void read_settings(void)
{
    self.setting = (struct setting){
        .lag = figure_of("DOUBLE_LAG"),
        .access = figure_of("DOUBLE_ACCESS"),
        .stall = figure_of("DOUBLE_STALL"),
        .flicker = figure_of("DOUBLE_FLICKER"),
        .deaf = figure_of("DOUBLE_DEAF"),
        .die = figure_of("DOUBLE_DIE"),
        .spoil = getenv("DOUBLE_SPOIL"),
        .unpowered = getenv("DOUBLE_UNPOWERED"),
    };
}

static bool is_spoiled(const char *how)
{
    return self.setting.spoil != NULL && strcmp(self.setting.spoil, how) == 0;
}

static void give_up(const char *what)
{
    (void)fprintf(stderr, "gpiod_double: %s\n", what);
    _exit(99);
}

/* --- time --- */

int clock_gettime(clockid_t id, struct timespec *to)
{
    if (id != CLOCK_MONOTONIC) {
        return (int)syscall(SYS_clock_gettime, id, to);
    }
    self.now += COST;
    to->tv_sec = (time_t)(self.now / DG_S(1));
    to->tv_nsec = (long)(self.now % DG_S(1));
    return 0;
}

/* --- the EEPROM --- */

static int read_image(void *ctx, uint32_t address, void *to, size_t n)
{
    (void)ctx;
    return pread(self.image, to, n, (off_t)address) == (ssize_t)n ? DG_OK : DG_ERR_IO;
}

static int write_image(void *ctx, uint32_t address, const void *from, size_t n)
{
    (void)ctx;
    self.written++;
    if (self.written == self.setting.die) {
        (void)raise(SIGKILL);
    }
    return pwrite(self.image, from, n, (off_t)address) == (ssize_t)n ? DG_OK : DG_ERR_IO;
}

static int sync_image(void *ctx)
{
    (void)ctx;
    return DG_OK;
}

static struct dg_nvm open_image(void)
{
    static const struct dg_nvm_ops ops = {
        .read = read_image, .write = write_image, .sync = sync_image};
    const struct dg_nvm nvm = {.ops = &ops, .ctx = NULL};
    const char *path = getenv("DOUBLE_IMAGE");
    const off_t size = (off_t)dg_store_size(&dg_biss_layout);
    self.image = path == NULL ? memfd_create("image", MFD_CLOEXEC)
                              : open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    const bool fresh = self.image >= 0 && lseek(self.image, 0, SEEK_END) < size;
    if (self.image < 0 ||
        (fresh && (ftruncate(self.image, size) != 0 || dg_biss_format(nvm) != 0))) {
        give_up("no image");
    }
    self.written = 0;
    return nvm;
}

/* --- the encoder --- */

static dg_angle turn_shaft(void *ctx, dg_ns now)
{
    const int64_t per_turn = 60000000; /* us in a minute */
    const int64_t travel = self.rpm * (int64_t)(now / DG_US(1));
    (void)ctx;
    return self.from + travel / per_turn * DG_TURN + travel % per_turn * DG_TURN / per_turn;
}

static void make_biss(void)
{
    self.biss_model = *dg_biss_model_of(self.device);
    self.biss_model.device_id[1] ^= is_spoiled("register") ? 1u : 0u;
    self.biss_model.unidirectional = figure_of("DOUBLE_BARE") != 0;
    if (self.biss_model.unidirectional) {
        self.biss_model.life_counter = false;
        self.biss_model.busy = 0;
    }
    self.biss_model.timeout = self.setting.lag > 0 ? SLOW : 0;
    self.from = (dg_angle)figure_of("DOUBLE_COUNT") * (DG_TURN >> self.biss_model.singleturn_bits);
    const struct dg_biss_setup setup = {&self.biss_model, &self.world, open_image()};
    if (dg_biss_init(&self.biss, &setup) != 0) {
        give_up("no encoder");
    }
}

static void make_ssi(void)
{
    self.ssi_model = *dg_ssi_model_of(self.device);
    self.ssi_model.monoflop = self.setting.lag > 0 ? SLOW : self.ssi_model.monoflop;
    self.from = (dg_angle)figure_of("DOUBLE_COUNT") * (DG_TURN >> self.ssi_model.singleturn_bits);
    const struct dg_ssi_setup setup = {&self.ssi_model, &self.world};
    if (dg_ssi_init(&self.ssi, &setup) != 0) {
        give_up("no encoder");
    }
}

static bool is_biss(void)
{
    return self.device->stack == &dg_biss_stack;
}

static void switch_power(bool on)
{
    self.powered = on;
    if (is_biss()) {
        if (!on) {
            dg_biss_power_off(&self.biss);
        } else if (dg_biss_power_on(&self.biss, self.now) != 0) {
            give_up("the image is none of such an encoder");
        }
        self.deadline = dg_biss_step(&self.biss, self.now);
    } else {
        if (on) {
            dg_ssi_power_on(&self.ssi, self.now);
        } else {
            dg_ssi_power_off(&self.ssi);
        }
        self.deadline = dg_ssi_step(&self.ssi, self.now);
    }
}

static void make_encoder(void)
{
    const char *name = getenv("DOUBLE_MODEL");
    self.device = name == NULL ? NULL : dg_device_find(name);
    if (self.device == NULL) {
        give_up("no model");
    }
    read_settings();
    self.setting.access = self.setting.access > 0 ? self.setting.access : ACCESS;
    dg_world_init(&self.world);
    self.world.angle = turn_shaft;
    self.world.led_current_ua = is_spoiled("error") ? 40000 : self.world.led_current_ua;
    self.rpm = (int64_t)figure_of("DOUBLE_RPM");
    if (is_biss()) {
        make_biss();
    } else {
        make_ssi();
    }
    self.clock = true;
    switch_power(true);
    self.now += DG_S(1);
}

/* What the encoder does by itself up to now. */
static void let_time_pass(void)
{
    const unsigned long stall = self.setting.stall;
    self.accesses++;
    self.now += stall > 0 && self.accesses % stall == 0 ? STALL : self.setting.access;
    while (self.deadline <= self.now) {
        self.deadline = is_biss() ? dg_biss_step(&self.biss, self.deadline)
                                  : dg_ssi_step(&self.ssi, self.deadline);
    }
}

static void look_at_supply(void)
{
    const char *unpowered = self.setting.unpowered;
    const bool powered = unpowered == NULL || access(unpowered, F_OK) != 0;
    if (powered != self.powered) {
        switch_power(powered);
    }
}

/* Whoever cuts the supply waits afterwards. */
int nanosleep(const struct timespec *span, struct timespec *rest)
{
    (void)rest;
    if (self.device != NULL) {
        look_at_supply();
    }
    self.now += DG_S(span->tv_sec) + (dg_ns)span->tv_nsec;
    return 0;
}

/* --- what is wrong with it --- */

/* Of BiSS the last bit of the CRC, when the control data of the frame was 1. */
static bool spoil_crc(bool slo, bool rose)
{
    const unsigned last = 1u + dg_biss_frame_bits(&self.biss_model);
    if (rose) {
        self.since = self.biss.line.state == DG_BISS_CDS ? 0 : self.since + 1u;
        self.cds = self.since == 1 ? slo : self.cds;
    }
    return self.since == last && self.cds ? !slo : slo;
}

/* Of SSI the last bit of a word that comes again. */
static bool spoil_again(bool data)
{
    const unsigned bits = dg_ssi_word_bits(&self.ssi_model);
    const bool again = self.since > bits + 1u && (self.since - 1u) % (bits + 1u) == bits - 1u;
    return self.ssi.state == DG_SSI_SHIFT && again ? !data : data;
}

static bool data_of_encoder(bool rose)
{
    const bool level = is_biss() ? dg_biss_slo(&self.biss, false) : dg_ssi_data(&self.ssi);
    if (self.setting.deaf > 0 && self.edges >= self.setting.deaf) {
        return true;
    }
    if (self.unlinked) {
        return true;
    }
    if (is_biss()) {
        const bool spoiled = spoil_crc(level, rose);
        return is_spoiled("crc") ? spoiled : level;
    }
    return is_spoiled("again") ? spoil_again(level) : level;
}

/* One that is spoiled sees a pulse that the master has not made. */
static void move_ma(void)
{
    const bool returns = self.clock && self.biss.line.state == DG_BISS_RETURN;
    (void)dg_biss_ma(&self.biss, self.now, self.clock);
    if (returns && is_spoiled("return")) {
        (void)dg_biss_ma(&self.biss, self.now, false);
        (void)dg_biss_ma(&self.biss, self.now, true);
    }
}

/* An encoder that is lost sees no falling edge, so that no word begins. */
static void move_clock(void)
{
    const bool rested = self.now - self.moved > LINK;
    self.moved = self.now;
    if (is_spoiled("link") && rested) {
        self.unlinked = self.clock;
    }
    self.since = self.ssi.state == DG_SSI_IDLE ? 0 : self.since + (self.clock ? 1u : 0u);
    if (!self.unlinked || self.clock) {
        (void)dg_ssi_clock(&self.ssi, self.now, self.clock);
    }
}

/* Data as the master sees it: it comes late. */
static void note_data(bool rose)
{
    const bool level = data_of_encoder(rose);
    if (level != self.data[1]) {
        self.data[0] = self.data[1];
        self.data[1] = level;
        self.changed = self.now;
    }
}

/* --- libgpiod --- */

struct gpiod_chip *gpiod_chip_open(const char *path)
{
    (void)path;
    if (self.device == NULL) {
        make_encoder();
    }
    self.chip.open = true;
    return &self.chip;
}

void gpiod_chip_close(struct gpiod_chip *chip)
{
    const char *log = getenv("DOUBLE_LOG");
    FILE *to = log == NULL ? NULL : fopen(log, "we");
    chip->open = false;
    if (to != NULL) {
        (void)fprintf(
            to, "frames %lu\nreads %lu\nwrites %lu\ncommands %lu\nstored %lu\n",
            (unsigned long)(is_biss() ? self.biss.counters.frames : self.ssi.counters.frames),
            (unsigned long)self.biss.counters.reads, (unsigned long)self.biss.counters.writes,
            (unsigned long)self.biss.counters.commands, self.written);
        (void)fclose(to);
    }
}

unsigned int gpiod_chip_num_lines(struct gpiod_chip *chip)
{
    (void)chip;
    return LINES;
}

struct gpiod_line *gpiod_chip_get_line(struct gpiod_chip *chip, unsigned int offset)
{
    (void)chip;
    self.lines[offset].offset = offset;
    return &self.lines[offset];
}

int gpiod_line_request_output(struct gpiod_line *line, const char *consumer, int level)
{
    (void)consumer;
    return gpiod_line_set_value(line, level);
}

int gpiod_line_request_input(struct gpiod_line *line, const char *consumer)
{
    (void)line;
    (void)consumer;
    return 0;
}

int gpiod_line_set_value(struct gpiod_line *line, int level)
{
    (void)line;
    let_time_pass();
    note_data(false);
    if ((level != 0) == self.clock) {
        return 0;
    }
    self.clock = level != 0;
    self.edges++;
    if (is_biss()) {
        move_ma();
        self.deadline = dg_biss_step(&self.biss, self.now);
    } else {
        move_clock();
        self.deadline = dg_ssi_step(&self.ssi, self.now);
    }
    note_data(self.clock);
    return 0;
}

int gpiod_line_get_value(struct gpiod_line *line)
{
    const unsigned long flicker = self.setting.flicker;
    (void)line;
    let_time_pass();
    note_data(false);
    self.looks++;
    const bool level = self.data[self.now >= self.changed + self.setting.lag ? 1 : 0];
    return flicker > 0 && self.looks % flicker == 0 ? !level : level;
}
