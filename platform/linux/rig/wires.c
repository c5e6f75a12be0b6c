/* SPDX-License-Identifier: MIT */
/* One row for each kind of wire. */
#include "bus.h"
#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "sim_settings.h"

static const char *const can_keys[] = {"pace", NULL};
static const char *const ring_keys[] = {"cycle", "tear", "break_at", NULL};

/* clang-format off */
const struct lx_wire lx_wires[] = {
    /* name     stations           make                    address      usual             keys       stack             simul. needed path */
    {"pty",     32,                lx_hf_bus_make_pty,     "LINK",      NULL,             NULL,      &dg_hf_stack,     false, false, true},
    {"tty",     32,                lx_hf_bus_make_tty,     "DEV",       NULL,             NULL,      &dg_hf_stack,     false, true,  true},
    {"sim",     DG_BISS_CHAIN_MAX, lx_sim_bus_make,        NULL,        NULL,             lx_sim_keys, &dg_biss_stack,   true,  false, false},
    {"gpio",    1,                 lx_gpio_bus_make,       "CHIP:MA,SLO", NULL,           NULL,      &dg_biss_stack,   false, true,  false},
    {"can",     DG_CO_NET_NODES,   lx_can_bus_make_socket, "IFNAME",    NULL,             can_keys,  &dg_cia406_stack, false, true,  false},
    {"slcan",   DG_CO_NET_NODES,   lx_can_bus_make_slcan,  "LINK",      NULL,             can_keys,  &dg_cia406_stack, false, false, true},
    {"modbus",  DG_IB_RING_MAX,    lx_ring_bus_make,       "HOST:PORT", "127.0.0.1:5020", ring_keys, &dg_ib_stack,     false, false, false},
};
/* clang-format on */

const size_t lx_wire_count = sizeof lx_wires / sizeof lx_wires[0];
