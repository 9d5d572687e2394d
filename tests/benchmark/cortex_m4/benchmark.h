/* benchmark.h - one estimator per image: CANDIDATE chooses it, so that an image holds what that estimator needs alone. */
#ifndef TUMBLE_BENCHMARK_H
#define TUMBLE_BENCHMARK_H

#include "tumble/core.h"

/* What one would write without looking at the structure: twelve unknowns, a dense row for each of the 3 x P means. */
tumble_status_t dense_normal_equations(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                       tumble_coefficients_t *coefficients);
tumble_status_t dense_householder(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                  tumble_coefficients_t *coefficients);

tumble_status_t shared_normal_matrix(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                     tumble_coefficients_t *coefficients);

/* The sample path: what SAMPLES samples cost, and the means of a run of 18 positions. */
#define SAMPLES 512U
void samples_begin(void);
tumble_status_t samples_none(void);
tumble_status_t samples_without_gates(void);
tumble_status_t samples_with_gates(void);
tumble_status_t samples_divide(void);
tumble_status_t samples_in_blocks(void);
tumble_status_t samples_noise(void);

#endif
