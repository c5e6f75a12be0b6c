/* SPDX-License-Identifier: MIT */
/*
 * Time and queues: what waits in the queue and what the device is waiting for happen in the order
 * of their moments, whatever the pace of the host is.
 *
 *   host   step(t0)                         step(t1)
 *   queue    |     rx   rx   rx                |        at the same moment: what comes in first
 *   device   |                    deadline     |
 *            -----> run, each at its own now -->
 */
#include "host_private.h"

/* ------------------------------------------------------------ queues */

static struct dg_host_event *first_event_of(struct host_queue *queue)
{
    return queue->count != 0 ? &queue->event[queue->first] : NULL;
}

static void drop_head(struct host_queue *queue)
{
    queue->first = (queue->first + 1u) % DG_HOST_QUEUE;
    queue->count--;
}

static void append_event(struct host_queue *queue, const struct dg_host_event *event)
{
    queue->event[(queue->first + queue->count) % DG_HOST_QUEUE] = *event;
    queue->count++;
}

void dg_host_deliver(struct dg_host *self, const struct dg_host_event *event)
{
    struct host_queues *queues = self->refs.queues;

    if (self->refs.heard != NULL) {
        self->refs.heard(self->refs.heard_ctx, event);
    } else if (queues == NULL || queues->out.count == DG_HOST_QUEUE || self->untold) {
        /* The gap is told where it is: nothing gets behind it before somebody knows. */
        self->lost++;
        self->untold = true;
    } else {
        append_event(&queues->out, event);
    }
}

void dg_host_emit(struct dg_host_line *line, const struct dg_host_event *event)
{
    struct dg_host *self = (struct dg_host *)(void *)line;
    struct dg_host_event copy = *event;
    unsigned times = 1;

    if (self->refs.faults != NULL) {
        times = self->refs.faults->arrives(self->refs.faults_ctx, &copy);
    }
    while (times-- > 0) {
        dg_host_deliver(self, &copy);
    }
}

int dg_host_receive(struct dg_host *self, struct dg_host_event *to)
{
    struct host_queues *queues = self->refs.queues;
    const struct dg_host_event *event = queues != NULL ? first_event_of(&queues->out) : NULL;

    if (event == NULL) {
        const bool untold = self->untold;
        self->untold = false;
        return untold ? DG_HOST_ERR_LOST : 0;
    }
    *to = *event;
    drop_head(&queues->out);
    return 1;
}

uint32_t dg_host_lost(const struct dg_host *self)
{
    return self->lost;
}

void dg_host_listen(struct dg_host *self, void (*heard)(void *, const struct dg_host_event *),
                    void *ctx)
{
    self->refs.heard = heard;
    self->refs.heard_ctx = ctx;
    self->line.on_bus = false;
}

static int check_edge(const struct dg_host_event *event)
{
    if (event->kind != DG_HOST_EDGE) {
        return DG_HOST_ERR_WIRE;
    }
    return event->length == 1 && event->data[0] <= 1 ? DG_HOST_OK : DG_HOST_ERR_ARGUMENT;
}

int dg_host_check_event(const struct dg_host_wire *wire, const struct dg_host_event *event)
{
    const int result = wire->check != NULL ? wire->check(event) : check_edge(event);

    return result == DG_HOST_OK && event->length > sizeof event->data ? DG_HOST_ERR_ARGUMENT
                                                                      : result;
}

int dg_host_send(struct dg_host *self, const struct dg_host_event *event)
{
    struct host_queues *queues = self->refs.queues;
    const int result = dg_host_check_event(self->refs.wire, event);

    if (result != DG_HOST_OK) {
        return result;
    }
    if (!self->made || queues == NULL) {
        return DG_HOST_ERR_STATE;
    }
    if (queues->in.count == DG_HOST_QUEUE) {
        return DG_HOST_ERR_SPACE;
    }
    append_event(&queues->in, event);
    return DG_HOST_OK;
}

/* ------------------------------------------------------------ time */

/* When the next part of what waits is to be taken. */
static dg_ns due_in(const struct dg_host *self)
{
    struct host_queues *queues = self->refs.queues;
    const struct dg_host_wire *wire = self->refs.wire;
    const struct dg_host_event *event = queues != NULL ? first_event_of(&queues->in) : NULL;

    if (event == NULL) {
        return DG_NEVER;
    }
    return wire->due != NULL ? wire->due(&self->line, event) : event->at;
}

/* The encoder's line at its other end. */
static bool seen(struct dg_host *self)
{
    const bool raw = self->refs.wire->level(&self->line);

    return self->refs.faults != NULL ? self->refs.faults->bent(self->refs.faults_ctx, raw) : raw;
}

/* The line may have another level than was told. */
void dg_host_look_at_level(struct dg_host *self)
{
    struct dg_host_line *line = &self->line;

    if (self->refs.wire->level == NULL) {
        return;
    }
    const bool level = seen(self);
    if (level != line->level) {
        const struct dg_host_event event = {
            .at = line->now, .kind = DG_HOST_EDGE, .length = 1, .data = {level}};
        line->level = level;
        dg_host_emit(line, &event);
    }
}

/* What the wire's controller is by itself. */
void dg_host_note_controller(struct dg_host *self, const struct dg_host_event *event)
{
    if (event->kind == DG_HOST_BUS && event->id <= DG_HOST_BUS_OFF) {
        self->controller = (uint8_t)event->id;
    }
}

/* The next part of an event. What a fault keeps from the encoder is not taken at all. @return
 * whether it was the last one */
bool dg_host_take_event(struct dg_host *self, struct dg_host_event *event)
{
    const struct dg_host_wire *wire = self->refs.wire;

    dg_host_note_controller(self, event);
    if (self->line.part == 0 && self->refs.faults != NULL &&
        !self->refs.faults->hears(self->refs.faults_ctx, event)) {
        return true;
    }
    if (wire->take != NULL) {
        return wire->take(&self->line, event);
    }
    (void)wire->clock(&self->line, self->line.now, event->data[0] != 0);
    return true;
}

static void take_queued(struct dg_host *self)
{
    struct host_queue *in = &self->refs.queues->in;

    while (in->count != 0 && due_in(self) <= self->line.now) {
        if (dg_host_take_event(self, &in->event[in->first])) {
            self->line.part = 0;
            drop_head(in);
        }
        dg_host_look_at_level(self);
    }
}

/* What comes in comes before what is due at the same moment (hiperface.h). */
void dg_host_serve(struct dg_host *self)
{
    if (self->refs.queues != NULL) {
        take_queued(self);
    }
    self->deadline = self->refs.device->stack->step(self->line.device, self->line.now);
    dg_host_look_at_level(self);
}

/* Whatever is due before `now`, which is the present then. DG_NEVER is no moment. */
void dg_host_run_until(struct dg_host *self, dg_ns now)
{
    dg_ns next = dg_host_next(self);

    if (now == DG_NEVER) {
        return;
    }
    while (self->made && next < now) {
        /* A device that asks for the present again would stop time. */
        self->line.now = next > self->line.now ? next : self->line.now;
        dg_host_serve(self);
        const dg_ns later = dg_host_next(self);
        next = later > self->line.now ? later : dg_after(self->line.now, 1);
    }
    self->line.now = now > self->line.now ? now : self->line.now;
}

/* Nothing lies before the present, however late what is due is. */
void dg_host_run(struct dg_host *self, dg_ns now)
{
    if (now > self->line.now) {
        dg_host_run_until(self, now);
    }
    if (self->made) {
        dg_host_serve(self);
    }
}

uint64_t dg_host_next(const struct dg_host *self)
{
    const dg_ns in = self->made ? due_in(self) : DG_NEVER;

    return dg_earliest(in, self->deadline);
}

uint64_t dg_host_step(struct dg_host *self, uint64_t now)
{
    dg_host_run(self, now);
    return dg_host_next(self);
}

/* ------------------------------------------------------------ lines */

struct dg_host_line *dg_host_line_at(struct dg_host *self, const struct dg_host_wire *wire,
                                     dg_ns now, int *result)
{
    if (self->refs.wire != wire) {
        *result = DG_HOST_ERR_WIRE;
        return NULL;
    }
    dg_host_run(self, now);
    *result = dg_host_powered(self) ? DG_HOST_OK : DG_HOST_ERR_STATE;
    return *result == DG_HOST_OK ? &self->line : NULL;
}

void dg_host_line_done(struct dg_host *self)
{
    self->line.level = seen(self);
    dg_host_serve(self);
}
