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
        .help = "the models",
        .takes = " json ",
    },
    {
        .name = "faults",
        .command = COMMAND_FAULTS,
        .usage = "faults MODEL [--json]",
        .help = "what can happen to an encoder, and what it does about it",
        .takes = " json model ",
    },
    {
        .name = "run",
        .command = COMMAND_RUN,
        .wires = true,
        .usage = "run MODEL [WIRE] [OPTIONS]",
        .help = "be that encoder",
    },
    {
        .name = "run",
        .command = COMMAND_RUN,
        .wires = true,
        .usage = "run RIG.ini [--control ...]",
        .help = "be all encoders of a rig file",
    },
    {
        .name = "run",
        .command = COMMAND_RUN,
        .wires = true,
        .usage = "run FILE.eds [WIRE] [OPTIONS]",
        .help = "be the CANopen encoder of an EDS or DCF file; - is stdin",
    },
    {
        .name = "check",
        .command = COMMAND_CHECK,
        .usage = "check FILE.eds",
        .help = "what is simulated of an EDS or DCF file, what is a value only, what is left out",
        .takes = "",
    },
    {
        .name = "eds",
        .command = COMMAND_EDS,
        .usage = "eds MODEL",
        .help = "the EDS file of a CANopen encoder",
        .takes = " explain ",
        .stack = &dg_cia406_stack,
    },
    {
        .name = "eds",
        .command = COMMAND_EDS,
        .usage = "eds FILE.eds --explain",
        .help = "what each object of an EDS or DCF file does as an encoder",
        .takes = " explain ",
    },
    {
        .name = "model",
        .command = COMMAND_MODEL,
        .usage = "model MODEL --c",
        .help = "a model as C, for a program of your own",
        .takes = " c model ",
    },
    {
        .name = "biss",
        .command = COMMAND_ASK,
        .usage = "biss MODEL ACTION [OPTIONS]",
        .help = "ask a BiSS encoder over a simulated wire; ACTION, one or more: read, registers "
                "[BANK:]ADDR N, eds, write [BANK:]ADDR BYTES, command N",
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
        .help = "the Modbus registers of an INTERBUS encoder",
        .takes = " ring model ",
        .stack = &dg_ib_stack,
    },
    {
        .name = "fmu",
        .command = COMMAND_FMU,
        .usage = "fmu MODEL --output FILE.fmu [OPTIONS]",
        .help = "write that encoder as an FMU, for co-simulation",
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
        .help = "ask a real encoder what the clauses of its manual say",
        .takes =
            " model node alone write irreversible restore journal power junit report json quiet ",
        .ask = verify_command,
    },
    {
        .name = "ctl",
        .command = COMMAND_CTL,
        .usage = "ctl [--control ADDR] COMMAND",
        .help = "SCPI to what is running; SYST:HELP? says which",
        .takes = " control timeout ",
    },
    {
        .name = "top",
        .command = COMMAND_TOP,
        .usage = "top [ADDRESS]",
        .help = "what is running, in a terminal; ? says the keys",
        .takes = " control ",
    },
    {
        .name = "web",
        .command = COMMAND_WEB,
        .usage = "web [ADDRESS] [OPTIONS]",
        .help = "what is running, in a browser",
        .takes = " control listen token watch ",
    },
    {
        .name = "explain",
        .command = COMMAND_EXPLAIN,
        .usage = "explain CAPTURE [--against=MODEL]",
        .help = "a recording of a real conversation in words, or what a model says otherwise",
        .takes = " against address node set quiet ",
    },
    {
        .name = "help",
        .command = COMMAND_HELP,
        .usage = "help [COMMAND [MODEL]]",
        .help = "this text, or that of a command",
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
