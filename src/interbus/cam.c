/* SPDX-License-Identifier: MIT */
/* The cam mode (manual 5.4.4, 9.5): programs, edges, masks, and the word they make. */
#include "interbus_private.h"

#define CAM_FIELD(word) ((word) >> 25 & 0xFu)
#define OFF_EDGE 0x20000000u
#define READ_OFF 0x20u
#define SHIFTED_MASK 0x1FFFFu

/* I15: on <= off is a stretch, on > off leads through zero, on == off is empty. */
static bool is_cam_on(const struct dg_ib_program *program, uint8_t cam, uint32_t position)
{
    uint32_t on = program->on[cam];
    uint32_t off = program->off[cam];

    return on <= off ? on <= position && position < off : position >= on || position < off;
}

uint32_t dg_ib_cam_word(const struct dg_ib *self, dg_angle angle)
{
    const struct dg_ib_program *program = &self->program;
    uint32_t position = dg_ib_position_at(self, angle);
    uint32_t given = program->mask & program->on_given & program->off_given;
    uint32_t cams = 0;

    for (uint8_t i = 0; i < DG_IB_CAMS; i++) {
        cams |= (is_cam_on(program, i, position) ? 1u : 0u) << i;
    }
    return (position >> self->shift_iw & SHIFTED_MASK) << 8 | (cams & given);
}

uint32_t dg_ib_set_program(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint8_t number = word & 0xFu;
    uint8_t mode = number == 0 ? DG_IB_POSITION : (uint8_t)(DG_IB_CAM + number);

    (void)now;
    if (number > DG_IB_PROGRAMS) {
        return DG_IB_UNKNOWN_CODE;
    }
    if (!dg_ib_put_u8(self, DG_IB_REGION_MODE, mode)) {
        return DG_IB_LOST;
    }
    self->mode = mode;
    if (number > 0) {
        self->program_number = number;
        dg_ib_load_program(self, number, &self->program);
    }
    return word | IB_ANSWER_BITS;
}

static uint32_t replace_program(struct dg_ib *self, const struct dg_ib_program *program,
                                uint32_t word)
{
    if (!dg_ib_put_program(self, program)) {
        return DG_IB_LOST;
    }
    self->program = *program;
    return word | IB_ANSWER_BITS;
}

uint32_t dg_ib_set_mask(struct dg_ib *self, dg_ns now, uint32_t word)
{
    struct dg_ib_program program = self->program;

    (void)now;
    if ((word & 0xFF00u) != 0) { /* I16: cams 8 to 15 */
        return DG_IB_UNKNOWN_CODE;
    }
    program.mask = (uint8_t)word;
    return replace_program(self, &program, word);
}

uint32_t dg_ib_set_edge(struct dg_ib *self, dg_ns now, uint32_t word)
{
    struct dg_ib_program program = self->program;
    uint32_t cam = CAM_FIELD(word);
    uint32_t position = word & DG_IB_DATA_MASK;
    bool off = (word & OFF_EDGE) != 0;

    (void)now;
    if (cam >= DG_IB_CAMS) {
        return DG_IB_UNKNOWN_CODE;
    }
    if (position >= dg_ib_range(self)) {
        return DG_IB_CAM_POSITION;
    }
    (off ? program.off : program.on)[cam] = position;
    *(off ? &program.off_given : &program.on_given) |= (uint8_t)(1u << cam);
    return replace_program(self, &program, word);
}

uint32_t dg_ib_set_shift_iw(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint8_t shift = (uint8_t)word;

    (void)now;
    if (shift > IB_SHIFT_IW_MAX) {
        return DG_IB_ILLEGAL_DATA;
    }
    if (!dg_ib_put_u8(self, DG_IB_REGION_SHIFT_IW, shift)) {
        return DG_IB_LOST;
    }
    self->shift_iw = shift;
    return word | IB_ANSWER_BITS;
}

uint32_t dg_ib_read_mask(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)now;
    (void)word;
    return DG_IB_READ_OUT | self->program.mask;
}

uint32_t dg_ib_read_edge(struct dg_ib *self, dg_ns now, uint32_t word)
{
    const uint32_t *edges = (word & READ_OFF) != 0 ? self->program.off : self->program.on;
    uint32_t cam = word & 0xFu;

    (void)now;
    return cam < DG_IB_CAMS ? DG_IB_READ_OUT | edges[cam] : DG_IB_UNKNOWN_CODE;
}

uint32_t dg_ib_read_shift_iw(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)now;
    (void)word;
    return DG_IB_READ_OUT | self->shift_iw;
}
