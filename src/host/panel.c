/* SPDX-License-Identifier: MIT */
/*
 * The control plane of one encoder: a rig of one instrument and one shaft, with one session. Faults
 * of the wire happen to events on their way into and out of the queues, and to the levels of a
 * clocked line, as they do on a bus of this one encoder; on a bus they are the bus's.
 */
#include <string.h>

#include "drehgeber/control.h"
#include "drehgeber/line_fault.h"
#include "drehgeber/tap.h"
#include "drehgeber/wire_fault.h"
#include "host_private.h"

struct dg_host_panel {
    struct dg_host *host;
    struct dg_encoder encoder;
    struct dg_rig_shaft shaft;
    struct dg_encoder *encoders[1];
    struct dg_rig_shaft *shafts[1];
    const struct dg_instrument *instruments[1];
    struct dg_rig rig;
    struct dg_control control;
    char *answer; /* of the call at hand */
    size_t size;
    size_t used;
    bool cut;
    bool deaf;    /* characters: inside a request that does not reach the encoder */
    dg_ns heard;  /* characters: the end of the latest one; 0: a reply has come since */
    dg_ns late;   /* frames: when the latest one arrives that a fault has made late */
    uint8_t dead; /* INTERBUS: cycles without data to come */
    uint8_t cycle[sizeof((struct dg_host_event *)0)->data]; /* INTERBUS: IN of the latest one */
    struct dg_line_fault line;
    dg_ns latched; /* the frame that `line` is about */
    dg_ns fell;    /* the latest falling edge of the clock */
    bool clock;    /* its level */
    bool bent;     /* CAN: a fault has made the controller worse than it is by itself */
};
_Static_assert(_Alignof(struct dg_host_panel) <= DG_HOST_ALIGN, "what host.h asks for is enough");

/* ------------------------------------------------------------ faults: what the encoder sends */

/* The first half of IN is that of the cycle before: the high word, of a K1 the high byte. IN is
 * told twice: its bytes, and as a number. */
static void tear_cycle(struct dg_host_panel *self, struct dg_host_event *event)
{
    uint8_t whole[sizeof self->cycle];

    if ((event->flags & DG_HOST_IDENTIFY) != 0) {
        return;
    }
    memcpy(whole, event->data, sizeof whole);
    if (dg_fault_wire_takes(&self->encoder.faults, DG_WIRE_TEAR)) {
        memcpy(event->data, self->cycle, event->length / 2u);
        event->id = 0;
        for (uint8_t i = 0; i < event->length; i++) {
            event->id = event->id << 8 | event->data[i];
        }
    }
    memcpy(self->cycle, whole, sizeof whole);
}

/* Frames keep their order: what is sent while another one is late waits behind it. A state that was
 * restored may have led back in time. */
static dg_ns find_arrival(const struct dg_host_panel *self, dg_ns at)
{
    const dg_ns most = (dg_ns)dg_fault_wire_value(self->encoder.instrument, DG_WIRE_DELAY);
    const dg_ns late = dg_earliest(self->late, dg_after(self->host->line.now, most));

    return late > at ? late : at;
}

/* Edges are bent as levels, below, and a cycle that is lost does not begin. On a bus the bus bends
 * what is said. */
static unsigned arrives(void *ctx, struct dg_host_event *event)
{
    struct dg_host_panel *self = ctx;

    if (event->kind == DG_HOST_WORDS && !self->host->line.on_bus) {
        tear_cycle(self, event);
    }
    if (event->kind != DG_HOST_CAN || self->host->line.on_bus) {
        return 1;
    }
    const struct dg_wire_sent sent = dg_wire_fault_send(&self->encoder, event->length);
    if (sent.damaged < event->length) {
        event->data[sent.damaged] ^= sent.flip;
    }
    if (sent.times > 0 && (sent.delay > 0 || event->at < self->late)) {
        event->at = find_arrival(self, dg_after(event->at, sent.delay));
        self->late = event->at;
    }
    return sent.times;
}

/* One that does not arrive takes no time: the encoder hears what comes next. */
static void say_reply(void *ctx, const uint8_t *bytes, size_t n)
{
    struct dg_host_panel *self = ctx;
    struct dg_host *host = self->host;
    uint8_t bent[DG_REPLY_MAX];
    const size_t length = n < sizeof bent ? n : sizeof bent;

    if (host->line.on_bus) {
        dg_host_say_reply(host, bytes, n);
        return;
    }
    memcpy(bent, bytes, length);
    const struct dg_wire_sent sent = dg_wire_fault_send(&self->encoder, length);
    if (sent.damaged < length) {
        bent[sent.damaged] ^= sent.flip;
    }
    host->line.until = dg_after(host->line.now, sent.delay);
    for (unsigned left = sent.times; left > 0; left--) {
        dg_host_say_reply(host, bent, length);
    }
    self->heard = 0;
}

/* ------------------------------------------------------------ faults: what it hears */

/* A request is heard as a whole or not at all: its first character decides, if it is for the
 * encoder. While its own reply is on the line it hears nothing anyway. */
static bool hears_characters(struct dg_host_panel *self, const struct dg_host_event *event)
{
    const struct dg_bus_side *side = self->host->refs.side;
    const struct dg_host_line *line = &self->host->line;
    struct dg_host_uart uart;

    if (event->length == 0 || dg_host_uart(self->host, &uart) != DG_HOST_OK) {
        self->deaf = self->deaf && dg_host_powered(self->host);
        return !self->deaf;
    }
    const dg_ns one = event->id != 0 ? event->id : dg_host_characters_ns(line, 1);
    const dg_ns end = dg_after(event->at, (event->flags & DG_HOST_ENDED) != 0 ? 0 : one);
    const dg_ns pause = dg_elapsed(end, self->heard);
    const bool begins = self->heard == 0 || pause > dg_bit_times_ns(uart.timeout_bits, uart.baud);
    self->heard = dg_after(end, (event->length - 1u) * one);
    if (begins && end >= line->until) {
        self->deaf = (side == NULL || side->wants == NULL || side->wants(line, event->data[0])) &&
                     dg_wire_fault_hear(&self->encoder) != DG_WIRE_HEARD;
    }
    return !self->deaf;
}

/* A controller has filters: what gets by them was neither lost nor kept from the encoder. */
static bool listens_to(const struct dg_host_panel *self, uint32_t id)
{
    const struct dg_bus_side *side = self->host->refs.side;
    uint16_t ids[DG_HOST_FILTERS];

    if (side == NULL) {
        return true;
    }
    uint8_t left = side->controller->listens(self->host->line.device, ids);

    while (left > 0 && ids[left - 1u] != id) {
        left--;
    }
    return left > 0;
}

/* A frame that a controller had to drop is an event to its node. */
static bool hears_frame(struct dg_host_panel *self, const struct dg_host_event *event)
{
    if (self->encoder.faults.wire == 0 || !listens_to(self, event->id)) {
        return true;
    }
    const enum dg_wire_heard heard = dg_wire_fault_hear(&self->encoder);
    if (heard == DG_WIRE_LOST) {
        dg_host_tell_controller(self->host, DG_HOST_BUS_OVERRUN);
    }
    return heard == DG_WIRE_HEARD;
}

/* No data comes back in a cycle that is lost or cut, nor in one with a transmission error and some
 * behind it. */
static bool hears_cycle(struct dg_host_panel *self, const struct dg_host_event *event)
{
    struct dg_faults *faults = &self->encoder.faults;
    const bool data = (event->flags & DG_HOST_IDENTIFY) == 0;

    if (!dg_host_powered(self->host)) {
        return true;
    }
    if (dg_fault_wire_takes(faults, DG_WIRE_DROP) || dg_fault_wire_active(faults, DG_WIRE_BREAK)) {
        return false;
    }
    if (data && self->dead > 0) {
        self->dead--;
        return false;
    }
    if (data && dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
        if (self->host->refs.side != NULL) {
            self->host->refs.side->ring->spoil(&self->host->line);
        }
        self->dead = DG_RING_DEAD_CYCLES;
        return false;
    }
    return true;
}

/* What the wire's controller says of itself is never better than what a fault has made of it. */
static void bend_controller(struct dg_host_panel *self, struct dg_host_event *event)
{
    if (event->id <= DG_HOST_BUS_OFF) {
        const enum dg_controller own = (enum dg_controller)event->id;
        const enum dg_controller bent = dg_fault_controller(&self->encoder.faults, own);
        self->bent = bent != own;
        event->id = (uint32_t)bent;
    }
}

/* Edges are bent as levels, below. */
static bool hears(void *ctx, struct dg_host_event *event)
{
    struct dg_host_panel *self = ctx;

    if (self->host->line.on_bus) {
        return true;
    }
    switch ((enum dg_host_kind)event->kind) {
    case DG_HOST_BYTES:
        return hears_characters(self, event);
    case DG_HOST_CAN:
        return hears_frame(self, event);
    case DG_HOST_BUS:
        bend_controller(self, event);
        return true;
    case DG_HOST_WORDS:
        return hears_cycle(self, event);
    case DG_HOST_EDGE:
        return true;
    }
    return true;
}

/* ------------------------------------------------------------ faults: levels */

/* The encoder may have taken an edge. A frame is latched by the one that it begins with; its period
 * is known at its rising edges only. */
static void follow_clock(struct dg_host_panel *self, bool raw)
{
    const struct dg_host_line *line = &self->host->line;
    const bool clock = self->encoder.instrument->clock(line->device);

    if (line->latched == line->now && line->latched != self->latched) {
        self->latched = line->latched;
        dg_line_fault_begin(&self->line);
    }
    if (clock && !self->clock) {
        dg_line_fault_advance(&self->line, raw, 2u * dg_elapsed(line->now, self->fell));
    }
    self->fell = !clock && self->clock ? line->now : self->fell;
    self->clock = clock;
}

/* An encoder that waits for nothing, which 0 just asks, has no frame on its line. */
static bool bent(void *ctx, bool raw)
{
    struct dg_host_panel *self = ctx;

    if (self->host->line.on_bus) {
        return raw;
    }
    follow_clock(self, raw);
    if (!dg_line_fault_due(&self->line)) {
        return raw;
    }
    if (self->host->refs.device->stack->step(self->host->line.device, 0) == DG_NEVER) {
        dg_line_fault_end(&self->line);
    }
    return dg_line_fault_level(&self->line, raw);
}

_Static_assert((int)DG_CONTROLLER_PASSIVE == (int)DG_HOST_BUS_PASSIVE, "the numbers are the same");
_Static_assert((int)DG_CONTROLLER_OFF == (int)DG_HOST_BUS_OFF, "the numbers are the same");

/* Whoever sets, ends or clears a fault comes by here; so does who switches power or bends the
 * world, as on a bus: a restart makes an encoder forget its controller. */
static void feel_controller(void *ctx)
{
    struct dg_host_panel *self = ctx;
    const enum dg_controller own = (enum dg_controller)self->host->controller;
    const enum dg_controller wanted = dg_fault_controller(&self->encoder.faults, own);

    if (wanted != own || self->bent) {
        dg_host_tell_controller(self->host, (uint32_t)wanted);
    }
    self->bent = wanted != own;
}

static void overridden(void *ctx, size_t offset)
{
    struct dg_host_panel *self = ctx;
    const struct dg_fault_target target = dg_encoder_target(&self->encoder);

    dg_fault_override(&self->encoder.faults, &target, offset);
    feel_controller(self);
}

static const struct host_faults faults_at_work = {
    .arrives = arrives,
    .reply = say_reply,
    .hears = hears,
    .bent = bent,
    .overridden = overridden,
    .feel = feel_controller,
};

/* ------------------------------------------------------------ the rig */

static void changed(struct dg_rig *rig, struct dg_encoder *encoder, dg_ns now)
{
    struct dg_host_panel *self = rig->host;

    (void)encoder;
    feel_controller(self);
    dg_host_run(self->host, now);
}

static const char *wire(struct dg_rig *rig, const struct dg_encoder *encoder)
{
    (void)rig;
    (void)encoder;
    return "host";
}

static const struct dg_rig_ops ops = {.changed = changed, .wire = wire};

static void collect(void *ctx, const char *bytes, size_t n)
{
    struct dg_host_panel *self = ctx;
    const size_t room = self->size - self->used;
    const size_t fits = n < room ? n : room;

    memcpy(self->answer + self->used, bytes, fits);
    self->used += fits;
    self->cut = self->cut || fits < n;
}

size_t dg_host_panel_size(void)
{
    return dg_host_round(sizeof(struct dg_host_panel));
}

static void build_panel(struct dg_host_panel *self)
{
    struct dg_host *host = self->host;

    self->encoder = (struct dg_encoder){
        .name = host->refs.device->name,
        .model = host->refs.device,
        .instrument = self->instruments[0],
        .device = host->line.device,
        .world = &host->world,
        .shaft = &self->shaft,
        .nvm = dg_host_setup(host).nvm,
    };
    self->shaft.name = "shaft";
    self->encoders[0] = &self->encoder;
    self->shafts[0] = &self->shaft;
    self->rig = (struct dg_rig){
        .encoders = self->encoders,
        .encoder_count = 1,
        .shafts = self->shafts,
        .shaft_count = 1,
        .instruments = self->instruments,
        .instrument_count = 1,
        .ops = &ops,
        .host = self,
    };
    dg_control_init(&self->control, &self->rig, collect, self);
}

struct dg_host_panel *dg_host_panel_init(void *memory, size_t size, struct dg_host *host,
                                         const struct dg_instrument *instrument)
{
    struct dg_host_panel *self = memory;

    if (memory == NULL || size < dg_host_panel_size() || (uintptr_t)memory % DG_HOST_ALIGN != 0 ||
        !host->made || instrument == NULL || instrument->stack != host->refs.device->stack) {
        return NULL;
    }
    memset(self, 0, sizeof *self);
    self->host = host;
    self->instruments[0] = instrument;
    build_panel(self);
    const int64_t angle = dg_host_angle(host, host->line.now);
    dg_shaft_init(&self->shaft.shaft);
    (void)dg_shaft_set_position(&self->shaft.shaft, host->line.now, angle);
    dg_host_shaft_of(host, &self->shaft.shaft);
    if (instrument->line_frame != NULL) {
        self->clock = instrument->clock(host->line.device);
        dg_line_fault_init(&self->line, instrument, host->line.device, &self->encoder.faults);
    }
    host->refs.faults = &faults_at_work;
    host->refs.faults_ctx = self;
    return self;
}

void dg_host_panel_seed(struct dg_host_panel *self, uint32_t seed)
{
    const struct dg_instrument *instrument = self->encoder.instrument;

    self->encoder.faults.random = seed;
    if (instrument->seed != NULL) {
        instrument->seed(self->host->line.device, seed);
    }
}

struct dg_shaft *dg_host_panel_shaft(struct dg_host_panel *self)
{
    return &self->shaft.shaft;
}

struct dg_encoder *dg_host_panel_encoder(struct dg_host_panel *self)
{
    return &self->encoder;
}

struct dg_rig *dg_host_panel_rig(struct dg_host_panel *self)
{
    return &self->rig;
}

/* ------------------------------------------------------------ faults */

int dg_host_fault(const struct dg_host_panel *self, size_t index, struct dg_host_fault *to)
{
    const struct dg_fault_target target = dg_encoder_target(&self->encoder);
    struct dg_fault_entry entry;

    if (!dg_fault_entry(&target, index, &entry)) {
        return DG_HOST_ERR_NAME;
    }
    *to = (struct dg_host_fault){.cause = entry.cause,
                                 .effect = entry.effect,
                                 .active = self->encoder.faults.fault[index].active};
    _Static_assert(sizeof to->name == sizeof entry.name, "a name has the room it needs");
    memcpy(to->name, entry.name, sizeof to->name);
    return DG_HOST_OK;
}

static int set_fault(struct dg_host_panel *self, const struct dg_fault_target *target, size_t index,
                     bool on)
{
    static const struct dg_fault_limits usual = {.probability_ppm = 1000000, .duration = DG_NEVER};
    struct dg_faults *faults = &self->encoder.faults;

    return on ? dg_fault_set(faults, target, index, self->host->line.now, &usual)
              : dg_fault_clear(faults, target, index);
}

int dg_host_fault_set(struct dg_host_panel *self, uint64_t now, const char *name, bool on)
{
    const struct dg_fault_target target = dg_encoder_target(&self->encoder);
    const int index = dg_fault_find(&target, name);

    if (index < 0) {
        return DG_HOST_ERR_NAME;
    }
    dg_host_run(self->host, now);
    const int result = set_fault(self, &target, (size_t)index, on);
    feel_controller(self);
    dg_host_run(self->host, now);
    return result;
}

/* ------------------------------------------------------------ SCPI */

/* One more than a session takes: it is told that the line is too long, and does none of it. */
static size_t command_length_of(const char *line)
{
    size_t n = 0;

    while (n <= DG_SCPI_LINE_MAX && line[n] != '\0') {
        n++;
    }
    return n;
}

static bool take_panel_line(struct dg_host_panel *self, dg_ns now, const char *line)
{
    const size_t n = command_length_of(line);

    if (n == 0) {
        return true;
    }
    return dg_control_rx(&self->control, now, line, n) == n &&
           dg_control_rx(&self->control, now, "\n", 1) == 1;
}

int dg_host_scpi(struct dg_host_panel *self, uint64_t now, const char *line, char *answer,
                 size_t size)
{
    if (size == 0) {
        return DG_HOST_ERR_SPACE;
    }
    (void)dg_host_panel_step(self, now);
    now = self->host->line.now;
    self->answer = answer;
    self->size = size - 1u;
    self->cut = false;
    self->used = 0;
    const bool taken = take_panel_line(self, now, line);
    (void)dg_control_step(&self->control, now);
    size_t n = self->used;
    n -= n > 0 && answer[n - 1u] == '\n' ? 1u : 0u;
    answer[n] = '\0';
    return self->cut || !taken ? DG_HOST_ERR_SPACE : (int)n;
}

/* Each fault ends at its own moment, in the order of what happens to the encoder. */
uint64_t dg_host_panel_step(struct dg_host_panel *self, uint64_t now)
{
    dg_ns faults = dg_rig_step(&self->rig, self->host->line.now);

    while (faults <= now && faults > self->host->line.now) {
        dg_host_run(self->host, faults);
        faults = dg_rig_step(&self->rig, faults);
    }
    dg_host_run(self->host, now);
    return dg_earliest(faults, dg_host_next(self->host));
}
