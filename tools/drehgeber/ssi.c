/* SPDX-License-Identifier: MIT */
#include "ssi.h"

#include <string.h>

#include "run.h"
#include "stacks.h"
#include "wire_session.h"

static int act(struct wire_session *self, struct words *words, struct lx_error *error);

static const struct wire_command ssi = {"ssi", &lx_ssi_stack, "an SSI model", "read", act};

static int act(struct wire_session *self, struct words *words, struct lx_error *error)
{
    static const char *const failures[] = {
        [DG_MASTER_WRONG] = "the parity is wrong",
        [DG_MASTER_SILENT] = "no answer",
    };
    const char *word = take_word(words);

    if (strcmp(word, "read") != 0) {
        return wire_command_usage(&ssi, "unknown action ", word, error);
    }
    const enum dg_master_verdict verdict = wire_session_read(self);
    if (verdict == DG_MASTER_GOOD) {
        return EXIT_OK;
    }
    (void)lx_fail(error, "position: %s", failures[verdict]);
    return EXIT_OTHER;
}

int ssi_command(const struct options *options)
{
    return wire_command_run(&ssi, options);
}
