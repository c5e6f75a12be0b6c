/* SPDX-License-Identifier: MIT */
/*
 * The command line, parsed but not yet understood: values are checked where they are used.
 */
#ifndef DREHGEBER_TOOL_OPTIONS_H
#define DREHGEBER_TOOL_OPTIONS_H

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "models.h"
#include "plan.h"
#include "say.h"
#include "wire.h"

/* What the command line asks for. Strings belong to argv. */
enum command {
    COMMAND_NONE,
    COMMAND_LIST,
    COMMAND_FAULTS,
    COMMAND_RUN,
    COMMAND_EDS,
    COMMAND_CHECK,
    COMMAND_MODEL,
    COMMAND_ASK, /* as the row's `ask` does it */
    COMMAND_VERIFY,
    COMMAND_MAP,
    COMMAND_FMU,
    COMMAND_CTL,
    COMMAND_TOP,
    COMMAND_WEB,
    COMMAND_EXPLAIN,
    COMMAND_HELP,
    COMMAND_VERSION,
    COMMAND_COUNT
};

struct eds_file;
struct options;

/* A command. */
struct command_row {
    const char *name;
    enum command command;
    bool wires;        /* it takes options that name a wire, besides `takes` */
    const char *usage; /* behind "drehgeber " */
    const char *help;  /* may have several lines */
    const char *takes; /* its options, with blanks around each; NULL: all but those of files that
                          it writes, and of the page: "json", "explain", "c", "output",
                          "fmi", "listen", "token", "watch", "timeout", and those of `explain` and
                          `verify` */
    /* COMMAND_ASK and COMMAND_VERIFY: do what options->words say, the former over a simulated wire.
       Prints its own errors.
       @return how the program ends */
    int (*ask)(const struct options *options);
    const struct dg_stack *stack; /* a MODEL is one of it; NULL: any */
    const char *words;            /* that may stand behind the MODEL, a blank between them; NULL */
};

extern const struct command_row command_rows[];
extern const size_t command_row_count;

/* The row called `name`, or NULL. */
const struct command_row *command_find(const char *name);

struct options {
    enum command command;
    const struct command_row *row;  /* its row, for help the one that is asked about; may be NULL */
    const char *model;              /* or the rig file */
    const char *models;             /* the file that has it */
    const struct dg_device *device; /* that `model` names: built-in, or of `file`; NULL: none */
    const struct dg_plan_model *text; /* its section, of `file`; NULL: it is built in */
    struct model_file *file;          /* owned; `model` as a file, or all that may have it; NULL */
    struct lx_error unread;           /* why a file of models does not help; "": nobody asked */
    const char *ring;                 /* models with commas between them */
    const struct dg_plan_wire_kind *wire; /* NULL: not said */
    const char *where;                    /* the wire's value; NULL: none */
    const char *nvm;
    const char *nvm_convert;
    const char *serial;
    const char *node;
    const char *shaft;
    const char *trace;
    const char *files;
    const char *time; /* "virtual:SPAN" */
    const char *output;
    const char *fmi; /* "2" or "3" */
    const char *listen;
    const char *token; /* its file */
    const char *timeout;
    const char *capture; /* a recording, as `model` is that of --against */
    const char *address;
    const char *journal;
    const char *power;
    const char *junit;
    const char *report;
    char **words; /* owned; what `biss MODEL` and its like are to do, as many as argc at most */
    size_t word_count;
    struct dg_plan_settings settings; /* owned */
    const char **controls;            /* owned; as many as argc at most */
    size_t control_count;
    bool json;
    bool c;
    bool explain;
    bool watch;
    bool alone;
    bool write;
    bool irreversible;
    bool restore;
    bool verbose;
    struct lx_say say;
    struct argp_option *table; /* owned: all options */
    const char *option;        /* name of the last option given; NULL: none */
    uint64_t given;            /* bit n: row n of `table` was */
    int parsed;                /* words, up to and with the last option that was right */
    const char *culprit;       /* what the parser stumbled over */
    struct eds_file *eds;      /* owned: that `device` comes from; NULL: it does not */
    struct lx_error error;
};

/* All options but those that `row` does not take, and those that encoders of `stack` have no use
   for; NULL: all. To be freed; NULL without memory. */
struct argp_option *options_table(const struct command_row *row, const struct lx_stack *stack);

/* Whether this is what stands behind the last row of a table. */
bool options_end(const struct argp_option *row);

/* Whether --node tells encoders of `stack` apart. */
bool options_numbered(const struct lx_stack *stack);

/* The wire for this encoder: the one that was given, or the default. NULL with `error` when that
   is none for it. */
const struct dg_plan_wire_kind *
options_wire(const struct options *self, const struct dg_device *device, struct lx_error *error);

/* Find what MODEL names: `device`, and the file that it comes from. 0, also when there is none, or
   -1 with self->error: an EDS file that is none. */
int options_find_model(struct options *self);

/* What `run` is to be: of a model, a ring, or a rig file, whose plan is handed over: to be called
   once. 0, or -1 with `error` and nothing to free. */
int options_plan(const struct options *self, struct dg_plan *plan, struct lx_error *error);

/* Parse. 0, or -1 with self->error. options_free() in any case. */
int options_parse(struct options *self, int argc, char **argv);

void options_free(struct options *self);

#endif
