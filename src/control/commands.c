/* SPDX-License-Identifier: MIT */
/*
 * The commands: one row each, in the order of the page.
 */
#include "control_private.h"
#include "drehgeber/quantity.h"

/* Parameter and help of a quantity, by the unit it is counted in. */
#define PARAMETER_MDEGC "TEMPERATURE"
#define PARAMETER_UA "CURRENT"
#define PARAMETER_MV "VOLTAGE"
#define PARAMETER_PERMILLE "PERMILLE"
#define PARAMETER_STATE "ON|OFF"
#define SUFFIXES_MDEGC "; DEGC"
#define SUFFIXES_UA "; UA or MA"
#define SUFFIXES_MV "; MV or V"
#define SUFFIXES_PERMILLE ""
#define SUFFIXES_STATE ""
#define QUANTITY(id, member, name, header, unit, healthy, min, max, multiturn, help)               \
    {"WORLd:" header,  dg_control_set_world, dg_control_world,                                     \
     DG_QUANTITY_##id, PARAMETER_##unit,     help SUFFIXES_##unit},

/* clang-format off */
static const struct dg_scpi_command rows[] = {
    /* header, command, query, argument, parameters (of the query where there is no command), help */
    {"INSTrument:CATalog",    NULL,                        dg_control_encoders,     0, "", "names of all encoders"},
    {"INSTrument:SELect",     dg_control_select,           dg_control_selection,    0, "NAME", "the encoder that this session works on; at the start the first one"},
    {"INSTrument:MODel",      NULL,                        dg_control_model,        0, "", "its model"},
    {"INSTrument:WIRE",       NULL,                        dg_control_wire,         0, "", "the address of its wire, as in its ready line"},

    {"SHAFt:CATalog",         NULL,                        dg_control_shafts,       0, "", "names of all shafts"},
    {"SHAFt:NAME",            NULL,                        dg_control_shaft_name,   0, "", "the shaft of the encoder; all SHAFt commands work on it"},
    {"SHAFt:POSition",        dg_control_set_position,     dg_control_position,     0, "ANGLE", "put the shaft at this angle, at rest; DEG or REV"},
    {"SHAFt:VELocity",        dg_control_set_velocity,     dg_control_velocity,     0, "SPEED", "turn at this speed; RPM"},
    {"SHAFt:ACCeleration",    dg_control_set_acceleration, dg_control_acceleration, 0, "RPM/S", "for the commands after it; 0: at once"},
    {"SHAFt:STOP",            dg_control_stop,             NULL,                    0, "", "stop the shaft"},
    {"SHAFt:MOVE",            dg_control_move,             NULL,                    0, "ANGLE[,SPEED]", "move to this angle, at 60 RPM without SPEED; *OPC? and *WAI wait for it"},
    {"SHAFt:MOVing",          NULL,                        dg_control_moving,       0, "", "1 while a move, a stop or a change of speed takes time, or a profile is played"},
    {"SHAFt:PROFile",         dg_control_set_profile,      dg_control_profile,      0, "\"MOTION\"", "play a motion as --shaft takes it, or a CSV file"},
    {"SHAFt:RECord:STARt",    dg_control_record,           NULL,                    0, "\"FILE.csv\"[,INTERVAL]", "record the angle every INTERVAL, 1 MS without it"},
    {"SHAFt:RECord:STOP",     dg_control_record_stop,      NULL,                    0, "", "end the recording"},

    DG_QUANTITIES(QUANTITY)
    {"WORLd:DEFault",         dg_control_healthy,          NULL,                    0, "", "make everything in the encoder's world healthy"},

    {"FAULt:CATalog",         NULL,                        dg_control_catalogue,    0, "", "name, kind, cause, effect, chapter of everything that can happen to the encoder"},
    {"FAULt:SET",             dg_control_fault,            NULL,                    0, "NAME[,COUNt N][,PROBability P][,DURation TIME]", "cause the fault: in N frames, in each frame with probability P (0..1), or for TIME, which needs a unit; otherwise until it is cleared"},
    {"FAULt:CLEar",           dg_control_clear,            NULL,                    0, "[NAME]", "clear the fault; without NAME all faults"},
    {"FAULt:ACTive",          NULL,                        dg_control_active,       0, "", "names of the active faults"},
    {"FAULt:HAPPened",        NULL,                        dg_control_happened,     0, "NAME", "number of frames that it has affected since it was set"},

    {"NVM:CATalog",           NULL,                        dg_control_regions,      0, "", "regions of the EEPROM"},
    {"NVM:DATA",              NULL,                        dg_control_data,         0, "[ADDRESS[,N]]", "N bytes of the EEPROM from ADDRESS on, in hexadecimal digits; without ADDRESS all of it"},
    {"NVM:CORRupt",           dg_control_corrupt,          NULL,                    0, "REGION", "flip a bit of the region; FAULt:CLEar restores it, except in an unchecked region; seen from the next start on"},
    {"NVM:ERASe",             dg_control_erase,            NULL,                    0, "", "put the EEPROM into its delivery state; the power has to be off"},

    {"POWer",                 dg_control_power,            dg_control_powered,      0, "OFF|ON|CYCLe", "of the encoder"},
    {"STATe",                 NULL,                        dg_control_state,        0, "", "KEY=VALUE for power, mode, position, LEDs, errors and counters"},

    {"TIME",                  NULL,                        dg_control_time,         0, "", "in seconds since the rig began, by its clock"},
    {"TIME:ORIGin",           NULL,                        dg_control_origin,       0, "", "when the rig began, in seconds of the host's clock: CLOCK_MONOTONIC on Linux"},
    {"TIME:SCALe",            dg_control_set_scale,        dg_control_scale,        0, "FACTOR", "speed of the rig's clock; 0 stops it; on simulated wires only"},
    {"TIME:STEP",             dg_control_step_time,        NULL,                    0, "TIME", "let this time pass while the clock is stopped"},

    {"TRACe:STARt",           dg_control_trace,            NULL,                    0, "\"FILE\"", "record the data on the encoder's wire"},
    {"TRACe:STOP",            dg_control_trace_stop,       NULL,                    0, "", "end the trace"},
    {"TRACe:LAST",            NULL,                        dg_control_last,         0, "[N]", "the last N frames in words, the newest last; one without N"},
    {"TRACe:LAST:SEVerity",   NULL,                        dg_control_severity,     0, "[N]", "of each of these frames: OK, NOTICE, WARNING or ERROR"},
};
/* clang-format on */

const struct dg_scpi_commands dg_control_commands = {rows, DG_COUNT(rows)};
