/* SPDX-License-Identifier: MIT */
/*
 * A real CANopen encoder against its clauses. Rows are about node 3Fh; to another one their
 * identifiers are moved. The model beside the encoder has its serial number and its raw position.
 * Frames of other nodes, and what the node sends by itself, are not looked at unless a row waits
 * for them.
 */
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "timer.h"
#include "verify_canopen.h"
#include "verify_eds.h"
#include "verify_stream.h"

/* --- the bus --- */

/* The identifier of a service of node `from`, for node `to`. */
static uint16_t move_id(uint16_t id, uint8_t from, uint8_t to)
{
    const bool of_node = id >= 0x080u && id <= 0x77Fu && (id & 0x7Fu) == from;
    return of_node ? (uint16_t)((id & 0x780u) | to) : id;
}

bool verify_canopen_send_frame(struct canopen *self, const struct dg_can_frame *frame,
                               struct cf_report *report)
{
    self->request = *frame;
    self->passed_count = 0;
    if (verify_frames_send(&self->wire, frame) != 0) {
        return verify_fail(&self->base, VERIFY_LOST, report, "the wire accepts no more data");
    }
    self->base.since = lx_now();
    return true;
}

/* Whether it answers something: a PDO, an SDO, LSS. */
static bool is_answer(const struct canopen *self, uint16_t id)
{
    return id == 0x7E4u ||
           (id >= 0x180u && id < 0x600u && (id & 0x7Fu) == self->node && (id & 0x80u) != 0);
}

/* What came before a frame that a row waits for: on a bus, identifiers decide what is sent first. */
static void keep_passed(struct canopen *self, const struct dg_can_frame *frame)
{
    if (self->passed_count < PASSED_MAX) {
        self->passed[self->passed_count++] = *frame;
    }
}

static bool take_passed(struct canopen *self, uint16_t id, struct dg_can_frame *to)
{
    size_t at = 0;
    while (at < self->passed_count && self->passed[at].id != id) {
        at++;
    }
    if (at == self->passed_count) {
        return false;
    }
    *to = self->passed[at];
    self->passed_count--;
    memmove(self->passed + at, self->passed + at + 1u,
            (self->passed_count - at) * sizeof self->passed[0]);
    return true;
}

/* The next frame with this identifier since the last request, 0: that answers something.
   @return 1, 0: none came, -1: lost, as `report` says */
int verify_canopen_receive_id(struct canopen *self, uint16_t id, dg_ns until,
                              struct dg_can_frame *to, struct cf_report *report)
{
    if (id != 0 && take_passed(self, id, to)) {
        return 1;
    }
    for (unsigned n = 0; n < FRAMES_MAX; n++) {
        const int result = verify_frames_receive(&self->wire, until, to);
        if (result < 0) {
            (void)verify_fail(&self->base, VERIFY_LOST, report, "the wire is gone");
            return -1;
        }
        if (result == 0 && lx_now() >= until) {
            return 0;
        }
        if (result > 0 && (id == 0 ? is_answer(self, to->id) : to->id == id)) {
            return 1;
        }
        if (result > 0) {
            keep_passed(self, to);
        }
    }
    (void)verify_fail(&self->base, VERIFY_LOST, report, "the bus is never silent");
    return -1;
}

/* --- what is compared --- */

/* Objects that are not constant: from, to, what they are. */
static const struct {
    uint16_t first, last;
    enum kind kind;
} objects[] = {
    /* clang-format off */
    {0x1003, 0x1003, CONFIGURED}, {0x1005, 0x1007, CONFIGURED}, {0x1008, 0x100A, TEXT},
    {0x100B, 0x1012, CONFIGURED}, {0x1013, 0x1013, MEASURED},
    {0x1014, 0x1017, CONFIGURED}, {0x1029, 0x1029, CONFIGURED},
    {0x1800, 0x1AFF, CONFIGURED}, {0x2100, 0x2102, CONFIGURED}, {0x2120, 0x2120, CONFIGURED},
    {0x2125, 0x2125, MEASURED},   {0x2140, 0x2140, CONFIGURED}, {0x2160, 0x2160, POSITION},
    {0x2161, 0x2162, MEASURED},   {0x6000, 0x6003, CONFIGURED}, {0x6004, 0x6004, POSITION},
    {0x6030, 0x6030, MEASURED},   {0x6031, 0x6031, CONFIGURED}, {0x6040, 0x6040, MEASURED},
    {0x6200, 0x6200, CONFIGURED}, {0x6401, 0x6402, CONFIGURED}, {0x6508, 0x6508, MEASURED},
    {0x6509, 0x6509, CONFIGURED},
    /* clang-format on */
};

enum kind verify_canopen_kind_of_object(uint16_t index)
{
    for (size_t i = 0; i < DG_COUNT(objects); i++) {
        if (index >= objects[i].first && index <= objects[i].last) {
            return objects[i].kind;
        }
    }
    return CONSTANT;
}

/* What the data of an answer are: behind an upload those of an object, in a PDO measured. */
static enum kind kind_of(const struct cf_unit *answer)
{
    const bool pdo = answer->id >= 0x180u && answer->id < 0x580u;
    const bool uploaded = answer->id == SDO_ANSWER + ROW_NODE && answer->n == 8 &&
                          (answer->bytes[0] & 0xF3u) == 0x43u;
    if (pdo) {
        return MEASURED;
    }
    return uploaded ? verify_canopen_kind_of_object(
                          (uint16_t)(answer->bytes[1] | (unsigned)answer->bytes[2] << 8))
                    : CONSTANT;
}

static bool same_form(const struct cf_unit *a, const struct cf_unit *b)
{
    const size_t head = a->id >= 0x180u && a->id < 0x580u ? 0u : 4u;
    return a->id == b->id && a->rtr == b->rtr && a->n == b->n &&
           memcmp(a->bytes, b->bytes, a->n < head ? a->n : head) == 0;
}

static bool same_data(const struct cf_unit *a, const struct cf_unit *b)
{
    return a->n == b->n && memcmp(a->bytes, b->bytes, a->n) == 0;
}

/* What CiA 301 leaves to a server: the object that it names when it refuses a command that it does not know
   or does not await, and how many segments it takes in a block. */
static size_t free_byte(const uint8_t *answer)
{
    const uint8_t initiated = answer[0] & 0xFBu;
    return initiated == 0xA0u ? 4u : answer[0] == 0xA2u ? 2u : 0u;
}

static bool is_as_free(const struct cf_unit *expected, const struct cf_unit *came)
{
    static const uint8_t unknown[] = {0x01, 0x00, 0x04, 0x05};
    struct cf_unit other = *came;
    uint8_t bytes[8];
    if (expected->id != SDO_ANSWER + ROW_NODE || came->id != expected->id || came->n != 8 ||
        expected->n != 8 || came->bytes[0] != expected->bytes[0]) {
        return false;
    }
    if (expected->bytes[0] == 0x80u) {
        return memcmp(expected->bytes + 4, unknown, 4) == 0 &&
               memcmp(came->bytes + 4, unknown, 4) == 0;
    }
    const size_t at = free_byte(expected->bytes);
    memcpy(bytes, came->bytes, sizeof bytes);
    bytes[at] = expected->bytes[at];
    other.bytes = bytes;
    return at != 0 && came->bytes[at] >= 1 && came->bytes[at] <= 127 && same_data(expected, &other);
}

/* The serial number is the encoder's own, too, and the model has the same. */
static bool is_serial(const struct cf_unit *answer)
{
    static const uint8_t heads[][4] = {{0x43, 0x18, 0x10, 0x04}, {0x43, 0x0B, 0x65, 0x00}};
    return answer->n == 8 &&
           (memcmp(answer->bytes, heads[0], 4) == 0 || memcmp(answer->bytes, heads[1], 4) == 0);
}

/* Whether the model, which is in the encoder's state, still says what the row is about. */
static bool is_as_delivered(const struct cf_answer *answer)
{
    const struct cf_unit *want = &answer->want;
    if (answer->got.bytes == NULL || !same_form(want, &answer->got)) {
        return false;
    }
    const enum kind kind = kind_of(want);
    return kind == MEASURED || kind == POSITION || is_serial(want) || same_data(want, &answer->got);
}

bool verify_canopen_is_near(const struct canopen *self, uint32_t a, uint32_t b)
{
    const uint32_t up = a - b;
    return up <= self->moves || 0u - up <= self->moves;
}

/* --- beside the model --- */

static struct dg_can_frame frame_of(const struct cf_unit *unit)
{
    struct dg_can_frame frame = {.id = unit->id, .dlc = (uint8_t)unit->n, .rtr = unit->rtr};
    memcpy(frame.data, unit->bytes, unit->n <= sizeof frame.data ? unit->n : sizeof frame.data);
    return frame;
}

static bool on_sent(void *ctx, const struct cf_unit *request, struct cf_report *report)
{
    struct canopen *self = ctx;
    struct dg_can_frame frame = frame_of(request);
    if (self->refusal[0] != '\0' && !self->irreversible) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report, "%s", self->refusal);
    }
    frame.id = move_id(frame.id, ROW_NODE, self->node);
    if (frame.id == 0 && frame.dlc == 2 && frame.data[1] == ROW_NODE) {
        frame.data[1] = self->node;
    }
    if (frame.id == 0 && frame.dlc == 2 && (frame.data[0] == 0x81u || frame.data[0] == 0x82u)) {
        verify_canopen_forget(self);
    }
    return verify_canopen_send_frame(self, &frame, report);
}

static bool report_frame(struct canopen *self, const struct cf_unit *expected,
                         const struct dg_can_frame *came, struct cf_report *report)
{
    char text[3][100];
    const struct cf_unit sent = {self->request.id, self->request.rtr, self->request.data,
                                 self->request.dlc};
    struct cf_unit moved = *expected;
    struct cf_unit got = {.bytes = NULL};
    moved.id = move_id(moved.id, ROW_NODE, self->node);
    if (came != NULL) {
        got = (struct cf_unit){came->id, came->rtr, came->data, came->dlc};
    }
    (void)verify_print_unit(&sent, text[0], sizeof text[0]);
    (void)verify_print_unit(&moved, text[1], sizeof text[1]);
    (void)verify_print_unit(&got, text[2], sizeof text[2]);
    return verify_fail(&self->base, VERIFY_DIFFERS, report, "sent%s; expected%s; came%s", text[0],
                       text[1], text[2]);
}

static bool is_text(const uint8_t *bytes, size_t n)
{
    bool text = true;
    for (size_t i = 0; i < n; i++) {
        text = text && bytes[i] >= ' ' && bytes[i] <= '~';
    }
    return text;
}

static bool judge_frame_values(struct canopen *self, const struct cf_unit *expected,
                               const struct dg_can_frame *came, struct cf_report *report)
{
    const struct cf_unit got = {move_id(came->id, self->node, ROW_NODE), came->rtr, came->data,
                                came->dlc};
    const enum kind kind = kind_of(expected);
    if (expected->id == GUARDING && got.n == 1 && expected->n == 1 &&
        ((got.bytes[0] ^ expected->bytes[0]) & 0x7Fu) == 0) {
        return true; /* its toggle bit goes on from row to row, the model's begins again */
    }
    if (is_as_free(expected, &got)) {
        return true;
    }
    if (!same_form(expected, &got)) {
        return report_frame(self, expected, came, report);
    }
    if (kind == MEASURED || same_data(expected, &got)) {
        return true;
    }
    if (kind == POSITION &&
        verify_canopen_is_near(self, le32(got.bytes + 4), le32(expected->bytes + 4))) {
        return true;
    }
    if (kind == TEXT && is_text(got.bytes + 4, 4u - (got.bytes[0] >> 2 & 3u))) {
        return true;
    }
    if (kind == CONFIGURED && !verify_canopen_is_known(self, got.bytes)) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report, "needs %02X%02Xh:%u as delivered",
                           got.bytes[2], got.bytes[1], (unsigned)got.bytes[3]);
    }
    return report_frame(self, expected, came, report);
}

/* The answer to an upload, whatever the model says to it. */
static bool judge_relation(struct canopen *self, const struct cf_relation *relation,
                           struct cf_report *report)
{
    struct dg_can_frame came = {.dlc = 0};
    char text[2][100];
    const struct cf_unit sent = {self->request.id, false, self->request.data, self->request.dlc};
    const int result = verify_canopen_receive_id(self, (uint16_t)(SDO_ANSWER + self->node),
                                                 self->base.since + ANSWER_MAX, &came, report);
    const struct cf_unit unit = {came.id, came.rtr, result > 0 ? came.data : NULL, came.dlc};
    if (result < 0) {
        return false;
    }
    const enum cf_verdict verdict = relation->judge(relation->ctx, &unit);
    if (verdict == CF_AGREES) {
        return true;
    }
    (void)verify_print_unit(&sent, text[0], sizeof text[0]);
    (void)verify_print_unit(&unit, text[1], sizeof text[1]);
    return verify_fail(&self->base, verdict == CF_UNKNOWN ? VERIFY_NOT_SEEN : VERIFY_DIFFERS,
                       report, "sent%s; expected %s; came%s", text[0], relation->text, text[1]);
}

static bool on_answered(void *ctx, const struct cf_answer *answer, struct cf_report *report)
{
    struct canopen *self = ctx;
    struct dg_can_frame came;
    if (answer->relation != NULL) {
        return judge_relation(self, answer->relation, report);
    }
    if (!is_as_delivered(answer)) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report,
                           "needs an encoder in its delivery state");
    }
    const uint16_t id = move_id(answer->got.id, ROW_NODE, self->node);
    const dg_ns slack = self->jitter + HOST_ADDS;
    const dg_ns late = answer->latest_ns + slack;
    self->passed_count = answer->timed && answer->earliest_ns > slack ? 0 : self->passed_count;
    const int result = verify_canopen_receive_id(
        self, id, self->base.since + (answer->timed ? late : ANSWER_MAX), &came, report);
    if (result <= 0) {
        return result == 0 && report_frame(self, &answer->got, NULL, report);
    }
    const dg_ns took = lx_now() - self->base.since;
    self->base.since += took;
    verify_canopen_remember(self, &answer->got);
    if (answer->timed && took + slack < answer->earliest_ns) {
        return verify_fail(&self->base, VERIFY_DIFFERS, report, "%03Xh came after %llu us already",
                           (unsigned)came.id, (unsigned long long)took / 1000u);
    }
    return judge_frame_values(self, &answer->got, &came, report);
}

static bool on_silent(void *ctx, uint64_t ns, struct cf_report *report)
{
    struct canopen *self = ctx;
    static const struct cf_unit nothing = {.bytes = NULL};
    struct dg_can_frame came;
    const dg_ns wait = ns == 1u ? SETTLE : ns > SILENCE ? ns : SILENCE;
    const uint16_t id = ns == 1u ? (uint16_t)(SDO_ANSWER + self->node) : 0; /* PDOs may go on */
    const int result = verify_canopen_receive_id(self, id, lx_now() + wait, &came, report);
    return result == 0 || (result > 0 && report_frame(self, &nothing, &came, report));
}

static bool on_waited(void *ctx, uint64_t ns, struct cf_report *report)
{
    struct canopen *self = ctx;
    (void)report;
    verify_stream_wait(&self->wire.stream, lx_now() + ns);
    self->base.since = lx_now();
    return true;
}

/* An encoder without supply sends nothing: what has come before, such as a heartbeat, is not from after its
   start. */
static bool on_powered(void *ctx, bool on, struct cf_report *report)
{
    struct canopen *self = ctx;
    struct dg_can_frame came;
    if (on && verify_canopen_receive_id(self, NOBODY, lx_now() + SETTLE, &came, report) < 0) {
        return false;
    }
    self->passed_count = 0;
    verify_canopen_forget(self);
    return verify_powered(ctx, on, report);
}

static const struct cf_beside_ops beside_ops = {
    .sent = on_sent,
    .answered = on_answered,
    .silent = on_silent,
    .waited = on_waited,
    .powered = on_powered,
    .needs = verify_allowed,
};

/* --- rows --- */

static void rehearse(struct verify_encoder *base, const struct cf_beside *beside, dg_ns slack)
{
    struct canopen *self = of(base);
    const struct cf_canopen_trial trial = {
        .device = self->device, .slack = slack, .beside = *beside};
    self->touched_count = 0;
    self->stores = false;
    self->one_way = false;
    cf_canopen_try(&trial);
}

/* What one cannot write back: what deletes, and who the node is. */
static bool is_one_way(uint16_t index)
{
    static const uint16_t indices[] = {0x1003, 0x2100, 0x2101, 0x2102,
                                       0x2105, 0x300A, 0x300B, 0x6509};
    bool found = false;
    for (size_t i = 0; i < DG_COUNT(indices); i++) {
        found = found || indices[i] == index;
    }
    return found;
}

/* A download begins. @return what it needs */
static unsigned touch(struct canopen *self, const struct cf_unit *request)
{
    const struct object object = {
        .index = (uint16_t)(request->bytes[1] | (unsigned)request->bytes[2] << 8),
        .sub = request->bytes[3],
    };
    bool known = false;
    for (size_t i = 0; i < self->touched_count; i++) {
        known =
            known || (self->touched[i].index == object.index && self->touched[i].sub == object.sub);
    }
    if (!known && self->touched_count == TOUCHED_MAX) {
        return CF_WRITE | CF_ONE_WAY;
    }
    if (!known) {
        self->touched[self->touched_count++] = object;
    }
    if (verify_canopen_needs_saved(object.index)) {
        self->stores = true;
        return CF_WRITE | (self->irreversible ? 0u : CF_POWER);
    }
    self->one_way = self->one_way || is_one_way(object.index);
    return CF_WRITE | (is_one_way(object.index) ? CF_ONE_WAY : 0u);
}

/* Downloads change the encoder; all but SDO and node guarding reaches others, or what they do. */
static unsigned needs_of(struct verify_encoder *base, const struct cf_unit *request)
{
    if (request->id == SDO_REQUEST + ROW_NODE && !request->rtr && request->n > 0) {
        const unsigned command = request->bytes[0] >> 5;
        const bool initiate = command == 1 || command == 6;
        return initiate && request->n > 3 ? touch(of(base), request)
               : command == 0 || initiate ? CF_WRITE
                                          : 0u;
    }
    if (request->id == 0x7E5u && request->n > 0 && request->bytes[0] >= 0x11u &&
        request->bytes[0] <= 0x17u) {
        return CF_ALONE | CF_ONE_WAY; /* its node number, its bit rate */
    }
    if (request->rtr && !verify_frames_has_remote(&of(base)->wire)) {
        return CF_EXACT;
    }
    return request->id == GUARDING && request->rtr ? 0u : CF_ALONE;
}

/* No transfer is left of the row before, no answer is on its way; and somebody is there. */
bool verify_canopen_settle(struct canopen *self, struct cf_report *report)
{
    const struct dg_can_frame abort = {
        .id = (uint16_t)(SDO_REQUEST + self->node), .dlc = 8, .data = {0x80}};
    struct dg_can_frame came;
    uint32_t value;
    for (unsigned i = 0; i < 3; i++) {
        if (!verify_canopen_send_frame(self, &abort, report) ||
            verify_canopen_receive_id(self, NOBODY, lx_now() + SETTLE, &came, report) < 0) {
            return false;
        }
        if (verify_canopen_upload(self, 0x1000, 0, &value) > 0) {
            return true;
        }
    }
    return verify_fail(&self->base, VERIFY_LOST, report, "it does not answer any more");
}

static bool begin(struct verify_encoder *base, struct cf_report *report)
{
    struct canopen *self = of(base);
    uint32_t value = 0;
    if (!verify_canopen_settle(self, report)) {
        return false;
    }
    base->outcome = VERIFY_AGREES;
    self->written_count = 0;
    self->loads = false;
    self->restored = false;
    self->trial.raw = verify_canopen_upload(self, 0x2160, 0, &value) > 0 ? value : 0;
    (void)verify_canopen_upload(self, 0x6004, 0, &self->position);
    if (base->journal != NULL &&
        (!verify_canopen_note_saved(self, report) || !verify_canopen_note_touched(self, report) ||
         !verify_canopen_deliver(self, report))) {
        return false;
    }
    self->trial.device = self->device;
    self->trial.placed = true;
    self->trial.beside = (struct cf_beside){&beside_ops, self};
    cf_canopen_try(&self->trial);
    return true;
}

/* The model begins pre-operational, and so does the encoder; LSS is left. */
static void leave_encoder(struct canopen *self)
{
    static const struct dg_can_frame waiting = {.id = 0x7E5, .dlc = 8, .data = {0x04, 0x00}};
    const struct dg_can_frame calm = {.id = 0, .dlc = 2, .data = {0x80, self->node}};
    (void)verify_frames_send(&self->wire, &waiting);
    (void)verify_frames_send(&self->wire, &calm);
    verify_stream_wait(&self->wire.stream, lx_now() + SILENCE);
}

static bool end(struct verify_encoder *base, struct cf_report *report)
{
    struct canopen *self = of(base);
    if (self->alone) {
        leave_encoder(self);
    }
    const enum verify_outcome outcome = base->outcome;
    const bool there = outcome != VERIFY_DIFFERS || verify_canopen_settle(self, report);
    base->outcome = there ? outcome : base->outcome;
    return there;
}

/* --- the encoder --- */

static int unanswered(const struct canopen *self, const char *where, struct lx_error *error)
{
    return lx_refuse(error, "expected its node-ID with --node, and a bus at 250 kBd",
                     "%s: node %u does not answer", where, (unsigned)self->node);
}

static int identify_node(struct canopen *self, const char *where, struct lx_error *error)
{
    uint32_t type = 0;
    uint32_t product = 0;
    uint32_t revision = 0;
    uint32_t firmware = 0;
    bool answered = verify_canopen_upload(self, 0x1000, 0, &type) > 0;
    answered = answered || verify_canopen_upload(self, 0x1000, 0, &type) >
                               0; /* the first may have met a frame */
    if (!answered) {
        return unanswered(self, where, error);
    }
    (void)verify_canopen_upload(self, 0x1018, 2, &product);
    (void)verify_canopen_upload(self, 0x1018, 3, &revision);
    (void)verify_canopen_upload(self, 0x1018, 4, &self->trial.serial);
    (void)verify_canopen_upload(self, 0x2103, 0, &firmware);
    (void)snprintf(self->base.serial, sizeof self->base.serial, "%lu",
                   (unsigned long)self->trial.serial);
    (void)snprintf(self->base.identity, sizeof self->base.identity,
                   "device type %08lXh, product %08lXh, revision %lu, firmware %lu",
                   (unsigned long)type, (unsigned long)product, (unsigned long)revision,
                   (unsigned long)firmware);
    return 0;
}

/* How far readings of a shaft at rest, and times of answers, are apart. */
static int measure_node(struct canopen *self, const char *where, struct lx_error *error)
{
    dg_ns shortest = DG_NEVER;
    dg_ns longest = 0;
    uint32_t before = 0;
    for (unsigned i = 0; i < READINGS; i++) {
        uint32_t now = 0;
        const dg_ns from = lx_now();
        if (verify_canopen_upload(self, 0x6004, 0, &now) == 0) {
            return unanswered(self, where, error);
        }
        const dg_ns took = lx_now() - from;
        shortest = took < shortest ? took : shortest;
        longest = took > longest ? took : longest;
        while (i > 0 && !verify_canopen_is_near(self, now, before) && self->moves <= MOVES_MAX) {
            self->moves++;
        }
        before = now;
    }
    if (self->moves > MOVES_MAX) {
        return lx_refuse(error, "expected a shaft at rest", "%s: the shaft turns", where);
    }
    self->moves = 2u * self->moves + 1u;
    /* A network may hold up one frame, and not the next one. */
    self->jitter = self->wire.stream.network ? longest : longest - shortest;
    return 0;
}

/* An upload of 1000h hurts nobody. */
static int scan(struct verify_encoder *base, struct lx_error *error)
{
    struct canopen *self = of(base);
    const dg_ns until = lx_now() + VERIFY_SCAN;
    struct dg_can_frame frame = {.dlc = 8, .data = {0x40, 0x00, 0x10, 0x00}};
    for (uint16_t node = 1; node <= 127; node++) {
        frame.id = (uint16_t)(SDO_REQUEST + node);
        if (node != self->node && verify_frames_send(&self->wire, &frame) != 0) {
            return lx_fail(error, "the wire accepts no more data");
        }
        verify_stream_wait(&self->wire.stream, lx_now() + DG_MS(2));
    }
    while (lx_now() < until) {
        const int result = verify_frames_receive(&self->wire, until, &frame);
        if (result < 0 || (result > 0 && (frame.id & 0x7Fu) != self->node)) {
            return lx_refuse(error, "without --alone, verify disturbs no other device",
                             "another device is on the bus: %03Xh was received",
                             (unsigned)frame.id);
        }
    }
    return 0;
}

static void close_encoder(struct verify_encoder *base)
{
    struct canopen *self = of(base);
    cf_canopen_try(NULL);
    verify_frames_close(&self->wire);
}

static int open_encoder(struct verify_encoder *base, const struct options *options,
                        struct lx_error *error)
{
    struct canopen *self = of(base);
    self->device = options->eds == NULL ? options->device : NULL;
    self->alone = options->alone;
    self->irreversible = options->irreversible;
    self->wire.stream.fd = -1;
    base->stream = &self->wire.stream;
    return verify_eds_node(options->node, &self->node, error) == 0
               ? verify_frames_open(&self->wire, options, error)
               : -1;
}

static int identify(struct verify_encoder *base, const char *where, struct lx_error *error)
{
    struct canopen *self = of(base);
    const int identified = identify_node(self, where, error);
    return identified != 0 || self->device == NULL ? identified : measure_node(self, where, error);
}

const struct verify_protocol verify_canopen = {
    .stack = &dg_cia406_stack,
    .suites = {"canopen", "cia406"},
    .choices = "CD",
    .writes =
        "objects, by SDO: communication, TPDOs and their mapping, scaling, working areas, customer memory; "
        "with --power COMMAND also the preset, and what is saved",
    .rows = cf_canopen,
    .size = sizeof(struct canopen),
    .open = open_encoder,
    .identify = identify,
    .scan = scan,
    .rehearse = rehearse,
    .needs = needs_of,
    .begin = begin,
    .end = end,
    .put_back = verify_canopen_put_back,
    .close = close_encoder,
};

const struct verify_protocol verify_canopen_file = {
    .stack = &dg_cia406_stack,
    .suites = {"eds"},
    .load = verify_eds_load,
    .choices = "",
    .rows = cf_canopen,
    .size = sizeof(struct canopen),
    .open = open_encoder,
    .identify = identify,
    .scan = scan,
    .rehearse = rehearse,
    .needs = needs_of,
    .begin = begin,
    .end = end,
    .close = close_encoder,
};
