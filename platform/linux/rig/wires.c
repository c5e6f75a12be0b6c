/* SPDX-License-Identifier: MIT */
/* One row for each kind of wire, and what they share. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

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

const struct lx_wire *lx_wire_find(const char *name, size_t n)
{
    for (size_t i = 0; i < lx_wire_count; i++) {
        if (strlen(lx_wires[i].name) == n && memcmp(lx_wires[i].name, name, n) == 0) {
            return &lx_wires[i];
        }
    }
    return NULL;
}

bool lx_wire_has(const struct lx_wire *self, const char *key)
{
    for (size_t i = 0; self->keys != NULL && self->keys[i] != NULL; i++) {
        if (strcmp(self->keys[i], key) == 0) {
            return true;
        }
    }
    return false;
}

void lx_bus_count(struct dg_scpi *to, const struct lx_count *rows, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        char text[64];
        (void)snprintf(text, sizeof text, "%s=%" PRIu64, rows[i].name, rows[i].value);
        dg_scpi_put_word(to, text);
    }
}
