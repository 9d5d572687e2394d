#include "bit_timing.h"

#include <stdbool.h>

#define MAX_PRESCALER 256U
#define MIN_QUANTA 8U /* as CiA 301 has it: fewer leave no room to resynchronise */
#define MAX_QUANTA 25U
#define MAX_SEGMENT1 16U
#define MAX_SEGMENT2 8U
#define MAX_JUMP 4U
#define MAX_RATE 1000000U
#define PPM 1000000U

static uint64_t distance(uint64_t a, uint64_t b)
{
    return (a > b) ? (a - b) : (b - a);
}

/* The segments for so many quanta a bit; returns how far the sample point is off, in thousandths of a bit. */
static uint64_t divide(uint32_t quanta, zcu102_bit_timing_t *timing)
{
    uint64_t least = UINT64_MAX;
    for (uint32_t segment2 = 1; segment2 <= MAX_SEGMENT2; segment2++) {
        const uint32_t segment1 = quanta - 1U - segment2; /* at least 8 quanta: not below 0 ... */
        const bool fits = (quanta > (segment2 + 1U)) && (segment1 <= MAX_SEGMENT1);
        const uint64_t off =
            distance((uint64_t)(quanta - segment2) * 1000U, (uint64_t)quanta * ZCU102_SAMPLE_POINT_PERMILLE);
        if (fits && (off < least)) {
            least = off;
            timing->segment1 = segment1;
            timing->segment2 = segment2;
        }
    }
    timing->jump = (timing->segment2 < MAX_JUMP) ? timing->segment2 : MAX_JUMP;
    return least / quanta;
}

/* A penalty that puts the error of the rate before the sample point. */
static uint64_t judge(uint32_t clock_hz, uint32_t bits_per_second, uint32_t quanta, zcu102_bit_timing_t *timing)
{
    const uint64_t wanted = (uint64_t)bits_per_second * quanta * timing->prescaler;
    const uint64_t error_ppm = (distance(clock_hz, wanted) * PPM) / clock_hz;
    return (error_ppm * 1000U) + divide(quanta, timing);
}

tumble_status_t zcu102_bit_timing(uint32_t clock_hz, uint32_t bits_per_second, zcu102_bit_timing_t *timing)
{
    uint64_t least = UINT64_MAX;
    zcu102_bit_timing_t best = {0};
    if ((clock_hz == 0U) || (bits_per_second == 0U) || (bits_per_second > MAX_RATE)) {
        return TUMBLE_E_ARGUMENT;
    }
    for (uint32_t quanta = MAX_QUANTA; quanta >= MIN_QUANTA; quanta--) {
        const uint64_t per_quantum = (uint64_t)bits_per_second * quanta;
        zcu102_bit_timing_t tried = {.prescaler = (uint32_t)((clock_hz + (per_quantum / 2U)) / per_quantum)};
        if ((tried.prescaler < 1U) || (tried.prescaler > MAX_PRESCALER)) {
            continue;
        }
        const uint64_t penalty = judge(clock_hz, bits_per_second, quanta, &tried);
        if (penalty < least) {
            least = penalty;
            best = tried;
        }
    }
    if (least >= ((uint64_t)(ZCU102_MOST_ERROR_PPM + 1U) * 1000U)) {
        return TUMBLE_E_ARGUMENT;
    }
    *timing = best;
    return TUMBLE_OK;
}
