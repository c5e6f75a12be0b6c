/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "canopen_bench.h"

#include <stdlib.h>
#include <string.h>

/* The value of a key, up to the end of its line; NULL when section or key are not there. */
static const char *find_value(char *text, const char *section, const char *key)
{
    char head[64];
    char line[64];

    (void)snprintf(head, sizeof head, "\n[%s]\r", section);
    (void)snprintf(line, sizeof line, "\n%s=", key);
    char *at = strstr(text, head);
    if (at == NULL) {
        return NULL;
    }
    at += strlen(head);
    char *end = strstr(at, "\n[");
    if (end != NULL) {
        *end = '\0';
    }
    char *found = strstr(at, line);
    if (found == NULL) {
        return NULL;
    }
    found += strlen(line);
    found[strcspn(found, "\r")] = '\0';
    return found;
}

static void write_text(void *to, const char *text, size_t n)
{
    (void)fwrite(text, 1, n, to);
}

bool canopen_eds(const struct dg_device *device, char **words, size_t n, struct cf_report *report)
{
    char *text = NULL;
    size_t size = 0;
    FILE *to = n == 4 ? open_memstream(&text, &size) : NULL;

    if (to == NULL) {
        return cf_fail(report, "eds SECTION KEY VALUE|none");
    }
    dg_co_eds(dg_cia406_sheet(dg_cia406_model_of(device)->device), write_text, to);
    (void)fclose(to);
    const char *got = find_value(text, words[1], words[2]);
    const char *shown = got != NULL ? got : "none";
    bool right = strcmp(shown, words[3]) == 0;
    if (!right) {
        (void)cf_fail(report, "eds: [%s] %s is %s", words[1], words[2], shown);
    }
    free(text);
    return right;
}
