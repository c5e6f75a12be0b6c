/* SPDX-License-Identifier: MIT */
/*
 * The coupler of an INTERBUS ring as Modbus clients see it, in virtual time: requests byte by byte,
 * who gives up a place, and in which cycle of a ring that nobody watches something happens.
 *
 * Requests and answers are those of the MODBUS Application Protocol Specification V1.1b3, headers
 * of its Messaging on TCP/IP Implementation Guide; registers of `drehgeber map`.
 */
#define _GNU_SOURCE
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "drehgeber/bits.h"
#include "hf_rig.h"
#include "memory_file.h"
#include "slow_disk.h"
#include "timer.h"
#include "virtual_rig.h"

#define HEADER 7u
#define PDU_MAX 253u /* of a request, and of an answer */
#define UNIT 0x11u
#define CYCLE DG_MS(1)
#define STEPS 4096u /* of a turn, which takes a second */
#define K3_MANY 63u
#define CLIENTS_MAX 32u /* LX_PEERS_MAX */
#define FAREWELL DG_S(2)
#define FAREWELL_BYTES 65536u
#define CHUNK 4096u

struct bench {
    struct virtual_rig rig;
    dg_ns begin; /* of the ring's first cycle, in which it is identified */
    uint8_t heard[4096];
    size_t heard_count;
    uint16_t number;               /* of the latest request */
    char folder[SLOW_DISK_FOLDER]; /* of an EEPROM file; empty: there is none */
};

static void on_heard(void *ctx, const uint8_t *bytes, size_t n)
{
    struct bench *self = ctx;
    assert_true(self->heard_count + n <= sizeof self->heard);
    memcpy(self->heard + self->heard_count, bytes, n);
    self->heard_count += n;
}

/* --- the rig --- */

/* A K1, and K3 behind it, on one shaft; a key for the last one. */
static void open_ring_with(struct bench *self, const char *motion, unsigned many, const char *key)
{
    char text[8192];
    int n = snprintf(text, sizeof text,
                     "[bus ring]\nwire = modbus\naddress = 127.0.0.1:0\n"
                     "[shaft main]\nmotion = %s\n"
                     "[encoder first]\nmodel = ocd-ib-k1\nbus = ring\nshaft = main\n"
                     "self_test_ms = 0\n",
                     motion);
    for (unsigned i = 0; i < many; i++) {
        n += snprintf(text + n, sizeof text - (size_t)n,
                      "[encoder e%u]\nmodel = ocd-ib-k3\nbus = ring\nshaft = main\n"
                      "self_test_ms = 0\n",
                      i);
    }
    n += snprintf(text + n, sizeof text - (size_t)n, "%s\n", key);
    assert_in_range(n, 1, sizeof text - 1);
    self->rig = (struct virtual_rig){.heard = on_heard, .ctx = self};
    virtual_rig_open(&self->rig, memory_file_write((const uint8_t *)text, (size_t)n), NULL);
    self->begin = lx_now();
    virtual_rig_connect(&self->rig);
}

static void open_ring(struct bench *self, const char *motion, unsigned many)
{
    open_ring_with(self, motion, many, "");
}

static int make_bench(void **state)
{
    *state = calloc(1, sizeof(struct bench));
    return *state == NULL ? -1 : 0;
}

static int end_bench(void **state)
{
    struct bench *self = *state;
    slow_disk_give();
    virtual_rig_close(&self->rig);
    slow_disk_remove_folder(self->folder);
    free(self);
    return 0;
}

/* --- requests --- */

/* A request with its header. @return its length */
static size_t wrap(struct bench *self, const uint8_t *pdu, size_t n, uint8_t *to)
{
    dg_store_be16(to, ++self->number);
    dg_store_be16(to + 2, 0);
    dg_store_be16(to + 4, (uint16_t)(n + 1u));
    to[6] = UNIT;
    memcpy(to + HEADER, pdu, n);
    return HEADER + n;
}

/* The answer to request `number` is the next that was heard. @return the length of its PDU */
static size_t take_answer(struct bench *self, uint16_t number, uint8_t pdu[PDU_MAX])
{
    assert_true(self->heard_count > HEADER);
    const size_t n = dg_load_be16(self->heard + 4) - 1u;
    assert_int_equal(dg_load_be16(self->heard), number);
    assert_int_equal(dg_load_be16(self->heard + 2), 0);
    assert_int_equal(self->heard[6], UNIT);
    assert_in_range(n, 1, PDU_MAX);
    assert_true(self->heard_count >= HEADER + n);
    memcpy(pdu, self->heard + HEADER, n);
    self->heard_count -= HEADER + n;
    memmove(self->heard, self->heard + HEADER + n, self->heard_count);
    return n;
}

/* A request and its answer, and nothing else. @return the length of the answer's PDU */
static size_t ask(struct bench *self, const uint8_t *pdu, size_t n, uint8_t answer[PDU_MAX])
{
    uint8_t request[HEADER + PDU_MAX];
    virtual_rig_say(&self->rig, request, wrap(self, pdu, n, request));
    const size_t length = take_answer(self, self->number, answer);
    assert_int_equal(self->heard_count, 0);
    return length;
}

/* The answer begins so, and is so long. */
static void expect(struct bench *self, const char *request, const char *answer, size_t length)
{
    uint8_t pdu[PDU_MAX];
    uint8_t right[PDU_MAX];
    uint8_t got[PDU_MAX];
    const size_t n = hf_rig_hex(request, pdu, sizeof pdu);
    const size_t begins = hf_rig_hex(answer, right, sizeof right);
    const size_t is = ask(self, pdu, n, got);
    if (is != length || memcmp(got, right, begins) != 0) {
        fail_msg("%s: %zu bytes, %02X %02X %02X %02X for %s", request, is, got[0], got[1], got[2],
                 got[3], answer);
    }
}

static uint16_t get(struct bench *self, uint16_t address)
{
    const uint8_t pdu[] = {4, (uint8_t)(address >> 8), (uint8_t)address, 0, 1};
    uint8_t answer[PDU_MAX];
    assert_int_equal(ask(self, pdu, sizeof pdu, answer), 4);
    assert_int_equal(answer[0], 4);
    return dg_load_be16(answer + 2);
}

static uint32_t get_pair(struct bench *self, uint16_t address)
{
    return (uint32_t)get(self, address) << 16 | get(self, address + 1u);
}

static void put_register(struct bench *self, uint16_t address, uint16_t value)
{
    const uint8_t pdu[] = {6, (uint8_t)(address >> 8), (uint8_t)address, (uint8_t)(value >> 8),
                           (uint8_t)value};
    uint8_t answer[PDU_MAX];
    assert_int_equal(ask(self, pdu, sizeof pdu, answer), sizeof pdu);
    assert_memory_equal(answer, pdu, sizeof pdu);
}

static void pass_to(struct bench *self, dg_ns since_begin)
{
    virtual_rig_pass_to(&self->rig, self->begin + since_begin);
}

/* --- requests and answers --- */

static const struct {
    const char *request;
    const char *answer;
    size_t length;
} functions[] = {
    {"03 0800 0001", "03 02 0000", 4},
    {"04 0000 007D", "04 FA", 252},
    {"03 0000 007D", "03 FA", 252},
    {"04 0000 007E", "84 03", 2},
    {"03 0000 0000", "83 03", 2},
    {"03 0000 00", "83 03", 2},
    {"04 0000 0001 00", "84 03", 2},
    {"06 0800 0012", "06 0800 0012", 5},
    {"03 0800 0001", "03 02 0012", 4},
    {"06 0800 13", "86 03", 2},
    {"06 0800 0013 00", "86 03", 2},
    {"10 0800 0001 02 0034", "10 0800 0001", 5},
    {"04 0800 0001", "04 02 0034", 4},
    {"10 0800 0000 00 00", "90 03", 2},
    {"10 0800 0000 00 0000", "90 03", 2},
    {"10 0800 0001 02 13", "90 03", 2},
    {"10 0800 0001 02 0013 00", "90 03", 2},
    {"10 0800 0001 01 0013", "90 03", 2},
    {"10 0800 0003 02 0013", "90 03", 2},
    {"10 0801 0002 04 0012 3456", "10 0801 0002", 5},
    {"04 0800 0003", "04 06 0034 0012 3456", 8},
    {"17 0800 0001 0800 0001 02 0056", "17 02 0056", 4},
    {"17 0801 007D 0800 0001 02 0057", "17 FA 0012 3456", 252},
    {"17 0801 007E 0800 0001 02 0058", "97 03", 2},
    {"17 0801 0000 0800 0001 02 0058", "97 03", 2},
    {"17 0801 0001 0800 0000 00 00", "97 03", 2},
    {"17 0801 0001 0800 0001 02 58", "97 03", 2},
    {"17 0801 0001 0800 0001 02 0058 00", "97 03", 2},
    {"17 0801 0001 0800 0003 02 0058", "97 03", 2},
    {"17 0000 0001 07FF 0001 02 0058", "97 02", 2},
    {"17 07FF 0001 0800 0001 02 0058", "97 02", 2},
    {"04 0800 0001", "04 02 0057", 4},
    {"01 0000 0001", "81 01", 2},
    {"7F", "FF 01", 2},
    {"FF", "FF 01", 2},
    {"84 0000 0001", "84 01", 2},
    /* identification; the type of the watchdog, and what is no fallback */
    {"04 1000 0006", "04 0C 6472 6568 6765 6265 7220 4942", 14},
    {"03 1122 0002", "03 04 0001 0000", 6},
    {"06 1122 0002", "86 03", 2},
    {"10 1122 0002 04 0000 0003", "90 03", 2},
    {"03 1122 0002", "03 04 0001 0000", 6},
    {"10 1122 0002 04 0000 0002", "10 1122 0002", 5},
    {"03 1120 0004", "03 08 0000 0000 0000 0002", 10},
};

static void functions_and_their_lengths(void **state)
{
    struct bench *self = *state;
    open_ring(self, "0DEG", K3_MANY);
    for (size_t i = 0; i < DG_COUNT(functions); i++) {
        expect(self, functions[i].request, functions[i].answer, functions[i].length);
    }
    virtual_rig_ask(&self->rig, "STAT?");
    char count[32];
    (void)snprintf(count, sizeof count, "wire_requests=%zu", DG_COUNT(functions));
    assert_non_null(strstr(self->rig.answer, count));
}

/* As many registers as there is room for in 253 bytes: 123, and 121 behind the four words of 23. */
static void longest_requests(void **state)
{
    static const struct {
        const char *head; /* FC 16 or 23, of as many words as follow */
        size_t words;
        uint8_t first;
        const char *answer;
        size_t length;
    } rows[] = {
        {"10 0800 007B F6", 123, 0x21, "10 0800 007B", 5},
        {"17 0801 007D 0800 0079 F2", 121, 0x42, "17 FA 0043 0044", 252},
    };
    struct bench *self = *state;
    open_ring(self, "0DEG", K3_MANY);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        char request[2u * PDU_MAX + 16u];
        size_t at = (size_t)snprintf(request, sizeof request, "%s ", rows[i].head);
        for (size_t k = 0; k < rows[i].words; k++) {
            at += (size_t)snprintf(request + at, sizeof request - at, "%04zX", rows[i].first + k);
        }
        expect(self, request, rows[i].answer, rows[i].length);
        assert_int_equal(get(self, (uint16_t)(0x0800u + rows[i].words - 1u)),
                         rows[i].first + rows[i].words - 1u);
    }
    assert_int_equal(get(self, 0x0800 + 122), 0x21 + 122); /* beyond what was written last */
    uint8_t longest[PDU_MAX] = {0x41};
    uint8_t answer[PDU_MAX];
    assert_int_equal(ask(self, longest, sizeof longest, answer), 2);
    assert_int_equal(answer[0], 0xC1);
    assert_int_equal(answer[1], 1);
}

/* --- streams --- */

/* Requests come as TCP likes: in pieces, several at once, more than one buffer has room for. */
static void requests_in_pieces_and_at_once(void **state)
{
    static const uint8_t pdu[] = {4, 0x10, 0x0C, 0, 1};
    struct bench *self = *state;
    uint8_t bytes[50u * (HEADER + sizeof pdu)];
    uint8_t answer[PDU_MAX];
    open_ring(self, "0DEG", 1);
    const size_t n = wrap(self, pdu, sizeof pdu, bytes);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(self->heard_count, 0);
        virtual_rig_say(&self->rig, &bytes[i], 1);
    }
    assert_int_equal(take_answer(self, self->number, answer), 4);
    size_t all = 0;
    const uint16_t before = self->number;
    for (int i = 0; i < 50; i++) {
        all += wrap(self, pdu, sizeof pdu, bytes + all);
    }
    virtual_rig_say(&self->rig, bytes, all - 1u);
    for (uint16_t i = 1; i < 50; i++) {
        assert_int_equal(take_answer(self, before + i, answer), 4);
    }
    assert_int_equal(self->heard_count, 0);
    virtual_rig_say(&self->rig, bytes + all - 1u, 1);
    assert_int_equal(take_answer(self, before + 50u, answer), 4);
}

/* Whether the other side has said that nothing more comes. */
static bool has_ended(int line)
{
    uint8_t byte = 0;
    return recv(line, &byte, 1, MSG_DONTWAIT | MSG_PEEK) == 0;
}

/* One more client; it is the master then. @return its connection */
static int join(struct bench *self)
{
    virtual_rig_connect(&self->rig);
    return self->rig.line;
}

/* What is no Modbus: another protocol, no function code, more than a request may have. */
static void what_is_no_modbus_ends_the_stream(void **state)
{
    static const struct {
        const char *bytes;
        bool ends;
    } rows[] = {
        {"0001 0001 0002 11", true},  {"0001 0100 0002 11", true},  {"0001 0000 0000 11", true},
        {"0001 0000 0001 11", true},  {"0001 0000 00FF 11", true},  {"0001 0000 0102 11", true},
        {"0001 0000 00FE 11", false}, {"0001 0000 0002 11", false}, {"0001 0001 0002", false},
    };
    struct bench *self = *state;
    open_ring(self, "0DEG", 1);
    const int first = self->rig.line;
    const unsigned open = descriptors_open();
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        uint8_t bytes[16];
        const size_t n = hf_rig_hex(rows[i].bytes, bytes, sizeof bytes);
        const int line = join(self);
        virtual_rig_say(&self->rig, bytes, n);
        assert_int_equal(has_ended(line), rows[i].ends);
        (void)close(line);
        self->rig.line = -1;
        virtual_rig_serve(&self->rig);
        assert_int_equal(descriptors_open(), open);
    }
    self->rig.line = first;
    assert_int_equal(get(self, 0x1010), 48);
}

static const uint8_t garbage[HEADER] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};

/* Who was told so may still send, 64 KiB and two seconds, and is closed then. */
static void who_is_sent_away_has_two_seconds(void **state)
{
    struct bench *self = *state;
    open_ring(self, "0DEG", 1);
    const int first = self->rig.line;
    const unsigned open = descriptors_open();
    const dg_ns begin = lx_now();
    const int one = join(self);
    virtual_rig_say(&self->rig, garbage, sizeof garbage);
    virtual_rig_pass(&self->rig, DG_S(1));
    const int two = join(self);
    virtual_rig_say(&self->rig, garbage, sizeof garbage);
    assert_int_equal(descriptors_open(), open + 4u); /* both ends */
    virtual_rig_pass_to(&self->rig, begin + FAREWELL - 1u);
    assert_int_equal(descriptors_open(), open + 4u);
    virtual_rig_pass(&self->rig, 1);
    assert_int_equal(descriptors_open(), open + 3u);
    virtual_rig_pass_to(&self->rig, begin + DG_S(1) + FAREWELL - 1u);
    assert_int_equal(descriptors_open(), open + 3u);
    virtual_rig_pass(&self->rig, 1);
    assert_int_equal(descriptors_open(), open + 2u);
    (void)close(one);
    (void)close(two);
    self->rig.line = first;
    assert_int_equal(get(self, 0x1010), 48);
}

static void who_is_sent_away_may_send_so_much(void **state)
{
    static const uint8_t chunk[CHUNK];
    struct bench *self = *state;
    open_ring(self, "0DEG", 1);
    const int first = self->rig.line;
    const unsigned open = descriptors_open();
    const int line = join(self);
    virtual_rig_say(&self->rig, garbage, sizeof garbage);
    for (size_t i = 0; i < FAREWELL_BYTES / CHUNK; i++) {
        virtual_rig_say(&self->rig, chunk, sizeof chunk);
    }
    assert_int_equal(descriptors_open(), open + 2u);
    assert_int_equal(send(line, chunk, 1, MSG_NOSIGNAL), 1);
    virtual_rig_serve(&self->rig);
    assert_int_equal(descriptors_open(), open + 1u);
    (void)close(line);
    self->rig.line = first;
}

/* --- places --- */

/* As many clients as there are places, each a millisecond after the one before. */
static void fill_places(struct bench *self, int line[CLIENTS_MAX])
{
    line[0] = self->rig.line;
    for (size_t i = 1; i < CLIENTS_MAX; i++) {
        virtual_rig_pass(&self->rig, DG_MS(1));
        line[i] = join(self);
    }
}

/* All but the two with these indices are there. */
static void expect_ended(const int line[CLIENTS_MAX], size_t one, size_t two)
{
    for (size_t i = 0; i < CLIENTS_MAX; i++) {
        assert_int_equal(has_ended(line[i]), i == one || i == two);
    }
}

static void the_most_silent_gives_up_its_place(void **state)
{
    int line[CLIENTS_MAX];
    struct bench *self = *state;
    open_ring(self, "0DEG", 1);
    fill_places(self, line);
    for (size_t i = 0; i < CLIENTS_MAX; i++) {
        virtual_rig_pass(&self->rig, DG_MS(1));
        self->rig.line = line[CLIENTS_MAX - 1u - i];
        if (i != 20 && i != 3) {
            (void)get(self, 0x1010);
        }
    }
    expect_ended(line, CLIENTS_MAX, CLIENTS_MAX);
    const int late = join(self); /* 11 has said nothing since it came, 28 came later */
    assert_int_equal(get(self, 0x1010), 48);
    expect_ended(line, 11, CLIENTS_MAX);
    self->rig.line = line[30]; /* who is told to leave goes first */
    virtual_rig_say(&self->rig, garbage, sizeof garbage);
    const unsigned open = descriptors_open();
    const int later = join(self);
    assert_int_equal(get(self, 0x1010), 48);
    assert_int_equal(descriptors_open(), open + 1u); /* one has come, and one is closed */
    assert_false(has_ended(line[28]));
    self->rig.line = line[28];
    assert_int_equal(get(self, 0x1010), 48);
    for (size_t i = 0; i < CLIENTS_MAX - 1u; i++) {
        (void)close(line[i]);
    }
    (void)close(late);
    (void)close(later);
    self->rig.line = line[CLIENTS_MAX - 1u];
    virtual_rig_serve(&self->rig);
    assert_int_equal(get(self, 0x1010), 48);
}

/* RFC 1122, 4.2.3.4: without it, an answer waits for the acknowledgement of the one before. */
static void answers_do_not_wait(void **state)
{
    struct bench *self = *state;
    unsigned quick = 0;
    open_ring(self, "0DEG", 1);
    for (int fd = 0; fd < 256; fd++) {
        struct sockaddr_in peer;
        socklen_t size = sizeof peer;
        int on = 0;
        socklen_t on_size = sizeof on;
        quick += fd != self->rig.line && getpeername(fd, (struct sockaddr *)&peer, &size) == 0 &&
                 getsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, &on_size) == 0 && on != 0;
    }
    assert_int_equal(quick, 1); /* the rig's end */
}

/* --- cycles --- */

/* What a shaft at one turn a second has come to. */
static uint32_t position_at(dg_ns since_begin)
{
    return (uint32_t)(since_begin * STEPS / DG_S(1));
}

/* IN is what the latest cycle has latched, and each cycle is counted, though none is watched. */
static void what_is_read_is_of_the_latest_cycle(void **state)
{
    static const dg_ns moments[] = {
        CYCLE,         CYCLE + 1,      2 * CYCLE - 1,     2 * CYCLE,
        3 * CYCLE + 1, 10 * CYCLE - 1, 10 * CYCLE,        123 * CYCLE + 456789,
        DG_S(1) - 1,   DG_S(1),        DG_S(60) + 999999, DG_S(3600) - 1,
    };
    struct bench *self = *state;
    open_ring(self, "60RPM", 2);
    for (size_t i = 0; i < DG_COUNT(moments); i++) {
        const uint64_t cycles = moments[i] / CYCLE;
        pass_to(self, moments[i]);
        assert_int_equal(get_pair(self, 0x0001), position_at(cycles * CYCLE));
        assert_int_equal(get(self, 0x0000), position_at(cycles * CYCLE) % STEPS);
        assert_int_equal(get_pair(self, 0x2002), cycles);
        assert_int_equal(get_pair(self, 0x2022), cycles);
        assert_int_equal(get_pair(self, 0x1014), 0);
        assert_int_equal(get(self, 0x100C), 1);
    }
}

/* It fires in the first cycle that is later than its time, whether or not anybody asks: the ring
   stops, and goes on with the cycle after its reset, or after OUT is written. */
static void the_watchdog_fires_in_a_cycle(void **state)
{
    static const struct {
        dg_ns fed; /* since a whole second */
        uint32_t cycles;
        bool asked;
    } rows[] = {
        {300000, 100, true}, {300000, 100, false},    {0, 100, true},
        {0, 100, false},     {CYCLE - 1, 100, false},
    };
    struct bench *self = *state;
    open_ring(self, "0DEG", 1);
    put_register(self, 0x1120, 100);
    put_register(self, 0x1122, 0);
    put_register(self, 0x1123, 2);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const dg_ns second = (i + 1u) * DG_S(10);
        const dg_ns fed = second + rows[i].fed;
        pass_to(self, fed);
        put_register(self, 0x0800, 0);
        assert_int_equal(get(self, 0x1020), 100);
        const uint32_t before = get_pair(self, 0x2002);
        const dg_ns fires = second + (rows[i].cycles + 1u) * CYCLE;
        if (rows[i].asked) {
            pass_to(self, fed + 1);
            assert_int_equal(get(self, 0x1020), 99);
            pass_to(self, fed + DG_MS(99));
            assert_int_equal(get(self, 0x1020), 1);
            pass_to(self, fed + DG_MS(100) - 1);
            assert_int_equal(get(self, 0x1020), 0);
            pass_to(self, fires - 1);
            assert_int_equal(get(self, 0x1121), 0);
            assert_int_equal(get(self, 0x100C), 1);
            pass_to(self, fires);
            assert_int_equal(get(self, 0x1121), 1);
            assert_int_equal(get(self, 0x100C), 0);
        }
        pass_to(self, second + DG_S(5));
        assert_int_equal(get(self, 0x1121), 1);
        assert_int_equal(get_pair(self, 0x2002) - before, rows[i].cycles);
        put_register(self, 0x1121, 0xBECF);
        put_register(self, 0x1121, 0xAFFE);
        assert_int_equal(get(self, 0x1121), 0);
        pass_to(self, second + DG_S(5) + 2 * CYCLE);
        assert_int_equal(get_pair(self, 0x2002) - before, rows[i].cycles + 2u);
    }
}

static void expect_counters(struct bench *self, const char *text)
{
    virtual_rig_ask(&self->rig, "STAT?");
    if (strstr(self->rig.answer, text) == NULL) {
        fail_msg("%s: no %s", self->rig.answer, text);
    }
}

/* The first cycle finds a ring that is to be identified; a damaged one is an error, one that does
   not take place is nothing, and while the ring is cut it is identified again in each. */
static void cycles_are_counted_by_what_came_of_them(void **state)
{
    struct bench *self = *state;
    open_ring(self, "0DEG", 1);
    pass_to(self, DG_S(1));
    assert_int_equal(get(self, 0x1010), 48);
    expect_counters(self, "wire_up=1,wire_late=0,wire_cycles=1001,wire_ids=1,wire_crc_errors=0,"
                          "wire_interrupted=0,wire_requests=1,");
    virtual_rig_order(&self->rig, "INST:SEL e0");
    virtual_rig_order(&self->rig, "FAUL:SET wire_damage,COUN,2");
    pass_to(self, DG_S(2));
    expect_counters(self, "wire_ids=1,wire_crc_errors=2,wire_interrupted=0,");
    assert_int_equal(get_pair(self, 0x2004), 0); /* it is behind the one that hears it */
    assert_int_equal(get_pair(self, 0x2014), 2);
    const uint32_t before = get_pair(self, 0x2002);
    virtual_rig_order(&self->rig, "FAUL:SET wire_drop,COUN,7");
    pass_to(self, DG_S(3));
    assert_int_equal(get_pair(self, 0x2002) - before, 1000 - 7);
    virtual_rig_order(&self->rig, "FAUL:SET wire_break");
    pass_to(self, DG_S(3) + 20 * CYCLE);
    assert_int_equal(get(self, 0x100C), 2 | 8);
    assert_int_equal(get(self, 0x2000), 0x0136);
    assert_int_equal(get(self, 0x2010), 0);
    expect_counters(self, "wire_ids=21,wire_crc_errors=2,wire_interrupted=20,");
    virtual_rig_order(&self->rig, "FAUL:CLE wire_break");
    pass_to(self, DG_S(3) + 22 * CYCLE);
    assert_int_equal(get(self, 0x100C), 1);
    assert_int_equal(get(self, 0x2010), 0x0237);
    expect_counters(self, "wire_ids=22,wire_crc_errors=2,wire_interrupted=20,");
}

/* --- a slow disk --- */

/* OUT of the last one; the K1 has a word before it. */
static void put_out(struct bench *self, uint32_t out)
{
    const uint8_t pdu[] = {
        16,          8, 1, 0, 2, 4, (uint8_t)(out >> 24), (uint8_t)(out >> 16), (uint8_t)(out >> 8),
        (uint8_t)out};
    uint8_t answer[PDU_MAX];
    assert_int_equal(ask(self, pdu, sizeof pdu, answer), 5);
}

/* A zero shift is answered when it is on the disk (5.3; page of the port, "what is kept back
   meanwhile"): until then IN is as it was in the cycle before. The ring goes on, and so does its
   neighbour. */
static void an_answer_waits_for_the_disk(void **state)
{
    struct bench *self = *state;
    char key[SLOW_DISK_KEY];
    slow_disk_make_folder(self->folder, key);
    open_ring_with(self, "60RPM", 1, key);
    for (uint32_t shift = 1; shift <= 2; shift++) {
        const uint32_t command = 0x0A000000 | shift;
        const dg_ns begin = shift * DG_S(10);
        pass_to(self, begin);
        slow_disk_take();
        put_out(self, command);
        const uint32_t before = get_pair(self, 0x0001);
        for (dg_ns at = begin; at < begin + 20 * CYCLE; at += CYCLE) {
            pass_to(self, at);
            const uint32_t is = get_pair(self, 0x0001);
            assert_true(is >= before && is <= position_at(at) + shift);
        }
        const uint32_t held = get_pair(self, 0x0001);
        pass_to(self, begin + DG_S(1));
        assert_int_equal(get_pair(self, 0x0001), held);
        assert_true(held <= position_at(begin + 5 * CYCLE) + shift); /* of cycles 3 or so */
        assert_int_equal(get(self, 0x0000), position_at(begin + DG_S(1)) % STEPS);
        slow_disk_give();
        const dg_ns end = lx_real_now() + DG_S(10);
        const struct timespec nap = {.tv_nsec = (long)DG_US(100)};
        while (get_pair(self, 0x0001) == held && lx_real_now() < end) {
            (void)nanosleep(&nap, NULL);
            virtual_rig_pass(&self->rig, CYCLE);
        }
        assert_int_equal(get_pair(self, 0x0001), command | 0xC0000000);
        put_out(self, 0x80000000);
        virtual_rig_pass(&self->rig, 10 * CYCLE);
        put_out(self, 0);
        virtual_rig_pass(&self->rig, 10 * CYCLE);
        const dg_ns now = lx_now() - self->begin;
        assert_int_equal(get_pair(self, 0x0001), position_at(now / CYCLE * CYCLE) + shift);
    }
}

/* The file in memory that rigs are read from stays. */
static int note(void **state)
{
    (void)memory_file_write((const uint8_t *)"", 0);
    return descriptors_note(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(functions_and_their_lengths, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(longest_requests, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(requests_in_pieces_and_at_once, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(what_is_no_modbus_ends_the_stream, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(who_is_sent_away_has_two_seconds, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(who_is_sent_away_may_send_so_much, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(the_most_silent_gives_up_its_place, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(answers_do_not_wait, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(what_is_read_is_of_the_latest_cycle, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(the_watchdog_fires_in_a_cycle, make_bench, end_bench),
        cmocka_unit_test_setup_teardown(cycles_are_counted_by_what_came_of_them, make_bench,
                                        end_bench),
        cmocka_unit_test_setup_teardown(an_answer_waits_for_the_disk, make_bench, end_bench),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests_name("the Modbus coupler", tests, note, NULL);
}
