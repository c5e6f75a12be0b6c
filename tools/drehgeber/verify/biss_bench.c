/* SPDX-License-Identifier: MIT */
/* Slaves, shaft, world and lines of the BiSS steps, and the steps that set them up. */
#include "biss_bench.h"

#include <stdlib.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "row_figures.h"

/* --- figures by name ----------------------------------------------------------------------- */

/* clang-format off */
#define MODEL(field, kind) CF_FIGURE(#field, dg_biss_model, field, kind)
static const struct cf_figure model_figures[] = {
    CF_FIGURE("mt",       dg_biss_model, multiturn_bits,  U8),
    CF_FIGURE("st",       dg_biss_model, singleturn_bits, U8),
    CF_FIGURE("lc",       dg_biss_model, life_counter,    BOOL),
    CF_FIGURE("revision", dg_biss_model, device_id[5],    U8),
    CF_FIGURE("series",   dg_biss_model, device_id,       U8),
    CF_FIGURE("busy_us",  dg_biss_model, busy,            US),
    CF_FIGURE("jitter_us", dg_biss_model, busy_jitter,   US),
    CF_FIGURE("early",    dg_biss_model, stop_bit_early,  BOOL),
    CF_FIGURE("read_us",  dg_biss_model, eeprom_read,     US),
    CF_FIGURE("write_us", dg_biss_model, eeprom_write,    US),
    CF_FIGURE("init_us",  dg_biss_model, init,            US),
    MODEL(autostore, BOOL), MODEL(sl_low_at_start, BOOL), MODEL(serial, U32), {NULL, 0, 0, CF_U8},
};
/* clang-format on */

/* "5ms", "300us", "100ns"; 0 when it is none of them, or NULL */
dg_ns biss_bench_span(const char *word)
{
    char *unit;

    if (word == NULL) {
        return 0;
    }
    unsigned long n = strtoul(word, &unit, 10);
    if (strcmp(unit, "ms") == 0) {
        return DG_MS(n);
    }
    if (strcmp(unit, "us") == 0) {
        return DG_US(n);
    }
    return strcmp(unit, "ns") == 0 ? n : 0;
}

/* --- shaft and lines ----------------------------------------------------------------------- */

/* Exact to 100 ns: rpm * t is split in whole turns and a rest whose product fits 64 bits. */
dg_angle biss_bench_angle(void *ctx, dg_ns now)
{
    const struct biss_bench *b = ctx;
    const int64_t per_turn = 600000000; /* 100 ns in a minute */
    int64_t travel = b->rpm * (int64_t)(dg_elapsed(now, b->since) / 100u);

    return b->from + travel / per_turn * DG_TURN + travel % per_turn * DG_TURN / per_turn;
}

static bool line_sl(void *ctx, dg_ns now)
{
    struct biss_bench *b = ctx;

    if (b->deadline <= now) {
        b->deadline = dg_biss_chain_step(&b->chain, b->deadline);
    }
    return dg_biss_chain_slo(&b->chain);
}

static bool line_ma(void *ctx, dg_ns now, bool level)
{
    struct biss_bench *b = ctx;
    bool sl;

    (void)line_sl(b, now);
    sl = dg_biss_chain_ma(&b->chain, now, level);
    b->deadline = dg_biss_chain_step(&b->chain, now);
    return sl;
}

void biss_bench_wait(struct biss_bench *b, dg_ns wait)
{
    b->master.now += wait;
    b->master.sl = line_sl(b, b->master.now);
}

/* --- given, shaft, world, power ------------------------------------------------------------ */

static bool start_slaves(struct biss_bench *b, bool init_over, struct cf_report *report)
{
    dg_ns init = 0;

    for (size_t i = 0; i < b->chain.count; i++) {
        int result = dg_biss_power_on(&b->slaves[i].device, b->master.now);

        if (result != 0) {
            return cf_fail(report, "power on returned %d", result);
        }
        init = b->slaves[i].model.init > init ? b->slaves[i].model.init : init;
    }
    b->deadline = dg_biss_chain_step(&b->chain, b->master.now);
    b->master.fresh = true;
    /* The break of 40 us that 5.2.1.1 asks for. */
    biss_bench_wait(b, DG_US(40) + (init_over ? init : 0));
    return true;
}

/* Whether an encoder in place of the one that a row names has this figure. Its serial number is a
   matter of the row. */
static bool has_figure(const struct dg_biss_model *own, const struct dg_biss_model *said,
                       const char *word)
{
    const struct cf_figure *figure = cf_find_figure(model_figures, word, strcspn(word, "="));

    return figure->offset == offsetof(struct dg_biss_model, serial) ||
           memcmp((const uint8_t *)own + figure->offset, (const uint8_t *)said + figure->offset,
                  figure->size) == 0;
}

/* What the words behind the model say of it. */
static bool take_biss_figures(struct dg_biss_model *model, char **words, size_t n,
                              struct cf_report *report)
{
    const struct cf_biss_trial *trial = biss_trial();

    if (trial->model != NULL) {
        *model = *trial->model;
    }
    for (size_t i = 2; i < n; i++) {
        if (strcmp(words[i], "window") == 0) {
            continue;
        }
        if (!cf_set_figure(model_figures, model, words[i])) {
            return cf_fail(report, "no such figure: %s", words[i]);
        }
        if (trial->model != NULL && !has_figure(trial->model, model, words[i])) {
            return cf_fail(report, "about other figures: %s", words[i]);
        }
    }
    model->serial = trial->model != NULL && trial->placed ? trial->model->serial : model->serial;
    return true;
}

/* Adds a slave behind those that are there: farther from the master. */
static bool add_slave(struct biss_bench *b, char **words, size_t n, struct cf_report *report)
{
    const struct dg_device *device = n > 1 ? dg_device_find(words[1]) : NULL;
    struct biss_slave *slave = &b->slaves[b->chain.count];
    struct dg_biss_setup setup = {&slave->model, &b->world, {NULL, NULL}};
    struct biss_channel *channel = &b->master.channels[b->chain.count];

    if (device == NULL || device->stack != &dg_biss_stack || b->chain.count == BISS_SLAVES_MAX) {
        return cf_fail(report, "no such model, or too many slaves");
    }
    slave->model = *dg_biss_model_of(device);
    if (!take_biss_figures(&slave->model, words, n, report)) {
        return false;
    }
    cf_memory_init(&slave->nvm, dg_store_size(&dg_biss_layout));
    setup.nvm = cf_memory_port(&slave->nvm);
    if (dg_biss_format(setup.nvm) != 0 || dg_biss_init(&slave->device, &setup) != 0) {
        return cf_fail(report, "these figures are refused");
    }
    *channel = (struct biss_channel){slave->model.multiturn_bits, slave->model.singleturn_bits,
                                     slave->model.life_counter ? 6 : 0};
    b->chain.slave[b->chain.count] = &slave->device;
    b->chain.count++;
    b->master.channel_count = b->chain.count;
    return true;
}

/* A real encoder has had zeros before the row begins: it would take the next CDM for a start bit. */
static void clock_zeros(struct biss_bench *b)
{
    for (unsigned i = 0; biss_trial()->placed && i < DG_BISS_ZEROS; i++) {
        struct biss_frame frame;

        biss_master_frame(&b->master, &frame, false);
    }
}

/* given MODEL figure=value... [window] */
bool biss_bench_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    bool window = n > 1 && strcmp(words[n - 1], "window") == 0;

    if (!biss_need(window ? CF_EXACT : 0u, report) || !add_slave(b, words, n, report)) {
        return false;
    }
    if (biss_trial()->placed) {
        b->from = biss_trial()->raw * (DG_TURN >> b->slaves[0].model.singleturn_bits);
    }
    if (!start_slaves(b, !window, report)) {
        return false;
    }
    clock_zeros(b);
    return true;
}

/* behind MODEL figure=value...: all power up anew */
bool biss_bench_behind(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    return add_slave(b, words, n, report) && start_slaves(b, true, report);
}

bool biss_bench_power(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    const bool on = n > 1 && strcmp(words[1], "on") == 0;

    if (!biss_need(n > 2 ? CF_EXACT : 0u, report) || !biss_power_beside(on, report)) {
        return false;
    }
    if (on) {
        return start_slaves(b, n == 2, report);
    }
    for (size_t i = 0; i < b->chain.count; i++) {
        dg_biss_power_off(&b->slaves[i].device);
    }
    b->deadline = DG_NEVER;
    biss_bench_wait(b, DG_MS(10));
    return true;
}

/* pos N: counts of the first slave, multiturn and singleturn. A real shaft is where it is, which is as
   good a place as that of a row; but it is not turned. */
bool biss_bench_pos(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    if (n != 2) {
        return cf_fail(report, "pos N");
    }
    if (!biss_need(b->asked || b->turned ? CF_SHAFT : 0u, report)) {
        return false;
    }
    b->turned = true;
    if (biss_trial()->placed) {
        return true;
    }
    b->from = strtoll(words[1], NULL, 0) * (DG_TURN >> b->slaves[0].model.singleturn_bits);
    b->since = b->master.now;
    b->rpm = 0;
    return true;
}

bool biss_bench_rpm(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    b->from = biss_bench_angle(b, b->master.now);
    b->since = b->master.now;
    b->rpm = n == 2 ? strtoll(words[1], NULL, 0) : 0;
    return n == 2 || cf_fail(report, "rpm N");
}

bool biss_bench_world(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    for (size_t i = 1; i < n; i++) {
        if (!cf_set_figure(cf_world_figures, &b->world, words[i])) {
            return cf_fail(report, "world: no such quantity: %s", words[i]);
        }
    }
    return true;
}

bool biss_bench_after(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    dg_ns wait = n == 2 ? biss_bench_span(words[1]) : 0;

    return wait > 0 ? biss_wait_beside(b, wait, report)
                    : cf_fail(report, "wait 5ms, 300us or 100ns");
}

/* damage REGION OFFSET: a bit that changes by itself */
bool biss_bench_damage(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    int region = n == 3 ? dg_store_find(&dg_biss_layout, words[1]) : -1;
    unsigned long offset = n == 3 ? strtoul(words[2], NULL, 0) : 0;
    struct cf_memory *nvm = &b->slaves[0].nvm;

    if (region < 0 || offset >= dg_biss_layout.regions[region].size) {
        return cf_fail(report, "damage REGION OFFSET");
    }
    offset += dg_store_address(&dg_biss_layout, (uint8_t)region);
    nvm->bytes[offset] ^= 1u;
    return true;
}

/* --- the master's settings ----------------------------------------------------------------- */

/* A real master goes on as it does; a stray CDM bit is one of an access. */
static bool need_master(char **words, size_t n, struct cf_report *report)
{
    const bool stray = n == 2 && strcmp(words[1], "stray") == 0;
    return biss_need(stray ? 0u : CF_EXACT, report);
}

/* master period=100ns jitter=25 extra=3 stray channels=0 disturbed=3 first */
bool biss_bench_master(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    if (!need_master(words, n, report)) {
        return false;
    }
    for (size_t i = 1; i < n; i++) {
        const char *value = strchr(words[i], '=');
        unsigned long figure = value != NULL ? strtoul(value + 1, NULL, 10) : 0;

        if (strncmp(words[i], "period=", 7) == 0) {
            b->master.period_ns = biss_bench_span(value + 1);
        } else if (strncmp(words[i], "jitter=", 7) == 0) {
            b->master.jitter_percent = (unsigned)figure;
        } else if (strncmp(words[i], "extra=", 6) == 0) {
            b->master.extra_clocks = (unsigned)figure;
        } else if (strncmp(words[i], "disturbed=", 10) == 0) {
            b->master.disturbed = (unsigned)figure;
        } else if (strncmp(words[i], "channels=", 9) == 0) {
            b->master.channel_count = figure;
        } else if (strcmp(words[i], "stray") == 0) {
            b->master.stray = true;
        } else if (strcmp(words[i], "first") == 0) {
            b->master.fresh = true;
        } else {
            return cf_fail(report, "master: no such setting: %s", words[i]);
        }
    }
    return b->master.period_ns > 0 || cf_fail(report, "master: no such period");
}

void biss_bench_begin(struct biss_bench *b)
{
    const struct biss_line line = {line_ma, line_sl, b};

    memset(b, 0, sizeof *b);
    b->deadline = DG_NEVER;
    biss_master_init(&b->master, line, DG_S(1));
    if (biss_trial()->period_ns > 0) {
        b->master.period_ns = biss_trial()->period_ns;
    }
    if (biss_trial()->timeout_max > 0) {
        b->master.timeout_max = biss_trial()->timeout_max;
    }
    dg_world_init(&b->world);
    b->world.angle = biss_bench_angle;
    b->world.angle_ctx = b;
}
