/* SPDX-License-Identifier: MIT */
#include "canopen.h"

#include <string.h>

#include "number.h"

/* As delivered (manual, chapter 8). */
#define NODE_ID_DEFAULT 63u
#define NODE_ID_MAX 127u
#define SERIAL_DEFAULT 1234567890u
#define SERIAL_DIGITS 10u

/* A decimal number of at most `max_digits` digits at the start of `text`. @return its end or NULL
 */
static const char *take_number(const char *text, size_t max_digits, uint64_t *value)
{
    struct lx_decimal number = {0};
    const size_t n = strspn(text, "0123456789");
    if (n == 0 || n > max_digits || !lx_decimal_parse(text, n, 0, &number)) {
        return NULL;
    }
    *value = (uint64_t)number.value;
    return text + n;
}

static int take_nodes(const char *text, struct lx_can_nodes_setup *setup, struct lx_error *error)
{
    uint64_t first = 0;
    uint64_t last = 0;
    const char *end = take_number(text, 3, &first);
    last = first;
    if (end != NULL && strncmp(end, "..", 2) == 0) {
        end = take_number(end + 2, 3, &last);
    }
    if (end == NULL || *end != '\0' || first < 1 || last < first || last > NODE_ID_MAX) {
        return lx_fail(error, "--node %s: a node-ID, or first..last, in 1..127 is right", text);
    }
    setup->first = (uint8_t)first;
    setup->last = (uint8_t)last;
    return 0;
}

static int take_serial(const char *text, struct lx_can_nodes_setup *setup, struct lx_error *error)
{
    uint64_t serial = 0;
    const char *end = take_number(text, SERIAL_DIGITS, &serial);
    const uint64_t max = UINT32_MAX - (uint64_t)(setup->last - setup->first);
    if (end == NULL || *end != '\0' || serial > max) {
        return lx_fail(error, "--serial %s: a number up to %llu is right", text,
                       (unsigned long long)max);
    }
    setup->serial = (uint32_t)serial;
    setup->serial_given = true;
    return 0;
}

int canopen_understand(const struct options *options, struct lx_can_nodes_setup *setup,
                       struct lx_error *error)
{
    setup->first = NODE_ID_DEFAULT;
    setup->last = NODE_ID_DEFAULT;
    setup->serial = SERIAL_DEFAULT;
    if (options->node != NULL && take_nodes(options->node, setup, error) != 0) {
        return -1;
    }
    return options->serial == NULL ? 0 : take_serial(options->serial, setup, error);
}

int canopen_set(struct dg_cia406_model *model, const char *assignment, struct lx_error *error)
{
    static const char key[] = "mt_bits=";
    const char *value = assignment + strlen(key);
    if (strncmp(assignment, key, strlen(key)) != 0) {
        return 0;
    }
    const bool wide = strcmp(value, "16") == 0;
    if (model->turns == 1 || (!wide && strcmp(value, "12") != 0)) {
        return lx_fail(error, "--set %s: 12 or 16 is right, with f3668", assignment);
    }
    model->turns = wide ? 65536u : 4096u;
    model->device = wide ? &dg_cia406_multiturn_32 : &dg_cia406_multiturn;
    return 1;
}
