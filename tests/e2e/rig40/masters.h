/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What all masters of a rig share: who is asked, the time, and whether an answer is right. One that
 * cannot do its work ends the process with a line on stderr.
 */
#ifndef DREHGEBER_TESTS_MASTERS_H
#define DREHGEBER_TESTS_MASTERS_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DEVICES_MAX 16u
#define STATE_MAX 80u
#define LINE_SIZE 256u
#define NS_PER_MS INT64_C(1000000)
#define NS_PER_S INT64_C(1000000000)
#define CONTROL_PATIENCE (10 * NS_PER_S)

/** Who is asked, and what came of it. */
struct device {
    char name[33];
    unsigned address;
    double steps;     /**< in a turn */
    double turns;     /**< until the position repeats */
    double turn;      /**< of the shaft at the time below */
    double per_ns;    /**< turns */
    int64_t at;       /**< CLOCK_MONOTONIC */
    unsigned answers; /**< to the present SYNC */
    bool right;       /**< all of them */
    char state[STATE_MAX];
};

/** A master and its wire. */
struct master {
    const char *where;
    int control; /**< socket */
    int fd;      /**< of the wire */
    struct device device[DEVICES_MAX];
    size_t count;
    int64_t patience;   /**< an encoder that has not answered by then is silent */
    unsigned long most; /**< exchanges and losses until it ends by itself; 0: never */
    unsigned long exchanges;
    unsigned long wrong;
    unsigned long lost;    /**< requests without an answer */
    unsigned long garbled; /**< answers that were none */
    int64_t longest;       /**< from a request to its answer */
    int64_t pause;         /**< on an RS485 line, between a reply and the next request */
    char line[LINE_SIZE];  /**< of SLCAN, as far as it has come */
    size_t line_size;
    int64_t ahead; /* so far may the wire run ahead of the clock: a frame of the rig's own master */
};

/** Whether a master has work left: the process is not to end, and it has not asked enough. */
bool goes_on(const struct master *self);

/** The masters: each works while it goes on. */
void run_can(struct master *self);
void run_rs485(struct master *self);
void run_ring(struct master *self);
void run_biss(struct master *self);
void run_clock(struct master *self);

/** CLOCK_MONOTONIC. */
int64_t now_ns(void);

/** Sleep, unless a signal comes. */
void sleep_until(int64_t at);

/** End the process: "masters: WHAT: " and the text of errno. */
_Noreturn void die(const char *what);

/** Whether there are bytes, or the end of them, before `end`. A signal does not shorten it: what
 * has been asked is answered. */
bool readable(int fd, int64_t end);

/** A line about something with a name, printf style. */
__attribute__((format(printf, 2, 3))) void say(const char *name, const char *format, ...);

/** Nothing came for a request: "silent". Counts. */
void lose(struct master *self, struct device *device);

/** What came is no answer: "garbled". Counts. */
void garble(struct master *self, struct device *device);

/** A line when the state is another one than before. */
void become(struct device *device, const char *state);

/** Send a line to the control plane. */
void tell(const struct master *self, const char *line);

/** A line of the control plane, LINE_SIZE at most, without its end; empty when none came. */
void hear(const struct master *self, char *line);

/** The number at `*text`, which goes on behind the separator after it; NAN when there is none. */
double number(const char **text);

/** An answer came that is all right but for the position in it: whether the shaft was there some
 * time since `from`. Counts. */
bool check(struct master *self, struct device *device, uint64_t position, int64_t from);

/** An answer came to what was asked at `from`. */
void took(struct master *self, int64_t from);

#endif
