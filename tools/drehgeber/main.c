/* SPDX-License-Identifier: MIT */
/* drehgeber: virtual absolute encoders on the command line. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include "biss.h"
#include "biss_settings.h"
#include "ctl.h"
#include "drehgeber/drehgeber.h"
#include "modbus_map.h"
#include "modbus_settings.h"
#include "motion_words.h"
#include "options.h"
#include "run.h"
#include "settings.h"
#include "sim_settings.h"
#include "top.h"

static void list_models(const char *indent)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        (void)printf("%s%-12s %s, %s\n", indent, dg_devices[i]->name, dg_devices[i]->wire,
                     dg_devices[i]->resolution);
    }
}

static const char introduction[] =
    "drehgeber - be an absolute encoder, byte for byte\n"
    "\n"
    "  drehgeber run s3684-rs485 --pty=enc --shaft 60RPM --nvm enc.nvm\n"
    "\n"
    "makes ./enc a serial port (9600 Bd, 8E1) behind which a multiturn encoder turns\n"
    "at 60 rpm; it prints one line, 'ready s3684-rs485 pty:/dev/pts/4', and runs until\n"
    "Ctrl-C or SIGTERM. Ask it for its position with the bytes 40 42 02.\n"
    "\n"
    "  drehgeber list                          the models\n"
    "  drehgeber run MODEL [WIRE] [OPTIONS]    be that encoder\n"
    "  drehgeber run RIG.ini [--control ...]   be all encoders of a rig file\n"
    "  drehgeber eds MODEL                     the EDS file of a CANopen encoder\n"
    "  drehgeber biss MODEL ACTION [OPTIONS]   ask a BiSS encoder over a simulated wire;\n"
    "                                          ACTION, one or more: read,\n"
    "                                          registers [BANK:]ADDR N, eds,\n"
    "                                          write [BANK:]ADDR BYTES, command N\n"
    "  drehgeber map MODEL                     the Modbus registers of an INTERBUS encoder\n"
    "  drehgeber ctl [--control ADDR] COMMAND  SCPI to what is running; SYST:HELP? says which\n"
    "  drehgeber top [ADDRESS]                 what is running, in a terminal; ? says the keys\n"
    "\n"
    " Models:\n";

/* An example first, then the reference; every table in it is the one the program works with. */
static void help(void)
{
    static char name[] = "drehgeber";
    struct lx_settings defaults;
    lx_settings_init(&defaults, dg_hf_model_of(dg_devices[0]));
    (void)fputs(introduction, stdout);
    list_models("  ");
    (void)fputs("\n", stdout);
    argp_help(&options_argp, stdout, ARGP_HELP_LONG, name);
    (void)printf("\n MOTION:\n"
                 "  %s\n"
                 "  Units: DEG REV (angle), RPM (speed), S MS (time). Positive is clockwise, time\n"
                 "  0 is when the encoder is ready. A file has lines 'time_s,angle_deg'.\n"
                 "\n KEY=VALUE (CANopen: those from temperature on, f3668 mt_bits=12|16, and\n"
                 " pace=0|1 of the bus, default 0: frames take their time at its bit rate):\n",
                 lx_shaft_forms);
    lx_settings_help(&defaults, stdout);
    (void)fputs("  (factory) is burnt into a new --nvm file; an existing one has to agree.\n"
                "\n KEY=VALUE of BiSS encoders, beside those from temperature on:\n",
                stdout);
    lx_biss_settings_help(stdout);
    lx_sim_settings_help(stdout);
    (void)fputs("\n KEY=VALUE of INTERBUS encoders, beside what they sense of the above:\n",
                stdout);
    lx_ring_settings_help(stdout);
    (void)fputs("\n Exit status: 0 after SIGTERM or SIGINT, 2 for a wrong command line, 1 for the "
                "rest.\n",
                stdout);
}

static int flushed(void)
{
    if (fflush(stdout) == 0 && ferror(stdout) == 0) {
        return EXIT_OK;
    }
    lx_complain("cannot write to stdout");
    return EXIT_OTHER;
}

static void write_text(void *to, const char *text, size_t n)
{
    (void)fwrite(text, 1, n, to); /* the stream keeps its errors for flushed() */
}

static int eds(const struct options *options)
{
    const struct dg_device *device = options->model == NULL ? NULL : dg_device_find(options->model);
    if (device == NULL || device->stack != &dg_cia406_stack) {
        lx_complain("eds needs a CANopen model; valid: f3658 f3668");
        return EXIT_USAGE;
    }
    dg_co_eds(dg_cia406_sheet(dg_cia406_model_of(device)->device), write_text, stdout);
    return flushed();
}

/* Whether the wire that was asked for, if any, is one of this model. */
static bool wire_fits(const struct options *options, const struct dg_device *device)
{
    struct lx_error error;
    if (device == NULL || options->wire == NULL ||
        options_wire(options, device->stack, &error) != NULL) {
        return true; /* an unknown model is refused where its name is needed */
    }
    lx_complain("%s", error.text);
    return false;
}

/* The registers of a model, or of a whole --ring. */
static int map(const struct options *options)
{
    const struct dg_device *device = options->model == NULL ? NULL : dg_device_find(options->model);
    const struct dg_ib_model *models[DG_IB_RING_MAX];
    struct lx_plan plan;
    struct lx_error error;
    if (options->ring == NULL && (device == NULL || device->stack != &dg_ib_stack)) {
        lx_complain("map needs an INTERBUS model; right is 'drehgeber map ocd-ib-k3' or 'map "
                    "--ring MODEL,MODEL'");
        return EXIT_USAGE;
    }
    if (options_plan(options, &plan, &error) != 0) {
        return run_complain(&error, EXIT_USAGE);
    }
    for (size_t i = 0; i < plan.encoder_count; i++) {
        models[i] = dg_ib_model_of(plan.encoders[i].model);
    }
    lx_map_print(models, plan.encoder_count, stdout);
    lx_plan_free(&plan);
    return flushed();
}

/* The address is an argument of its own, or that of --control. */
static int top(const struct options *options)
{
    if (options->option != NULL && options->control_count == 0) {
        lx_complain("top takes no option --%s; right is 'drehgeber top [ADDRESS]'",
                    options->option);
        return EXIT_USAGE;
    }
    return top_command(options->control_count > 0 ? options->controls[0] : options->model);
}

static int act(const struct options *options)
{
    const struct dg_device *device = options->model == NULL ? NULL : dg_device_find(options->model);
    if (!wire_fits(options, device)) {
        return EXIT_USAGE;
    }
    switch (options->command) {
    case COMMAND_LIST:
        list_models("");
        return flushed();
    case COMMAND_HELP:
        help();
        return flushed();
    case COMMAND_VERSION:
        (void)printf("drehgeber %s\n", dg_version());
        return flushed();
    case COMMAND_EDS:
        return eds(options);
    case COMMAND_RUN:
        return run_rig(options);
    case COMMAND_BISS:
        return biss_command(options);
    case COMMAND_MAP:
        return map(options);
    case COMMAND_CTL:
        return ctl_command(options->control_count == 0 ? NULL : options->controls[0],
                           options->words, options->word_count);
    case COMMAND_TOP:
        return top(options);
    case COMMAND_NONE: /* refused by options_parse() */
        break;
    }
    return EXIT_USAGE;
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

int main(int argc, char **argv)
{
    occupy_closed_streams();
    struct options options;
    int status = EXIT_USAGE;
    if (options_parse(&options, argc, argv) != 0) {
        lx_complain("%s", options.error.text);
    } else {
        status = act(&options);
    }
    options_free(&options);
    return status;
}
