#include "core/count.h"

void tumble_count(uint32_t *counter)
{
    if (*counter != UINT32_MAX) {
        ++*counter;
    }
}

void tumble_add_up(uint32_t *counter, uint32_t by)
{
    tumble_add_up_here(counter, by);
}

void tumble_count_u16(uint16_t *counter)
{
    if (*counter != UINT16_MAX) {
        ++*counter;
    }
}
