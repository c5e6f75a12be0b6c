/* SPDX-License-Identifier: MIT */
/*
 * Control frames: a bit in each direction per frame (5.2.2). CDM(k) is read when the timeout of
 * frame k ends, and what it asks for is in CDS(k + 1), which goes out before CDM(k + 1) comes in.
 * One function for each state takes the CDM bit; the numbers are those of the frames.
 */
#include "biss_private.h"

#define IDL_BITS 9u
#define ADDRESSING_BITS 11u
#define CRC_BITS 4u
#define DATA_BITS 8u

static void enter_control_state(struct dg_biss_control *control, enum dg_biss_control_state state)
{
    control->state = state;
    control->shift = 0;
    control->count = 0;
}

static void collect_bit(struct dg_biss_control *control, bool bit)
{
    control->shift = (uint16_t)((uint32_t)control->shift << 1 | bit);
    control->count++;
}

/* IDL0..8 in frames 1..9: whoever finds a free one takes it; the ninth says 'more slaves'. */
bool dg_biss_cds(struct dg_biss *self, bool sli)
{
    struct dg_biss_control *control = &self->control;
    const bool assigning = control->state == DG_BISS_CONTROL_ADDRESS && control->count < IDL_BITS;

    if (!assigning || self->communication_off || control->id != DG_BISS_NO_ID || sli) {
        return sli || control->cds;
    }
    if (control->count < DG_BISS_CHAIN_MAX) {
        control->id = control->count;
    }
    return true;
}

static void on_idle(struct dg_biss *self, dg_ns now, bool cdm)
{
    (void)self;
    (void)now;
    (void)cdm;
}

static void on_ready(struct dg_biss *self, dg_ns now, bool cdm)
{
    (void)now;
    if (cdm) {
        enter_control_state(&self->control, DG_BISS_CONTROL_ADDRESS);
        self->control.id = DG_BISS_NO_ID;
    }
}

/* CTS ID2..0 ADR6..0, or CTS IDS0..7 CMD1..0. */
static void addressed(struct dg_biss *self, uint16_t bits)
{
    struct dg_biss_control *control = &self->control;
    const bool cts = (bits >> 10 & 1u) != 0;
    const uint8_t ids = (uint8_t)(bits >> 2);

    if (cts) {
        control->address = (uint8_t)(bits & BISS_ADDRESS_END);
        if ((bits >> 7 & 7u) == control->id) {
            enter_control_state(control, DG_BISS_CONTROL_R);
        }
        return;
    }
    control->command = (uint8_t)(bits & 3u);
    control->addressed = ids != 0;
    control->mine = control->id != DG_BISS_NO_ID && (0x80u >> control->id & ids) != 0;
    enter_control_state(control, DG_BISS_CONTROL_SELECT);
}

static void on_address(struct dg_biss *self, dg_ns now, bool cdm)
{
    struct dg_biss_control *control = &self->control;

    (void)now;
    collect_bit(control, cdm);
    if (control->count < ADDRESSING_BITS + CRC_BITS) {
        return;
    }
    const uint16_t word = control->shift;
    const uint16_t bits = word >> CRC_BITS;
    enter_control_state(control, DG_BISS_CONTROL_IDLE);
    if ((word & 0x0Fu) == dg_biss_crc4(bits, ADDRESSING_BITS)) {
        addressed(self, bits);
    } else {
        self->counters.damaged++;
    }
}

static void on_r(struct dg_biss *self, dg_ns now, bool cdm)
{
    (void)now;
    self->control.r = cdm;
    self->control.cds = cdm;
    enter_control_state(&self->control, DG_BISS_CONTROL_W);
}

/* An answer with R = W says 'refused', also to a request with R = W. */
static void on_w(struct dg_biss *self, dg_ns now, bool cdm)
{
    struct dg_biss_control *control = &self->control;

    control->w = cdm;
    control->refused =
        control->r == cdm || dg_biss_permitted(self, now, control->address, cdm) == NULL;
    self->counters.refused += control->refused;
    control->cds = control->refused ? control->r : cdm;
    enter_control_state(control, control->refused ? DG_BISS_CONTROL_IDLE : DG_BISS_CONTROL_S);
}

/* S goes out, and of a read the data behind it. */
static void send_data(struct dg_biss_control *control, uint8_t value)
{
    enter_control_state(control, DG_BISS_CONTROL_DATA);
    if (!control->w) {
        control->shift = (uint16_t)((uint32_t)value << CRC_BITS | dg_biss_crc4(value, DATA_BITS));
    }
    control->cds = true;
}

/* The register is ready, unless its bank broke away meanwhile. */
static void begin_data(struct dg_biss *self, dg_ns now)
{
    struct dg_biss_control *control = &self->control;
    const struct biss_register *row = dg_biss_permitted(self, now, control->address, control->w);
    uint8_t value = 0;

    enter_control_state(control, DG_BISS_CONTROL_IDLE);
    if (row == NULL) {
        return;
    }
    if (!control->w) {
        if (row->read(self, now, (uint8_t)(control->address - row->first), &value) != DG_OK) {
            return;
        }
        self->counters.reads++;
    }
    send_data(control, value);
}

static void on_busy(struct dg_biss *self, dg_ns now, bool cdm)
{
    if (!cdm) {
        enter_control_state(&self->control, DG_BISS_CONTROL_IDLE);
    } else if (now >= self->control.ready) {
        begin_data(self, now);
    }
}

static void on_s(struct dg_biss *self, dg_ns now, bool cdm)
{
    struct dg_biss_control *control = &self->control;
    const struct biss_register *row = dg_biss_permitted(self, now, control->address, control->w);

    if (!cdm) {
        enter_control_state(control, DG_BISS_CONTROL_IDLE);
        return;
    }
    if (control->refused) { /* a further register: only its own P can say so */
        self->counters.refused++;
        send_data(control, 0);
        return;
    }
    if (row != NULL && (row->access & BISS_EEPROM) != 0) {
        const dg_ns free = control->ready > now ? control->ready : now;
        control->ready = dg_after(free, self->setup.model->eeprom_read);
        enter_control_state(control, DG_BISS_CONTROL_BUSY);
    }
    if (control->state != DG_BISS_CONTROL_BUSY || now >= control->ready) {
        begin_data(self, now);
    }
}

/* Frame 31: a write whose CRC and stop bit are right takes effect. @return whether P stays 0 */
static bool write_biss_register(struct dg_biss *self, dg_ns now, uint16_t word)
{
    struct dg_biss_control *control = &self->control;
    const uint8_t value = (uint8_t)(word >> (CRC_BITS + 1u));
    const struct biss_register *row = dg_biss_permitted(self, now, control->address, true);

    if ((word & 0x1Fu) != (uint32_t)dg_biss_crc4(value, DATA_BITS) << 1) {
        self->counters.damaged++;
        return false;
    }
    if (row == NULL ||
        row->write(self, now, (uint8_t)(control->address - row->first), value) != DG_OK) {
        return false;
    }
    self->counters.writes++;
    return true;
}

/* The address of the next register, for the case that the master goes on. */
static bool next_refused(struct dg_biss *self, dg_ns now)
{
    struct dg_biss_control *control = &self->control;

    if (control->address == BISS_WINDOW_END || control->address == BISS_ADDRESS_END) {
        return true;
    }
    control->address++;
    return dg_biss_permitted(self, now, control->address, control->w) == NULL;
}

static void on_register_data(struct dg_biss *self, dg_ns now, bool cdm)
{
    struct dg_biss_control *control = &self->control;
    const uint8_t last = DATA_BITS + CRC_BITS;

    if (control->count < last) {
        const bool bit = ((uint32_t)control->shift >> (last - 1u - control->count) & 1u) != 0;
        control->cds = control->w ? cdm : bit;
    }
    if (!control->w) { /* what a master sends in the data of a read means nothing */
        control->count++;
    } else {
        collect_bit(control, cdm);
    }
    if (control->count <= last) {
        return;
    }
    const bool accepted =
        !control->refused && (!control->w || write_biss_register(self, now, control->shift));
    if (control->state != DG_BISS_CONTROL_DATA) {
        return; /* the write was a soft reset */
    }
    control->refused = !accepted || next_refused(self, now);
    /* P of this register, or ahead of time of the next one. */
    control->cds = self->setup.model->stop_bit_early ? control->refused : !accepted;
    enter_control_state(control, control->cds ? DG_BISS_CONTROL_IDLE : DG_BISS_CONTROL_S);
}

/* Broadcast: 00 data channels off, 01 communication on. Addressed: 00 on, 01 off. */
static void execute_command(struct dg_biss *self)
{
    const bool selected = self->control.addressed;

    if (self->control.command == 0) {
        self->channel_off = !selected;
    } else if (self->control.command == 1) {
        self->communication_off = selected;
    }
    self->counters.commands++;
}

/* IDA of this slave in frames 17..24, `count` frames behind S. */
static bool acknowledges(const struct dg_biss_control *control)
{
    return control->addressed && control->mine && control->count == control->id;
}

static void on_select(struct dg_biss *self, dg_ns now, bool cdm)
{
    struct dg_biss_control *control = &self->control;

    (void)now;
    enter_control_state(control, cdm ? DG_BISS_CONTROL_EXECUTE : DG_BISS_CONTROL_IDLE);
    control->cds = cdm && acknowledges(control);
}

static void on_execute(struct dg_biss *self, dg_ns now, bool cdm)
{
    struct dg_biss_control *control = &self->control;
    const bool is_ex = !control->addressed || control->count == DG_BISS_CHAIN_MAX - 1u;

    (void)now;
    collect_bit(control, cdm);
    if (!is_ex && !cdm) {
        control->cds = acknowledges(control);
        return;
    }
    if (is_ex && cdm && (control->mine || !control->addressed)) {
        execute_command(self);
    }
    enter_control_state(control, DG_BISS_CONTROL_IDLE);
}

void dg_biss_cdm(struct dg_biss *self, dg_ns now, bool cdm)
{
    static void (*const states[])(struct dg_biss *, dg_ns, bool) = {
        [DG_BISS_CONTROL_IDLE] = on_idle,
        [DG_BISS_CONTROL_READY] = on_ready,
        [DG_BISS_CONTROL_ADDRESS] = on_address,
        [DG_BISS_CONTROL_R] = on_r,
        [DG_BISS_CONTROL_W] = on_w,
        [DG_BISS_CONTROL_S] = on_s,
        [DG_BISS_CONTROL_BUSY] = on_busy,
        [DG_BISS_CONTROL_DATA] = on_register_data,
        [DG_BISS_CONTROL_SELECT] = on_select,
        [DG_BISS_CONTROL_EXECUTE] = on_execute,
    };
    struct dg_biss_control *control = &self->control;

    _Static_assert(DG_COUNT(states) == DG_BISS_CONTROL_STATE_COUNT, "all states");
    if (self->setup.model->unidirectional) {
        return;
    }
    control->cds = false;
    states[control->state](self, now, cdm);
    if (cdm) {
        control->zeros = 0;
    } else if (control->zeros < DG_BISS_ZEROS) {
        control->zeros++;
    }
    if (control->zeros == DG_BISS_ZEROS && control->state != DG_BISS_CONTROL_READY) {
        enter_control_state(control, DG_BISS_CONTROL_READY);
        control->cds = false;
    }
}
