/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "virtual_rig.h"

#include <arpa/inet.h>
#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "give_up.h"
#include "rig_parts.h"
#include "timer.h"

#define PATIENCE DG_S(10)
/* More than such a rig has. */
#define DESCRIPTORS 256

/* --- time --- */

/* Everybody who has been told something does what there is to do. */
void virtual_rig_serve(struct virtual_rig *self)
{
    uint8_t bytes[512];
    while (sd_event_run(self->event, 0) > 0) {
    }
    ssize_t n = 0;
    while (self->line >= 0 && (n = recv(self->line, bytes, sizeof bytes, MSG_DONTWAIT)) > 0) {
        if (self->heard != NULL) {
            self->heard(self->ctx, bytes, (size_t)n);
        }
    }
}

void virtual_rig_pass_to(struct virtual_rig *self, dg_ns end)
{
    virtual_rig_serve(self);
    while (lx_time_pass(end)) {
        virtual_rig_serve(self);
    }
}

void virtual_rig_pass(struct virtual_rig *self, dg_ns span)
{
    virtual_rig_pass_to(self, lx_now() + span);
}

/* --- the control plane --- */

static void on_answer(void *ctx, const char *bytes, size_t n)
{
    struct virtual_rig *self = ctx;
    const size_t length = strlen(self->answer);
    if (length + n < sizeof self->answer) {
        memcpy(self->answer + length, bytes, n);
        self->answer[length + n] = '\0';
    }
}

void virtual_rig_ask(struct virtual_rig *self, const char *command)
{
    const struct lx_clock *clock = &self->rig->clock;
    self->answer[0] = '\0';
    (void)dg_control_rx(&self->control, lx_clock_now(clock), command, strlen(command));
    (void)dg_control_rx(&self->control, lx_clock_now(clock), "\n", 1);
    lx_rig_settle(self->rig, lx_clock_now(clock));
    self->answer[strcspn(self->answer, "\n")] = '\0';
}

void virtual_rig_order(struct virtual_rig *self, const char *format, ...)
{
    char command[256];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(command, sizeof command, format, arguments);
    va_end(arguments);
    virtual_rig_ask(self, command);
    virtual_rig_ask(self, "SYST:ERR?");
    if (self->answer[0] != '0') {
        give_up(self->answer, command);
    }
}

/* --- the master --- */

/* The rig's end of the master's connection: it is in this process, too. */
static int find_other_end(const struct virtual_rig *self)
{
    struct sockaddr_in master;
    struct sockaddr_in peer;
    socklen_t size = sizeof master;
    (void)getsockname(self->line, (struct sockaddr *)&master, &size);
    for (int fd = 0; fd < DESCRIPTORS; fd++) {
        size = sizeof peer;
        if (getpeername(fd, (struct sockaddr *)&peer, &size) == 0 && size == sizeof peer &&
            memcmp(&peer, &master, sizeof peer) == 0) {
            return fd;
        }
    }
    give_up("the rig has closed the master's connection", self->name);
}

/* All of it is there before time goes on. */
static void await_arrival(const struct virtual_rig *self, size_t n)
{
    const dg_ns end = lx_real_now() + PATIENCE;
    const int other = find_other_end(self);
    int come = 0;
    while (ioctl(other, SIOCINQ, &come) == 0 && (size_t)come < n) {
        if (lx_real_now() > end) {
            give_up("what the master says does not arrive", self->name);
        }
    }
}

void virtual_rig_say(struct virtual_rig *self, const uint8_t *bytes, size_t n)
{
    if (send(self->line, bytes, n, MSG_NOSIGNAL) != (ssize_t)n) {
        give_up("the master's connection is closed", self->name);
    }
    await_arrival(self, n);
    virtual_rig_serve(self);
}

void virtual_rig_connect(struct virtual_rig *self)
{
    static const char host[] = "127.0.0.1:";
    const char *address = strstr(lx_rig_address(self->rig, &self->rig->engine.stations[0]), host);
    if (address == NULL) {
        give_up("expected a wire on a TCP port of 127.0.0.1", self->name);
    }
    const struct sockaddr_in to = {
        .sin_family = AF_INET,
        .sin_port = htons((uint16_t)strtoul(address + strlen(host), NULL, 10)),
        .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
    };
    self->line = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    /* What it says does not wait for the receipt of what it has said before. */
    (void)setsockopt(self->line, IPPROTO_TCP, TCP_NODELAY, &(int){1}, sizeof(int));
    if (connect(self->line, (const struct sockaddr *)&to, sizeof to) != 0) {
        give_up("cannot connect", address);
    }
    virtual_rig_serve(self);
}

/* --- the rig --- */

const char *virtual_rig_wire(const struct virtual_rig *self)
{
    return self->plan.wires[0].kind->name;
}

const struct dg_encoder *virtual_rig_encoder(const struct virtual_rig *self, size_t index)
{
    return index < self->plan.encoder_count ? self->rig->control->encoders[index] : NULL;
}

void virtual_rig_open(struct virtual_rig *self, const char *file, struct lx_tap_listener *listener)
{
    static const struct lx_say quiet = {.quiet = true};
    struct lx_error error = {.right = ""};
    self->name = file;
    self->line = -1;
    self->listener = listener;
    /* No control plane: its socket would be somebody else's business. */
    (void)setenv("XDG_RUNTIME_DIR", "/dev/null", 1);
    (void)unsetenv("RUNTIME_DIRECTORY");
    if (lx_plan_read(&self->plan, file, &error) != 0) {
        give_up(lx_error_line(&error).text, file);
    }
    if (sd_event_new(&self->event) < 0) {
        give_up("no event loop", file);
    }
    lx_time_own();
    const struct lx_rig_setup setup = {.event = self->event, .say = &quiet, .plan = &self->plan};
    if (lx_rig_open(&self->rig, &setup, lx_now(), &error) != LX_RIG_OK) {
        give_up(lx_error_line(&error).text, file);
    }
    /* A busy machine stops this process, which counts as late also while time stands still. */
    lx_stall_close(&self->rig->stall);
    if (listener != NULL) {
        lx_tap_add(&self->rig->wires[0].bus->tap, listener);
    }
    dg_control_init(&self->control, self->rig->control, on_answer, self);
}

void virtual_rig_close(struct virtual_rig *self)
{
    struct lx_error error = {.right = ""};
    if (self->listener != NULL) {
        lx_tap_remove(&self->rig->wires[0].bus->tap, self->listener);
    }
    if (self->line >= 0) {
        (void)close(self->line);
    }
    if (lx_rig_close(self->rig, &error) != 0) {
        give_up(lx_error_line(&error).text, self->name);
    }
    (void)sd_event_unref(self->event);
    lx_plan_free(&self->plan);
}
