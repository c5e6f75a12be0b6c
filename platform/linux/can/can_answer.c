/* SPDX-License-Identifier: MIT */
/*
 *   node -- PDO, heartbeat, emergency ------------> wire
 *        \-- answer over SDO or LSS --(on disk?)---/
 *
 * Only an answer acknowledges. Everything else goes on, however long the disk takes.
 */
#include <stdlib.h>
#include <string.h>

#include "can_bus.h"

#define LIST_FIRST 16u
/* An SDO server's answers, and the one to LSS. */
#define ID_SDO 0x580u
#define ID_LSS 0x7E4u
/* Two blocks of an upload, and some: a client that asks on and on is not waited for. */
#define ANSWERS_MAX 256u

bool lx_can_list_append(struct lx_can_list *self, const struct lx_can_waiting *frame)
{
    if (self->count == self->capacity) {
        const size_t capacity = self->capacity == 0 ? LIST_FIRST : 2 * self->capacity;
        struct lx_can_waiting *frames = realloc(self->frames, capacity * sizeof *frames);
        if (frames == NULL) {
            return false;
        }
        self->frames = frames;
        self->capacity = capacity;
    }
    self->frames[self->count++] = *frame;
    return true;
}

static void emit(struct lx_can_node *from, const struct dg_can_frame *frame)
{
    if (from->bent) {
        lx_can_emit_bent(from, frame);
    } else {
        lx_can_emit(from, frame);
    }
}

static bool is_answer(const struct lx_can_node *from, const struct dg_can_frame *frame)
{
    return frame->id == ID_SDO + from->device.id || frame->id == ID_LSS;
}

void lx_can_answer(struct lx_can_node *from, const struct dg_can_frame *frame)
{
    const bool waits = from->answers.count > 0 || lx_nvm_queue_pending(&from->queue);
    const struct lx_can_waiting answer = {
        .from = from, .ticket = from->queue.issued, .frame = *frame};
    if (!waits || !is_answer(from, frame)) {
        emit(from, frame);
    } else if (from->answers.count == ANSWERS_MAX || !lx_can_list_append(&from->answers, &answer)) {
        from->bus->can->counters.lost++;
    }
}

void lx_can_answer_settled(struct lx_can_node *from)
{
    struct lx_can_list *list = &from->answers;
    size_t done = 0;
    for (; done < list->count; done++) {
        const struct lx_can_waiting *answer = &list->frames[done];
        const enum lx_nvm_state state = lx_nvm_queue_state(&from->queue, answer->ticket);
        if (state == LX_NVM_PENDING) {
            break;
        }
        if (state == LX_NVM_THROUGH && from->hears) {
            emit(from, &answer->frame);
        }
    }
    list->count -= done;
    if (done > 0 && list->count > 0) {
        memmove(list->frames, list->frames + done, list->count * sizeof *list->frames);
    }
}

void lx_can_answer_none(struct lx_can_node *from)
{
    from->answers.count = 0;
}
