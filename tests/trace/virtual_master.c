/* SPDX-License-Identifier: MIT */
/*
 * A rig in virtual time, and its master at a TCP port of its wire, led by lines on stdin. Each is
 * answered with a line: what the master has heard since the last one, as hexadecimal text.
 *
 *   say HEX        say these bytes now
 *   hear N NS      let time go on until N more bytes are heard, which must come within that time
 *   pass NS        let time go on for so long; what is heard is waited for no more
 *   order LINE     a line of the control plane, which must not be refused
 *
 * usage: virtual_master RIG.ini
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "give_up.h"
#include "hf_rig.h"
#include "timer.h"
#include "virtual_rig.h"

#define SAID_MAX 256u

struct master {
    struct virtual_rig rig;
    size_t heard; /* and not waited for yet */
};

static void on_heard(void *ctx, const uint8_t *bytes, size_t n)
{
    struct master *self = ctx;
    self->heard += n;
    for (size_t i = 0; i < n; i++) {
        (void)printf("%02X", bytes[i]);
    }
}

static void say_bytes(struct master *self, char *rest)
{
    uint8_t bytes[SAID_MAX];
    virtual_rig_say(&self->rig, bytes, hf_rig_hex(rest, bytes, sizeof bytes));
}

static void await_bytes(struct master *self, char *rest)
{
    const size_t n = strtoul(rest, &rest, 10);
    const dg_ns end = lx_now() + strtoull(rest, NULL, 10);
    virtual_rig_serve(&self->rig);
    while (self->heard < n && lx_time_pass(end)) {
        virtual_rig_serve(&self->rig);
    }
    if (self->heard < n) {
        give_up("the master waits in vain", self->rig.name);
    }
    self->heard -= n;
}

static void pass_time(struct master *self, char *rest)
{
    virtual_rig_pass(&self->rig, strtoull(rest, NULL, 10));
    self->heard = 0;
}

static void order_rig(struct master *self, char *rest)
{
    virtual_rig_order(&self->rig, "%s", rest);
}

static const struct {
    const char *word;
    void (*act)(struct master *self, char *rest);
} commands[] = {
    {"say", say_bytes}, {"hear", await_bytes}, {"pass", pass_time}, {"order", order_rig}};

static void obey(struct master *self, char *line)
{
    char *rest = line;
    const char *word = strsep(&rest, " ");
    for (size_t i = 0; rest != NULL && i < DG_COUNT(commands); i++) {
        if (strcmp(word, commands[i].word) == 0) {
            commands[i].act(self, rest);
            return;
        }
    }
    give_up("expected say, hear, pass or order", word);
}

int main(int argc, char **argv)
{
    struct master master = {.rig = {.heard = on_heard, .ctx = &master}};
    char line[1024];
    if (argc != 2) {
        (void)fprintf(stderr, "usage: %s RIG.ini\n", argv[0]);
        return 2;
    }
    virtual_rig_open(&master.rig, argv[1], NULL);
    virtual_rig_connect(&master.rig);
    while (fgets(line, sizeof line, stdin) != NULL) {
        line[strcspn(line, "\n")] = '\0';
        obey(&master, line);
        (void)puts("");
        (void)fflush(stdout);
    }
    virtual_rig_close(&master.rig);
    return 0;
}
