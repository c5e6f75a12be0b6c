/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the SCPI engine: what its files share.
 */
#ifndef DREHGEBER_SCPI_PRIVATE_H
#define DREHGEBER_SCPI_PRIVATE_H

#include "drehgeber/scpi.h"
#include "drehgeber/text.h"

/** common.c: the engine's own commands, looked up before the host's. */
extern const struct dg_scpi_commands dg_scpi_own;

/** header.c: characters and headers. */
size_t dg_scpi_length(const char *text);
bool dg_scpi_is_digit(char c);
/** A part of a pattern between colons. */
struct scpi_node {
    const char *name;
    size_t n; /**< 0: there are no more */
    bool optional;
};
/** The first node of a pattern, or of what is left of it. @return what is left then */
const char *dg_scpi_next_node(const char *pattern, struct scpi_node *out);
/** Whether the `n` characters at `text` are the long or the short form of the `name_length`
 * characters at `name`. */
bool dg_scpi_is_form(const char *name, size_t name_length, const char *text, size_t n);
/** Whether the `n` characters at `header` call `pattern`, see dg_scpi_command.header. */
bool dg_scpi_matches(const char *pattern, const char *header, size_t n);
/** List `index` of all commands, the engine's own first; NULL behind the last. */
const struct dg_scpi_commands *dg_scpi_command_list(const struct dg_scpi *self, size_t index);
/** The row that `header` (without '?') calls, or NULL. */
const struct dg_scpi_command *dg_scpi_find(const struct dg_scpi *self, const char *header, size_t n,
                                           bool query);

/** near.c: raise an error with what would be right. */
/** Nothing is called `header` (n characters, with '?' when it is a query). */
void dg_scpi_refuse_header(struct dg_scpi *self, const char *header, size_t n, bool query);
/** What stands at the place is none of these words. */
void dg_scpi_refuse_word(struct dg_scpi *self, int code, const char *const *words, size_t count);

/** parameter.c: from the place in the line on. */
bool dg_scpi_is_end(char c);
void dg_scpi_skip_blanks(struct dg_scpi *self);
/** Length of what stands at the place, up to a blank, ',' or the end of the command. */
size_t dg_scpi_token(const struct dg_scpi *self);
/** Go to the next parameter. @return false: -109 was raised, or an error before */
bool dg_scpi_next(struct dg_scpi *self);
/** How many parameters there are at `text`, up to the end of a command. */
unsigned dg_scpi_count(const char *text);

/** Room for the detail of an error. */
#define SCPI_DETAIL_SIZE (DG_SCPI_DETAIL_MAX + 1u)

/** Pieces of a line in the help: header, '?', blank, parameters; some of them empty. */
#define SCPI_USAGE 4u

/** status.c: errors. */
/** The pieces of a command's or query's line in the help. */
void dg_scpi_usage(const struct dg_scpi_command *command, bool query,
                   const char *pieces[SCPI_USAGE]);
/** That line. */
void dg_scpi_add_usage(struct dg_text *to, const struct dg_scpi_command *command, bool query);
/** Raise `code` with the command at hand as the help has it. */
void dg_scpi_raise_usage(struct dg_scpi *self, int code);
uint8_t dg_scpi_status_byte(const struct dg_scpi *self);
void dg_scpi_clear_errors(struct dg_scpi *self);
/** Put the oldest error, or `0,"No error"`, and drop it. */
void dg_scpi_put_error(struct dg_scpi *self);
/** With quotes in it doubled; no quotes around it. */
void dg_scpi_append_quoted(struct dg_scpi *self, const char *text);
/** Absolute value. */
uint64_t dg_scpi_magnitude(int64_t value);

#endif
