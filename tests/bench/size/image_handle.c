/* SPDX-License-Identifier: MIT */
/* The least that has an encoder behind a handle: DEVICE and its WIRE, named alone. */
#include "drehgeber/host.h"

#include "board.h"

extern const struct dg_device DEVICE;

int main(void)
{
    struct dg_host *self = dg_host_init(board_handle, dg_host_size(&DEVICE, &WIRE), &DEVICE, &WIRE);
    struct dg_host_event event = {.kind = 0};

    if (self == NULL || dg_host_power(self, 0, true) != DG_HOST_OK) {
        return 1;
    }
    dg_host_shaft(self, 0, 0, 1);
    return dg_host_send(self, &event) + dg_host_receive(self, &event) + (int)dg_host_step(self, 1);
}
