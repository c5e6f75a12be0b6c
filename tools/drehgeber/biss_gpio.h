/* SPDX-License-Identifier: MIT */
/* `run` of a BiSS encoder on GPIO lines. */
#ifndef DREHGEBER_TOOL_BISS_GPIO_H
#define DREHGEBER_TOOL_BISS_GPIO_H

#include <stdbool.h>

#include "options.h"

/* Whether --gpio was given. */
bool biss_on_gpio(const struct options *options);

/* Be that encoder until SIGINT or SIGTERM. Prints its own errors, returns how the program ends. */
int biss_gpio_run(const struct options *options);

#endif
