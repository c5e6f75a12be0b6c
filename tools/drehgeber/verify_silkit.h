/* SPDX-License-Identifier: MIT */
/*
 * A SIL Kit simulation between the command and an encoder: frames of a CAN network, or the topics of a
 * serial line as a master has them. Time is that of the simulation unless it is real, and lx_now() says it.
 */
#ifndef DREHGEBER_TOOL_VERIFY_SILKIT_H
#define DREHGEBER_TOOL_VERIFY_SILKIT_H

#include <stdbool.h>
#include <stddef.h>

#include "drehgeber/time.h"
#include "error.h"
#include "options.h"

struct verify_silkit;

/* Whether the command line names one. */
bool verify_silkit_is(const struct options *options);

/* Join the one at options->where, and wait until it has begun; before anybody asks for the time.
   @return NULL with `error` */
struct verify_silkit *verify_silkit_open(const struct options *options, struct lx_error *error);

/* Send a struct dg_can_frame, or characters. @return 0, or -1: nobody takes part any more */
int verify_silkit_send(struct verify_silkit *self, const void *bytes, size_t n);

/* What has come by `until` at the latest, in the order in which it came: a struct dg_can_frame, when `size` is
   that of one, or characters. @return its length, 0: nothing, -1: nobody takes part any more */
long verify_silkit_receive(struct verify_silkit *self, dg_ns until, void *to, size_t size);

/* Do nothing until then. What comes meanwhile can be received. */
void verify_silkit_wait(struct verify_silkit *self, dg_ns until);

/* Nobody has answered: whether it is known why; then `error` says it. */
bool verify_silkit_explain(const struct verify_silkit *self, struct lx_error *error);

/* Leave it; NULL is fine. */
void verify_silkit_close(struct verify_silkit *self);

#endif
