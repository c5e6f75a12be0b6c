/* SPDX-License-Identifier: MIT */
/* A client of the control plane that keeps a struct top_view up to date. */
#ifndef DREHGEBER_TOOL_TOP_CLIENT_H
#define DREHGEBER_TOOL_TOP_CLIENT_H

#include <stdbool.h>
#include <stddef.h>
#include <systemd/sd-event.h>

#include "drehgeber/time.h"
#include "say.h"
#include "top_view.h"

/* How often top_client_tick() is to be called. */
#define TOP_EVERY DG_MS(200)

struct top_client;

/* Connect to `view->where` and begin to ask. `changed` is called when a round of questions was
   answered. @return NULL with one line in `error` */
struct top_client *top_client_open(sd_event *event, struct top_view *view,
                                   void (*changed)(void *ctx), void *ctx, struct lx_error *error);

/* Ask about everything that is to be seen, once the last round was answered; say what does not go
   on; connect again. */
void top_client_tick(struct top_client *self, dg_ns now);

/* A command to an encoder, e.g. "POW OFF". Refused, with a message in the view, while nobody
   answers: it would surprise later. @return whether it is on its way */
bool top_client_do(struct top_client *self, size_t encoder, const char *command);

/* Ask for what can happen to an encoder; in the view when `faults_of` is that encoder. */
void top_client_ask_faults(struct top_client *self, size_t encoder);

/* NULL is fine. */
void top_client_close(struct top_client *self);

#endif
