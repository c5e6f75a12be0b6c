/* SPDX-License-Identifier: MIT */
/**
 * @file
 * From the threads of the SIL Kit library to the loop: the one place where they meet. A handler
 * puts a copy of what it was told into the list, under a lock, and wakes the loop, which takes the
 * whole list. Handlers touch nothing else.
 */
#ifndef DREHGEBER_LINUX_SILKIT_INBOX_H
#define DREHGEBER_LINUX_SILKIT_INBOX_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** What a handler was told. */
enum lx_silkit_kind {
    LX_SILKIT_FRAME,   /**< `port` received it: id, flags, bytes */
    LX_SILKIT_DATA,    /**< likewise: bytes */
    LX_SILKIT_REFUSED, /**< likewise, but it was longer than the port wants; no bytes */
    LX_SILKIT_LOST,    /**< a frame that `port` has sent was not transmitted */
    LX_SILKIT_STATE,   /**< of a controller: id is enum lx_sk_error_state */
    LX_SILKIT_READY,   /**< everybody can hear what is sent from now on */
    LX_SILKIT_STEP,    /**< it is `time`, and the step is to be completed */
    LX_SILKIT_GONE,    /**< a participant, whose name is in bytes */
    LX_SILKIT_ABORTED,
    LX_SILKIT_STOPPED,
    LX_SILKIT_SHUTDOWN,
};

/** Bytes that need no memory of their own. */
#define LX_SILKIT_SHORT 8u

struct lx_silkit_port;

/** A message. */
struct lx_silkit_message {
    enum lx_silkit_kind kind;
    struct lx_silkit_port *port; /**< NULL: it is about all */
    uint64_t time;               /**< ns, of the sender */
    uint64_t order;              /**< in which they came */
    uint32_t id;
    uint32_t flags;
    uint16_t dlc; /**< of a remote frame */
    size_t length;
    uint8_t *bytes; /**< owned; NULL: they are in `few` */
    uint8_t few[LX_SILKIT_SHORT];
};

/** Its bytes. */
const uint8_t *lx_silkit_bytes(const struct lx_silkit_message *self);

/** A growing list of messages. */
struct lx_silkit_list {
    struct lx_silkit_message *at; /**< owned */
    size_t first;                 /**< not taken yet */
    size_t count;                 /**< behind the last one */
    size_t capacity;
};

/** Append, which takes over `message->bytes`. @return false without memory */
bool lx_silkit_list_add(struct lx_silkit_list *self, const struct lx_silkit_message *message);

/** Forget those before `first`. */
void lx_silkit_list_trim(struct lx_silkit_list *self);

/** Give all back. */
void lx_silkit_list_free(struct lx_silkit_list *self);

/** The list under its lock. */
struct lx_silkit_inbox {
    pthread_mutex_t lock;
    pthread_cond_t over; /**< `ended` was set */
    struct lx_silkit_list list;
    uint64_t order;
    uint64_t lost; /**< messages for which there was no room */
    size_t bytes;  /**< in the list, beyond the short ones */
    bool closed;   /**< what comes now is ignored */
    bool ended;    /**< the participant's life is over */
    int wakes;     /**< eventfd; -1: none */
};

/** Make it. @return 0 or a negative errno */
int lx_silkit_inbox_open(struct lx_silkit_inbox *self);

/** Close it; not while somebody may still call. */
void lx_silkit_inbox_close(struct lx_silkit_inbox *self);

/** Any thread: copy `message` with `n` bytes into it, and wake the loop. */
void lx_silkit_inbox_put(struct lx_silkit_inbox *self, const struct lx_silkit_message *message,
                         const void *bytes, size_t n);

/** The loop: take everything, behind what is in `list`. @return how many were lost so far */
uint64_t lx_silkit_inbox_take(struct lx_silkit_inbox *self, struct lx_silkit_list *list);

/** The loop: nothing more is wanted; but wait until life is over, `ms` at most.
 * @return whether it is */
bool lx_silkit_inbox_wait(struct lx_silkit_inbox *self, unsigned ms);

#endif
