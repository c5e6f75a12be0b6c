/* SPDX-License-Identifier: MIT */
/*
 * One encoder, several nodes of one model, or a ring: a plan with one shaft and one wire. All
 * encoders get the same settings; what counts (node-IDs, serial numbers, files) counts up.
 */
#define _GNU_SOURCE
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "access.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/figure.h"
#include "drehgeber/interbus.h"
#include "eds_file.h"
#include "options.h"
#include "trace.h"
#include "wire.h"

/* Node-IDs asked for; 0: as delivered. */
struct nodes {
    unsigned first;
    unsigned last;
};

static int no_memory(struct lx_error *error)
{
    return lx_fail(error, "no memory for so many encoders");
}

/* --- models --- */

static int unknown_model(const struct options *options, struct lx_error *error)
{
    struct lx_words right = {"valid:"};
    if (options->unread.what[0] != '\0' || options->unread.right[0] != '\0') {
        *error = options->unread; /* it may be in a file that nobody could read */
        return -1;
    }
    lx_stack_models(NULL, &right);
    lx_words_add(&right, ", RIG.ini or MODELS.ini");
    return options->model == NULL
               ? lx_refuse(error, right.text, "%s needs a model or a rig file", options->row->name)
               : lx_refuse(error, right.text, "unknown model %s", options->model);
}

/* The one protocol that has rings. */
static const struct lx_stack *ring_stack(void)
{
    size_t i = 0;
    while (!lx_stacks[i]->is_ring) {
        i++;
    }
    return lx_stacks[i];
}

/* The model that the first `n` characters name, which belongs into a ring; `asked`: of --ring. */
static const struct dg_device *ring_model(const char *name, size_t n, const char *asked,
                                          struct lx_error *error)
{
    char text[32] = "";
    if (n < sizeof text) {
        memcpy(text, name, n);
    }
    const struct dg_device *device = dg_device_find(text);
    if (device != NULL && lx_stack_of(device)->is_ring) {
        return device;
    }
    struct lx_words right = {"valid:"};
    lx_stack_models(ring_stack(), &right);
    lx_words_add(&right, ", several with commas between them");
    (void)lx_refuse(error, right.text, "'%.*s' is no %s model", (int)n, name,
                    ring_stack()->trace->title);
    (void)lx_about(error, LX_ABOUT_KEY, "ring", asked);
    return NULL;
}

static const struct dg_device *the_model(const struct options *options, struct lx_error *error)
{
    const struct dg_device *device = options->device;
    if (options->ring != NULL && options->model != NULL) {
        return ring_model(options->model, strlen(options->model), options->ring, error);
    }
    if (options->ring != NULL) {
        return ring_model(options->ring, strcspn(options->ring, ","), options->ring, error);
    }
    if (device == NULL) {
        (void)unknown_model(options, error);
    }
    return device;
}

/* --- encoders --- */

/* `digits` plus `offset`; what is no number stays as it is, for the wire to refuse. */
static char *counted(const char *digits, unsigned offset)
{
    uint64_t number = 0;
    char *text = NULL;
    if (offset == 0 || digits[strspn(digits, "0123456789")] != '\0' ||
        !dg_unsigned_parse(digits, &number)) {
        return strdup(digits);
    }
    return asprintf(&text, "%" PRIu64, number + offset) < 0 ? NULL : text;
}

/* Those of the wire itself, or all others. @return false without memory */
static bool pick_settings(const struct options *options, struct dg_plan *plan, bool of_wire,
                          struct dg_plan_settings *to)
{
    const struct dg_plan_wire_kind *wire = plan->wires[0].kind;
    const bool made = dg_plan_make_settings(plan, to, options->settings.count);
    to->count = 0;
    for (size_t i = 0; made && i < options->settings.count; i++) {
        const struct dg_plan_setting *row = &options->settings.list[i];
        if (dg_plan_wire_has(wire, row->key) == of_wire) {
            to->list[to->count++] = *row;
        }
    }
    return made;
}

/* Settings of the wire itself go to the wire, once. All encoders share theirs, which the options
   keep. */
static int add_settings(const struct options *options, struct dg_plan *plan,
                        struct dg_plan_encoder *encoder, struct lx_error *error)
{
    if (encoder != plan->encoders) {
        encoder->settings = plan->encoders[0].settings;
        return 0;
    }
    return pick_settings(options, plan, true, &plan->wires[0].settings) &&
                   pick_settings(options, plan, false, &encoder->settings)
               ? 0
               : no_memory(error);
}

/* "MODEL-NUMBER"; a negative number: there are no others of its model. */
static char *name_of(const struct dg_device *device, int number)
{
    char *name = NULL;
    if (number < 0) {
        return strdup(device->name);
    }
    return asprintf(&name, "%s-%d", device->name, number) < 0 ? NULL : name;
}

static struct dg_plan_encoder *add_encoder(const struct options *options, struct dg_plan *plan,
                                           const struct dg_device *device, int number,
                                           struct lx_error *error)
{
    const unsigned offset = (unsigned)plan->encoder_count;
    char *serial = options->serial == NULL ? NULL : counted(options->serial, offset);
    char *name = name_of(device, number);
    const char *kept = serial == NULL ? NULL : dg_plan_copy(plan, serial);
    const int at = name == NULL || (options->serial != NULL && kept == NULL)
                       ? -1
                       : dg_plan_add_encoder(plan, name, device, 0, 0);
    free(name);
    free(serial);
    if (at < 0) {
        (void)no_memory(error);
        return NULL;
    }
    struct dg_plan_encoder *encoder = &plan->encoders[at];
    encoder->serial = kept;
    return add_settings(options, plan, encoder, error) == 0 ? encoder : NULL;
}

/* --- one encoder, or a ring --- */

static int plan_one(const struct options *options, struct dg_plan *plan,
                    const struct dg_device *device, struct lx_error *error)
{
    struct dg_plan_encoder *encoder = add_encoder(options, plan, device, -1, error);
    if (encoder == NULL) {
        return -1;
    }
    encoder->nvm = options->nvm;
    return 0;
}

/* All devices of a ring share one file. */
static int plan_ring(const struct options *options, struct dg_plan *plan, struct lx_error *error)
{
    const size_t most = plan->wires[0].kind->stations_max;
    const char *at = options->ring;
    for (bool more = true; more;) {
        const size_t n = strcspn(at, ",");
        const struct dg_device *device = ring_model(at, n, at, error);
        if (device == NULL) {
            return -1;
        }
        if (plan->encoder_count == most) {
            (void)lx_refuse(error, "expected fewer", "more than %lu devices", (unsigned long)most);
            return lx_about(error, LX_ABOUT_KEY, "ring", "...");
        }
        struct dg_plan_encoder *encoder =
            add_encoder(options, plan, device, (int)plan->encoder_count, error);
        if (encoder == NULL) {
            return -1;
        }
        encoder->nvm = options->nvm;
        more = at[n] != '\0';
        at += n + 1;
    }
    return 0;
}

/* --- CANopen nodes --- */

/* A decimal node-ID of at most 3 digits at the start of `text`. @return its end or NULL */
static const char *take_node_id(const char *text, unsigned *node)
{
    struct dg_decimal number = {0};
    const size_t n = strspn(text, "0123456789");
    if (n == 0 || n > 3 || !dg_decimal_parse(text, n, 0, &number)) {
        return NULL;
    }
    *node = (unsigned)number.value;
    return text + n;
}

static int take_nodes(const char *text, const struct dg_device *device, struct nodes *nodes,
                      struct lx_error *error)
{
    if (text == NULL) {
        return 0;
    }
    const struct dg_key *row = dg_plan_address_row(device);
    char range[64];
    struct dg_text right = dg_text_in(range, sizeof range);
    const char *end = take_node_id(text, &nodes->first);
    nodes->last = nodes->first;
    if (end != NULL && strncmp(end, "..", 2) == 0) {
        end = take_node_id(end + 2, &nodes->last);
    }
    if (end == NULL || *end != '\0' || nodes->first < row->min || nodes->last < nodes->first ||
        nodes->last > row->max) {
        dg_text_add(&right, "expected ");
        dg_plan_say_addresses(device, &right);
        dg_text_add(&right, ", or first..last");
        (void)lx_refuse(error, range, "%s", "");
        return lx_about(error, LX_ABOUT_KEY, row->name, text);
    }
    return 0;
}

/* Several nodes have a file each, FILE.NODE. */
static int add_node(const struct options *options, struct dg_plan *plan,
                    const struct dg_device *device, const struct nodes *nodes, unsigned node,
                    struct lx_error *error)
{
    const bool alone = nodes->first == nodes->last;
    struct dg_plan_encoder *encoder =
        add_encoder(options, plan, device, alone ? -1 : (int)node, error);
    if (encoder == NULL) {
        return -1;
    }
    if (node != 0) {
        encoder->address = (int)node;
    }
    if (alone || options->nvm == NULL) {
        encoder->nvm = options->nvm;
        return 0;
    }
    char *nvm = NULL;
    if (asprintf(&nvm, "%s.%u", options->nvm, node) < 0) {
        return no_memory(error);
    }
    encoder->nvm = dg_plan_copy(plan, nvm);
    free(nvm);
    return encoder->nvm == NULL ? no_memory(error) : 0;
}

static int plan_nodes(const struct options *options, struct dg_plan *plan,
                      const struct dg_device *device, struct lx_error *error)
{
    struct nodes nodes = {0, 0};
    int result = take_nodes(options->node, device, &nodes, error);
    for (unsigned node = nodes.first; result == 0 && node <= nodes.last; node++) {
        result = add_node(options, plan, device, &nodes, node, error);
    }
    return result;
}

/* --- the whole --- */

static int take_controls(const struct options *options, struct dg_plan *plan,
                         struct lx_error *error)
{
    struct lx_access access;
    for (size_t i = 0; i < options->control_count; i++) {
        if (plan->control_count == DG_PLAN_CONTROLS_MAX) {
            (void)lx_refuse(error, "expected fewer", "one more than %u", DG_PLAN_CONTROLS_MAX);
            return lx_about(error, LX_ABOUT_KEY, "control", options->controls[i]);
        }
        if (lx_access_parse(options->controls[i], &access, error) != 0) {
            return lx_about(error, LX_ABOUT_KEY, "control", NULL);
        }
        const bool token = access.token_file[0] != '\0';
        struct dg_plan_control *to = &plan->controls[plan->control_count++];
        *to = (struct dg_plan_control){
            .where = dg_plan_copy(plan, access.where),
            .token_file = token ? dg_plan_copy(plan, access.token_file) : NULL,
            .tcp = access.tcp,
            .open = access.open,
        };
        if (to->where == NULL || (token && to->token_file == NULL)) {
            return no_memory(error);
        }
    }
    return 0;
}

/* The shaft and the wire, which all share. Texts of options are kept by them. */
static int begin_plan(const struct options *options, struct dg_plan *plan,
                      const struct dg_device *device, struct lx_error *error)
{
    const char *name = options->ring != NULL ? "ring" : device->name;
    const struct dg_plan_wire_kind *wire = options_wire(options, device, error);
    if (wire == NULL || lx_plan_make(plan, error) != 0) {
        return -1;
    }
    const char *where = options->where == NULL ? wire->usual : options->where;
    plan->name = name;
    if (dg_plan_add_shaft(plan, "main", options->shaft) < 0 ||
        dg_plan_add_wire(plan, name, wire, where) < 0) {
        return no_memory(error);
    }
    plan->wires[0].trace = options->trace;
    return 0;
}

bool options_numbered(const struct lx_stack *stack)
{
    return stack->core->address_key != NULL && strcmp(stack->core->address_key, "node") == 0;
}

static int plan_model(const struct options *options, struct dg_plan *plan, struct lx_error *error)
{
    const struct dg_device *device = the_model(options, error);
    if (device == NULL || begin_plan(options, plan, device, error) != 0) {
        return -1;
    }
    if (options_numbered(lx_stack_of(device))) {
        return plan_nodes(options, plan, device, error);
    }
    if (options->node != NULL) {
        (void)lx_refuse(error, "leave it out", "%s has no node-ID", device->name);
        return lx_about(error, LX_ABOUT_KEY, "node", options->node);
    }
    return options->ring != NULL ? plan_ring(options, plan, error)
                                 : plan_one(options, plan, device, error);
}

/* What belongs into the rig file then. @return the option, or NULL */
static const char *not_with_rig(const struct options *options)
{
    const struct {
        const char *name;
        bool given;
    } rows[] = {
        {"set", options->settings.count > 0}, {"nvm", options->nvm != NULL},
        {"serial", options->serial != NULL},  {"node", options->node != NULL},
        {"shaft", options->shaft != NULL},    {"trace", options->trace != NULL},
        {"ring", options->ring != NULL},
    };
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        if (rows[i].given) {
            return rows[i].name;
        }
    }
    return options->wire == NULL ? NULL : options->wire->name;
}

/* A file of models is none: it says what MODEL is. */
static bool is_rig_file(const struct options *self)
{
    return self->model != NULL && self->models == NULL && self->device == NULL &&
           !eds_file_is(self->model) && models_is_file(self->model);
}

/* What nobody could read may be a file of models: what is wrong in it is said first. */
static bool is_read(const struct options *self)
{
    return self->file != NULL && self->file->plan.memory != NULL;
}

/* The plan is the caller's now. */
static int take_rig(const struct options *self, struct dg_plan *plan, struct lx_error *error)
{
    if (!is_read(self)) {
        *error = self->unread;
        return -1;
    }
    *plan = self->file->plan;
    self->file->plan = (struct dg_plan){.file = NULL};
    return 0;
}

int options_plan(const struct options *self, struct dg_plan *plan, struct lx_error *error)
{
    *plan = (struct dg_plan){.file = NULL};
    int result = 0;
    if (!is_rig_file(self)) {
        result = plan_model(self, plan, error);
    } else if (not_with_rig(self) != NULL && is_read(self)) {
        struct lx_words right = {""};
        lx_words_add(&right, "set it in %s", self->model);
        result = lx_refuse(error, right.text, "--%s: not with a rig file", not_with_rig(self));
    } else {
        result = take_rig(self, plan, error);
    }
    if (result == 0) {
        result = take_controls(self, plan, error);
    }
    if (result == 0 && self->files != NULL) {
        plan->files_line = 0;
        plan->files = self->files;
    }
    if (result != 0) {
        lx_plan_free(plan);
    }
    return result;
}
