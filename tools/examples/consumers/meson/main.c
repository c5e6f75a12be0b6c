/* SPDX-License-Identifier: MIT */
/* A CANopen encoder after two turns, asked by SDO for its position; returns 0 when it says 131072.
 */
#include <stdalign.h>
#include <stdio.h>

#include <drehgeber/drehgeber.h>

static alignas(DG_HOST_ALIGN) unsigned char memory[8192];

int main(void)
{
    const struct dg_host_event upload = {
        .at = DG_S(1), .kind = DG_HOST_CAN, .id = 0x605, .length = 8, .data = {0x40, 0x04, 0x60}};
    struct dg_host *encoder = dg_host_init(memory, sizeof memory, &dg_f3668, &dg_cia406_wire);
    struct dg_host_event reply = {0};

    if (encoder == NULL || dg_host_set(encoder, "node", "5") != DG_HOST_OK ||
        dg_host_power(encoder, 0, true) != DG_HOST_OK) {
        return 1;
    }
    dg_host_shaft(encoder, 0, 0, 2 * DG_TURN); /* two turns a second */
    (void)dg_host_send(encoder, &upload);
    (void)dg_host_step(encoder, DG_S(1));
    while (dg_host_receive(encoder, &reply) > 0) {
        printf("%03X\n", (unsigned)reply.id);
    }
    return reply.id == 0x585 && reply.data[6] == 2 ? 0 : 2;
}
