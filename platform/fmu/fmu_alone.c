/* SPDX-License-Identifier: MIT */
/*
 * One encoder by itself: its handle is all there is.
 */
#include <stdlib.h>

#include "encoder.h"

/* --- its memory --- */

/* @return NULL: `model` is none, or no memory */
static struct dg_host *make_built_in_handle(struct fmu_encoder *self)
{
    const size_t size = dg_host_size_of(self->model);
    self->memory = size == 0 ? NULL : calloc(1, size + DG_HOST_ALIGN);
    return self->memory == NULL ? NULL
                                : dg_host_make(encoder_aligned(self->memory), size, self->model);
}

static struct dg_host *make_handle_of_device(struct fmu_encoder *self)
{
    const struct dg_host_wire *wire = dg_host_wire_of(self->device);
    const size_t size = dg_host_size(self->device, wire);
    self->memory = calloc(1, size + DG_HOST_ALIGN);
    if (self->memory == NULL) {
        return NULL;
    }
    struct dg_host *host = dg_host_init(encoder_aligned(self->memory), size, self->device, wire);
    if (host != NULL) {
        dg_host_take_side(host, dg_bus_side_of(self->device));
    }
    return host;
}

static int make_handle_alone(struct fmu *all)
{
    struct fmu_encoder *self = all->encoders;
    free(self->memory);
    free(self->panel_memory);
    self->panel_memory = NULL;
    self->panel = NULL;
    self->host = self->device == NULL ? make_built_in_handle(self) : make_handle_of_device(self);
    if (self->host == NULL) {
        return -1;
    }
    self->has = encoder_has(self->host);
    return self->has != 0 ? 0 : -1;
}

static void free_handle(struct fmu *all)
{
    if (all->encoders != NULL) {
        free(all->encoders->memory);
        free(all->encoders->panel_memory);
    }
}

/* --- what is done to it --- */

static void run_handle(struct fmu *all, uint64_t to)
{
    struct fmu_encoder *self = all->encoders;
    if (self->panel != NULL) {
        (void)dg_host_panel_step(self->panel, to);
    } else {
        (void)dg_host_step(self->host, to);
    }
    wire_collect(self);
}

static int start_handle(struct fmu *all)
{
    struct dg_host *host = all->encoders->host;
    const int result = dg_host_power(host, 0, true);
    return result == DG_HOST_OK && !all->encoders->now.power ? dg_host_power(host, 0, false)
                                                             : result;
}

static void turn_handle(struct fmu *all, size_t shaft, uint64_t at, const int64_t *angle,
                        double rad_s)
{
    struct dg_host *host = all->encoders->host;
    (void)shaft;
    dg_host_shaft(host, at, angle != NULL ? *angle : dg_host_angle(host, at), fmu_turns(rad_s));
}

static int power_handle(struct fmu_encoder *self, bool on)
{
    return dg_host_power(self->host, self->all->now, on);
}

static int sense_handle(struct fmu_encoder *self, const char *quantity, int64_t value)
{
    return dg_host_world_set(self->host, self->all->now, quantity, value);
}

/* Made the first time; NULL: it was never on, or no memory. With a panel an encoder sits on the
   shaft of that: back to its own. */
static struct dg_host_panel *find_panel(struct fmu_encoder *self)
{
    const size_t size = dg_host_panel_size();
    if (self->panel != NULL) {
        return self->panel;
    }
    free(self->panel_memory);
    self->panel_memory = calloc(1, size + DG_HOST_ALIGN);
    if (self->panel_memory != NULL) {
        self->panel = dg_host_panel_make(encoder_aligned(self->panel_memory), size, self->host);
    }
    (void)dg_host_share(self->host, NULL);
    return self->panel;
}

static int find_handle_fault(struct fmu_encoder *self, size_t index, struct dg_host_fault *to)
{
    const struct dg_host_panel *panel = find_panel(self);
    return panel == NULL ? DG_HOST_ERR_STATE : dg_host_fault(panel, index, to);
}

static int set_handle_fault(struct fmu_encoder *self, size_t index, bool on)
{
    struct dg_host_fault fault;
    int result = find_handle_fault(self, index, &fault);
    if (result == DG_HOST_OK) {
        result = dg_host_fault_set(self->panel, self->all->now, fault.name, on);
    }
    wire_collect(self);
    return result;
}

/* --- its wire --- */

static int read_handle_frame(struct fmu_encoder *self, struct dg_host_frame *to)
{
    return dg_host_frame(self->host, self->all->now, to);
}

/* What a frame makes it say comes before what the next one does. */
static int send_to_handle(struct fmu_encoder *self, const struct dg_host_event *event)
{
    const int result = dg_host_send(self->host, event);
    if (event->kind == DG_HOST_CAN) {
        (void)dg_host_step(self->host, event->at);
        wire_collect(self);
    }
    return result;
}

static int say_to_handle(struct fmu_encoder *self, uint64_t at, const uint8_t *head, size_t n)
{
    struct dg_host_event event = {.kind = DG_HOST_BYTES, .id = wire_each(head)};
    const uint8_t *from = head + FMU_SERIAL_SIZE;
    struct dg_host_uart uart = {.baud = 9600};
    event.flags = head[14] & DG_HOST_DAMAGED;
    const int result = dg_host_uart(self->host, &uart);
    if (result == DG_HOST_ERR_WIRE && event.id == 0) {
        return result; /* it cannot say how long its characters take, so the master has to */
    }
    const uint64_t each = event.id == 0 ? dg_host_uart_ns(&uart, 1) : event.id;
    while (n > 0) {
        event.at = at;
        event.length = (uint8_t)(n < sizeof event.data ? n : sizeof event.data);
        for (size_t i = 0; i < event.length; i++) {
            event.data[i] = *from++;
        }
        const int sent = dg_host_send(self->host, &event);
        if (sent != DG_HOST_OK) {
            return sent;
        }
        at += event.length * each;
        n -= event.length;
    }
    return DG_HOST_OK;
}

static int64_t handle_bit_rate_of(const struct fmu_encoder *self)
{
    return INT64_C(1000) * dg_host_bit_rate(self->host);
}

static uint64_t next_of_handle(const struct fmu *all)
{
    return dg_host_next(all->encoders->host);
}

/* --- states --- */

static size_t handle_state_size(const struct fmu *all)
{
    return dg_host_state_size(all->encoders->host);
}

static int save_handle(struct fmu *all, uint8_t *to)
{
    return dg_host_save(all->encoders->host, to, handle_state_size(all));
}

static int restore_handle(struct fmu *all, const uint8_t *from, size_t n)
{
    return dg_host_restore(all->encoders->host, from, n);
}

const struct fmu_ops fmu_alone_ops = {
    .make = make_handle_alone,
    .free = free_handle,
    .start = start_handle,
    .turn = turn_handle,
    .power = power_handle,
    .sense = sense_handle,
    .entry = find_handle_fault,
    .fault = set_handle_fault,
    .frame = read_handle_frame,
    .send = send_to_handle,
    .say = say_to_handle,
    .bit_rate = handle_bit_rate_of,
    .run = run_handle,
    .next = next_of_handle,
    .state_size = handle_state_size,
    .save = save_handle,
    .restore = restore_handle,
};
