/* SPDX-License-Identifier: MIT */
/*
 * The rig's EEPROM is a struct ram_nvm behind a counter of accesses, so that any one of them, not
 * only writes, can be made to fail.
 */
#include "hf_rig.h"

#include <string.h>

#define CHARACTER_BITS 11u
#define RUN_STEPS_MAX 100

static dg_angle shaft_angle(void *ctx, dg_ns now)
{
    const struct hf_rig *self = ctx;

    /* Whole milliseconds and the rest apart, modulo 2^64: nothing overflows. */
    const uint64_t whole = (uint64_t)self->angle_per_ms * (now / 1000000u);
    const int64_t rest = self->angle_per_ms * (int64_t)(now % 1000000u) / 1000000;
    return (dg_angle)((uint64_t)self->angle + whole + (uint64_t)rest);
}

static void capture(void *ctx, const uint8_t *bytes, size_t n)
{
    struct hf_rig *self = ctx;

    self->replies++;
    self->reply_at = self->now;
    self->reply_length = n;
    memcpy(self->reply, bytes, n < sizeof self->reply ? n : sizeof self->reply);
}

static bool fails(struct hf_rig *self)
{
    uint32_t access = self->accesses++;

    return access >= self->fail_from && access - self->fail_from < self->fail_count;
}

static int rig_read(void *ctx, uint32_t address, void *to, size_t n)
{
    struct hf_rig *self = ctx;
    struct dg_nvm ram = ram_nvm_port(&self->nvm);

    return fails(self) ? DG_ERR_IO : ram.ops->read(ram.ctx, address, to, n);
}

static int rig_write(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct hf_rig *self = ctx;
    struct dg_nvm ram = ram_nvm_port(&self->nvm);

    if (self->write_count < HF_RIG_WRITES_MAX) {
        self->write_size[self->write_count] = (uint16_t)n;
    }
    self->write_count++;
    return fails(self) ? DG_ERR_IO : ram.ops->write(ram.ctx, address, from, n);
}

static int rig_sync(void *ctx)
{
    struct hf_rig *self = ctx;
    struct dg_nvm ram = ram_nvm_port(&self->nvm);

    return fails(self) ? DG_ERR_IO : ram.ops->sync(ram.ctx);
}

struct dg_hf_setup hf_rig_setup(struct hf_rig *self, const struct dg_hf_model *model)
{
    static const struct dg_hf_ops line = {.tx = capture};
    static const struct dg_nvm_ops memory = {
        .read = rig_read, .write = rig_write, .sync = rig_sync};

    return (struct dg_hf_setup){.model = model,
                                .world = &self->world,
                                .nvm = {.ops = &memory, .ctx = self},
                                .ops = &line,
                                .ctx = self};
}

int hf_rig_init(struct hf_rig *self, const struct dg_hf_model *model)
{
    memset(self, 0, sizeof *self);
    dg_world_init(&self->world);
    self->world.angle = shaft_angle;
    self->world.angle_ctx = self;
    ram_nvm_init(&self->nvm, dg_store_size(dg_hf_stack.layout(model)));
    struct dg_hf_setup setup = hf_rig_setup(self, model);
    int result = dg_hf_format(model, setup.nvm);

    return result == DG_OK ? dg_hf_init(&self->device, &setup) : result;
}

void hf_rig_run(struct hf_rig *self)
{
    dg_ns deadline = dg_hf_step(&self->device, self->now);

    for (int i = 0; i < RUN_STEPS_MAX; i++) {
        bool busy = self->device.line != DG_HF_IDLE && self->device.line != DG_HF_OFF;
        if (!busy || deadline == DG_NEVER) {
            break;
        }
        self->now = deadline > self->now ? deadline : self->now;
        deadline = dg_hf_step(&self->device, self->now);
    }
}

int hf_rig_power_on(struct hf_rig *self)
{
    int result = dg_hf_power_on(&self->device, self->now);

    if (result == DG_OK) {
        dg_ns end = dg_hf_step(&self->device, self->now);
        self->now = end == DG_NEVER ? self->now : end;
        (void)dg_hf_step(&self->device, self->now);
    }
    return result;
}

size_t hf_rig_send(struct hf_rig *self, const uint8_t *bytes, size_t n)
{
    dg_ns character = dg_bit_times_ns(CHARACTER_BITS, dg_hf_uart(&self->device).baud);
    unsigned before = self->replies;

    self->reply_length = 0;
    for (size_t i = 0; i < n; i++) {
        self->now += character;
        (void)dg_hf_rx(&self->device, self->now, bytes[i], DG_HF_RX_OK);
    }
    hf_rig_run(self);
    if (self->replies == before) {
        return 0;
    }
    self->now += character * self->reply_length;
    return self->reply_length;
}

uint8_t hf_rig_xor(const uint8_t *bytes, size_t n)
{
    uint8_t sum = 0;

    for (size_t i = 0; i < n; i++) {
        sum = (uint8_t)(sum ^ bytes[i]);
    }
    return sum;
}

int hf_rig_ask_bytes(struct hf_rig *self, const uint8_t *command, size_t n)
{
    uint8_t frame[DG_HF_FRAME_MAX + 1u];

    if (n == 0 || n > sizeof frame - 2u) {
        return HF_RIG_SILENCE;
    }
    frame[0] = self->device.address;
    memcpy(&frame[1], command, n);
    frame[n + 1u] = hf_rig_xor(frame, n + 1u);
    size_t length = hf_rig_send(self, frame, n + 2u);
    if (length == 0) {
        return HF_RIG_SILENCE;
    }
    bool error = (self->reply[1] & 0x7Fu) == 0x50u && command[0] != 0x50u;
    return error ? self->reply[2] : 0;
}

static int digit(char c)
{
    static const char digits[] = "0123456789ABCDEF";
    const char *at = c == '\0' ? NULL : strchr(digits, c);

    return at == NULL ? -1 : (int)(at - digits);
}

size_t hf_rig_hex(const char *text, uint8_t *bytes, size_t capacity)
{
    size_t n = 0;

    while (n < capacity) {
        while (*text == ' ') {
            text++;
        }
        int high = digit(text[0]);
        int low = high < 0 ? -1 : digit(text[1]);
        if (low < 0) {
            break;
        }
        bytes[n++] = (uint8_t)(high * 16 + low);
        text += 2;
    }
    return n;
}

int hf_rig_ask(struct hf_rig *self, const char *command)
{
    uint8_t bytes[DG_HF_FRAME_MAX];

    return hf_rig_ask_bytes(self, bytes, hf_rig_hex(command, bytes, sizeof bytes));
}
