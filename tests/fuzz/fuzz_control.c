/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: two clients of a rig that send anything, while time passes, the host refuses, wires
 * let faults happen and EEPROMs do not acknowledge. The input is a stream of operations. After each
 * one: the sessions are sound, what they answer is printable. In the end a third client resets the
 * rig: nothing is wrong any more, and every encoder answers on its wire, also after a power cycle.
 */
#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "control_rig.h"
#include "drehgeber/instruments.h"
#include "fuzz_input.h"

#define CLIENTS 2u
#define RING 2u
/* Longer than any initialisation, start-up window and self-test. */
#define READY DG_S(2)
#define DEVICE_TYPE 0x1000u

struct bench {
    struct control_rig rig;
    struct dg_control client[CLIENTS];
    char last[CLIENTS]; /* character of its answers */
    struct dg_rig_ops able;
    struct dg_rig_ops unable; /* without what is optional */
    const void *biss_port;
};

/* ------------------------------------------------------------ the host */

static void listen(void *ctx, const char *bytes, size_t n)
{
    char *last = ctx;

    for (size_t i = 0; i < n; i++) {
        fuzz_must(bytes[i] == '\n' || bytes[i] == '\t' || (bytes[i] >= ' ' && bytes[i] <= '~'));
        *last = bytes[i];
    }
}

static void step_devices(struct control_rig *rig)
{
    rig->co.now = rig->now;
    rig->co.count = 0;
    fuzz_must(dg_hf_step(&rig->hf.device, rig->now) > rig->now);
    fuzz_must(dg_co_step(&rig->co.node, rig->now) > rig->now);
    fuzz_must(dg_rig_step(&rig->rig, rig->now) > rig->now);
}

/* Unlike the rig's own, this one lets the time pass. */
static int step_time(struct dg_rig *rig, dg_ns span, char *detail)
{
    struct control_rig *self = rig->host;

    (void)detail;
    if (self->result == DG_SCPI_NO_ERROR) {
        self->now = dg_after(self->now, span);
        step_devices(self);
    }
    return self->result;
}

static void pass(struct bench *bench, dg_ns span)
{
    struct control_rig *rig = &bench->rig;

    rig->now = dg_after(rig->now, span);
    step_devices(rig);
    for (size_t i = 0; i < CLIENTS; i++) {
        const dg_ns next = dg_control_step(&bench->client[i], rig->now);
        fuzz_must(next > rig->now); /* the line that went on may have let time pass */
    }
}

static void connect(struct bench *bench)
{
    for (size_t i = 0; i < CLIENTS; i++) {
        bench->last[i] = '\n';
        dg_control_init(&bench->client[i], &bench->rig.rig, listen, &bench->last[i]);
    }
}

static void set_up(struct bench *bench)
{
    struct control_rig *rig = &bench->rig;

    control_rig_start(rig);
    rig->ops.step = step_time;
    bench->able = rig->ops;
    bench->biss_port = rig->encoder[CONTROL_RIG_BISS].port;
    bench->unable = (struct dg_rig_ops){.changed = rig->ops.changed, .wire = rig->ops.wire};
    connect(bench);
}

/* ------------------------------------------------------------ invariants */

static void check_session(const struct dg_scpi *session, char last)
{
    fuzz_must(session->length <= DG_SCPI_LINE_MAX);
    fuzz_must(session->error_count <= DG_SCPI_ERRORS_MAX);
    fuzz_must(session->error_first < DG_SCPI_ERRORS_MAX);
    fuzz_must(session->selected < CONTROL_RIG_ENCODERS);
    fuzz_must(session->executing == session->waiting);
    fuzz_must(session->command == NULL);
    fuzz_must(session->waiting || last == '\n');
    for (size_t i = 0; i < session->error_count; i++) {
        const struct dg_scpi_queued *error =
            &session->errors[(session->error_first + i) % DG_SCPI_ERRORS_MAX];
        fuzz_must(error->code != 0);
        fuzz_must(memchr(error->detail, '\0', sizeof error->detail) != NULL);
    }
}

static void check(const struct bench *bench)
{
    for (size_t i = 0; i < CLIENTS; i++) {
        check_session(&bench->client[i].session, bench->last[i]);
    }
}

/* All that is sensed lies between the first and the last member, without a gap. */
static bool healthy(const struct dg_world *world)
{
    const size_t first = offsetof(struct dg_world, temperature_mdegc);
    const size_t end = offsetof(struct dg_world, watchdog_fired) + sizeof(bool);
    struct dg_world wanted;

    dg_world_init(&wanted);
    return memcmp((const char *)world + first, (const char *)&wanted + first, end - first) == 0;
}

static void check_encoder(const struct dg_encoder *encoder)
{
    fuzz_must(dg_encoder_powered(encoder));
    fuzz_must(healthy(encoder->world));
    fuzz_must(encoder->faults.wire == 0);
    for (size_t i = 0; i < DG_FAULTS_MAX; i++) {
        fuzz_must(!encoder->faults.fault[i].active);
    }
}

static void check_hiperface(struct control_rig *rig, bool fresh)
{
    rig->hf.now = rig->now;
    const int status = hf_rig_ask(&rig->hf, "42");
    fuzz_must(status != HF_RIG_SILENCE && (status == 0 || !fresh));
}

static void check_biss(struct control_rig *rig)
{
    struct biss_rig *biss = &rig->biss;

    biss->now = rig->now;
    biss_rig_frame(biss, false); /* what a master that went away left behind is over then */
    biss_rig_frame(biss, false);
    const uint64_t data = biss->bits >> 6;
    fuzz_must(biss_rig_crc6(data, biss->data_bits - 6u) == (biss->bits & 0x3Fu));
}

static void check_canopen(struct control_rig *rig)
{
    uint32_t type = 0;

    rig->co.now = rig->now;
    fuzz_must(co_rig_read(&rig->co, DEVICE_TYPE, 0, &type) == 0);
    fuzz_must((type & 0xFFFFu) == 406);
}

static void check_interbus(struct control_rig *rig, bool fresh)
{
    struct dg_ib devices[RING] = {rig->k3.device, rig->k2.device};
    uint32_t in[RING] = {0};

    for (size_t i = 0; i < RING; i++) {
        const uint16_t id = dg_ib_id(&devices[i], rig->now);
        fuzz_must((id & 0xFFu) == (dg_ib_id_word(devices[i].setup.model) & 0xFFu));
        dg_ib_cycle(&devices[i], rig->now, 0, &in[i]);
    }
    fuzz_must(in[0] >> 25 == 0 || !fresh); /* a position, no answer and nothing lost */
}

static void send_line(struct bench *bench, const char *line)
{
    fuzz_must(strcmp(control_rig_say(&bench->rig, line), "") == 0);
    fuzz_must(strncmp(control_rig_say(&bench->rig, "SYST:ERR?"), "0,", 2) == 0);
}

/* @param fresh the power was cycled */
static void check_encoders(struct bench *bench, bool fresh)
{
    pass(bench, READY);
    for (size_t i = 0; i < CONTROL_RIG_ENCODERS; i++) {
        check_encoder(&bench->rig.encoder[i]);
    }
    check_hiperface(&bench->rig, fresh);
    check_biss(&bench->rig);
    check_canopen(&bench->rig);
    check_interbus(&bench->rig, fresh);
}

/* ------------------------------------------------------------ operations */

static void send_bytes(struct bench *bench, size_t client, const char *bytes, size_t n)
{
    (void)dg_control_rx(&bench->client[client], bench->rig.now, bytes, n);
}

/* "SHAFt:POSition" or "SHAF:POS" */
static size_t put_header(char *to, const char *header, bool abbreviated)
{
    size_t n = 0;

    for (; *header != '\0'; header++) {
        if (!abbreviated || islower((unsigned char)*header) == 0) {
            to[n++] = *header;
        }
    }
    return n;
}

static const char *pick_region(const struct dg_fault_target *target, uint8_t which)
{
    return target->layout == NULL
               ? "none"
               : target->layout->regions[which % target->layout->region_count].name;
}

static const char *pick_value(struct fuzz_input *input)
{
    static const char *const values[] = {
        "hf",          "BISS-1",    "can",    "k3",      "k2",         "ON",
        "OFF",         "CYCL",      "0",      "1",       "MIN",        "MAX",
        "-273",        "1.5REV",    "90 DEG", "6000RPM", "-12000",     "1E5RPM/S",
        "1S",          "20MS",      "300US",  "COUN 3",  "PROB 0.5",   "DUR 2S",
        "'a.csv'",     "\"60RPM\"", "#H7F",   "0x40",    "255",        "64",
        "2000",        "-1000",     "3.6V",   "12MA",    "'it''s'",    "0.000001",
        "-4194304REV", "1E9",       "86400S", "",        "\"a\tb\\\"", "COUN 1,DUR 1NS",
        "0,1,1S,0",    "LOOP",      "STEP",   "0,0",     "2MS,1",      "1,0,LOOP",
    };

    return values[fuzz_take(input) % DG_COUNT(values)];
}

/* Of the encoder that the client has selected. */
static int put_parameter(const struct bench *bench, size_t client, struct fuzz_input *input,
                         char *to, size_t size)
{
    enum { VALUE, FAULT, REGION, PLAIN, WAYS };
    const uint32_t selected = bench->client[client].session.selected;
    const struct dg_fault_target target = dg_encoder_target(&bench->rig.encoder[selected]);
    const uint8_t way = fuzz_take(input) % WAYS;
    struct dg_fault_entry entry;

    if (way == FAULT && dg_fault_entry(&target, fuzz_take(input) % DG_FAULTS_MAX, &entry)) {
        return snprintf(to, size, "%s", entry.name);
    }
    if (way == REGION) {
        return snprintf(to, size, "%s", pick_region(&target, fuzz_take(input)));
    }
    if (way == PLAIN) {
        return snprintf(to, size, "%d", fuzz_take(input) - 100);
    }
    return snprintf(to, size, "%s", pick_value(input));
}

/* Of all commands: of every rig, and of those with BiSS and with courses. */
static const char *pick_header(size_t index)
{
    static const struct dg_scpi_commands *const lists[] = {
        &dg_control_commands,
        &dg_biss_instrument.commands,
        &dg_course_commands,
    };
    size_t total = 0;
    size_t i = 0;

    for (size_t n = 0; n < DG_COUNT(lists); n++) {
        total += lists[n]->count;
    }
    for (index %= total; index >= lists[i]->count; i++) {
        index -= lists[i]->count;
    }
    return lists[i]->rows[index].header;
}

/* A command that exists, with what may be a parameter of it. */
static void op_command(struct bench *bench, struct fuzz_input *input)
{
    static const char *const ends[] = {"\n", "\n", "\n", "\r\n", ";:", ";", ";*WAI;:", ";*OPC?;:"};
    const uint8_t how = fuzz_take(input);
    const size_t client = how & 1u;
    const bool query = (how & 4u) != 0;
    const char *header = pick_header(fuzz_take(input));
    char line[256];
    size_t n = put_header(line, header, (how & 2u) != 0);

    n += (size_t)snprintf(&line[n], sizeof line - n, query ? "?" : "");
    for (uint8_t i = 0; i < (how >> 3 & 3u); i++) {
        n += (size_t)snprintf(&line[n], sizeof line - n, i == 0 ? " " : ",");
        n += (size_t)put_parameter(bench, client, input, &line[n], sizeof line - n);
    }
    n += (size_t)snprintf(&line[n], sizeof line - n, "%s", ends[how >> 5]);
    send_bytes(bench, client, line, n);
}

static void op_common(struct bench *bench, struct fuzz_input *input)
{
    static const char *const lines[] = {
        "*RST\n",       "*OPC\n",  "*OPC?\n", "*WAI\n",    "*CLS\n",           "*ESR?\n",
        "*ESE 255\n",   "*STB?\n", "*IDN?\n", "*SRE 36\n", "*TST?\n",          "SYST:ERR?\n",
        "SYST:HELP?\n", "\n",      ";",       "'",         "SYST:ERR?;ERR?;:",
    };
    const uint8_t how = fuzz_take(input);
    const char *line = lines[(how >> 1) % DG_COUNT(lines)];

    send_bytes(bench, how & 1u, line, strlen(line));
}

static void op_bytes(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);
    const size_t left = (size_t)(input->end - input->at);
    const size_t n = (how >> 1) < left ? (how >> 1) : left;

    send_bytes(bench, how & 1u, (const char *)input->at, n);
    input->at += n;
}

static void op_time(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t shift = fuzz_take(input) % 40u;

    pass(bench, (dg_ns)fuzz_take(input) << shift);
}

/* What the host says to the next commands. */
static void op_host(struct bench *bench, struct fuzz_input *input)
{
    static const int results[] = {
        DG_SCPI_NO_ERROR,         DG_SCPI_NO_ERROR, DG_SCPI_CONFLICT,  DG_SCPI_HARDWARE,
        DG_SCPI_MISSING_HARDWARE, DG_SCPI_STORAGE,  DG_SCPI_FILE_NAME, DG_SCPI_ILLEGAL,
    };
    struct control_rig *rig = &bench->rig;
    const uint8_t how = fuzz_take(input);

    rig->result = results[how % DG_COUNT(results)];
    rig->ops = how >= 0xC0 ? bench->unable : bench->able;
    rig->encoder[CONTROL_RIG_BISS].port = how >= 0xC0 ? NULL : bench->biss_port;
    rig->lines = fuzz_take(input);
    rig->frame = rig->frame << 8 | fuzz_take(input);
    rig->frame_bits = fuzz_take(input);
    rig->bytes[how % sizeof rig->bytes] = rig->frame_bits;
}

/* A frame on a wire, as a port looks for faults. */
static void op_frame(struct bench *bench, struct fuzz_input *input)
{
    struct dg_faults *faults = &bench->rig.encoder[fuzz_take(input) % CONTROL_RIG_ENCODERS].faults;
    uint8_t frames = fuzz_take(input);

    for (; frames > 0; frames--) {
        const enum dg_wire_fault fault = (enum dg_wire_fault)(frames % DG_WIRE_FAULT_COUNT);
        fuzz_must(!dg_fault_wire_takes(faults, fault) ||
                  faults->fault[faults->slot[fault]].happened > 0);
    }
}

static void set_memory(struct control_rig *rig, uint8_t dead)
{
    struct ram_nvm *const memories[] = {&rig->hf.nvm, &rig->biss.nvm[0], &rig->co.nvm,
                                        &rig->k3.nvm};

    for (size_t i = 0; i < DG_COUNT(memories); i++) {
        memories[i]->no_acknowledge = (dead >> i & 1u) != 0;
    }
}

static void op_memory(struct bench *bench, struct fuzz_input *input)
{
    set_memory(&bench->rig, fuzz_take(input));
}

/* ------------------------------------------------------------ the end */

static void restore(struct bench *bench)
{
    struct control_rig *rig = &bench->rig;

    rig->result = DG_SCPI_NO_ERROR;
    rig->ops = bench->able;
    rig->encoder[CONTROL_RIG_BISS].port = bench->biss_port;
    set_memory(rig, 0);
    connect(bench); /* anew: what a line that waits still has to say is not said any more */
    send_line(bench, "*RST;:SHAF:ACC 0;POS 0");
}

static void cycle_power(struct bench *bench)
{
    char line[64];

    for (size_t i = 0; i < CONTROL_RIG_ENCODERS; i++) {
        (void)snprintf(line, sizeof line, "INST:SEL %s;:POW CYCL", bench->rig.encoder[i].name);
        send_line(bench, line);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct bench *, struct fuzz_input *) = {
        op_command, op_command, op_command, op_command, op_command, op_common,
        op_bytes,   op_bytes,   op_time,    op_host,    op_frame,   op_memory,
    };
    static struct bench bench;
    static struct bench fresh; /* a copy is much faster than making one */
    static bool made;
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    if (!made) {
        set_up(&bench);
        fresh = bench;
        made = true;
    }
    bench = fresh;
    while (input.at < input.end) {
        operations[fuzz_take(&input) % DG_COUNT(operations)](&bench, &input);
        check(&bench);
    }
    restore(&bench);
    check_encoders(&bench, false);
    cycle_power(&bench);
    check_encoders(&bench, true);
    return 0;
}
