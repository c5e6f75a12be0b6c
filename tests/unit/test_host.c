/* SPDX-License-Identifier: MIT */
/*
 * Every model behind its handle, with nothing but host.h: what a binding of another language sees.
 * What the encoders have to say to it stands here in bytes, as the manuals and standards have it.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "host_rig.h"

/* ------------------------------------------------------------ each model on its wire */

/* What `self` says to the request of its kind, put together to one text of bytes. */
struct heard {
    size_t n;
    uint8_t bytes[256];
};

static void collect(struct dg_host *self, struct heard *heard)
{
    struct dg_host_event event;

    heard->n = 0;
    while (dg_host_receive(self, &event) > 0) {
        assert_true(heard->n + event.length <= sizeof heard->bytes);
        memcpy(heard->bytes + heard->n, event.data, event.length);
        heard->n += event.length;
    }
}

static void sends(struct dg_host *self, struct dg_host_event event, uint64_t until,
                  struct heard *heard)
{
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, until);
    collect(self, heard);
}

#define ASSERT_HEARD(heard, ...)                                                                   \
    do {                                                                                           \
        const uint8_t want[] = {__VA_ARGS__};                                                      \
        assert_int_equal((heard).n, sizeof want);                                                  \
        assert_memory_equal((heard).bytes, want, sizeof want);                                     \
    } while (0)

static uint8_t xor8(const uint8_t *bytes, size_t n)
{
    uint8_t sum = 0;

    while (n-- > 0) {
        sum ^= *bytes++;
    }
    return sum;
}

/* 42h of address 40h: position in steps of 1/65536 turn, most significant byte first. */
static void check_hiperface(const struct host_rig_model *row)
{
    const uint32_t position = (uint32_t)row->position;
    struct dg_host *self = host_rig_start(&host_rig_here, row->name);
    const struct dg_host_event request = {
        .at = READY + MS, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x42, 0x02}};
    struct dg_host_event event;
    struct dg_host_uart uart;
    int32_t uv[4];
    uint8_t reply[] = {0x40,
                       0x42,
                       (uint8_t)(position >> 24),
                       (uint8_t)(position >> 16),
                       (uint8_t)(position >> 8),
                       (uint8_t)position,
                       0};

    reply[6] = xor8(reply, 6);
    host_rig_drain(self);
    assert_int_equal(dg_host_uart(self, &uart), DG_HOST_OK);
    assert_int_equal(uart.baud, 9600);
    assert_int_equal(uart.parity, 'E');
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, READY + 100 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.kind, DG_HOST_BYTES);
    assert_int_equal(event.length, sizeof reply);
    assert_memory_equal(event.data, reply, sizeof reply);
    /* 3 characters, 44 bit times of silence, 1 ms reaction; 11 bits a character. */
    assert_int_equal(event.id, 1145834);
    assert_in_range(event.at, READY + MS + 8 * MS, READY + MS + 10 * MS);
    assert_int_equal(dg_host_receive(self, &event), 0);
    /* A quarter of a turn is 512 whole periods: sin 0, cos at its peak. */
    assert_int_equal(dg_host_sincos(self, READY, uv), DG_HOST_OK);
    assert_int_equal(uv[0], uv[1]);
    assert_true(uv[2] > uv[3]);
}

/* 11 bits with parity, 10 without; rounded up. */
static void characters_take_their_bits(void **state)
{
    static const struct {
        struct dg_host_uart uart;
        uint32_t count;
        uint64_t ns;
    } rows[] = {
        {{.baud = 9600, .parity = 'E'}, 1, 1145834},
        {{.baud = 9600, .parity = 'O'}, 16, 18333334},
        {{.baud = 38400, .parity = 'N'}, 1, 260417},
        {{.baud = 38400, .parity = 'N'}, 5000, 1302083334},
        {{.baud = 600, .parity = 'E'}, 0, 0},
        {{.baud = 0, .parity = 'E'}, 1, DG_HOST_NEVER},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_int_equal(dg_host_uart_ns(&rows[i].uart, rows[i].count), rows[i].ns);
    }
}

/* Half duplex: an encoder is deaf as long as its reply lasts, 8 ms of 7 characters; but none of a
   reply is left when its power is gone. */
static void a_reply_ends_with_the_power(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "s3684-rs485");
    struct dg_host_event request = {
        .at = MS, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x42, 0x02}};
    struct dg_host_event event;

    (void)state;
    assert_int_equal(dg_host_set(self, "init_ms", "0"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, 12 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_true(event.at < 12 * MS && event.at + 6u * event.id > 14 * MS);
    assert_int_equal(dg_host_power(self, 12 * MS, false), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 12 * MS + 1u, true), DG_HOST_OK);
    request.at = 12 * MS + 2u;
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, 100 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.length, 7);
}

/* 56h has more characters than an event: behind its end an event has zeros, not the one before. */
static void a_long_reply_leaves_nothing_behind_its_end(void **state)
{
    static const uint8_t zeros[sizeof((struct dg_host_event *)0)->data];
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    const struct dg_host_event request = {
        .at = READY + MS, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x56, 0x16}};
    struct dg_host_event event;
    unsigned count = 0;
    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, READY + 200 * MS);
    for (; dg_host_receive(self, &event) == 1; count++) {
        assert_memory_equal(&event.data[event.length], zeros, sizeof zeros - event.length);
    }
    assert_int_equal(count, 3);
    assert_in_range(event.length, 1, sizeof zeros - 1u);
}

static void check_biss(const struct host_rig_model *row)
{
    struct dg_host *self = host_rig_start(&host_rig_here, row->name);
    struct dg_host_frame frame;
    uint64_t now = READY + MS;
    uint8_t bytes[6];

    host_rig_drain(self);
    assert_int_equal(dg_host_frame(self, now, &frame), DG_HOST_OK);
    assert_int_equal(frame.at, now);
    assert_true(frame.end > now && frame.end < now + MS);
    assert_int_equal(frame.position, row->position);
    assert_int_equal(frame.count, row->width);
    assert_true(frame.good == 1 && frame.error == 0 && frame.warning == 0);
    now = frame.end;
    /* 78h..7Bh: the device's ID (5.2.1.3). */
    assert_int_equal(dg_host_registers_read(self, &now, 0x78, bytes, 4), 4);
    assert_int_equal(bytes[0], 0x04);
    assert_int_equal(bytes[2] & 0xC0, 0xC0);
    /* 23h: the mask of warnings; it takes what was written. */
    bytes[0] = 0x5A;
    assert_int_equal(dg_host_registers_write(self, &now, 0x23, bytes, 1), 1);
    bytes[0] = 0;
    assert_int_equal(dg_host_registers_read(self, &now, 0x23, bytes, 1), 1);
    assert_int_equal(bytes[0], 0x5A);
    /* The ID cannot be written. */
    assert_int_equal(dg_host_registers_write(self, &now, 0x78, bytes, 1), DG_HOST_ERR_REFUSED);
    assert_int_equal(dg_host_frame(self, now, &frame), DG_HOST_OK);
    assert_int_equal(frame.position, row->position);
    assert_int_equal(dg_host_receive(self, &(struct dg_host_event){0}), 0);
}

/* CiA 301, 7.3.5, and CiA 305: LSS, NMT, SYNC, its SDO and its node guarding; and node 5's
   heartbeat when 1016h says so. */
static void check_filters(struct dg_host *self)
{
    static const uint16_t usual[] = {0x7E5, 0x000, 0x080, 0x63F, 0x73F};
    struct heard heard;
    uint16_t ids[DG_HOST_FILTERS];

    assert_true(dg_host_filters(self, ids) >= (int)DG_COUNT(usual));
    assert_memory_equal(ids, usual, sizeof usual);
    const int before = dg_host_filters(self, ids);
    sends(self,
          (struct dg_host_event){.at = READY + 7 * MS,
                                 .kind = DG_HOST_CAN,
                                 .id = 0x63F,
                                 .length = 8,
                                 .data = {0x23, 0x16, 0x10, 1, 100, 0, 5, 0}},
          READY + 8 * MS, &heard);
    assert_int_equal(dg_host_filters(self, ids), before + 1);
    bool found = false;
    for (int i = 0; i < before + 1; i++) {
        found = found || ids[i] == 0x705;
    }
    assert_true(found);
}

/* 6004h by SDO, then the SYNC PDO that maps it. */
static void check_canopen(const struct host_rig_model *row)
{
    const uint32_t position = (uint32_t)row->position;
    struct dg_host *self = host_rig_start(&host_rig_here, row->name);
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_CAN};
    struct heard heard;
    unsigned found = 0;

    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.id, 0x73F); /* boot-up */
    assert_int_equal(event.length, 1);
    host_rig_drain(self);
    sends(self,
          (struct dg_host_event){.at = READY + MS,
                                 .kind = DG_HOST_CAN,
                                 .id = 0x63F,
                                 .length = 8,
                                 .data = {0x40, 0x04, 0x60}},
          READY + 2 * MS, &heard);
    ASSERT_HEARD(heard, 0x43, 0x04, 0x60, 0, (uint8_t)position, (uint8_t)(position >> 8),
                 (uint8_t)(position >> 16), 0);
    sends(
        self,
        (struct dg_host_event){.at = READY + 3 * MS, .kind = DG_HOST_CAN, .length = 2, .data = {1}},
        READY + 4 * MS, &heard);
    event = (struct dg_host_event){.at = READY + 5 * MS, .kind = DG_HOST_CAN, .id = 0x80};
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, READY + 6 * MS);
    while (dg_host_receive(self, &event) > 0) {
        found += event.id == 0x2BF && event.at == READY + 5 * MS &&
                         event.data[0] == (uint8_t)position &&
                         event.data[1] == (uint8_t)(position >> 8)
                     ? 1u
                     : 0u;
    }
    assert_int_equal(found, 1);
    assert_int_equal(dg_host_bit_rate(self), 250);
    check_filters(self);
}

static void check_interbus(const struct host_rig_model *row)
{
    struct dg_host *self = host_rig_start(&host_rig_here, row->name);
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_WORDS, .flags = DG_HOST_IDENTIFY};
    int result = 1;

    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    event.flags = 0;
    for (int i = 0; i < 3; i++) {
        event.at += MS;
        assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    }
    (void)dg_host_step(self, READY + 3 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.flags, DG_HOST_IDENTIFY);
    assert_int_equal(event.length, 2);
    for (int i = 0; i < 3; i++) {
        result = dg_host_receive(self, &event);
    }
    assert_int_equal(result, 1);
    assert_int_equal(event.at, READY + 3 * MS);
    assert_int_equal(event.length, row->width);
    assert_int_equal(event.id, row->position);
    assert_int_equal(event.data[row->width - 1], (uint8_t)row->position);
}

static void check_ssi(const struct host_rig_model *row)
{
    const uint64_t position = row->position;
    const uint8_t count = row->width;
    struct dg_host *self = host_rig_start(&host_rig_here, row->name);
    struct dg_host_frame frame;

    host_rig_drain(self);
    assert_int_equal(dg_host_frame(self, READY + MS, &frame), DG_HOST_OK);
    assert_int_equal(frame.position, position);
    /* Gray code, or binary with three ones, no error and the parity of that. */
    assert_int_equal(frame.bits, count == 30 ? position << 2 | 1u : position ^ position >> 1);
    assert_int_equal(frame.count, count);
    assert_int_equal(frame.good, 1);
    assert_int_equal(frame.end, READY + MS + (count - 1u) * 1000u + 20000u);
}

/* What is done with the encoders of each wire. */
static const struct {
    const struct dg_host_wire *wire;
    void (*check)(const struct host_rig_model *row);
} exchanges[] = {
    {&dg_hf_wire, check_hiperface},   {&dg_biss_wire, check_biss},   {&dg_ssi_wire, check_ssi},
    {&dg_cia406_wire, check_canopen}, {&dg_ib_wire, check_interbus},
};

static void drive(const struct host_rig_model *row)
{
    uint64_t position = 0;
    size_t i = 0;

    assert_string_equal(dg_host_protocol(host_rig_make(&host_rig_here, row->name)), row->protocol);
    assert_int_equal(dg_host_position(host_rig_start(&host_rig_here, row->name), READY, &position),
                     DG_HOST_OK);
    assert_int_equal(position, row->position);
    while (i < DG_COUNT(exchanges) && exchanges[i].wire != row->wire) {
        i++;
    }
    if (i == DG_COUNT(exchanges)) {
        fail_msg("%s: there is no exchange of %s here", row->name, row->protocol);
    }
    exchanges[i].check(row);
}

/* What a host goes by, before the first power-on, too. */
static void every_model_tells_its_medium_and_its_address(void **state)
{
    (void)state;
    for (size_t i = 0; i < host_rig_model_count; i++) {
        const struct host_rig_model *row = &host_rig_models[i];
        struct dg_host *self = host_rig_make(&host_rig_here, row->name);
        const char *key = dg_host_address_key(self);
        char text[16];
        assert_int_equal(dg_host_medium(self), row->medium);
        assert_int_equal(key == NULL, row->address_key == NULL);
        if (key != NULL) {
            assert_string_equal(key, row->address_key);
            assert_true(dg_host_get(self, key, text, sizeof text) > 0);
        }
    }
}

static void every_model_is_driven_by_its_handle(void **state)
{
    size_t named = 0;

    (void)state;
    for (size_t i = 0; i < host_rig_model_count; i++) {
        drive(&host_rig_models[i]);
    }
    while (dg_host_name(named) != NULL) {
        size_t i = 0;
        while (i < host_rig_model_count &&
               strcmp(host_rig_models[i].name, dg_host_name(named)) != 0) {
            i++;
        }
        assert_true(i < host_rig_model_count); /* a new model is to be driven, too */
        assert_true(dg_host_size_of(dg_host_name(named)) <= HOST_RIG_MEMORY_MAX);
        named++;
    }
    assert_true(named > 0);
}

/* ------------------------------------------------------------ states */

/* What starts this program once more; a build that runs under an emulator names that. */
#ifndef STARTED_BY
#define STARTED_BY "/proc/self/exe"
#endif

static uint8_t state_of[HOST_RIG_MEMORY_MAX];
static uint8_t other_state[HOST_RIG_MEMORY_MAX];

/* A second of everything a wire has, from `now` on; the steps do not matter. */
static void ask(struct dg_host *self, uint64_t now)
{
    const struct dg_host_event events[] = {
        {.at = now + MS, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x42, 0x02}},
        {.at = now + MS, .kind = DG_HOST_CAN, .length = 2, .data = {1}},
        {.at = now + 2 * MS, .kind = DG_HOST_CAN, .id = 0x80},
        {.at = now + 2 * MS,
         .kind = DG_HOST_CAN,
         .id = 0x63F,
         .length = 8,
         .data = {0x40, 8, 0x10}},
        {.at = now + 3 * MS, .kind = DG_HOST_CAN, .id = 0x63F, .length = 8, .data = {0x60}},
        {.at = now + MS, .kind = DG_HOST_EDGE, .length = 1, .data = {0}},
        {.at = now + MS + 500, .kind = DG_HOST_EDGE, .length = 1, .data = {1}},
        {.at = now + MS + 900, .kind = DG_HOST_EDGE, .length = 1, .data = {0}},
        {.at = now + MS + 1500, .kind = DG_HOST_EDGE, .length = 1, .data = {1}},
        {.at = now + MS, .kind = DG_HOST_WORDS},
    };

    for (size_t i = 0; i < DG_COUNT(events); i++) {
        const int result = dg_host_send(self, &events[i]);
        assert_true(result == DG_HOST_OK || result == DG_HOST_ERR_WIRE);
    }
}

static void go_on(struct dg_host *self, uint64_t now, uint64_t step)
{
    ask(self, now);
    for (uint64_t t = now; t <= now + SECOND; t += step) {
        (void)dg_host_step(self, t);
    }
    (void)dg_host_step(self, now + SECOND);
}

/* In the middle of things: turning, warm, with what waits in both queues. */
static struct dg_host *in_the_middle(const char *name)
{
    struct dg_host *self = host_rig_start(&host_rig_here, name);

    dg_host_shaft(self, READY, TURN, 17 * TURN + 12345);
    (void)dg_host_world_set(self, READY, "temperature", 55500);
    ask(self, READY);
    (void)dg_host_step(self, READY + 2 * MS);
    return self;
}

static size_t saved(struct dg_host *self, uint8_t *to)
{
    assert_int_equal(dg_host_save(self, to, dg_host_state_size(self) - 1u), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_save(self, to, HOST_RIG_MEMORY_MAX), DG_HOST_OK);
    return dg_host_state_size(self);
}

static void whole(int fd, uint8_t *bytes, size_t n, bool out)
{
    for (size_t done = 0; done < n;) {
        const ssize_t now =
            out ? write(fd, bytes + done, n - done) : read(fd, bytes + done, n - done);
        assert_true(now > 0);
        done += (size_t)now;
    }
}

/* The other process: a state comes in, what became of it a second later goes out. */
static int in_another_process(const char *name)
{
    struct dg_host *self = host_rig_make(&host_rig_there, name);
    const size_t n = dg_host_state_size(self);

    whole(STDIN_FILENO, state_of, n, false);
    if (dg_host_restore(self, state_of, n) != DG_HOST_OK) {
        return 1;
    }
    go_on(self, READY + 10 * MS, 10 * MS);
    (void)saved(self, state_of);
    whole(STDOUT_FILENO, state_of, n, true);
    return 0;
}

/* Another program at other addresses; not a fork, where pointers would still be right. */
static void continue_elsewhere(const char *name, uint8_t *state, size_t n)
{
    int to[2];
    int from[2];
    int status = 0;

    assert_int_equal(pipe(to), 0);
    assert_int_equal(pipe(from), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        (void)dup2(to[0], STDIN_FILENO);
        (void)dup2(from[1], STDOUT_FILENO);
        (void)close(to[1]);
        (void)close(from[0]);
        const char *const again[] = {STARTED_BY, name, NULL};
        (void)execv(again[0], (char *const *)again);
        _exit(127);
    }
    (void)close(to[0]);
    (void)close(from[1]);
    whole(to[1], state, n, true);
    whole(from[0], state, n, false);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    (void)close(to[1]);
    (void)close(from[0]);
}

static void a_state_goes_on_in_another_process(void **state)
{
    (void)state;
    for (size_t i = 0; i < host_rig_model_count; i++) {
        struct dg_host *self = in_the_middle(host_rig_models[i].name);
        const size_t n = saved(self, other_state);
        continue_elsewhere(host_rig_models[i].name, other_state, n);
        go_on(self, READY + 10 * MS, 10 * MS);
        (void)saved(self, state_of);
        assert_memory_equal(state_of, other_state, n);
    }
}

/* However far apart the calls are, the same happens at the same moments. */
static void the_pace_of_the_host_does_not_matter(void **state)
{
    (void)state;
    for (size_t i = 0; i < host_rig_model_count; i++) {
        struct dg_host *self = in_the_middle(host_rig_models[i].name);
        struct dg_host *fine = host_rig_make(&host_rig_there, host_rig_models[i].name);
        struct dg_host_event a;
        struct dg_host_event b;
        int result;
        assert_int_equal(dg_host_restore(fine, state_of, saved(self, state_of)), DG_HOST_OK);
        go_on(self, READY + 10 * MS, SECOND);
        go_on(fine, READY + 10 * MS, 7919);
        do {
            result = dg_host_receive(self, &a);
            assert_int_equal(dg_host_receive(fine, &b), result);
            assert_true(result != 1 || memcmp(&a, &b, sizeof a) == 0);
        } while (result > 0);
    }
}

static void a_state_that_is_not_its_own_is_refused(void **state)
{
    struct dg_host *self = in_the_middle("f3668");
    const size_t n = saved(self, state_of);
    struct dg_host *same;

    (void)state;
    assert_int_equal(dg_host_restore(host_rig_make(&host_rig_there, "f3658"), state_of, n),
                     DG_HOST_ERR_OTHER);
    same = host_rig_make(&host_rig_there, "f3668");
    assert_int_equal(dg_host_restore(same, state_of, n - 1u), DG_HOST_ERR_SPACE);
    for (size_t i = 0; i < n; i++) {
        memcpy(other_state, state_of, n);
        other_state[i] ^= 0x10;
        const int result = dg_host_restore(same, other_state, n);
        assert_true(result == DG_HOST_ERR_OTHER || result == DG_HOST_ERR_DAMAGED);
        assert_false(dg_host_powered(same)); /* nothing was changed */
        i += i < 256 ? 0 : 96;
    }
    assert_int_equal(dg_host_restore(same, state_of, n), DG_HOST_OK);
    assert_true(dg_host_powered(same));
}

int main(int argc, char **argv)
{
    if (argc > 1) {
        return in_another_process(argv[1]);
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_model_is_driven_by_its_handle),
        cmocka_unit_test(every_model_tells_its_medium_and_its_address),
        cmocka_unit_test(characters_take_their_bits),
        cmocka_unit_test(a_reply_ends_with_the_power),
        cmocka_unit_test(a_long_reply_leaves_nothing_behind_its_end),
        cmocka_unit_test(a_state_goes_on_in_another_process),
        cmocka_unit_test(the_pace_of_the_host_does_not_matter),
        cmocka_unit_test(a_state_that_is_not_its_own_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
