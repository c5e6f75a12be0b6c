/* SPDX-License-Identifier: MIT */
/*
 * What a test bench does to an encoder beside its wires: it turns the shaft, bends the world,
 * looks.
 */
#include <stdio.h>
#include <string.h>

#include "drehgeber/shaft.h"
#include "hdl_private.h"

#define TURNS_MAX 1048576.0
#define TURN 4294967296.0

/* A real number from the simulator, which may be anything, as a whole one in units of `unit`.
   Upwards, as all angles: one that is written down for a step is in that step. */
static bool round_to_units(double value, double unit, double max, int64_t *to)
{
    if (!(value >= -max && value <= max)) {
        return false;
    }
    *to = (int64_t)(value * unit);
    *to += (double)*to < value * unit ? 1 : 0;
    return true;
}

/* What a call to the shaft gave. */
static int report_steering(struct dg_hdl *self, int result)
{
    hdl_look(self);
    return result == DG_HOST_OK ? result : hdl_fail(self, result, "the shaft cannot do that");
}

int dg_hdl_turn(struct dg_hdl *self, int64_t now, double turns)
{
    const uint64_t ns = hdl_run(self, now);
    int64_t angle;

    if (!round_to_units(turns, TURN, TURNS_MAX, &angle)) {
        return hdl_fail(self, DG_HOST_ERR_ARGUMENT, "turn: %g is beyond +-%.0f turns", turns,
                        TURNS_MAX);
    }
    return report_steering(self,
                           dg_shaft_set_position(dg_host_panel_shaft(self->panel), ns, angle));
}

int dg_hdl_speed(struct dg_hdl *self, int64_t now, double rpm)
{
    const uint64_t ns = hdl_run(self, now);
    const double max = DG_MOTION_SPEED_MAX_MRPM / 1000.0;
    int64_t mrpm;

    if (!round_to_units(rpm, 1000.0, max, &mrpm)) {
        return hdl_fail(self, DG_HOST_ERR_ARGUMENT, "speed: %g is beyond +-%.0f rpm", rpm, max);
    }
    return report_steering(
        self, dg_shaft_set_velocity(dg_host_panel_shaft(self->panel), ns, (int32_t)mrpm));
}

int dg_hdl_motion(struct dg_hdl *self, int64_t now, const char *words)
{
    const uint64_t ns = hdl_run(self, now);
    struct lx_error error = {.what = ""};
    struct lx_shaft wanted;

    if (lx_shaft_parse(&wanted, hdl_text(words), NULL, &error) != 0) {
        return hdl_fail(self, DG_HOST_ERR_ARGUMENT, "%s", lx_error_line(&error).text);
    }
    const int result = dg_shaft_play(dg_host_panel_shaft(self->panel), ns, &wanted.motion);
    lx_shaft_free(&self->shaft);
    self->shaft = wanted;
    return report_steering(self, result);
}

int dg_hdl_world(struct dg_hdl *self, int64_t now, const char *name, double value)
{
    struct dg_host_key key;
    char text[64];
    size_t i = 0;

    (void)hdl_run(self, now);
    while (dg_host_key(self->host, i, &key) == DG_HOST_OK) {
        if (key.always != 0 && strcmp(key.name, hdl_text(name)) == 0) {
            (void)snprintf(text, sizeof text, "%.*f", (int)key.places, value);
            const int result = dg_host_set(self->host, name, text);
            hdl_look(self);
            return result == DG_HOST_OK
                       ? result
                       : hdl_fail(self, result, "world: %s=%s is out of its range", name, text);
        }
        i++;
    }
    return hdl_fail(self, DG_HOST_ERR_NAME, "world: %s senses no '%s'", dg_host_model(self->host),
                    hdl_text(name));
}

int dg_hdl_fault(struct dg_hdl *self, int64_t now, const char *name, int on)
{
    const uint64_t ns = hdl_run(self, now);
    const int result = dg_host_fault_set(self->panel, ns, hdl_text(name), on != 0);

    hdl_look(self);
    return result == DG_HOST_OK ? result
                                : hdl_fail(self, result, "fault: %s: %s", hdl_text(name),
                                           dg_host_result_text(result));
}

int dg_hdl_power(struct dg_hdl *self, int64_t now, int on)
{
    const uint64_t ns = hdl_run(self, now);
    const int result = dg_host_power(self->host, ns, on != 0);

    if (on == 0) {
        self->looked = true;
        self->power_at = HDL_NEVER;
    }
    if (self->wire->reset != NULL) {
        hdl_cut(self);
    }
    hdl_look(self);
    return result == DG_HOST_OK ? result
                                : hdl_fail(self, result, "power: %s", dg_host_result_text(result));
}

const char *dg_hdl_command(struct dg_hdl *self, int64_t now, const char *line)
{
    const uint64_t ns = hdl_run(self, now);
    char queue[512];

    line = hdl_text(line);
    const int n = dg_host_scpi(self->panel, ns, line, self->answer, sizeof self->answer);

    hdl_look(self);
    (void)dg_host_scpi(self->panel, ns, "SYSTem:ERRor?", queue, sizeof queue);
    if (queue[0] != '0' && queue[0] != '\0') {
        (void)hdl_fail(self, DG_HOST_ERR_REFUSED, "command: %s: %s", line, queue);
        return NULL;
    }
    if (n < 0) {
        (void)hdl_fail(self, n, "command: %s: %s", line, dg_host_result_text(n));
        return NULL;
    }
    return self->answer;
}

/* --- looks --- */

int64_t dg_hdl_position(const struct dg_hdl *self, int64_t at)
{
    uint64_t counts;
    const uint64_t ns = at > 0 ? (uint64_t)at / HDL_PS_PER_NS : 0;

    return dg_host_position(self->host, ns, &counts) == DG_HOST_OK ? (int64_t)counts : -1;
}

int64_t dg_hdl_latched(const struct dg_hdl *self)
{
    uint64_t at;
    uint64_t counts;
    const int result = dg_host_latched(self->host, &at, &counts);

    if (result == DG_HOST_ERR_WIRE) {
        return dg_hdl_position(self, self->now);
    }
    return result == DG_HOST_OK ? (int64_t)counts : -1;
}

int64_t dg_hdl_latched_at(const struct dg_hdl *self)
{
    uint64_t at;
    uint64_t counts;

    return dg_host_latched(self->host, &at, &counts) == DG_HOST_OK ? (int64_t)at * HDL_PS_PER_NS
                                                                   : -1;
}

double dg_hdl_volts(const struct dg_hdl *self, int64_t at, int index)
{
    int32_t microvolts[4];
    const uint64_t ns = at > 0 ? (uint64_t)at / HDL_PS_PER_NS : 0;

    if (index < 0 || index > 3 || dg_host_sincos(self->host, ns, microvolts) != DG_HOST_OK) {
        return 0.0;
    }
    return microvolts[index] / 1e6;
}
