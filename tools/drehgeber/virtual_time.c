/* SPDX-License-Identifier: MIT */
#include "virtual_time.h"

#include <string.h>
#include <strings.h>

#include "bus.h"
#include "drehgeber/figure.h"
#include "drehgeber/hal.h"
#include "timer.h"
#include "wire.h"

#define PREFIX "virtual:"
#define RIGHT "expected virtual:10MIN, virtual:2.5S or virtual:1H, for example; up to 8760H"
#define PLACES 3u
#define SPAN_MAX DG_S(8760 * 3600)

static const struct {
    const char *name;
    dg_ns ns;
} units[] = {
    {"MS", DG_MS(1)}, {"S", DG_S(1)}, {"MIN", DG_S(60)}, {"H", DG_S(3600)}, /* MS before S */
};

int virtual_time_span(const char *text, dg_ns *span)
{
    const size_t n = strlen(text);
    for (size_t i = 0; i < DG_COUNT(units); i++) {
        const size_t length = strlen(units[i].name);
        struct dg_decimal number;
        if (n > length && strcasecmp(text + n - length, units[i].name) == 0) {
            if (!dg_decimal_parse(text, n - length, PLACES, &number) || number.cut ||
                number.value <= 0 || (dg_ns)number.value > SPAN_MAX / (units[i].ns / 1000u)) {
                return -1;
            }
            *span = (dg_ns)number.value * (units[i].ns / 1000u);
            return 0;
        }
    }
    return -1;
}

/* One that has to be named is a device of the machine, and lives in its time. */
static bool is_real(const struct dg_plan_wire_kind *kind)
{
    return kind->where_needed && lx_wire_of(kind)->make != lx_silkit_bus_make;
}

/* Whether it lives in a time that this process, or a simulation, lets pass. */
static bool is_virtual(const struct dg_plan_wire_kind *kind, bool stepped)
{
    return stepped ? !is_real(kind) : !kind->where_needed;
}

static struct lx_words virtual_wires(bool stepped)
{
    struct lx_words right = {"expected "};
    size_t count = 0;
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        count += is_virtual(&dg_plan_wires[i], stepped);
    }
    for (size_t i = 0, n = 0; i < dg_plan_wire_count; i++) {
        if (is_virtual(&dg_plan_wires[i], stepped)) {
            lx_words_item(&right, dg_plan_wires[i].name, n++, count, " or ");
        }
    }
    return right;
}

static int check_wires(const char *text, const struct dg_plan *plan, bool stepped,
                       struct lx_error *error)
{
    const struct lx_words right = virtual_wires(stepped);
    for (size_t i = 0; i < plan->wire_count; i++) {
        const char *name = plan->wires[i].kind->name;
        if (is_virtual(plan->wires[i].kind, stepped)) {
            continue;
        }
        if (text != NULL) {
            return lx_refuse(error, right.text, "--time=%s: %s has real time", text, name);
        }
        (void)lx_refuse(error, right.text, "%s has real time, not that of a simulation", name);
        return lx_plan_refuse_wire(plan, &plan->wires[i], error);
    }
    return 0;
}

int virtual_time_of(const char *text, const struct dg_plan *plan, dg_ns *span, bool *stepped,
                    struct lx_error *error)
{
    const size_t n = strlen(PREFIX);
    *span = 0;
    if (lx_rig_is_stepped(plan, stepped, error) != 0) {
        return -1;
    }
    if (text != NULL &&
        (strncasecmp(text, PREFIX, n) != 0 || virtual_time_span(text + n, span) != 0)) {
        return lx_refuse(error, RIGHT, "--time=%s: no such time", text);
    }
    return text != NULL || *stepped ? check_wires(text, plan, *stepped, error) : 0;
}

/* Who has said something is answered before time goes on. @return false: it is over, with `result`
 */
static bool serve_events(sd_event *event, int *result)
{
    do {
        *result = sd_event_run(event, 0);
    } while (*result > 0 && sd_event_get_state(event) != SD_EVENT_FINISHED);
    if (sd_event_get_state(event) == SD_EVENT_FINISHED) {
        (void)sd_event_get_exit_code(event, result);
        return false;
    }
    return *result >= 0;
}

int virtual_time_loop(sd_event *event, dg_ns span)
{
    const dg_ns end = dg_after(lx_now(), span);
    int result = 0;
    while (serve_events(event, &result) && lx_time_pass(end)) {
    }
    return result;
}

int virtual_time_steps(sd_event *event, struct lx_rig *rig)
{
    int result = 0;
    while (serve_events(event, &result)) {
        if (!lx_rig_step(rig)) {
            result = sd_event_run(event, UINT64_MAX);
        }
    }
    return result;
}
