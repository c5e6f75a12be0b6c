/* SPDX-License-Identifier: MIT */
/*
 * A rig file with one encoder, in virtual time; lines come in, what it says goes out.
 *
 *   NS scpi LINE    a line of SCPI at this moment: "NUMBER ANSWER", or the error
 *   NS clock LINE   the same, for a line that lets the master clock a frame: its levels are told
 *   NS send HEX     the master says these bytes: "NUMBER"
 *
 * In front of it stands what the encoder has sent: "@NS byte HH", "@NS message ID FLAGS HEX;",
 * "@NS levels CLOCK DATA". usage: differential_rig RIG.ini < LINES
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "give_up.h"
#include "hf_rig.h"
#include "timer.h"
#include "told.h"
#include "virtual_rig.h"

#define LINE_CHARS_MAX 512u

static void ask_scpi(struct virtual_rig *rig, unsigned number, const char *command)
{
    virtual_rig_ask(rig, command);
    told_levels = false;
    if (rig->answer[0] == '\0') {
        virtual_rig_ask(rig, "SYST:ERR?");
    }
    printf("%u %s\n", number, rig->answer);
}

static void clock_frame(struct virtual_rig *rig, unsigned number, const char *command)
{
    told_levels = true;
    ask_scpi(rig, number, command);
}

static void send_bytes(struct virtual_rig *rig, unsigned number, const char *digits)
{
    uint8_t bytes[LINE_CHARS_MAX / 2u];
    const size_t n = hf_rig_hex(digits, bytes, sizeof bytes);

    virtual_rig_say(rig, bytes, n);
    printf("%u\n", number);
}

static const struct {
    const char *name;
    void (*run)(struct virtual_rig *rig, unsigned number, const char *text);
} operations[] = {
    {"scpi ", ask_scpi},
    {"clock ", clock_frame},
    {"send ", send_bytes},
};

static void do_line(struct virtual_rig *rig, unsigned number, char *line)
{
    char *rest = NULL;
    const dg_ns at = strtoull(line, &rest, 10);

    if (at > lx_now()) {
        virtual_rig_pass_to(rig, at);
    }
    for (size_t i = 0; i < DG_COUNT(operations); i++) {
        const size_t n = strlen(operations[i].name);

        if (*rest == ' ' && strncmp(rest + 1, operations[i].name, n) == 0) {
            operations[i].run(rig, number, rest + 1 + n);
            return;
        }
    }
    give_up("no such operation", line);
}

int main(int argc, char *argv[])
{
    static struct virtual_rig rig;
    struct lx_tap_listener listener = {.event = told_print};
    char line[LINE_CHARS_MAX];

    if (argc != 2) {
        fprintf(stderr, "usage: differential_rig RIG.ini < LINES\n");
        return 2;
    }
    virtual_rig_open(&rig, argv[1], &listener);
    if (strcmp(virtual_rig_wire(&rig), "sim") != 0) {
        virtual_rig_connect(&rig);
    }
    for (unsigned number = 1; fgets(line, sizeof line, stdin) != NULL; number++) {
        line[strcspn(line, "\n")] = '\0';
        do_line(&rig, number, line);
        (void)fflush(stdout);
    }
    virtual_rig_close(&rig);
    return 0;
}
