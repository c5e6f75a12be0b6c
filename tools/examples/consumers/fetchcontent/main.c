/* SPDX-License-Identifier: MIT */
/* A BiSS encoder read by its master, in virtual time; returns 0 when the position is where the
   shaft is. Nothing here needs an operating system. */
#include <stdalign.h>

#include <drehgeber/drehgeber.h>

static alignas(DG_HOST_ALIGN) unsigned char memory[8192];

int main(void)
{
    struct dg_host *encoder = dg_host_init(memory, sizeof memory, &dg_s3684_biss, &dg_biss_wire);
    struct dg_host_frame frame;

    if (encoder == NULL || dg_host_power(encoder, 0, true) != DG_HOST_OK) {
        return 1;
    }
    dg_host_shaft(encoder, 0, 3 * DG_TURN + DG_TURN / 4, 0);
    if (dg_host_frame(encoder, DG_S(2), &frame) != DG_HOST_OK) {
        return 2;
    }
    return frame.good && frame.multiturn == 3 && frame.singleturn == 1u << 19 ? 0 : 3;
}
