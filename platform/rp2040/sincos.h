/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The process channel of the S36 RS485 (4.1.3) as two duty cycles of a PWM of 122 kHz: pin 10 is
 * sine, pin 11 cosine, for a low-pass filter and a driver each. Half a period is 0; the nominal
 * amplitude, 250 mV at each of the encoder's four outputs, is 40 % of a period to either side.
 */
#ifndef SINCOS_H
#define SINCOS_H

#include "drehgeber/hiperface.h"

/** Pins and PWM, once. */
void sincos_start(void);
/** Follow the shaft. @return when to call again: in 50 us while it turns, in 1 ms while it rests */
dg_ns sincos_follow(const struct dg_hf *device, dg_ns now);

#endif
