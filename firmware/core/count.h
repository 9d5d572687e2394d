/* count.h - counters that stop at their end instead of wrapping (private to the firmware). */
#ifndef TUMBLE_CORE_COUNT_H
#define TUMBLE_CORE_COUNT_H

#include <stdint.h>

void tumble_count(uint32_t *counter);
void tumble_count_u16(uint16_t *counter);
void tumble_add_up(uint32_t *counter, uint32_t by);

/* The same where it is called: for the way of every sample, which would be a sixth longer if it led through calls. */
static inline void tumble_add_up_here(uint32_t *counter, uint32_t by)
{
    *counter = (by <= (UINT32_MAX - *counter)) ? (*counter + by) : UINT32_MAX;
}

#endif
