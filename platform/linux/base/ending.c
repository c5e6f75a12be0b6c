/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "ending.h"

#include "drehgeber/api.h"

static const struct {
    int number;
    bool unless_ignored;
} rows[] = {{SIGTERM, false}, {SIGINT, false}, {SIGHUP, true}, {SIGQUIT, true}};

void lx_ending_signals(sigset_t *set)
{
    struct sigaction before;
    (void)sigemptyset(set);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        if (!rows[i].unless_ignored ||
            (sigaction(rows[i].number, NULL, &before) == 0 && before.sa_handler != SIG_IGN)) {
            (void)sigaddset(set, rows[i].number);
        }
    }
}

bool lx_ending_asked(void)
{
    sigset_t wanted;
    sigset_t came;
    lx_ending_signals(&wanted);
    return sigpending(&came) == 0 && sigandset(&came, &came, &wanted) == 0 &&
           sigisemptyset(&came) == 0;
}
