/* SPDX-License-Identifier: MIT */
/*
 * What a plan says of encoders and wires, by rows. An encoder has four lists of them: its end of
 * the line, the host's own, the encoder's, its world's; the first one that has the name counts.
 */
#include "drehgeber/course.h"
#include "drehgeber/figure.h"
#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "engine_private.h"

#include <string.h>

#define SERIAL "serial"
#define RIGHT_MAX 256u

/* ---------------------------------------------------------------- rows of wires */

#define LINE(member) offsetof(struct dg_engine_line, member)
#define END(member) offsetof(struct dg_engine_end, member)

static const char *const own_any[2] = {"own", "any"};

/* clang-format off */
static const struct dg_key end_rows[] = {
    {"pace",          "",   END(pace),            DG_KEY_FLAG, 0,     1,     0,      1,                   dg_key_no_yes, "requests and replies at the speed of the line; 0: at once"},
    {"line",          "",   END(any_line),        DG_KEY_FLAG, 0,     1,     0,      1,                   own_any,       "data rate the master must use: the encoder's own, or any"},
};
/* clang-format on */

const struct dg_keys dg_engine_end_keys[DG_MEDIUM_COUNT] = {
    [DG_MEDIUM_CHARACTERS] = {end_rows, DG_COUNT(end_rows)},
};
const struct dg_engine_end dg_engine_end_usual = {.pace = true};

/* ---------------------------------------------------------------- a value */

/* "expected a number in 1..127" */
static int set_value(const struct dg_key *row, void *base, const char *value,
                     struct dg_plan_error *error)
{
    char words[RIGHT_MAX];
    struct dg_text right = dg_text_in(words, sizeof words);

    if (dg_key_set(row, base, value) == DG_OK) {
        return 0;
    }
    dg_key_say_right(row, &right);
    return dg_plan_refuse(error, RIG_SAY(words), RIG_SAY(""));
}

static int refuse_setting(const struct dg_plan *plan, const struct dg_plan_setting *setting,
                          struct dg_plan_error *error)
{
    if (error->key[0] == '\0') {
        (void)dg_plan_about(error, setting->key, setting->value);
        error->valued = DG_PLAN_SETTING;
    }
    return dg_plan_stand(plan, setting->line, error);
}

/* ---------------------------------------------------------------- lists */

enum { OF_END, OF_HOST, OF_ENCODER, OF_WORLD, LISTS };

struct list {
    struct dg_keys keys;
    void *base;
    uint32_t without; /* bit n: row n is not there */
};

/* Serial number and address have words of their own in a rig file. */
static uint32_t separate_keys_of(const struct dg_host_wire *wire)
{
    const struct dg_key *rows[] = {dg_keys_find(wire->keys, SERIAL), NULL};
    uint32_t bits = 0;

    if (wire->stack->address_key != NULL) {
        rows[1] = dg_keys_find(wire->keys, wire->stack->address_key);
    }
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        bits |= rows[i] == NULL ? 0 : UINT32_C(1) << (rows[i] - wire->keys->rows);
    }
    return bits;
}

static void list_rows(struct dg_engine *self, size_t index, struct list lists[LISTS])
{
    struct engine_encoder *encoder = &self->encoders[index];
    const struct dg_host_wire *wire = dg_host_wire_at(encoder->host);
    void *settings = dg_host_line_of(encoder->host)->settings;

    lists[OF_END] =
        (struct list){.keys = dg_engine_end_keys[wire->stack->medium], .base = &encoder->end};
    lists[OF_HOST] = (struct list){.base = NULL};
    if (self->setup.rows != NULL) {
        lists[OF_HOST].base =
            self->setup.rows(self->setup.ctx, index, settings, &lists[OF_HOST].keys);
    }
    lists[OF_ENCODER] = (struct list){.keys = *wire->keys, .base = settings};
    lists[OF_ENCODER].without =
        separate_keys_of(wire) | (wire->without != NULL ? wire->without(settings) : 0);
    lists[OF_WORLD] = (struct list){
        .keys = dg_world_keys, .base = dg_host_world(encoder->host), .without = wire->blind};
}

static bool has_row(const struct list *self, size_t row)
{
    return row >= 32u || (self->without >> row & 1u) == 0;
}

static const struct dg_key *find_key(const struct list lists[LISTS], const char *name, void **base)
{
    for (size_t i = 0; i < LISTS; i++) {
        const struct dg_key *row =
            lists[i].keys.rows == NULL ? NULL : dg_keys_find(&lists[i].keys, name);
        if (row != NULL && has_row(&lists[i], (size_t)(row - lists[i].keys.rows))) {
            *base = lists[i].base;
            return row;
        }
    }
    return NULL;
}

/* ---------------------------------------------------------------- names that nobody has */

/* A key of its own, or of the ends of what it carries. */
static bool offers(const struct dg_plan_wire_kind *kind, const char *name)
{
    bool found = dg_plan_wire_has(kind, name);

    for (size_t i = 0; i < DG_MEDIUM_COUNT && !found; i++) {
        found = (kind->media >> i & 1u) != 0 && dg_engine_end_keys[i].rows != NULL &&
                dg_keys_find(&dg_engine_end_keys[i], name) != NULL;
    }
    return found;
}

/* @return how many kinds of wire take it, if one of them has it itself */
static size_t list_kinds(const char *name, struct rig_list *to)
{
    const size_t all = dg_plan_wire_count;
    size_t count = 0;
    size_t own = 0;
    size_t n = 0;

    for (size_t i = 0; i < all; i++) {
        own += dg_plan_wire_has(&dg_plan_wires[i], name) ? 1u : 0u;
        count += offers(&dg_plan_wires[i], name) ? 1u : 0u;
    }
    for (size_t i = 0; own > 0 && i < all; i++) {
        if (offers(&dg_plan_wires[i], name)) {
            dg_plan_list_item(to, dg_plan_wires[i].name, n++, count);
        }
    }
    return own > 0 ? count : 0;
}

/* A row of the host's is listed where the encoder has the one in place of which it is. */
static bool host_has(const struct list lists[LISTS], size_t list, const char *name)
{
    return list == OF_ENCODER && lists[OF_HOST].keys.rows != NULL &&
           dg_keys_find(&lists[OF_HOST].keys, name) != NULL;
}

static void list_names(const struct list lists[LISTS], struct dg_text *to)
{
    for (size_t i = 0; i < LISTS; i++) {
        for (size_t j = 0; j < lists[i].keys.count; j++) {
            const char *name = lists[i].keys.rows[j].name;
            const bool instead =
                i == OF_HOST && dg_keys_find(&lists[OF_ENCODER].keys, name) != NULL;
            if ((has_row(&lists[i], j) || host_has(lists, i, name)) && !instead) {
                dg_plan_add(to, RIG_SAY(" ", name));
            }
        }
    }
}

/* A key of another kind of wire, or of none: whoever mistyped one finds it in the list. */
static int refuse_setting_name(const struct dg_engine *self, size_t index,
                               const struct list lists[LISTS], const char *name,
                               struct dg_plan_error *error)
{
    const struct dg_plan_wire *wire =
        &self->setup.plan->wires[self->setup.plan->encoders[index].wire];
    const struct dg_keys *of_wire = wire->kind->keys;
    struct rig_list text;

    dg_plan_list_begin(&text);
    const size_t others = list_kinds(name, &text);
    if (others > 0) {
        return dg_plan_refuse(error, RIG_SAY("leave it out"),
                              RIG_SAY("only ", others == 1 ? "a " : "", text.room,
                                      others == 1 ? " wire has it" : " wires have it"));
    }
    dg_text_add(&text.text, "valid:");
    list_names(lists, &text.text);
    for (size_t i = 0; of_wire != NULL && i < of_wire->count; i++) {
        dg_plan_add(&text.text, RIG_SAY(i == 0 ? "; of the wire: " : " ", of_wire->rows[i].name));
    }
    (void)dg_plan_refuse(error, RIG_SAY(text.room), RIG_SAY("no such key"));
    return dg_plan_about(error, name, NULL);
}

/* ---------------------------------------------------------------- an encoder */

/* It is understood here; its points come when the rig is made. */
static int check_course(const struct dg_engine *self, const char *text, struct dg_plan_error *error)
{
    struct dg_course_words words;

    const int result = dg_course_read(text, &words, error);
    return result != 0 || self->setup.course != NULL
               ? result
               : dg_plan_refuse(error, RIG_SAY("expected a value"),
                                RIG_SAY("there are no files here"));
}

static int set_one(const struct dg_engine *self, size_t index, const struct list lists[LISTS],
                   const struct dg_plan_setting *setting, struct dg_plan_error *error)
{
    void *base = NULL;
    const struct dg_key *row = find_key(lists, setting->key, &base);

    if (row == NULL) {
        return refuse_setting_name(self, index, lists, setting->key, error);
    }
    return base == lists[OF_WORLD].base && dg_course_is(setting->value)
               ? check_course(self, setting->value, error)
               : set_value(row, base, setting->value, error);
}

static int set_serial(const struct dg_engine *self, size_t index, struct dg_plan_error *error)
{
    const struct dg_plan_encoder *row = &self->setup.plan->encoders[index];
    struct dg_host *host = self->encoders[index].host;
    const struct dg_key *key = dg_keys_find(dg_host_wire_at(host)->keys, SERIAL);

    if (key == NULL) {
        (void)dg_plan_refuse(error, RIG_SAY("leave it out"),
                             RIG_SAY(row->model->name, " has none"));
    } else if (set_value(key, dg_host_line_of(host)->settings, row->serial, error) == 0) {
        return 0;
    }
    (void)dg_plan_about(error, SERIAL, row->serial);
    return dg_plan_stand(self->setup.plan, row->serial_line, error);
}

/* 0: it has none. */
static uint32_t serial_of(struct dg_host *host)
{
    char text[DG_TEXT_DIGITS_MAX + 1u] = "";
    uint64_t serial = 0;

    (void)dg_host_get(host, SERIAL, text, sizeof text);
    (void)dg_unsigned_parse(text, &serial);
    return (uint32_t)serial;
}

/* Encoders whose master asks for their serial numbers count up on their wire. */
static void count_serial(const struct engine_encoder *encoder)
{
    const struct dg_host_wire *wire = dg_host_wire_at(encoder->host);
    const struct dg_key *key = dg_keys_find(wire->keys, SERIAL);
    const enum dg_medium medium = wire->stack->medium;

    if (key != NULL && (medium == DG_MEDIUM_FRAMES || medium == DG_MEDIUM_WORDS)) {
        const uint64_t serial =
            ((uint64_t)serial_of(encoder->host) + encoder->place) % ((uint64_t)key->max + 1u);
        (void)dg_host_set(encoder->host, SERIAL, dg_plan_number((size_t)serial).text);
    }
}

static void set_address(struct dg_host *host, const struct dg_plan_encoder *row)
{
    const char *key = row->model->stack->address_key;

    if (key != NULL && row->address != DG_PLAN_AS_DELIVERED) {
        (void)dg_host_set(host, key, dg_plan_number((size_t)row->address).text);
    }
}

/* Making a device touches no memory, so it may be tried. */
static int try_encoder(const struct dg_plan_encoder *row, struct dg_host *host,
                       struct dg_plan_error *error)
{
    static const struct dg_nvm_ops nowhere = {.read = NULL};
    struct dg_host_line *line = dg_host_line_of(host);
    struct dg_stack_setup setup = dg_host_setup(host);

    setup.nvm.ops = &nowhere;
    const int result = row->model->stack->init(line->device, &setup);
    memset(line->device, 0, row->model->stack->device_size);
    return result == 0 ? 0 : dg_plan_refuse(error, NULL, RIG_SAY("these figures make no encoder"));
}

/* One by one they are right. */
static int check_together(struct dg_engine *self, size_t index, struct dg_plan_error *error)
{
    const struct dg_plan_encoder *row = &self->setup.plan->encoders[index];
    struct dg_host *host = self->encoders[index].host;
    const int result =
        self->setup.check == NULL
            ? try_encoder(row, host, error)
            : self->setup.check(self->setup.ctx, index, dg_host_line_of(host)->settings, error);

    return result == 0 ? 0 : dg_plan_stand(self->setup.plan, row->line, error);
}

int dg_engine_set_encoder(struct dg_engine *self, size_t index, struct dg_plan_error *error)
{
    const struct dg_plan_encoder *row = &self->setup.plan->encoders[index];
    struct engine_encoder *encoder = &self->encoders[index];
    struct list lists[LISTS];

    encoder->end = dg_engine_end_usual;
    list_rows(self, index, lists);
    for (size_t i = 0; i < row->settings.count; i++) {
        if (set_one(self, index, lists, &row->settings.list[i], error) != 0) {
            return refuse_setting(self->setup.plan, &row->settings.list[i], error);
        }
    }
    if (row->serial == NULL) {
        count_serial(encoder);
    } else if (set_serial(self, index, error) != 0) {
        return -1;
    }
    encoder->control.serial = serial_of(encoder->host);
    set_address(encoder->host, row);
    if (check_together(self, index, error) != 0) {
        return -1;
    }
    if (row->nvm == NULL || self->setup.memory_is_host || dg_host_memory_size(encoder->host) > 0) {
        return 0;
    }
    (void)dg_plan_refuse(error, RIG_SAY("leave it out"),
                         RIG_SAY(row->model->name, " has no EEPROM"));
    (void)dg_plan_about(error, "nvm", NULL);
    return dg_plan_stand(self->setup.plan, row->nvm_line, error);
}

/* ---------------------------------------------------------------- courses */

static const struct dg_key *find_course_row(const struct dg_plan_setting *setting)
{
    return dg_course_is(setting->value) ? dg_keys_find(&dg_world_keys, setting->key) : NULL;
}

size_t dg_engine_course_count(const struct dg_plan *plan)
{
    size_t n = 0;

    for (size_t i = 0; i < plan->encoder_count; i++) {
        const struct dg_plan_settings *settings = &plan->encoders[i].settings;
        for (size_t j = 0; j < settings->count; j++) {
            n += find_course_row(&settings->list[j]) != NULL ? 1u : 0u;
        }
    }
    return n;
}

/* What can be told by the words alone is right already. */
static int begin_course(struct dg_engine *self, size_t index, const struct dg_plan_setting *setting,
                        struct dg_plan_error *error)
{
    const struct dg_key *row = find_course_row(setting);
    struct dg_course_words words;

    if (row == NULL) {
        return 0;
    }
    (void)dg_course_read(setting->value, &words, error);
    struct dg_rig_course *course = self->setup.course(self->setup.ctx, index, setting, error);
    if (course == NULL) {
        return refuse_setting(self->setup.plan, setting, error);
    }
    course->quantity = (size_t)(row - dg_world_keys.rows);
    course->course.loop = words.loop;
    course->course.steps = words.steps || dg_quantities[course->quantity].unit == DG_UNIT_STATE;
    if (dg_rig_follow(&self->control, &self->encoders[index].control, course, self->setup.begin) ==
        DG_OK) {
        self->courses[self->course_count++] = (struct engine_course){course, index};
        return 0;
    }
    (void)dg_plan_refuse(error, NULL, RIG_SAY("a loop needs a time above 0"));
    return refuse_setting(self->setup.plan, setting, error);
}

int dg_engine_begin_courses(struct dg_engine *self, struct dg_plan_error *error)
{
    int result = 0;

    for (size_t i = 0; i < self->setup.plan->encoder_count; i++) {
        const struct dg_plan_settings *settings = &self->setup.plan->encoders[i].settings;
        for (size_t j = 0; result == 0 && j < settings->count; j++) {
            result = begin_course(self, i, &settings->list[j], error);
        }
    }
    return result;
}

/* ---------------------------------------------------------------- a wire */

/* By what a kind has nobody set of it. */
static const struct {
    const void *usual;
    size_t offset;
} places[] = {
    {&dg_plan_pace_usual, LINE(pace)},
    {&dg_plan_timing_usual, LINE(timing)},
    {&dg_plan_ring_usual, LINE(ring)},
    {&dg_plan_simulation_usual, LINE(simulation)},
};

static void *settings_place_of(struct dg_engine_line *line, const struct dg_plan_wire_kind *kind)
{
    size_t i = DG_COUNT(places) - 1u;

    while (i > 0 && places[i].usual != kind->settings) {
        i--;
    }
    return (uint8_t *)line + places[i].offset;
}

/* Which keys its kind has was asked when they were given to it. */
int dg_engine_line_read(const struct dg_plan *plan, const struct dg_plan_wire *wire,
                        struct dg_engine_line *line, struct dg_plan_error *error)
{
    const struct dg_keys *keys = wire->kind->keys;
    int result = 0;

    for (size_t i = 0; result == 0 && i < wire->settings.count; i++) {
        const struct dg_plan_setting *setting = &wire->settings.list[i];
        const struct dg_key *row = keys == NULL ? NULL : dg_keys_find(keys, setting->key);
        result = row != NULL
                     ? set_value(row, settings_place_of(line, wire->kind), setting->value, error)
                     : dg_plan_refuse(error, RIG_SAY("leave it out"),
                                      RIG_SAY("the wire has no such key"));
        if (result != 0) {
            (void)refuse_setting(plan, setting, error);
        }
    }
    return result;
}
