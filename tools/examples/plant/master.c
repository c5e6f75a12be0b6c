/* SPDX-License-Identifier: MIT */
/*
 * The master of a plant: CANopen encoders on many buses, one shaft for each bus, in a SIL Kit
 * simulation. It starts the nodes, sends SYNC on a bus once a period, and compares each position
 * that comes back with the shaft at the moment of that SYNC, to the last bit. The buses share the
 * period, so each step has positions to check:
 *
 *   step        T                            T+1                          T+2
 *   master      SYNC, a new speed for        SYNC on the next buses       compares the positions
 *               the shaft, on some buses                                  with the angle at T
 *   rig                                      latches the angle at T,
 *                                            sends TPDO2
 *
 * plant.py starts it, and reads its lines. Each is a word and what belongs to it:
 *
 *   joined                  all participants are there
 *   begin                   before the first step that counts: it waits for a line
 *   end                     behind the last one, likewise
 *   progress TEXT           every other second
 *   steps N                 the rest comes when the simulation is over: those that counted,
 *   seconds X               how long they took,
 *   frames N                received meanwhile,
 *   syncs N                 sent
 *   checked N               positions, and
 *   wrong N                 how many of all were wrong or missing
 *   hash N                  of all frames received, if it is wanted
 *   complaint TEXT          about the first ten that were wrong
 *   over
 *
 * It is the system controller as well, so it stays until its input ends: rigs leave before it does.
 */
#define _POSIX_C_SOURCE 200809L
#include "master.h"

#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define NAME "master"
#define PROGRESS_MS 2000
#define PROCESSES_MAX 256u
#define BUSES_MAX 100000u

/* Nodes have booted by then; the first SYNC comes so much behind the start, or a period. */
#define BOOTED_MS 500u
#define STARTED_MS 100u
/* The answer to a SYNC of the last step that has one comes two steps later. */
#define ANSWER_STEPS 3u
#define PERIOD_STEPS_MIN 4u

/* --- what is wrong --- */

void master_note_wrong(struct master *self, const char *format, ...)
{
    self->wrong++;
    if (self->complaints < COMPLAINTS) {
        va_list arguments;
        char *text = self->complaint[self->complaints++];
        const int n = snprintf(text, COMPLAINT_MAX, "step %" PRIu64 ": ", self->step);
        va_start(arguments, format);
        (void)vsnprintf(text + n, COMPLAINT_MAX - (size_t)n, format, arguments);
        va_end(arguments);
        while ((text = strchr(text, '\n')) != NULL) {
            *text = ' '; /* a complaint is a line */
        }
    }
}

static void end_watch(struct master *self)
{
    self->over = true;
    (void)!write(self->wakes[1], "", 1);
}

/* Calls that fail in a simulation end it. */
void master_demand(struct master *self, const char *function, int32_t code)
{
    if (code != 0 && !self->over) {
        master_note_wrong(self, "SIL Kit: %s: %s", function, self->kit.call.last_error());
        end_watch(self);
    }
}

/* --- steps --- */

/* The reader of the lines measures the processes while the simulation stands still. */
static void ask_reader(struct master *self, const char *word)
{
    (void)printf("%s\n", word);
    (void)fflush(stdout);
    while (sem_wait(&self->answered) != 0 && errno == EINTR) {
    }
}

/* Bus i of n has its turn in step i * period / n of a period. */
static uint64_t first_due(const struct master *self, uint64_t turn)
{
    return (turn * self->buses + self->period - 1u) / self->period;
}

static void serve_buses(struct master *self)
{
    const uint64_t turn = (self->step - self->booted) % self->period;
    const uint64_t past = first_due(self, turn + 1u);
    for (uint64_t i = first_due(self, turn); i < past; i++) {
        if (self->step < self->started) {
            bus_start(&self->bus[i]);
        } else {
            bus_sync(&self->bus[i]);
        }
    }
}

static void end_plant(struct master *self)
{
    (void)clock_gettime(CLOCK_MONOTONIC, &self->end);
    ask_reader(self, "end");
    for (unsigned i = 0; i < self->buses; i++) {
        bus_count_missing(&self->bus[i]);
        self->bus[i].asked = false;
    }
    self->complete = true;
    master_demand(self, "LifecycleService_Stop", self->kit.call.stop(self->kit.life, "done"));
}

static void take_plant_step(struct master *self, uint64_t now)
{
    self->now = now;
    if (self->step == self->started) {
        ask_reader(self, "begin");
        self->frames = 0;
        (void)clock_gettime(CLOCK_MONOTONIC, &self->begin);
    }
    if (self->step >= self->booted && self->step < self->ends) {
        serve_buses(self);
    }
    self->step++;
    if (self->step == self->whole) {
        end_plant(self);
    }
    self->step_told = (unsigned long)self->step;
    self->checked_told = (unsigned long)self->checked;
    self->wrong_told = (unsigned long)self->wrong;
}

/* --- on the library's thread --- */

/* A controller is started here: nobody sends before all can receive. */
static void on_ready(void *ctx, void *life)
{
    struct master *self = ctx;
    (void)life;
    for (unsigned i = 0; i < self->buses && !self->plant.packed; i++) {
        master_demand(self, "CanController_Start",
                      self->kit.call.start_controller(self->bus[i].wire));
    }
    self->joined = true;
    (void)printf("joined\n");
    (void)fflush(stdout);
}

static void on_step(void *ctx, void *clock, uint64_t now, uint64_t duration)
{
    struct master *self = ctx;
    (void)clock;
    (void)duration;
    if (!self->over && !self->complete && !self->leaves) {
        take_plant_step(self, now);
    }
}

static void on_shutdown(void *ctx, void *life)
{
    (void)life;
    end_watch(ctx);
}

static void on_abort(void *ctx, void *life, int16_t before)
{
    (void)before;
    on_shutdown(ctx, life);
}

/* --- what is printed --- */

static void print_progress(const struct master *self)
{
    if (self->joined) {
        (void)printf("progress step %lu of %" PRIu64 ", %lu positions checked, %lu wrong\n",
                     self->step_told, self->whole, self->checked_told, self->wrong_told);
    } else {
        (void)printf("progress waiting for all %" PRIu32 " rigs\n", self->plant.processes);
    }
    (void)fflush(stdout);
}

static double seconds_between(const struct timespec *begin, const struct timespec *end)
{
    return (double)(end->tv_sec - begin->tv_sec) + (double)(end->tv_nsec - begin->tv_nsec) / 1e9;
}

static void print_summary(const struct master *self)
{
    (void)printf("steps %" PRIu64 "\nseconds %.9f\nframes %" PRIu64 "\nsyncs %" PRIu64
                 "\nchecked %" PRIu64 "\nwrong %" PRIu64 "\n",
                 self->whole - self->started, seconds_between(&self->begin, &self->end),
                 self->frames, self->syncs, self->checked, self->wrong);
    if (self->plant.hash) {
        (void)printf("hash %016" PRIx64 "\n", bus_hash_all(self));
    }
    for (unsigned i = 0; i < self->complaints; i++) {
        (void)printf("complaint %s\n", self->complaint[i]);
    }
    (void)printf("over\n");
    (void)fflush(stdout);
}

/* Until the input ends. */
static void watch_plant(struct master *self)
{
    struct pollfd from[] = {{.fd = STDIN_FILENO, .events = POLLIN},
                            {.fd = self->wakes[0], .events = POLLIN}};
    for (int patience = PROGRESS_MS;;) {
        const int ready = poll(from, 2, patience);
        char bytes[64];
        if (ready == 0) {
            print_progress(self);
        }
        if (ready <= 0) {
            continue;
        }
        if (from[1].revents != 0 && read(self->wakes[0], bytes, 1) == 1) {
            print_summary(self);
            from[1].fd = -1;
            patience = -1;
        }
        if (from[0].revents != 0) {
            const ssize_t n = read(STDIN_FILENO, bytes, sizeof bytes);
            if (n <= 0) {
                return;
            }
            for (ssize_t i = 0; i < n; i++) {
                if (bytes[i] == '\n') {
                    (void)sem_post(&self->answered);
                }
            }
        }
    }
}

/* --- the command line --- */

/* Their ranges keep all products here within 64 bits. */
static const struct {
    const char *name;
    size_t at;
    uint32_t least, most, usual;
} numbers[] = {
    /* clang-format off */
    {"processes", offsetof(struct plant, processes), 1, PROCESSES_MAX, 1},
    {"buses",     offsetof(struct plant, buses),     1, BUSES_MAX,     80},
    {"nodes",     offsetof(struct plant, nodes),     1, NODES_MAX,     125},
    {"ms",        offsetof(struct plant, ms),        1, UINT32_MAX,    1000},
    {"step_us",   offsetof(struct plant, step_us),   1, 1000000,       1000},
    {"sync_ms",   offsetof(struct plant, sync_ms),   1, 86400000,      100},
    {"aggregate", offsetof(struct plant, aggregate), 0, 1,             1},
    {"packed",    offsetof(struct plant, packed),    0, 1,             1},
    {"hash",      offsetof(struct plant, hash),      0, 1,             0},
    /* clang-format on */
};
#define NUMBERS (sizeof numbers / sizeof numbers[0])

static _Noreturn void refuse_command(const char *what, const char *right)
{
    (void)fprintf(stderr, "plant: %s%s\n", what, right);
    exit(KIT_REFUSED);
}

static void assign_number(struct plant *self, size_t row, uint32_t value)
{
    memcpy((char *)self + numbers[row].at, &value, sizeof value);
}

static void assign_word(struct plant *self, const char *text)
{
    const size_t length = strcspn(text, "=");
    size_t row = 0;
    while (row < NUMBERS &&
           (strlen(numbers[row].name) != length || strncmp(text, numbers[row].name, length) != 0)) {
        row++;
    }
    if (row == NUMBERS || text[length] == '\0') {
        refuse_command(text, ": expected NAME=NUMBER");
    }
    char *end = NULL;
    const char *digits = text + length + 1u;
    errno = 0;
    const unsigned long long value = strtoull(digits, &end, 10);
    if (digits[0] < '0' || digits[0] > '9' || *end != '\0' || errno != 0 ||
        value < numbers[row].least || value > numbers[row].most) {
        char right[48];
        (void)snprintf(right, sizeof right, ": expected %" PRIu32 "..%" PRIu32, numbers[row].least,
                       numbers[row].most);
        refuse_command(text, right);
    }
    assign_number(self, row, (uint32_t)value);
}

static void read_plant(struct plant *self, char *const *words)
{
    for (size_t row = 0; row < NUMBERS; row++) {
        assign_number(self, row, numbers[row].usual);
    }
    for (; *words != NULL; words++) {
        assign_word(self, *words);
    }
    if ((uint64_t)self->processes * self->buses > BUSES_MAX) {
        refuse_command("expected 100000 buses at most", "");
    }
    const uint64_t sync_us = self->sync_ms * UINT64_C(1000);
    if (sync_us % self->step_us != 0 || sync_us / self->step_us < PERIOD_STEPS_MIN) {
        refuse_command("expected SYNC in each fourth step at most, and in a step", "");
    }
}

/* --- life --- */

static void prepare_master(struct master *self)
{
    const struct plant *plant = &self->plant;
    const uint64_t pause = STARTED_MS * UINT64_C(1000) / plant->step_us;
    self->period = plant->sync_ms * UINT64_C(1000) / plant->step_us;
    self->booted = BOOTED_MS * UINT64_C(1000) / plant->step_us;
    self->started = self->booted + (self->period > pause ? self->period : pause);
    self->ends = self->started + plant->ms * UINT64_C(1000) / plant->step_us;
    self->whole = self->ends + ANSWER_STEPS;
    self->buses = plant->processes * plant->buses;
    self->bus = calloc(self->buses, sizeof *self->bus);
    if (self->bus == NULL || pipe(self->wakes) != 0 || sem_init(&self->answered, 0, 0) != 0) {
        refuse_command("the master: ", strerror(errno));
    }
}

static void join_plant(struct master *self, const char *registry)
{
    static const struct kit_handlers handlers = {
        .ready = on_ready, .step = on_step, .shutdown = on_shutdown, .abort = on_abort};
    static char name[PROCESSES_MAX][24];
    const char *names[PROCESSES_MAX + 1u] = {NAME};
    for (uint32_t i = 0; i < self->plant.processes; i++) {
        (void)snprintf(name[i], sizeof name[i], "plant-%u", (unsigned)i);
        names[i + 1u] = name[i];
    }
    kit_load(&self->kit);
    kit_join(&self->kit, NAME, registry, self->plant.aggregate != 0);
    kit_coordinate(&self->kit, names, self->plant.processes + 1u);
    kit_live(&self->kit, &handlers, self, self->plant.step_us * UINT64_C(1000));
    bus_prepare(self);
    for (unsigned i = 0; i < self->buses; i++) {
        bus_connect(self, i);
    }
    kit_start(&self->kit);
}

/* The library's thread may wait for an answer. */
static void leave_plant(struct master *self)
{
    self->leaves = true;
    (void)sem_post(&self->answered);
    (void)self->kit.call.leave(self->kit.participant);
    free(self->bus);
}

int main(int argc, char **argv)
{
    static struct master master;
    if (argc < 2) {
        refuse_command("usage: master silkit://HOST:PORT [NAME=NUMBER]...", "");
    }
    /* A terminal sends these to all processes; plant.py ends the master after the rigs. */
    (void)signal(SIGINT, SIG_IGN);
    (void)signal(SIGHUP, SIG_IGN);
    read_plant(&master.plant, argv + 2);
    prepare_master(&master);
    join_plant(&master, argv[1]);
    watch_plant(&master);
    leave_plant(&master);
    const uint64_t expected = master.syncs * master.plant.nodes;
    const bool good =
        master.complete && master.wrong == 0 && master.checked == expected && expected > 0;
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
