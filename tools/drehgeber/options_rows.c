/* SPDX-License-Identifier: MIT */
#include "options_rows.h"

#include "drehgeber/api.h"

const struct argp_option option_rows[] = {
    {
        .doc = "Options:",
        .group = 2,
    },
    {
        .name = "ring",
        .key = KEY_RING,
        .arg = "MODELS",
        .doc = "INTERBUS: all encoders of the ring, separated by commas",
    },
    {
        .name = "model",
        .key = KEY_MODEL,
        .arg = "FILE",
        .doc = "a file with models; MODEL is one of them (default: the last one)",
    },
    {
        .name = "nvm",
        .key = KEY_NVM,
        .arg = "FILE",
        .doc = "keep the EEPROM in FILE, which is created if it does not exist (default: the "
               "EEPROM is lost at the end)",
    },
    {
        .name = "nvm-convert",
        .key = KEY_NVM_CONVERT,
        .arg = "NEW",
        .doc =
            "EDS, .ini: --nvm FILE is from another encoder; copy the values that fit into NEW, and "
            "use NEW",
    },
    {
        .name = "serial",
        .key = KEY_SERIAL,
        .arg = "N",
        .doc = "serial number, up to 9 digits (CANopen: 10)",
    },
    {
        .name = "node",
        .key = KEY_NODE,
        .arg = "N[..M]",
        .doc = "CANopen node-ID (default: 63), or several; each node keeps its EEPROM in its own "
               "FILE.N",
    },
    {
        .name = "shaft",
        .key = KEY_SHAFT,
        .arg = "MOTION",
        .doc = "how the shaft moves, see below (default: 0)",
    },
    {
        .name = "set",
        .key = KEY_SET,
        .arg = "KEY=VALUE",
        .doc = "change a setting, see below; may be given several times",
    },
    {
        .name = "control",
        .key = KEY_CONTROL,
        .arg = "ADDRESS",
        .doc = "accept SCPI on unix:PATH or tcp:HOST:PORT; add ,open to accept other machines than "
               "this one, and ,token=FILE to require a token; may be given several times; ctl also "
               "takes tty:PATH, the console of a board (default: "
               "unix:$XDG_RUNTIME_DIR/drehgeber/NAME.sock; in a service "
               "unix:$RUNTIME_DIRECTORY/NAME.sock)",
    },
    {
        .name = "files",
        .key = KEY_FILES,
        .arg = "DIR",
        .doc = "SCPI clients may only name traces, recordings and motions below DIR (default: the "
               "working directory for unix:, none for tcp:)",
    },
    {
        .name = "trace",
        .key = KEY_TRACE,
        .arg = "FILE",
        .doc = "record the wire in FILE: .vcd (RS485, BiSS, SSI), .log or .pcapng (CAN), .csv "
               "(INTERBUS)",
    },
    {
        .name = "time",
        .key = KEY_TIME,
        .arg = "virtual:SPAN",
        .doc = "run for 2.5S, 10MIN, 1H or another span of virtual time, as fast as the machine "
               "can, and stop",
    },
    {
        .name = "output",
        .key = KEY_OUTPUT,
        .arg = "FILE",
        .doc = "write the FMU to FILE",
    },
    {
        .name = "fmi",
        .key = KEY_FMI,
        .arg = "VERSION",
        .doc = "FMI version: 3, or 2, which has signals only (default: 3)",
    },
    {
        .name = "listen",
        .key = KEY_LISTEN,
        .arg = "HOST:PORT",
        .doc = "serve the page there; port 0 is any free port; add ,open to serve other machines "
               "than this one (default: 127.0.0.1:8080)",
    },
    {
        .name = "token",
        .key = KEY_TOKEN,
        .arg = "FILE",
        .doc = "require the token in FILE (default: a new token, which is part of the printed "
               "address)",
    },
    {
        .name = "watch",
        .key = KEY_WATCH,
        .doc = "the page only shows the rig; it cannot change it",
    },
    {
        .name = "timeout",
        .key = KEY_TIMEOUT,
        .arg = "SPAN",
        .doc = "stop when no answer has come for 10S, 5MIN or another span (default: 60S, no limit "
               "with *OPC? or *WAI)",
    },
    {
        .name = "against",
        .key = KEY_AGAINST,
        .arg = "MODEL",
        .doc = "send the same requests to MODEL, and print only the differences",
    },
    {
        .name = "address",
        .key = KEY_ADDRESS,
        .arg = "N",
        .doc = "address of the encoder in the recording (default: the address of MODEL as "
               "delivered)",
    },
    {
        .name = "c",
        .key = KEY_C,
        .doc = "print C: the figures, and a device that uses them",
    },
    {
        .name = "json",
        .key = KEY_JSON,
        .doc = "print JSON: an array of objects",
    },
    {
        .name = "explain",
        .key = KEY_EXPLAIN,
        .doc = "explain what each object of FILE.eds does in the simulated encoder",
    },
    {
        .name = "alone",
        .key = KEY_ALONE,
        .doc = "the encoder is alone on the wire: also send requests that other devices would obey",
    },
    {
        .name = "write",
        .key = KEY_WRITE,
        .doc =
            "also make experiments that change the encoder, and put back the old values after each",
    },
    {
        .name = "irreversible",
        .key = KEY_IRREVERSIBLE,
        .doc = "with --write: also make changes that cannot be put back",
    },
    {
        .name = "restore",
        .key = KEY_RESTORE,
        .doc = "put back the old values after an interrupted run, and check nothing",
    },
    {
        .name = "journal",
        .key = KEY_JOURNAL,
        .arg = "FILE",
        .doc = "with --write: write the old values to FILE (default: drehgeber/verify.journal in "
               "$XDG_STATE_HOME)",
    },
    {
        .name = "power",
        .key = KEY_POWER,
        .arg = "COMMAND",
        .doc =
            "run 'COMMAND off' and 'COMMAND on' to switch the supply (default: ask on the terminal)",
    },
    {
        .name = "junit",
        .key = KEY_JUNIT,
        .arg = "FILE",
        .doc = "write the results to FILE as JUnit XML for CI, with a test case for each clause",
    },
    {
        .name = "report",
        .key = KEY_REPORT,
        .arg = "FILE",
        .doc = "write the results to FILE as text for an issue, without the serial number",
    },
    {
        .name = "verbose",
        .key = KEY_VERBOSE,
        .doc = "print each message on the wire in words, on stderr",
    },
    {
        .name = "quiet",
        .key = KEY_QUIET,
        .doc = "print no notes on stderr, only warnings and errors",
    },
    {
        .name = "help",
        .key = KEY_HELP,
        .doc = "print this text, or after a command the help of that command, and start nothing",
    },
    {
        .name = "version",
        .key = KEY_VERSION,
        .doc = "print the version",
    },
};
const size_t option_row_count = DG_COUNT(option_rows);
