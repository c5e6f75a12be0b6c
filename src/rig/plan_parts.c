/* SPDX-License-Identifier: MIT */
/*
 * The plan and its memory, which is taken from the front for what stays, and from the back for the
 * words of sections that are being read. Rows of a list lie behind each other: a list that is full
 * moves to twice the room, and what it leaves behind is lost.
 */
#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "rig_private.h"

#include <limits.h>
#include <string.h>

/* What any object may be aligned to; memory begins so. */
#define ALIGN (2u * sizeof(void *))

void *dg_plan_reserve(struct dg_plan *self, size_t size)
{
    const size_t before = (size_t)(0u - (uintptr_t)self->at) % ALIGN;
    const size_t free = (size_t)(self->end - self->at);

    if (self->at == NULL || free < before || free - before < size) {
        self->out = true;
        return NULL;
    }
    void *found = memset(self->at + before, 0, size);
    self->at += before + size;
    return found;
}

void *dg_plan_grow(struct dg_plan *self, void *list, size_t count, size_t size)
{
    if (count > 0 && (count & (count - 1u)) != 0) {
        return list;
    }
    void *rows =
        count >= INT_MAX ? NULL : dg_plan_reserve(self, (count == 0 ? 1u : 2u * count) * size);
    if (rows != NULL && count > 0) {
        memcpy(rows, list, count * size);
    }
    return rows;
}

char *dg_plan_keep(struct dg_plan *self, const char *text, size_t n)
{
    if (self->at == NULL || (size_t)(self->end - self->at) <= n) {
        self->out = true;
        return NULL;
    }
    char *kept = memcpy(self->at, text, n);
    kept[n] = '\0';
    self->at += n + 1u;
    return kept;
}

const char *dg_plan_copy(struct dg_plan *self, const char *text)
{
    return dg_plan_keep(self, text, dg_plan_length(text));
}

bool dg_plan_make_settings(struct dg_plan *self, struct dg_plan_settings *to, size_t count)
{
    *to = (struct dg_plan_settings){.count = count};
    to->list = count == 0 ? NULL : dg_plan_reserve(self, count * sizeof *to->list);
    to->count = to->list == NULL ? 0 : count;
    return to->count == count;
}

void dg_plan_begin(struct dg_plan *self, void *memory, size_t size)
{
    /* Words stand at the back, each an object. */
    const size_t rest = (size_t)((uintptr_t)memory + size) % ALIGN;
    const size_t used = memory == NULL || size < rest ? 0 : size - rest;

    *self = (struct dg_plan){.memory = memory, .at = memory, .end = (unsigned char *)memory + used};
}

/* ---------------------------------------------------------------- rows */

/* What a row is called: a copy, which the names borrow. @return its index, or -1 */
static int name_row(struct dg_plan *self, const char **to, uint8_t list, const char *text,
                    size_t count)
{
    const int index = (int)count - 1;

    *to = dg_plan_copy(self, text);
    const struct dg_plan_name name = {.list = list, .text = *to, .index = index};
    return *to != NULL && dg_plan_names_add(self, &name) == 0 ? index : -1;
}

/* A copy; NULL stays NULL. @return false: the memory is full */
static bool copy_text(struct dg_plan *self, const char **to, const char *text)
{
    *to = text == NULL ? NULL : dg_plan_copy(self, text);
    return text == NULL || *to != NULL;
}

int dg_plan_add_shaft(struct dg_plan *self, const char *name, const char *motion)
{
    struct dg_plan_shaft *list = dg_plan_grow(self, self->shafts, self->shaft_count, sizeof *list);

    if (list == NULL) {
        return -1;
    }
    self->shafts = list;
    struct dg_plan_shaft *row = &list[self->shaft_count++];
    *row = (struct dg_plan_shaft){.driver = -1, .ratio = {1, 1}};
    return copy_text(self, &row->motion, motion)
               ? name_row(self, &row->name, RIG_SHAFT, name, self->shaft_count)
               : -1;
}

int dg_plan_add_wire(struct dg_plan *self, const char *name, const struct dg_plan_wire_kind *kind,
                     const char *where)
{
    struct dg_plan_wire *list = dg_plan_grow(self, self->wires, self->wire_count, sizeof *list);

    if (list == NULL) {
        return -1;
    }
    self->wires = list;
    struct dg_plan_wire *row = &list[self->wire_count++];
    *row = (struct dg_plan_wire){.kind = kind};
    return copy_text(self, &row->where, where)
               ? name_row(self, &row->name, RIG_WIRE, name, self->wire_count)
               : -1;
}

int dg_plan_add_encoder(struct dg_plan *self, const char *name, const struct dg_device *model,
                        size_t shaft, size_t wire)
{
    struct dg_plan_encoder *list =
        dg_plan_grow(self, self->encoders, self->encoder_count, sizeof *list);

    if (list == NULL) {
        return -1;
    }
    self->encoders = list;
    struct dg_plan_encoder *row = &list[self->encoder_count++];
    *row = (struct dg_plan_encoder){
        .model = model, .shaft = shaft, .wire = wire, .address = DG_PLAN_AS_DELIVERED};
    struct dg_plan_wire *on = &self->wires[wire];
    on->stack = model->stack;
    on->encoder_count++;
    const int index = name_row(self, &row->name, RIG_ENCODER, name, self->encoder_count);
    const struct dg_plan_name alias = {.list = RIG_ALIAS, .text = row->name, .index = index};
    return index >= 0 && dg_plan_names_add(self, &alias) == 0 ? index : -1;
}

static int find_name(const struct dg_plan *self, uint8_t list, const char *name)
{
    return dg_plan_names_find(self, &(struct dg_plan_name){.list = list, .text = name});
}

int dg_plan_find_shaft(const struct dg_plan *self, const char *name)
{
    return find_name(self, RIG_SHAFT, name);
}

int dg_plan_find_wire(const struct dg_plan *self, const char *name)
{
    return find_name(self, RIG_WIRE, name);
}

int dg_plan_find_encoder(const struct dg_plan *self, const char *name)
{
    const int index = find_name(self, RIG_ENCODER, name);

    return index < 0 ? find_name(self, RIG_ALIAS, name) : index;
}

dg_plan_line dg_plan_setting_line(const struct dg_plan_encoder *encoder, const char *key)
{
    for (size_t i = 0; i < encoder->settings.count; i++) {
        if (dg_plan_same(encoder->settings.list[i].key, key)) {
            return encoder->settings.list[i].line;
        }
    }
    return encoder->line;
}

/* ---------------------------------------------------------------- kinds of wires, addresses */

bool dg_plan_is_path(const struct dg_plan_wire_kind *kind, const char *where)
{
    return kind->where_is_path && where != NULL &&
           !(kind->where_may_be_tcp && dg_plan_begins(where, "tcp:"));
}

bool dg_plan_carries(const struct dg_plan_wire_kind *kind, const struct dg_stack *stack)
{
    return (kind->media >> stack->medium & 1u) != 0;
}

bool dg_plan_is_address_key(const char *key)
{
    bool found = false;

    for (size_t i = 0; i < dg_device_count && !found; i++) {
        const char *own = dg_devices[i]->stack->address_key;
        found = own != NULL && dg_plan_same(own, key);
    }
    return found;
}

const struct dg_key *dg_plan_address_row(const struct dg_device *model)
{
    const char *key = model->stack->address_key;

    return key == NULL ? NULL : dg_keys_find(dg_host_wire_of(model)->keys, key);
}

static void add_address(const struct dg_device *model, int address, struct dg_text *to)
{
    if (model->stack->address_hex) {
        dg_text_add(to, "0x");
        dg_text_add_hex(to, (uint64_t)address, 2);
    } else {
        dg_text_add_number(to, address);
    }
}

struct rig_number dg_plan_address_text(const struct dg_device *model, int address)
{
    struct rig_number number = {.text = ""};
    struct dg_text text = dg_text_in(number.text, sizeof number.text);

    add_address(model, address, &text);
    return number;
}

void dg_plan_say_addresses(const struct dg_device *model, struct dg_text *to)
{
    const struct dg_key *row = dg_plan_address_row(model);

    if (row == NULL) {
        return; /* it has none */
    }
    dg_text_add(to, model->stack->address_what);
    dg_text_add(to, " in ");
    add_address(model, (int)row->min, to);
    dg_text_add(to, "..");
    add_address(model, (int)row->max, to);
}

/* ---------------------------------------------------------------- places */

/* Characters of the folder, with '/'. */
static size_t folder_of(const char *file)
{
    size_t folder = 0;

    for (size_t i = 0; file != NULL && file[i] != '\0'; i++) {
        folder = file[i] == '/' ? i + 1u : folder;
    }
    return folder;
}

static const struct dg_plan_piece *piece_of(const struct dg_plan *self, dg_plan_line line)
{
    size_t low = 0;
    size_t high = self->piece_count;

    while (high - low > 1u) {
        const size_t middle = low + (high - low) / 2u;
        *(self->pieces[middle].first <= line ? &low : &high) = middle;
    }
    return &self->pieces[low];
}

static size_t source_of(const struct dg_plan *self, dg_plan_line line)
{
    return self->piece_count == 0 ? 0 : piece_of(self, line)->source;
}

struct dg_plan_place dg_plan_place(const struct dg_plan *self, dg_plan_line line)
{
    struct dg_plan_place place = {self->file, line, folder_of(self->file)};

    if (self->piece_count > 0 && line > 0) {
        const struct dg_plan_piece *piece = piece_of(self, line);
        place.file = self->sources[piece->source].file;
        place.line = line - piece->first + piece->first_in_file;
        place.folder = folder_of(place.file);
    }
    return place;
}

void dg_plan_say_files(const struct dg_plan *self, dg_plan_line line, struct dg_text *to)
{
    dg_plan_line lines[DG_PLAN_DEPTH_MAX];
    size_t depth = 0;

    for (size_t at = source_of(self, line); at > 0; at = self->sources[at].parent) {
        lines[depth++] = self->sources[at].line;
    }
    while (depth > 0) {
        const struct dg_plan_place place = dg_plan_place(self, lines[--depth]);
        dg_plan_add(to, RIG_SAY(place.file, ":", dg_plan_number(place.line).text, ": "));
    }
    dg_text_add(to, dg_plan_place(self, line).file);
}

/* ---------------------------------------------------------------- reading */

/* Models for other files, and nothing that would run. */
static bool is_catalogue(const struct dg_plan *plan)
{
    return plan->model_count > 0 && plan->shaft_count == 0 && plan->wire_count == 0;
}

/* What only the end of the text tells. */
static int check_whole(struct rig_reader *in)
{
    const struct dg_plan *plan = in->plan;

    for (size_t i = 0; i < plan->wire_count; i++) {
        const struct dg_plan_wire *wire = &plan->wires[i];
        if (wire->encoder_count == 0) {
            return dg_plan_wrong_line(
                in, wire->line,
                RIG_SAY("expected bus = ", wire->name, " in an [encoder NAME], or no such bus"),
                RIG_SAY("[bus ", wire->name, "]: without encoders"));
        }
    }
    return plan->encoder_count > 0 || is_catalogue(plan)
               ? 0
               : dg_plan_refuse(
                     in->error,
                     RIG_SAY("expected [encoder NAME] with model = MODEL and wire = KIND"),
                     RIG_SAY(plan->file, ": without encoders"));
}

/* The file's name without its folder and its ending. */
static const char *rig_name_of(struct dg_plan *self)
{
    const char *base = self->file + folder_of(self->file);
    const size_t length = dg_plan_length(base);
    size_t n = length;

    while (n > 0 && base[n] != '.') {
        n--;
    }
    return dg_plan_keep(self, base, n == 0 ? length : n);
}

static int read_sections(struct rig_reader *in)
{
    if (dg_plan_read_lines(in) != 0 || check_whole(in) != 0) {
        return -1;
    }
    in->plan->name = in->plan->name == NULL ? rig_name_of(in->plan) : in->plan->name;
    return in->plan->name == NULL ? -1 : 0;
}

int dg_plan_read(struct dg_plan *self, const struct dg_plan_setup *setup,
                 struct dg_plan_error *error)
{
    struct rig_reader in = {.plan = self, .setup = setup, .error = error};

    if (setup->size != sizeof *setup || setup->file == NULL) {
        *self = (struct dg_plan){.file = NULL};
        return dg_plan_refuse(error, NULL, RIG_SAY("not a setup of this version"));
    }
    dg_plan_begin(self, setup->memory, setup->memory_size);
    self->file = setup->file;
    self->find_model = setup->find_model;
    self->ctx = setup->ctx;
    const int result = read_sections(&in);
    self->find_model = NULL; /* whoever finds them has gone when this returns */
    if (result == 0) {
        return DG_OK;
    }
    const bool out = self->out;
    *self = (struct dg_plan){.file = NULL};
    return out ? DG_ERR_SPACE : DG_ERR_ARGUMENT;
}
