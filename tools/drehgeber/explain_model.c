/* SPDX-License-Identifier: MIT */
#include "explain_model.h"

#include <stdlib.h>
#include <string.h>

#include "drehgeber/angle.h"
#include "drehgeber/host_wire.h"
#include "explain_source.h"
#include "stacks.h"

#define LOOKS 64u     /* positions that tell how many bits there are */
#define STEPS_MAX 16u /* each is nearer by the counts of a 16th of a turn */
#define ANGLE_MAX (INT64_C(1) << 60)
#define SIXTEENTH (INT64_C(1) << 28)
#define SIXTY_FOURTH (INT64_C(1) << 26)
#define RATE_MASK 0x7FFFFFFF /* below half a turn a second */
#define ADDRESS_MAX 12u

/* --- making --- */

static struct dg_host *make_host(const struct dg_device *device)
{
    const struct dg_host_wire *wire = dg_host_wire_of(device);
    const size_t size = dg_host_size(device, wire);
    const size_t room = (size + DG_HOST_ALIGN - 1u) / DG_HOST_ALIGN * DG_HOST_ALIGN;
    void *memory = aligned_alloc(DG_HOST_ALIGN, room);
    struct dg_host *host = memory == NULL ? NULL : dg_host_init(memory, room, device, wire);
    if (host == NULL) {
        free(memory);
    }
    return host;
}

static int refuse_setting(const char *key, const char *value, const char *what,
                          struct lx_error *error)
{
    (void)lx_fail(error, "%s", what);
    return lx_about(error, LX_ABOUT_SETTING, key, value);
}

static int set_setting(struct dg_host *host, const char *key, const char *value,
                       struct lx_error *error)
{
    const int result = dg_host_set(host, key, value);
    if (result == DG_HOST_ERR_NAME) {
        return refuse_setting(key, value, "no setting of this model", error);
    }
    return result == DG_HOST_OK ? 0 : refuse_setting(key, value, "out of its range", error);
}

static int set_address(struct dg_host *host, const struct options *options, struct lx_error *error)
{
    const char *key = dg_host_address_key(host);
    const char *value = options->address != NULL ? options->address : options->node;
    if (value == NULL) {
        return 0;
    }
    if (key == NULL) {
        return lx_fail(error, "%s has no address", options->model);
    }
    if (dg_host_set(host, key, value) != DG_HOST_OK) {
        return lx_fail(error, "--%s %s: no %s of %s", options->address != NULL ? "address" : "node",
                       value, key, options->model);
    }
    return 0;
}

static int start_encoder(struct dg_host *host, const struct options *options,
                         struct lx_error *error)
{
    struct dg_host_event event;
    if (host == NULL) {
        return lx_fail(error, "%s: no memory", options->model);
    }
    if (set_address(host, options, error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < options->settings.count; i++) {
        const struct dg_plan_setting *row = &options->settings.list[i];
        if (set_setting(host, row->key, row->value, error) != 0) {
            return -1;
        }
    }
    const int result = dg_host_power(host, 0, true);
    if (result != DG_HOST_OK) {
        return lx_fail(error, "%s: %s", options->model, dg_host_result_text(result));
    }
    while (dg_host_receive(host, &event) != 0) {
    }
    return 0;
}

void explain_model_free(struct explain_model *self)
{
    free(self->model);
    free(self->probe);
    *self = (struct explain_model){.model = NULL};
}

/* --- positions --- */

/* A number that follows from the last one, for each place of the probe (a xorshift of 32 bits). */
static uint32_t draw_number(struct explain_model *self)
{
    uint32_t x = self->seed;
    x ^= x << 13;
    x ^= x >> 17;
    x ^= x << 5;
    self->seed = x;
    return x;
}

static int64_t draw_angle(struct explain_model *self)
{
    const int64_t turns = (int64_t)(draw_number(self) & 0xFFFFFFu);
    return turns * DG_TURN + (int64_t)draw_number(self);
}

static uint64_t position(const struct dg_host *host, dg_ns now)
{
    uint64_t counts = 0;
    return dg_host_position(host, now, &counts) == DG_HOST_OK ? counts : 0;
}

static uint64_t position_at(struct dg_host *host, dg_ns now, int64_t angle)
{
    dg_host_shaft(host, now, angle, 0);
    return position(host, now);
}

static uint64_t distance(uint64_t a, uint64_t b)
{
    return a > b ? a - b : b - a;
}

/* How positions of this model count. Settings that are made of them stay as they are. */
static void measure_model(struct explain_model *self)
{
    uint64_t all = 0;
    uint64_t turn = UINT64_MAX;
    for (unsigned i = 0; i < LOOKS; i++) {
        const int64_t angle = draw_angle(self);
        const uint64_t here = position_at(self->probe, EXPLAIN_BEGIN, angle);
        const uint64_t there = position_at(self->probe, EXPLAIN_BEGIN, angle + SIXTY_FOURTH);
        turn = distance(here, there) < turn ? distance(here, there) : turn;
        all |= here | there;
    }
    for (; all != 0; all >>= 1) {
        self->bits++;
    }
    self->turn = (uint32_t)(turn > UINT32_MAX ? 0 : turn);
}

int explain_model_make(struct explain_model *self, const struct options *options,
                       struct lx_error *error)
{
    *self = (struct explain_model){.seed = 0x2545F491};
    self->model = make_host(options->device);
    self->probe = make_host(options->device);
    if (start_encoder(self->model, options, error) != 0 ||
        start_encoder(self->probe, options, error) != 0) {
        explain_model_free(self);
        return -1;
    }
    (void)dg_host_step(self->model, EXPLAIN_BEGIN);
    (void)dg_host_step(self->probe, EXPLAIN_BEGIN);
    measure_model(self);
    return 0;
}

void explain_model_move(struct explain_model *self, dg_ns now, bool turning)
{
    const int64_t angle = draw_angle(self);
    const int64_t rate = turning ? (int64_t)(draw_number(self) & RATE_MASK) - RATE_MASK / 2 : 0;
    dg_host_shaft(self->probe, now, angle, rate);
}

/* Counts that a 16th of a turn makes, which may wrap in one place only. 0: it does not count. */
static int64_t find_slope(struct dg_host *host, dg_ns now, int64_t angle)
{
    const int64_t here = (int64_t)position_at(host, now, angle);
    const int64_t next = (int64_t)position_at(host, now, angle + SIXTEENTH);
    const int64_t last = (int64_t)position_at(host, now, angle + 2 * SIXTEENTH);
    return llabs(next - here) <= llabs(last - next) ? next - here : last - next;
}

/* By as many counts as are missing, again and again, as the slope is not exact. One that would be
   missed again and again, as it is at the edge of a count, is met from another place in the count.
 */
bool explain_model_place(struct explain_model *self, dg_ns now, uint64_t counts)
{
    struct dg_host *host = self->model;
    int64_t angle = dg_host_angle(host, now);
    const int64_t slope = find_slope(host, now, angle);
    uint64_t here = position_at(host, now, angle);
    for (unsigned i = 0; i < STEPS_MAX && here != counts && slope != 0; i++) {
        const int64_t missing = (int64_t)(counts - here);
        angle += missing / slope * SIXTEENTH + missing % slope * SIXTEENTH / slope;
        angle += i < STEPS_MAX / 2u ? 0 : SIXTEENTH / slope / 4;
        if (angle > ANGLE_MAX || angle < -ANGLE_MAX) {
            break;
        }
        here = position_at(host, now, angle);
    }
    return here == counts;
}

uint32_t explain_model_address(const struct explain_model *self)
{
    const char *key = dg_host_address_key(self->model);
    char text[ADDRESS_MAX] = "";
    if (key == NULL || dg_host_get(self->model, key, text, sizeof text) < 0) {
        return 0;
    }
    const size_t n = strlen(text);
    const bool hex = n > 1u && (text[n - 1u] == 'h' || text[1] == 'x');
    return (uint32_t)strtoul(text, NULL, hex ? 16 : 10);
}
