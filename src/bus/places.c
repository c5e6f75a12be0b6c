/* SPDX-License-Identifier: MIT */
/* What all buses do alike: places, the order of time, and who asks whom. */
#include "bus_private.h"

#include <string.h>

static size_t round_up(size_t n)
{
    return (n + DG_HOST_ALIGN - 1u) / DG_HOST_ALIGN * DG_HOST_ALIGN;
}

size_t dg_bus_size(const struct dg_bus_medium *medium, size_t encoders)
{
    if (encoders == 0 || encoders > medium->encoders_most) {
        return 0;
    }
    return round_up(sizeof(struct dg_bus)) + round_up(medium->wire_size) +
           encoders * round_up(medium->place_size);
}

struct dg_bus *dg_bus_init(void *memory, size_t size, const struct dg_bus_setup *setup)
{
    struct dg_bus *self = memory;

    if (setup->size != sizeof *setup || setup->ops == NULL ||
        (setup->ops->tx == NULL && !setup->medium->is_read)) {
        return NULL;
    }
    const size_t needed = dg_bus_size(setup->medium, setup->encoders);
    if (memory == NULL || needed == 0 || size < needed || (uintptr_t)memory % DG_HOST_ALIGN != 0) {
        return NULL;
    }
    memset(memory, 0, needed);
    *self = (struct dg_bus){
        .medium = setup->medium,
        .ops = setup->ops,
        .ctx = setup->ctx,
        .watched = setup->ops->tap != NULL,
        .room = setup->encoders,
        .stride = round_up(setup->medium->place_size),
        .wire = (uint8_t *)memory + round_up(sizeof *self),
    };
    self->places = (uint8_t *)self->wire + round_up(setup->medium->wire_size);
    return self->medium->begin(self, setup->wire) == DG_OK ? self : NULL;
}

static void hear_encoder(void *ctx, const struct dg_host_event *event)
{
    struct bus_place *from = ctx;

    from->bus->medium->hear(from, event);
}

/* Who draws by chance draws otherwise than the others on the wire: unless somebody else has begun
 * it, chance begins with the place. */
static struct dg_encoder *begin_chance(struct dg_encoder *control, size_t place)
{
    if (control != NULL && control->faults.random == 0) {
        control->faults.random = (uint32_t)place;
    }
    return control;
}

int dg_bus_attach(struct dg_bus *self, struct dg_host *encoder, struct dg_encoder *control)
{
    const struct dg_stack *stack = dg_host_wire_at(encoder)->stack;

    if (stack->medium != self->medium->medium || dg_host_side_at(encoder) == NULL) {
        return DG_ERR_ARGUMENT;
    }
    if (self->count == self->room) {
        return DG_ERR_SPACE;
    }
    struct bus_place *place = dg_bus_place_at(self, self->count);
    *place = (struct bus_place){.bus = self,
                                .host = encoder,
                                .control = begin_chance(control, self->count),
                                .index = self->count,
                                .deadline = dg_host_next(encoder)};
    const int result = self->medium->attach(place);
    if (result != DG_OK) {
        return result;
    }
    dg_host_join_bus(encoder, hear_encoder, place);
    self->count++;
    return (int)place->index;
}

/* Those behind place `index`, which is empty, move up to it. */
static void close_gap(struct dg_bus *self, size_t index)
{
    self->count--;
    for (size_t i = index; i < self->count; i++) {
        struct bus_place *place = dg_bus_place_at(self, i);
        memcpy(place, dg_bus_place_at(self, i + 1u), self->stride);
        place->index = i;
        dg_host_join_bus(place->host, hear_encoder, place);
    }
    memset(dg_bus_place_at(self, self->count), 0, self->stride);
}

/* What is due at `now` the encoder does already without a wire. */
dg_ns dg_bus_detach(struct dg_bus *self, size_t place, dg_ns now)
{
    struct bus_place *leaving = dg_bus_place_at(self, place);
    struct dg_host *encoder = leaving->host;

    dg_bus_run_until(self, now);
    if (self->medium->detach != NULL) {
        self->medium->detach(leaving);
    }
    dg_host_listen(encoder, NULL, NULL);
    close_gap(self, place);
    if (self->medium->moved != NULL) {
        self->medium->moved(self, place);
    }
    dg_host_skip(encoder, self->now);
    (void)dg_host_step(encoder, self->now);
    return dg_bus_step(self, now);
}

void dg_bus_control(struct dg_bus *self, size_t place, struct dg_encoder *control)
{
    dg_bus_place_at(self, place)->control = begin_chance(control, place);
}

dg_ns dg_bus_next(const struct dg_bus *self)
{
    return self->medium->next(self);
}

/* What is due before `now` happens first, each at its own moment. */
static void serve_each(struct dg_bus *self, dg_ns now)
{
    dg_ns next = dg_bus_next(self);

    while (next < now) {
        /* Whoever asks for the present again would stop time. */
        self->now = next > self->now ? next : self->now;
        self->medium->go_on(self, self->now);
        const dg_ns later = dg_bus_next(self);
        next = later > self->now ? later : dg_after(self->now, 1);
    }
}

/* It is `now`; a medium that is ordered catches up by itself. DG_NEVER is no moment. */
static inline void enter_moment(struct dg_bus *self, dg_ns now)
{
    if (now == DG_NEVER) {
        return;
    }
    self->called = now > self->called ? now : self->called;
    if (!self->medium->ordered) {
        serve_each(self, now);
    }
    self->now = now > self->now ? now : self->now;
}

void dg_bus_run_until(struct dg_bus *self, dg_ns now)
{
    enter_moment(self, now);
    if (self->medium->ordered) {
        self->medium->go_on(self, dg_elapsed(self->now, 1));
    }
}

dg_ns dg_bus_rx(struct dg_bus *self, const struct dg_tap_event *event)
{
    enter_moment(self, event->at);
    self->medium->take(self, event);
    self->medium->go_on(self, self->now);
    return dg_bus_next(self);
}

dg_ns dg_bus_step(struct dg_bus *self, dg_ns now)
{
    enter_moment(self, now);
    self->medium->go_on(self, self->now);
    return dg_bus_next(self);
}

void dg_bus_look(struct dg_bus *self, dg_ns now)
{
    dg_bus_run_until(self, now);
}

dg_ns dg_bus_changed(struct dg_bus *self, size_t place, dg_ns now)
{
    struct bus_place *changed = dg_bus_place_at(self, place);

    dg_bus_run_until(self, now);
    if (self->medium->feel != NULL) {
        self->medium->feel(changed, self->now);
    }
    changed->deadline = dg_host_step(changed->host, self->now);
    self->medium->changed(changed, self->now);
    return dg_bus_step(self, now);
}

dg_ns dg_bus_durable(struct dg_bus *self, size_t place, dg_ns now)
{
    dg_bus_run_until(self, now);
    if (self->medium->durable != NULL) {
        self->medium->durable(dg_bus_place_at(self, place), self->now);
    }
    return dg_bus_step(self, now);
}

void dg_bus_watch(struct dg_bus *self, bool watched)
{
    self->watched = watched && self->ops->tap != NULL;
}

size_t dg_bus_count(const struct dg_bus *self)
{
    return self->count;
}

struct dg_host *dg_bus_encoder(const struct dg_bus *self, size_t place)
{
    return dg_bus_place_at(self, place)->host;
}

void *dg_bus_device(const struct dg_bus *self, size_t place)
{
    return dg_host_line_of(dg_bus_encoder(self, place))->device;
}

const void *dg_bus_settings(const struct dg_bus *self, size_t place)
{
    return dg_host_line_of(dg_bus_encoder(self, place))->settings;
}
