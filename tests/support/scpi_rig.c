/* SPDX-License-Identifier: MIT */
#include "scpi_rig.h"

#include <string.h>

#define SPEED_MAX 6000000

static const struct dg_scpi_range ranges[SCPI_RIG_VALUES] = {
    [SCPI_RIG_POSITION] = {DG_SCPI_ANGLE, 0, INT64_MIN / 2, INT64_MAX / 2},
    [SCPI_RIG_VELOCITY] = {DG_SCPI_SPEED, 0, -SPEED_MAX, SPEED_MAX},
    [SCPI_RIG_ACCELERATION] = {DG_SCPI_ACCELERATION, 0, 0, 1000000500},
    [SCPI_RIG_SPAN] = {DG_SCPI_TIME, 0, 0, INT64_MAX},
    [SCPI_RIG_TEMPERATURE] = {DG_SCPI_TEMPERATURE, 0, -100000, 200000},
    [SCPI_RIG_SUPPLY] = {DG_SCPI_VOLTAGE, 0, 0, 30000},
    [SCPI_RIG_CURRENT] = {DG_SCPI_CURRENT, 0, 0, 100000},
    [SCPI_RIG_NUMBER] = {DG_SCPI_PLAIN, 0, INT64_MIN, INT64_MAX},
    [SCPI_RIG_BYTE] = {DG_SCPI_PLAIN, 0, 0, 255},
    [SCPI_RIG_THOUSANDTHS] = {DG_SCPI_PLAIN, 3, -1500, 1000},
    [SCPI_RIG_SINE] = {DG_SCPI_PLAIN, 0, -1000, 1000},
    [SCPI_RIG_COSINE] = {DG_SCPI_PLAIN, 0, -1000, 1000},
};

static struct scpi_rig *rig_of(struct dg_scpi *session)
{
    return session->setup.ctx;
}

static void write_out(void *ctx, const char *bytes, size_t n)
{
    struct scpi_rig *self = ctx;

    if (n == 0 || n >= sizeof self->out - self->length) {
        self->lost = true;
        return;
    }
    memcpy(&self->out[self->length], bytes, n);
    self->length += n;
    self->out[self->length] = '\0';
}

static void reset(struct dg_scpi *session)
{
    rig_of(session)->resets++;
}

static dg_ns settled(struct dg_scpi *session)
{
    rig_of(session)->asked++;
    return rig_of(session)->settles;
}

static void take_number(struct dg_scpi *session, uint32_t value)
{
    if (dg_scpi_number(session, &ranges[value], &rig_of(session)->values[value])) {
        rig_of(session)->taken++;
    }
}

static void set_number(struct dg_scpi *session)
{
    take_number(session, session->command->argument);
}

static void get_number(struct dg_scpi *session)
{
    const uint32_t value = session->command->argument;

    dg_scpi_put_number(session, rig_of(session)->values[value], ranges[value].places);
}

static void set_flag(struct dg_scpi *session)
{
    bool value;

    if (dg_scpi_flag(session, &value)) {
        rig_of(session)->values[session->command->argument] = value;
        rig_of(session)->taken++;
    }
}

static void set_text(struct dg_scpi *session)
{
    if (dg_scpi_text(session, rig_of(session)->text, sizeof rig_of(session)->text)) {
        rig_of(session)->taken++;
    }
}

static void get_text(struct dg_scpi *session)
{
    dg_scpi_put_string(session, rig_of(session)->text);
}

/* A handler whose change makes the host step the session that it serves, and offer it bytes. */
static void stop(struct dg_scpi *session)
{
    rig_of(session)->stops++;
    (void)dg_scpi_step(session, session->now + 1);
    rig_of(session)->stops += (unsigned)dg_scpi_rx(session, session->now + 1, "SHAF:STOP\n", 10);
}

/* Optional pairs of a word and a number behind a name: answers what it has read. */
static void set_fault(struct dg_scpi *session)
{
    static const char *const words[] = {"COUNt", "PROBability", "DURation"};
    static const enum scpi_rig_value values[] = {SCPI_RIG_NUMBER, SCPI_RIG_THOUSANDTHS,
                                                 SCPI_RIG_SPAN};
    size_t index;

    set_text(session);
    while (dg_scpi_more(session)) {
        index = 0;
        (void)dg_scpi_word(session, words, DG_COUNT(words), &index);
        take_number(session, values[index]); /* careless: after an error there is none */
    }
}

/* Any number of bytes. */
static void set_bytes(struct dg_scpi *session)
{
    do {
        take_number(session, SCPI_RIG_BYTE);
    } while (dg_scpi_more(session));
}

/* Answers its parameter in all forms that parts have. */
static void get_parts(struct dg_scpi *session)
{
    int64_t value = 0;

    if (dg_scpi_more(session)) {
        (void)dg_scpi_number(session, &ranges[SCPI_RIG_NUMBER], &value);
    }
    dg_scpi_put_number(session, value, 3);
    dg_scpi_put_unsigned(session, (uint64_t)value);
    dg_scpi_put_word(session, "key=word");
    dg_scpi_put_string(session, "say \"yes\"");
    dg_scpi_begin(session);
    dg_scpi_append(session, "piece");
    dg_scpi_append_number(session, value, 18);
    dg_scpi_append_hex(session, (uint64_t)value, 16);
}

static void get_nothing(struct dg_scpi *session)
{
    (void)session;
}

/* Two errors, and an answer that does not come. */
static void raise_two(struct dg_scpi *session)
{
    dg_scpi_raise(session, DG_SCPI_NO_ERROR, "nothing");
    dg_scpi_raise(session, DG_SCPI_HARDWARE, "first");
    dg_scpi_raise(session, DG_SCPI_STORAGE, NULL);
    dg_scpi_put_word(session, "unseen");
}

/* Any number as an error, with a text that is too long. */
static void raise_any(struct dg_scpi *session)
{
    static const struct dg_scpi_range codes = {DG_SCPI_PLAIN, 0, INT16_MIN, INT16_MAX};
    char text[2u * DG_SCPI_DETAIL_MAX];
    int64_t code;

    if (dg_scpi_number(session, &codes, &code)) {
        memset(text, 'x', sizeof text - 1u);
        text[sizeof text - 1u] = '\0';
        dg_scpi_raise(session, (int)code, text);
    }
}

/* clang-format off */
const struct dg_scpi_command scpi_rig_commands[] = {
    {"SHAFt:POSition",      set_number, get_number,  SCPI_RIG_POSITION,     "ANGLE",   "an angle"},
    {"SHAFt:VELocity",      set_number, get_number,  SCPI_RIG_VELOCITY,     "SPEED",   "a speed"},
    {"SHAFt:ACCeleration",  set_number, get_number,  SCPI_RIG_ACCELERATION, "RPM/S",   "an acceleration"},
    {"SHAFt:STOP",          stop,       NULL,        0,                     "",        "nothing to say"},
    {"TIME:STEP",           set_number, get_number,  SCPI_RIG_SPAN,         "TIME",    "a time"},
    {"WORLd:TEMPerature",   set_number, get_number,  SCPI_RIG_TEMPERATURE,  "DEGC",    "a temperature"},
    {"WORLd:SUPPly",        set_number, get_number,  SCPI_RIG_SUPPLY,       "VOLTAGE", "a voltage"},
    {"WORLd:LED:CURRent",   set_number, get_number,  SCPI_RIG_CURRENT,      "CURRENT", "a current"},
    {"WORLd:OFFSet[:SIN]",  set_number, get_number,  SCPI_RIG_SINE,         "N",       "an optional node"},
    {"WORLd:OFFSet:COS",    set_number, get_number,  SCPI_RIG_COSINE,       "N",       "its neighbour"},
    {"[SENSe:]VALue[:NOW]", set_number, get_number,  SCPI_RIG_THOUSANDTHS,  "N",       "two optional nodes"},
    {"NUMBer",              set_number, NULL,        SCPI_RIG_NUMBER,       "N",       "a row for the command"},
    {"NUMBer",              NULL,       get_number,  SCPI_RIG_NUMBER,       "",        "a row for the query"},
    {"BYTE",                set_number, get_number,  SCPI_RIG_BYTE,         "N",       "a byte"},
    {"BYTes",               set_bytes,  NULL,        0,                     "N[,N]...", "any number of them"},
    {"FLAG",                set_flag,   get_number,  SCPI_RIG_FLAG,         "ON|OFF",  "a flag"},
    {"TEXT",                set_text,   get_text,    0,                     "\"TEXT\"", "a string"},
    {"FAULt:SET",           set_fault,  NULL,        0, "NAME[,COUNt n][,PROBability p][,DURation TIME]", "words"},
    {"PARTs",               NULL,       get_parts,   0,                     "[N]",     "a query with a parameter"},
    {"NOTHing",             NULL,       get_nothing, 0,                     "",        "an empty answer"},
    {"FAIL",                raise_two,  raise_two,   0,                     "",        "errors"},
    {"RAISe",               raise_any,  NULL,        0,                     "N",       "any error"},
};
/* clang-format on */
const size_t scpi_rig_command_count = DG_COUNT(scpi_rig_commands);

/* In two lists: the engine takes any number of them. */
static const struct dg_scpi_commands *commands(const struct dg_scpi *session, size_t index)
{
    enum { FIRST = 10 };
    static const struct dg_scpi_commands lists[] = {
        {scpi_rig_commands, FIRST},
        {scpi_rig_commands + FIRST, DG_COUNT(scpi_rig_commands) - FIRST},
    };

    (void)session;
    return index < DG_COUNT(lists) ? &lists[index] : NULL;
}

void scpi_rig_init(struct scpi_rig *self)
{
    static const struct dg_scpi_ops ops = {
        .commands = commands, .write = write_out, .reset = reset, .settled = settled};
    const struct dg_scpi_setup setup = {
        .ops = &ops,
        .ctx = self,
        .idn = "drehgeber,rig,0,1.2.3",
    };

    memset(self, 0, sizeof *self);
    dg_scpi_init(&self->session, &setup);
}

void scpi_rig_send_bytes(struct scpi_rig *self, const char *bytes, size_t n)
{
    self->length = 0;
    self->out[0] = '\0';
    if (dg_scpi_rx(&self->session, 0, bytes, n) != n) {
        self->lost = true;
    }
}

void scpi_rig_send(struct scpi_rig *self, const char *text)
{
    scpi_rig_send_bytes(self, text, strlen(text));
}
