/* SPDX-License-Identifier: MIT */
/* The commands: a row for each way to call one. */
#include <string.h>

#include "biss.h"
#include "drehgeber/drehgeber.h"
#include "options.h"
#include "ssi.h"
#include "verify.h"

const struct command_row command_rows[] = {
    {
        .name = "list",
        .command = COMMAND_LIST,
        .usage = "list [--json]",
        .help = "print the models",
        .takes = " json ",
    },
    {
        .name = "faults",
        .command = COMMAND_FAULTS,
        .usage = "faults MODEL [--json]",
        .help = "print what can break in an encoder, and how it reacts",
        .takes = " json model ",
    },
    {
        .name = "run",
        .command = COMMAND_RUN,
        .wires = true,
        .usage = "run MODEL [WIRE] [OPTIONS]",
        .help = "simulate this encoder",
    },
    {
        .name = "run",
        .command = COMMAND_RUN,
        .wires = true,
        .usage = "run RIG.ini [--control ...]",
        .help = "simulate all encoders of a rig file",
    },
    {
        .name = "run",
        .command = COMMAND_RUN,
        .wires = true,
        .usage = "run FILE.eds [WIRE] [OPTIONS]",
        .help = "simulate the CANopen encoder of an EDS or DCF file; - is stdin",
    },
    {
        .name = "check",
        .command = COMMAND_CHECK,
        .usage = "check FILE.eds",
        .help = "print which objects of an EDS or DCF file are simulated, only store a value, or "
                "are left out",
        .takes = "",
    },
    {
        .name = "eds",
        .command = COMMAND_EDS,
        .usage = "eds MODEL",
        .help = "print the EDS file of a CANopen encoder",
        .takes = " explain ",
        .stack = &dg_cia406_stack,
    },
    {
        .name = "eds",
        .command = COMMAND_EDS,
        .usage = "eds FILE.eds --explain",
        .help = "print what each object of an EDS or DCF file does in the simulated encoder",
        .takes = " explain ",
    },
    {
        .name = "model",
        .command = COMMAND_MODEL,
        .usage = "model MODEL --c",
        .help = "print a model as C source for your own program",
        .takes = " c model ",
    },
    {
        .name = "biss",
        .command = COMMAND_ASK,
        .usage = "biss MODEL ACTION [OPTIONS]",
        .help = "read and write a BiSS encoder over a simulated wire; one or more ACTIONs: read, "
                "registers [BANK:]ADDR N, eds, write [BANK:]ADDR BYTES, command N",
        .takes = " set nvm serial shaft trace model ",
        .ask = biss_command,
        .stack = &dg_biss_stack,
        .words = "read registers eds write command",
    },
    {
        .name = "ssi",
        .command = COMMAND_ASK,
        .usage = "ssi MODEL read [OPTIONS]",
        .help = "read an SSI encoder over a simulated wire",
        .takes = " set shaft trace model ",
        .ask = ssi_command,
        .stack = &dg_ssi_stack,
        .words = "read",
    },
    {
        .name = "map",
        .command = COMMAND_MAP,
        .usage = "map MODEL",
        .help = "print the Modbus registers of an INTERBUS encoder",
        .takes = " ring model ",
        .stack = &dg_ib_stack,
    },
    {
        .name = "fmu",
        .command = COMMAND_FMU,
        .usage = "fmu MODEL --output FILE.fmu [OPTIONS]",
        .help = "write an FMU of this encoder for co-simulation",
        .takes = " output fmi set serial node model ",
    },
    {
        .name = "fmu",
        .command = COMMAND_FMU,
        .usage = "fmu RIG.ini --output FILE.fmu [--fmi 2]",
        .help = "write all encoders of a rig as one FMU",
        .takes = " output fmi set serial node ",
    },
    {
        .name = "verify",
        .command = COMMAND_VERIFY,
        .wires = true,
        .usage = "verify MODEL WIRE [CLAUSE ...] [OPTIONS]",
        .help = "check a real encoder against the clauses of its manual",
        .takes =
            " model node set alone write irreversible restore journal power junit report json quiet ",
        .ask = verify_command,
    },
    {
        .name = "ctl",
        .command = COMMAND_CTL,
        .usage = "ctl [--control ADDR] COMMAND",
        .help = "send SCPI commands to a running rig; SYST:HELP? lists them",
        .takes = " control timeout ",
    },
    {
        .name = "top",
        .command = COMMAND_TOP,
        .usage = "top [ADDRESS]",
        .help = "show a running rig in a terminal; ? lists the keys",
        .takes = " control ",
    },
    {
        .name = "web",
        .command = COMMAND_WEB,
        .usage = "web [ADDRESS] [OPTIONS]",
        .help = "show a running rig in a browser",
        .takes = " control listen token watch ",
    },
    {
        .name = "explain",
        .command = COMMAND_EXPLAIN,
        .usage = "explain CAPTURE [--against=MODEL]",
        .help = "print a recording of a real bus in words, or print where a model answers "
                "differently",
        .takes = " against address node set quiet ",
    },
    {
        .name = "help",
        .command = COMMAND_HELP,
        .usage = "help [COMMAND [MODEL]]",
        .help = "print this text, or the help of a command",
        .takes = "",
    },
};
const size_t command_row_count = DG_COUNT(command_rows);

const struct command_row *command_find(const char *name)
{
    for (size_t i = 0; i < command_row_count; i++) {
        if (strcmp(command_rows[i].name, name) == 0) {
            return &command_rows[i];
        }
    }
    return NULL;
}
