/* SPDX-License-Identifier: MIT */

#include <stddef.h>

#include "clocked.h"
#include "drehgeber/ssi.h"
#include "sim_bus.h"
#include "stacks.h"
#include "trace_format.h"

#define CLOCK_NAME "CLOCK"
#define DATA_NAME "DATA"
/* Ends a word on GPIO lines; see src/ssi/README.md, 'GPIO'. */
#define GPIO_MONOFLOP DG_MS(20)

/* --- what the control plane asks for --- */

static int read_word(void *ctx, uint64_t *bits, char *detail)
{
    const struct lx_station *station = ctx;
    const struct dg_bus_master *master = lx_sim_bus_ask(station->bus, detail);
    *bits = master == NULL ? 0 : master->bits[0];
    return master == NULL ? DG_SCPI_HARDWARE : DG_SCPI_NO_ERROR;
}

static const struct dg_ssi_port_ops port = {.frame = read_word};

/* --- from a plan --- */

/* A clock that user space can follow is slower than the encoder's own time allows. */
static void slow_down(void *settings)
{
    struct dg_ssi_model *model = settings;
    model->monoflop = GPIO_MONOFLOP;
}

static dg_ns init(const void *settings)
{
    return ((const struct dg_ssi_model *)settings)->init;
}

/* Each falling edge has to come before the monoflop time from the one before is over. The edges of
   the wire are at whole nanoseconds. */
static int check_rate(const void *settings, uint32_t hz, struct lx_error *error)
{
    const dg_ns monoflop = ((const struct dg_ssi_model *)settings)->monoflop;
    const dg_ns period = (DG_S(1) + hz - 1u) / hz;
    struct lx_words right = {""};
    if (period < monoflop) {
        return 0;
    }
    lx_words_add(&right, "expected clock_hz from %u or monoflop_us from %u on",
                 (unsigned)((DG_S(1) + monoflop - 2u) / (monoflop - 1u)),
                 (unsigned)(period / DG_US(1) + 1u));
    return lx_refuse(error, right.text,
                     "its period, %u ns, ends the word, as the monoflop time of %u ns is over",
                     (unsigned)period, (unsigned)monoflop);
}

static const struct lx_clocked_protocol protocol = {
    .clock = CLOCK_NAME,
    .data = DATA_NAME,
    .master = &dg_ssi_master,
    .port = &port,
    .slow_down = slow_down,
    .init = init,
    .check_rate = check_rate,
};

/* --- the stack --- */

/* clang-format off */
static const struct dg_key monoflop =
    {"monoflop_us", "us", offsetof(struct dg_ssi_model, monoflop), DG_KEY_NS, 0, 1000, DG_SSI_MONOFLOP_MIN_NS / DG_US(1), DG_SSI_MONOFLOP_MAX_NS / DG_US(1), NULL, "a pause of the clock of this length ends a word; gpio: 20000 unless set"};
/* clang-format on */

static int check(const void *settings, struct lx_error *error)
{
    const struct dg_ssi_model *model = settings;
    const unsigned bits = (unsigned)model->multiturn_bits + model->singleturn_bits;
    const unsigned most =
        model->form == NULL ? DG_SSI_BITS_MAX : DG_SSI_FORM_BITS_MAX - model->form->around;
    const unsigned least = model->form == NULL ? DG_SSI_BITS_MIN : 1u;
    struct lx_words right = {""};
    const bool each =
        model->form != NULL || (model->multiturn_bits <= DG_SSI_MULTITURN_BITS_MAX &&
                                model->singleturn_bits >= DG_SSI_SINGLETURN_BITS_MIN &&
                                model->singleturn_bits <= DG_SSI_SINGLETURN_BITS_MAX);
    if (each && bits >= least && bits <= most) {
        return 0;
    }
    lx_words_add(&right, "expected %u to %u bits together", least, most);
    if (!each) {
        lx_words_add(&right, ", mt 0..%u and st %u..%u", DG_SSI_MULTITURN_BITS_MAX,
                     DG_SSI_SINGLETURN_BITS_MIN, DG_SSI_SINGLETURN_BITS_MAX);
    }
    return lx_refuse(error, right.text, "mt %u and st %u", model->multiturn_bits,
                     model->singleturn_bits);
}

static const struct lx_trace_format vcd = LX_TRACE_CLOCKED("ssi", CLOCK_NAME, DATA_NAME);
const struct lx_stack lx_ssi_stack = {
    .core = &dg_ssi_stack,
    .handle = &dg_ssi_wire,
    .trace = &(const struct lx_trace_kind){"SSI", {&vcd}, false},
    .clocked = &protocol,
    .wire = "sim",
    .instead = &monoflop,
    .check = check,
};
