/* SPDX-License-Identifier: MIT */
/*
 * The line: characters and silence become frames, frames become replies (5.1.1.1, R1, R6b,
 * R13-R16).
 *
 *   IDLE --own address--> COLLECT --silence--> REPLY --reaction time--> IDLE
 *     \----anything else--> SKIP --silence--> IDLE
 *                          53h: COLLECT --silence--> DEAF --init--> IDLE
 */
#include "hiperface_private.h"

#define CHARACTER_BITS 11u
#define BAUD_MASK 0x07u
#define LONG_TIMEOUT 0x40u
#define REACTION_LEAST_MS 5u

int dg_hf_uart_decode(uint8_t setting, struct dg_hf_uart *out)
{
    static const uint16_t bauds[] = {600, 1200, 2400, 4800, 9600, 19200, 38400};
    static const char parities[] = {'N', 0, 'E', 'O'};
    uint8_t baud = setting & BAUD_MASK;
    char parity = parities[(setting >> 4) & 3u];

    if (baud >= DG_COUNT(bauds) || parity == 0) {
        return DG_ERR_ARGUMENT;
    }
    out->baud = bauds[baud];
    out->parity = parity;
    out->timeout_bits = (setting & LONG_TIMEOUT) != 0 ? 44 : 11;
    return DG_OK;
}

struct dg_hf_uart dg_hf_uart(const struct dg_hf *self)
{
    struct dg_hf_uart uart = {.baud = 9600, .parity = 'E', .timeout_bits = 44};

    /* What is in force has been decoded before; a refusal would leave the delivery setting. */
    (void)dg_hf_uart_decode(self->uart, &uart);
    return uart;
}

static void use_uart(struct dg_hf *self, uint8_t uart)
{
    self->uart = uart;
    const struct dg_hf_uart plain = dg_hf_uart(self);
    self->silence_ns = (uint32_t)dg_bit_times_ns(plain.timeout_bits, plain.baud);
}

/* Silence after a character that ends a frame; after a start bit its character is still to come. */
static dg_ns hf_timeout_ns(const struct dg_hf *self, bool start_bit)
{
    if (!start_bit) {
        return self->silence_ns;
    }
    const struct dg_hf_uart uart = dg_hf_uart(self);
    return dg_bit_times_ns(uart.timeout_bits + CHARACTER_BITS, uart.baud);
}

static void enter_line_state(struct dg_hf *self, enum dg_hf_line_state line, dg_ns deadline)
{
    self->line = line;
    self->deadline = deadline;
}

/* The start common to power-on and 53h: everything but the UART setting begins anew. */
static int start_channel(struct dg_hf *self)
{
    int result = DG_ERR_IO;

    self->stack_count = 0;
    self->locks = 0;
    self->monitors = 0;
    if (self->setup.world->eeprom_acknowledges) {
        result = dg_hf_mount(&self->store, self->setup.model, self->setup.nvm);
    }
    dg_hf_load(self, result == DG_OK);
    if (result == DG_OK && self->store.failures > 0) {
        result = DG_ERR_IO; /* mounted, then silent: no mixture of memory and model */
        dg_hf_load(self, false);
    }
    if (result == DG_OK) {
        dg_hf_start_up_checks(self);
    } else {
        self->locks = HF_LOCK_POSITION | HF_LOCK_EEPROM;
        dg_hf_push(self, DG_HF_I2C);
    }
    return result;
}

int dg_hf_init(struct dg_hf *self, const struct dg_hf_setup *setup)
{
    if (setup->model == NULL || setup->world == NULL || setup->world->angle == NULL ||
        setup->nvm.ops == NULL || setup->ops == NULL || setup->ops->tx == NULL) {
        return DG_ERR_ARGUMENT;
    }
    if (dg_hf_model_check(setup->model) != DG_OK) {
        return DG_ERR_ARGUMENT;
    }
    *self = (struct dg_hf){.setup = *setup, .deadline = DG_NEVER, .window_end = DG_NEVER};
    return DG_OK;
}

int dg_hf_power_on(struct dg_hf *self, dg_ns now)
{
    dg_hf_power_off(self);
    int result = start_channel(self);
    if (result == DG_ERR_BLANK || result == DG_ERR_FOREIGN) {
        return result;
    }
    use_uart(self, DG_HF_UART_DEFAULT);
    self->uart_next = self->uart_stored;
    self->window_end = dg_after(now, self->setup.model->init);
    self->last_rx = now;
    enter_line_state(self, DG_HF_IDLE, DG_NEVER);
    return DG_OK;
}

void dg_hf_power_off(struct dg_hf *self)
{
    self->window_end = DG_NEVER;
    enter_line_state(self, DG_HF_OFF, DG_NEVER);
}

/* 53h: deaf for the initialisation time, then the setting that 57h left, if it left one. */
static void reset_line(struct dg_hf *self, dg_ns moment)
{
    uint8_t uart = self->uart_next;

    (void)start_channel(self);
    use_uart(self, uart);
    self->uart_next = uart;
    enter_line_state(self, DG_HF_DEAF, dg_after(moment, self->setup.model->init));
}

/* The line was silent for the timeout. In the start-up window an intact frame is communication,
 * whoever it was for and whatever was in it: the setting in force stays (R27). */
static void notice_silence(struct dg_hf *self)
{
    bool intact = !self->frame_damaged && self->length >= HF_FRAME_LEAST && self->sum == 0;

    if (intact && self->window_end != DG_NEVER) {
        self->window_end = DG_NEVER;
        self->uart_next = self->uart;
    }
}

/* The line was silent for the timeout, at `moment`: the frame in the buffer is complete. */
static void end_of_frame(struct dg_hf *self, dg_ns moment)
{
    dg_ns reaction = self->setup.model->reaction;

    dg_hf_check_frame(self);
    const struct hf_command *row =
        self->command < dg_hf_command_count ? &dg_hf_commands[self->command] : NULL;
    self->counters.frames++;
    notice_silence(self);
    if (self->verdict == DG_HF_NO_ERROR && row != NULL && row->handler == NULL) {
        reset_line(self, moment);
        return;
    }
    /* What is no command has the shortest maximum that a command has. */
    uint8_t most_ms = row != NULL && row->handler != NULL ? row->reaction_ms : REACTION_LEAST_MS;
    reaction = dg_earliest(reaction, DG_MS(most_ms));
    enter_line_state(self, DG_HF_REPLY, dg_after(moment, reaction));
}

/* What came in before the reply was out is no frame: wait until that is over, too. */
static void after_reply(struct dg_hf *self, dg_ns now)
{
    dg_ns silent = dg_after(self->last_rx, hf_timeout_ns(self, false));

    if (silent > now) {
        self->frame_damaged = true;
        enter_line_state(self, DG_HF_SKIP, silent);
    } else {
        enter_line_state(self, DG_HF_IDLE, DG_NEVER);
    }
}

/* The start-up window does not close in the middle of a frame for this device, nor of one for
 * another as long as it may be one. */
static dg_ns window_deadline(const struct dg_hf *self)
{
    bool noise = self->frame_damaged || self->length > DG_HF_FRAME_MAX;

    return self->line == DG_HF_IDLE || (self->line == DG_HF_SKIP && noise) ? self->window_end
                                                                           : DG_NEVER;
}

static inline dg_ns next_deadline(const struct dg_hf *self)
{
    return self->window_end == DG_NEVER ? self->deadline
                                        : dg_earliest(self->deadline, window_deadline(self));
}

static void act_on_state(struct dg_hf *self, dg_ns now)
{
    dg_ns moment = self->deadline;

    if (self->window_end != DG_NEVER && window_deadline(self) <= moment) {
        self->window_end = DG_NEVER;
        use_uart(self, self->uart_next);
        return;
    }
    switch (self->line) {
    case DG_HF_COLLECT:
        end_of_frame(self, moment);
        break;
    case DG_HF_REPLY:
        dg_hf_answer(self, now);
        after_reply(self, now);
        break;
    case DG_HF_SKIP:
        notice_silence(self);
        enter_line_state(self, DG_HF_IDLE, DG_NEVER);
        break;
    case DG_HF_DEAF:
        enter_line_state(self, DG_HF_IDLE, DG_NEVER);
        break;
    case DG_HF_OFF:
    case DG_HF_IDLE:
        break;
    }
}

dg_ns dg_hf_step(struct dg_hf *self, dg_ns now)
{
    dg_ns next = next_deadline(self);

    while (next <= now && next != DG_NEVER) {
        act_on_state(self, now);
        next = next_deadline(self);
    }
    if (self->line != DG_HF_OFF && self->line != DG_HF_DEAF) {
        dg_hf_monitor(self);
    }
    return next;
}

/* The first character after a silence is an address (5.1.1.1). */
static void first_character(struct dg_hf *self, uint8_t byte, bool damaged)
{
    bool mine = byte == self->address || byte == DG_HF_ADDRESS_BROADCAST;

    self->frame[0] = byte;
    self->sum = byte;
    self->length = 1;
    self->frame_damaged = damaged;
    if (damaged || !mine) {
        self->counters.others++;
        self->line = DG_HF_SKIP;
    } else {
        self->line = DG_HF_COLLECT;
    }
}

static void next_character(struct dg_hf *self, uint8_t byte, bool damaged)
{
    if (self->length < DG_HF_FRAME_MAX) {
        self->frame[self->length++] = byte;
    } else {
        self->length = DG_HF_FRAME_MAX + 1u; /* says "too long", however long (R14) */
    }
    self->sum ^= byte;
    self->frame_damaged |= damaged;
}

dg_ns dg_hf_rx(struct dg_hf *self, dg_ns now, uint8_t byte, uint8_t flags)
{
    bool damaged = (flags & DG_HF_RX_DAMAGED) != 0;
    bool start_bit = (flags & DG_HF_RX_START) != 0;

    now = now > self->last_rx ? now : self->last_rx; /* earlier: no time has passed (time.h) */
    if (next_deadline(self) < now) {
        (void)dg_hf_step(self, now);
    }
    if (start_bit && self->line != DG_HF_COLLECT && self->line != DG_HF_SKIP) {
        return next_deadline(self);
    }
    self->counters.damaged += damaged && !start_bit;
    switch (self->line) {
    case DG_HF_OFF:
        return DG_NEVER;
    case DG_HF_DEAF:
        self->counters.deaf++;
        return next_deadline(self);
    case DG_HF_REPLY:
        self->counters.interrupted++;
        self->last_rx = now;
        return next_deadline(self);
    case DG_HF_IDLE:
        first_character(self, byte, damaged);
        break;
    case DG_HF_COLLECT:
    case DG_HF_SKIP:
        if (!start_bit) {
            next_character(self, byte, damaged);
        }
        break;
    }
    self->last_rx = now;
    self->deadline = dg_after(now, hf_timeout_ns(self, start_bit));
    return next_deadline(self);
}
