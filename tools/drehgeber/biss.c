/* SPDX-License-Identifier: MIT */
#include "biss.h"

#include <stdio.h>
#include <string.h>

#include "biss_eds.h"
#include "drehgeber/figure.h"
#include "run.h"
#include "stacks.h"
#include "wire_session.h"

#define RIGHT "read, registers [BANK:]ADDR N, eds, write [BANK:]ADDR BYTES or command N"
#define BANK_SELECT 0x40u
#define COMMAND_REGISTER 0x60u
#define ADDRESSES 0x80u
#define PER_LINE 16u

static int act(struct wire_session *self, struct words *words, struct lx_error *error);

static const struct wire_command biss = {"biss", &lx_biss_stack, "a BiSS model", RIGHT, act};

static int usage(struct lx_error *error, const char *what, const char *word)
{
    return wire_command_usage(&biss, what, word, error);
}

static bool take_number(struct words *words, uint64_t max, uint64_t *value)
{
    const char *word = take_word(words);

    return word != NULL && dg_unsigned_parse(word, value) && *value <= max;
}

/* Pairs of hexadecimal digits; a word that is something else is left. */
static size_t take_bytes(struct words *words, uint8_t *bytes, size_t capacity)
{
    size_t n = 0;

    while (words->count > 0) {
        const char *word = *words->at;
        const size_t length = strlen(word);
        if (length == 0 || length % 2 != 0 || strspn(word, "0123456789abcdefABCDEF") != length ||
            n + length / 2 > capacity) {
            break;
        }
        for (size_t i = 0; i < length; i += 2) {
            const char digits[5] = {'0', 'x', word[i], word[i + 1], '\0'};
            uint64_t value = 0;
            (void)dg_unsigned_parse(digits, &value);
            bytes[n++] = (uint8_t)value;
        }
        (void)take_word(words);
    }
    return n;
}

/* How an access went wrong. Manuals write addresses in hexadecimal digits, and without 0x they are
   read as decimal: both are told. */
static int complain_access(struct lx_error *error, const char *what, unsigned address, int result)
{
    (void)lx_fail(error, "%s 0x%02X (%u): %s", what, address, address,
                  dg_biss_failure_text(result));
    return EXIT_OTHER;
}

static int select_bank(struct wire_session *self, uint8_t bank, struct lx_error *error)
{
    struct dg_biss_access access = {.address = BANK_SELECT, .sent = &bank, .n = 1};
    const int result = dg_biss_access(&self->master, &access);

    return result < 0 ? complain_access(error, "bank select", BANK_SELECT, result) : 0;
}

/* [BANK:]ADDR */
static int take_address(struct wire_session *self, struct words *words, uint8_t *address,
                        struct lx_error *error)
{
    char bank[8] = "";
    uint64_t number = 0;
    const char *word = take_word(words);
    const char *colon = word == NULL ? NULL : strchr(word, ':');

    if (colon != NULL && (size_t)(colon - word) < sizeof bank) {
        memcpy(bank, word, (size_t)(colon - word));
        if (!dg_unsigned_parse(bank, &number) || number > UINT8_MAX) {
            return usage(error, "no bank: ", bank);
        }
        const int result = select_bank(self, (uint8_t)number, error);
        if (result != 0) {
            return result;
        }
        word = colon + 1;
    }
    if (word == NULL || !dg_unsigned_parse(word, &number) || number >= ADDRESSES) {
        return word == NULL ? usage(error, "no address", "")
                            : usage(error, "no address of 0x00..0x7F: ", word);
    }
    *address = (uint8_t)number;
    return 0;
}

static int read_all(struct wire_session *self, uint8_t address, uint8_t *bytes, size_t n,
                    struct lx_error *error)
{
    struct dg_biss_access access = {.address = address, .got = bytes, .n = n};
    const int result = dg_biss_access(&self->master, &access);

    return result < 0 ? complain_access(error, "read", address + (unsigned)access.done, result) : 0;
}

static int write_all(struct wire_session *self, uint8_t address, const uint8_t *bytes, size_t n,
                     struct lx_error *error)
{
    struct dg_biss_access access = {.address = address, .sent = bytes, .n = n};
    const int result = dg_biss_access(&self->master, &access);

    return result < 0 ? complain_access(error, "write", address + (unsigned)access.done, result)
                      : 0;
}

static int do_read(struct wire_session *self, struct words *words, struct lx_error *error)
{
    static const int results[] = {
        [DG_MASTER_WRONG] = DG_BISS_DAMAGED,
        [DG_MASTER_SILENT] = DG_BISS_SILENT,
    };
    const enum dg_master_verdict verdict = wire_session_read(self);

    (void)words;
    return verdict == DG_MASTER_GOOD ? 0 : complain_access(error, "position", 0, results[verdict]);
}

static int do_registers(struct wire_session *self, struct words *words, struct lx_error *error)
{
    uint8_t bytes[ADDRESSES] = {0};
    uint8_t address = 0;
    uint64_t n = 0;
    int result = take_address(self, words, &address, error);

    if (result != 0) {
        return result;
    }
    if (!take_number(words, ADDRESSES - address, &n) || n == 0) {
        char what[80];
        (void)snprintf(what, sizeof what, "registers 0x%02X (%u) needs a number N of 1..%u",
                       address, address, ADDRESSES - address);
        return usage(error, what, "");
    }
    result = read_all(self, address, bytes, (size_t)n, error);
    for (size_t i = 0; result == 0 && i < n; i++) {
        const bool last = i + 1 == n || (i + 1) % PER_LINE == 0;
        (void)printf("%02X%c", bytes[i], last ? '\n' : ' ');
    }
    return result;
}

static int do_eds(struct wire_session *self, struct words *words, struct lx_error *error)
{
    uint8_t banks[2][DG_BISS_BANK_SIZE];

    (void)words;
    for (uint8_t i = 0; i < 2; i++) {
        int result = select_bank(self, (uint8_t)(3u + i), error);
        result = result == 0 ? read_all(self, 0, banks[i], DG_BISS_BANK_SIZE, error) : result;
        if (result != 0) {
            return result;
        }
    }
    if (biss_eds_print(banks[0], banks[1], stdout) != 0) {
        (void)lx_fail(error, "eds: a check sum is wrong");
        return EXIT_OTHER;
    }
    return 0;
}

static int do_write(struct wire_session *self, struct words *words, struct lx_error *error)
{
    uint8_t bytes[DG_BISS_BANK_SIZE];
    uint8_t address = 0;
    int result = take_address(self, words, &address, error);

    if (result != 0) {
        return result;
    }
    const size_t n = take_bytes(words, bytes, sizeof bytes);
    if (n == 0) {
        return usage(error, "write needs 1..64 BYTES in hexadecimal, e.g. A5 or 01 02 03", "");
    }
    return write_all(self, address, bytes, n, error);
}

static int do_command(struct wire_session *self, struct words *words, struct lx_error *error)
{
    uint64_t number = 0;

    if (!take_number(words, UINT8_MAX, &number)) {
        return usage(error, "command needs a number of 0..255", "");
    }
    const uint8_t command = (uint8_t)number;
    struct dg_biss_access access = {.address = COMMAND_REGISTER, .sent = &command, .n = 1};
    const int result = dg_biss_access(&self->master, &access);
    if (result < 0) {
        return complain_access(error, "command", command, result);
    }
    dg_bus_master_pause(&self->master,
                        self->master.now +
                            (command == DG_BISS_SOFT_RESET ? lx_clocked_init(self->line) : 0));
    return 0;
}

static const struct {
    const char *name;
    int (*act)(struct wire_session *self, struct words *words, struct lx_error *error);
} actions[] = {
    {"read", do_read},   {"registers", do_registers}, {"eds", do_eds},
    {"write", do_write}, {"command", do_command},
};
#define ACTION_COUNT DG_COUNT(actions)

static int act(struct wire_session *self, struct words *words, struct lx_error *error)
{
    const char *word = take_word(words);

    for (size_t i = 0; i < ACTION_COUNT; i++) {
        if (strcmp(word, actions[i].name) == 0) {
            return actions[i].act(self, words, error);
        }
    }
    return usage(error, "unknown action ", word);
}

int biss_command(const struct options *options)
{
    return wire_command_run(&biss, options);
}
