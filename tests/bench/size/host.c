/* SPDX-License-Identifier: MIT */
/* What the images need of a host, for trees that link them to look at and not to run. */
#include "drehgeber/host.h"
#include "drehgeber/control.h"

/* The largest device. */
#define DEVICE_MAX 4096u
#define HANDLE_MAX 16384u

extern struct dg_world image_world;
extern struct dg_nvm image_nvm;
extern const void *image_port;
extern unsigned char image_device[DEVICE_MAX];
extern unsigned char image_handle[HANDLE_MAX];
extern struct dg_encoder image_encoder;
extern struct dg_rig_shaft image_shaft;
extern struct dg_control image_control;
extern const struct dg_rig_ops image_ops;
void image_write(void *ctx, const char *bytes, size_t n);

struct dg_world image_world;
struct dg_nvm image_nvm;
const void *image_port;
unsigned char image_device[DEVICE_MAX];
_Alignas(DG_HOST_ALIGN) unsigned char image_handle[HANDLE_MAX];
struct dg_encoder image_encoder;
struct dg_rig_shaft image_shaft;
struct dg_control image_control;
const struct dg_rig_ops image_ops = {0};

void image_write(void *ctx, const char *bytes, size_t n)
{
    (void)ctx;
    (void)bytes;
    (void)n;
}
