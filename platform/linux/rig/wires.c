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

/* clang-format off */
const struct lx_wire lx_wires[] = {
    /* name        stations           make                        carries                 address                usual                     keys           defaults           simul. mixed  needed path   or tcp traced help */
    {"pty",        32,                lx_line_bus_make_pty,       LX_CARRIES(CHARACTERS), "LINK",                NULL,                     NULL,          NULL,              false, true,  false, true,  false, false,  "RS485 on a pseudo-terminal, and a symbolic link to it while it runs"},
    {"tty",        32,                lx_line_bus_make_tty,       LX_CARRIES(CHARACTERS), "DEV",                 NULL,                     NULL,          NULL,              false, false, true,  true,  false, false,  "RS485 on a serial port; data rate and parity are the encoder's own"},
    {"rs485",      32,                lx_line_bus_make_net,       LX_CARRIES(CHARACTERS), "KIND:HOST:PORT",      "rfc2217:127.0.0.1:2217", NULL,          NULL,              false, true,  false, false, false, false,  "RS485 on a TCP port: KIND rfc2217, where clients say data rate and parity, or tcp, plain bytes (loopback; ,open: beyond it, too)"},
    {"sim",        DG_BISS_CHAIN_MAX, lx_sim_bus_make,            LX_CARRIES(EDGES),      NULL,                  NULL,                     &lx_sim_keys,  &lx_sim_timing,    true,  false, false, false, false, false,  "BiSS or SSI on a simulated wire with a master that reads positions"},
    {"gpio",       1,                 lx_gpio_bus_make,           LX_CARRIES(EDGES),      "CHIP:CLOCK,DATA",     NULL,                     NULL,          NULL,              false, false, true,  false, false, false,  "BiSS (MA, SLO) or SSI (clock, data) on two lines of a GPIO chip: its name, path or label, and their offsets, e.g. gpiochip0:4,5"},
    {"can",        DG_BUS_FRAMES_ENCODERS, lx_can_bus_make_socket,     LX_CARRIES(FRAMES),     "IFNAME",              NULL,                     &lx_can_keys,  &lx_can_pace,      false, false, true,  false, false, true,   "CAN on a network interface (SocketCAN)"},
    {"slcan",      DG_BUS_FRAMES_ENCODERS, lx_can_bus_make_slcan,      LX_CARRIES(FRAMES),     "LINK|tcp:HOST:PORT",  NULL,                     &lx_can_keys,  &lx_can_pace,      false, false, false, true,  true,  false,  "CAN behind an SLCAN adapter on a pseudo-terminal, or on a TCP port, one for each client (loopback; ,open: beyond it, too)"},
    {"socketcand", DG_BUS_FRAMES_ENCODERS, lx_can_bus_make_socketcand, LX_CARRIES(FRAMES),     "HOST:PORT[,BUS]",     "127.0.0.1:29536",        &lx_can_keys,  &lx_can_pace,      false, false, false, false, false, false,  "CAN behind a socketcand on a TCP port; BUS: the name that clients have to open it by (loopback; ,open: beyond it, too)"},
    {"silkit",     DG_RING_MAX,       lx_silkit_bus_make,         LX_CARRIES_ALL,         "silkit://HOST:PORT,NETWORK", NULL,              &lx_silkit_keys, &lx_silkit_defaults, false, false, true, false, false, false, "a SIL Kit simulation: the registry, the CAN network or the name before the topics of another line, and behind a comma the name of the participant"},
    {"modbus",     DG_RING_MAX,       lx_ring_bus_make,           LX_CARRIES(WORDS),      "HOST:PORT",           "127.0.0.1:5020",         &lx_ring_keys, &lx_ring_defaults, false, false, false, false, false, false,  "INTERBUS: the Modbus/TCP coupler in front of the ring (loopback; ,open: beyond it, too)"},
};
/* clang-format on */

const size_t lx_wire_count = DG_COUNT(lx_wires);
