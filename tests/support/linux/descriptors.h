/* SPDX-License-Identifier: MIT */
/** What a program has open, from its first test to its last: nothing of a port may be left. */
#ifndef SUPPORT_DESCRIPTORS_H
#define SUPPORT_DESCRIPTORS_H

/** How many descriptors this process has open. */
unsigned descriptors_open(void);

/** Setup of a group of tests. @return 0 */
int descriptors_note(void **state);

/** The last test of that group: as many as then. */
void no_descriptor_is_left(void **state);

#endif
