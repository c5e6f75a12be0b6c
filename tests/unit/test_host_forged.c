/* SPDX-License-Identifier: MIT */
/*
 * States that somebody has made: bytes of a saved one are changed, its check sum is made right. It
 * is refused and changes nothing, or the encoder lives with it: no index leaves its table (the
 * sanitizers see it) and time goes on (an alarm sees it).
 */
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/crc.h"
#include "effort.h"
#include "host_rig.h"

#define STATES 250
#define STATES_THOROUGH 2000
/* Nothing here takes a second; a machine under load may make it some. */
#define PATIENCE_S 30
#define SUM_SIZE sizeof(uint32_t)

static uint8_t healthy[HOST_RIG_MEMORY_MAX];
static uint8_t forged[HOST_RIG_MEMORY_MAX];
static uint8_t before[HOST_RIG_MEMORY_MAX];
static struct host_rig_place panel_place;
static uint32_t noise;
static char doing[96];

static void on_alarm(int signal_number)
{
    (void)signal_number;
    (void)!write(STDERR_FILENO, "time stands: ", 13);
    (void)!write(STDERR_FILENO, doing, strlen(doing));
    (void)!write(STDERR_FILENO, "\n", 1);
    _exit(1);
}

/* xorshift32: the same states in every run. */
static uint32_t any(uint32_t below)
{
    noise ^= noise << 13;
    noise ^= noise >> 17;
    noise ^= noise << 5;
    return noise % below;
}

/* What a field may hold that nobody meant: one bit, ends of ranges, a moment far away, noise. */
static void change(uint8_t *at, size_t n)
{
    static const uint8_t ends[] = {0x00, 0x01, 0x02, 0x7F, 0x80, 0xFE, 0xFF};
    const uint32_t how = any(4);
    const uint8_t end = ends[any(sizeof ends)];

    for (size_t i = 0; i < n; i++) {
        if (how == 0) {
            at[i] = end;
        } else if (how == 1) {
            at[i] = (uint8_t)any(256);
        } else if (how == 2) {
            at[i] = i == 0 ? end : 0;
        } else {
            at[i] = (uint8_t)(at[i] ^ (i == 0 ? 1u << any(8) : 0u));
        }
    }
}

/* The sum is the last number of the header, and of all behind it. */
static void sign(uint8_t *state, size_t n, size_t body)
{
    const uint32_t sum = dg_crc32(0, state + (n - body), body);

    memcpy(state + (n - body) - SUM_SIZE, &sum, SUM_SIZE);
}

/* Queues and EEPROM are most of a state: the handle before them, and settings and device between
 * them, get most of the changes. */
static uint32_t pick_offset(const struct dg_host *self, uint32_t body)
{
    const uint32_t memory = ((uint32_t)dg_host_memory_size(self) + 15u) & ~15u;
    const uint32_t device = 64u << any(6);

    switch (any(4)) {
    case 0:
        return any(body);
    case 1:
        return any(320);
    default:
        return body - memory - 1u - any(device < 1400 ? device : 1400);
    }
}

static void forge(const struct dg_host *self, size_t n, size_t body)
{
    memcpy(forged, healthy, n);
    for (uint32_t changes = 1 + any(3); changes > 0; changes--) {
        const uint32_t width = 1u << any(4);
        const size_t at = n - body + pick_offset(self, (uint32_t)body) / width * width;
        change(forged + at, at + width <= n ? width : n - at);
    }
    sign(forged, n, body);
}

static void send_event(struct dg_host *self, const struct dg_host_event *event)
{
    (void)dg_host_send(self, event);
}

/* Requests of every wire; those of others are refused. */
static void speak(struct dg_host *self, uint64_t now)
{
    static const uint8_t requests[][3] = {
        {0x40, 0x42, 0x02}, {0x40, 0x50, 0x10}, {0x40, 0x52, 0x12}, {0x40, 0x53, 0x13}};
    static const uint8_t objects[][4] = {
        {0x40, 0x04, 0x60, 0}, {0x40, 0x08, 0x10, 0}, {0x40, 0x30, 0x60, 1}, {0x60, 0, 0, 0}};
    static const uint32_t words[] = {0, 0x8000, 0x20210000, 0x22210005, 0x60000000};
    struct dg_host_frame frame;
    uint8_t bytes[8] = {0};

    for (uint8_t i = 0; i < 4; i++) {
        struct dg_host_event event = {.at = now + i * 50 * MS, .kind = DG_HOST_BYTES, .length = 3};
        memcpy(event.data, requests[i], 3);
        send_event(self, &event);
        event = (struct dg_host_event){
            .at = now + (1u + i) * MS, .kind = DG_HOST_CAN, .id = 0x63F, .length = 8};
        memcpy(event.data, objects[i], 4);
        send_event(self, &event);
    }
    send_event(self, &(struct dg_host_event){
                         .at = now + 6 * MS, .kind = DG_HOST_CAN, .length = 2, .data = {1}});
    send_event(self, &(struct dg_host_event){.at = now + 7 * MS, .kind = DG_HOST_CAN, .id = 0x80});
    for (uint8_t i = 0; i < 5; i++) {
        send_event(self, &(struct dg_host_event){
                             .at = now + i * MS, .kind = DG_HOST_WORDS, .id = words[i]});
    }
    send_event(self, &(struct dg_host_event){
                         .at = now + 9 * MS, .kind = DG_HOST_WORDS, .flags = DG_HOST_IDENTIFY});
    for (uint8_t i = 0; i < 120; i++) {
        (void)dg_host_clock(self, now + i * UINT64_C(500), i % 2u == 0);
    }
    now += MS;
    for (uint8_t i = 0; i < 3; i++) {
        (void)dg_host_frame(self, now, &frame);
        now += MS;
        (void)dg_host_registers_read(self, &now, (uint8_t)(0x30u * i), bytes, 4);
    }
    (void)dg_host_registers_write(self, &now, 0x23, bytes, 1);
}

static void look_at_all(struct dg_host *self, uint64_t now)
{
    struct dg_host_uart uart;
    uint16_t ids[DG_HOST_FILTERS];
    uint64_t counts;
    uint64_t at;
    int32_t uv[4];
    char text[64];
    struct dg_host_key key;

    (void)dg_host_position(self, now, &counts);
    (void)dg_host_latched(self, &at, &counts);
    (void)dg_host_sincos(self, now, uv);
    (void)dg_host_uart(self, &uart);
    (void)dg_host_bit_rate(self);
    (void)dg_host_filters(self, ids);
    for (size_t i = 0; dg_host_key(self, i, &key) == DG_HOST_OK; i++) {
        (void)dg_host_get(self, key.name, text, sizeof text);
    }
    host_rig_drain(self);
}

static void ask(struct dg_host *self, uint64_t now)
{
    static const char *const lines[] = {"*IDN?",     "STATe?",        "SHAFt:ANGLe 90DEG",
                                        "NVM:DATA?", "POWer CYCLe",   "WORLd:TEMPerature 90",
                                        "STATe?",    "FAULt:CATalog?"};
    static char answer[4096];
    struct dg_host_panel *panel = dg_host_panel_make(&panel_place, sizeof panel_place, self);

    for (size_t i = 0; panel != NULL && i < DG_COUNT(lines); i++) {
        (void)dg_host_scpi(panel, now, lines[i], answer, sizeof answer);
        (void)dg_host_panel_step(panel, now + i * MS);
    }
    dg_host_shaft_of(self, NULL);
    (void)dg_host_share(self, NULL);
}

static void live(struct dg_host *self)
{
    uint64_t now = 2 * SECOND;

    look_at_all(self, now);
    (void)dg_host_step(self, now);
    speak(self, now);
    for (unsigned i = 0; i < 20; i++) {
        now += 20 * MS;
        dg_host_shaft(self, now, (int64_t)i << 40, INT64_C(1) << 36);
        (void)dg_host_step(self, now);
        look_at_all(self, now);
    }
    ask(self, now);
    (void)dg_host_power(self, now + SECOND, false);
    (void)dg_host_power(self, now + 2 * SECOND, true);
    now += 3 * SECOND;
    (void)dg_host_step(self, now);
    speak(self, now);
    (void)dg_host_step(self, now + SECOND);
    look_at_all(self, now + SECOND);
    (void)dg_host_save(self, before, sizeof before);
}

/* In the middle of what its wire does. */
static size_t saved(const char *name, uint32_t moment)
{
    struct dg_host *self = host_rig_start(&host_rig_here, name);
    uint64_t now = READY;

    dg_host_shaft(self, now, 0, INT64_C(3) << 32);
    speak(self, now);
    (void)dg_host_step(self, now + moment * MS);
    for (uint32_t i = 0; i < moment; i++) {
        (void)dg_host_clock(self, now + SECOND / 2 + i * UINT64_C(500), i % 2u != 0);
    }
    assert_true(dg_host_state_size(self) <= sizeof healthy);
    assert_int_equal(dg_host_save(self, healthy, sizeof healthy), DG_HOST_OK);
    return dg_host_state_size(self);
}

static void one(const char *name, uint32_t number, unsigned taken[2])
{
    const size_t n = saved(name, number % 40u);
    const size_t body = dg_host_size_of(name);
    struct dg_host *self = host_rig_start(&host_rig_there, name);

    (void)snprintf(doing, sizeof doing, "state %u of %s", (unsigned)number, name);
    noise = UINT32_C(0x9E3779B9) * (number + 1u);
    forge(self, n, body);
    assert_int_equal(dg_host_save(self, before, sizeof before), DG_HOST_OK);
    (void)alarm(PATIENCE_S);
    const int result = dg_host_restore(self, forged, n);
    taken[result == DG_HOST_OK]++;
    if (result == DG_HOST_OK) {
        live(self);
    } else {
        assert_int_equal(result, DG_HOST_ERR_DAMAGED);
        assert_int_equal(dg_host_save(self, healthy, sizeof healthy), DG_HOST_OK);
        assert_memory_equal(healthy, before, n);
    }
    (void)alarm(0);
}

static void forged_states_do_no_harm(void **state)
{
    const uint32_t count = effort(STATES, STATES_THOROUGH);

    (void)state;
    (void)signal(SIGALRM, on_alarm);
    for (size_t i = 0; i < host_rig_model_count; i++) {
        unsigned taken[2] = {0, 0};
        for (uint32_t number = 0; number < count; number++) {
            one(host_rig_models[i].name, number, taken);
        }
        print_message("%s: %u taken, %u refused\n", host_rig_models[i].name, taken[1], taken[0]);
        assert_true(taken[0] > 0 && taken[1] > 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(forged_states_do_no_harm)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
