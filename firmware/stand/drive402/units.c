#include "stand/drive402/internal.h"

#include "core/arith.h"
#include "core/one_copy.h"

#define TURN_DEG 360.0
#define MAX_WRAPPING_COUNTS 4503599627370496.0 /* 2^52: exact as a double, and far from the end of an int64 */

bool tumble_drive_counts(const tumble_drive_profile_t *profile, double angle_deg, int64_t *counts)
{
    const double exact = (double)profile->sign * angle_deg * profile->counts_per_revolution / TURN_DEG;
    if (!tumble_within(exact, (profile->wrap_counts == 0U) ? (double)INT32_MAX : MAX_WRAPPING_COUNTS)) {
        return false;
    }
    *counts = tumble_nearest(exact);
    return true;
}

uint32_t tumble_drive_way(const tumble_drive_profile_t *profile, double way_deg)
{
    const double exact = (way_deg * profile->counts_per_revolution / TURN_DEG) + 1.0;
    return tumble_within(exact, (double)UINT32_MAX) ? (uint32_t)tumble_whole(exact) : UINT32_MAX;
}

double tumble_drive_angle_deg(const tumble_drive_profile_t *profile, int64_t counts)
{
    return (double)profile->sign * (double)counts * TURN_DEG / profile->counts_per_revolution;
}

/* What is left of `counts`, with its sign, after whole circles: the longest way of doubled circles first. It saves the
 * library's division of 64 bits. */
TUMBLE_ONE_COPY static int64_t rest_of(int64_t counts, int64_t wrap)
{
    int64_t rest = (counts < 0) ? -counts : counts;
    while (rest >= wrap) {
        int64_t way = wrap;
        while ((2 * way) <= rest) {
            way *= 2;
        }
        rest -= way;
    }
    return (counts < 0) ? -rest : rest;
}

int32_t tumble_drive_wrapped(const tumble_drive_profile_t *profile, int64_t counts)
{
    const int64_t wrap = (int64_t)profile->wrap_counts;
    if (wrap == 0) {
        return (int32_t)counts;
    }
    const int64_t rest = rest_of(counts, wrap);
    return (int32_t)((rest < 0) ? (rest + wrap) : rest);
}

int64_t tumble_drive_unwrapped(const tumble_drive_profile_t *profile, int32_t raw, int64_t before)
{
    const int64_t wrap = (int64_t)profile->wrap_counts;
    if (wrap == 0) {
        return raw;
    }
    int64_t change = rest_of((int64_t)raw - before, wrap);
    if (change > (wrap / 2)) {
        change -= wrap;
    } else if (change < -(wrap / 2)) {
        change += wrap;
    } else {
        /* the shorter way already */
    }
    return before + change;
}
