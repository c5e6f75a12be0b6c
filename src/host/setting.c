/* SPDX-License-Identifier: MIT */
/*
 * Settings by name, of two lists: the encoder's, the world's.
 */
#include "host_private.h"

#include "drehgeber/quantity.h"

enum { OWN, WORLD, LISTS };

static const struct dg_keys *list_of(const struct dg_host *self, unsigned list)
{
    return list == WORLD ? &dg_world_keys : self->refs.wire->keys;
}

static bool has_quantity(const struct dg_host *self, size_t row)
{
    const struct dg_stack *stack = self->refs.device->stack;

    return (self->refs.wire->blind >> row & 1u) == 0 &&
           (!dg_quantities[row].multiturn || stack->senses_multiturn(self->refs.device->model));
}

static bool has(const struct dg_host *self, unsigned list, size_t row)
{
    const uint32_t without =
        self->refs.wire->without != NULL ? self->refs.wire->without(self->line.settings) : 0;

    if (list == WORLD) {
        return has_quantity(self, row);
    }
    return (without >> row & 1u) == 0;
}

/* @return the row, with its list, or NULL */
static const struct dg_key *find_setting(const struct dg_host *self, const char *name,
                                         unsigned *list)
{
    for (*list = 0; *list < LISTS; ++*list) {
        const struct dg_keys *keys = list_of(self, *list);
        const struct dg_key *key = dg_keys_find(keys, name);
        if (key != NULL && has(self, *list, (size_t)(key - keys->rows))) {
            return key;
        }
    }
    return NULL;
}

static uint8_t type_of(const struct dg_key *key)
{
    if (key->type == DG_KEY_FLAG || key->type == DG_KEY_WORD) {
        return DG_HOST_KEY_WORD;
    }
    return key->type == DG_KEY_TEXT || key->type == DG_KEY_DIGITS ? DG_HOST_KEY_TEXT
                                                                  : DG_HOST_KEY_NUMBER;
}

int dg_host_key(const struct dg_host *self, size_t index, struct dg_host_key *to)
{
    for (unsigned list = 0; list < LISTS; list++) {
        const struct dg_keys *keys = list_of(self, list);
        for (size_t row = 0; row < keys->count; row++) {
            const struct dg_key *key = &keys->rows[row];
            if (has(self, list, row) && index-- == 0) {
                *to = (struct dg_host_key){.name = key->name,
                                           .unit = key->unit,
                                           .help = key->help,
                                           .min = key->min,
                                           .max = key->max,
                                           .type = type_of(key),
                                           .places = key->places,
                                           .always = list == WORLD};
                return DG_HOST_OK;
            }
        }
    }
    return DG_HOST_ERR_NAME;
}

const char *dg_host_word(const struct dg_host *self, const char *name, size_t index)
{
    unsigned list = 0;
    const struct dg_key *key = find_setting(self, name, &list);
    const bool word = key != NULL && type_of(key) == DG_HOST_KEY_WORD;

    return word && index <= (size_t)key->max ? key->words[index] : NULL;
}

int dg_host_set(struct dg_host *self, const char *name, const char *value)
{
    unsigned list = 0;
    const struct dg_key *key = find_setting(self, name, &list);

    if (key == NULL) {
        return DG_HOST_ERR_NAME;
    }
    if (list != WORLD && self->made) {
        return DG_HOST_ERR_STATE;
    }
    const int result =
        dg_key_set(key, list == WORLD ? (void *)&self->world : self->line.settings, value);
    if (result == DG_OK && list == WORLD) {
        dg_host_run(self, self->line.now);
    }
    return result;
}

int dg_host_get(const struct dg_host *self, const char *name, char *to, size_t size)
{
    unsigned list = 0;
    const struct dg_key *key = find_setting(self, name, &list);

    if (key == NULL) {
        return DG_HOST_ERR_NAME;
    }
    return dg_key_get(key, list == WORLD ? (const void *)&self->world : self->line.settings, to,
                      size);
}

/* ------------------------------------------------------------ the world */

static const struct dg_quantity *quantity(const struct dg_host *self, const char *name)
{
    const struct dg_key *key = dg_keys_find(&dg_world_keys, name);
    const size_t row = key != NULL ? (size_t)(key - dg_world_keys.rows) : 0;

    return key != NULL && has_quantity(self, row) ? &dg_quantities[row] : NULL;
}

int dg_host_world_set(struct dg_host *self, uint64_t now, const char *name, int64_t value)
{
    const struct dg_quantity *row = quantity(self, name);

    if (row == NULL) {
        return DG_HOST_ERR_NAME;
    }
    if (value < row->min || value > row->max) {
        return DG_HOST_ERR_ARGUMENT;
    }
    dg_host_run(self, now);
    if (self->refs.faults != NULL) {
        self->refs.faults->overridden(self->refs.faults_ctx, row->offset);
    }
    dg_quantity_set(row, &self->world, value);
    dg_host_run(self, now);
    return DG_HOST_OK;
}

int dg_host_world_get(const struct dg_host *self, const char *name, int64_t *value)
{
    const struct dg_quantity *row = quantity(self, name);

    if (row == NULL) {
        return DG_HOST_ERR_NAME;
    }
    *value = dg_quantity_get(row, &self->world);
    return DG_HOST_OK;
}
