/* SPDX-License-Identifier: MIT */
/*
 * BISS: frames and registers through a wire that the host clocks.
 */
#include "control_private.h"
#include "drehgeber/biss.h"

static const struct dg_scpi_range addresses = {DG_SCPI_PLAIN, 0, 0, 0x7F};
static const struct dg_scpi_range sizes = {DG_SCPI_PLAIN, 0, 1, DG_BISS_BANK_SIZE};
static const struct dg_scpi_range bytes_range = {DG_SCPI_PLAIN, 0, 0, UINT8_MAX};

/* Whether the selected encoder is one with BiSS on a wire that the host clocks. */
static bool has_biss(struct dg_scpi *self, bool there)
{
    if (control_encoder(self)->kind->stack != &dg_biss_stack) {
        control_refuse(self, DG_SCPI_MISSING_HARDWARE, "it is no BiSS encoder");
        return false;
    }
    return control_offered(self, there);
}

static void put_frame(struct dg_scpi *self, const struct dg_biss_model *model, uint64_t bits)
{
    struct dg_biss_data data;

    dg_biss_frame_decode(model, bits, &data);
    dg_scpi_put_unsigned(self, data.position);
    dg_scpi_put_unsigned(self, data.n_err);
    dg_scpi_put_unsigned(self, data.n_warn);
    dg_scpi_put_unsigned(self, data.life);
    dg_scpi_put_unsigned(self, data.crc_ok);
}

void control_frame(struct dg_scpi *self, uint32_t argument)
{
    struct dg_encoder *encoder = control_encoder(self);
    char detail[CONTROL_DETAIL_SIZE] = "";
    uint64_t bits = 0;
    uint8_t count = 0;

    (void)argument;
    if (!has_biss(self, control_ops_of(self)->biss_frame != NULL)) {
        return;
    }
    const int code =
        control_ops_of(self)->biss_frame(control_rig_of(self), encoder, &bits, &count, detail);
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
        !has_biss(self, control_ops_of(self)->biss_read != NULL)) {
        return;
    }
    const int code = control_ops_of(self)->biss_read(control_rig_of(self), control_encoder(self),
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
    if (has_biss(self, control_ops_of(self)->biss_write != NULL)) {
        const int code = control_ops_of(self)->biss_write(
            control_rig_of(self), control_encoder(self), (uint8_t)address, bytes, n, detail);
        dg_scpi_raise(self, code, detail);
    }
}
