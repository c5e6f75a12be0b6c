/* SPDX-License-Identifier: MIT */
/*
 * TRACe: what goes over the wires, for those who look.
 */
#include "control_private.h"

#define LINES_MAX 100

static const struct dg_scpi_range lines = {DG_SCPI_PLAIN, 0, 1, LINES_MAX};

static void trace(struct dg_scpi *self, const char *path)
{
    const struct dg_rig_ops *ops = dg_control_ops_of(self);
    char detail[CONTROL_DETAIL_SIZE] = "";

    if (control_offered(self, ops->trace != NULL)) {
        const int code =
            ops->trace(dg_control_rig_of(self), dg_control_selected(self), path, detail);
        dg_scpi_raise(self, code, detail);
    }
}

void dg_control_trace(struct dg_scpi *self)
{
    char path[DG_SCPI_LINE_MAX + 1u];

    if (dg_scpi_text(self, path, sizeof path)) {
        trace(self, path);
    }
}

void dg_control_trace_stop(struct dg_scpi *self)
{
    trace(self, NULL);
}

/* The last lines, each put by `put_line`. */
static void put_lines(struct dg_scpi *self,
                      void (*put_line)(struct dg_scpi *self, const struct dg_rig_line *line))
{
    const struct dg_rig_ops *ops = dg_control_ops_of(self);
    struct dg_rig_line line;
    int64_t wanted = 1;
    size_t count = 0;

    if ((dg_scpi_more(self) && !dg_scpi_number(self, &lines, &wanted)) ||
        !control_offered(self, ops->last != NULL)) {
        return;
    }
    for (unsigned back = (unsigned)wanted; back > 0; back--) {
        if (ops->last(dg_control_rig_of(self), dg_control_selected(self), back - 1u, &line)) {
            put_line(self, &line);
            count++;
        }
    }
    dg_control_put_none(self, count);
}

static void put_text(struct dg_scpi *self, const struct dg_rig_line *line)
{
    dg_scpi_put_string(self, line->text);
}

static void put_severity(struct dg_scpi *self, const struct dg_rig_line *line)
{
    static const char *const words[] = {
        [DG_SEVERITY_OK] = "OK",
        [DG_SEVERITY_NOTICE] = "NOTICE",
        [DG_SEVERITY_WARNING] = "WARNING",
        [DG_SEVERITY_ERROR] = "ERROR",
    };

    _Static_assert(DG_COUNT(words) == DG_SEVERITY_COUNT, "a word each");
    dg_scpi_put_word(self, words[line->severity]);
}

void dg_control_last(struct dg_scpi *self)
{
    put_lines(self, put_text);
}

void dg_control_severity(struct dg_scpi *self)
{
    put_lines(self, put_severity);
}
