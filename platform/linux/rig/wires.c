/* SPDX-License-Identifier: MIT */
/* One row for each kind of wire and for each protocol. */
#include "biss_settings.h"
#include "bus.h"
#include "can_bus.h"
#include "drehgeber/interbus.h"
#include "hf_settings.h"
#include "modbus_settings.h"
#include "silkit.h"
#include "sim_settings.h"
#include "ssi_settings.h"

const struct lx_stack *const lx_stacks[] = {
    &lx_hf_stack, &lx_biss_stack, &lx_ssi_stack, &lx_can_stack, &lx_ib_stack,
};
const size_t lx_stack_count = DG_COUNT(lx_stacks);

const struct lx_wire lx_wires[] = {
    {
        .kind =
            {
                .name = "pty",
                .stations_max = 32,
                .media = DG_PLAN_CARRIES(CHARACTERS),
                .where = "LINK",
                .where_is_path = true,
                .mixed = true,
            },
        .make = lx_line_bus_make_pty,
        .help = "RS485 on a pseudo-terminal, and a symbolic link to it while it runs",
    },
    {
        .kind =
            {
                .name = "tty",
                .stations_max = 32,
                .media = DG_PLAN_CARRIES(CHARACTERS),
                .where = "DEV",
                .where_needed = true,
                .where_is_path = true,
            },
        .make = lx_line_bus_make_tty,
        .help = "RS485 on a serial port; data rate and parity are the encoder's own",
    },
    {
        .kind =
            {
                .name = "rs485",
                .stations_max = 32,
                .media = DG_PLAN_CARRIES(CHARACTERS),
                .where = "KIND:HOST:PORT",
                .usual = "rfc2217:127.0.0.1:2217",
                .mixed = true,
            },
        .make = lx_line_bus_make_net,
        .help = "RS485 on a TCP port: KIND rfc2217, where clients say data rate and parity, "
                "or tcp, plain bytes (loopback; ,open: beyond it, too)",
    },
    {
        .kind =
            {
                .name = "sim",
                .stations_max = DG_BISS_CHAIN_MAX,
                .media = DG_PLAN_CARRIES(EDGES),
                .keys = &lx_sim_keys,
            },
        .make = lx_sim_bus_make,
        .defaults = &lx_sim_timing,
        .simulated = true,
        .help = "BiSS or SSI on a simulated wire with a master that reads positions",
    },
    {
        .kind =
            {
                .name = "gpio",
                .stations_max = 1,
                .media = DG_PLAN_CARRIES(EDGES),
                .where = "CHIP:CLOCK,DATA",
                .where_needed = true,
            },
        .make = lx_gpio_bus_make,
        .help = "BiSS (MA, SLO) or SSI (clock, data) on two lines of a GPIO chip: its name, "
                "path or label, and their offsets, e.g. gpiochip0:4,5",
    },
    {
        .kind =
            {
                .name = "can",
                .stations_max = DG_BUS_FRAMES_ENCODERS,
                .media = DG_PLAN_CARRIES(FRAMES),
                .where = "IFNAME",
                .keys = &lx_can_keys,
                .where_needed = true,
            },
        .make = lx_can_bus_make_socket,
        .defaults = &lx_can_pace,
        .where_in_trace = true,
        .help = "CAN on a network interface (SocketCAN)",
    },
    {
        .kind =
            {
                .name = "slcan",
                .stations_max = DG_BUS_FRAMES_ENCODERS,
                .media = DG_PLAN_CARRIES(FRAMES),
                .where = "LINK|tcp:HOST:PORT",
                .keys = &lx_can_keys,
                .where_is_path = true,
                .where_may_be_tcp = true,
            },
        .make = lx_can_bus_make_slcan,
        .defaults = &lx_can_pace,
        .help = "CAN behind an SLCAN adapter on a pseudo-terminal, or on a TCP port, one for "
                "each client (loopback; ,open: beyond it, too)",
    },
    {
        .kind =
            {
                .name = "socketcand",
                .stations_max = DG_BUS_FRAMES_ENCODERS,
                .media = DG_PLAN_CARRIES(FRAMES),
                .where = "HOST:PORT[,BUS]",
                .usual = "127.0.0.1:29536",
                .keys = &lx_can_keys,
            },
        .make = lx_can_bus_make_socketcand,
        .defaults = &lx_can_pace,
        .help = "CAN behind a socketcand on a TCP port; BUS: the name that clients have to "
                "open it by (loopback; ,open: beyond it, too)",
    },
    {
        .kind =
            {
                .name = "silkit",
                .stations_max = DG_RING_MAX,
                .media = DG_PLAN_CARRIES_ALL,
                .where = "silkit://HOST:PORT,NETWORK",
                .keys = &lx_silkit_keys,
                .where_needed = true,
            },
        .make = lx_silkit_bus_make,
        .defaults = &lx_silkit_defaults,
        .help = "a SIL Kit simulation: the registry, the CAN network or the name before the "
                "topics of another line, and behind a comma the name of the participant",
    },
    {
        .kind =
            {
                .name = "modbus",
                .stations_max = DG_RING_MAX,
                .media = DG_PLAN_CARRIES(WORDS),
                .where = "HOST:PORT",
                .usual = "127.0.0.1:5020",
                .keys = &lx_ring_keys,
            },
        .make = lx_ring_bus_make,
        .defaults = &lx_ring_defaults,
        .help = "INTERBUS: the Modbus/TCP coupler in front of the ring (loopback; ,open: "
                "beyond it, too)",
    },
};
const size_t lx_wire_count = DG_COUNT(lx_wires);
