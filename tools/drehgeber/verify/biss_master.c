/* SPDX-License-Identifier: MIT */
/* BiSS C master. Frame indices k are those of the control frame: k = 0 carries the start bit S. */
#include "biss_master.h"

#include <string.h>

/* Longest processing time of single-cycle data, and longest BiSS timeout. */
#define BUSY_S_MAX DG_US(40)
#define TIMEOUT_MAX DG_US(40)
#define BUSY_R_MAX DG_MS(20)
/* So often SL is looked at in the longest timeout: every 20 ns, unless the line is slow. */
#define POLLS 2000u
#define SILENT_FRAMES 14u

/* --- check sums ---------------------------------------------------------------------------- */

/* Long division, bit by bit, of the message times x^width. */
static uint8_t divide_bits(const char *bits, size_t n, unsigned polynomial, unsigned width)
{
    unsigned remainder = 0;

    for (size_t i = 0; i < n + width; i++) {
        remainder = remainder << 1 | (i < n && bits[i] == '1' ? 1u : 0u);
        if ((remainder >> width & 1u) != 0) {
            remainder ^= polynomial;
        }
    }
    return (uint8_t)remainder;
}

uint8_t biss_crc4(const char *bits, size_t n)
{
    return divide_bits(bits, n, 0x13u, 4);
}

uint8_t biss_crc6(const char *bits, size_t n)
{
    return divide_bits(bits, n, 0x43u, 6);
}

static uint64_t value_of_bits(const char *bits, size_t n)
{
    uint64_t value = 0;

    for (size_t i = 0; i < n; i++) {
        value = value << 1 | (bits[i] == '1' ? 1u : 0u);
    }
    return value;
}

/* Appends `n` bits of `value`. */
static char *spell(char *to, unsigned value, unsigned n)
{
    while (n > 0) {
        n--;
        *to++ = (value >> n & 1u) != 0 ? '1' : '0';
    }
    *to = '\0';
    return to;
}

/* --- edges --------------------------------------------------------------------------------- */

void biss_master_init(struct biss_master *self, struct biss_line line, dg_ns now)
{
    memset(self, 0, sizeof *self);
    self->line = line;
    self->now = now;
    self->period_ns = 1000;
    self->timeout_max = TIMEOUT_MAX;
    self->ma = true;
    self->sl = true;
    self->noise = 1;
}

static dg_ns half_period(struct biss_master *self)
{
    dg_ns half = self->period_ns / 2u;
    dg_ns swing = half * self->jitter_percent / 100u;

    self->noise = self->noise * 1664525u + 1013904223u;
    return half - swing + (self->noise >> 8) % (2u * swing + 1u);
}

bool biss_master_edge(struct biss_master *self, bool level)
{
    self->now += half_period(self);
    self->ma = level;
    self->sl = self->line.ma(self->line.ctx, self->now, level);
    return self->sl;
}

/* A clock: falling and rising edge. @return the bit of the clock before: SL 1 ns before the rising
 * edge. It may not have changed since the clock before began. */
static bool next_clock(struct biss_master *self, struct biss_frame *frame)
{
    bool before = self->sl;
    dg_ns half = half_period(self);
    bool bit;

    (void)biss_master_edge(self, false);
    bit = self->line.sl(self->line.ctx, self->now + half - 1u);
    frame->falling_changes += bit != before ? 1u : 0u;
    self->now += half;
    self->ma = true;
    self->sl = self->line.ma(self->line.ctx, self->now, true);
    return bit;
}

/* --- single-cycle data --------------------------------------------------------------------- */

static void decode(const struct biss_channel *channel, const char *bits, struct biss_word *word)
{
    size_t position = (size_t)channel->mt_bits + channel->st_bits;
    size_t data = position + 2u + channel->lc_bits;

    word->position = value_of_bits(bits, position);
    word->n_error = bits[position] == '1';
    word->n_warning = bits[position + 1] == '1';
    word->lc = (uint8_t)value_of_bits(bits + position + 2, channel->lc_bits);
    word->crc = (uint8_t)value_of_bits(bits + data, 6);
    word->crc_good = (biss_crc6(bits, data) ^ word->crc) == 0x3Fu;
}

static size_t channel_bits(const struct biss_channel *channel)
{
    return (size_t)channel->mt_bits + channel->st_bits + 2u + channel->lc_bits + 6u;
}

/* e1 and e2. */
static void clock_ack(struct biss_master *self, struct biss_frame *frame)
{
    bool idle = next_clock(self, frame) || self->fresh;

    self->fresh = false;
    frame->latch = self->now;
    frame->acknowledged = next_clock(self, frame) && idle && !self->sl;
}

/* e1, e2, and clocks up to the start bit. */
static void clock_to_start(struct biss_master *self, struct biss_frame *frame)
{
    dg_ns patience;

    clock_ack(self, frame);
    frame->start_edge = 2;
    /* Every slave delays the start bit by a clock of its own. */
    patience = frame->latch + BUSY_S_MAX + (BISS_SLAVES_MAX + 2u) * self->period_ns;
    while (frame->acknowledged && !self->sl && self->now < patience) {
        (void)next_clock(self, frame);
        frame->start_edge++;
    }
    frame->started = frame->acknowledged && self->sl;
}

void biss_master_clock(struct biss_master *self, struct biss_frame *frame)
{
    size_t total = 0;
    size_t at = 0;

    memset(frame, 0, sizeof *frame);
    for (size_t i = 0; i < self->channel_count; i++) {
        total += channel_bits(&self->channels[i]);
    }
    clock_to_start(self, frame);
    if (!frame->started) {
        return;
    }
    (void)next_clock(self, frame);
    frame->cds = next_clock(self, frame) != (self->disturbed == 1);
    self->disturbed -= self->disturbed > 0 ? 1u : 0u;
    for (size_t i = 0; i < total && i + 1 < sizeof frame->bits; i++) {
        frame->bits[i] = next_clock(self, frame) ? '1' : '0';
    }
    frame->stopped = !self->sl;
    for (unsigned i = 0; i < self->extra_clocks; i++) {
        (void)next_clock(self, frame);
        frame->stopped = frame->stopped && !self->sl;
    }
    for (size_t i = 0; i < self->channel_count; i++) {
        decode(&self->channels[i], frame->bits + at, &frame->words[i]);
        at += channel_bits(&self->channels[i]);
    }
}

static void record(struct biss_master *self, bool cdm, bool cds)
{
    if (self->recorded < BISS_RECORD_MAX) {
        self->cdm[self->recorded] = cdm ? '1' : '0';
        self->cds[self->recorded] = cds ? '1' : '0';
        self->recorded++;
        self->cdm[self->recorded] = '\0';
        self->cds[self->recorded] = '\0';
    }
}

/* What is wrong with a frame that has ended, in words; NULL: nothing. */
static const char *fault_of(const struct biss_master *self, const struct biss_frame *frame)
{
    const char *fault = !frame->acknowledged         ? "no Ack"
                        : !frame->started            ? "no start bit within 40 us"
                        : frame->falling_changes > 0 ? "SL changes between rising edges"
                        : !frame->stopped            ? "no 0 after the CRC"
                        : !frame->timed_out          ? "no end of the timeout"
                                                     : NULL;

    for (size_t i = 0; fault == NULL && i < self->channel_count; i++) {
        fault = frame->words[i].crc_good ? NULL : "wrong CRC";
    }
    return fault;
}

void biss_master_end(struct biss_master *self, struct biss_frame *frame, bool cdm)
{
    dg_ns last;

    if (cdm) {
        (void)biss_master_edge(self, false);
    }
    last = self->now;
    while (!self->sl && self->now < last + self->timeout_max) {
        self->now += self->timeout_max / POLLS;
        self->sl = self->line.sl(self->line.ctx, self->now);
    }
    frame->timed_out = self->sl;
    frame->timeout = self->now - last;
    if (cdm) {
        (void)biss_master_edge(self, true);
    }
    self->now += self->period_ns;
    self->sl = self->line.sl(self->line.ctx, self->now);
    const char *fault = fault_of(self, frame);
    self->bad_frames += fault != NULL ? 1u : 0u;
    self->fault = fault != NULL ? fault : self->fault;
    self->frames++;
    record(self, cdm, frame->cds);
}

void biss_master_frame(struct biss_master *self, struct biss_frame *frame, bool cdm)
{
    biss_master_clock(self, frame);
    biss_master_end(self, frame, cdm);
}

void biss_master_reduced(struct biss_master *self, struct biss_frame *frame, bool cdm)
{
    unsigned bad = self->bad_frames;

    memset(frame, 0, sizeof *frame);
    clock_ack(self, frame);
    biss_master_end(self, frame, cdm);
    /* It has neither start bit nor data to be judged by. */
    self->bad_frames = bad + (frame->acknowledged && frame->timed_out ? 0u : 1u);
}

/* --- control frames ------------------------------------------------------------------------ */

void biss_master_record(struct biss_master *self)
{
    self->recorded = 0;
    self->cdm[0] = '\0';
    self->cds[0] = '\0';
}

void biss_master_bits(struct biss_master *self, const char *cdm)
{
    struct biss_frame frame;

    for (; *cdm != '\0'; cdm++) {
        biss_master_frame(self, &frame, *cdm == '1');
    }
}

/* Frames for the characters of `cdm`. @return their CDS as a number */
static unsigned exchange_frames(struct biss_master *self, const char *cdm)
{
    struct biss_frame frame;
    unsigned cds = 0;

    for (; *cdm != '\0'; cdm++) {
        biss_master_frame(self, &frame, *cdm == '1');
        cds = cds << 1 | (frame.cds ? 1u : 0u);
    }
    return cds;
}

static void silence(struct biss_master *self, bool reduced)
{
    struct biss_frame frame;

    for (unsigned i = 0; i < SILENT_FRAMES; i++) {
        if (reduced) {
            biss_master_reduced(self, &frame, false);
        } else {
            biss_master_frame(self, &frame, false);
        }
    }
    biss_master_record(self);
}

/* IDL0 comes first, in frame 1; frames 0..15 are in `cds`. */
static uint16_t id_locks(unsigned cds)
{
    uint16_t idl = 0;

    for (unsigned n = 0; n <= 8; n++) {
        idl |= (uint16_t)((cds >> (14u - n) & 1u) << n);
    }
    return idl;
}

/* Repeats S until CDS brings it, then sends the first bit of the byte in the same frame.
 * @return whether it came */
static bool await_slave_start(struct biss_master *self, struct biss_access *access, bool first_bit)
{
    dg_ns until = self->now + (access->patience > 0 ? access->patience : BUSY_R_MAX);
    struct biss_frame frame;

    biss_master_clock(self, &frame);
    while (!frame.cds && self->now < until) {
        access->busy[access->done]++;
        biss_master_end(self, &frame, true);
        biss_master_clock(self, &frame);
    }
    access->late = !frame.cds;
    biss_master_end(self, &frame, frame.cds && (first_bit || (self->stray && !access->write)));
    return frame.cds;
}

/* One byte, 14 frames from the one behind S: data, CRC, P; the frame that receives P sends S when
 * `more` and P is 0.
 *
 *  CDM   D7 D6 .. D0 C3 .. C0 P   S|0     (read: all 0)
 *  CDS   S  D7 .. D1 D0 C3.. C1 C0 P
 */
static bool exchange_register_byte(struct biss_master *self, struct biss_access *access, bool more)
{
    uint8_t data = access->data[access->done];
    char sent[16] = "000000000000";
    char got[16];
    struct biss_frame frame;

    if (access->write) {
        char *end = spell(sent, data, 8);

        (void)spell(end, (biss_crc4(sent, 8) ^ 0xFu) ^ access->data_flips, 4);
    }
    if (!await_slave_start(self, access, sent[0] == '1')) {
        return false;
    }
    /* Frames 20..31: CDM D6..D0, CRC, P; CDS D7..D0, CRC. */
    for (size_t i = 0; i < 12; i++) {
        biss_master_frame(self, &frame, i < 11 && sent[i + 1] == '1');
        got[i] = frame.cds ? '1' : '0';
    }
    access->data[access->done] = (uint8_t)value_of_bits(got, 8);
    access->crc_good = access->crc_good &&
                       (access->write ? memcmp(got, sent, 12) == 0
                                      : (biss_crc4(got, 8) ^ value_of_bits(got + 8, 4)) == 0xFu);
    access->done++;
    biss_master_clock(self, &frame);
    access->stop = frame.cds;
    biss_master_end(self, &frame, more && !frame.cds);
    return !frame.cds;
}

/* S, CTS 1, ID, ADR and the CRC over all of these but S: frames 0..15. */
static void exchange_address(struct biss_master *self, struct biss_access *access)
{
    char sent[20];
    char *end = spell(sent, 3, 2);

    end = spell(end, access->id & 7u, 3);
    end = spell(end, access->address & 0x7Fu, 7);
    (void)spell(end, (biss_crc4(sent + 1, 11) ^ 0xFu) ^ access->address_flips, 4);
    access->idl = id_locks(exchange_frames(self, sent));
}

void biss_master_access(struct biss_master *self, struct biss_access *access)
{
    struct biss_frame frame;
    bool granted;

    access->done = 0;
    access->late = false;
    access->stop = false;
    access->crc_good = true;
    memset(access->busy, 0, sizeof access->busy);
    silence(self, false);
    exchange_address(self, access);
    (void)exchange_frames(self, access->write ? "0" : "1");
    access->r = exchange_frames(self, access->write ? "1" : "0") != 0;
    /* Frame 18 brings the echo of W and, when it is not inverted, takes S. */
    biss_master_clock(self, &frame);
    access->w = frame.cds;
    granted = access->r != access->w && access->w == access->write;
    biss_master_end(self, &frame, granted);
    while (granted && access->done < access->n) {
        granted = exchange_register_byte(self, access, access->done + 1 < access->n);
    }
}

static bool control_bit(struct biss_master *self, bool cdm, bool reduced)
{
    struct biss_frame frame;

    if (reduced) {
        biss_master_reduced(self, &frame, cdm);
    } else {
        biss_master_frame(self, &frame, cdm);
    }
    return frame.cds;
}

void biss_master_command(struct biss_master *self, struct biss_command *command)
{
    char sent[24];
    char *end = spell(sent, 2, 2);
    unsigned cds = 0;

    for (unsigned id = 0; id < 8; id++) {
        end = spell(end, (unsigned)command->ids >> id & 1u, 1);
    }
    end = spell(end, command->code & 3u, 2);
    end = spell(end, (biss_crc4(sent + 1, 11) ^ 0xFu) ^ command->crc_flips, 4);
    silence(self, command->reduced);
    for (const char *bit = sent; bit < end; bit++) {
        cds = cds << 1 | (control_bit(self, *bit == '1', command->reduced) ? 1u : 0u);
    }
    command->idl = id_locks(cds);
    command->ida = 0;
    (void)control_bit(self, true, command->reduced);
    if (command->ids == 0) {
        (void)control_bit(self, command->execute, command->reduced);
        return;
    }
    for (unsigned id = 0; id < 8; id++) {
        bool acknowledged = control_bit(self, id == 7 && command->execute, false);

        command->ida |= (uint8_t)((acknowledged ? 1u : 0u) << id);
    }
}
