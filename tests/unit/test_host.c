/* SPDX-License-Identifier: MIT */
/*
 * Every model behind its handle, with nothing but host.h: what a binding of another language sees.
 * What the encoders have to say to it stands here in bytes, as the manuals and standards have it.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/host.h"

/* Not in the list of all models. */
extern const struct dg_device dg_ssi_25;

#define MS UINT64_C(1000000)
#define SECOND (1000 * MS)
#define TURN ((int64_t)1 << 32)
/* Longer than any model initialises. */
#define READY SECOND
#define MEMORY_MAX 32768u

struct place {
    alignas(DG_HOST_ALIGN) uint8_t bytes[MEMORY_MAX];
};

static struct place here;
static struct place there;

static struct dg_host *make(struct place *place, const char *name)
{
    memset(place, 0xA5, sizeof *place);
    if (strcmp(name, "ssi-25") == 0) {
        return dg_host_init(place, sizeof *place, &dg_ssi_25, &dg_ssi_wire);
    }
    return dg_host_make(place, sizeof *place, name);
}

/* With power since 0, initialised, 3.25 turns and at rest. */
static struct dg_host *start(struct place *place, const char *name)
{
    struct dg_host *self = make(place, name);

    assert_non_null(self);
    dg_host_shaft(self, 0, 3 * TURN + TURN / 4, 0);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_true(dg_host_step(self, READY) > READY);
    return self;
}

/* Fetch until nothing is left. */
static void drain(struct dg_host *self)
{
    struct dg_host_event event;

    while (dg_host_receive(self, &event) > 0) {
    }
}

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
static void check_hiperface(const char *name, uint32_t position)
{
    struct dg_host *self = start(&here, name);
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
    drain(self);
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

static void check_biss(const char *name, uint64_t position, uint8_t count)
{
    struct dg_host *self = start(&here, name);
    struct dg_host_frame frame;
    uint64_t now = READY + MS;
    uint8_t bytes[6];

    drain(self);
    assert_int_equal(dg_host_frame(self, now, &frame), DG_HOST_OK);
    assert_int_equal(frame.at, now);
    assert_true(frame.end > now && frame.end < now + MS);
    assert_int_equal(frame.position, position);
    assert_int_equal(frame.count, count);
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
    assert_int_equal(frame.position, position);
    assert_int_equal(dg_host_receive(self, &(struct dg_host_event){0}), 0);
}

/* 6004h by SDO, then the SYNC PDO that maps it. */
static void check_canopen(const char *name, uint32_t position)
{
    struct dg_host *self = start(&here, name);
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_CAN};
    struct heard heard;
    unsigned found = 0;

    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.id, 0x73F); /* boot-up */
    assert_int_equal(event.length, 1);
    drain(self);
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
}

static void check_interbus(const char *name, uint32_t position, uint8_t length)
{
    struct dg_host *self = start(&here, name);
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_WORDS, .flags = DG_HOST_IDENTIFY};
    int result = 1;

    drain(self);
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
    assert_int_equal(event.length, length);
    assert_int_equal(event.id, position);
    assert_int_equal(event.data[length - 1], (uint8_t)position);
}

static void check_ssi(const char *name, uint64_t position, uint8_t count)
{
    struct dg_host *self = start(&here, name);
    struct dg_host_frame frame;

    drain(self);
    assert_int_equal(dg_host_frame(self, READY + MS, &frame), DG_HOST_OK);
    assert_int_equal(frame.position, position);
    assert_int_equal(frame.bits, position ^ position >> 1);
    assert_int_equal(frame.count, count);
    assert_int_equal(frame.good, 1);
    assert_int_equal(frame.end, READY + MS + (count - 1u) * 1000u + 20000u);
}

static const struct row {
    const char *name;
    const char *protocol;
    uint64_t position; /* at 3.25 turns */
    uint8_t width;     /* bits, or bytes */
} rows[] = {
    {"s3674-rs485", "hiperface", 16384, 0},
    {"s3684-rs485", "hiperface", 3 * 65536 + 16384, 0},
    {"s3674-biss", "biss", 1u << 19, 21 + 2 + 6 + 6},
    {"s3684-biss", "biss", 3u << 21 | 1u << 19, 12 + 21 + 2 + 6 + 6},
    {"f3658", "canopen", 16384, 0},
    {"f3668", "canopen", 3 * 65536 + 16384, 0},
    {"ocd-ib-k1", "interbus", 1024, 2},
    {"ocd-ib-k2", "interbus", 3 * 4096 + 1024, 4},
    {"ocd-ib-k3", "interbus", 3 * 4096 + 1024, 4},
    {"ssi-25", "ssi", 3u << 13 | 1u << 11, 25},
};
#define ROWS (sizeof rows / sizeof rows[0])

static void drive(const struct row *row)
{
    uint64_t position = 0;

    assert_string_equal(dg_host_protocol(make(&here, row->name)), row->protocol);
    assert_int_equal(dg_host_position(start(&here, row->name), READY, &position), DG_HOST_OK);
    assert_int_equal(position, row->position);
    if (strcmp(row->protocol, "hiperface") == 0) {
        check_hiperface(row->name, (uint32_t)row->position);
    } else if (strcmp(row->protocol, "biss") == 0) {
        check_biss(row->name, row->position, row->width);
    } else if (strcmp(row->protocol, "canopen") == 0) {
        check_canopen(row->name, (uint32_t)row->position);
    } else if (strcmp(row->protocol, "interbus") == 0) {
        check_interbus(row->name, (uint32_t)row->position, row->width);
    } else {
        check_ssi(row->name, row->position, row->width);
    }
}

static void every_model_is_driven_by_its_handle(void **state)
{
    size_t named = 0;

    (void)state;
    for (size_t i = 0; i < ROWS; i++) {
        drive(&rows[i]);
    }
    while (dg_host_name(named) != NULL) {
        size_t i = 0;
        while (i < ROWS && strcmp(rows[i].name, dg_host_name(named)) != 0) {
            i++;
        }
        assert_true(i < ROWS); /* a new model is to be driven, too */
        assert_true(dg_host_size_of(dg_host_name(named)) <= MEMORY_MAX);
        named++;
    }
    assert_true(named > 0);
}

/* ------------------------------------------------------------ states */

static uint8_t state_of[MEMORY_MAX];
static uint8_t other_state[MEMORY_MAX];

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

    for (size_t i = 0; i < sizeof events / sizeof events[0]; i++) {
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
    struct dg_host *self = start(&here, name);

    dg_host_shaft(self, READY, TURN, 17 * TURN + 12345);
    (void)dg_host_world_set(self, READY, "temperature", 55500);
    ask(self, READY);
    (void)dg_host_step(self, READY + 2 * MS);
    return self;
}

static size_t saved(struct dg_host *self, uint8_t *to)
{
    assert_int_equal(dg_host_save(self, to, dg_host_state_size(self) - 1u), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_save(self, to, MEMORY_MAX), DG_HOST_OK);
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
    struct dg_host *self = make(&there, name);
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
        (void)execl("/proc/self/exe", "test_host", name, (char *)NULL);
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
    for (size_t i = 0; i < ROWS; i++) {
        struct dg_host *self = in_the_middle(rows[i].name);
        const size_t n = saved(self, other_state);
        continue_elsewhere(rows[i].name, other_state, n);
        go_on(self, READY + 10 * MS, 10 * MS);
        (void)saved(self, state_of);
        assert_memory_equal(state_of, other_state, n);
    }
}

/* However far apart the calls are, the same happens at the same moments. */
static void the_pace_of_the_host_does_not_matter(void **state)
{
    (void)state;
    for (size_t i = 0; i < ROWS; i++) {
        struct dg_host *self = in_the_middle(rows[i].name);
        struct dg_host *fine = make(&there, rows[i].name);
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
    assert_int_equal(dg_host_restore(make(&there, "f3658"), state_of, n), DG_HOST_ERR_OTHER);
    same = make(&there, "f3668");
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

/* ------------------------------------------------------------ memory and settings */

static void memory_that_does_not_do_is_refused(void **state)
{
    const size_t n = dg_host_size_of("f3668");

    (void)state;
    assert_true(n > 0);
    assert_int_equal(n % DG_HOST_ALIGN, 0);
    assert_null(dg_host_make(&here, n - 1u, "f3668"));
    assert_null(dg_host_make(here.bytes + 8, n, "f3668"));
    assert_null(dg_host_make(NULL, n, "f3668"));
    assert_null(dg_host_make(&here, sizeof here, "f366"));
    assert_int_equal(dg_host_size_of(""), 0);
    assert_int_equal(dg_host_size(&dg_ssi_25, &dg_hf_wire), 0);
    assert_null(dg_host_init(&here, sizeof here, &dg_ssi_25, &dg_hf_wire));
    assert_non_null(dg_host_make(&here, n, "f3668"));
}

/* A value that is allowed, as text. */
static void check_key(struct dg_host *self, const struct dg_host_key *key)
{
    char before[64];
    char after[64];

    assert_true(key->name[0] != '\0' && key->help[0] != '\0' && key->unit != NULL);
    assert_true(key->min <= key->max);
    assert_true(dg_host_get(self, key->name, before, sizeof before) >= 0);
    assert_int_equal(dg_host_set(self, key->name, before), DG_HOST_OK);
    assert_true(dg_host_get(self, key->name, after, sizeof after) >= 0);
    assert_string_equal(before, after);
    assert_int_equal(dg_host_get(self, key->name, after, strlen(before)), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_set(self, key->name, "no such value, too long for a text as well"),
                     DG_HOST_ERR_ARGUMENT);
}

static void every_setting_is_told_and_taken_as_it_is_told(void **state)
{
    (void)state;
    for (size_t i = 0; i < ROWS; i++) {
        struct dg_host *self = make(&here, rows[i].name);
        struct dg_host_key key;
        size_t n = 0;
        for (; dg_host_key(self, n, &key) == DG_HOST_OK; n++) {
            check_key(self, &key);
        }
        assert_true(n > 8);
        assert_int_equal(dg_host_set(self, "no_such_key", "1"), DG_HOST_ERR_NAME);
        assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
        for (n = 0; dg_host_key(self, n, &key) == DG_HOST_OK; n++) {
            char value[64];
            assert_true(dg_host_get(self, key.name, value, sizeof value) >= 0);
            assert_int_equal(dg_host_set(self, key.name, value),
                             key.always ? DG_HOST_OK : DG_HOST_ERR_STATE);
        }
    }
}

static void settings_make_the_encoder(void **state)
{
    struct dg_host *self = make(&here, "f3668");
    struct dg_host_event event;
    struct dg_host_frame frame;
    uint64_t counts = 0;
    uint64_t now = READY;
    uint8_t serial[4];

    (void)state;
    assert_int_equal(dg_host_set(self, "node", "128"), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_set(self, "node", "5"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "mt_bits", "16"), DG_HOST_OK);
    dg_host_shaft(self, 0, 5000 * TURN, 0);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.id, 0x705);
    assert_int_equal(dg_host_position(self, READY, &counts), DG_HOST_OK);
    assert_int_equal(counts, 5000u << 16);

    self = make(&here, "s3684-biss");
    assert_int_equal(dg_host_set(self, "serial", "0x12345678"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "st", "18"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "lc", "0"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_int_equal(dg_host_frame(self, now, &frame), DG_HOST_OK);
    assert_int_equal(frame.count, 12 + 18 + 2 + 6);
    now = frame.end;
    assert_int_equal(dg_host_registers_read(self, &now, 0x44, serial, 4), 4);
    assert_true(serial[0] == 0x12 && serial[3] == 0x78);

    self = make(&here, "s3684-rs485");
    assert_int_equal(dg_host_set(self, "address", "0x60"), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_set(self, "address", "41h"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    event = (struct dg_host_event){
        .at = READY, .kind = DG_HOST_BYTES, .length = 3, .data = {0x41, 0x42, 0x03}};
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, READY + 100 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.data[0], 0x41);
}

static void settings_that_do_not_go_together_make_none(void **state)
{
    struct dg_host *self = make(&here, "s3684-rs485");

    (void)state;
    assert_int_equal(dg_host_set(self, "periods", "65535"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "steps", "16777216"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_ERR_ARGUMENT);
    assert_false(dg_host_powered(self));
    assert_int_equal(dg_host_set(self, "steps", "1"), DG_HOST_OK);
    assert_int_equal(dg_host_set(self, "turns", "1"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
}

static void an_image_is_another_ones_memory(void **state)
{
    struct dg_host *self = start(&here, "s3684-biss");
    uint64_t now = READY;
    uint8_t byte = 0x5A;
    struct dg_host *other = make(&there, "s3684-biss");
    const size_t n = dg_host_memory_size(self);

    (void)state;
    assert_int_equal(dg_host_registers_write(self, &now, 0x23, &byte, 1), 1);
    byte = 1; /* command 01: store */
    assert_int_equal(dg_host_registers_write(self, &now, 0x60, &byte, 1), 1);
    assert_int_equal(dg_host_memory_load(self, state_of, n), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_memory_copy(self, state_of, n - 1u), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_memory_copy(self, state_of, n), DG_HOST_OK);
    assert_int_equal(dg_host_memory_load(other, state_of, n - 1u), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_memory_load(other, state_of, n), DG_HOST_OK);
    assert_int_equal(dg_host_power(other, 0, true), DG_HOST_OK);
    now = READY;
    byte = 0;
    assert_int_equal(dg_host_registers_read(other, &now, 0x23, &byte, 1), 1);
    assert_int_equal(byte, 0x5A);
    other = make(&there, "s3684-rs485");
    memset(state_of, 0xFF, sizeof state_of);
    assert_int_equal(dg_host_memory_load(other, state_of, dg_host_memory_size(other)), DG_HOST_OK);
    assert_int_equal(dg_host_power(other, 0, true), DG_HOST_ERR_BLANK);
    assert_false(dg_host_powered(other));
}

/* ------------------------------------------------------------ physics and time */

/* floor(rate * t / 1 s) modulo 2^64, by integers of any length (Python). */
static void a_shaft_turns_exactly_between_two_steps(void **state)
{
    static const struct {
        int64_t rate;
        uint64_t t;
        int64_t turned;
    } courses[] = {
        {1, UINT64_C(1), INT64_C(0)},
        {1, UINT64_C(333333333), INT64_C(0)},
        {1, UINT64_C(1000000001), INT64_C(1)},
        {-1, UINT64_C(999), INT64_C(-1)},
        {-1, UINT64_C(1000000000), INT64_C(-1)},
        {-1, UINT64_C(86400000000001), INT64_C(-86401)},
        {12 * TURN + 7, UINT64_C(1), INT64_C(51)},
        {12 * TURN + 7, UINT64_C(333333333), INT64_C(17179869169)},
        {12 * TURN + 7, UINT64_C(1000000001), INT64_C(51539607610)},
        {-200 * TURN - 1, UINT64_C(999), INT64_C(-858135)},
        {-200 * TURN - 1, UINT64_C(1000000000), INT64_C(-858993459201)},
        {-200 * TURN - 1, UINT64_C(86400000000001), INT64_C(-74217034874967259)},
        {INT64_MAX, UINT64_C(1), INT64_C(9223372036)},
        {INT64_MAX, UINT64_C(333333333), INT64_C(3074457342543801256)},
        {INT64_MAX, UINT64_C(1000000001), INT64_C(-9223372027631403773)},
        {INT64_MIN, UINT64_C(999), INT64_C(-9214148664818)},
        {INT64_MIN, UINT64_C(1000000000), INT64_MIN},
        {INT64_MIN, UINT64_C(86400000000001), INT64_C(-9223372037)},
        {-1000000001, UINT64_C(1), INT64_C(-2)},
        {-1000000001, UINT64_C(333333333), INT64_C(-333333334)},
        {-1000000001, UINT64_C(1000000001), INT64_C(-1000000003)},
    };

    (void)state;
    for (size_t i = 0; i < sizeof courses / sizeof courses[0]; i++) {
        struct dg_host *self = make(&here, "f3658");
        const uint64_t want = (uint64_t)TURN + (uint64_t)courses[i].turned;
        dg_host_shaft(self, 0, -TURN, 0);
        dg_host_shaft(self, SECOND, TURN, courses[i].rate);
        assert_int_equal(dg_host_angle(self, SECOND + courses[i].t), want);
        assert_int_equal(dg_host_angle(self, SECOND - 1u), -TURN);
    }
}

static void encoders_share_a_shaft(void **state)
{
    struct dg_host *self = start(&here, "s3684-biss");
    struct dg_host *other = start(&there, "f3668");
    uint64_t a = 0;
    uint64_t b = 0;

    (void)state;
    assert_int_equal(dg_host_share(other, self), DG_HOST_OK);
    assert_int_equal(dg_host_share(self, other), DG_HOST_ERR_ARGUMENT);
    dg_host_shaft(self, READY, 7 * TURN, 3 * TURN);
    for (uint64_t t = READY; t < READY + SECOND; t += 77 * MS) {
        assert_int_equal(dg_host_position(self, t, &a), DG_HOST_OK);
        assert_int_equal(dg_host_position(other, t, &b), DG_HOST_OK);
        assert_int_equal(a >> 5, b);
    }
    assert_int_equal(dg_host_share(other, NULL), DG_HOST_OK);
    assert_int_equal(dg_host_angle(other, READY), 3 * TURN + TURN / 4);
}

static void the_world_is_bent_by_name(void **state)
{
    struct dg_host *self = start(&here, "s3684-biss");
    struct dg_host_frame frame;
    int64_t value = 0;
    char text[16];

    (void)state;
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 37000);
    assert_int_equal(dg_host_world_set(self, READY, "temperature", 1000001), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(dg_host_world_set(self, READY, "no_such", 1), DG_HOST_ERR_NAME);
    assert_int_equal(dg_host_set(self, "temperature", "-12.5"), DG_HOST_OK);
    assert_int_equal(dg_host_get(self, "temperature", text, sizeof text), 7);
    assert_string_equal(text, "-12.500");
    assert_int_equal(dg_host_world_set(self, READY, "singleturn_ok", 0), DG_HOST_OK);
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_OK);
    assert_int_equal(frame.error, 1);
    self = make(&here, "ocd-ib-k1");
    assert_int_equal(dg_host_world_set(self, READY, "supply_mv", 1), DG_HOST_ERR_NAME);
    assert_int_equal(dg_host_world_set(self, READY, "multiturn_sync_ok", 0), DG_HOST_ERR_NAME);
}

static void what_nobody_fetches_is_counted_and_told(void **state)
{
    struct dg_host *self = start(&here, "ocd-ib-k2");
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_WORDS};
    unsigned n = 0;

    (void)state;
    drain(self);
    for (unsigned i = 0; i < DG_HOST_QUEUE; i++) {
        assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    }
    assert_int_equal(dg_host_send(self, &event), DG_HOST_ERR_SPACE);
    (void)dg_host_step(self, READY);
    assert_int_equal(dg_host_lost(self), 0);
    event.at += 5;
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    assert_int_equal(dg_host_step(self, READY + 5), DG_HOST_NEVER);
    assert_int_equal(dg_host_lost(self), 1);
    while (dg_host_receive(self, &event) == 1) {
        n++;
    }
    assert_int_equal(n, DG_HOST_QUEUE);
    assert_int_equal(dg_host_receive(self, &event), 0); /* the loop was told */
    event = (struct dg_host_event){.at = READY + 6, .kind = DG_HOST_WORDS};
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, READY + 6);
    assert_int_equal(dg_host_receive(self, &event), 1);
}

static void count(void *ctx, const struct dg_host_event *event)
{
    assert_int_equal(event->kind, DG_HOST_WORDS);
    ++*(unsigned *)ctx;
}

static void a_listener_hears_at_once(void **state)
{
    struct dg_host *self = start(&here, "ocd-ib-k1");
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_WORDS};
    unsigned heard = 0;

    (void)state;
    drain(self);
    dg_host_listen(self, count, &heard);
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    assert_int_equal(heard, 1);
    dg_host_listen(self, NULL, NULL);
    assert_int_equal(dg_host_receive(self, &event), 0);
}

static void events_of_other_wires_are_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < ROWS; i++) {
        struct dg_host *self = make(&here, rows[i].name);
        struct dg_host_event event = {.at = 0, .length = 1};
        unsigned own = 0;
        int32_t uv[4];
        uint64_t now = READY;
        uint8_t byte = 0;
        assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
        for (unsigned kind = 0; kind < 256; kind++) {
            event.kind = (uint8_t)kind;
            const int result = dg_host_send(self, &event);
            own += result == DG_HOST_OK ? 1u : 0u;
            assert_true(result == DG_HOST_OK || result == DG_HOST_ERR_WIRE);
        }
        assert_true(own == 1 || (own == 2 && strcmp(rows[i].protocol, "canopen") == 0));
        const bool rs485 = strcmp(rows[i].protocol, "hiperface") == 0;
        const bool biss = strcmp(rows[i].protocol, "biss") == 0;
        const bool clocked = biss || strcmp(rows[i].protocol, "ssi") == 0;
        assert_int_equal(dg_host_sincos(self, READY, uv) == DG_HOST_ERR_WIRE, !rs485);
        assert_int_equal(dg_host_clock(self, now, true) == DG_HOST_ERR_WIRE, !clocked);
        assert_int_equal(dg_host_registers_read(self, &now, 0, &byte, 1) == DG_HOST_ERR_WIRE,
                         !biss);
    }
}

/* The line of an SSI encoder by its edges, in picoseconds. */
static void a_simulator_clocks_in_picoseconds(void **state)
{
    struct dg_host *self = start(&here, "ssi-25");
    const uint64_t ps = 1000;
    uint64_t now = READY * ps + 999; /* still the same nanosecond */
    uint64_t bits = 0;

    (void)state;
    assert_int_equal(dg_host_clock_ps(self, now, true), 1);
    for (int i = 0; i < 25; i++) {
        (void)dg_host_clock_ps(self, now, false);
        bits = bits << 1 | (uint64_t)dg_host_clock_ps(self, now + 250 * ps, true);
        now += 500 * ps;
    }
    assert_int_equal(bits, rows[9].position ^ rows[9].position >> 1);
    const uint64_t end = (READY + 24u * 500u + 20000u) * ps;
    assert_int_equal(dg_host_step_ps(self, end - 1u), end); /* not early */
    assert_int_equal(dg_host_step_ps(self, end), DG_HOST_NEVER);
    assert_int_equal(dg_host_frame(self, READY, &(struct dg_host_frame){0}), DG_HOST_OK);
}

/* The middle of a word is no moment for a frame. */
static void a_frame_waits_for_the_end_of_another(void **state)
{
    static const char *const names[] = {"s3684-biss", "ssi-25"};
    struct dg_host_frame frame;

    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct dg_host *self = make(&here, names[i]);
        assert_int_equal(dg_host_frame(self, 0, &frame), DG_HOST_ERR_STATE);
        assert_int_equal(dg_host_clock(self, 0, false), DG_HOST_ERR_STATE);
        self = start(&here, names[i]);
        (void)dg_host_clock(self, READY, false);
        (void)dg_host_clock(self, READY + 500, true);
        (void)dg_host_clock(self, READY + 1000, false);
        assert_int_equal(dg_host_frame(self, READY + 1500, &frame), DG_HOST_ERR_STATE);
    }
}

static void results_have_words(void **state)
{
    (void)state;
    for (int result = -14; result <= 0; result++) {
        assert_string_not_equal(dg_host_result_text(result), "unknown result");
    }
    assert_string_equal(dg_host_result_text(1), "unknown result");
    assert_string_equal(dg_host_result_text(-15), "unknown result");
    assert_string_equal(dg_host_result_text(INT32_MIN), "unknown result");
}

/* ------------------------------------------------------------ faults and SCPI */

static struct place panel_place;

static struct dg_host_panel *panel(struct dg_host *self)
{
    assert_true(dg_host_panel_size() <= sizeof panel_place);
    return dg_host_panel_make(&panel_place, sizeof panel_place, self);
}

static void a_panel_needs_an_encoder_that_was_on(void **state)
{
    struct dg_host *self = make(&here, "f3668");

    (void)state;
    assert_null(panel(self));
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_null(dg_host_panel_make(&panel_place, dg_host_panel_size() - 1u, self));
    assert_null(dg_host_panel_make(panel_place.bytes + 8, dg_host_panel_size(), self));
    assert_null(dg_host_panel_make(NULL, dg_host_panel_size(), self));
    assert_non_null(panel(self));
    assert_null(panel(start(&here, "ssi-25"))); /* has no instrument */
}

/* Every fault of every model comes and goes, or is told to be none of queues. */
static void faults_come_and_go_by_name(void **state)
{
    (void)state;
    for (size_t i = 0; i + 1 < ROWS; i++) {
        struct dg_host *self = start(&here, rows[i].name);
        struct dg_host_panel *board = panel(self);
        struct dg_host_fault fault;
        unsigned set = 0;
        for (size_t n = 0; dg_host_fault(board, n, &fault) == DG_HOST_OK; n++) {
            const int result = dg_host_fault_set(board, READY, fault.name, true);
            assert_true(result == DG_HOST_OK ||
                        (result == DG_HOST_ERR_WIRE && strncmp(fault.name, "wire_", 5) == 0));
            assert_true(fault.active == 0 && fault.cause[0] != '\0' && fault.effect[0] != '\0');
            assert_int_equal(dg_host_fault(board, n, &fault), DG_HOST_OK);
            assert_int_equal(fault.active, result == DG_HOST_OK);
            set += fault.active;
            assert_int_equal(dg_host_fault_set(board, READY + MS, fault.name, false),
                             result == DG_HOST_OK ? DG_HOST_OK : DG_HOST_ERR_WIRE);
        }
        assert_true(set >= 2);
        assert_int_equal(dg_host_fault_set(board, READY, "no_such_fault", true), DG_HOST_ERR_NAME);
    }
}

/* 42h while something is wrong with the wire. */
static int ask_hiperface(struct dg_host *self, uint64_t at, struct dg_host_event *event)
{
    const struct dg_host_event request = {
        .at = at, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x42, 0x02}};
    int n = 0;

    drain(self);
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, at + 900 * MS);
    while (dg_host_receive(self, event) == 1) {
        n++;
    }
    return n;
}

static void faults_of_the_wire_happen_in_the_queues(void **state)
{
    struct dg_host *self = start(&here, "s3684-rs485");
    struct dg_host_panel *board = panel(self);
    static const struct {
        const char *name;
        int replies;
        bool late;
        bool damaged;
    } faults[] = {
        {"wire_drop", 0, false, false},      {"wire_deaf", 0, false, false},
        {"wire_delay", 1, true, false},      {"wire_damage", 1, false, true},
        {"wire_duplicate", 2, false, false},
    };
    struct dg_host_event healthy;
    struct dg_host_event event;
    uint64_t now = 2 * SECOND;

    (void)state;
    assert_int_equal(ask_hiperface(self, now, &healthy), 1);
    healthy.at -= now;
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        now += SECOND;
        assert_int_equal(dg_host_fault_set(board, now, faults[i].name, true), DG_HOST_OK);
        assert_int_equal(ask_hiperface(self, now, &event), faults[i].replies);
        if (faults[i].replies > 0) {
            assert_int_equal(event.at - now - healthy.at, faults[i].late ? 300 * MS : 0);
            assert_int_equal(memcmp(event.data, healthy.data, sizeof event.data) != 0,
                             faults[i].damaged);
        }
        assert_int_equal(dg_host_fault_set(board, now, faults[i].name, false), DG_HOST_OK);
    }
    assert_int_equal(ask_hiperface(self, now + SECOND, &event), 1);
}

static void a_controller_that_is_off_is_silent(void **state)
{
    struct dg_host *self = start(&here, "f3668");
    struct dg_host_panel *board = panel(self);
    struct heard heard;
    const struct dg_host_event read = {
        .at = READY, .kind = DG_HOST_CAN, .id = 0x63F, .length = 8, .data = {0x40, 0x01, 0x10}};

    (void)state;
    drain(self);
    assert_int_equal(dg_host_fault_set(board, READY, "bus_off", true), DG_HOST_OK);
    sends(self, read, READY + MS, &heard);
    assert_int_equal(heard.n, 0);
    assert_int_equal(dg_host_fault_set(board, READY + MS, "bus_off", false), DG_HOST_OK);
    drain(self);
    sends(self, read, READY + 2 * MS, &heard);
    assert_int_equal(heard.n, 8);
}

static void a_line_of_scpi_is_answered(void **state)
{
    struct dg_host *self = start(&here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    struct dg_host_frame frame;
    char answer[64];
    int64_t value = 0;

    (void)state;
    assert_int_equal(dg_host_scpi(board, READY, "SHAF:POS?", answer, sizeof answer), 11);
    assert_string_equal(answer, "1170.000000");
    assert_int_equal(dg_host_scpi(board, READY, "WORL:TEMP 50;:SHAF:POS 90", answer, sizeof answer),
                     0);
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 50000);
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_OK);
    assert_int_equal(frame.position, 1u << 19);
    assert_int_equal(dg_host_scpi(board, frame.end, "*IDN?", answer, 8), DG_HOST_ERR_SPACE);
    assert_string_equal(answer, "drehgeb");
    assert_int_equal(dg_host_scpi(board, frame.end, "NONS", answer, sizeof answer), 0);
    assert_true(dg_host_scpi(board, frame.end, "SYST:ERR?", answer, sizeof answer) > 0);
    assert_memory_equal(answer, "-113", 4);
    assert_int_equal(dg_host_scpi(board, frame.end, "POW OFF", answer, sizeof answer), 0);
    assert_false(dg_host_powered(self));
    assert_int_equal(dg_host_scpi(board, frame.end, "", answer, sizeof answer), 0);
}

static void a_fault_with_a_time_ends(void **state)
{
    struct dg_host *self = start(&here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    char answer[64];
    int64_t value = 0;

    (void)state;
    assert_int_equal(
        dg_host_scpi(board, READY, "FAUL:SET temperature_high;:SYST:ERR?", answer, sizeof answer),
        12);
    assert_string_equal(answer, "0,\"No error\"");
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_true(value > 120000);
    assert_true(dg_host_panel_step(board, READY + MS) > READY + MS);
    assert_int_equal(dg_host_fault_set(board, READY, "temperature_high", false), DG_HOST_OK);
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 37000);
}

int main(int argc, char **argv)
{
    if (argc > 1) {
        return in_another_process(argv[1]);
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_model_is_driven_by_its_handle),
        cmocka_unit_test(a_state_goes_on_in_another_process),
        cmocka_unit_test(the_pace_of_the_host_does_not_matter),
        cmocka_unit_test(a_state_that_is_not_its_own_is_refused),
        cmocka_unit_test(memory_that_does_not_do_is_refused),
        cmocka_unit_test(every_setting_is_told_and_taken_as_it_is_told),
        cmocka_unit_test(settings_make_the_encoder),
        cmocka_unit_test(settings_that_do_not_go_together_make_none),
        cmocka_unit_test(an_image_is_another_ones_memory),
        cmocka_unit_test(a_shaft_turns_exactly_between_two_steps),
        cmocka_unit_test(encoders_share_a_shaft),
        cmocka_unit_test(the_world_is_bent_by_name),
        cmocka_unit_test(what_nobody_fetches_is_counted_and_told),
        cmocka_unit_test(a_listener_hears_at_once),
        cmocka_unit_test(events_of_other_wires_are_refused),
        cmocka_unit_test(a_simulator_clocks_in_picoseconds),
        cmocka_unit_test(a_frame_waits_for_the_end_of_another),
        cmocka_unit_test(results_have_words),
        cmocka_unit_test(a_panel_needs_an_encoder_that_was_on),
        cmocka_unit_test(faults_come_and_go_by_name),
        cmocka_unit_test(faults_of_the_wire_happen_in_the_queues),
        cmocka_unit_test(a_controller_that_is_off_is_silent),
        cmocka_unit_test(a_line_of_scpi_is_answered),
        cmocka_unit_test(a_fault_with_a_time_ends),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
