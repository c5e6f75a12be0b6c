/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A record of what a release has said: a text, line by line.
 */
#ifndef TESTS_GOLDEN_RECORD_H
#define TESTS_GOLDEN_RECORD_H

/** A line that differs: `was` and `is` are NULL where there is none. `section` is the last line of
 * `now` that began with a bracket. */
typedef void record_difference(void *ctx, const char *section, const char *was, const char *is);

/**
 * What a program is for, which ends when a file cannot be read or written: `--update` writes `now`
 * to `path`; else it is compared with what stands there, line by line.
 * @return how many lines differ
 */
unsigned record_settle(const char *path, char *now, int update, record_difference *differs,
                       void *ctx);

#endif
