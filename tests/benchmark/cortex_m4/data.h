/* data.h - what the estimators get: a run, its stand, and the gains for that. cortex_m4.py writes data.c. */
#ifndef TUMBLE_BENCHMARK_DATA_H
#define TUMBLE_BENCHMARK_DATA_H

#include "tumble/core.h"

extern const tumble_means_t benchmark_means;
extern const tumble_means_t benchmark_three_mountings;
extern const tumble_means_t benchmark_diagonal;
extern const tumble_means_t benchmark_inclined;
extern const tumble_gain_record_t *const benchmark_record;
extern const tumble_gain_table_t benchmark_table;
extern const tumble_stand_record_t benchmark_stand;
extern const tumble_coefficients_t benchmark_coefficients;

#endif
