/* SPDX-License-Identifier: MIT */
/*
 * Random operations on TPDOs against a model of the rules (CiA 301; C4).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "pdo_rig.h"

/* A TPDO, looked at in ticks of 1 ms. TPDO1 and TPDO2 carry the value; 3 and 4 are not valid. */
struct model {
    bool valid;
    uint8_t type;
    uint32_t syncs; /* since the phase began */
    bool event;
    bool sent_any; /* since the phase began */
    uint32_t sent_value;
    bool has_sync_sample;
    uint32_t sync_sample;
    uint32_t event_ms;
    uint32_t timer_from;
    bool timer_ran_out;
    uint32_t inhibit_ms;
    uint32_t inhibit_from; /* last event transmission, or far in the past */
};

static struct {
    struct model tpdo[2];
    bool operational;
    uint32_t ms;
    uint32_t value;
    uint32_t count;
    struct {
        uint32_t id;
        uint32_t value;
        uint32_t ms;
    } sent[PDO_RIG_FRAMES];
} model;

static uint32_t random_state;

static uint32_t random_below(uint32_t n)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (random_state >> 8) % n;
}

static void model_frame(uint8_t n, uint32_t value)
{
    assert_true(model.count < PDO_RIG_FRAMES);
    model.sent[model.count].id = n == 0 ? TPDO1 : TPDO2;
    model.sent[model.count].value = value;
    model.sent[model.count].ms = model.ms;
    model.count++;
}

static void model_send(uint8_t n)
{
    struct model *tpdo = &model.tpdo[n];

    model_frame(n, model.value);
    tpdo->sent_any = tpdo->type != 252;
    tpdo->sent_value = model.value;
    tpdo->timer_from = model.ms;
    tpdo->timer_ran_out = false;
}

static void model_phase(uint8_t n)
{
    struct model *tpdo = &model.tpdo[n];

    tpdo->syncs = 0;
    tpdo->event = false;
    tpdo->sent_any = false;
    tpdo->has_sync_sample = false;
    tpdo->timer_from = model.ms;
    tpdo->timer_ran_out = false;
}

/* Sends what waits and may go. */
static void model_events(void)
{
    for (uint8_t n = 0; n < 2; n++) {
        struct model *tpdo = &model.tpdo[n];
        if (!model.operational || !tpdo->valid || tpdo->type < 254) {
            continue;
        }
        if (tpdo->event_ms != 0 && !tpdo->timer_ran_out &&
            model.ms >= tpdo->timer_from + tpdo->event_ms) {
            tpdo->timer_ran_out = true;
            tpdo->event = true;
        }
        if (tpdo->event && model.ms >= tpdo->inhibit_from + tpdo->inhibit_ms) {
            tpdo->event = false;
            model_send(n);
            tpdo->inhibit_from = model.ms;
        }
    }
}

static void do_sync(void)
{
    pdo_sync();
    for (uint8_t n = 0; n < 2; n++) {
        struct model *tpdo = &model.tpdo[n];
        if (!model.operational || !tpdo->valid) {
            continue;
        }
        tpdo->syncs++;
        if (tpdo->type == 252) {
            tpdo->has_sync_sample = true;
            tpdo->sync_sample = model.value;
        } else if (tpdo->type == 0 ? tpdo->event
                                   : tpdo->type <= 240 && tpdo->syncs % tpdo->type == 0) {
            tpdo->event = false;
            model_send(n);
        }
    }
}

static void do_request(void)
{
    uint8_t n = (uint8_t)random_below(2);
    struct model *tpdo = &model.tpdo[n];

    pdo_request(n == 0 ? TPDO1 : TPDO2);
    if (!model.operational || !tpdo->valid) {
        return;
    }
    if (tpdo->type == 252 && tpdo->has_sync_sample) {
        model_frame(n, tpdo->sync_sample);
    } else {
        model_send(n);
    }
}

static void do_change(void)
{
    model.value += random_below(2);
    pdo_change(model.value);
    for (uint8_t n = 0; n < 2; n++) {
        struct model *tpdo = &model.tpdo[n];
        bool takes = tpdo->type == 0 || tpdo->type >= 254;
        if (model.operational && tpdo->valid && takes) {
            tpdo->event = tpdo->event || !tpdo->sent_any || tpdo->sent_value != model.value;
        }
    }
}

static void do_type(void)
{
    static const uint8_t types[] = {0, 1, 2, 3, 7, 252, 253, 254, 255, 255};
    uint8_t n = (uint8_t)random_below(2);
    uint8_t type = types[random_below(sizeof types)];
    bool waits = model.tpdo[n].event && (type == 0 || type >= 254);

    pdo_put_type(n, type);
    model.tpdo[n].type = type;
    model_phase(n);
    model.tpdo[n].event = waits;
}

static void do_event_timer(void)
{
    uint8_t n = (uint8_t)random_below(2);
    uint32_t ms = random_below(2) * random_below(12);

    pdo_put_ok((uint16_t)(0x1800 + n), 5, ms, 2);
    model.tpdo[n].event_ms = ms;
    model.tpdo[n].timer_from = model.ms;
    model.tpdo[n].timer_ran_out = false;
}

static void do_nmt(void)
{
    static const uint8_t commands[] = {START, START, START, START, START, PRE_OPERATIONAL};
    uint8_t command = commands[random_below(sizeof commands)];
    bool entered = command == START && !model.operational;

    pdo_nmt(command);
    model.operational = command == START;
    for (uint8_t n = 0; n < 2 && (entered || !model.operational); n++) {
        model_phase(n);
        model.tpdo[n].event = entered && (model.tpdo[n].type == 0 || model.tpdo[n].type >= 254);
    }
}

/* Off, another inhibit time, on again; or only one of them. */
static void do_validity(void)
{
    uint8_t n = (uint8_t)random_below(2);
    uint32_t ms = random_below(2) * random_below(15);

    pdo_disable(n);
    model.tpdo[n].valid = false;
    pdo_put_ok((uint16_t)(0x1800 + n), 3, ms * 10, 2);
    if (random_below(8) != 0) {
        pdo_enable(n);
        model.tpdo[n].valid = true;
        model.tpdo[n].inhibit_ms = ms;
        model.tpdo[n].inhibit_from = 0;
        model_phase(n);
    }
}

static void do_wait(void)
{
    uint32_t span = random_below(9);

    pdo_run_ms(span);
    while (span-- > 0) {
        model.ms++;
        model_events();
    }
}

static void compare(uint32_t seed, uint32_t step)
{
    bool same = pdo_rig.count == model.count;

    for (uint32_t i = 0; same && i < model.count; i++) {
        same = pdo_rig.sent[i].frame.id == model.sent[i].id && pdo_rig.sent[i].frame.dlc == 4 &&
               dg_load_le32(pdo_rig.sent[i].frame.data) == model.sent[i].value &&
               pdo_rig.sent[i].at == DG_S(1) + DG_MS(model.sent[i].ms);
    }
    if (!same) {
        fail_msg("seed %u, step %u: %u frames, expected %u", seed, step, pdo_rig.count,
                 model.count);
    }
    pdo_forget();
    model.count = 0;
}

static void random_operations_as_the_model_says(void **state)
{
    static void (*const operations[])(void) = {
        do_sync, do_sync,        do_sync, do_request,  do_change, do_change,
        do_type, do_event_timer, do_nmt,  do_validity, do_wait,   do_wait,
    };
    uint32_t frames = 0;

    for (uint32_t seed = 1; seed <= 200; seed++) {
        assert_int_equal(pdo_set_up(state), 0);
        random_state = seed;
        memset(&model, 0, sizeof model);
        model.ms = 1000; /* so that an inhibit time from 0 is over */
        pdo_rig.now = DG_S(1) + DG_MS(model.ms);
        model.value = pdo_rig.live;
        model.tpdo[0] = (struct model){.valid = true, .type = 255};
        model.tpdo[1] = (struct model){.valid = true, .type = 1};
        pdo_disable(2);
        pdo_disable(3);
        for (uint32_t step = 0; step < 300; step++) {
            operations[random_below(DG_COUNT(operations))]();
            model_events();
            frames += model.count;
            compare(seed, step);
        }
    }
    assert_true(frames > 10000);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(random_operations_as_the_model_says, pdo_set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
