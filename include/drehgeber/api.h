/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What belongs to the interface of the library, and what all headers may use. The library is built
 * with hidden visibility: a function or table is exported when its header says DG_API, and nothing
 * else is.
 */
#ifndef DREHGEBER_API_H
#define DREHGEBER_API_H

/** Before each declaration of the interface. */
#if defined(__GNUC__)
#define DG_API __attribute__((visibility("default")))
#else
#define DG_API
#endif

/** Elements of an array. */
#define DG_COUNT(array) (sizeof(array) / sizeof((array)[0]))

#endif
