/* counters.h - what the gateway counts; the list is that of the register map. */
#ifndef TUMBLE_GATEWAY_COUNTERS_H
#define TUMBLE_GATEWAY_COUNTERS_H

#include "canopen/link.h"
#include "register_map.h"

typedef struct {
    uint32_t count[GATEWAY_COUNTERS];
} gateway_counters_t;

/* `which`: GATEWAY_COUNT_... Stops at its largest value. */
static inline void gateway_count(gateway_counters_t *counters, int which)
{
    tumble_count(&counters->count[which]);
}

#endif
