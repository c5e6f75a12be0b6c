/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Whether clauses and rows fit each other.
 */
#ifndef TESTS_CONFORMANCE_AUDIT_H
#define TESTS_CONFORMANCE_AUDIT_H

#include "rows.h"

/** What an audit finds, by kind. */
struct cf_audit {
    unsigned duplicate;   /**< IDs that stand twice */
    unsigned unknown;     /**< citations of an ID that does not exist */
    unsigned uncovered;   /**< clauses without a row */
    unsigned expectless;  /**< rows that cannot fail */
    unsigned clauseless;  /**< rows that cite nothing */
    unsigned same_titled; /**< rows with the title of another row */
    unsigned unlisted;    /**< listed clauses that the page does not have, or that a row cites */
};

/** Check that clauses and rows fit each other; says every finding on `to`. */
struct cf_audit cf_audit(struct cf_suite *suite, const struct cf_device *device, FILE *to);

/** Clauses covered per chapter, on `to`. Call after cf_audit(). */
void cf_summary(const struct cf_suite *suite, FILE *to);

#endif
