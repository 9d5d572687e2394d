/* averaging.h - exact integer averaging of raw samples, position by position, with gates.
 *
 * Integer arithmetic only in the sample path: sums are exact, so a mean is one correctly rounded division of two exact
 * numbers, the same on every target and for every order of the samples. The caller owns the state (one per block of
 * accelerometers) and the constant configuration. Not re-entrant on one state; no other state is touched.
 *
 * Life of a position: begin, add (or accumulate) for every sample, finish. `finish` judges the gates; a position that
 * fails them is left empty and may be begun again. Every sample that a gate refuses or that is missing is counted;
 * one that comes while no position is open, or when it is full, is a mistake of the caller: the status tells, nothing
 * counts it.
 */
#ifndef TUMBLE_CORE_AVERAGING_H
#define TUMBLE_CORE_AVERAGING_H

#include "core/limits.h"
#include "core/schedule.h"
#include "core/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t counts[TUMBLE_CHANNELS];
    uint16_t counter; /* the block's own sample counter; grows by one per sample and wraps */
} tumble_sample_t;

typedef struct {
    int32_t saturation_counts; /* at or beyond +- this a sample is refused; 1 to INT32_MAX */
    uint32_t min_samples;      /* of a finished position; 1 to TUMBLE_MAX_SAMPLES */
    uint16_t max_lost;         /* samples that may be missing from a position */
    uint16_t stuck_run;        /* equal values in a row that call a channel stuck, or all values of a position with fewer
                                * samples (but more than one); at least 2, or 0: gate off */
    float noise_counts;        /* declared standard deviation of one sample, finite; 0: unknown, stillness gate off */
    float stillness_ratio;     /* scatter over declared noise that still counts as still; finite, above 0 */
} tumble_averaging_config_t;

/* Monotonic since init, over all positions; they stop at UINT32_MAX instead of wrapping. */
typedef struct {
    uint32_t saturated;
    uint32_t deviating;
    uint32_t repeated;
    uint32_t reordered;
    uint32_t lost;
} tumble_averaging_counters_t;

/* One finished position. samples == 0: empty. */
typedef struct {
    int64_t sum_counts[TUMBLE_CHANNELS];
    uint32_t samples;
    float scatter_counts[TUMBLE_CHANNELS]; /* standard deviation of one sample, n - 1; 0 for a single one */
} tumble_average_t;

/* The open position. */
typedef struct {
    uint8_t index;
    uint8_t faults; /* bits private to averaging.c */
    uint16_t last_counter;
    uint32_t lost;
    int64_t square_sum[TUMBLE_CHANNELS]; /* of deviations from `first` */
    int32_t first[TUMBLE_CHANNELS];
    int32_t last[TUMBLE_CHANNELS];
    uint16_t run[TUMBLE_CHANNELS]; /* how often `last` has come in a row */
} tumble_open_position_t;

typedef struct {
    tumble_open_position_t open;
    tumble_averaging_counters_t counters;
    tumble_average_t averages[TUMBLE_MAX_POSITIONS];
} tumble_averaging_t;

static_assert(sizeof(tumble_averaging_t) <= 1536, "the averaging state of 36 positions must stay within 1.5 kB");

/* Empty every position and zero the counters. Returns TUMBLE_OK or _ARGUMENT (a configuration out of range). */
tumble_status_t tumble_averaging_init(tumble_averaging_t *averaging, const tumble_averaging_config_t *config);

/* Open the position at `index` of the schedule, forgetting what it held; an open one is abandoned and left empty.
 * Returns TUMBLE_OK or _ARGUMENT (index not below TUMBLE_MAX_POSITIONS). */
tumble_status_t tumble_averaging_begin(tumble_averaging_t *averaging, uint8_t index);

/* Take one sample through the gates. Refused samples are counted and change neither sums nor scatter; missing counter
 * values are counted as lost, and the sample itself is taken. A gap of 32768 or more reads as a step backwards: the
 * caller's timeout must come long before.
 * Returns TUMBLE_OK, _NOT_OPEN, _FULL, _REPEATED, _REORDERED, _SATURATED, _DEVIATION. */
tumble_status_t tumble_averaging_add(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                     const tumble_sample_t *sample);

/* Take one sample without gates, for a caller that has gates of its own: sums and scatter only. Those of `add` that can be
 * switched off are the stuck and the stillness gate (configuration); the others always judge. The caller vouches for an open position that is not full and
 * for deviations within TUMBLE_MAX_DEVIATION_COUNTS. */
void tumble_averaging_accumulate(tumble_averaging_t *averaging, const int32_t counts[TUMBLE_CHANNELS]);

/* Close the open position and judge it. On any refusal the position is left empty.
 * Returns TUMBLE_OK, _NOT_OPEN, and in this order: _SATURATED, _DEVIATION (such a sample was refused: the mean would be
 * biased), _LOST, _TOO_FEW, _STUCK, _NOT_STILL. */
tumble_status_t tumble_averaging_finish(tumble_averaging_t *averaging, const tumble_averaging_config_t *config);

/* Put back a position that `finish` had accepted, as it was kept elsewhere meanwhile; an open one is abandoned and left
 * empty. It must pass the gates that can still be judged: TUMBLE_OK, _ARGUMENT (null, index, a sum that so many samples
 * below saturation cannot have, more than TUMBLE_MAX_SAMPLES, a scatter that is none), _TOO_FEW, _STUCK, _NOT_STILL. On any
 * refusal the position is left empty. */
tumble_status_t tumble_averaging_restore(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                         uint8_t index, const tumble_average_t *average);

/* Samples in the open position so far; 0 when none is open. */
uint32_t tumble_averaging_samples(const tumble_averaging_t *averaging);

/* Mean (counts) of the open position so far and its standard error, for progress and for stopping early.
 * Returns TUMBLE_OK, _ARGUMENT, _NOT_OPEN, or TUMBLE_E_TOO_FEW below two samples (the error is not known yet). */
tumble_status_t tumble_averaging_running(const tumble_averaging_t *averaging, double mean_counts[TUMBLE_CHANNELS],
                                         double standard_error_counts[TUMBLE_CHANNELS]);

/* Mean (counts) of the finished position at `index`, correctly rounded, and its standard error scatter / sqrt(n).
 * `standard_error_counts` may be null. Returns TUMBLE_OK, _ARGUMENT, or _MISSING_POSITION when the position is empty. */
tumble_status_t tumble_averaging_mean(const tumble_averaging_t *averaging, uint8_t index,
                                      double mean_counts[TUMBLE_CHANNELS],
                                      double standard_error_counts[TUMBLE_CHANNELS]);

/* All finished positions as means in volts, ready for an estimator; the others are marked as not measured.
 * `v_per_count` finite and not 0. Returns TUMBLE_OK or _ARGUMENT. */
tumble_status_t tumble_averaging_means(const tumble_averaging_t *averaging, double v_per_count, tumble_means_t *means);

#endif
