/* SPDX-License-Identifier: MIT */
/*
 * What `drehgeber verify` is made of. A row is rehearsed first, with the model alone: that says
 * what it needs, and whether it is about such an encoder at all. Then the real encoder is asked the
 * same as the model beside it, and has to answer what the model answers.
 */
#ifndef DREHGEBER_TOOL_VERIFY_PARTS_H
#define DREHGEBER_TOOL_VERIFY_PARTS_H

#include <stdbool.h>
#include <stdio.h>

#include "error.h"
#include "options.h"
#include "rows.h"
#include "verify_journal.h"

/* Most lists of clauses that a protocol has. */
#define VERIFY_SUITES_MAX 2u
/* What a wait of a host may take longer. */
#define VERIFY_SLACK DG_MS(50)
/* How long an encoder may take to be there behind power-on. */
#define VERIFY_START DG_MS(500)
/* How long a row may wait. */
#define VERIFY_ROW_MAX DG_S(10)
/* How long others on the wire are looked for. */
#define VERIFY_SCAN DG_S(5)
/* Longest text about a row. */
#define VERIFY_TEXT_MAX 1200u

/* What became of the row that runs. */
enum verify_outcome {
    VERIFY_AGREES,
    VERIFY_DIFFERS,
    VERIFY_NOT_SEEN, /* the encoder's own state is in the way */
    VERIFY_LOST      /* nobody answers, or nobody stops */
};

struct verify_protocol;
struct verify_stream;

/* A real encoder on its wire; the first member of a protocol's own struct. */
struct verify_encoder {
    const struct verify_protocol *protocol;
    char identity[160];             /* type and firmware, as it says itself */
    char serial[48];                /* serial number, likewise */
    enum verify_outcome outcome;    /* of the row that runs, when its steps have failed */
    struct verify_journal *journal; /* for what is changed; NULL: nothing may be */
    struct verify_stream *stream;   /* whose time is its own; NULL: it is this machine's */
    dg_ns since;                    /* the last step of the row that runs, when that counts */
    bool cuts;                      /* the row that was rehearsed last cuts its supply */
    bool off;                       /* its supply is cut */
    bool declined;                  /* the user does not want to switch it */
    bool held_up;      /* this host was late in the row that runs: what differs says nothing */
    const char *power; /* cuts the supply, with "on" or "off" behind it; NULL: the user does */
};

/* What verifies encoders of a protocol. */
struct verify_protocol {
    const struct dg_stack *stack;
    const char *suites[VERIFY_SUITES_MAX]; /* names of lists of clauses; NULL: no more */
    /* Make the only list; NULL: they are files. 0, or -1 with `error`. */
    int (*load)(const struct options *options, struct cf_suite *suite, struct lx_error *error);
    const struct cf_device *(*rows)(void);
    const char *choices; /* letters with which the numbers of decisions begin */
    const char *writes;  /* what it may write, in words; NULL: nothing, and put_back is, too */
    const char *wire;    /* the only one that leads to such encoders; NULL: `open` knows */
    const char *expects; /* what is right in place of another wire; NULL with `wire` */
    size_t size;         /* of the protocol's own struct, which is all 0 before `open` */
    /* Open the wire. 0, or -1 with `error`; to be closed in any case. */
    int (*open)(struct verify_encoder *self, const struct options *options, struct lx_error *error);
    /* Find the encoder at `where` and ask what it is; not for options->restore. 0, or -1 with
       `error`. */
    int (*identify)(struct verify_encoder *self, const char *where, struct lx_error *error);
    /* Look for others on the wire for VERIFY_SCAN, with nothing that they obey. 0, or -1 with
       `error`: somebody is there. */
    int (*scan)(struct verify_encoder *self, struct lx_error *error);
    /* From now on rows are run for the model alone, as delivered, and for `beside`; each wait takes
       `slack` longer. */
    void (*rehearse)(struct verify_encoder *self, const struct cf_beside *beside, dg_ns slack);
    /* What the request needs, bits of enum cf_need. */
    unsigned (*needs)(struct verify_encoder *self, const struct cf_unit *request);
    /* Find out where the encoder is, and run rows for it from now on. False: it is lost, as
       `report` says. */
    bool (*begin)(struct verify_encoder *self, struct cf_report *report);
    /* After a row: the encoder is as before it, and answers. False: it is lost, as `report` says.
     */
    bool (*end)(struct verify_encoder *self, struct cf_report *report);
    /* Put back what the notes of the journal say. False: it could not be done, as `report` says. */
    bool (*put_back)(struct verify_encoder *self, struct cf_report *report);
    /* The wire, also when it was not opened; `self` is freed by whoever has made it. */
    void (*close)(struct verify_encoder *self);
};

extern const struct verify_protocol verify_hiperface, verify_canopen, verify_canopen_file,
    verify_interbus, verify_biss, verify_ssi;

/* cf_fail(), and `outcome` is what became of the row. */
bool verify_fail(struct verify_encoder *self, enum verify_outcome outcome, struct cf_report *report,
                 const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Operations of struct cf_beside_ops that are the same for all; `encoder` is a struct verify_encoder.
   Cut the supply, or switch it on and wait until the encoder is there. */
bool verify_powered(void *encoder, bool on, struct cf_report *report);
/* A row whose needs are not allowed is not run. */
bool verify_allowed(void *encoder, unsigned wanted, struct cf_report *report);

/* " 40 42 02", or "nothing". @return its length */
size_t verify_print_unit(const struct cf_unit *unit, char *to, size_t size);

/* A row that was run, or was not. */
struct verify_row {
    enum verify_outcome outcome;
    char *text; /* owned; why; NULL: it agrees */
};

/* A list of clauses, and what became of its rows, one for each. */
struct verify_suite {
    struct cf_suite *rows;      /* owned */
    struct verify_row *results; /* owned */
    const char *name;
};

/* Everything that was found out. */
struct verify_result {
    const char *model;
    const struct verify_encoder *encoder;
    struct verify_suite suites[VERIFY_SUITES_MAX];
    size_t suite_count;
    char **words; /* beginnings of the clauses that are asked for; none: all are */
    size_t word_count;
    char lost[VERIFY_TEXT_MAX]; /* why it ended early; "" : it did not */
};

/* Load the lists of the protocol. 0, or -1 with `error`; to be unloaded in any case. */
int verify_load_suites(struct verify_result *self, const struct verify_protocol *protocol,
                       const struct options *options, struct lx_error *error);
void verify_unload_suites(struct verify_result *self);

/* Whether the clause is asked for. */
bool verify_asked(const struct verify_result *result, const char *clause);

/* What became of a clause, and of which row that is; NULL: no row is about it. */
enum verify_outcome verify_clause(const struct verify_suite *suite, const struct cf_clause *clause,
                                  const struct verify_row **because);

/* A line a clause, and the sum. */
void verify_print_lines(const struct verify_result *result, FILE *to);
/* For programs: an array of objects. */
void verify_print_json(const struct verify_result *result, FILE *to);
/* For CI: a test case a clause. */
void verify_print_junit(const struct verify_result *result, FILE *to);
/* For people: model, firmware, differences, and what it says about choices. */
void verify_print_report(const struct verify_result *result, FILE *to);

#endif
