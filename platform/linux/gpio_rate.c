/* SPDX-License-Identifier: MIT */
#include "gpio_rate.h"

#include <stdlib.h>
#include <string.h>

#define PERCENT 99u
#define EDGES_PER_PERIOD 2u

static uint32_t used(const struct lx_gpio_rate *self)
{
    return self->count < LX_GPIO_RATE_SAMPLES ? self->count : LX_GPIO_RATE_SAMPLES;
}

void lx_gpio_rate_take(struct lx_gpio_rate *self, dg_ns reaction)
{
    self->reaction_ns[self->count % LX_GPIO_RATE_SAMPLES] =
        reaction < UINT32_MAX ? (uint32_t)reaction : UINT32_MAX;
    /* Never back to 0, where there would be no answers. */
    self->count = self->count == UINT32_MAX ? LX_GPIO_RATE_SAMPLES : self->count + 1u;
}

bool lx_gpio_rate_known(const struct lx_gpio_rate *self)
{
    return self->count >= LX_GPIO_RATE_SAMPLES;
}

static int compare(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a;
    const uint32_t y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

uint32_t lx_gpio_rate_reaction_ns(const struct lx_gpio_rate *self)
{
    uint32_t sorted[LX_GPIO_RATE_SAMPLES];
    const uint32_t n = used(self);

    if (n == 0) {
        return 0;
    }
    memcpy(sorted, self->reaction_ns, n * sizeof sorted[0]);
    qsort(sorted, n, sizeof sorted[0], compare);
    return sorted[(n - 1u) * PERCENT / 100u];
}

uint32_t lx_gpio_rate_hz(const struct lx_gpio_rate *self)
{
    const dg_ns reaction = lx_gpio_rate_reaction_ns(self);

    return reaction == 0 ? 0 : (uint32_t)(DG_S(1) / (EDGES_PER_PERIOD * reaction));
}
