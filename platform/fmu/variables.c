/* SPDX-License-Identifier: MIT */
/*
 * The list of variables: what an encoder has by its medium and by what it can do stands in tables,
 * settings, world and faults are asked of the encoder.
 */
#include <stdio.h>
#include <string.h>

#include "encoder.h"

/* Which encoders have a row: a bit of FMU_HAS_... . */
#define ANY 0xFFu
#define SERIAL FMU_HAS_CHARACTERS
#define CAN FMU_HAS_FRAMES
#define SINCOS FMU_HAS_SINCOS
#define MASTER FMU_HAS_MASTER

struct fixed_row {
    uint8_t of; /* encoders that have one of these */
    uint8_t group, index, type;
    bool input, continuous;
    const char *name;
    const char *unit;
    const char *start;
    const char *help;
};

/* clang-format off */
static const struct fixed_row of_shaft[] = {
    {ANY, FMU_INPUT, FMU_ANGLE, FMU_REAL, true, true,  "angle", "rad",   "0",    "of the shaft, clockwise looking at it, any number of turns"},
    {ANY, FMU_INPUT, FMU_SPEED, FMU_REAL, true, true,  "speed", "rad/s", "0",    "of the shaft: goes on with it within a step"},
};

static const struct fixed_row before[] = {
    {ANY, FMU_INPUT, FMU_POWER, FMU_BOOL, true, false, "power", "",      "true", "supply: off and on again is a restart"},
};

static const struct fixed_row behind[] = {
    {ANY,    FMU_OUTPUT, FMU_POSITION,       FMU_INT,    false, false, "position",         "",  "", "counts as the wire would tell them now"},
    {SINCOS, FMU_OUTPUT, FMU_SIN_PLUS,       FMU_REAL,   false, true,  "sin_plus",         "V", "", "process channel SIN+"},
    {SINCOS, FMU_OUTPUT, FMU_SIN_MINUS,      FMU_REAL,   false, true,  "sin_minus",        "V", "", "process channel REFSIN"},
    {SINCOS, FMU_OUTPUT, FMU_COS_PLUS,       FMU_REAL,   false, true,  "cos_plus",         "V", "", "process channel COS+"},
    {SINCOS, FMU_OUTPUT, FMU_COS_MINUS,      FMU_REAL,   false, true,  "cos_minus",        "V", "", "process channel REFCOS"},
    {MASTER, FMU_OUTPUT, FMU_FRAME,          FMU_INT,    false, false, "frame",            "",  "", "bits of the last frame behind start bit and CDS, right-aligned"},
    {MASTER, FMU_OUTPUT, FMU_FRAME_BITS,     FMU_INT,    false, false, "frame.bits",       "",  "", "how many they are; 0: there was none"},
    {MASTER, FMU_OUTPUT, FMU_FRAME_POSITION, FMU_INT,    false, false, "frame.position",   "",  "", "multiturn and singleturn of that frame, binary"},
    {MASTER, FMU_OUTPUT, FMU_FRAME_GOOD,     FMU_BOOL,   false, false, "frame.good",       "",  "", "its check sum or parity fits"},
    {MASTER, FMU_OUTPUT, FMU_NERR,           FMU_BOOL,   false, false, "nERR",             "",  "", "false: that frame tells an error"},
    {MASTER, FMU_OUTPUT, FMU_NWARN,          FMU_BOOL,   false, false, "nWARN",            "",  "", "false: that frame tells a warning (BiSS)"},
    {CAN,    FMU_OUTPUT, FMU_ERROR_CODE,     FMU_INT,    false, false, "error.code",       "",  "", "of the last EMCY; 0: none"},
    {CAN,    FMU_OUTPUT, FMU_ERROR_REGISTER, FMU_INT,    false, false, "error.register",   "",  "", "1001h as the last EMCY told it"},
    {CAN,    FMU_OUTPUT, FMU_BUS_STATE,      FMU_INT,    false, false, "bus_state",        "",  "", "of the controller: 0 error active, 1 passive, 2 bus-off"},
    {MASTER, FMU_BUS,    FMU_MA,             FMU_CLOCK,  true,  false, "MA",               "",  "", "the master begins a frame: position and errors are latched at this moment"},
    {CAN,    FMU_BUS,    FMU_RX,             FMU_BINARY, true,  false, "CanChannel.Rx_Data",  "", "", "operations of FMI-LS-BUS from the bus"},
    {CAN,    FMU_BUS,    FMU_TX,             FMU_BINARY, false, false, "CanChannel.Tx_Data",  "", "", "operations of FMI-LS-BUS to the bus"},
    {CAN,    FMU_BUS,    FMU_RX_CLOCK,       FMU_CLOCK,  true,  false, "CanChannel.Rx_Clock", "", "", "Rx_Data comes"},
    {CAN,    FMU_BUS,    FMU_TX_CLOCK,       FMU_CLOCK,  false, false, "CanChannel.Tx_Clock", "", "", "Tx_Data waits"},
    {SERIAL, FMU_BUS,    FMU_RX,             FMU_BINARY, true,  false, "RS485.Rx_Data",    "",  "", "characters of the master"},
    {SERIAL, FMU_BUS,    FMU_TX,             FMU_BINARY, false, false, "RS485.Tx_Data",    "",  "", "characters of the encoder"},
    {SERIAL, FMU_BUS,    FMU_RX_CLOCK,       FMU_CLOCK,  true,  false, "RS485.Rx_Clock",   "",  "", "Rx_Data comes"},
    {SERIAL, FMU_BUS,    FMU_TX_CLOCK,       FMU_CLOCK,  false, false, "RS485.Tx_Clock",   "",  "", "Tx_Data waits"},
};
/* clang-format on */

static void name_variable(struct fmu_variable *to, const char *prefix, const char *room,
                          const char *name)
{
    (void)snprintf(to->name, sizeof to->name, "%.48s%.10s%.36s", prefix, room, name);
}

static void describe_row(const struct fixed_row *row, const char *prefix, struct fmu_variable *to)
{
    to->reference = (uint32_t)row->group << 8 | row->index;
    to->type = (enum fmu_type)row->type;
    to->input = row->input;
    to->continuous = row->continuous;
    to->wire = row->type != FMU_BINARY ? 0 : row->of == CAN ? 'c' : 's';
    to->unit = row->unit;
    (void)snprintf(to->start, sizeof to->start, "%s", row->start);
    (void)snprintf(to->help, sizeof to->help, "%s", row->help);
    name_variable(to, prefix, "", row->name);
}

/* Row `*index` of those this encoder has; else *index less them. */
static bool fixed(const struct fmu_encoder *of, const struct fixed_row *rows, size_t count,
                  size_t *index, struct fmu_variable *to)
{
    for (size_t i = 0; i < count; i++) {
        const bool of_wire = rows[i].group == FMU_BUS;
        if ((rows[i].of & of->has) != 0 && (!of_wire || of->leads) && (*index)-- == 0) {
            describe_row(&rows[i], of_wire ? of->wire : of->prefix, to);
            to->room = of->room;
            return true;
        }
    }
    return false;
}

/* Inputs of shafts that are described with this encoder; FMU_NOBODY: of those with none. */
static bool turned(const struct fmu *self, size_t encoder, size_t *index, struct fmu_variable *to)
{
    for (size_t i = 0; i < self->shaft_count; i++) {
        const struct fmu_shaft *shaft = &self->shafts[i];
        if (!shaft->input || shaft->first != encoder) {
            continue;
        }
        if (*index < DG_COUNT(of_shaft)) {
            describe_row(&of_shaft[*index], shaft->prefix, to);
            to->reference |= (uint32_t)i << 16;
            return true;
        }
        *index -= DG_COUNT(of_shaft);
    }
    return false;
}

static bool is_flag(const struct dg_host *host, const char *key)
{
    const char *no = dg_host_word(host, key, 0);
    const char *yes = no == NULL ? NULL : dg_host_word(host, key, 1);
    return yes != NULL && strcmp(no, "0") == 0 && strcmp(yes, "1") == 0 &&
           dg_host_word(host, key, 2) == NULL;
}

enum fmu_type fmu_key_type(const struct dg_host *host, const struct dg_host_key *key)
{
    if (key->type == DG_HOST_KEY_WORD) {
        return is_flag(host, key->name) ? FMU_BOOL : FMU_TEXT;
    }
    if (key->type == DG_HOST_KEY_TEXT) {
        return FMU_TEXT;
    }
    return key->always || key->places > 0 ? FMU_REAL : FMU_INT;
}

/* The help, and the words it may be. */
static void help_on(const struct dg_host *host, const struct dg_host_key *key,
                    struct fmu_variable *to)
{
    size_t n = (size_t)snprintf(to->help, sizeof to->help, "%.160s", key->help);
    for (size_t i = 0; to->type == FMU_TEXT && n < sizeof to->help; i++) {
        const char *word = dg_host_word(host, key->name, i);
        if (word == NULL) {
            return;
        }
        n +=
            (size_t)snprintf(to->help + n, sizeof to->help - n, "%s%s", i == 0 ? ": " : ", ", word);
    }
}

static bool setting(const struct fmu_encoder *of, size_t *index, struct fmu_variable *to)
{
    struct dg_host_key key;
    size_t count = 0;
    while (dg_host_key(of->host, count, &key) == DG_HOST_OK && count != *index) {
        count++;
    }
    if (dg_host_key(of->host, count, &key) != DG_HOST_OK) {
        *index -= count;
        return false;
    }
    to->reference = (uint32_t)(key.always ? FMU_WORLD : FMU_PARAMETER) << 8 | (uint32_t)count;
    to->type = fmu_key_type(of->host, &key);
    to->input = true;
    to->parameter = !key.always;
    to->continuous = to->type == FMU_REAL && key.always;
    to->unit = key.unit;
    to->min = key.min;
    to->max = key.max;
    (void)dg_host_get(of->host, key.name, to->start, sizeof to->start);
    if (to->type == FMU_BOOL) {
        (void)snprintf(to->start, sizeof to->start, "%s", to->start[0] == '1' ? "true" : "false");
    }
    help_on(of->host, &key, to);
    name_variable(to, of->prefix, key.always ? "world." : "", key.name);
    return true;
}

static bool fault(struct fmu_encoder *of, size_t *index, struct fmu_variable *to)
{
    struct dg_host_fault entry;
    size_t count = 0;
    while (count < FMU_FAULTS_MAX && count < *index &&
           of->all->ops->entry(of, count, &entry) == DG_HOST_OK) {
        count++;
    }
    if (count == FMU_FAULTS_MAX || of->all->ops->entry(of, count, &entry) != DG_HOST_OK) {
        *index -= count;
        return false;
    }
    to->reference = (uint32_t)FMU_FAULT << 8 | (uint32_t)count;
    to->type = FMU_BOOL;
    to->input = true;
    (void)snprintf(to->start, sizeof to->start, "false");
    (void)snprintf(to->help, sizeof to->help, "%.100s -> %.140s", entry.cause, entry.effect);
    name_variable(to, of->prefix, "fault.", entry.name);
    return true;
}

/* What an encoder is described with, beside its inputs of shafts. */
static bool described(struct fmu_encoder *of, size_t *index, struct fmu_variable *to)
{
    return fixed(of, before, DG_COUNT(before), index, to) || setting(of, index, to) ||
           fault(of, index, to) || fixed(of, behind, DG_COUNT(behind), index, to);
}

bool fmu_variable(struct fmu *self, size_t index, struct fmu_variable *to)
{
    memset(to, 0, sizeof *to);
    to->unit = "";
    if (index == 0) {
        to->continuous = true;
        (void)snprintf(to->name, sizeof to->name, "time");
        to->unit = "s";
        return true;
    }
    index--;
    (void)fmu_start(self, 0);
    for (size_t i = 0; i < self->count; i++) {
        if (turned(self, i, &index, to)) {
            return true;
        }
        if (described(&self->encoders[i], &index, to)) {
            to->reference |= (uint32_t)i << 16;
            return true;
        }
    }
    return turned(self, FMU_NOBODY, &index, to);
}
