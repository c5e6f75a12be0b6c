/* SPDX-License-Identifier: MIT */
#include "control_rig.h"
#include "drehgeber/biss.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/instruments.h"
#include "drehgeber/interbus.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static struct control_rig *rig_of(struct dg_rig *rig)
{
    return rig->host;
}

static void changed(struct dg_rig *rig, struct dg_encoder *encoder, dg_ns now)
{
    struct control_rig *self = rig_of(rig);

    assert_int_equal(now, self->now);
    self->changes++;
    self->changed = encoder;
}

static const char *wire(struct dg_rig *rig, const struct dg_encoder *encoder)
{
    (void)rig;
    return encoder->host;
}

static void counters(struct dg_rig *rig, const struct dg_encoder *encoder, struct dg_scpi *to)
{
    (void)rig;
    dg_scpi_begin(to);
    dg_scpi_append(to, "wire=");
    dg_scpi_append(to, encoder->host);
}

static int asked(struct control_rig *self, const char *call, const void *whom, const char *text,
                 char *detail)
{
    self->call = call;
    self->whom = whom;
    (void)snprintf(self->text, sizeof self->text, "%s", text == NULL ? "NULL" : text);
    if (self->result != 0) {
        (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "as %s says", call);
    }
    return self->result;
}

static int profile(struct dg_rig *rig, struct dg_rig_shaft *shaft, dg_ns now, const char *text,
                   char *detail)
{
    (void)now;
    return asked(rig_of(rig), "profile", shaft, text, detail);
}

static const char *profile_text(struct dg_rig *rig, const struct dg_rig_shaft *shaft)
{
    (void)shaft;
    return rig_of(rig)->text;
}

static int record(struct dg_rig *rig, struct dg_rig_shaft *shaft, dg_ns now, const char *path,
                  dg_ns interval, char *detail)
{
    (void)now;
    rig_of(rig)->number[0] = (int64_t)interval;
    return asked(rig_of(rig), "record", shaft, path, detail);
}

static int trace(struct dg_rig *rig, struct dg_encoder *encoder, const char *path, char *detail)
{
    return asked(rig_of(rig), "trace", encoder, path, detail);
}

static bool last(struct dg_rig *rig, const struct dg_encoder *encoder, unsigned back,
                 struct dg_rig_line *line)
{
    (void)encoder;
    line->severity = (enum dg_severity)(back % DG_SEVERITY_COUNT);
    (void)snprintf(line->text, sizeof line->text, "line %u", back);
    return back < rig_of(rig)->lines;
}

static int set_scale(struct dg_rig *rig, uint32_t permille, char *detail)
{
    rig_of(rig)->number[0] = permille;
    return asked(rig_of(rig), "scale", NULL, NULL, detail);
}

static uint32_t scale(struct dg_rig *rig)
{
    return (uint32_t)rig_of(rig)->number[0];
}

static int step_time(struct dg_rig *rig, dg_ns span, char *detail)
{
    rig_of(rig)->number[0] = (int64_t)span;
    return asked(rig_of(rig), "step", NULL, NULL, detail);
}

static int course(struct dg_rig *rig, struct dg_encoder *encoder,
                  const struct dg_rig_course_wish *wish, dg_ns now, char *detail)
{
    struct control_rig *self = rig_of(rig);
    struct control_rig_course *to = &self->courses[encoder - self->encoder][wish->quantity];
    const struct dg_quantity *row = &dg_quantities[wish->quantity];
    const struct dg_course_point file[] = {{0, row->min}, {DG_S(1), row->max}};
    const bool points = wish->path == NULL;

    if (asked(self, "course", encoder, wish->path, detail) != 0) {
        return self->result;
    }
    dg_rig_unfollow(rig, encoder, wish->quantity);
    to->course = (struct dg_rig_course){.quantity = wish->quantity,
                                        .course = {.points = to->points,
                                                   .count = points ? wish->count : DG_COUNT(file),
                                                   .loop = wish->loop,
                                                   .steps = wish->steps}};
    memcpy(to->points, points ? wish->points : file, to->course.course.count * sizeof *file);
    assert_int_equal(dg_rig_follow(rig, encoder, &to->course, now), DG_OK);
    return 0;
}

static const char *course_text(struct dg_rig *rig, const struct dg_encoder *encoder,
                               size_t quantity)
{
    assert_non_null(dg_rig_course_of(encoder, quantity));
    return rig_of(rig)->text;
}

static int biss_frame(void *ctx, uint64_t *bits, uint8_t *count, char *detail)
{
    struct control_rig *self = ctx;

    *bits = self->frame;
    *count = self->frame_bits;
    return asked(self, "frame", &self->encoder[CONTROL_RIG_BISS], NULL, detail);
}

static int biss_read(void *ctx, uint8_t address, uint8_t *bytes, size_t n, char *detail)
{
    struct control_rig *self = ctx;

    self->number[0] = address;
    self->number[1] = (int64_t)n;
    memcpy(bytes, self->bytes, n);
    return asked(self, "read", &self->encoder[CONTROL_RIG_BISS], NULL, detail);
}

static int biss_write(void *ctx, uint8_t address, const uint8_t *bytes, size_t n, char *detail)
{
    struct control_rig *self = ctx;

    self->number[0] = address;
    self->number[1] = (int64_t)n;
    memcpy(self->bytes, bytes, n);
    return asked(self, "write", &self->encoder[CONTROL_RIG_BISS], NULL, detail);
}

static const struct dg_biss_port_ops biss_port = {
    .frame = biss_frame,
    .read = biss_read,
    .write = biss_write,
};

static const struct dg_rig_ops all = {
    .changed = changed,
    .wire = wire,
    .counters = counters,
    .profile = profile,
    .profile_text = profile_text,
    .record = record,
    .trace = trace,
    .last = last,
    .set_scale = set_scale,
    .scale = scale,
    .step = step_time,
    .course = course,
    .course_text = course_text,
};

static void take_answer(void *ctx, const char *bytes, size_t n)
{
    struct control_rig *self = ctx;

    assert_true(self->length + n < sizeof self->answer);
    memcpy(&self->answer[self->length], bytes, n);
    self->length += n;
    self->answer[self->length] = '\0';
}

static void start_devices(struct control_rig *self)
{
    assert_int_equal(hf_rig_init(&self->hf, dg_hf_model_of(dg_device_find("s3684-rs485"))), DG_OK);
    assert_int_equal(biss_rig_init(&self->biss, dg_biss_model_of(dg_device_find("s3684-biss")), 1),
                     DG_OK);
    co_rig_start(&self->co);
    assert_int_equal(ib_rig_init(&self->k3, dg_ib_model_of(dg_device_find("ocd-ib-k3"))), DG_OK);
    assert_int_equal(ib_rig_init(&self->k2, dg_ib_model_of(dg_device_find("ocd-ib-k2"))), DG_OK);
}

static void start_shafts(struct control_rig *self)
{
    static const char *const names[] = {"main", "geared"};

    for (size_t i = 0; i < DG_COUNT(self->shaft); i++) {
        self->shaft[i].name = names[i];
        dg_shaft_init(&self->shaft[i].shaft);
        self->shafts[i] = &self->shaft[i];
    }
    assert_int_equal(dg_shaft_couple(&self->shaft[1].shaft, &self->shaft[0].shaft, 1, 2), DG_OK);
}

static void start_encoders(struct control_rig *self)
{
    static char wires[][16] = {"pty:/dev/pts/4", "sim:", "can:vcan0/63", "modbus:a/0",
                               "modbus:a/1"};
    const struct {
        const char *name;
        const char *model;
        void *device;
        struct dg_world *world;
        struct dg_nvm nvm;
    } rows[CONTROL_RIG_ENCODERS] = {
        {"hf", "s3684-rs485", &self->hf.device, &self->hf.world, self->hf.device.setup.nvm},
        {"biss-1", "s3684-biss", &self->biss.slave[0], &self->biss.world,
         ram_nvm_port(&self->biss.nvm[0])},
        {"can", "f3668", &self->co.device, &self->co.world, ram_nvm_port(&self->co.nvm)},
        {"k3", "ocd-ib-k3", &self->k3.device, &self->k3.world, ram_nvm_port(&self->k3.nvm)},
        {"k2", "ocd-ib-k2", &self->k2.device, &self->k2.world, {NULL, NULL}},
    };

    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_encoder *encoder = &self->encoder[i];
        const struct dg_device *model = dg_device_find(rows[i].model);
        *encoder = (struct dg_encoder){
            .name = rows[i].name,
            .model = model,
            .instrument = dg_instrument_of(model->stack),
            .device = rows[i].device,
            .world = rows[i].world,
            .shaft = &self->shaft[i == CONTROL_RIG_K2],
            .nvm = rows[i].nvm,
            .serial = 1234567890u,
            .host = wires[i],
        };
        if (i == CONTROL_RIG_BISS) {
            encoder->port = &biss_port;
            encoder->port_ctx = self;
        }
        encoder->world->angle = dg_shaft_angle;
        encoder->world->angle_ctx = &encoder->shaft->shaft;
        self->encoders[i] = encoder;
        assert_int_equal(dg_encoder_power(encoder, self->now, true), DG_OK);
    }
}

void control_rig_start(struct control_rig *self)
{
    memset(self, 0, sizeof *self);
    self->now = DG_S(1);
    start_devices(self);
    start_shafts(self);
    start_encoders(self);
    self->ops = all;
    self->rig = (struct dg_rig){
        .encoders = self->encoders,
        .encoder_count = CONTROL_RIG_ENCODERS,
        .shafts = self->shafts,
        .shaft_count = DG_COUNT(self->shafts),
        .instruments = dg_instruments,
        .courses = &dg_course_commands,
        .instrument_count = dg_instrument_count,
        .ops = &self->ops,
        .host = self,
    };
    dg_control_init(&self->control, &self->rig, take_answer, self);
}

const char *control_rig_say(struct control_rig *self, const char *line)
{
    self->length = 0;
    self->answer[0] = '\0';
    assert_int_equal(dg_control_rx(&self->control, self->now, line, strlen(line)), strlen(line));
    assert_int_equal(dg_control_rx(&self->control, self->now, "\n", 1), 1);
    if (self->length > 0 && self->answer[self->length - 1u] == '\n') {
        self->answer[--self->length] = '\0';
    }
    return self->answer;
}

void control_rig_expect(struct control_rig *self, const char *line, const char *answer)
{
    const char *seen = control_rig_say(self, line);

    if (strcmp(seen, answer) != 0) {
        fail_msg("%s: %s, not %s", line, seen, answer);
    }
    seen = control_rig_say(self, "SYST:ERR?");
    if (strncmp(seen, "0,", 2) != 0) {
        fail_msg("%s: %s", line, seen);
    }
}

void control_rig_refuse(struct control_rig *self, const char *line, const char *error,
                        const char *text)
{
    const char *seen = control_rig_say(self, line);

    if (seen[0] != '\0') {
        fail_msg("%s: %s, not %s", line, seen, error);
    }
    seen = control_rig_say(self, "SYST:ERR?");
    if (strncmp(seen, error, strlen(error)) != 0 || seen[strlen(error)] != ',' ||
        (text != NULL && strstr(seen, text) == NULL)) {
        fail_msg("%s: %s, not %s", line, seen, error);
    }
    seen = control_rig_say(self, "SYST:ERR?");
    if (strncmp(seen, "0,", 2) != 0) {
        fail_msg("%s: also %s", line, seen);
    }
}
