/* SPDX-License-Identifier: MIT */
/* drehgeber: virtual absolute encoders on the command line. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include "ctl.h"
#include "drehgeber/drehgeber.h"
#include "eds_file.h"
#include "explain.h"
#include "fmu_file.h"
#include "help.h"
#include "list.h"
#include "model_c.h"
#include "options.h"
#include "run.h"
#include "top.h"
#include "web.h"

static int flushed(void)
{
    if (fflush(stdout) == 0 && ferror(stdout) == 0) {
        return EXIT_OK;
    }
    lx_complain("cannot write to stdout");
    return EXIT_OTHER;
}

static int printed(int status)
{
    return status == EXIT_OK ? flushed() : status;
}

static void write_text(void *to, const char *text, size_t n)
{
    (void)fwrite(text, 1, n, to); /* the stream keeps its errors for flushed() */
}

static int eds(const struct options *options)
{
    const struct dg_device *device = options->device;
    if (options->explain != eds_file_is(options->model)) {
        lx_complain("eds explains files, and prints those of models; expected 'drehgeber eds "
                    "FILE.eds --explain' or 'drehgeber eds MODEL'");
        return EXIT_USAGE;
    }
    if (options->explain) {
        return printed(eds_explain(options->model));
    }
    const struct dg_co_sheet *sheet = dg_cia406_sheet_of(device);
    if (sheet == NULL) {
        struct lx_words right = {""};
        lx_stack_models(&lx_cia406_stack, &right);
        lx_complain("eds needs a CANopen model; valid:%s", right.text);
        return EXIT_USAGE;
    }
    dg_co_eds(sheet, write_text, stdout);
    return flushed();
}

static int check_file(const struct options *options)
{
    if (!eds_file_is(options->model)) {
        lx_complain("check needs an EDS or DCF file; expected 'drehgeber check FILE.eds'");
        return EXIT_USAGE;
    }
    return printed(eds_file_check(options->model));
}

/* Whether the wire that was asked for, if any, is one of this model. */
static bool wire_fits(const struct options *options, const struct dg_device *device)
{
    struct lx_error error;
    if (device == NULL || options->wire == NULL || options_wire(options, device, &error) != NULL) {
        return true; /* an unknown model is refused where its name is needed */
    }
    (void)complain(&error, EXIT_USAGE);
    return false;
}

/* Commands that take a rig file, too, say so themselves. */
static bool file_is_read(const struct options *options)
{
    const bool rig = options->command == COMMAND_RUN || options->command == COMMAND_FMU ||
                     options->command == COMMAND_HELP;
    const bool wrong = options->unread.what[0] != '\0' || options->unread.right[0] != '\0';
    if (!rig && wrong && options->device == NULL) {
        (void)complain(&options->unread, EXIT_USAGE);
        return false;
    }
    return true;
}

static void print_line(void *ctx, const char *text)
{
    (void)ctx;
    (void)puts(text);
}

/* The registers of a model, or of a whole --ring. */
static int map(const struct options *options)
{
    const struct dg_device *device = options->device;
    const struct dg_ib_model *models[DG_RING_MAX];
    struct dg_plan plan;
    struct lx_error error;
    if (options->ring == NULL && (device == NULL || device->stack != &dg_ib_stack)) {
        lx_complain("map needs an INTERBUS model; expected 'drehgeber map ocd-ib-k3' or 'map "
                    "--ring MODEL,MODEL'");
        return EXIT_USAGE;
    }
    if (options_plan(options, &plan, &error) != 0) {
        return complain(&error, EXIT_USAGE);
    }
    for (size_t i = 0; i < plan.encoder_count; i++) {
        models[i] = dg_ib_model_of(plan.encoders[i].model);
    }
    dg_ib_coupler_describe(models, plan.encoder_count, print_line, NULL);
    lx_plan_free(&plan);
    return flushed();
}

/* The address is an argument of its own, or that of --control. */
static int top(const struct options *options)
{
    if (options->option != NULL && options->control_count == 0) {
        lx_complain("top takes no option --%s; expected 'drehgeber top [ADDRESS]'",
                    options->option);
        return EXIT_USAGE;
    }
    return top_command(options->control_count > 0 ? options->controls[0] : options->model);
}

static int ctl(const struct options *options)
{
    const struct ctl_wanted wanted = {options->control_count == 0 ? NULL : options->controls[0],
                                      options->timeout};
    return ctl_command(&wanted, options->words, options->word_count);
}

static int list(const struct options *options)
{
    return printed(list_command(options));
}

static int faults(const struct options *options)
{
    return printed(faults_command(options));
}

static int model(const struct options *options)
{
    return printed(model_command(options));
}

static int help(const struct options *options)
{
    help_print(options);
    return flushed();
}

static int version(const struct options *options)
{
    (void)options;
    (void)printf("drehgeber %s\n", dg_version());
    return flushed();
}

static int ask_command(const struct options *options)
{
    return options->row->ask(options);
}

/* NULL: refused by options_parse() */
static int (*const acts[])(const struct options *) = {
    [COMMAND_NONE] = NULL,
    [COMMAND_LIST] = list,
    [COMMAND_FAULTS] = faults,
    [COMMAND_RUN] = run_rig,
    [COMMAND_EDS] = eds,
    [COMMAND_CHECK] = check_file,
    [COMMAND_MODEL] = model,
    [COMMAND_ASK] = ask_command,
    [COMMAND_VERIFY] = ask_command,
    [COMMAND_MAP] = map,
    [COMMAND_FMU] = fmu_command,
    [COMMAND_CTL] = ctl,
    [COMMAND_TOP] = top,
    [COMMAND_WEB] = web_command,
    [COMMAND_HELP] = help,
    [COMMAND_VERSION] = version,
    [COMMAND_EXPLAIN] = explain_command,
};
_Static_assert(DG_COUNT(acts) == COMMAND_COUNT, "a row for each command");

static int act_on_wire(const struct options *options)
{
    if (!wire_fits(options, options->device) || !file_is_read(options)) {
        return EXIT_USAGE;
    }
    return acts[options->command] == NULL ? EXIT_USAGE : acts[options->command](options);
}

/* A stream that came closed stays one that cannot be written to. Otherwise the next file opened,
   such as the EEPROM's, would get its number and every message. */
static void occupy_closed_streams(void)
{
    int fd = STDIN_FILENO;
    while (fd >= 0 && fd <= STDERR_FILENO) {
        fd = open("/dev/null", O_RDONLY);
    }
    if (fd >= 0) {
        (void)close(fd);
    }
}

/* The help is for whoever wants to know; a script that has forgotten the command is told so by the
   status. */
static int explain_itself(void)
{
    const struct options nothing = {.command = COMMAND_HELP};
    help_print(&nothing);
    return flushed() == EXIT_OK ? EXIT_USAGE : EXIT_OTHER;
}

int main(int argc, char **argv)
{
    occupy_closed_streams();
    if (argc < 2) {
        return explain_itself();
    }
    struct options options;
    int status = EXIT_USAGE;
    if (options_parse(&options, argc, argv) != 0) {
        (void)complain(&options.error, status);
    } else {
        status = act_on_wire(&options);
    }
    options_free(&options);
    return status;
}
