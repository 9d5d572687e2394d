/* averaging_state.h - what the two halves of averaging and the procedure share (private to the firmware). */
#ifndef TUMBLE_CORE_AVERAGING_STATE_H
#define TUMBLE_CORE_AVERAGING_STATE_H

#include "tumble/core.h"

#define NONE_OPEN UINT8_MAX

static inline bool tumble_averaging_is_open(const tumble_averaging_t *averaging)
{
    return averaging->open.index != NONE_OPEN;
}

static inline bool tumble_averaging_has_mean(const tumble_averaging_t *averaging, uint8_t index)
{
    return (averaging->averages[index].samples != 0U) && (averaging->open.index != index);
}

static inline tumble_average_t *tumble_averaging_open_average(tumble_averaging_t *averaging)
{
    return &averaging->averages[averaging->open.index];
}

/* The mean of three channels, correctly rounded in counts, times `unit`. It has samples. */
void tumble_average_mean(const tumble_average_t *average, double mean[TUMBLE_CHANNELS], double unit);

#endif
