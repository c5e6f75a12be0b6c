/* SPDX-License-Identifier: MIT */
/*
 * A real encoder with BiSS against its clauses. Rows are frames, register accesses and commands; the
 * same master clocks them for the model, in virtual time, and for the encoder, on two GPIO lines.
 * What the encoder answers has to be what the model answers. Positions are near to each other,
 * the life counter has counted the frames, what is measured may be anything.
 */
#include <string.h>

#include "timer.h"
#include "verify_biss.h"
#include "verify_stream.h"

#define READINGS 20u
#define MOVES_MAX 8u
/* Frames that have to be good before a clock is said to suit the encoder. */
#define FRAMES_GOOD 3u
/* How often something is asked for for which this host was late. */
#define TRIES 5u
/* How long SL is waited for behind a frame: of encoders with their own timeouts, and of ours. */
#define TIMEOUT_FAST DG_MS(10)
#define TIMEOUT_SLOW DG_MS(400)
/* The break behind an error, after which a slave is ready (5.2.1.1-15), and what a host adds to it. */
#define BREAK DG_US(50)
/* Of a control frame: S, CTS, ID, address, CRC; R and W; the start bit behind them. */
#define CTS_AT 1u
#define ID_AT 2u
#define ADDRESS_AT 5u
#define R_AT 16u
#define W_AT 17u

/* --- the line --- */

/* MA goes to `level`. SL follows a rising edge and is looked at before the next one. */
static bool drive_ma(void *ctx, dg_ns now, bool level)
{
    struct biss *self = ctx;
    verify_lines_clock(&self->wire, now, level);
    const dg_ns at = self->wire.edge;
    const bool sl =
        level ? verify_lines_data(&self->wire, at + self->wire.half * 3u / 4u) : self->master.sl;
    self->master.now = at;
    return sl;
}

static bool look_at_sl(void *ctx, dg_ns now)
{
    struct biss *self = ctx;
    return verify_lines_data(&self->wire, now);
}

static bool has_life(const struct biss *self)
{
    return self->model.life_counter;
}

/* LC of the frame that is `n` frames behind one with `life`: 0 only behind a start. */
static int advance_life(int life, unsigned n)
{
    for (; n > 0 && life != LIFE_ANY; n--) {
        life = life == LIFE_START ? 0 : life == 0x3F ? 1 : life + 1;
    }
    return life;
}

static void begin_asking(struct biss *self, unsigned *frames)
{
    verify_lines_begin(&self->wire);
    self->master.sl = verify_lines_data(&self->wire, 0); /* low behind a start */
    self->master.now = lx_real_now();
    self->master.bad_frames = 0;
    *frames = self->master.frames;
}

/* An encoder that is still inside a frame, with SL high, would take the next one for its rest. */
static void make_break(const struct biss *self)
{
    verify_stream_sleep(lx_real_now() + BREAK + self->model.timeout);
}

/* @return whether this host was late: what has come says nothing */
static bool end_asking(struct biss *self, unsigned frames)
{
    const bool torn = verify_lines_torn(&self->wire);
    self->bad = self->master.bad_frames;
    if (self->bad > 0) {
        make_break(self);
    }
    self->expected = advance_life(self->life, self->master.frames - frames);
    self->life = self->bad > 0 ? (int)LIFE_ANY : self->expected;
    return torn;
}

/* The frames of self->frames.cdm. @return whether this host was late, likewise the next ones */
static bool clock_asked_frames(struct biss *self)
{
    unsigned frames = 0;
    begin_asking(self, &frames);
    cf_biss_clock(&self->master, &self->frames);
    const bool torn = end_asking(self, frames);
    const bool known = self->bad == 0 && has_life(self);
    self->life = known ? self->frames.last.words[0].lc : (int)LIFE_ANY;
    return torn;
}

static bool access_registers(struct biss *self)
{
    unsigned frames = 0;
    begin_asking(self, &frames);
    cf_biss_access(&self->master, &self->access);
    return end_asking(self, frames);
}

static bool send_biss_command(struct biss *self)
{
    unsigned frames = 0;
    begin_asking(self, &frames);
    biss_master_command(&self->master, &self->command);
    return end_asking(self, frames);
}

bool verify_biss_frame(struct biss *self)
{
    bool good = false;
    for (unsigned i = 0; !good && i < TRIES && !self->wire.gone; i++) {
        memcpy(self->frames.cdm, "0", 2);
        (void)clock_asked_frames(self);
        good = self->bad == 0;
    }
    return good;
}

static bool transfer_bytes(struct biss *self, const struct cf_biss_access *what)
{
    bool done = false;
    for (unsigned i = 0; !done && i < TRIES && !self->wire.gone; i++) {
        self->access = *what;
        const struct biss_access *access = &self->access.access;

        (void)access_registers(self);
        done = access->done == access->n && access->crc_good && !access->late &&
               (!access->stop || self->model.stop_bit_early);
    }
    return done;
}

bool verify_biss_read(struct biss *self, uint8_t address, uint8_t *bytes, size_t n)
{
    const struct cf_biss_access what = {.access = {.address = address, .n = n}};
    const bool read = transfer_bytes(self, &what);
    memcpy(bytes, self->access.access.data, n);
    return read;
}

bool verify_biss_write(struct biss *self, uint8_t address, const uint8_t *bytes, size_t n)
{
    struct cf_biss_access what = {.access = {.address = address, .n = n, .write = true}};
    memcpy(what.access.data, bytes, n);
    return transfer_bytes(self, &what);
}

/* --- beside the model --- */

static bool report_biss_answer(struct biss *self, const struct cf_unit *got,
                               enum cf_verdict verdict, struct cf_report *report)
{
    char text[3][VERIFY_BISS_TEXT];
    if (verdict == CF_UNKNOWN) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report,
                           "needs an encoder in its delivery state");
    }
    verify_biss_tell(self, got, text);
    return verify_fail(&self->base, self->base.held_up ? VERIFY_NOT_SEEN : VERIFY_DIFFERS, report,
                       "sent%s; expected%s; came%s%s", text[0], text[1], text[2],
                       self->base.held_up ? "; this host was held up" : "");
}

/* Whether a control frame that is given bit for bit is a command, up to what executes it. */
static bool is_command(const char *cdm)
{
    const char *s = strchr(cdm, '1');
    return s != NULL && strlen(s) > R_AT && s[CTS_AT] == '0';
}

/* Commands are noted before they are sent; registers were, when the row began. */
static bool note_sent(struct biss *self, const struct cf_unit *request, struct cf_report *report)
{
    struct verify_journal *journal = self->base.journal;
    const struct biss_access *access = &self->access.access;
    struct cf_unit unit = {.id = COMMAND, .bytes = access->data, .n = 1};
    const bool command = request->id == CF_BISS_COMMAND ||
                         (request->id == CF_BISS_FRAMES && is_command(self->frames.cdm));
    if (command) {
        unit.id = NOTE_COMMAND;
    } else if (request->id != CF_BISS_ACCESS || !access->write || access->address != COMMAND) {
        return true;
    }
    return journal == NULL || self->writes == 0 ||
           (verify_journal_add(journal, false, &unit) && verify_journal_sync(journal)) ||
           verify_fail(&self->base, VERIFY_LOST, report, "the journal cannot be written");
}

static bool on_sent(void *ctx, const struct cf_unit *request, struct cf_report *report)
{
    struct biss *self = ctx;
    const struct {
        void *to;
        size_t size;
        bool (*ask)(struct biss *self);
    } kinds[] = {
        [CF_BISS_FRAMES] = {&self->frames, sizeof self->frames, clock_asked_frames},
        [CF_BISS_ACCESS] = {&self->access, sizeof self->access, access_registers},
        [CF_BISS_COMMAND] = {&self->command, sizeof self->command, send_biss_command},
    };
    if (request->id >= DG_COUNT(kinds) || kinds[request->id].to == NULL) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report, "needs another master");
    }
    memcpy(kinds[request->id].to, request->bytes, kinds[request->id].size);
    verify_biss_print_request(&self->access, self->asked);
    if (!note_sent(self, request, report)) {
        return false;
    }
    self->base.held_up = kinds[request->id].ask(self) || self->base.held_up;
    return !self->wire.gone || verify_fail(&self->base, VERIFY_LOST, report, "the lines are gone");
}

static bool on_answered(void *ctx, const struct cf_answer *answer, struct cf_report *report)
{
    struct biss *self = ctx;
    const enum cf_verdict verdict =
        answer->want.bytes == NULL ? CF_UNKNOWN : verify_biss_judge(self, &answer->got);
    return verdict == CF_AGREES || report_biss_answer(self, &answer->got, verdict, report);
}

static bool on_waited(void *ctx, uint64_t ns, struct cf_report *report)
{
    (void)ctx;
    (void)report;
    verify_stream_sleep(lx_real_now() + ns);
    return true;
}

/* Without supply SL is as it likes, and behind a start low until the first clock. */
static bool on_powered(void *ctx, bool on, struct cf_report *report)
{
    struct biss *self = ctx;
    self->master.fresh = true;
    self->life = LIFE_START;
    return verify_powered(&self->base, on, report);
}

static const struct cf_beside_ops beside_ops = {
    .sent = on_sent,
    .answered = on_answered,
    .waited = on_waited,
    .powered = on_powered,
    .needs = verify_allowed,
};

/* --- rows --- */

static void rehearse(struct verify_encoder *base, const struct cf_beside *beside, dg_ns slack)
{
    struct biss *self = of(base);
    const struct cf_biss_trial trial = {
        .model = &self->model,
        .period_ns = slack > 0 ? self->master.period_ns : 0,
        .timeout_max = self->model.timeout > 0 ? TIMEOUT_SLOW : 0,
        .frame_ns = self->trial.frame_ns,
        .slack = slack,
        .beside = *beside,
    };
    self->writes = 0;
    self->banks = 0;
    self->bank = 0;
    cf_biss_try(&trial);
}

/* Registers that can be put back; what should be refused might not be. */
static unsigned needs_of_write(struct biss *self, uint8_t address, uint8_t byte)
{
    const bool user = self->bank >= DG_BISS_BANK_USER_FIRST && self->bank <= DG_BISS_BANK_USER_LAST;
    const bool config =
        self->bank == 0 && address >= CONFIG_FIRST && address < CONFIG_FIRST + CONFIG_SIZE;
    if (address == BANK_SELECT) {
        self->bank = byte;
        return CF_WRITE;
    }
    if (address == COMMAND) {
        const bool known = byte <= CLEAR && byte != 2u && (byte != STORE || self->delivered);
        return known ? CF_WRITE : CF_WRITE | CF_ONE_WAY;
    }
    if (address < BANK_SELECT && user) {
        self->banks |= (uint32_t)1 << self->bank;
        return CF_WRITE;
    }
    return config || address == TIMEOUT_SELECT ? CF_WRITE : CF_WRITE | CF_ONE_WAY;
}

static unsigned needs_of_access(struct biss *self, const struct biss_access *access)
{
    unsigned needs = access->id != 0 ? CF_ALONE : 0u;
    for (size_t i = 0; access->write && i < access->n; i++) {
        needs |= needs_of_write(self, (uint8_t)(access->address + i), access->data[i]);
    }
    return needs;
}

static unsigned number_of_bits(const char *bits, size_t n)
{
    unsigned value = 0;
    for (size_t i = 0; i < n; i++) {
        value = value << 1 | (bits[i] == '1' ? 1u : 0u);
    }
    return value;
}

/* What a control frame does that is given bit for bit. One that ends before its W does nothing. */
static unsigned needs_of_frames(struct biss *self, const char *cdm)
{
    const char *s = strchr(cdm, '1');
    const size_t n = s == NULL ? 0 : strlen(s);
    if (is_command(cdm)) {
        return CF_ALONE | CF_WRITE;
    }
    if (n <= ADDRESS_AT) {
        return 0;
    }
    const unsigned needs = number_of_bits(s + ID_AT, 3) != 0 ? CF_ALONE : 0u;
    if (n <= W_AT || (s[R_AT] == '1' && s[W_AT] == '0')) {
        return needs;
    }
    return needs | needs_of_write(self, (uint8_t)number_of_bits(s + ADDRESS_AT, 7), UINT8_MAX);
}

static unsigned needs_of(struct verify_encoder *base, const struct cf_unit *request)
{
    struct biss *self = of(base);
    unsigned needs = CF_ALONE | CF_WRITE; /* a command */
    if (request->id == CF_BISS_FRAMES) {
        struct cf_biss_frames frames;
        memcpy(&frames, request->bytes, sizeof frames);
        needs = needs_of_frames(self, frames.cdm);
    } else if (request->id == CF_BISS_ACCESS) {
        struct cf_biss_access access;
        memcpy(&access, request->bytes, sizeof access);
        needs = needs_of_access(self, &access.access);
    }
    self->writes |= needs & (CF_WRITE | CF_ONE_WAY);
    return needs;
}

/* Whatever control frame the encoder is in, this many zeros end it, and its answer. */
static void end_control(struct biss *self)
{
    self->master.fresh = true;
    self->life = LIFE_ANY;
    memset(self->frames.cdm, '0', DG_BISS_ZEROS + 2u);
    self->frames.cdm[DG_BISS_ZEROS + 2u] = '\0';
    (void)clock_asked_frames(self);
}

/* Where it is, and how far its life counter is. */
static bool begin(struct verify_encoder *base, struct cf_report *report)
{
    struct biss *self = of(base);
    end_control(self);
    if (!verify_biss_frame(self)) {
        return verify_fail(base, VERIFY_LOST, report, "it sends no good frame any more");
    }
    if (base->journal != NULL && self->writes != 0 &&
        (!verify_biss_note(self) || !verify_journal_sync(base->journal))) {
        return verify_fail(base, VERIFY_LOST, report, "the journal cannot be written");
    }
    if (!verify_biss_frame(self)) {
        return verify_fail(base, VERIFY_LOST, report, "it sends no good frame any more");
    }
    base->outcome = VERIFY_AGREES;
    self->trial.model = &self->model;
    self->trial.placed = true;
    self->trial.raw = (int64_t)self->frames.last.words[0].position;
    self->trial.beside = (struct cf_beside){&beside_ops, self};
    cf_biss_try(&self->trial);
    return true;
}

/* What has switched its data off is put back behind that. */
static bool end(struct verify_encoder *base, struct cf_report *report)
{
    const enum verify_outcome outcome = base->outcome;
    struct biss *self = of(base);
    self->master.fresh = true;
    const bool there = self->writes != 0 || verify_biss_frame(self);
    base->outcome = there ? outcome : VERIFY_LOST;
    return there || verify_fail(base, VERIFY_LOST, report, "it sends no good frame any more");
}

/* --- the encoder --- */

/* A clock that is too slow for an encoder's own timeout is for one of ours, whose is as slow. */
static void suit_clock(struct biss *self)
{
    const dg_ns half = self->wire.half;
    const bool slow = half > VERIFY_HALF_FAST;
    self->master.period_ns = 2u * half;
    self->master.timeout_max = slow ? TIMEOUT_SLOW : TIMEOUT_FAST;
    self->model.timeout = slow ? 8u * half : 0;
    self->trial.period_ns = self->master.period_ns;
    self->trial.timeout_max = slow ? TIMEOUT_SLOW : 0;
}

/* @return whether frames are good with this clock */
static bool suits_encoder(struct biss *self)
{
    unsigned good = 0;
    suit_clock(self);
    self->master.fresh = true;
    for (unsigned i = 0; i < 2u * FRAMES_GOOD && good < FRAMES_GOOD; i++) {
        memcpy(self->frames.cdm, "0", 2);
        (void)clock_asked_frames(self);
        good += self->bad == 0 ? 1u : 0u;
        self->master.fresh = self->bad > 0;
    }
    return good == FRAMES_GOOD;
}

/* An encoder with a timeout of its own may not follow the clock that settles. */
static int find_biss_clock(struct biss *self, const char *where, struct lx_error *error)
{
    do {
        const dg_ns half = self->wire.half;
        if (suits_encoder(self)) {
            verify_lines_settle(&self->wire);
            if (self->wire.half != half && !suits_encoder(self)) {
                self->wire.half = half;
            }
            suit_clock(self);
            return 0;
        }
        verify_stream_sleep(lx_real_now() + VERIFY_REST_MAX);
    } while (verify_lines_slow_down(&self->wire));
    return lx_refuse(error,
                     "expected MA and SLO of such an encoder, and a host that is fast enough",
                     "%s: no frame with Ack, start bit, the right CRC and timeout", where);
}

/* Flags that are low differ from the model's in each row: the first line says why. */
static void tell_health(struct biss *self, const struct biss_word *word)
{
    const size_t at = strlen(self->base.identity);
    (void)snprintf(self->base.identity + at, sizeof self->base.identity - at, "%s%s",
                   word->n_error ? "" : ", reports an error",
                   word->n_warning ? "" : ", reports a warning");
}

/* How far readings of a shaft at rest are apart; how long a frame takes. */
static int measure_biss_shaft(struct biss *self, const char *where, struct lx_error *error)
{
    const dg_ns from = lx_real_now();
    uint64_t first = 0;
    self->moves = 0;
    for (unsigned i = 0; i < READINGS; i++) {
        if (!verify_biss_frame(self)) {
            return lx_fail(error, "%s: it sends no good frame any more", where);
        }
        const struct biss_word *word = &self->frames.last.words[0];
        first = i == 0 ? word->position : first;
        while (!verify_biss_is_near(self, word->position, first) && self->moves <= MOVES_MAX) {
            self->moves++;
        }
    }
    if (self->moves > MOVES_MAX) {
        return lx_refuse(error, "expected a shaft at rest", "%s: the shaft turns", where);
    }
    self->moves = 2u * self->moves + 1u;
    self->trial.frame_ns = (lx_real_now() - from) / READINGS;
    return 0;
}

/* Serial number and revision are its own; whether the rest is as delivered. */
static int read_identity(struct biss *self, const char *where, struct lx_error *error)
{
    static const uint8_t config[CONFIG_SIZE] = {
        [7] = DG_BISS_EMASK_DEFAULT, [8] = DG_BISS_WMASK_DEFAULT};
    struct dg_biss_model *model = &self->model;
    uint8_t id[8];
    uint8_t serial[4];
    uint8_t bank = 0;
    uint8_t found[CONFIG_SIZE] = {0};
    if (!verify_biss_read(self, 0x78, id, sizeof id) ||
        !verify_biss_read(self, 0x44, serial, sizeof serial) ||
        !verify_biss_read(self, BANK_SELECT, &bank, 1)) {
        return lx_refuse(error, "expected an encoder with registers, its only one in the chain",
                         "%s: it does not answer a register access", where);
    }
    self->delivered = bank == 0 && verify_biss_read(self, CONFIG_FIRST, found, sizeof found) &&
                      memcmp(found, config, sizeof config) == 0;
    model->device_id[5] = id[5];
    model->serial = (uint32_t)serial[0] << 24 | (uint32_t)serial[1] << 16 |
                    (uint32_t)serial[2] << 8 | serial[3];
    (void)snprintf(self->base.serial, sizeof self->base.serial, "%lu",
                   (unsigned long)model->serial);
    (void)snprintf(self->base.identity, sizeof self->base.identity,
                   "device ID %02X %02X %02X %02X %02X %02X %02X %02X, clock %llu Hz%s", id[0],
                   id[1], id[2], id[3], id[4], id[5], id[6], id[7],
                   (unsigned long long)(DG_S(1) / self->master.period_ns),
                   self->delivered ? "" : ", bank 0 not as delivered");
    return 0;
}

static int identify(struct verify_encoder *base, const char *where, struct lx_error *error)
{
    struct biss *self = of(base);
    if (find_biss_clock(self, where, error) != 0 || measure_biss_shaft(self, where, error) != 0) {
        return -1;
    }
    const struct biss_word word = self->frames.last.words[0];
    if (self->model.unidirectional) {
        self->delivered = true;
        (void)snprintf(base->identity, sizeof base->identity, "no registers, clock %llu Hz",
                       (unsigned long long)(DG_S(1) / self->master.period_ns));
    } else if (read_identity(self, where, error) != 0) {
        return -1;
    }
    tell_health(self, &word);
    return 0;
}

/* IDs are locked in every register access: their number is that of encoders with registers. */
static int scan(struct verify_encoder *base, struct lx_error *error)
{
    struct biss *self = of(base);
    const bool silent = self->model.unidirectional;
    uint8_t byte = 0;
    if (!verify_biss_read(self, 0x78, &byte, 1) && !silent) {
        return lx_fail(error, "it does not answer a register access");
    }
    return self->access.access.idl == (silent ? 0u : 1u)
               ? 0
               : lx_refuse(error, "without --alone nobody else is disturbed",
                           "somebody else is in the chain: IDL is %03X",
                           (unsigned)self->access.access.idl);
}

static int open_encoder(struct verify_encoder *base, const struct options *options,
                        struct lx_error *error)
{
    struct biss *self = of(base);
    const struct biss_line line = {drive_ma, look_at_sl, self};
    self->model = *dg_biss_model_of(options->device);
    if (self->model.form != NULL) {
        return lx_refuse(error, "expected position, nERR, nWARN, LC and CRC",
                         "verify has no clauses for frames of another form");
    }
    self->model.layout = NULL;
    self->life = LIFE_ANY;
    biss_master_init(&self->master, line, lx_real_now());
    self->master.channels[0] = (struct biss_channel){
        self->model.multiturn_bits, self->model.singleturn_bits, self->model.life_counter ? 6 : 0};
    self->master.channel_count = 1;
    if (verify_lines_open(&self->wire, options->where, error) != 0) {
        return -1;
    }
    return options->restore ? find_biss_clock(self, options->where, error) : 0;
}

static void close_encoder(struct verify_encoder *base)
{
    cf_biss_try(NULL);
    verify_lines_close(&of(base)->wire);
}

const struct verify_protocol verify_biss = {
    .stack = &dg_biss_stack,
    .suites = {"biss"},
    .choices = "B",
    .writes = "bank 0 (offsets, direction, masks), user banks 7 to 31, 40h, 7Ch, commands to 60h",
    .rows = cf_biss,
    .wire = "gpio",
    .expects = "expected --gpio=CHIP:MA,SLO",
    .size = sizeof(struct biss),
    .open = open_encoder,
    .identify = identify,
    .scan = scan,
    .rehearse = rehearse,
    .needs = needs_of,
    .begin = begin,
    .end = end,
    .put_back = verify_biss_put_back,
    .close = close_encoder,
};
