/* SPDX-License-Identifier: MIT */
/*
 *   node -- PDO, heartbeat, emergency ------------> wire
 *        \-- answer over SDO or LSS --(on disk?)---/
 *
 * Only an answer acknowledges. Everything else goes on, however long the disk takes.
 */
#include <string.h>

#include "can_bus.h"

/* An SDO server's answers, and the one to LSS. */
#define ID_SDO 0x580u
#define ID_LSS 0x7E4u
/* Two blocks of an upload, and some: a client that asks on and on is not waited for. */
#define ANSWERS_MAX 256u

static bool is_answer(const struct lx_can_node *from, const struct dg_can_frame *frame)
{
    return frame->id == ID_SDO + from->device.node.id || frame->id == ID_LSS;
}

void lx_can_answer(struct lx_can_node *from, const struct dg_can_frame *frame)
{
    const struct lx_can_waiting answer = {
        .from = from, .ticket = from->image.queue.issued, .frame = *frame};
    enum lx_nvm_answer what = LX_NVM_SAY;
    if (is_answer(from, frame)) {
        what = from->answers.count > 0 ? LX_NVM_KEEP : lx_nvm_queue_answer(&from->image.queue);
    }
    if (what == LX_NVM_SAY) {
        lx_can_put(from, frame);
    } else if (what == LX_NVM_KEEP && (from->answers.count == ANSWERS_MAX ||
                                       !lx_can_list_append(&from->answers, &answer))) {
        from->bus->can->counters.lost++;
    }
}

void lx_can_answer_settled(struct lx_can_node *from)
{
    struct lx_can_list *list = &from->answers;
    size_t done = 0;
    for (; done < list->count; done++) {
        const struct lx_can_waiting *answer = &list->frames[done];
        const enum lx_nvm_state state = lx_nvm_queue_state(&from->image.queue, answer->ticket);
        if (state == LX_NVM_PENDING) {
            break;
        }
        if (state == LX_NVM_THROUGH && from->hears) {
            lx_can_put(from, &answer->frame);
        }
    }
    list->count -= done;
    if (done > 0 && list->count > 0) {
        memmove(list->frames, list->frames + done, list->count * sizeof *list->frames);
    } else if (done > 0) {
        (void)lx_nvm_queue_answer(&from->image.queue); /* it has been given, or dropped */
    }
}

void lx_can_answer_none(struct lx_can_node *from)
{
    from->answers.count = 0;
}
