/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a participant is made of, for the files that make it: silkit.c lives, silkit_ports.c sends
 * and receives, silkit_wait.c has things made, silkit_settings.c knows the plan.
 */
#ifndef DREHGEBER_LINUX_SILKIT_PARTS_H
#define DREHGEBER_LINUX_SILKIT_PARTS_H

#include <signal.h>

#include "silkit.h"
#include "silkit_lanes.h"

/** A participant. What other threads touch is `inbox`, and, once it is started, `port`, `lib`. */
struct lx_silkit {
    sd_event *event;
    const struct lx_say *say;
    const char *rig; /**< name */
    struct lx_silkit_library lib;
    struct lx_silkit_inbox inbox;
    sd_event_source *io;
    struct lx_sk_participant *participant; /**< NULL: it has not joined, or left */
    struct lx_sk_lifecycle *lifecycle;
    struct lx_sk_time *clock;     /**< NULL: time is real, then: */
    struct lx_timer tick;         /**< ... instead of steps */
    struct lx_silkit_port **port; /**< owned list of theirs */
    size_t count;
    struct lx_silkit_list came;    /**< just taken out of the inbox */
    struct lx_silkit_list pending; /**< messages in the order in which they are handled */
    struct lx_silkit_lanes *lanes; /**< owned; NULL: no bus is packed, or time is real */
    size_t threads;                /**< that step them, at least 1 */
    uint64_t lost;                 /**< messages for which there was no room, as was told */
    uint64_t at;                   /**< time of the present step */
    uint64_t origin;               /**< time of the first one, which is that of the rig at */
    dg_ns begin;                   /**< ... this moment */
    dg_ns span;                    /**< its part is over then; 0: it is not */
    sd_event_source *standstill;   /**< is looked for; NULL: it is not */
    unsigned grace;                /**< steps until it need not be */
    struct dg_plan_simulation settings;
    struct lx_silkit_where where;
    bool planned;    /**< a wire was added */
    bool heard;      /**< everybody can hear */
    bool ready;      /**< ports know that */
    bool begun;      /**< there was a step */
    bool stepping;   /**< one is to be completed */
    bool stopped;    /**< the library has said so */
    bool ended;      /**< the loop was told to end */
    bool complained; /**< about what the library refuses */
    bool mixed;      /**< somebody has another kind of time */
};

/** Hand over the first message of `list`, at `now`, of which those before `end` come in this step.
 */
void lx_silkit_deliver(const struct lx_silkit *self, struct lx_silkit_list *list, dg_ns now,
                       uint64_t end);

/** The rig's time at the simulation's `time`; what is over already is now. */
dg_ns lx_silkit_moment_of(const struct lx_silkit *self, uint64_t time);

/** Put the pending ones into their order. */
void lx_silkit_sort(struct lx_silkit_list *list);

/** A function of the library said no: what it was to do, and its reason. @return -1 */
int lx_silkit_refused(const struct lx_silkit *self, const char *what, struct lx_error *error);

/** Likewise, once, to the user. */
void lx_silkit_complain(struct lx_silkit *self, const char *what);

/** Something that the library makes; kept when it does not come to an end. */
struct lx_silkit_call {
    /** Make it, on a thread of its own. @return 0, or -1 with `error` */
    int (*make)(struct lx_silkit_call *self, struct lx_error *error);
    struct lx_silkit *all;
    struct lx_silkit_port *port;
    char name[LX_SILKIT_TOPIC_MAX]; /**< the network or topic, for errors, too */
    const char *media_type;
    struct lx_sk_can *can;             /**< made */
    struct lx_sk_publisher *publisher; /**< made */
};

/** Have it made, for 10 s at most, or until a signal asks the program to end. What is not there
 * then is left behind: the rig is to be taken down. @return 0, or -1 with `error` */
int lx_silkit_wait(struct lx_silkit_call *call, struct lx_error *error);

/** Let the handlers' threads leave all signals to the loop: around whatever starts threads. */
void lx_silkit_mask(sigset_t *before);
void lx_silkit_unmask(const sigset_t *before);

#endif
