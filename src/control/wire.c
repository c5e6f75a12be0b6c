/* SPDX-License-Identifier: MIT */
/*
 * TIME, TRACe and BISS: what the host and its wires can do, as far as they can.
 */
#include "control_private.h"

#define SECOND_PLACES 9u
#define SCALE_PLACES 3u
#define SCALE_MAX_PERMILLE 1000000
#define STEP_MAX DG_S(86400)
#define LINES_MAX 100
#define LINE_SIZE 256u

#define CRC_BITS 6u
#define LIFE_BITS 6u
#define STATE_BITS 2u

static const struct dg_scpi_range scales = {DG_SCPI_PLAIN, SCALE_PLACES, 0, SCALE_MAX_PERMILLE};
static const struct dg_scpi_range spans = {DG_SCPI_TIME, 0, 0, (int64_t)STEP_MAX};
static const struct dg_scpi_range lines = {DG_SCPI_PLAIN, 0, 1, LINES_MAX};
static const struct dg_scpi_range addresses = {DG_SCPI_PLAIN, 0, 0, 0x7F};
static const struct dg_scpi_range sizes = {DG_SCPI_PLAIN, 0, 1, DG_BISS_BANK_SIZE};
static const struct dg_scpi_range bytes_range = {DG_SCPI_PLAIN, 0, 0, UINT8_MAX};

static const struct dg_rig_ops *ops_of(const struct dg_scpi *self)
{
    return control_rig_of(self)->ops;
}

/* What the host cannot do. @return `there` */
static bool offered(struct dg_scpi *self, bool there)
{
    if (!there) {
        dg_scpi_raise(self, DG_SCPI_MISSING_HARDWARE, NULL);
    }
    return there;
}

void control_time(struct dg_scpi *self, uint32_t argument)
{
    (void)argument;
    dg_scpi_put_number(self, (int64_t)dg_elapsed(self->now, control_rig_of(self)->origin),
                       SECOND_PLACES);
}

void control_origin(struct dg_scpi *self, uint32_t argument)
{
    (void)argument;
    dg_scpi_put_number(self, (int64_t)control_rig_of(self)->origin, SECOND_PLACES);
}

void control_set_scale(struct dg_scpi *self, uint32_t argument)
{
    char detail[CONTROL_DETAIL_SIZE] = "";
    int64_t permille;

    (void)argument;
    if (!dg_scpi_number(self, &scales, &permille) ||
        !offered(self, ops_of(self)->set_scale != NULL)) {
        return;
    }
    const int code = ops_of(self)->set_scale(control_rig_of(self), (uint32_t)permille, detail);
    dg_scpi_raise(self, code, detail);
}

void control_scale(struct dg_scpi *self, uint32_t argument)
{
    (void)argument;
    if (offered(self, ops_of(self)->scale != NULL)) {
        dg_scpi_put_number(self, ops_of(self)->scale(control_rig_of(self)), SCALE_PLACES);
    }
}

void control_step_time(struct dg_scpi *self, uint32_t argument)
{
    char detail[CONTROL_DETAIL_SIZE] = "";
    int64_t span;

    (void)argument;
    if (dg_scpi_number(self, &spans, &span) && offered(self, ops_of(self)->step != NULL)) {
        const int code = ops_of(self)->step(control_rig_of(self), (dg_ns)span, detail);
        dg_scpi_raise(self, code, detail);
        /* The rest of the line is done then. */
        self->now = code == DG_SCPI_NO_ERROR ? dg_after(self->now, (dg_ns)span) : self->now;
    }
}

static void trace(struct dg_scpi *self, const char *path)
{
    struct dg_rig *rig = control_rig_of(self);
    char detail[CONTROL_DETAIL_SIZE] = "";

    if (offered(self, rig->ops->trace != NULL)) {
        const int code = rig->ops->trace(rig, control_encoder(self), path, detail);
        dg_scpi_raise(self, code, detail);
    }
}

void control_trace(struct dg_scpi *self, uint32_t argument)
{
    char path[DG_SCPI_LINE_MAX + 1u];

    (void)argument;
    if (dg_scpi_text(self, path, sizeof path)) {
        trace(self, path);
    }
}

void control_trace_stop(struct dg_scpi *self, uint32_t argument)
{
    (void)argument;
    trace(self, NULL);
}

void control_last(struct dg_scpi *self, uint32_t argument)
{
    struct dg_rig *rig = control_rig_of(self);
    char text[LINE_SIZE];
    int64_t wanted = 1;
    size_t count = 0;

    (void)argument;
    if ((dg_scpi_more(self) && !dg_scpi_number(self, &lines, &wanted)) ||
        !offered(self, rig->ops->last != NULL)) {
        return;
    }
    for (unsigned back = (unsigned)wanted; back > 0; back--) {
        if (rig->ops->last(rig, control_encoder(self), back - 1u, text, sizeof text)) {
            dg_scpi_put_string(self, text);
            count++;
        }
    }
    control_put_none(self, count);
}

/* Whether the selected encoder is one with BiSS on a wire that the host clocks. */
static bool has_biss(struct dg_scpi *self, bool there)
{
    if (control_encoder(self)->kind->stack != DG_STACK_BISS) {
        control_refuse(self, DG_SCPI_MISSING_HARDWARE, "it is no BiSS encoder");
        return false;
    }
    return offered(self, there);
}

static uint64_t field(uint64_t bits, uint8_t low, uint8_t count)
{
    return bits >> low & (((uint64_t)1 << count) - 1u);
}

/* Behind CDS: MT:ST, nERR, nWARN, LC if there is one, CRC. */
static void put_frame(struct dg_scpi *self, const struct dg_biss_model *model, uint64_t bits)
{
    const uint8_t life_bits = model->life_counter ? LIFE_BITS : 0;
    const uint8_t position_bits = (uint8_t)(model->multiturn_bits + model->singleturn_bits);
    const uint8_t warn = (uint8_t)(CRC_BITS + life_bits);
    const uint8_t low = (uint8_t)(warn + STATE_BITS);
    const uint8_t checked = (uint8_t)(position_bits + STATE_BITS + life_bits);
    const uint8_t crc = dg_biss_crc6(bits >> CRC_BITS, checked);

    dg_scpi_put_unsigned(self, field(bits, low, position_bits));
    dg_scpi_put_unsigned(self, field(bits, (uint8_t)(warn + 1u), 1));
    dg_scpi_put_unsigned(self, field(bits, warn, 1));
    dg_scpi_put_unsigned(self, field(bits, CRC_BITS, life_bits));
    dg_scpi_put_unsigned(self, field(bits, 0, CRC_BITS) == crc ? 1 : 0);
}

void control_frame(struct dg_scpi *self, uint32_t argument)
{
    struct dg_encoder *encoder = control_encoder(self);
    char detail[CONTROL_DETAIL_SIZE] = "";
    uint64_t bits = 0;
    uint8_t count = 0;

    (void)argument;
    if (!has_biss(self, ops_of(self)->biss_frame != NULL)) {
        return;
    }
    const int code = ops_of(self)->biss_frame(control_rig_of(self), encoder, &bits, &count, detail);
    if (code != DG_SCPI_NO_ERROR) {
        dg_scpi_raise(self, code, detail);
    } else if (count <= 1) {
        control_refuse(self, DG_SCPI_HARDWARE, "no data in the frame");
    } else {
        const struct dg_biss *device = encoder->device;
        put_frame(self, device->setup.model, bits);
    }
}

void control_read(struct dg_scpi *self, uint32_t argument)
{
    char detail[CONTROL_DETAIL_SIZE] = "";
    uint8_t bytes[DG_BISS_BANK_SIZE] = {0};
    int64_t address;
    int64_t n = 1;

    (void)argument;
    if (!dg_scpi_number(self, &addresses, &address) ||
        (dg_scpi_more(self) && !dg_scpi_number(self, &sizes, &n)) ||
        !has_biss(self, ops_of(self)->biss_read != NULL)) {
        return;
    }
    const int code = ops_of(self)->biss_read(control_rig_of(self), control_encoder(self),
                                             (uint8_t)address, bytes, (size_t)n, detail);
    dg_scpi_raise(self, code, detail);
    for (int64_t i = 0; code == DG_SCPI_NO_ERROR && i < n; i++) {
        dg_scpi_put_unsigned(self, bytes[i]);
    }
}

void control_write(struct dg_scpi *self, uint32_t argument)
{
    char detail[CONTROL_DETAIL_SIZE] = "";
    uint8_t bytes[DG_BISS_BANK_SIZE];
    int64_t address;
    int64_t byte;
    size_t n = 0;

    (void)argument;
    if (!dg_scpi_number(self, &addresses, &address)) {
        return;
    }
    do {
        if (!dg_scpi_number(self, &bytes_range, &byte)) {
            return;
        }
        bytes[n++] = (uint8_t)byte;
    } while (n < sizeof bytes && dg_scpi_more(self));
    if (dg_scpi_more(self)) {
        dg_scpi_raise(self, DG_SCPI_SUPERFLUOUS, "at most 64 bytes");
        return;
    }
    if (has_biss(self, ops_of(self)->biss_write != NULL)) {
        const int code = ops_of(self)->biss_write(control_rig_of(self), control_encoder(self),
                                                  (uint8_t)address, bytes, n, detail);
        dg_scpi_raise(self, code, detail);
    }
}
