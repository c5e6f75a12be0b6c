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
    {"INSTrument:SELect",     dg_control_select,           dg_control_selection,    0, "NAME", "the encoder that this session works on; the first one to begin with"},
    {"INSTrument:MODel",      NULL,                        dg_control_model,        0, "", "its model"},
    {"INSTrument:WIRE",       NULL,                        dg_control_wire,         0, "", "the address of its wire, as in its ready line"},

    {"SHAFt:CATalog",         NULL,                        dg_control_shafts,       0, "", "names of all shafts"},
    {"SHAFt:NAME",            NULL,                        dg_control_shaft_name,   0, "", "the shaft that the encoder sits on; all of SHAFt works on it"},
    {"SHAFt:POSition",        dg_control_set_position,     dg_control_position,     0, "ANGLE", "be there, at rest; DEG or REV"},
    {"SHAFt:VELocity",        dg_control_set_velocity,     dg_control_velocity,     0, "SPEED", "turn at it; RPM"},
    {"SHAFt:ACCeleration",    dg_control_set_acceleration, dg_control_acceleration, 0, "RPM/S", "of what is to come; 0: at once"},
    {"SHAFt:STOP",            dg_control_stop,             NULL,                    0, "", "come to rest"},
    {"SHAFt:MOVE",            dg_control_move,             NULL,                    0, "ANGLE[,SPEED]", "go there, at 60 RPM without SPEED; *OPC? and *WAI wait for it"},
    {"SHAFt:MOVing",          NULL,                        dg_control_moving,       0, "", "1 while a move, a stop or a change of speed takes time, or a profile is played"},
    {"SHAFt:PROFile",         dg_control_set_profile,      dg_control_profile,      0, "\"MOTION\"", "play a motion as --shaft takes it, or a CSV file"},
    {"SHAFt:RECord:STARt",    dg_control_record,           NULL,                    0, "\"FILE.csv\"[,INTERVAL]", "record the angle every INTERVAL, 1 MS without it"},
    {"SHAFt:RECord:STOP",     dg_control_record_stop,      NULL,                    0, "", "end the recording"},

    DG_QUANTITIES(QUANTITY)
    {"WORLd:DEFault",         dg_control_healthy,          NULL,                    0, "", "everything of the encoder's world is healthy"},

    {"FAULt:CATalog",         NULL,                        dg_control_catalogue,    0, "", "name, kind, cause, effect, chapter of everything that can happen to the encoder"},
    {"FAULt:SET",             dg_control_fault,            NULL,                    0, "NAME[,COUNt N][,PROBability P][,DURation TIME]", "let it happen: to N frames, to each frame with probability P (0..1), for TIME, whose unit has to be said; else until cleared"},
    {"FAULt:CLEar",           dg_control_clear,            NULL,                    0, "[NAME]", "make it good; all of them without NAME"},
    {"FAULt:ACTive",          NULL,                        dg_control_active,       0, "", "names of the faults at work"},
    {"FAULt:HAPPened",        NULL,                        dg_control_happened,     0, "NAME", "frames it has happened to since it was set"},

    {"NVM:CATalog",           NULL,                        dg_control_regions,      0, "", "regions of the EEPROM"},
    {"NVM:DATA",              NULL,                        dg_control_data,         0, "[ADDRESS[,N]]", "N bytes of it from ADDRESS on, in hexadecimal digits; all of it without"},
    {"NVM:CORRupt",           dg_control_corrupt,          NULL,                    0, "REGION", "flip a bit of it; FAULt:CLEar makes it good unless the region is an unchecked one; seen from the next start on"},
    {"NVM:ERASe",             dg_control_erase,            NULL,                    0, "", "the EEPROM is in its delivery state; the power has to be off"},

    {"POWer",                 dg_control_power,            dg_control_powered,      0, "OFF|ON|CYCLe", "of the encoder"},
    {"STATe",                 NULL,                        dg_control_state,        0, "", "KEY=VALUE for power, mode, position, LEDs, errors and counters"},

    {"TIME",                  NULL,                        dg_control_time,         0, "", "in seconds since the rig began, by its clock"},
    {"TIME:ORIGin",           NULL,                        dg_control_origin,       0, "", "when the rig began, in seconds of the host's clock: CLOCK_MONOTONIC on Linux"},
    {"TIME:SCALe",            dg_control_set_scale,        dg_control_scale,        0, "FACTOR", "how fast it goes; 0 stops it; on simulated wires only"},
    {"TIME:STEP",             dg_control_step_time,        NULL,                    0, "TIME", "let it pass while the clock stands still"},

    {"TRACe:STARt",           dg_control_trace,            NULL,                    0, "\"FILE\"", "what goes over the encoder's wire"},
    {"TRACe:STOP",            dg_control_trace_stop,       NULL,                    0, "", "end the trace"},
    {"TRACe:LAST",            NULL,                        dg_control_last,         0, "[N]", "the last N frames in words, the newest last; one without N"},
    {"TRACe:LAST:SEVerity",   NULL,                        dg_control_severity,     0, "[N]", "of each of these frames: OK, NOTICE, WARNING or ERROR"},
};
/* clang-format on */

const struct dg_scpi_commands dg_control_commands = {rows, DG_COUNT(rows)};
