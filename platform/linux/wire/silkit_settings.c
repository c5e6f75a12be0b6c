/* SPDX-License-Identifier: MIT */
/* What a plan says about the simulation that a rig is to join. */
#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/rig_engine.h"
#include "silkit_parts.h"

#define RIGHT "expected silkit://HOST:PORT,NETWORK or silkit://HOST:PORT,NETWORK,PARTICIPANT"

/* --- addresses --- */

/* A name of letters, digits, '_', '-' and '.'; a slash begins what stands behind it. */
static bool take_network_name(const char *from, size_t n, char to[LX_SILKIT_NAME_MAX])
{
    bool good = n > 0 && n < LX_SILKIT_NAME_MAX;
    for (size_t i = 0; good && i < n; i++) {
        good = isalnum((unsigned char)from[i]) != 0 || strchr("_-.", from[i]) != NULL;
    }
    if (good) {
        memcpy(to, from, n);
        to[n] = '\0';
    }
    return good;
}

/* HOST:PORT behind the scheme. The port of a registry cannot be any. */
static bool take_uri(const char *from, size_t n, char to[LX_SILKIT_URI_MAX])
{
    static const char scheme[] = "silkit://";
    const size_t ahead = strlen(scheme);
    if (n >= LX_SILKIT_URI_MAX || strncmp(from, scheme, ahead) != 0) {
        return false;
    }
    memcpy(to, from, n);
    to[n] = '\0';
    const char *port = strrchr(to + ahead, ':');
    if (port == NULL || port == to + ahead || port[1] == '\0' || strlen(port + 1) > 5u ||
        port[1 + strspn(port + 1, "0123456789")] != '\0') {
        return false;
    }
    const long number = strtol(port + 1, NULL, 10);
    return number > 0 && number <= UINT16_MAX && strpbrk(to + ahead, " /?#") == NULL;
}

int lx_silkit_split(const char *where, struct lx_silkit_where *out, struct lx_error *error)
{
    *out = (struct lx_silkit_where){0};
    const size_t uri = strcspn(where, ",");
    const char *network = where + uri + (where[uri] == ',' ? 1 : 0);
    const size_t n = strcspn(network, ",");
    const char *name = network[n] == ',' ? network + n + 1 : NULL;
    const bool good = take_uri(where, uri, out->uri) &&
                      take_network_name(network, n, out->network) &&
                      (name == NULL || take_network_name(name, strlen(name), out->participant));
    (void)snprintf(out->ready, sizeof out->ready, "%s,%s", out->uri, out->network);
    return good ? 0 : lx_refuse(error, RIGHT, "%s", "");
}

bool lx_silkit_is_loopback(const struct lx_silkit_where *self)
{
    static const char *const hosts[] = {"silkit://127.", "silkit://localhost:", "silkit://[::1]:"};
    bool is = false;
    for (size_t i = 0; i < DG_COUNT(hosts); i++) {
        is = is || strncmp(self->uri, hosts[i], strlen(hosts[i])) == 0;
    }
    return is;
}

/* --- the plan --- */

static int refuse_another(const char *first, const char *what, struct lx_error *error)
{
    struct lx_words right = {""};
    lx_words_add(&right, "expected %s, as for the first silkit wire", first);
    return lx_refuse(error, right.text, "a rig has one %s", what);
}

static int same_where(const struct lx_silkit *self, const struct lx_silkit_where *where,
                      struct lx_error *error)
{
    if (strcmp(self->where.uri, where->uri) != 0) {
        return refuse_another(self->where.uri, "registry", error);
    }
    if (where->participant[0] != '\0' && strcmp(lx_silkit_name(self), where->participant) != 0) {
        return refuse_another(lx_silkit_name(self), "participant", error);
    }
    return 0;
}

static int same_settings(const struct lx_silkit *self, const struct dg_plan_simulation *settings,
                         const struct dg_plan_wire *wire, struct lx_error *error)
{
    if (self->settings.time != settings->time) {
        const struct dg_key *time = dg_keys_find(wire->kind->keys, "time");
        return refuse_another(time->words[self->settings.time], "time", error);
    }
    if (self->settings.step_us != settings->step_us) {
        struct lx_words step = {""};
        lx_words_add(&step, "step_us=%lu", (unsigned long)self->settings.step_us);
        return refuse_another(step.text, "step", error);
    }
    if (self->settings.aggregate != settings->aggregate) {
        const char *first = self->settings.aggregate ? "aggregate=1" : "aggregate=0";
        return refuse_another(first, "way of sending", error);
    }
    return 0;
}

/* What a later wire leaves out is as with the first one. */
int lx_silkit_add(struct lx_silkit *self, const struct dg_plan *plan,
                  const struct dg_plan_wire *wire, struct lx_error *error)
{
    struct lx_silkit_where where;
    struct dg_engine_line line = {.simulation =
                                      self->planned ? self->settings : dg_plan_simulation_usual};
    struct dg_plan_error wrong;
    if (lx_silkit_split(wire->where, &where, error) != 0) {
        return lx_plan_refuse_wire(plan, wire, error);
    }
    if (dg_engine_line_read(plan, wire, &line, &wrong) != 0) {
        return lx_error_take(error, &wrong);
    }
    if (self->planned) {
        return same_where(self, &where, error) == 0 &&
                       same_settings(self, &line.simulation, wire, error) == 0
                   ? 0
                   : lx_plan_refuse_wire(plan, wire, error);
    }
    self->planned = true;
    self->threads = plan->threads > 0 ? plan->threads : 1u;
    self->where = where;
    self->settings = line.simulation;
    return 0;
}

bool lx_silkit_is_virtual(const struct lx_silkit *self)
{
    return self->planned && self->settings.time != DG_PLAN_REAL;
}

const char *lx_silkit_name(const struct lx_silkit *self)
{
    return self->where.participant[0] != '\0' ? self->where.participant : self->rig;
}
