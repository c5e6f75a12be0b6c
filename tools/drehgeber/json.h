/* SPDX-License-Identifier: MIT */
/* Texts for programs that read what a command prints. */
#ifndef DREHGEBER_TOOL_JSON_H
#define DREHGEBER_TOOL_JSON_H

/* "text", on stdout, with what JSON wants escaped. The text is UTF-8. */
void json_string(const char *text);

/* "name": "text" */
void json_member(const char *name, const char *text);

#endif
