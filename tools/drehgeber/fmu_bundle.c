/* SPDX-License-Identifier: MIT */
/*
 * A rig file is read once more, and all texts that are asked for go into the bundle. Points of
 * motions and courses are in there as numbers, as an FMU has no reader of such files.
 */
#define _GNU_SOURCE
#include "fmu_bundle.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "bundle.h"
#include "drehgeber/devices.h"
#include "eds_file.h"
#include "models.h"
#include "motion_words.h"
#include "plan.h"

/* A bundle that grows. */
struct growing {
    struct fmu_models *models;
    struct fmu_bundle is; /* owned, of `to` */
    FILE *to;
    struct lx_error *error;
    int result; /* of the models */
};

/* --- parts --- */

static bool has_part(const struct growing *self, const char *kind, const char *name)
{
    struct dg_plan_text part;
    (void)fflush(self->to);
    return fmu_bundle_part(&self->is, kind, name, &part, NULL);
}

static void put_bundle_part(const struct growing *self, const char *kind, const char *name,
                            const struct dg_plan_text *text)
{
    (void)fprintf(self->to, "%s %zu %s\n", kind, text->n, name);
    (void)fwrite(text->text, 1, text->n, self->to);
}

/* --- texts and models --- */

static void keep_bundled_text(void *ctx, const char *name, const struct dg_plan_text *text)
{
    const struct growing *self = ctx;
    if (!has_part(self, "file", name)) {
        put_bundle_part(self, "file", name, text);
    }
}

static int put_bundled_model(const struct growing *self, const struct dg_device *model)
{
    struct dg_plan_text text = {.n = 0};
    char *bytes = NULL;
    FILE *to = open_memstream(&bytes, &text.n);
    int result = to == NULL ? lx_fail(self->error, "no memory for %s", model->name)
                            : fmu_models_put(self->models, model, to, self->error);
    if (to != NULL && fclose(to) != 0) {
        result = lx_fail(self->error, "no memory for %s", model->name);
    }
    text.text = bytes;
    if (result == 0) {
        put_bundle_part(self, "model", model->name, &text);
    }
    free(bytes);
    return result;
}

/* Of other files than the rig's: the figures go along. */
static const struct dg_device *find_bundled_model(void *ctx, const char *name)
{
    struct growing *self = ctx;
    const struct model_file *file = self->models->options->file;
    struct lx_error ignored;
    const struct dg_plan_model *row =
        file == NULL || file->others == NULL ? NULL : models_find(file->others, name, &ignored);
    if (row == NULL) {
        return NULL;
    }
    if (self->result == 0 && !has_part(self, "model", name)) {
        self->result = put_bundled_model(self, row->device);
    }
    return row->device;
}

static int put_texts(struct growing *self, const char *file)
{
    const struct lx_plan_shelf shelf = {
        .find_model = find_bundled_model, .keep = keep_bundled_text, .ctx = self};
    struct dg_plan again;
    const int result = lx_plan_read_with(&again, file, &shelf, self->error);
    lx_plan_free(&again);
    return result != 0 ? result : self->result;
}

/* --- points --- */

static struct dg_plan_text line_name(dg_plan_line line, char name[24])
{
    const int n = snprintf(name, 24, "%u", line);
    return (struct dg_plan_text){name, (size_t)n};
}

static void put_points(const struct growing *self, const char *kind, dg_plan_line line,
                       struct dg_plan_text *text)
{
    char name[24];
    put_bundle_part(self, kind, line_name(line, name).text, text);
}

static int write_motion_points(const struct growing *self, const struct dg_plan_shaft *row,
                               FILE *to)
{
    struct lx_shaft motion = {.points = NULL};
    const int result = lx_shaft_parse(&motion, row->motion, NULL, self->error);
    for (size_t i = 0; result == 0 && i < motion.motion.point_count; i++) {
        (void)fprintf(to, "%" PRIu64 " %" PRId64 "\n", (uint64_t)motion.points[i].at,
                      (int64_t)motion.points[i].angle);
    }
    lx_shaft_free(&motion);
    return result == 0
               ? 0
               : lx_plan_refuse_key(self->models->plan, "motion", row->motion_line, self->error);
}

static int read_course_points(const struct growing *self, const char *path, size_t quantity,
                              struct lx_csv_points *to)
{
    struct lx_csv *file = lx_course_open(path, quantity, NULL, self->error);
    int result = file == NULL ? -1 : 1;
    while (result > 0) {
        result = lx_csv_read_on(file, LX_CSV_SLICE, self->error);
    }
    *to = result == 0 ? lx_csv_take(file) : (struct lx_csv_points){.count = 0};
    lx_csv_close(file);
    return result;
}

/* Words of a course that are wrong are the rig's to tell. */
static int write_course_points(const struct growing *self, const struct dg_plan_setting *row,
                               FILE *to)
{
    const struct dg_key *key = dg_keys_find(&dg_world_keys, row->key);
    struct lx_csv_points points = {.count = 0};
    struct dg_course_words words;
    struct dg_plan_error wrong;
    if (dg_course_read(row->value, &words, &wrong) != DG_OK) {
        return 0;
    }
    char *path = lx_plan_path(self->models->plan, row->value, row->line, self->error);
    if (path == NULL) {
        return -1;
    }
    path[strlen(path) - strlen(row->value) + words.name] = '\0';
    const int result = read_course_points(self, path, (size_t)(key - dg_world_keys.rows), &points);
    const struct dg_course_point *list = points.points;
    for (size_t i = 0; i < points.count; i++) {
        (void)fprintf(to, "%" PRIu64 " %" PRId32 "\n", (uint64_t)list[i].at, list[i].value);
    }
    free(points.points);
    free(path);
    return result == 0 ? 0 : lx_plan_refuse_setting(self->models->plan, row, self->error);
}

static int bundle_motion(const struct growing *self, const struct dg_plan_shaft *row)
{
    struct dg_plan_text text = {.n = 0};
    char *bytes = NULL;
    FILE *to = open_memstream(&bytes, &text.n);
    int result = to == NULL ? lx_fail(self->error, "no memory for %s", row->motion)
                            : write_motion_points(self, row, to);
    if (to != NULL && fclose(to) != 0) {
        result = lx_fail(self->error, "no memory for %s", row->motion);
    }
    text.text = bytes;
    if (result == 0) {
        put_points(self, "motion", row->motion_line, &text);
    }
    free(bytes);
    return result;
}

static int bundle_course(const struct growing *self, const struct dg_plan_setting *row)
{
    struct dg_plan_text text = {.n = 0};
    char *bytes = NULL;
    FILE *to = open_memstream(&bytes, &text.n);
    int result = to == NULL ? lx_fail(self->error, "no memory for %s", row->value)
                            : write_course_points(self, row, to);
    if (to != NULL && fclose(to) != 0) {
        result = lx_fail(self->error, "no memory for %s", row->value);
    }
    text.text = bytes;
    if (result == 0) {
        put_points(self, "course", row->line, &text);
    }
    free(bytes);
    return result;
}

static bool is_course_setting(const struct dg_plan_setting *row)
{
    return dg_course_is(row->value) && dg_keys_find(&dg_world_keys, row->key) != NULL;
}

static int put_encoder_courses(const struct growing *self, const struct dg_plan_settings *settings)
{
    char name[24];
    int result = 0;
    for (size_t i = 0; result == 0 && i < settings->count; i++) {
        const struct dg_plan_setting *row = &settings->list[i];
        if (is_course_setting(row) && !has_part(self, "course", line_name(row->line, name).text)) {
            result = bundle_course(self, row);
        }
    }
    return result;
}

static int put_all_points(const struct growing *self)
{
    const struct dg_plan *plan = self->models->plan;
    int result = 0;
    for (size_t i = 0; result == 0 && i < plan->shaft_count; i++) {
        const struct dg_plan_shaft *row = &plan->shafts[i];
        result =
            row->motion != NULL && dg_motion_is_file(row->motion) ? bundle_motion(self, row) : 0;
    }
    for (size_t i = 0; result == 0 && i < plan->encoder_count; i++) {
        result = put_encoder_courses(self, &plan->encoders[i].settings);
    }
    return result;
}

/* --- nodes of a command line --- */

/* Any kind that needs no address: an FMU has its own. */
static const char *kind_for(const struct dg_stack *stack)
{
    size_t i = 0;
    while (dg_plan_wires[i].where_needed || !dg_plan_carries(&dg_plan_wires[i], stack)) {
        i++;
    }
    return dg_plan_wires[i].name;
}

static void write_node(const struct growing *self, size_t index, const char *model, FILE *to)
{
    const struct dg_plan_encoder *row = &self->models->plan->encoders[index];
    (void)fputs("[encoder ", to);
    for (const char *at = row->name; *at != '\0'; at++) {
        (void)fputc(isalnum((unsigned char)*at) ? *at : '_', to);
    }
    (void)fprintf(to, "]\nmodel = %s\nbus = bus\nnode = %d\n", model, row->address);
    if (row->serial != NULL) {
        (void)fprintf(to, "serial = %s\n", row->serial);
    }
    for (size_t i = 0; i < row->settings.count; i++) {
        (void)fprintf(to, "%s = %s\n", row->settings.list[i].key, row->settings.list[i].value);
    }
}

/* An EDS file has its text in here, too. */
static int put_nodes(const struct growing *self)
{
    const struct dg_plan *plan = self->models->plan;
    const struct dg_device *model = plan->encoders[0].model;
    const struct eds_file *eds = self->models->options->eds;
    const bool of_file = eds != NULL && &eds->encoder.device == model;
    struct dg_plan_text text = {.n = 0};
    char *bytes = NULL;
    FILE *to = open_memstream(&bytes, &text.n);
    if (to == NULL) {
        return lx_fail(self->error, "no memory for so many encoders");
    }
    (void)fprintf(to, "[bus bus]\nwire = %s\n", kind_for(model->stack));
    for (size_t i = 0; i < plan->encoder_count; i++) {
        write_node(self, i, of_file ? "model.eds" : model->name, to);
    }
    int result = fclose(to) == 0 ? 0 : lx_fail(self->error, "no memory for so many encoders");
    text.text = bytes;
    if (result == 0) {
        put_bundle_part(self, "file", "nodes.ini", &text);
        text = (struct dg_plan_text){of_file ? eds->text : "", of_file ? eds->length : 0};
    }
    if (result == 0 && of_file) {
        put_bundle_part(self, "file", "model.eds", &text);
    } else if (result == 0 && dg_device_find(model->name) != model) {
        result = put_bundled_model(self, model);
    }
    free(bytes);
    return result;
}

/* --- all of it --- */

const char *fmu_bundle_add(struct fmu_models *models, struct lx_error *error)
{
    struct growing self = {.models = models, .error = error};
    const char *name = NULL;
    self.to = open_memstream(&self.is.text, &self.is.n);
    if (self.to == NULL) {
        (void)lx_fail(error, "no memory for a rig");
        return NULL;
    }
    int result =
        models->plan->file == NULL ? put_nodes(&self) : put_texts(&self, models->plan->file);
    result = result == 0 ? put_all_points(&self) : result;
    if (fclose(self.to) != 0 && result == 0) {
        result = lx_fail(error, "no memory for a rig");
    }
    if (result == 0) {
        name = fmu_models_add(models, "rig", self.is.text, self.is.n);
        (void)(name == NULL ? lx_fail(error, "no memory for a rig") : 0);
    }
    free(self.is.text);
    return name;
}
