/* SPDX-License-Identifier: MIT */
/* The file of a rig: parts one behind the other, each with its head as a line. */
#include "bundle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One part and where the next one begins. */
struct part {
    struct dg_plan_text kind, name, bytes;
    const char *next;
};

/* "KIND BYTES NAME" at `at`, and what it is about. */
static bool take_bundle_part(const char *at, const char *end, struct part *to)
{
    const char *line = memchr(at, '\n', (size_t)(end - at));
    const char *size = line == NULL ? NULL : memchr(at, ' ', (size_t)(line - at));
    char *name = NULL;
    if (size == NULL) {
        return false;
    }
    const unsigned long long n = strtoull(size + 1, &name, 10);
    if (*name != ' ' || n > (unsigned long long)(end - line - 1)) {
        return false;
    }
    name++;
    to->kind = (struct dg_plan_text){at, (size_t)(size - at)};
    to->name = (struct dg_plan_text){name, (size_t)(line - name)};
    to->bytes = (struct dg_plan_text){line + 1, (size_t)n};
    to->next = line + 1 + n;
    return true;
}

static bool is_called(const struct dg_plan_text *self, const char *text)
{
    return strlen(text) == self->n && memcmp(self->text, text, self->n) == 0;
}

bool fmu_bundle_part(const struct fmu_bundle *self, const char *kind, const char *name,
                     struct dg_plan_text *to, struct dg_plan_text *called)
{
    const char *end = self->text + self->n;
    struct part part = {.next = self->text};
    while (take_bundle_part(part.next, end, &part)) {
        if (is_called(&part.kind, kind) && (name == NULL || is_called(&part.name, name))) {
            *to = part.bytes;
            if (called != NULL) {
                *called = part.name;
            }
            return true;
        }
    }
    return false;
}

/* --- points --- */

static size_t count_point_lines(const struct dg_plan_text *of)
{
    size_t n = 0;
    for (size_t i = 0; i < of->n; i++) {
        n += of->text[i] == '\n' ? 1 : 0;
    }
    return n;
}

static bool find_points(const struct fmu_bundle *self, const char *kind, dg_plan_line line,
                        struct dg_plan_text *to)
{
    char name[24];
    (void)snprintf(name, sizeof name, "%llu", (unsigned long long)line);
    return fmu_bundle_part(self, kind, name, to, NULL);
}

size_t fmu_bundle_motion(const struct fmu_bundle *self, dg_plan_line line,
                         struct dg_motion_point **to)
{
    struct dg_plan_text part;
    const size_t count = find_points(self, "motion", line, &part) ? count_point_lines(&part) : 0;
    char *at = NULL;
    *to = count == 0 ? NULL : calloc(count, sizeof **to);
    for (size_t i = 0; *to != NULL && i < count; i++) {
        (*to)[i].at = strtoull(i == 0 ? part.text : at, &at, 10);
        (*to)[i].angle = strtoll(at, &at, 10);
    }
    return *to == NULL ? 0 : count;
}

size_t fmu_bundle_course(const struct fmu_bundle *self, dg_plan_line line,
                         struct dg_course_point **to)
{
    struct dg_plan_text part;
    const size_t count = find_points(self, "course", line, &part) ? count_point_lines(&part) : 0;
    char *at = NULL;
    *to = count == 0 ? NULL : calloc(count, sizeof **to);
    for (size_t i = 0; *to != NULL && i < count; i++) {
        (*to)[i].at = strtoull(i == 0 ? part.text : at, &at, 10);
        (*to)[i].value = (int32_t)strtol(at, &at, 10);
    }
    return *to == NULL ? 0 : count;
}
