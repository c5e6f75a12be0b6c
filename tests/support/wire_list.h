/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What messages list, for tests that a new kind of wire does not concern.
 */
#ifndef TESTS_SUPPORT_WIRE_LIST_H
#define TESTS_SUPPORT_WIRE_LIST_H

/** The kinds of wire that carry one of these media (DG_PLAN_CARRIES()), `between` them, and " or "
 * in front of the last one. @return a text that lasts until the next call */
const char *list_wires(unsigned media, const char *between);

#endif
