/* SPDX-License-Identifier: MIT */
/* All options but the wires, a row for each. */
#ifndef DREHGEBER_TOOL_OPTIONS_ROWS_H
#define DREHGEBER_TOOL_OPTIONS_ROWS_H

#include <argp.h>
#include <stddef.h>

enum option_key {
    KEY_HELP = 'h',
    KEY_VERSION = 'V',
    KEY_QUIET = 'q',
    KEY_OUTPUT = 'o',
    KEY_NODE = 256,
    KEY_TRACE,
    KEY_FILES,
    KEY_TIME,
    KEY_FMI,
    KEY_LISTEN,
    KEY_TOKEN,
    KEY_WATCH,
    KEY_TIMEOUT,
    KEY_AGAINST,
    KEY_ADDRESS,
    KEY_C,
    KEY_MODEL,
    KEY_JSON,
    KEY_EXPLAIN,
    KEY_RING,
    KEY_NVM,
    KEY_NVM_CONVERT,
    KEY_SERIAL,
    KEY_SET,
    KEY_SHAFT,
    KEY_CONTROL,
    KEY_VERBOSE,
    KEY_ALONE,
    KEY_WRITE,
    KEY_IRREVERSIBLE,
    KEY_RESTORE,
    KEY_JOURNAL,
    KEY_POWER,
    KEY_JUNIT,
    KEY_REPORT,
    KEY_WIRE, /* and one more for each kind of wire */
};

/* They stand behind the wires. */
extern const struct argp_option option_rows[];
extern const size_t option_row_count;

#endif
