/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "record.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "give_up.h"

static char *read_text(const char *path)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = fopen(path, "r");
    if (file == NULL || getdelim(&text, &size, '\0', file) <= 0) {
        give_up("cannot read", path);
    }
    (void)fclose(file);
    return text;
}

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    if (file == NULL || fputs(text, file) < 0 || fclose(file) != 0) {
        give_up("cannot write", path);
    }
}

/* @return the next line of `*text` without its end; NULL behind the last */
static char *next_line(char **text)
{
    char *line = strsep(text, "\n");
    return line != NULL && *line == '\0' && *text == NULL ? NULL : line;
}

unsigned record_settle(const char *path, char *now, int update, record_difference *differs,
                       void *ctx)
{
    const char *section = "";
    unsigned differences = 0;
    if (update) {
        write_text(path, now);
        return 0;
    }
    char *text = read_text(path);
    char *before = text;
    for (char *was = next_line(&before), *is = next_line(&now); was != NULL || is != NULL;
         was = next_line(&before), is = next_line(&now)) {
        section = is != NULL && *is == '[' ? is : section;
        if (was == NULL || is == NULL || strcmp(was, is) != 0) {
            differences++;
            differs(ctx, section, was, is);
        }
    }
    free(text);
    return differences;
}
