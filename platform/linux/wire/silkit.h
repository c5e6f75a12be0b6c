/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A rig as a participant of a SIL Kit simulation: one for all of its wires, with a CAN controller
 * for each bus and topics for what else goes over wires and shafts.
 *
 * Time is that of the simulation, in steps, unless it is real. At the step at T all that others
 * have sent before T is there. It is handled at its own moments, in the order (time, wire, CAN-ID,
 * arrival), the rig's deadlines in between; what the rig sends meanwhile is stamped T.
 *
 *   others   ..f1....f2..|
 *   rig                  | -> f1, deadlines, f2, deadlines up to T; send; complete
 *                        T
 */
#ifndef DREHGEBER_LINUX_SILKIT_H
#define DREHGEBER_LINUX_SILKIT_H

#include <systemd/sd-event.h>

#include "plan.h"
#include "say.h"
#include "silkit_inbox.h"
#include "silkit_library.h"
#include "tap.h"
#include "timer.h"
#include "wire.h"

/** Longest parts of an address, with their zeros. */
#define LX_SILKIT_URI_MAX 200u
#define LX_SILKIT_NAME_MAX 64u
/** Longest topic: PARTICIPANT/shaft/NAME/... */
#define LX_SILKIT_TOPIC_MAX 200u

/** An address. */
struct lx_silkit_where {
    char uri[LX_SILKIT_URI_MAX];
    char network[LX_SILKIT_NAME_MAX];
    char participant[LX_SILKIT_NAME_MAX];               /**< "": the rig's name */
    char ready[LX_SILKIT_URI_MAX + LX_SILKIT_NAME_MAX]; /**< what a ready line says: both */
};

/** Understand "silkit://HOST:PORT,NETWORK[,PARTICIPANT]". @return 0, or -1 with `error` */
int lx_silkit_split(const char *where, struct lx_silkit_where *out, struct lx_error *error);
/** Whether a thread hangs in the library: then the process is to end without looking back. */
bool lx_silkit_is_left_behind(void);

/** Whether the registry is of this machine only. */
bool lx_silkit_is_loopback(const struct lx_silkit_where *self);

struct lx_silkit;

/** Topics of a serial line: what they are made of, and the longest message: more than a line of 38400
 * Bd carries in a second. */
#define LX_SILKIT_CHARACTERS "application/vnd.drehgeber.characters.v1"
#define LX_SILKIT_CHARACTERS_MAX 4096u

/** Something that sends and receives: a controller, or a topic. Its owner's, filled by the
 * functions below. */
struct lx_silkit_port {
    struct lx_silkit *all;
    size_t place;                    /**< among all ports */
    char topic[LX_SILKIT_TOPIC_MAX]; /**< "": of CAN */
    size_t length_min;               /**< of what may be received; */
    size_t length_max;               /**< anything else is left out, and said once */
    bool packed;      /**< a message is frames (silkit_pack.h), of which each is received */
    uint64_t refused; /**< how often */
    struct lx_sk_can *can;
    struct lx_sk_publisher *publisher;
    /** A message has come at `now`; more of the same moment may follow unless it is the `last`.
     * NULL: nothing is received. */
    void (*receive)(void *ctx, dg_ns now, const struct lx_silkit_message *message, bool last);
    /** Everybody can hear now. NULL: nobody minds. */
    void (*ready)(void *ctx, dg_ns now);
    /** The step at `now` ends: what is to be said in each. NULL: nothing. */
    void (*step)(void *ctx, dg_ns now);
    void *ctx;
    /** Of a packed bus: its deadline and who listens to it. Then it may be stepped on another
     * thread than the loop's (silkit_lanes.h). NULL: it is not */
    struct lx_timer *timer;
    const struct lx_tap *tap;
    size_t lane;  /**< which it is in, */
    bool in_lane; /**< ... if it is in one now */
};

/** A rig's. `event` NULL: it is only asked whether it can be. */
struct lx_silkit *lx_silkit_new(sd_event *event, const struct lx_say *say, const char *name);

/** A wire of the plan is to be on it. All wires of a rig have one registry, one participant and
 * the same settings. @return 0, or -1 with `error` */
int lx_silkit_add(struct lx_silkit *self, const struct dg_plan *plan,
                  const struct dg_plan_wire *wire, struct lx_error *error);

/** Whether any is, and time is not real. */
bool lx_silkit_is_virtual(const struct lx_silkit *self);

/** A wire joins the simulation, the first one for all; from here on ports can be made. `where`: the
 * address in its plan, `out`: its parts. @return 0, or -1 with one line in `error` */
int lx_silkit_join(struct lx_silkit *self, const char *where, struct lx_silkit_where *out,
                   struct lx_error *error);

/** A CAN controller on `network`, at port->can. The functions of `port` and its `ctx` are set.
 * @return 0, or -1 with `error` */
int lx_silkit_open_can(struct lx_silkit *self, struct lx_silkit_port *port, const char *network,
                       struct lx_error *error);

/** Receive what others publish as port->topic, of port->length_min..length_max bytes; as above. */
int lx_silkit_subscribe(struct lx_silkit *self, struct lx_silkit_port *port, const char *media_type,
                        struct lx_error *error);

/** Publish as port->topic; as above. */
int lx_silkit_offer(struct lx_silkit *self, struct lx_silkit_port *port, const char *media_type,
                    struct lx_error *error);

/** Name a topic: "NAME/LAST". */
void lx_silkit_name_topic(struct lx_silkit_port *port, const char *name, const char *last);

/** Whether it has. */
bool lx_silkit_has_joined(const struct lx_silkit *self);

/** All ports are there: life begins. * @return 0, or -1 with `error` */
int lx_silkit_start(struct lx_silkit *self, struct lx_error *error);

/** Whether what is sent is heard. */
bool lx_silkit_is_ready(const struct lx_silkit *self);

/** Whether our time is real, and somebody has sent something who has virtual time. The other way
 * round nobody can tell. */
bool lx_silkit_has_mixed_time(const struct lx_silkit *self);

/** Publish. What cannot be is said once. */
void lx_silkit_publish(struct lx_silkit_port *port, const void *bytes, size_t n);

/** What a network simulator has to know of the controller. */
void lx_silkit_baud_rate(struct lx_silkit_port *port, uint32_t rate);

/** Send a frame. */
void lx_silkit_send(struct lx_silkit_port *port, uint16_t id, bool remote, const uint8_t *bytes,
                    uint8_t n);

/** The simulation's time, in nanoseconds, at this moment of the rig's; in real time the rig's. */
uint64_t lx_silkit_time_at(const struct lx_silkit *self, dg_ns now);

/** The name that the rig has there. */
const char *lx_silkit_name(const struct lx_silkit *self);

/** The rig's part is over once the simulation's time is beyond `span` after its beginning: then the
 * loop ends. Where several end so, all of them have done the step at `span`, and none a later one.
 */
void lx_silkit_end_after(struct lx_silkit *self, dg_ns span);

/** Time is the simulation's: do one thing of the present step, a deadline or a message.
 * @return false: nothing is left before the library calls again */
bool lx_silkit_step(struct lx_silkit *self);

/** Leave the simulation: nothing is sent or received any more. Before the ports are given back;
 * NULL is fine. */
void lx_silkit_leave(struct lx_silkit *self);

/** Give it back; NULL is fine. */
void lx_silkit_free(struct lx_silkit *self);

#endif
