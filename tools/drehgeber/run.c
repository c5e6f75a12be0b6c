/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "run.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <systemd/sd-daemon.h>
#include <systemd/sd-event.h>
#include <unistd.h>

#include "eds_file.h"
#include "ending.h"
#include "nvm_convert.h"
#include "plan.h"
#include "rig.h"
#include "silkit.h"
#include "timer.h"
#include "virtual_time.h"

/* How often the master of a simulated wire says what it reads. */
#define PRINT_EVERY DG_S(1)
/* Longest line that it says. */
#define LINE_MAX_CHARS 160u

/* Everything that runs. */
struct running {
    const struct options *options;
    struct dg_plan plan;
    struct lx_rig *rig;
    sd_event *event;
    struct lx_timer print; /* one encoder on a simulated wire */
    dg_ns next;            /* position that is printed */
    dg_ns span;            /* of virtual time; 0: real time, or */
    bool stepped;          /* that of a simulation */
};

/* --- positions of a simulated wire --- */

static void on_print(void *ctx, dg_ns now)
{
    struct running *self = ctx;
    char text[LINE_MAX_CHARS];
    if (lx_rig_read(self->rig, 0, text, sizeof text)) {
        (void)printf("%s\n", text);
        (void)fflush(stdout);
    }
    while (self->next <= now) {
        self->next = dg_after(self->next, PRINT_EVERY);
    }
    lx_timer_at(&self->print, self->next);
}

/* From the end of the initialisation on. */
static int begin_printing(struct running *self, struct lx_error *error)
{
    self->next = lx_rig_readable(self->rig, 0);
    if (self->plan.file != NULL || self->options->say.quiet || self->next == DG_NEVER) {
        return 0;
    }
    const int result = lx_timer_open(&self->print, self->event, on_print, self);
    lx_timer_at(&self->print, self->next);
    return result < 0 ? lx_fail(error, "no timer: %s", strerror(-result)) : 0;
}

/* --- the loop --- */

/* Blocked from here on and read by the loop: no way out that leaves a link behind. A closed stdout
   or a file size limit is an errno then, not the end. */
static int take_signals(sd_event *event)
{
    sigset_t stop;
    lx_ending_signals(&stop);
    const struct sigaction ignore = {.sa_handler = SIG_IGN};
    if (sigprocmask(SIG_BLOCK, &stop, NULL) != 0 || sigaction(SIGPIPE, &ignore, NULL) != 0 ||
        sigaction(SIGXFSZ, &ignore, NULL) != 0) {
        return -errno;
    }
    /* Without a handler of its own a signal ends the loop with 0. */
    int result = 0;
    for (int number = 1; result >= 0 && number < NSIG; number++) {
        if (sigismember(&stop, number) == 1) {
            result = sd_event_add_signal(event, NULL, number, NULL, NULL);
        }
    }
    return result;
}

/* A large rig has a file for each encoder; nothing here minds descriptors beyond 1023. */
static void raise_file_limit(void)
{
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files) == 0) {
        files.rlim_cur = files.rlim_max;
        (void)setrlimit(RLIMIT_NOFILE, &files);
    }
}

static int make_loop(sd_event **event, struct lx_error *error)
{
    int result = sd_event_new(event);
    if (result >= 0) {
        result = take_signals(*event);
    }
    return result < 0 ? lx_fail(error, "no event loop: %s", strerror(-result)) : 0;
}

/* From here on the encoders answer. Time 0 of all motions is now. */
static int switch_rig_on(struct running *self, struct lx_error *error)
{
    const dg_ns now = lx_now();
    const struct lx_rig_setup setup = {
        .event = self->event,
        .say = &self->options->say,
        .plan = &self->plan,
        .verbose = self->options->verbose,
    };
    const int result = lx_rig_open(&self->rig, &setup, now, error);
    if (result != LX_RIG_OK) {
        return result == LX_RIG_PLAN ? EXIT_USAGE : EXIT_OTHER;
    }
    if (lx_rig_announce(self->rig, error) != 0 || begin_printing(self, error) != 0) {
        return EXIT_OTHER;
    }
    (void)sd_notify(0, "READY=1");
    return EXIT_OK;
}

static int run_loop(struct running *self)
{
    if (self->stepped) {
        lx_rig_end_after(self->rig, self->span);
        return virtual_time_steps(self->event, self->rig);
    }
    return self->span == 0 ? sd_event_loop(self->event)
                           : virtual_time_loop(self->event, self->span);
}

static int serve_rig(struct running *self)
{
    struct lx_error error;
    raise_file_limit();
    if (make_loop(&self->event, &error) != 0) {
        return complain(&error, EXIT_OTHER);
    }
    const int status = switch_rig_on(self, &error);
    if (status != EXIT_OK) {
        return lx_ending_asked() ? EXIT_OK : complain(&error, status);
    }
    const int result = run_loop(self);
    (void)sd_notify(0, "STOPPING=1");
    if (result < 0) {
        (void)lx_fail(&error, "the event loop failed: %s", strerror(-result));
        return complain(&error, EXIT_OTHER);
    }
    return result;
}

int run_rig(const struct options *options)
{
    struct running self = {.options = options};
    struct lx_error error;
    if (options_plan(options, &self.plan, &error) != 0) {
        return complain(&error, EXIT_USAGE);
    }
    if ((options->nvm_convert != NULL &&
         nvm_convert(&self.plan, options->nvm_convert, &options->say, &error) != 0) ||
        nvm_check(&self.plan, &error) != 0) {
        lx_plan_free(&self.plan);
        return complain(&error, EXIT_USAGE);
    }
    if (virtual_time_of(options->time, &self.plan, &self.span, &self.stepped, &error) != 0) {
        lx_plan_free(&self.plan);
        return complain(&error, EXIT_USAGE);
    }
    if (self.span != 0 || self.stepped) {
        lx_time_own();
    }
    if (options->eds != NULL) {
        eds_file_tell(options->eds, &options->say);
    }
    eds_file_tell_plan(&self.plan, &options->say);
    int status = serve_rig(&self);
    lx_timer_close(&self.print);
    if (lx_rig_close(self.rig, &error) != 0 && status == EXIT_OK) {
        status = complain(&error, EXIT_OTHER);
    }
    self.event = sd_event_unref(self.event);
    lx_plan_free(&self.plan);
    if (lx_silkit_is_left_behind()) {
        (void)fflush(NULL);
        _exit(status);
    }
    return status;
}
