/* SPDX-License-Identifier: MIT */
/* One row for each kind of wire and for each protocol. */
#include "bus.h"
#include "can.h"
#include "modbus.h"
#include "serial.h"

const struct lx_stack *const lx_stacks[] = {
    &lx_hf_stack, &lx_biss_stack, &lx_ssi_stack, &lx_cia406_stack, &lx_ib_stack,
};
const size_t lx_stack_count = DG_COUNT(lx_stacks);

const struct lx_wire lx_wires[] = {
    {
        .name = "pty",
        .make = lx_line_bus_make,
        .open_port = lx_pty_open,
        .help = "RS485 on a pseudo-terminal, and a symbolic link to it while it runs",
    },
    {
        .name = "tty",
        .make = lx_line_bus_make,
        .open_port = lx_tty_open,
        .help = "RS485 on a serial port; data rate and parity are the encoder's own",
    },
    {
        .name = "rs485",
        .make = lx_line_bus_make,
        .open_port = lx_net_port_open,
        .check = lx_net_port_check,
        .help = "RS485 on a TCP port: KIND rfc2217, where clients say data rate and parity, "
                "or tcp, plain bytes (loopback; ,open: beyond it, too)",
    },
    {
        .name = "sim",
        .make = lx_sim_bus_make,
        .simulated = true,
        .help = "BiSS or SSI on a simulated wire with a master that reads positions",
    },
    {
        .name = "gpio",
        .make = lx_gpio_bus_make,
        .help = "BiSS (MA, SLO) or SSI (clock, data) on two lines of a GPIO chip: its name, "
                "path or label, and their offsets, e.g. gpiochip0:4,5",
    },
    {
        .name = "can",
        .make = lx_can_bus_make,
        .open_can = lx_can_socket_open,
        .where_in_trace = true,
        .help = "CAN on a network interface (SocketCAN)",
    },
    {
        .name = "slcan",
        .make = lx_can_bus_make,
        .open_can = lx_slcan_open,
        .check = lx_slcan_address_check,
        .help = "CAN behind an SLCAN adapter on a pseudo-terminal, or on a TCP port, one for "
                "each client (loopback; ,open: beyond it, too)",
    },
    {
        .name = "socketcand",
        .make = lx_can_bus_make,
        .open_can = lx_socketcand_open,
        .check = lx_socketcand_check,
        .help = "CAN behind a socketcand on a TCP port; BUS: the name that clients have to "
                "open it by (loopback; ,open: beyond it, too)",
    },
    {
        .name = "silkit",
        .make = lx_silkit_bus_make,
        .help = "a SIL Kit simulation: the registry, the CAN network or the name before the "
                "topics of another line, and behind a comma the name of the participant",
    },
    {
        .name = "modbus",
        .make = lx_ring_bus_make,
        .check = lx_modbus_check,
        .help = "INTERBUS: the Modbus/TCP coupler in front of the ring (loopback; ,open: "
                "beyond it, too)",
    },
};
const size_t lx_wire_count = DG_COUNT(lx_wires);
