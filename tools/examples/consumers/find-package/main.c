/* SPDX-License-Identifier: MIT */
/* A drive asks its encoder for the position, in virtual time: 40 42 and 16384 of 65536 steps. */
#include <stdalign.h>
#include <stdio.h>

#include <drehgeber/drehgeber.h>

static alignas(DG_HOST_ALIGN) unsigned char memory[8192];

int main(void)
{
    const struct dg_host_event request = {
        .at = DG_S(1), .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x42, 0x02}};
    struct dg_host *encoder = dg_host_init(memory, sizeof memory, &dg_s3684_rs485, &dg_hf_wire);
    struct dg_host_event reply;

    if (encoder == NULL || dg_host_power(encoder, 0, true) != DG_HOST_OK) {
        return 1;
    }
    dg_host_shaft(encoder, 0, DG_TURN / 4, 0);
    (void)dg_host_send(encoder, &request);
    (void)dg_host_step(encoder, DG_S(2));
    while (dg_host_receive(encoder, &reply) > 0) {
        for (unsigned i = 0; i < reply.length; i++) {
            printf("%02X ", (unsigned)reply.data[i]);
        }
    }
    printf("\n");
    return 0;
}
