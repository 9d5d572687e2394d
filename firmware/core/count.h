/* count.h - counters that stop at their end instead of wrapping (private to the firmware). */
#ifndef TUMBLE_CORE_COUNT_H
#define TUMBLE_CORE_COUNT_H

#include <stdint.h>

void tumble_count(uint32_t *counter);
void tumble_count_u16(uint16_t *counter);

#endif
