/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The version of these headers, for the preprocessor and for whoever builds without CMake, which
 * reads it from here. That of the library linked against is dg_version(). It follows semver.
 */
#ifndef DREHGEBER_VERSION_H
#define DREHGEBER_VERSION_H

/** MAJOR changes when something goes that was promised, MINOR when something is added. */
#define DG_VERSION_MAJOR 1
#define DG_VERSION_MINOR 0
#define DG_VERSION_PATCH 0

/** "major.minor.patch" */
#define DG_VERSION "1.0.0"

/** When this version was released: "month-day-year", as EDS files have it. */
#define DG_RELEASED "11-29-2026"

#endif
