/* SPDX-License-Identifier: MIT */
/*
 * A whole rig in a firmware: the text of a rig file in flash, a plan and a rig at work in memory
 * that never moves, the board's CAN controller as the door, and SCPI on its UART. A master on the
 * bus finds two drives and their shafts; somebody with a terminal breaks one of them.
 */
#include "board.h"
#include "drehgeber/host.h"
#include "drehgeber/instruments.h"
#include "drehgeber/rig_engine.h"

static const char text[] = "[shaft motor]\nmotion = 1500RPM\n"
                           "[shaft load]\ndriver = motor\nratio = 1:3\n"
                           "[bus field]\nwire = slcan\n"
                           "[encoder motor]\nmodel = f3668\nbus = field\nnode = 5\n"
                           "[encoder load]\nmodel = f3658\nbus = field\nnode = 6\nshaft = load\n";

static _Alignas(DG_HOST_ALIGN) unsigned char plan_memory[4096];
static _Alignas(DG_HOST_ALIGN) unsigned char rig_memory[20480];

static void send_frame(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    board_tx = event->frame;
}

static int open_controller(void *ctx, size_t index, struct dg_engine_wire *to,
                           struct dg_plan_error *error)
{
    static const struct dg_bus_ops controller = {.tx = send_frame};

    (void)ctx;
    (void)index;
    to->ops = &controller;
    to->frames.real_time = true;
    to->frames.line.company = DG_BUS_SOMEBODY;
    (void)error;
    return 0;
}

static struct dg_engine *make_rig(struct dg_plan *plan)
{
    const struct dg_plan_setup reader = {.size = sizeof reader,
                                         .file = "rig.ini",
                                         .text = {text, sizeof text - 1u},
                                         .memory = plan_memory,
                                         .memory_size = sizeof plan_memory};
    const struct dg_engine_setup setup = {.size = sizeof setup,
                                          .plan = plan,
                                          .begin = board_now,
                                          .instruments = dg_instruments,
                                          .instrument_count = dg_instrument_count,
                                          .frames_wait = 64,
                                          .wire = open_controller};
    struct dg_plan_error error;

    if (dg_plan_read(plan, &reader, &error) != 0) {
        return NULL;
    }
    struct dg_engine *engine = dg_engine_make(rig_memory, sizeof rig_memory, &setup, &error);
    return engine == NULL || dg_engine_power(engine, board_now, &error) != 0 ? NULL : engine;
}

/* What has come, from the bus or from the terminal. */
static void take_input(struct dg_engine *engine)
{
    const struct dg_tap_event event = {.at = board_now, .kind = DG_TAP_FRAME, .frame = board_rx};
    const char byte = (char)board_in;

    if (board_received) {
        (void)dg_bus_rx(dg_engine_bus(engine, 0), &event);
        (void)dg_control_rx(&board_control, board_now, &byte, 1);
    }
}

int main(void)
{
    struct dg_plan plan;
    struct dg_engine *engine = make_rig(&plan);
    dg_ns due = 0;

    if (engine == NULL) {
        return 1;
    }
    dg_control_init(&board_control, dg_engine_control(engine), board_write, NULL);
    while (due != DG_NEVER) {
        take_input(engine);
        due = dg_engine_step(engine, board_now);
        due = dg_earliest(due, dg_control_step(&board_control, board_now));
    }
    return 0;
}
