/* SPDX-License-Identifier: MIT */
/*
 * System tasks and functions around libdrehgeber_hdl for simulators with VPI and without DPI-C:
 * Icarus Verilog, for which it is compiled by its user:
 *
 *   iverilog-vpi --name=drehgeber drehgeber_vpi.c $(pkg-config --cflags --libs drehgeber-hdl)
 *
 * The models drehgeber_*.v call them; nobody else does. An encoder has the full name of the module
 * instance that makes it.
 */
#include <stdint.h>
#include <string.h>

#include <vpi_user.h>

#include "hdl.h"
#include "hdl_names.h"

#define ARGUMENTS_MAX 8
#define TEXT_MAX 1024

/* Arguments as texts, numbers and handles: each task knows which it wants. */
struct arguments {
    vpiHandle handle[ARGUMENTS_MAX];
    int count;
};

static struct arguments arguments_of(vpiHandle call)
{
    struct arguments self = {.count = 0};
    vpiHandle all = vpi_iterate(vpiArgument, call);
    vpiHandle one = all != NULL ? vpi_scan(all) : NULL;

    while (one != NULL) {
        if (self.count < ARGUMENTS_MAX) {
            self.handle[self.count++] = one;
        }
        one = vpi_scan(all);
    }
    return self;
}

static void copy_vpi_string(vpiHandle handle, char *to)
{
    s_vpi_value value = {.format = vpiStringVal};

    vpi_get_value(handle, &value);
    strncpy(to, value.value.str != NULL ? value.value.str : "", TEXT_MAX - 1);
    to[TEXT_MAX - 1] = '\0';
    /* "" is a character 0, which some give as a space. */
    if (strcmp(to, " ") == 0) {
        to[0] = '\0';
    }
}

static int32_t integer_of(vpiHandle handle)
{
    s_vpi_value value = {.format = vpiIntVal};

    vpi_get_value(handle, &value);
    return value.value.integer;
}

static double real_of(vpiHandle handle)
{
    s_vpi_value value = {.format = vpiRealVal};

    vpi_get_value(handle, &value);
    return value.value.real;
}

static void put_vpi_number(vpiHandle to, int32_t number)
{
    s_vpi_value value = {.format = vpiIntVal, .value.integer = number};

    vpi_put_value(to, &value, NULL, vpiNoDelay);
}

static void put_real(vpiHandle to, double number)
{
    s_vpi_value value = {.format = vpiRealVal, .value.real = number};

    vpi_put_value(to, &value, NULL, vpiNoDelay);
}

/* The simulation's own steps may be finer or coarser than picoseconds: 10^precision s. */
static void now(int32_t *us, int32_t *ps)
{
    s_vpi_time time = {.type = vpiSimTime};
    vpi_get_time(NULL, &time);
    uint64_t t = (uint64_t)time.high << 32 | time.low;

    for (int32_t precision = vpi_get(vpiTimePrecision, NULL); precision != -12;
         precision += precision < -12 ? 1 : -1) {
        t = precision < -12 ? t / 10u : t * 10u;
    }
    *us = (int32_t)(t / 1000000u);
    *ps = (int32_t)(t % 1000000u);
}

/* @return how long it is */
static int32_t read_vpi_text(int32_t id, enum dg_hdl_text which, char *text)
{
    int32_t n = 0;

    for (int32_t c = 1; id >= 0 && c != 0 && n < TEXT_MAX - 1; n += c != 0) {
        c = dg_hdl_character(id, (int32_t)which, n);
        text[n] = (char)c;
    }
    text[n] = '\0';
    return n;
}

/* One line, and the simulation is over and has failed. */
static void fail_simulation(vpiHandle call, int32_t id, const char *instead)
{
    char text[TEXT_MAX];
    const int32_t n = read_vpi_text(id, DG_HDL_ERROR, text);

    vpi_printf("FATAL: %s: %s\n", vpi_get_str(vpiFullName, vpi_handle(vpiScope, call)),
               n > 0 ? text : instead);
    vpip_set_return_value(1);
    vpi_control(vpiFinish, 0);
}

/* $drehgeber_make(model, settings, motion, memory): its number, or -1. */
static PLI_INT32 make(PLI_BYTE8 *unused)
{
    vpiHandle call = vpi_handle(vpiSysTfCall, NULL);
    const struct arguments arguments = arguments_of(call);
    char text[4][TEXT_MAX];
    char name[TEXT_MAX];

    (void)unused;
    for (int i = 0; i < 4; i++) {
        copy_vpi_string(arguments.handle[i], text[i]);
    }
    strncpy(name, vpi_get_str(vpiFullName, vpi_handle(vpiScope, call)), sizeof name - 1);
    name[sizeof name - 1] = '\0';
    int32_t id = dg_hdl_make(name, text[0], text[1], text[2], text[3]);
    if (id < 0 || dg_hdl_character(id, DG_HDL_ERROR, 0) != 0) {
        fail_simulation(call, id, "no memory for an encoder");
        id = -1;
    }
    put_vpi_number(call, id);
    return 0;
}

/* $drehgeber_look(id, inputs): its outputs. */
static PLI_INT32 look(PLI_BYTE8 *unused)
{
    vpiHandle call = vpi_handle(vpiSysTfCall, NULL);
    const struct arguments arguments = arguments_of(call);
    const int32_t id = integer_of(arguments.handle[0]);
    int32_t us;
    int32_t ps;

    (void)unused;
    now(&us, &ps);
    const int32_t levels = id < 0 ? 0 : dg_hdl_look(id, us, ps, integer_of(arguments.handle[1]));
    if ((levels & DG_HDL_HINT) != 0) {
        char text[TEXT_MAX];
        (void)read_vpi_text(id, DG_HDL_NOTE, text);
        vpi_printf("%s\n", text);
    }
    put_vpi_number(call, levels);
    return 0;
}

/* $drehgeber_rest(id): picoseconds until it has to be looked at again, 1 ms at most. */
static PLI_INT32 rest(PLI_BYTE8 *unused)
{
    vpiHandle call = vpi_handle(vpiSysTfCall, NULL);
    const struct arguments arguments = arguments_of(call);
    const int32_t id = integer_of(arguments.handle[0]);
    const int32_t most = 1000000000;
    int32_t us;
    int32_t ps;

    (void)unused;
    now(&us, &ps);
    put_vpi_number(call, id < 0 ? most : dg_hdl_rest(id, us, ps, most));
    return 0;
}

/* $drehgeber_steer(id, what, text, value): by enum dg_hdl_steering. */
static PLI_INT32 steer(PLI_BYTE8 *unused)
{
    vpiHandle call = vpi_handle(vpiSysTfCall, NULL);
    const struct arguments arguments = arguments_of(call);
    const int32_t id = integer_of(arguments.handle[0]);
    char text[TEXT_MAX];
    int32_t us;
    int32_t ps;

    (void)unused;
    now(&us, &ps);
    copy_vpi_string(arguments.handle[2], text);
    if (id >= 0 && dg_hdl_steer(id, us, ps, integer_of(arguments.handle[1]), text,
                                real_of(arguments.handle[3])) < 0) {
        fail_simulation(call, id, "failed");
    }
    return 0;
}

/* $drehgeber_answer(id, to): of the latest command. */
static PLI_INT32 answer(PLI_BYTE8 *unused)
{
    vpiHandle call = vpi_handle(vpiSysTfCall, NULL);
    const struct arguments arguments = arguments_of(call);
    const int32_t id = integer_of(arguments.handle[0]);
    char text[TEXT_MAX];

    (void)unused;
    (void)read_vpi_text(id, DG_HDL_ANSWER, text);
    s_vpi_value value = {.format = vpiStringVal, .value.str = text};
    vpi_put_value(arguments.handle[1], &value, NULL, vpiNoDelay);
    return 0;
}

/* $drehgeber_real(id, what, to): by enum dg_hdl_look. No function: what those give is 32 bits. */
static PLI_INT32 read_real(PLI_BYTE8 *unused)
{
    vpiHandle call = vpi_handle(vpiSysTfCall, NULL);
    const struct arguments arguments = arguments_of(call);
    const int32_t id = integer_of(arguments.handle[0]);
    int32_t us;
    int32_t ps;

    (void)unused;
    now(&us, &ps);
    put_real(arguments.handle[2],
             id < 0 ? 0.0 : dg_hdl_real(id, us, ps, integer_of(arguments.handle[1])));
    return 0;
}

/* How many arguments a task or function takes stands in its user data. */
static PLI_INT32 check(PLI_BYTE8 *wanted)
{
    vpiHandle call = vpi_handle(vpiSysTfCall, NULL);

    if (arguments_of(call).count != wanted[0] - '0') {
        vpi_printf("%s takes %s arguments\n", vpi_get_str(vpiName, call), wanted);
        vpip_set_return_value(1);
        vpi_control(vpiFinish, 1);
    }
    return 0;
}

static void register_all(void)
{
    s_vpi_systf_data rows[] = {
        {vpiSysFunc, vpiIntFunc, "$drehgeber_make", make, check, NULL, "4"},
        {vpiSysFunc, vpiIntFunc, "$drehgeber_look", look, check, NULL, "2"},
        {vpiSysFunc, vpiIntFunc, "$drehgeber_rest", rest, check, NULL, "1"},
        {vpiSysTask, 0, "$drehgeber_real", read_real, check, NULL, "3"},
        {vpiSysTask, 0, "$drehgeber_steer", steer, check, NULL, "4"},
        {vpiSysTask, 0, "$drehgeber_answer", answer, check, NULL, "2"},
    };

    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        (void)vpi_register_systf(&rows[i]);
    }
}

void (*vlog_startup_routines[])(void) = {register_all, NULL};
