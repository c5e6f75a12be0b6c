/* SPDX-License-Identifier: MIT */
/*
 * Keys and the loop. The screen is drawn after each round of answers and each key, and whenever the
 * rig is silent. Signals are read by the loop, so the terminal is restored on every way out.
 */
#define _GNU_SOURCE
#include "top.h"

#include <errno.h>
#include <locale.h>
#include <ncurses.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <systemd/sd-event.h>
#include <unistd.h>

#include "ctl.h"
#include "run.h"
#include "timer.h"
#include "top_client.h"
#include "top_screen.h"

/* Last: its macros have the names of other people's parameters. */
#include <term.h>

#define UDEG_PER_DEG 1000000
#define MRPM_PER_RPM 1000
#define STEP_DEG 1
#define FAST_DEG 10
#define STEP_RPM 10
#define KEY_ESCAPE 27
#define COMMAND_SIZE 80u
#define SOCKET ".sock"

struct top {
    sd_event *event;
    struct lx_timer timer;
    struct top_client *client;
    struct top_view view;
    struct top_screen screen;
    bool stop;
};

static void draw_view(struct top *self)
{
    top_screen_arrange(&self->view);
    top_screen_draw(&self->screen, &self->view);
}

/* --- keys --- */

/* The shaft that the selected encoder sits on, as far as it is known where that is. */
static struct top_shaft *shaft_of(struct top *self)
{
    const struct top_view *view = &self->view;
    if (view->selected >= view->encoder_count) {
        return NULL;
    }
    const size_t shaft = view->encoders[view->selected].shaft;
    return shaft != TOP_NONE && view->shafts[shaft].known ? &view->shafts[shaft] : NULL;
}

/* From where it is seen to be, or was sent by the key before. It rests there. */
static void turn_shaft(struct top *self, int deg)
{
    struct top_shaft *shaft = shaft_of(self);
    char command[COMMAND_SIZE];
    if (shaft == NULL) {
        return;
    }
    const int64_t udeg = shaft->udeg + (int64_t)deg * UDEG_PER_DEG;
    (void)snprintf(command, sizeof command, "SHAF:POS %.6f DEG", (double)udeg / UDEG_PER_DEG);
    if (top_client_do(self->client, self->view.selected, command)) {
        shaft->udeg = udeg;
        shaft->mrpm = 0;
        shaft->held = true;
    }
}

static void speed_up(struct top *self, int rpm)
{
    struct top_shaft *shaft = shaft_of(self);
    char command[COMMAND_SIZE];
    if (shaft == NULL) {
        return;
    }
    const int64_t mrpm = shaft->mrpm + (int64_t)rpm * MRPM_PER_RPM;
    (void)snprintf(command, sizeof command, "SHAF:VEL %.3f RPM", (double)mrpm / MRPM_PER_RPM);
    if (top_client_do(self->client, self->view.selected, command)) {
        shaft->mrpm = mrpm;
        shaft->held = true;
    }
}

static void halt(struct top *self, int unused)
{
    (void)unused;
    (void)top_client_do(self->client, self->view.selected, "SHAF:STOP");
}

static void power(struct top *self, int unused)
{
    const struct top_view *view = &self->view;
    (void)unused;
    if (view->selected < view->encoder_count && view->encoders[view->selected].known) {
        const bool on = view->encoders[view->selected].powered;
        (void)top_client_do(self->client, view->selected, on ? "POW OFF" : "POW ON");
    }
}

static void heal(struct top *self, int unused)
{
    (void)unused;
    (void)top_client_do(self->client, self->view.selected, "FAUL:CLE");
}

/* A place in a list of `count`, which ends at its ends. */
static size_t moved(size_t at, int by, size_t count)
{
    if (by < 0) {
        return at > (size_t)-by ? at - (size_t)-by : 0;
    }
    return count == 0 ? 0 : at + (size_t)by < count ? at + (size_t)by : count - 1;
}

static void go(struct top *self, int by)
{
    struct top_view *view = &self->view;
    view->selected = moved(view->selected, by, view->encoder_count);
    view->frame_count = 0;
}

static void page(struct top *self, int direction)
{
    go(self, direction * (int)self->view.rows);
}

static void show_help(struct top *self, int unused)
{
    (void)unused;
    self->screen.popup = TOP_POPUP_HELP;
}

static void show_faults(struct top *self, int unused)
{
    struct top_view *view = &self->view;
    (void)unused;
    if (view->selected >= view->encoder_count) {
        return;
    }
    view->fault_count = 0;
    view->faults_of = view->selected;
    self->screen = (struct top_screen){.popup = TOP_POPUP_FAULTS};
    top_client_ask_faults(self->client, view->selected);
}

static void leave(struct top *self, int unused)
{
    (void)unused;
    self->stop = true;
}

#define ALL 100000 /* more than a list has */

/* clang-format off */
static const struct key {
    void (*act)(struct top *self, int amount);
    int key;
    int amount;
} keys[] = {
    {go,       KEY_UP,    -1},        {go,          'k',       -1},
    {go,       KEY_DOWN,  1},         {go,          'j',       1},
    {page,     KEY_PPAGE, -1},        {page,        KEY_NPAGE, 1},
    {go,       KEY_HOME,  -ALL},      {go,          KEY_END,   ALL},
    {turn_shaft,     KEY_LEFT,  -STEP_DEG}, {turn_shaft,        'h',       -STEP_DEG},
    {turn_shaft,     KEY_RIGHT, STEP_DEG},  {turn_shaft,        'l',       STEP_DEG},
    {turn_shaft,     KEY_SLEFT, -FAST_DEG}, {turn_shaft,        'H',       -FAST_DEG},
    {turn_shaft,     KEY_SRIGHT, FAST_DEG}, {turn_shaft,        'L',       FAST_DEG},
    {speed_up, '+',       STEP_RPM},  {speed_up,    '-',       -STEP_RPM},
    {halt,     ' ',       0},         {power,       'p',       0},
    {heal,     'c',       0},         {show_faults, 'f',       0},
    {leave,    'q',       0},         {show_help,   '?',       0},
};
/* clang-format on */

/* Keys of the list of faults; all others close it. */
static void choose(struct top *self, int by)
{
    self->screen.choice = moved(self->screen.choice, by, self->view.fault_count);
}

static void set_or_clear(struct top *self, int unused)
{
    const struct top_view *view = &self->view;
    char command[COMMAND_SIZE];
    (void)unused;
    if (self->screen.choice < view->fault_count && view->faults_of < view->encoder_count) {
        const char *name = view->faults[self->screen.choice].name;
        const bool active = top_fault_active(&view->encoders[view->faults_of], name);
        (void)snprintf(command, sizeof command, "FAUL:%s %s", active ? "CLE" : "SET", name);
        (void)top_client_do(self->client, view->faults_of, command);
    }
}

#define JUMP 10

/* clang-format off */
static const struct key fault_keys[] = {
    {choose,       KEY_UP,    -1},    {choose,       'k',       -1},
    {choose,       KEY_DOWN,  1},     {choose,       'j',       1},
    {choose,       KEY_PPAGE, -JUMP}, {choose,       KEY_NPAGE, JUMP},
    {choose,       KEY_HOME,  -ALL},  {choose,       KEY_END,   ALL},
    {set_or_clear, '\r',      0},     {set_or_clear, KEY_ENTER, 0},
};
/* clang-format on */

/* @return whether it is one of them */
static bool act_on(struct top *self, const struct key *table, size_t count, int key)
{
    for (size_t i = 0; i < count; i++) {
        if (table[i].key == key) {
            table[i].act(self, table[i].amount);
            return true;
        }
    }
    return false;
}

static void press_key(struct top *self, int key)
{
    switch (self->screen.popup) {
    case TOP_POPUP_NONE:
        (void)act_on(self, keys, DG_COUNT(keys), key);
        break;
    case TOP_POPUP_HELP:
        self->screen.popup = TOP_POPUP_NONE;
        break;
    case TOP_POPUP_FAULTS:
        if (!act_on(self, fault_keys, DG_COUNT(fault_keys), key)) {
            self->screen.popup = TOP_POPUP_NONE;
        }
        break;
    }
}

/* --- the loop --- */

static int on_keys(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct top *self = ctx;
    int key = ERR;
    (void)source;
    (void)fd;
    while (!self->stop && (key = getch()) != ERR) {
        press_key(self, key);
    }
    if (self->stop) {
        return sd_event_exit(self->event, EXIT_OK);
    }
    if ((events & (EPOLLHUP | EPOLLERR)) != 0) { /* the terminal has gone */
        return sd_event_exit(self->event, EXIT_OTHER);
    }
    draw_view(self);
    return 0;
}

static int on_resize(sd_event_source *source, const struct signalfd_siginfo *info, void *ctx)
{
    struct top *self = ctx;
    struct winsize size;
    (void)source;
    (void)info;
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0) {
        (void)resizeterm(size.ws_row, size.ws_col);
        draw_view(self);
    }
    return 0;
}

static void on_tick(void *ctx, dg_ns now)
{
    struct top *self = ctx;
    top_client_tick(self->client, now);
    if (self->view.trouble[0] != '\0') {
        draw_view(self);
    }
    lx_timer_at(&self->timer, dg_after(now, TOP_EVERY));
}

static void on_changed(void *ctx)
{
    struct top *self = ctx;
    if (self->screen.popup == TOP_POPUP_FAULTS && self->view.faults_of == TOP_NONE) {
        self->screen.popup = TOP_POPUP_NONE; /* another connection, maybe another rig */
    }
    draw_view(self);
}

static int add_event_sources(struct top *self)
{
    static const int ends[] = {SIGTERM, SIGINT, SIGHUP};
    sigset_t blocked;
    (void)sigemptyset(&blocked);
    (void)sigaddset(&blocked, SIGWINCH);
    for (size_t i = 0; i < DG_COUNT(ends); i++) {
        (void)sigaddset(&blocked, ends[i]);
    }
    int result = sigprocmask(SIG_BLOCK, &blocked, NULL) == 0 ? 0 : -errno;
    for (size_t i = 0; i < DG_COUNT(ends) && result >= 0; i++) {
        result = sd_event_add_signal(self->event, NULL, ends[i], NULL, NULL); /* ends it with 0 */
    }
    if (result >= 0) {
        result = sd_event_add_signal(self->event, NULL, SIGWINCH, on_resize, self);
    }
    if (result >= 0) {
        result = sd_event_add_io(self->event, NULL, STDIN_FILENO, EPOLLIN, on_keys, self);
    }
    return result < 0 ? result : lx_timer_open(&self->timer, self->event, on_tick, self);
}

static void give_back(SCREEN *screen)
{
    (void)endwin();
    delscreen(screen);
}

/* Whether curses can work here. newterm() would lose memory where it cannot. */
static bool has_cursor(void)
{
    int unused = 0;
    if (setupterm(NULL, STDOUT_FILENO, &unused) != OK) {
        return false;
    }
    const bool found = tigetstr("cup") != NULL;
    (void)del_curterm(cur_term);
    return found;
}

/* From here on the terminal is ours. */
static int open_terminal(SCREEN **screen, struct lx_error *error)
{
    const char *name = getenv("TERM");
    *screen = has_cursor() ? newterm(NULL, stdout, stdin) : NULL;
    if (*screen != NULL) {
        top_screen_begin();
        return EXIT_OK;
    }
    (void)lx_fail(error,
                  "TERM=%s is not a terminal with a cursor that can be placed; expected "
                  "TERM=xterm, linux, tmux or your own",
                  name == NULL ? "" : name);
    return EXIT_USAGE;
}

static int run_screen(struct top *self, struct lx_error *error)
{
    SCREEN *screen = NULL;
    const int status = open_terminal(&screen, error);
    if (status != EXIT_OK) {
        return status;
    }
    draw_view(self);
    lx_timer_at(&self->timer, lx_now());
    const int result = sd_event_loop(self->event);
    give_back(screen);
    if (result == EXIT_OK) {
        return EXIT_OK;
    }
    (void)lx_fail(error, "the event loop ended: %s",
                  result < 0 ? strerror(-result) : "the terminal has gone");
    return EXIT_OTHER;
}

/* The default address ends with the name of the rig. */
static void name_rig(struct top_view *view)
{
    const char *name = strrchr(view->where, '/');
    const size_t n = name == NULL ? 0 : strlen(name);
    if (n > strlen(SOCKET)) {
        (void)snprintf(view->rig, sizeof view->rig, "%.*s", (int)(n - 1u - strlen(SOCKET)),
                       name + 1);
    }
}

static int start_top(struct top *self, struct lx_error *error)
{
    int result = sd_event_new(&self->event);
    if (result < 0) {
        (void)lx_fail(error, "no event loop: %s", strerror(-result));
        return EXIT_OTHER;
    }
    name_rig(&self->view);
    self->client = top_client_open(self->event, &self->view, on_changed, self, error);
    if (self->client == NULL) {
        return EXIT_OTHER;
    }
    if (!isatty(STDIN_FILENO) || !isatty(STDOUT_FILENO)) {
        (void)lx_fail(error, "top needs a terminal; 'drehgeber ctl STAT?' works without");
        return EXIT_OTHER;
    }
    result = add_event_sources(self);
    if (result < 0) {
        (void)lx_fail(error, "no event loop: %s", strerror(-result));
        return EXIT_OTHER;
    }
    return run_screen(self, error);
}

int top_command(const char *wanted)
{
    struct top *self = calloc(1, sizeof *self);
    struct lx_error error;
    int status = EXIT_OTHER;
    if (self == NULL) {
        lx_complain("no memory");
        return EXIT_OTHER;
    }
    (void)setlocale(LC_CTYPE, "");
    if (ctl_find(wanted, self->view.where, sizeof self->view.where, &error) != 0) {
        status = wanted == NULL ? EXIT_OTHER : EXIT_USAGE;
    } else {
        status = start_top(self, &error);
    }
    top_client_close(self->client);
    lx_timer_close(&self->timer);
    self->event = sd_event_unref(self->event);
    free(self);
    return status == EXIT_OK ? EXIT_OK : complain(&error, status);
}
