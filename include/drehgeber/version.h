/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The version of these headers, for the preprocessor and for whoever builds without CMake, which
 * reads it from here. That of the library linked against is dg_version(). It follows semver.
 */
#ifndef DREHGEBER_VERSION_H
#define DREHGEBER_VERSION_H

/** While MAJOR is 0, MINOR changes when an interface does. */
#define DG_VERSION_MAJOR 0
#define DG_VERSION_MINOR 3
#define DG_VERSION_PATCH 0

/** "major.minor.patch" */
#define DG_VERSION "0.3.0"

/** When this version was released: "month-day-year", as EDS files have it. */
#define DG_RELEASED "11-23-2026"

#endif
