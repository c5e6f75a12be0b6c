/* SPDX-License-Identifier: MIT */
/* As much of Arduino as the example calls. */
#ifndef ARDUINO_H
#define ARDUINO_H

#include <stddef.h>
#include <stdint.h>

#define SERIAL_8E1 0x26

struct HardwareSerial {
    void begin(unsigned long baud, uint16_t setting);
    int available();
    int read();
    size_t write(const uint8_t *bytes, size_t n);
};
extern HardwareSerial Serial1;
extern "C" unsigned long micros(void);
void setup();
void loop();

#endif
