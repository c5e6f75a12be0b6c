/* SPDX-License-Identifier: MIT */
/* As much of ESP-IDF as the example calls. */
#ifndef ESP_TIMER_H
#define ESP_TIMER_H

#include <stdint.h>

int64_t esp_timer_get_time(void);
void app_main(void);

#endif
