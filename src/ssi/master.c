/* SPDX-License-Identifier: MIT */
/*
 *   clock  ¯¯|__|¯¯|__|¯¯ ... ¯|__|¯¯|__|¯¯¯¯¯
 *   data   ¯¯¯¯¯|MSB  | ...    |LSB  |_________|¯¯
 *   master    1?   bits             0?
 *
 * The master takes data for a word that is still high behind the first falling edge, and low behind
 * the last bit. SSI has nothing to measure the cable by: the master is told how long it is, and
 * takes each sample later by the way there and back.
 */
#include "drehgeber/bus_master.h"
#include "drehgeber/ssi.h"

/* A master waits a little longer than the monoflop time. */
#define PAUSE_NS DG_US(5)

/* Numbers of the encoder in front of the word read last: dg_bus_master.own. */
enum { FRAMES, REPEATS, ABORTED, FAST, OWN_COUNT };
_Static_assert(OWN_COUNT <= DG_MASTER_OWN, "the master keeps as many");

static struct dg_ssi *device_of(const struct dg_bus_master *self)
{
    return dg_bus_device(self->setup.bus, 0);
}

static const struct dg_ssi_model *ssi_model_of(const struct dg_bus_master *self)
{
    return dg_bus_settings(self->setup.bus, 0);
}

/* Those of the word, and the one behind it. */
static uint32_t count_rises(const struct dg_bus *bus)
{
    return dg_ssi_word_bits(dg_bus_settings(bus, 0)) + 1u;
}

static void keep_counters(struct dg_bus_master *self)
{
    const struct dg_ssi_counters *counters = &device_of(self)->counters;

    self->own[FRAMES] = counters->frames;
    self->own[REPEATS] = counters->repeats;
    self->own[ABORTED] = counters->aborted;
    self->own[FAST] = counters->fast;
}

/* What the master sees when the clock is about to move again. */
static bool sample_late(const struct dg_bus_master *self)
{
    return dg_bus_master_sample(self, self->now + self->half_ns);
}

/* Each bit is taken with the falling edge behind it, by which the monoflop time of a clock that is
   too slow is over. */
static void read_word(struct dg_bus_master *self)
{
    const struct dg_ssi_model *model = ssi_model_of(self);
    const dg_ns way = dg_bus_master_way(self);
    uint64_t bits = 0;

    keep_counters(self);
    self->delay = self->setup.compensates ? way : 0;
    dg_bus_master_edge(self, false);
    self->latched = self->now;
    const bool high = sample_late(self);
    dg_bus_master_edge(self, true);
    for (uint8_t left = dg_ssi_word_bits(model); left > 0; left--) {
        dg_bus_master_edge(self, false);
        bits = bits << 1 | dg_bus_master_sample(self, self->now);
        dg_bus_master_edge(self, true);
    }
    self->bits[0] = bits;
    self->answered = high && !sample_late(self);
    self->silent += !self->answered;
    dg_bus_master_pause(self, self->now + model->monoflop + way + PAUSE_NS);
}

static void skip_words(const struct dg_bus_master *self, uint64_t n)
{
    const struct dg_ssi_counters *after = &device_of(self)->counters;
    const struct dg_ssi_counters each = {
        .frames = after->frames - self->own[FRAMES],
        .repeats = after->repeats - self->own[REPEATS],
        .aborted = after->aborted - self->own[ABORTED],
        .fast = after->fast - self->own[FAST],
    };

    dg_ssi_skip(device_of(self), &each, n);
}

/* @return whether the parity is right */
static bool decode_frame(const struct dg_bus_master *self, struct dg_ssi_frame *frame)
{
    return dg_ssi_frame_decode(ssi_model_of(self), self->bits[0], frame) == DG_OK;
}

static enum dg_master_verdict judge(const struct dg_bus_master *self, size_t place)
{
    struct dg_ssi_frame frame;

    (void)place;
    if (!self->answered) {
        return DG_MASTER_SILENT;
    }
    return decode_frame(self, &frame) ? DG_MASTER_GOOD : DG_MASTER_WRONG;
}

static void tell_word(const struct dg_bus_master *self, size_t place, struct dg_master_word *to)
{
    struct dg_ssi_frame frame;

    (void)place;
    (void)decode_frame(self, &frame);
    *to = (struct dg_master_word){
        .bits = self->bits[0],
        .count = dg_ssi_word_bits(ssi_model_of(self)),
        .position = frame.position,
        .multiturn = frame.multiturn,
        .singleturn = frame.singleturn,
        .error = frame.error,
    };
}

/* What the bits around the position say, if there are any. */
static void say_extra_bits(const struct dg_ssi_model *model, const struct dg_ssi_frame *frame,
                           const char *parity, struct dg_text *to)
{
    if (model->error_bit != DG_SSI_ERROR_NONE) {
        dg_master_say(to, "  error ", frame->error);
    }
    if (model->parity != DG_SSI_PARITY_NONE) {
        dg_text_add(to, "  parity ");
        dg_text_add(to, parity);
    }
    if (model->form != NULL && dg_form_has(model->form->layout, 'T')) {
        dg_master_say(to, "  toggle ", frame->toggle);
    }
    if (model->form != NULL && dg_form_has(model->form->layout, 'F')) {
        dg_master_say(to, "  power fail ", frame->power_fail);
    }
}

static void note_word(const struct dg_bus_master *self, size_t place, struct dg_text *to)
{
    struct dg_ssi_frame frame;
    const bool right = decode_frame(self, &frame);

    (void)place;
    dg_master_note_position(to, frame.multiturn, frame.singleturn);
    say_extra_bits(ssi_model_of(self), &frame, right ? "ok" : "wrong", to);
}

static void print_word(const struct dg_bus_master *self, size_t place, struct dg_text *to)
{
    const struct dg_ssi_model *model = ssi_model_of(self);
    struct dg_ssi_frame frame;
    const bool right = decode_frame(self, &frame);

    (void)place;
    dg_master_line_position(to, frame.multiturn, frame.singleturn, model->singleturn_bits);
    say_extra_bits(model, &frame, right ? "valid" : "WRONG", to);
}

const struct dg_master_protocol dg_ssi_master = {
    .rises = count_rises,
    .read = read_word,
    .skip = skip_words,
    .judge = judge,
    .word = tell_word,
    .note = note_word,
    .line = print_word,
};
