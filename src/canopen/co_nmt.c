/* SPDX-License-Identifier: MIT */
/*
 * NMT state machine, heartbeat producer and consumers, node and life guarding (CiA 301).
 */
#include "co_nmt.h"
#include "co_pdo.h"
#include "co_sdo.h"

static const uint8_t no_details[5];

static uint32_t heartbeat_ms(const struct dg_co_node *self)
{
    return self->value[CO_HEARTBEAT_MS];
}

/* One of the deadlines that `others` is the first of. */
static void move_deadline(struct dg_co_node *self, dg_ns *deadline, dg_ns at)
{
    if (*deadline != at) {
        *deadline = at;
        self->others = 0;
    }
}

static void start_period(struct dg_co_node *self)
{
    move_deadline(self, &self->heartbeat_at, dg_co_after_ms(self->now, heartbeat_ms(self)));
}

/* Now, and again after the period. */
static void heartbeat(struct dg_co_node *self)
{
    const uint8_t state[1] = {(uint8_t)self->state};

    if (heartbeat_ms(self) != 0) {
        dg_co_send(self, (uint16_t)(CO_ID_GUARD + self->id), state, sizeof state);
    }
    start_period(self);
}

void dg_co_enter(struct dg_co_node *self, enum dg_co_state state)
{
    if (self->state == state) {
        return;
    }
    bool was_operational = self->state == DG_CO_OPERATIONAL;
    bool booted = self->state == DG_CO_BOOT;
    self->state = state;
    if (self->emcy_count != 0) {
        self->others = 0; /* EMCYs may go now, or no longer */
    }
    if (state == DG_CO_STOPPED) {
        dg_co_sdo_start(self); /* a transfer does not survive */
    }
    if (!booted) {
        heartbeat(self);
    } else { /* the boot-up was the first one */
        start_period(self);
    }
    if (was_operational || state == DG_CO_OPERATIONAL) {
        dg_co_pdo_state(self, state == DG_CO_OPERATIONAL);
    }
}

static void to_operational(struct dg_co_node *self)
{
    dg_co_enter(self, DG_CO_OPERATIONAL);
}

static void to_stopped(struct dg_co_node *self)
{
    dg_co_enter(self, DG_CO_STOPPED);
}

static void to_pre_operational(struct dg_co_node *self)
{
    dg_co_enter(self, DG_CO_PRE_OPERATIONAL);
}

static void reset_node(struct dg_co_node *self)
{
    dg_co_reset(self, true);
}

static void reset_communication(struct dg_co_node *self)
{
    dg_co_reset(self, false);
}

void dg_co_nmt_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    static const struct {
        uint8_t command;
        void (*act)(struct dg_co_node *self);
    } commands[] = {
        {0x01, to_operational}, {0x02, to_stopped},          {0x80, to_pre_operational},
        {0x81, reset_node},     {0x82, reset_communication},
    };

    if (frame->dlc != 2) {
        self->counters.malformed++;
        return;
    }
    if (frame->data[1] != 0 && frame->data[1] != self->id) {
        return;
    }
    for (uint8_t i = 0; i < DG_COUNT(commands); i++) {
        if (commands[i].command == frame->data[0]) {
            commands[i].act(self);
            return;
        }
    }
}

void dg_co_nmt_start(struct dg_co_node *self)
{
    self->heartbeat_at = DG_NEVER;
    self->guard_toggle = false;
    self->guard_at = DG_NEVER;
    for (uint8_t i = 0; i < DG_CO_CONSUMERS; i++) {
        self->consumer_at[i] = DG_NEVER;
    }
}

/* Life time runs from the first request of the master on (C13). */
void dg_co_guard_rx(struct dg_co_node *self)
{
    uint32_t life_ms = self->value[CO_GUARD_TIME_MS] * self->value[CO_LIFE_FACTOR];

    if (heartbeat_ms(self) != 0) {
        return;
    }
    const uint8_t answer[1] = {
        (uint8_t)((unsigned)self->state | (self->guard_toggle ? 0x80u : 0u))};
    self->guard_toggle = !self->guard_toggle;
    dg_co_send(self, (uint16_t)(CO_ID_GUARD + self->id), answer, sizeof answer);
    self->others = 0;
    self->guard_at = dg_co_after_ms(self->now, life_ms);
    dg_co_clear(self, DG_CO_CAUSE_LIFE);
}

static uint8_t consumed_node(uint32_t entry)
{
    return (uint8_t)(entry >> 16);
}

static bool consumer_active(uint32_t entry)
{
    return consumed_node(entry) != 0 && (entry & 0xFFFFu) != 0;
}

/* A state in one byte. Neither a boot-up, nor an answer to guarding (bit 7), nor a frame without
 * data says that the node's heartbeat is on (C32). */
static bool is_heartbeat(const struct dg_can_frame *frame)
{
    uint8_t state = frame->data[0];

    return frame->dlc == 1 &&
           (state == DG_CO_STOPPED || state == DG_CO_OPERATIONAL || state == DG_CO_PRE_OPERATIONAL);
}

/* Monitoring begins with the first heartbeat of the node (C12). */
void dg_co_heartbeat_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    if (!is_heartbeat(frame)) {
        return;
    }
    for (uint8_t i = 0; i < DG_CO_CONSUMERS; i++) {
        uint32_t entry = self->value[CO_CONSUMER_1 + i];
        if (consumer_active(entry) && frame->id == CO_ID_GUARD + consumed_node(entry)) {
            self->others = 0;
            self->consumer_at[i] = dg_co_after_ms(self->now, entry & 0xFFFFu);
            dg_co_clear(self, (uint8_t)(DG_CO_CAUSE_HEARTBEAT + i));
        }
    }
}

dg_ns dg_co_nmt_step(struct dg_co_node *self)
{
    if (self->heartbeat_at <= self->now) {
        dg_ns due = self->heartbeat_at;
        heartbeat(self);
        /* Keep the phase unless whole periods were missed. */
        dg_ns next = dg_co_after_ms(due, heartbeat_ms(self));
        self->heartbeat_at = next > self->now ? next : self->heartbeat_at;
    }
    if (self->guard_at <= self->now) {
        self->guard_at = DG_NEVER;
        dg_co_raise(self, DG_CO_CAUSE_LIFE, no_details);
    }
    dg_ns next = dg_earliest(self->heartbeat_at, self->guard_at);
    for (uint8_t i = 0; i < DG_CO_CONSUMERS; i++) {
        if (self->consumer_at[i] <= self->now) {
            self->consumer_at[i] = DG_NEVER;
            dg_co_raise(self, (uint8_t)(DG_CO_CAUSE_HEARTBEAT + i), no_details);
        }
        next = dg_earliest(next, self->consumer_at[i]);
    }
    return next;
}

/* What is written to 100Ch, 100Dh and 1017h ends life guarding until the master's next request, and
 * what it has found (C13). */
enum dg_co_abort dg_co_hook_heartbeat(struct dg_co_node *self, const struct dg_co_object *object,
                                      enum dg_co_op op, uint32_t *value)
{
    (void)value;
    if (op != DG_CO_WRITTEN) {
        return DG_CO_OK;
    }
    move_deadline(self, &self->guard_at, DG_NEVER);
    if ((self->active_causes >> DG_CO_CAUSE_LIFE & 1u) != 0) { /* seldom: saves the call */
        dg_co_clear(self, DG_CO_CAUSE_LIFE);
    }
    if (object->slot == CO_HEARTBEAT_MS) {
        heartbeat(self);
    }
    return DG_CO_OK;
}

/* An active entry is not changed without having been cleared (C12); written again as it is, it
 * waits for a heartbeat anew. */
enum dg_co_abort dg_co_hook_consumer(struct dg_co_node *self, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    uint8_t mine = (uint8_t)(object->sub - 1u);
    uint32_t present = self->value[CO_CONSUMER_1 + mine];
    uint32_t other = self->value[CO_CONSUMER_1 + (mine ^ 1u)];

    if (op == DG_CO_WRITTEN) {
        move_deadline(self, &self->consumer_at[mine], DG_NEVER);
        dg_co_clear(self, (uint8_t)(DG_CO_CAUSE_HEARTBEAT + mine));
    }
    if (op != DG_CO_WRITE) {
        return DG_CO_OK;
    }
    if (*value >> 23 != 0) {
        return DG_CO_RANGE;
    }
    if (!consumer_active(*value)) {
        return DG_CO_OK;
    }
    bool taken = (consumer_active(other) && consumed_node(other) == consumed_node(*value)) ||
                 consumed_node(*value) == self->id;
    bool changes = consumer_active(present) && *value != present;
    return taken || changes ? DG_CO_INCOMPATIBLE : DG_CO_OK;
}
