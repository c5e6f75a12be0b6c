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
        .doc = "INTERBUS: all encoders of the ring, with commas between them",
    },
    {
        .name = "model",
        .key = KEY_MODEL,
        .arg = "FILE",
        .doc = "a file of models: MODEL is one of them (default: the last one)",
    },
    {
        .name = "nvm",
        .key = KEY_NVM,
        .arg = "FILE",
        .doc = "keep the EEPROM in FILE, made when it does not exist (default: forgotten at the "
               "end)",
    },
    {
        .name = "nvm-convert",
        .key = KEY_NVM_CONVERT,
        .arg = "NEW",
        .doc =
            "EDS, .ini: make NEW of what fits of --nvm FILE, which is of another one, and use it",
    },
    {
        .name = "serial",
        .key = KEY_SERIAL,
        .arg = "N",
        .doc = "serial number, up to 9 digits, CANopen 10",
    },
    {
        .name = "node",
        .key = KEY_NODE,
        .arg = "N[..M]",
        .doc = "CANopen node-ID (default: 63), or several; each has its own EEPROM FILE.N",
    },
    {
        .name = "shaft",
        .key = KEY_SHAFT,
        .arg = "MOTION",
        .doc = "what the shaft does, see below (default: 0)",
    },
    {
        .name = "set",
        .key = KEY_SET,
        .arg = "KEY=VALUE",
        .doc = "see below; may be given again",
    },
    {
        .name = "control",
        .key = KEY_CONTROL,
        .arg = "ADDRESS",
        .doc = "SCPI at unix:PATH or tcp:HOST:PORT (loopback; ,open: beyond it, too), ,token=FILE "
               "behind it: for who knows the token; may be given again; for ctl also tty:PATH, "
               "the console of a board (default: unix:$XDG_RUNTIME_DIR/drehgeber/NAME.sock; in a "
               "service unix:$RUNTIME_DIRECTORY/NAME.sock)",
    },
    {
        .name = "files",
        .key = KEY_FILES,
        .arg = "DIR",
        .doc = "traces, recordings and motions that SCPI names lie below DIR (default: here for "
               "unix:, nowhere for tcp:)",
    },
    {
        .name = "trace",
        .key = KEY_TRACE,
        .arg = "FILE",
        .doc = "what goes over the wire: .vcd (RS485, BiSS, SSI), .log or .pcapng (CAN), .csv "
               "(INTERBUS)",
    },
    {
        .name = "time",
        .key = KEY_TIME,
        .arg = "virtual:SPAN",
        .doc = "live for a span such as 2.5S, 10MIN or 1H of virtual time, as fast as the machine "
               "can, and end",
    },
    {
        .name = "output",
        .key = KEY_OUTPUT,
        .arg = "FILE",
        .doc = "the FMU",
    },
    {
        .name = "fmi",
        .key = KEY_FMI,
        .arg = "VERSION",
        .doc = "of the FMU: 3, or 2, which has signals only (default: 3)",
    },
    {
        .name = "listen",
        .key = KEY_LISTEN,
        .arg = "HOST:PORT",
        .doc = "of the page (loopback; ,open: beyond it, too; port 0: any free one; default: "
               "127.0.0.1:8080)",
    },
    {
        .name = "token",
        .key = KEY_TOKEN,
        .arg = "FILE",
        .doc = "for who knows the token in FILE (default: a new one, in the address that is "
               "printed)",
    },
    {
        .name = "watch",
        .key = KEY_WATCH,
        .doc = "the page shows, and changes nothing",
    },
    {
        .name = "timeout",
        .key = KEY_TIMEOUT,
        .arg = "SPAN",
        .doc = "end when nothing has come for a span such as 10S or 5MIN (default: 60S, no limit "
               "with *OPC? or *WAI)",
    },
    {
        .name = "against",
        .key = KEY_AGAINST,
        .arg = "MODEL",
        .doc = "ask MODEL the same, and print the differences only",
    },
    {
        .name = "address",
        .key = KEY_ADDRESS,
        .arg = "N",
        .doc = "of the encoder in the recording (default: that of MODEL as delivered)",
    },
    {
        .name = "c",
        .key = KEY_C,
        .doc = "for a compiler: figures, and a device that has them",
    },
    {
        .name = "json",
        .key = KEY_JSON,
        .doc = "for programs: an array of objects",
    },
    {
        .name = "explain",
        .key = KEY_EXPLAIN,
        .doc = "of a FILE.eds: what each object does as an encoder",
    },
    {
        .name = "alone",
        .key = KEY_ALONE,
        .doc = "send also what reaches others on the wire, when nobody else is there",
    },
    {
        .name = "write",
        .key = KEY_WRITE,
        .doc = "change the encoder, too, and put everything back after each experiment",
    },
    {
        .name = "irreversible",
        .key = KEY_IRREVERSIBLE,
        .doc = "with --write also what cannot be put back",
    },
    {
        .name = "restore",
        .key = KEY_RESTORE,
        .doc = "only put back what a run that was cut off has left changed",
    },
    {
        .name = "journal",
        .key = KEY_JOURNAL,
        .arg = "FILE",
        .doc = "of --write: what is to be put back (default: drehgeber/verify.journal in "
               "$XDG_STATE_HOME)",
    },
    {
        .name = "power",
        .key = KEY_POWER,
        .arg = "COMMAND",
        .doc =
            "cut the supply by 'COMMAND off' and 'COMMAND on' (default: you are asked to, on a terminal)",
    },
    {
        .name = "junit",
        .key = KEY_JUNIT,
        .arg = "FILE",
        .doc = "what was found out, for CI: a test case for each clause",
    },
    {
        .name = "report",
        .key = KEY_REPORT,
        .arg = "FILE",
        .doc = "what was found out, as a text for an issue, without the serial number",
    },
    {
        .name = "verbose",
        .key = KEY_VERBOSE,
        .doc = "what goes over the wire in words, on stderr",
    },
    {
        .name = "quiet",
        .key = KEY_QUIET,
        .doc = "no notes on stderr, only complaints",
    },
    {
        .name = "help",
        .key = KEY_HELP,
        .doc = "this text; behind a command that of the command, and nothing is started",
    },
    {
        .name = "version",
        .key = KEY_VERSION,
        .doc = "the version",
    },
};
const size_t option_row_count = DG_COUNT(option_rows);
