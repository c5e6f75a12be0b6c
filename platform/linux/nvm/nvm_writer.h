/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The one thread of a process: it writes EEPROM files, so that a slow or stuck disk delays only who
 * waits for it. Everything else runs in the event loop.
 *
 * A queue stands between a device and its file. The device works on a copy in memory, and what it
 * writes and syncs goes to the file in the same order, later. A sync waits for a moment, in which a
 * healthy disk may be through, or say no. After that it says yes, and whoever answers for the
 * device keeps what acknowledges it to himself until the sync's ticket is through.
 */
#ifndef DREHGEBER_LINUX_NVM_WRITER_H
#define DREHGEBER_LINUX_NVM_WRITER_H

#include <systemd/sd-event.h>

#include "drehgeber/bus.h"
#include "drehgeber/hal.h"
#include "drehgeber/time.h"
#include "say.h"

/** How long a sync waits in the loop before the device goes on without it: time in which the disk
 * works for it, */
#define LX_NVM_MOMENT DG_MS(2)
/** and with the time in which the thread waits for a processor, as the loop may have to as well. */
#define LX_NVM_MOMENT_MAX DG_MS(50)

/** The thread, and the queues it serves in turn. */
struct lx_nvm_writer;

/** What has become of a sync. */
enum lx_nvm_state {
    LX_NVM_THROUGH, /**< all that was written before is durable */
    LX_NVM_PENDING,
    LX_NVM_LOST, /**< it failed after it had said yes; it may get through later, when the file works
                  */
};

/** What the thread has to do for a queue: a write, or a sync; private. */
struct lx_nvm_job;

/** In the order of their arrival. */
struct lx_nvm_jobs {
    struct lx_nvm_job *first; /**< owned */
    struct lx_nvm_job *last;
};

/** What a queue is made of. */
struct lx_nvm_queue_setup {
    struct lx_nvm_writer *writer; /**< NULL: no queue, the device works on the memory itself */
    struct dg_nvm below; /**< the thread's from open to close, but for its reads; may block */
    uint32_t size;       /**< bytes of it */
    const char *path;    /**< of its file, for messages */
    /** In the loop: a sync is through, or lost. Optional; whoever keeps answers back needs it. */
    void (*settled)(void *ctx, dg_ns now);
    void *ctx;
};

/** A device's memory in front of its file. All zero: not open. Not to be moved while it is. */
struct lx_nvm_queue {
    struct lx_nvm_queue_setup setup;
    uint8_t *bytes;             /**< owned: what the device reads */
    struct lx_nvm_queue *later; /**< the writer's next queue, */
    struct lx_nvm_queue **open; /**< ... and what points to this one */
    uint64_t issued;            /**< ticket of the last sync */
    uint64_t known;             /**< ... of the last one that an answer was said or dropped for */
    uint32_t waits;             /**< syncs that took longer than a moment */
    bool emptied;               /**< `bytes` are to be read anew */
    /* what the thread looks at, too */
    struct lx_nvm_queue *behind; /**< in the line for the thread */
    struct lx_nvm_jobs jobs;     /**< to be done; those that failed are at the front */
    struct lx_nvm_jobs spent;    /**< to be given back by the loop: the thread needs no allocator */
    uint64_t done;               /**< ticket of the last sync that is through */
    bool lined_up;               /**< in the line, or being served */
    bool stalled;                /**< the first job failed */
    struct lx_nvm_queue *tells;  /**< of those with news for settled(), the next one */
    bool news;                   /**< it is among them */
};

/**
 * A writer without a thread yet.
 * @param settled in the loop, after those of the queues: some sync is through or lost; optional
 * @return NULL without memory
 */
struct lx_nvm_writer *lx_nvm_writer_new(sd_event *event, void (*settled)(void *ctx), void *ctx);

/** End the thread, when all queues are closed; NULL is fine. */
void lx_nvm_writer_free(struct lx_nvm_writer *self);

/** Whether what the files are made for may still be refused: then whoever closes a new one removes
 * it. Not so in a new writer; NULL: never. */
void lx_nvm_writer_try(struct lx_nvm_writer *self, bool on_trial);
bool lx_nvm_writer_on_trial(const struct lx_nvm_writer *self);

/** Ticket of the last sync of any queue; they count up. NULL: 0. */
uint64_t lx_nvm_writer_ticket(const struct lx_nvm_writer *self);

/** The syncs behind the one with ticket `after`, up to `ticket`; lost, if one of them is. */
enum lx_nvm_state lx_nvm_writer_state(struct lx_nvm_writer *self, uint64_t after, uint64_t ticket);

/**
 * Put a queue in front of a memory, and start the thread if this is the first one.
 * @param nvm what the device is to work on from here on: the queue, or without a writer `below`
 * @return 0, or -1 with one line in `error`
 */
int lx_nvm_queue_open(struct lx_nvm_queue *self, const struct lx_nvm_queue_setup *setup,
                      struct dg_nvm *nvm, struct lx_error *error);

/** Wait until all is written, and say so when that takes longer than a second; what failed is tried
 * once more. Also when it is not open. */
void lx_nvm_queue_close(struct lx_nvm_queue *self);

/** What has become of the sync with `ticket` and of all before it. Through, when it is not open. */
enum lx_nvm_state lx_nvm_queue_state(struct lx_nvm_queue *self, uint64_t ticket);

/** What to do with what acknowledges a sync. */
enum dg_bus_answer lx_nvm_answer_of(enum lx_nvm_state state);

/** What to do with what the device answers now: it may acknowledge its last sync. What is kept is
 * to be asked for again when settled() is called; behind what is dropped the next one may be said.
 */
enum dg_bus_answer lx_nvm_queue_answer(struct lx_nvm_queue *self);

#endif
