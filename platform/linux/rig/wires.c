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
        .help = "RS485 on a pseudo-terminal; LINK is a symbolic link to it while the encoder runs",
    },
    {
        .name = "tty",
        .make = lx_line_bus_make,
        .open_port = lx_tty_open,
        .help = "RS485 on a serial port, with the encoder's data rate and parity",
    },
    {
        .name = "rs485",
        .make = lx_line_bus_make,
        .open_port = lx_net_port_open,
        .check = lx_net_port_check,
        .help = "RS485 on a TCP port; KIND is rfc2217 (clients set data rate and parity) or tcp "
                "(plain bytes); add ,open to accept other machines than this one",
    },
    {
        .name = "sim",
        .make = lx_sim_bus_make,
        .simulated = true,
        .help = "BiSS or SSI on a simulated wire; a built-in master reads positions",
    },
    {
        .name = "gpio",
        .make = lx_gpio_bus_make,
        .help = "BiSS (MA, SLO) or SSI (clock, data) on two lines of a GPIO chip; give its name, "
                "path or label, and the offsets of the lines, e.g. gpiochip0:4,5",
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
        .help = "CAN through a simulated SLCAN adapter on a pseudo-terminal, or on a TCP port with "
                "an adapter for each client; add ,open to accept other machines than this one",
    },
    {
        .name = "socketcand",
        .make = lx_can_bus_make,
        .open_can = lx_socketcand_open,
        .check = lx_socketcand_check,
        .help = "CAN through a simulated socketcand on a TCP port; clients open the bus by the "
                "name BUS; add ,open to accept other machines than this one",
    },
    {
        .name = "silkit",
        .make = lx_silkit_bus_make,
        .help = "a SIL Kit simulation; give the registry, the CAN network (for other wires: the "
                "first part of the topics), and after a comma the name of the participant",
    },
    {
        .name = "modbus",
        .make = lx_ring_bus_make,
        .check = lx_modbus_check,
        .help = "INTERBUS through a simulated Modbus/TCP coupler; add ,open to accept other "
                "machines than this one",
    },
};
const size_t lx_wire_count = DG_COUNT(lx_wires);
