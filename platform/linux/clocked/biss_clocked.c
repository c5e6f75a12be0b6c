/* SPDX-License-Identifier: MIT */

#include <stddef.h>

#include "clocked.h"
#include "drehgeber/biss.h"
#include "sim_bus.h"
#include "stacks.h"
#include "trace_format.h"

#define CLOCK_NAME "MA"
#define DATA_NAME "SLO"
/* Ends a frame on GPIO lines; see src/biss/README.md, 'GPIO'. */
#define GPIO_TIMEOUT DG_MS(20)
/* Threads of a host are slower than the encoder's own timeout is short. */
#define TIMEOUT_MIN_US (DG_BISS_TIMEOUT_NS / DG_US(1))
#define TIMEOUT_MAX_US (DG_BISS_TIMEOUT_MAX_NS / DG_US(1))

/* --- what the control plane asks for --- */

static int read_frame(void *ctx, uint64_t *bits, uint8_t *count, char *detail)
{
    const struct lx_station *station = ctx;
    const struct dg_bus_master *master = lx_sim_bus_ask(station->bus, detail);
    if (master == NULL) {
        return DG_SCPI_HARDWARE;
    }
    const struct dg_biss *device = station->control->device;
    const uint8_t data_bits = dg_biss_frame_bits(device->setup.model);
    *bits = (uint64_t)master->cds << data_bits | master->bits[station->place];
    *count = (uint8_t)(data_bits + 1u);
    return DG_SCPI_NO_ERROR;
}

static int serve_access(const struct lx_station *station, struct dg_biss_access *access,
                        char *detail)
{
    struct dg_bus_master *master = lx_sim_bus_begin(station->bus);
    access->place = station->place;
    const int result = dg_biss_access(master, access);
    lx_sim_bus_end(station->bus);
    if (result >= 0) {
        return DG_SCPI_NO_ERROR;
    }
    dg_biss_access_explain(master, access, result, detail, DG_SCPI_DETAIL_MAX + 1u);
    return DG_SCPI_HARDWARE;
}

static int read_registers(void *ctx, uint8_t address, uint8_t *bytes, size_t n, char *detail)
{
    return serve_access(ctx, &(struct dg_biss_access){.address = address, .got = bytes, .n = n},
                        detail);
}

static int write_registers(void *ctx, uint8_t address, const uint8_t *bytes, size_t n, char *detail)
{
    return serve_access(ctx, &(struct dg_biss_access){.address = address, .sent = bytes, .n = n},
                        detail);
}

static const struct dg_biss_port_ops port = {
    .frame = read_frame,
    .read = read_registers,
    .write = write_registers,
};

/* --- from a plan --- */

/* A clock that user space can follow is slower than the encoder's own timeout allows. */
static void slow_down(void *settings)
{
    struct dg_biss_model *model = settings;
    model->timeout = model->timeout == 0 ? GPIO_TIMEOUT : model->timeout;
}

/* On a simulated wire the master leaves an encoder the time it has of its own. */
static int check_timeout(const struct lx_bus_setup *setup, const struct lx_station *station,
                         enum lx_clocked_master master, struct lx_error *error)
{
    const struct dg_biss_model *model = dg_host_line_of(station->host)->settings;
    if (master == LX_CLOCKED_THERE || model->timeout == 0) {
        return 0;
    }
    (void)lx_refuse(error, "only with gpio", "the simulated wire has the encoder's own timeout");
    (void)lx_about(error, LX_ABOUT_SETTING, "timeout_us", NULL);
    return lx_plan_stands(setup->plan, dg_plan_setting_line(station->plan, "timeout_us"), error);
}

static dg_ns init(const void *settings)
{
    return ((const struct dg_biss_model *)settings)->init;
}

static const struct lx_clocked_protocol protocol = {
    .clock = CLOCK_NAME,
    .data = DATA_NAME,
    .master = &dg_biss_master,
    .port = &port,
    .slow_down = slow_down,
    .check = check_timeout,
    .init = init,
};

/* --- the stack --- */

/* clang-format off */
static const struct dg_key timeout =
    {"timeout_us", "us", offsetof(struct dg_biss_model, timeout), DG_KEY_NS, 0, 1000, TIMEOUT_MIN_US, TIMEOUT_MAX_US, NULL, "gpio: a pause on MA of this length ends a frame; 20000 unless set"};
/* clang-format on */

/* Bits of a frame that are no position, with a life counter. */
#define USUAL_AROUND (DG_BISS_FLAG_BITS + DG_BISS_LIFE_BITS + DG_BISS_CRC_BITS)

static int check(const void *settings, struct lx_error *error)
{
    const struct dg_biss_model *model = settings;
    struct lx_words right = {""};
    const unsigned bits = (unsigned)model->multiturn_bits + model->singleturn_bits;
    const unsigned around = model->form == NULL ? USUAL_AROUND : model->form->around;
    if (bits + around > DG_BISS_FRAME_BITS_MAX) {
        lx_words_add(&right, "expected at most %u together", DG_BISS_FRAME_BITS_MAX - around);
        return lx_refuse(error, right.text, "mt %u and st %u", model->multiturn_bits,
                         model->singleturn_bits);
    }
    if (model->busy + model->busy_jitter <= DG_BISS_BUSY_S_MAX_NS) {
        return 0;
    }
    lx_words_add(&right, "expected at most %u together", (unsigned)(DG_BISS_BUSY_S_MAX_NS / 1000u));
    return lx_refuse(error, right.text, "busy_us %g and busy_jitter_us %g",
                     (double)model->busy / 1000.0, (double)model->busy_jitter / 1000.0);
}

static const struct lx_trace_format vcd = LX_TRACE_CLOCKED("biss", CLOCK_NAME, DATA_NAME);
const struct lx_stack lx_biss_stack = {
    .core = &dg_biss_stack,
    .handle = &dg_biss_wire,
    .trace = &(const struct lx_trace_kind){"BiSS", {&vcd}, false},
    .clocked = &protocol,
    .wire = "sim",
    .spoiled = "the encoder answers P = 1",
    .instead = &timeout,
    .check = check,
};
