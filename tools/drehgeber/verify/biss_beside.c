/* SPDX-License-Identifier: MIT */
/* What the rows of BiSS are run for, and what is asked beside their model. */
#include <string.h>

#include "biss_bench.h"

static struct cf_biss_trial trial;

void cf_biss_try(const struct cf_biss_trial *wanted)
{
    trial = wanted != NULL ? *wanted : (struct cf_biss_trial){.model = NULL};
}

const struct cf_biss_trial *biss_trial(void)
{
    return &trial;
}

bool biss_has_beside(void)
{
    return trial.beside.ops != NULL;
}

bool biss_need(unsigned needs, struct cf_report *report)
{
    return !biss_has_beside() || needs == 0 ||
           trial.beside.ops->needs(trial.beside.ctx, needs, report);
}

bool biss_wait_beside(struct biss_bench *b, dg_ns wait, struct cf_report *report)
{
    biss_bench_wait(b, wait + trial.slack);
    return !biss_has_beside() || trial.beside.ops->waited(trial.beside.ctx, wait, report);
}

bool biss_power_beside(bool on, struct cf_report *report)
{
    return !biss_has_beside() || trial.beside.ops->powered(trial.beside.ctx, on, report);
}

bool biss_ask(struct biss_bench *b, uint16_t kind, const void *what, size_t n,
              struct cf_report *report)
{
    const struct cf_unit unit = {.id = kind, .bytes = what, .n = n};

    b->asked = true;
    b->frames_before = b->master.frames;
    return !biss_has_beside() || trial.beside.ops->sent(trial.beside.ctx, &unit, report);
}

bool biss_judge(const struct biss_bench *b, uint16_t kind, const struct biss_said *said,
                struct cf_report *report)
{
    const struct cf_unit got = {.id = kind, .bytes = said->what, .n = said->n};
    const struct cf_answer answer = {
        .want = said->matched ? got : (struct cf_unit){.bytes = NULL},
        .got = got,
        .earliest_ns = trial.placed ? 0 : (b->master.frames - b->frames_before) * trial.frame_ns,
    };

    return trial.beside.ops->answered(trial.beside.ctx, &answer, report);
}

void cf_biss_clock(struct biss_master *master, struct cf_biss_frames *frames)
{
    size_t n = 0;

    for (; frames->cdm[n] != '\0'; n++) {
        biss_master_frame(master, &frames->last, frames->cdm[n] == '1');
        frames->cds[n] = frames->last.cds ? '1' : '0';
    }
    frames->cds[n] = '\0';
}

void cf_biss_access(struct biss_master *master, struct cf_biss_access *access)
{
    master->stray = access->stray;
    biss_master_access(master, &access->access);
    access->heard = strlen(master->cds) > 10u && strchr(master->cds + 10, '1') != NULL;
}

bool cf_biss_is_own(uint8_t address)
{
    static const struct {
        uint8_t first;
        uint8_t last;
    } own[] = {{0x44, 0x47}, {0x61, 0x68}, {0x6A, 0x6B}, {0x7D, 0x7D}};

    for (size_t i = 0; i < DG_COUNT(own); i++) {
        if (address >= own[i].first && address <= own[i].last) {
            return true;
        }
    }
    return false;
}
