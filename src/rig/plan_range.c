/* SPDX-License-Identifier: MIT */
/*
 * [encoder NAME] of a rig file, or many of them: with node = FIRST..LAST, or another protocol's key
 * of its addresses, the section stands for one for each number, NAME-FIRST to NAME-LAST. What else
 * counts, counts up.
 */
#include "drehgeber/figure.h"
#include "rig_private.h"

#include <string.h>

#define BETWEEN ".."
/* What stands in front of BETWEEN is shorter. */
#define NUMBER_MAX 15u

/* The numbers of a section. */
struct range {
    const struct dg_plan_setting *word; /* FIRST..LAST; NULL: the section is one encoder */
    const struct dg_device *model;
    int first;
    int last;
};

static const struct dg_plan_setting *find_range(const struct rig_section *self)
{
    for (size_t i = 0; i < self->count; i++) {
        const struct dg_plan_setting *word = dg_plan_word_at(self, i);
        if (dg_plan_is_address_key(word->key) && dg_plan_find(word->value, BETWEEN) != NULL) {
            return word;
        }
    }
    return NULL;
}

static int refuse_range(struct rig_reader *in, const struct range *self)
{
    struct rig_list right;

    dg_plan_list_begin(&right);
    dg_plan_say_addresses(self->model, &right.text);
    (void)dg_plan_refuse(in->error, RIG_SAY("expected ", right.room, ", or FIRST" BETWEEN "LAST"),
                         NULL);
    (void)dg_plan_about(in->error, self->word->key, self->word->value);
    return dg_plan_refuse_key(in, self->word->key, self->word->line);
}

static int take_numbers(struct rig_reader *in, struct range *self)
{
    const char *text = self->word->value;
    const char *between = dg_plan_find(text, BETWEEN);
    const size_t n = (size_t)(between - text);

    if (n > NUMBER_MAX) {
        return refuse_range(in, self);
    }
    self->first = dg_plan_address(self->model, dg_plan_cut(text, n).text);
    self->last = dg_plan_address(self->model, between + dg_plan_length(BETWEEN));
    return self->first < 0 || self->last < self->first ? refuse_range(in, self) : 0;
}

/* Number `i` of the section, as it would be written by itself. */
struct one {
    struct rig_section section;
    struct rig_number number;
    struct rig_number serial;
    char nvm[DG_PLAN_LINE_MAX + 32u];
};

/* What counts has a value of its own; everything else is that of the section. */
static const char *item_value_of(struct one *self, const struct range *range,
                                 const struct dg_plan_setting *word, int at)
{
    uint64_t serial = 0;

    if (word == range->word) {
        return self->number.text;
    }
    if (dg_plan_same(word->key, "serial") && dg_unsigned_parse(word->value, &serial)) {
        char *to = self->serial.text;
        to[dg_text_digits(to, serial + (uint64_t)(at - range->first), false, 0)] = '\0';
        return to;
    }
    if (dg_plan_same(word->key, "nvm")) {
        struct dg_text nvm = dg_text_in(self->nvm, sizeof self->nvm);
        dg_plan_add(&nvm, RIG_SAY(word->value, ".", self->number.text));
        return self->nvm;
    }
    return word->value;
}

static int take_one(struct rig_reader *in, const struct rig_section *all, const struct range *range,
                    int at, struct one *self)
{
    char text[sizeof all->name + sizeof self->number];
    struct dg_text name = dg_text_in(text, sizeof text);

    self->number = dg_plan_address_text(range->model, at);
    for (size_t i = 0; i < all->count; i++) {
        *dg_plan_word_at(&self->section, i) = *dg_plan_word_at(all, i);
        dg_plan_word_at(&self->section, i)->value =
            item_value_of(self, range, dg_plan_word_at(all, i), at);
    }
    dg_plan_add(&name, RIG_SAY(all->name, "-", self->number.text));
    if (!dg_plan_name_fits(text)) {
        return dg_plan_wrong_section(in, all, RIG_SAY("expected a shorter name"),
                                     RIG_SAY(text, " is too long for a name"));
    }
    memcpy(self->section.name, text, name.length + 1u);
    return dg_plan_take_encoder(in, &self->section);
}

/* The words of each lie behind those of all. */
static int take_all(struct rig_reader *in, const struct rig_section *all, const struct range *range)
{
    struct dg_plan *plan = in->plan;
    const size_t size = all->count * sizeof(struct dg_plan_setting);
    struct one one = {.section = *all};
    int result = 0;

    if ((size_t)(plan->end - plan->at) < size) {
        plan->out = true;
        return -1;
    }
    one.section.words -= all->count;
    plan->end -= size;
    for (int at = range->first; result == 0 && at <= range->last; at++) {
        result = take_one(in, all, range, at, &one);
    }
    plan->end += size;
    return result;
}

int dg_plan_take_encoders(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan_setting *model = dg_plan_word(self, "model");
    struct range range = {.word = find_range(self)};

    if (range.word == NULL) {
        return dg_plan_take_encoder(in, self);
    }
    if (dg_plan_take_name(in, model, &range.model) != 0) {
        return -1;
    }
    if (range.model == NULL) {
        return dg_plan_take_encoder(in, self); /* which says what is wrong */
    }
    const char *key = range.model->stack->address_key;
    if (key == NULL || !dg_plan_same(key, range.word->key)) {
        return dg_plan_take_encoder(in, self); /* which says that it has none */
    }
    const struct dg_plan_setting *wire = dg_plan_word(self, "wire");
    if (wire != NULL) {
        return dg_plan_wrong_word(in, wire, RIG_SAY("expected bus = NAME of a [bus] above"),
                                  RIG_SAY("several encoders have no wire of their own"));
    }
    return take_numbers(in, &range) == 0 ? take_all(in, self, &range) : -1;
}
