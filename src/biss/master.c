/* SPDX-License-Identifier: MIT */
/*
 * The master of a BiSS chain: frames, and control frames (5.2.2), which have a bit of theirs in
 * each frame, CDM from the master, CDS from the encoders.
 *
 * Ack tells the master how long a level needs there and back:
 *
 *   MA   _|1|_|2|_|3|_|4|_|5|_      the clocks go on meanwhile
 *   SLO  ---------.___.---....      Ack here, start bit there
 *          e2 ----^ delay           bit n is sampled half a period behind its clock and the delay
 */
#include "drehgeber/biss.h"
#include "drehgeber/bus_master.h"

/* Longer than 100 us at 10 MHz, by which a fault puts off a start bit. */
#define START_CLOCKS_MAX 1200u
/* A real master pauses a little longer than the encoder's timeout. */
#define PAUSE_NS 15000u
/* Rising edges of a frame in front of its data: e1, e2, start bit, CDS. */
#define EDGES_AHEAD 4u
/* A start bit later than this is worth a word. */
#define START_MAX DG_BISS_BUSY_S_MAX_NS
#define ZERO_FRAMES 14u
#define BUSY_MAX_NS 20000000u
#define CTS (1u << 10)
#define ADDRESS_BITS 11u

static const struct dg_biss_model *biss_model_of(const struct dg_bus_master *self, size_t place)
{
    return dg_bus_settings(self->setup.bus, place);
}

static uint32_t count_rises(const struct dg_bus *bus)
{
    uint32_t edges = EDGES_AHEAD;

    for (size_t i = 0; i < dg_bus_count(bus); i++) {
        edges += dg_biss_frame_bits(dg_bus_settings(bus, i));
    }
    return edges;
}

/* ---------------------------------------------------------------- frames */

/* e1 and e2. */
static void await_ack(struct dg_bus_master *self)
{
    self->delay = 0;
    (void)dg_bus_master_bit(self);
    self->latched = self->now;
    (void)dg_bus_master_bit(self);
    const dg_ns fell = dg_bus_edges_fell(self->setup.bus);
    self->answered = fell >= self->now;
    self->delay = self->answered && self->setup.compensates ? fell - self->now : 0;
    self->silent += !self->answered;
}

static uint64_t read_bits(struct dg_bus_master *self, uint8_t count)
{
    uint64_t bits = 0;

    for (uint8_t left = count; left > 0; left--) {
        bits = bits << 1 | dg_bus_master_bit(self);
    }
    return bits;
}

/* Up to the last bit of the last CRC; its CDM bit is not yet decided. @return CDS */
static bool open_frame(struct dg_bus_master *self)
{
    await_ack(self);
    for (unsigned i = 0; i < START_CLOCKS_MAX && !dg_bus_master_bit(self); i++) {
    }
    self->start = self->now - self->latched;
    const dg_ns known = self->now + self->delay + self->half_ns;
    self->cds = dg_bus_master_bit(self);
    for (size_t i = 0; i < dg_bus_count(self->setup.bus); i++) {
        self->bits[i] = read_bits(self, dg_biss_frame_bits(biss_model_of(self, i)));
    }
    /* The master did not know when to end before it had seen the start bit. */
    while (self->now < known) {
        (void)dg_bus_master_bit(self);
    }
    return self->cds;
}

/* With this CDM bit, and the timeout. */
static void close_frame(struct dg_bus_master *self, bool cdm)
{
    if (cdm) {
        dg_bus_master_edge(self, false);
    }
    dg_bus_master_pause(self, self->now + PAUSE_NS + self->delay);
    if (cdm) {
        dg_bus_master_edge(self, true);
    }
}

static void read_frame(struct dg_bus_master *self)
{
    (void)open_frame(self);
    close_frame(self, false);
}

static void skip_frames(const struct dg_bus_master *self, uint64_t n)
{
    for (size_t i = 0; i < dg_bus_count(self->setup.bus); i++) {
        dg_biss_skip(dg_bus_device(self->setup.bus, i), n);
    }
}

static struct dg_biss_data frame_data_of(const struct dg_bus_master *self, size_t place)
{
    struct dg_biss_data data;

    dg_biss_frame_decode(biss_model_of(self, place), self->bits[place], &data);
    return data;
}

static enum dg_master_verdict judge(const struct dg_bus_master *self, size_t place)
{
    if (!self->answered) {
        return DG_MASTER_SILENT;
    }
    return frame_data_of(self, place).crc_ok ? DG_MASTER_GOOD : DG_MASTER_WRONG;
}

static void tell_word(const struct dg_bus_master *self, size_t place, struct dg_master_word *to)
{
    const struct dg_biss_data data = frame_data_of(self, place);

    *to = (struct dg_master_word){
        .bits = self->bits[place],
        .count = dg_biss_frame_bits(biss_model_of(self, place)),
        .position = data.position,
        .multiturn = data.multiturn,
        .singleturn = data.singleturn,
        .error = !data.n_err,
        .warning = !data.n_warn,
        .life = data.life,
    };
}

/* What stands behind the position, each name with these blanks in front. */
static void say_status_bits(const struct dg_biss_data *data, const char *blanks, const char *crc,
                            struct dg_text *to)
{
    dg_text_add(to, blanks);
    dg_master_say(to, "nERR ", data->n_err);
    dg_text_add(to, blanks);
    dg_master_say(to, "nWARN ", data->n_warn);
    dg_text_add(to, blanks);
    dg_master_say(to, "LC ", data->life);
    dg_text_add(to, blanks);
    dg_text_add(to, "CRC ");
    dg_text_add(to, crc);
}

static void note_frame(const struct dg_bus_master *self, size_t place, struct dg_text *to)
{
    const struct dg_biss_data data = frame_data_of(self, place);

    dg_master_note_position(to, data.multiturn, data.singleturn);
    say_status_bits(&data, " ", data.crc_ok ? "ok" : "wrong", to);
    if (self->start > START_MAX) {
        dg_master_say(to, ", start bit after ", self->start / DG_US(1));
        dg_text_add(to, " us");
    }
    if (self->delay > 0) {
        dg_master_say(to, ", line delay ", self->delay);
        dg_text_add(to, " ns");
    }
}

static void print_frame(const struct dg_bus_master *self, size_t place, struct dg_text *to)
{
    const struct dg_biss_data data = frame_data_of(self, place);

    dg_master_line_position(to, data.multiturn, data.singleturn,
                            biss_model_of(self, place)->singleturn_bits);
    say_status_bits(&data, "  ", data.crc_ok ? "valid" : "WRONG", to);
}

const struct dg_master_protocol dg_biss_master = {
    .rises = count_rises,
    .read = read_frame,
    .skip = skip_frames,
    .judge = judge,
    .word = tell_word,
    .note = note_frame,
    .line = print_frame,
};

/* ---------------------------------------------------------------- control frames */

static bool clock_frame(struct dg_bus_master *master, bool cdm)
{
    const bool cds = open_frame(master);

    close_frame(master, cdm);
    return cds;
}

/* The last `n` bits of `bits`. @return what came back, its last bit in bit 0 */
static unsigned send_bits(struct dg_bus_master *master, unsigned bits, unsigned n)
{
    unsigned back = 0;

    for (unsigned i = n; i > 0; i--) {
        back = back << 1 | clock_frame(master, (bits >> (i - 1u) & 1u) != 0);
    }
    return back;
}

/* CDS of the frames after R and after W: how the encoder takes it. The last encoder of the line
   gets ID 0. */
static int address_register(struct dg_bus_master *master, const struct dg_biss_access *access,
                            uint8_t address)
{
    const unsigned id = (unsigned)(dg_bus_count(master->setup.bus) - 1u - access->place);
    const unsigned bits = CTS | id << 7 | address;
    const bool write = access->sent != NULL;
    const unsigned wanted = write ? 1u : 2u;

    (void)send_bits(master, 0, ZERO_FRAMES);
    (void)clock_frame(master, true);
    const unsigned locks =
        send_bits(master, bits << 4 | dg_biss_crc4(bits, ADDRESS_BITS), ADDRESS_BITS + 4u);
    (void)clock_frame(master, !write);
    unsigned answer = clock_frame(master, write) ? 2u : 0u;
    answer |= clock_frame(master, true) ? 1u : 0u;
    if (answer == wanted) {
        return 0;
    }
    return locks == 0 ? DG_BISS_SILENT : DG_BISS_REFUSED;
}

/* S is repeated until it comes back; the frame it comes back in stays open. */
static bool await_start_bit(struct dg_bus_master *master)
{
    const dg_ns begin = master->now;

    while (!open_frame(master)) {
        close_frame(master, true);
        if (master->now - begin > BUSY_MAX_NS) {
            return false;
        }
    }
    return true;
}

/* Byte `index` is exchanged. @return P */
static bool exchange_register(struct dg_bus_master *master, const struct dg_biss_access *access,
                              size_t index, bool *good)
{
    const bool last = index + 1u == access->n;
    const uint8_t byte = access->sent == NULL ? 0 : access->sent[index];
    const unsigned word = access->sent == NULL ? 0 : (unsigned)byte << 4 | dg_biss_crc4(byte, 8);

    close_frame(master, (word >> 11 & 1u) != 0); /* D7 goes first */
    const unsigned back = send_bits(master, word << 1, 12);
    const bool stop = open_frame(master);
    close_frame(master, !last && !stop);
    *good = (back & 0x0Fu) == dg_biss_crc4(back >> 4, 8);
    if (access->got != NULL) {
        access->got[index] = (uint8_t)(back >> 4);
    }
    return stop;
}

/* Bytes from `first` on. P = 1 refuses the byte itself, unless the encoder tells of the next one.
 */
static int exchange_all(struct dg_bus_master *master, const struct dg_biss_access *access,
                        size_t first)
{
    int done = 0;
    bool stop = false;

    for (size_t i = first; i < access->n && !stop; i++) {
        bool good = false;
        if (!await_start_bit(master)) {
            return DG_BISS_TOO_BUSY;
        }
        stop = exchange_register(master, access, i, &good);
        if (!good) {
            return DG_BISS_DAMAGED;
        }
        done += !stop || biss_model_of(master, access->place)->stop_bit_early;
    }
    return done > 0 ? done : DG_BISS_REFUSED;
}

/* One control frame, which begins with register `first`. An SLO that reads high is no echo. */
static int transfer_registers(struct dg_bus_master *master, const struct dg_biss_access *access,
                              size_t first)
{
    const uint32_t silent = master->silent;
    int result = address_register(master, access, (uint8_t)(access->address + first));

    if (result == 0) {
        result = exchange_all(master, access, first);
    }
    return master->silent == silent ? result : DG_BISS_SILENT;
}

/* ---------------------------------------------------------------- registers */

const char *dg_biss_failure_text(int failure)
{
    static const char *const texts[] = {
        [-DG_BISS_SILENT] = "no answer",
        [-DG_BISS_REFUSED] = "refused: not implemented or protected",
        [-DG_BISS_TOO_BUSY] = "busy for more than 20 ms",
        [-DG_BISS_DAMAGED] = "wrong check sum",
    };

    return texts[-failure];
}

static void add_register(struct dg_text *to, const struct dg_biss_access *access, size_t index)
{
    dg_text_add(to, "register ");
    dg_text_add_hex(to, access->address + index, 2);
    dg_text_add(to, "h");
}

void dg_biss_access_explain(const struct dg_bus_master *master, const struct dg_biss_access *access,
                            int failure, char *to, size_t size)
{
    struct dg_text text = dg_bus_master_text(master, access->place, to, size);

    add_register(&text, access, access->done);
    dg_text_add(&text, ": ");
    dg_text_add(&text, dg_biss_failure_text(failure));
}

/* "register 78h = 04 00" */
static void note_registers(const struct dg_bus_master *master, const struct dg_biss_access *access)
{
    const uint8_t *bytes = access->got != NULL ? access->got : access->sent;
    char note[DG_BUS_NOTE_MAX];
    struct dg_text text = dg_bus_master_text(master, access->place, note, sizeof note);

    add_register(&text, access, 0);
    dg_text_add(&text, " =");
    for (size_t i = 0; i < access->done && text.length + 4u < sizeof note; i++) {
        dg_text_add(&text, " ");
        dg_text_add_hex(&text, bytes[i], 2);
    }
    dg_bus_master_note(master, note, DG_SEVERITY_OK);
}

static void note_failure(const struct dg_bus_master *master, const struct dg_biss_access *access,
                         int failure)
{
    char note[DG_BUS_NOTE_MAX];

    dg_biss_access_explain(master, access, failure, note, sizeof note);
    dg_bus_master_note(master, note, DG_SEVERITY_ERROR);
}

int dg_biss_access(struct dg_bus_master *master, struct dg_biss_access *access)
{
    int result = 0;

    access->done = 0;
    while (result >= 0 && access->done < access->n) {
        result = transfer_registers(master, access, access->done);
        access->done += result > 0 ? (size_t)result : 0;
    }
    if (access->done > 0) {
        note_registers(master, access);
    }
    if (result < 0) {
        note_failure(master, access, result);
    }
    return result;
}
