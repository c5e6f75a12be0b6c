/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the control plane: what its files share.
 */
#ifndef DREHGEBER_CONTROL_PRIVATE_H
#define DREHGEBER_CONTROL_PRIVATE_H

#include "drehgeber/control.h"
#include "drehgeber/quantity.h"
#include "drehgeber/text.h"

/** Longest name that is asked for, with its zero; those of faults and regions are shorter. */
#define CONTROL_NAME_MAX 64u
/** Room for the text of an error, with its zero. */
#define CONTROL_DETAIL_SIZE (DG_SCPI_DETAIL_MAX + 1u)
/** A probability of 1, and the decimals it has. */
#define CONTROL_PPM 1000000u
#define CONTROL_PPM_PLACES 6u

/** A command or a query. */
typedef void control_handler(struct dg_scpi *self);

/* text.c */

/** Whether two names are the same; case does not count, and '-' is '_'. */
bool dg_control_same(const char *a, const char *b);

/* session.c */
struct dg_rig *dg_control_rig_of(const struct dg_scpi *self);
/** Something about the selected encoder has changed. */
void dg_control_changed(struct dg_scpi *self);
/** Take a name. @return false: an error was raised */
bool dg_control_name(struct dg_scpi *self, char to[CONTROL_NAME_MAX]);
/** What the host can do. */
const struct dg_rig_ops *dg_control_ops_of(const struct dg_scpi *self);
/** What the host cannot do raises an error. @return `there` */
static inline bool control_offered(struct dg_scpi *self, bool there)
{
    if (!there) {
        dg_scpi_raise(self, DG_SCPI_MISSING_HARDWARE, NULL);
    }
    return there;
}
/** An answer that is a list of `count` names needs one when there are none: "". */
void dg_control_put_none(struct dg_scpi *self, size_t count);

/* fault_engine.c */
/** The quantity at `offset` of the world is `value`, as soon as nothing bends it. */
void dg_control_put_behind(struct dg_faults *self, const struct dg_fault_target *target,
                           size_t offset, int64_t value);
/** When the first one ends; DG_NEVER. */
dg_ns dg_control_next_end(const struct dg_faults *self);

/* eeprom_flip.c */
/** A bit of region `region`, which is flipped. @return 0 or DG_ERR_IO */
int dg_control_flip(const struct dg_fault_target *target, uint8_t region, uint32_t bit);
/** The same of a checked region; `done` is what dg_control_mend() needs. */
int dg_control_damage(const struct dg_fault_target *target, uint8_t region, uint32_t bit,
                      struct dg_fault_flip *done);
/** Flip it back, unless the region was written since. */
int dg_control_mend(const struct dg_fault_target *target, uint8_t region,
                    const struct dg_fault_flip *done);
/** What damage of a region does. */
const struct dg_damage_row *dg_control_damage_of(const struct dg_instrument *instrument,
                                                 const char *region);

/* rig.c */
/** The quantity follows nothing, any more. */
void dg_control_unfollow(struct dg_encoder *encoder, size_t quantity);

/* commands_world.c */
/** What may be asked for of a quantity that is no state. */
struct dg_scpi_range dg_control_range(const struct dg_quantity *row);

/* Commands, by file. */
control_handler dg_control_encoders, dg_control_select,
    dg_control_selection; /* commands_encoder.c */
control_handler dg_control_model, dg_control_wire, dg_control_power, dg_control_powered;
control_handler dg_control_state;
control_handler dg_control_shafts, dg_control_shaft_name; /* commands_shaft.c */
control_handler dg_control_set_position, dg_control_position;
control_handler dg_control_set_velocity, dg_control_velocity;
control_handler dg_control_set_acceleration, dg_control_acceleration;
control_handler dg_control_stop, dg_control_move, dg_control_moving;
control_handler dg_control_set_profile, dg_control_profile;
control_handler dg_control_record, dg_control_record_stop;
control_handler dg_control_set_world, dg_control_world, dg_control_healthy; /* commands_world.c */
control_handler dg_control_follow, dg_control_followed;                     /* commands_course.c */
control_handler dg_control_follow_points, dg_control_follow_on, dg_control_follows;
control_handler dg_control_catalogue, dg_control_fault, dg_control_clear; /* commands_fault.c */
control_handler dg_control_active, dg_control_happened;
control_handler dg_control_regions, dg_control_data, dg_control_corrupt, dg_control_erase;
control_handler dg_control_time, dg_control_origin, dg_control_set_scale,
    dg_control_scale; /* commands_time.c */
control_handler dg_control_step_time;
control_handler dg_control_trace, dg_control_trace_stop, dg_control_last,
    dg_control_severity; /* commands_trace.c */

/** For all commands that heal: every fault is cleared, every quantity healthy. */
void dg_control_clear_all(struct dg_scpi *self);
void dg_control_heal(struct dg_scpi *self);
/** *RST and *OPC. */
void dg_control_reset(struct dg_scpi *self);
dg_ns dg_control_settled(struct dg_scpi *self);

#endif
