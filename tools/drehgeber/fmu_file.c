/* SPDX-License-Identifier: MIT */
/*
 * An FMU is a description that is made here, and what was built and installed with this program:
 * the shared objects and the sources, in a folder beside it or where it was installed.
 */
#define _GNU_SOURCE
#include "fmu_file.h"

#include <ctype.h>
#include <errno.h>
#include <libgen.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "beside.h"
#include "complain.h"
#include "describe.h"
#include "drehgeber/devices.h"
#include "drehgeber/drehgeber.h"
#include "fmu_bundle.h"
#include "fmu_models.h"
#include "plan.h"
#include "run.h"
#include "say.h"
#include "stacks.h"
#include "zip.h"

/* A file of the folder, or text that was made. */
struct text {
    char *bytes; /* owned */
    size_t n;
};

/* What the FMU is made of. */
struct making {
    char folder[4096]; /* of the parts, with a slash behind it */
    int version;       /* of FMI */
    struct text token, list, description;
    char **sources; /* owned, of `list` */
    size_t source_count;
    struct fmu *fmu;
    struct fmu_models models;
    struct lx_error error;
};

/* --- the parts --- */

static int load_file(struct making *self, const char *name, struct text *to)
{
    char path[4400];
    (void)snprintf(path, sizeof path, "%s%s", self->folder, name);
    FILE *file = fopen(path, "rb");
    char block[16384];
    size_t n = 0;
    FILE *copy = open_memstream(&to->bytes, &to->n);
    while (file != NULL && copy != NULL && (n = fread(block, 1, sizeof block, file)) > 0) {
        (void)fwrite(block, 1, n, copy);
    }
    const bool bad = file == NULL || copy == NULL || ferror(file) != 0 || ferror(copy) != 0;
    if (file != NULL) {
        (void)fclose(file);
    }
    if (copy != NULL && fclose(copy) != 0) {
        return lx_fail(&self->error, "no memory for %s", path);
    }
    return bad ? lx_fail(&self->error, "cannot read %s: %s", path, strerror(errno)) : 0;
}

/* Beside the program in a build tree, else where it is installed. */
static int find_folder(struct making *self)
{
    char path[4096 - sizeof DREHGEBER_FMU_FOLDER];
    const ssize_t n = readlink("/proc/self/exe", path, sizeof path - 1);
    if (n < 0) {
        return lx_fail(&self->error, "cannot find out where this program is: %s", strerror(errno));
    }
    path[n] = '\0';
    const char *folder = dirname(path);
    (void)snprintf(self->folder, sizeof self->folder, "%s/fmu-parts/", folder);
    if (access(self->folder, X_OK) != 0) {
        (void)snprintf(self->folder, sizeof self->folder, "%s/" DREHGEBER_FMU_FOLDER "/", folder);
    }
    return access(self->folder, X_OK) == 0
               ? 0
               : lx_fail(&self->error, "%s is not installed", self->folder);
}

/* Names, a line each. */
static int take_list(struct making *self)
{
    if (load_file(self, "sources.list", &self->list) != 0) {
        return -1;
    }
    for (char *at = strtok(self->list.bytes, "\n"); at != NULL; at = strtok(NULL, "\n")) {
        char **more = realloc(self->sources, (self->source_count + 1) * sizeof *more);
        if (more == NULL) {
            return lx_fail(&self->error, "no memory for a list of sources");
        }
        self->sources = more;
        self->sources[self->source_count++] = at;
    }
    return 0;
}

/* --- the token, see fmu.h --- */

static int no_such(struct making *self, const char *key, const char *value)
{
    (void)lx_refuse(&self->error, "leave it out", "an FMU has no such wire");
    return lx_about(&self->error, LX_ABOUT_SETTING, key, value);
}

static int put_setting(struct making *self, struct dg_host *trial, const char *key,
                       const char *value, FILE *to)
{
    const int result = dg_host_set(trial, key, value);
    if (result == DG_HOST_ERR_NAME) {
        return no_such(self, key, value);
    }
    if (result != DG_HOST_OK) {
        (void)lx_refuse(&self->error, "'drehgeber help fmu MODEL' shows the ranges", "%s",
                        dg_host_result_text(result));
        return lx_about(&self->error, LX_ABOUT_SETTING, key, value);
    }
    (void)fprintf(to, ",%s=", key);
    fmu_put_escaped(value, to);
    return 0;
}

/* One that is not in an FMU yet: what it is asked does not change it. @return NULL: no memory */
static struct dg_host *make_trial(const struct dg_device *model, void **memory)
{
    const struct dg_host_wire *wire = dg_host_wire_of(model);
    const size_t size = dg_host_size(model, wire);
    *memory = aligned_alloc(DG_HOST_ALIGN, (size + DG_HOST_ALIGN - 1) & ~(DG_HOST_ALIGN - 1));
    return *memory == NULL ? NULL : dg_host_init(*memory, size, model, wire);
}

static int refuse_model(struct making *self, const struct dg_device *model, struct dg_host *trial)
{
    if (trial == NULL) {
        return lx_fail(&self->error, "no memory for an encoder");
    }
    return fmu_can_have(trial) ? 0
                               : lx_refuse(&self->error, "leave it out",
                                           "an FMU cannot have %s, whose protocol is %s",
                                           model->name, dg_host_protocol(trial));
}

static int put_encoder_settings(struct making *self, const struct dg_plan_encoder *encoder,
                                FILE *to)
{
    const struct dg_key *address = dg_plan_address_row(encoder->model);
    void *memory = NULL;
    struct dg_host *trial = make_trial(encoder->model, &memory);
    int result = refuse_model(self, encoder->model, trial);
    if (result == 0 && encoder->serial != NULL) {
        result = put_setting(self, trial, "serial", encoder->serial, to);
    }
    if (result == 0 && address != NULL && encoder->address != DG_PLAN_AS_DELIVERED) {
        char text[16];
        (void)snprintf(text, sizeof text, "%d", encoder->address);
        result = put_setting(self, trial, address->name, text, to);
    }
    for (size_t i = 0; result == 0 && i < encoder->settings.count; i++) {
        const struct dg_plan_setting *row = &encoder->settings.list[i];
        result = put_setting(self, trial, row->key, row->value, to);
    }
    free(memory);
    return result;
}

/* --- what stays outside --- */

/* Words, each once. */
struct words {
    const char *name[24];
    size_t count;
};

static void add_word(struct words *self, const char *name)
{
    for (size_t i = 0; i < self->count; i++) {
        if (strcmp(self->name[i], name) == 0) {
            return;
        }
    }
    if (self->count < DG_COUNT(self->name)) {
        self->name[self->count++] = name;
    }
}

static void add_word_if(struct words *self, const char *name, bool is)
{
    if (is) {
        add_word(self, name);
    }
}

static struct words left_out(const struct dg_plan *plan)
{
    struct words all = {.count = 0};
    for (size_t i = 0; i < plan->wire_count; i++) {
        const struct dg_plan_wire *wire = &plan->wires[i];
        const bool acts = wire->kind->settings == &dg_plan_pace_usual;
        add_word_if(&all, "trace", wire->trace != NULL);
        for (size_t k = 0; k < wire->settings.count && !acts; k++) {
            add_word(&all, wire->settings.list[k].key);
        }
    }
    for (size_t i = 0; i < plan->encoder_count; i++) {
        add_word_if(&all, "nvm", plan->encoders[i].nvm != NULL);
    }
    return all;
}

/* A rig file is for running, too: what an FMU has no place for is told. */
static void tell_left_out(const struct dg_plan *plan)
{
    const struct lx_say say = {.quiet = false};
    const struct words all = left_out(plan);
    struct lx_words list = {""};
    for (size_t i = 0; i < all.count; i++) {
        lx_words_item(&list, all.name[i], i, all.count, " and ");
    }
    if (all.count > 0) {
        lx_note(&say, "%s: not in an FMU, left out: %s", plan->file, list.text);
    }
}

/* On a command line nobody else reads them. */
static int refuse_wires(struct making *self, const struct dg_plan *plan)
{
    const struct dg_plan_settings *of = &plan->wires[0].settings;
    return plan->file != NULL || of->count == 0 ? 0
                                                : no_such(self, of->list[0].key, of->list[0].value);
}

/* --- the token of all --- */

static int put_encoder(struct making *self, const struct dg_plan_encoder *encoder, FILE *to)
{
    (void)fputc('=', to);
    const int result = fmu_models_put(&self->models, encoder->model, to, &self->error);
    return result == 0 ? put_encoder_settings(self, encoder, to) : result;
}

static int put_rig(struct making *self, const struct dg_plan *plan, FILE *to)
{
    int result = 0;
    for (size_t i = 0; result == 0 && i < plan->encoder_count; i++) {
        void *memory = NULL;
        struct dg_host *trial = make_trial(plan->encoders[i].model, &memory);
        result = refuse_model(self, plan->encoders[i].model, trial);
        free(memory);
    }
    const char *name = result == 0 ? fmu_bundle_add(&self->models, &self->error) : NULL;
    (void)fputs(name == NULL ? "" : name, to);
    return name == NULL ? -1 : 0;
}

static int make_token(struct making *self, const struct dg_plan *plan)
{
    FILE *to = open_memstream(&self->token.bytes, &self->token.n);
    if (to == NULL) {
        return lx_fail(&self->error, "no memory for a token");
    }
    (void)fprintf(to, "drehgeber %s ", dg_version());
    const int result = plan->file == NULL && plan->encoder_count == 1
                           ? put_encoder(self, &plan->encoders[0], to)
                           : put_rig(self, plan, to);
    if (fclose(to) != 0) {
        return lx_fail(&self->error, "no memory for a token");
    }
    return result;
}

/* What is wrong with a rig is found when it is made. */
static int make_encoders(struct making *self, const struct dg_plan *plan)
{
    struct dg_plan_error wrong = {.line = 0};
    self->models.files.error = &wrong;
    self->fmu = fmu_make_with(self->token.bytes, &self->models.files);
    self->models.files.error = NULL;
    if (self->fmu != NULL) {
        return 0;
    }
    if (wrong.what[0] == '\0' && wrong.right[0] == '\0') {
        return lx_fail(&self->error, "no memory for the encoders");
    }
    wrong.file = plan->file;
    return lx_error_take(&self->error, &wrong);
}

/* --- the archive --- */

static int describe_fmu(struct making *self, const struct fmu_about *about)
{
    FILE *to = open_memstream(&self->description.bytes, &self->description.n);
    if (to == NULL) {
        return lx_fail(&self->error, "no memory for a description");
    }
    fmu_describe(self->fmu, about, self->version, to);
    return fclose(to) == 0 ? 0 : lx_fail(&self->error, "no memory for a description");
}

static int add_file(struct making *self, struct zip *zip, const char *name, const char *as)
{
    struct text text = {0};
    const int result = load_file(self, name, &text);
    if (result == 0) {
        zip_add(zip, as, text.bytes, text.n);
    }
    free(text.bytes);
    return result;
}

/* Which texts FMI 3 has beside its description. */
static int add_texts(struct making *self, struct zip *zip, const struct fmu_about *about)
{
    static const char *const names[] = {
        "sources/buildDescription.xml",
        "terminalsAndIcons/terminalsAndIcons.xml",
        "extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml",
    };
    const size_t count = fmu_has_bus(self->fmu) ? 3 : 1;
    for (size_t i = 0; i < count; i++) {
        struct text text = {0};
        FILE *to = open_memstream(&text.bytes, &text.n);
        if (to == NULL) {
            return lx_fail(&self->error, "no memory for %s", names[i]);
        }
        switch (i) {
        case 0:
            fmu_describe_build(about, to);
            break;
        case 1:
            fmu_describe_terminals(self->fmu, to);
            break;
        default:
            fmu_describe_bus(to);
            break;
        }
        if (fclose(to) == 0) {
            zip_add(zip, names[i], text.bytes, text.n);
        }
        free(text.bytes);
    }
    return 0;
}

/* Sources that are compiled for the other version are left out, headers are in the list, too. */
static bool is_for(const struct making *self, const char *source)
{
    return strstr(source, self->version == 2 ? "/fmi3.c" : "/fmi2.c") == NULL;
}

static int add_source_files(struct making *self, struct zip *zip)
{
    int result = 0;
    for (size_t i = 0; i < self->source_count && result == 0; i++) {
        char name[300];
        (void)snprintf(name, sizeof name, "sources/%s", self->sources[i]);
        result = is_for(self, name) ? add_file(self, zip, name, name) : 0;
    }
    return result;
}

static int add_members(struct making *self, struct zip *zip, const struct fmu_about *about)
{
    const char *object = self->version == 2 ? "fmi2.so" : "fmi3.so";
    const char *as = self->version == 2 ? "binaries/" DREHGEBER_FMU_PLATFORM_2 "/drehgeber.so"
                                        : "binaries/" DREHGEBER_FMU_PLATFORM_3 "/drehgeber.so";
    zip_add(zip, "modelDescription.xml", self->description.bytes, self->description.n);
    int result = add_file(self, zip, object, as);
    if (result == 0) {
        result = add_file(self, zip, "terms.txt", "documentation/licenses/license.txt");
    }
    if (result == 0 && self->version == 3) {
        result = add_texts(self, zip, about);
    }
    for (size_t i = 0; i < self->models.count; i++) {
        const struct fmu_resource *resource = &self->models.resources[i];
        char name[sizeof resource->name + sizeof "resources/"];
        (void)snprintf(name, sizeof name, "resources/%s", resource->name);
        zip_add(zip, name, resource->bytes, resource->n);
    }
    return result != 0 ? result : add_source_files(self, zip);
}

static bool is_same_file(const char *one, const char *other)
{
    struct stat a;
    struct stat b;
    return stat(one, &a) == 0 && stat(other, &b) == 0 && a.st_dev == b.st_dev &&
           a.st_ino == b.st_ino;
}

/* What is no regular file, /dev/stdout for one, has no place beside it. 0 or an errno. */
static int write_out(const char *output, const struct text *archive)
{
    struct stat is;
    if (stat(output, &is) != 0 || S_ISREG(is.st_mode)) {
        const mode_t mask = umask(0);
        (void)umask(mask);
        return lx_file_replace(output, archive->bytes, archive->n, 0666 & ~mask, NULL);
    }
    FILE *to = fopen(output, "wb");
    if (to == NULL) {
        return errno;
    }
    int reason = fwrite(archive->bytes, 1, archive->n, to) == archive->n ? 0 : errno;
    if (fclose(to) != 0 && reason == 0) {
        reason = errno;
    }
    return reason;
}

/* The archive is complete before anything of the user's is touched. */
static int make_archive(struct making *self, const char *name, struct text *to)
{
    char *compiled[512];
    struct fmu_about about = {self->token.bytes, name, compiled, 0};
    for (size_t i = 0; i < self->source_count && about.source_count < DG_COUNT(compiled); i++) {
        const char *end = strrchr(self->sources[i], '.');
        if (end != NULL && strcmp(end, ".c") == 0 && is_for(self, self->sources[i])) {
            compiled[about.source_count++] = self->sources[i];
        }
    }
    if (describe_fmu(self, &about) != 0) {
        return -1;
    }
    struct zip zip = {.to = open_memstream(&to->bytes, &to->n)};
    if (zip.to == NULL) {
        return lx_fail(&self->error, "no memory for an FMU");
    }
    int result = add_members(self, &zip, &about);
    const bool bad = zip_end(&zip) != 0;
    if ((fclose(zip.to) != 0 || bad) && result == 0) {
        result = lx_fail(&self->error, "no memory for an FMU");
    }
    return result;
}

static int write_archive(struct making *self, const char *name, const char *output)
{
    struct text archive = {0};
    int result = make_archive(self, name, &archive);
    const int reason = result == 0 ? write_out(output, &archive) : 0;
    if (reason != 0) {
        result = lx_fail(&self->error, "cannot write %s: %s", output, strerror(reason));
    }
    free(archive.bytes);
    return result;
}

static int make_fmu(struct making *self, const struct dg_plan *plan, const char *output)
{
    if (find_folder(self) != 0 || take_list(self) != 0) {
        return -1;
    }
    return write_archive(self, plan->name, output);
}

static int take_version(const char *text, struct making *self)
{
    self->version = text == NULL || strcmp(text, "3") == 0 ? 3 : 2;
    if (self->version == 2 && strcmp(text, "2") != 0) {
        (void)lx_refuse(&self->error, "expected 2 or 3", "%s", "");
        return lx_about(&self->error, LX_ABOUT_KEY, "fmi", text);
    }
    return 0;
}

/* Importers go by the ending; a pipe or the like has its own name. */
static bool is_named(const char *output)
{
    static const char ending[] = ".fmu";
    const size_t n = strlen(output);
    const size_t of_ending = strlen(ending);
    struct stat is;
    return (n > of_ending && strcasecmp(output + n - of_ending, ending) == 0) ||
           (stat(output, &is) == 0 && !S_ISREG(is.st_mode));
}

int fmu_command(const struct options *options)
{
    struct making self = {.version = 3};
    struct dg_plan plan;
    if (options->output == NULL) {
        lx_complain("fmu needs --output; expected 'drehgeber %s'", options->row->usage);
        return EXIT_USAGE;
    }
    (void)signal(SIGXFSZ, SIG_IGN); /* a limit of file sizes is an errno then, not the end */
    if (take_version(options->fmi, &self) != 0 || options_plan(options, &plan, &self.error) != 0) {
        return complain(&self.error, EXIT_USAGE);
    }
    int status = EXIT_OK;
    fmu_models_begin(&self.models, options, &plan);
    if (refuse_wires(&self, &plan) != 0 || make_token(&self, &plan) != 0 ||
        make_encoders(&self, &plan) != 0) {
        status = complain(&self.error, EXIT_USAGE);
    } else if (options->device == NULL && is_same_file(options->model, options->output)) {
        lx_complain("fmu: %s is the rig file itself", options->output);
        status = EXIT_USAGE;
    } else if (!is_named(options->output)) {
        lx_complain("--output %s: expected %s.fmu", options->output, options->output);
        status = EXIT_USAGE;
    } else if (make_fmu(&self, &plan, options->output) != 0) {
        status = complain(&self.error, EXIT_OTHER);
    } else if (plan.file != NULL) {
        tell_left_out(&plan);
    }
    fmu_free(self.fmu);
    fmu_models_end(&self.models);
    free(self.sources);
    free(self.token.bytes);
    free(self.list.bytes);
    free(self.description.bytes);
    lx_plan_free(&plan);
    return status;
}
