/* SPDX-License-Identifier: MIT */
/* One row for each kind of wire. */
#include "bus.h"
#include "drehgeber/interbus.h"
#include "sim_settings.h"

static const char *const can_keys[] = {"pace", NULL};
static const char *const ring_keys[] = {"cycle", "tear", "break_at", NULL};

/* clang-format off */
const struct lx_wire lx_wires[] = {
    /* name     stations           make                    address      usual             keys       stack               simul. needed path */
    {"pty",     32,                lx_hf_bus_make_pty,     "LINK",      NULL,             NULL,      DG_STACK_HIPERFACE, false, false, true},
    {"tty",     32,                lx_hf_bus_make_tty,     "DEV",       NULL,             NULL,      DG_STACK_HIPERFACE, false, true,  true},
    {"sim",     DG_BISS_CHAIN_MAX, lx_sim_bus_make,        NULL,        NULL,             lx_sim_keys, DG_STACK_BISS,      true,  false, false},
    {"gpio",    1,                 lx_gpio_bus_make,       "CHIP:MA,SLO", NULL,           NULL,      DG_STACK_BISS,      false, true,  false},
    {"can",     DG_CO_NET_NODES,   lx_can_bus_make_socket, "IFNAME",    NULL,             can_keys,  DG_STACK_CANOPEN,   false, true,  false},
    {"slcan",   DG_CO_NET_NODES,   lx_can_bus_make_slcan,  "LINK",      NULL,             can_keys,  DG_STACK_CANOPEN,   false, false, true},
    {"modbus",  DG_IB_RING_MAX,    lx_ring_bus_make,       "HOST:PORT", "127.0.0.1:5020", ring_keys, DG_STACK_INTERBUS,  false, false, false},
};
/* clang-format on */

const size_t lx_wire_count = sizeof lx_wires / sizeof lx_wires[0];
