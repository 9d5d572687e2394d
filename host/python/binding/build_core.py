"""Write the C source of `_tumble_core`, the extension module through which Python calls the firmware core.

    python build_core.py OUTPUT.c

cffi's API mode: the declarations below are compared with the real headers by the C compiler, so a change of a
structure or a signature breaks the build instead of a result. Where a structure ends in `...`, the compiler fills in
what Python has no use for. The module uses the limited API, so one build serves every Python from 3.10 on.
"""

import sys
from pathlib import Path

import cffi

HEADERS = """
#include "tumble/core.h"
"""

LIMITS = """
#define TUMBLE_COEFFICIENTS ...
#define TUMBLE_MAX_POSITIONS ...
#define TUMBLE_MAX_MOUNTINGS ...
#define TUMBLE_MAX_YAWS ...
static const double TUMBLE_MIN_SENSITIVITY_G;
static const double TUMBLE_MAX_MEAN_V;
static const double TUMBLE_MIN_ROW_RATIO;
static const double TUMBLE_MAX_STAND_ERROR_RAD;
static const int64_t TUMBLE_MAX_SAMPLES;
static const int64_t TUMBLE_MAX_DEVIATION_COUNTS;
"""

STATUS = """
typedef enum {
    TUMBLE_OK, TUMBLE_E_MISSING_POSITION, TUMBLE_E_TOO_FEW, TUMBLE_E_STAND_ERROR, TUMBLE_STATUS_COUNT, ...
} tumble_status_t;
const char *tumble_status_name(tumble_status_t status);
const char *tumble_status_sentence(tumble_status_t status);
"""

SCHEDULE = """
typedef struct { double deg; double sine; double cosine; } tumble_angle_t;
typedef struct { uint8_t number; double matrix[3][3]; tumble_angle_t tilt; uint8_t bolting; } tumble_mounting_t;
typedef enum { TUMBLE_USE_FIT, TUMBLE_USE_CHECK } tumble_use_t;
typedef struct { uint8_t mounting; uint8_t number; tumble_use_t use; tumble_angle_t angle; } tumble_position_t;
typedef struct {
    const tumble_mounting_t *mountings;
    const tumble_position_t *positions;
    uint8_t mounting_count;
    uint8_t position_count;
} tumble_schedule_t;
typedef struct { double u_v[...][3]; bool measured[...]; } tumble_means_t;
typedef struct { uint8_t circles[3]; ...; } tumble_harmonic_map_t;

extern const tumble_schedule_t tumble_schedule_paper;
extern const tumble_schedule_t tumble_schedule_three_mountings;
extern const tumble_schedule_t tumble_schedule_diagonal;
extern const tumble_schedule_t tumble_schedule_diagonal_closed;
extern const tumble_schedule_t tumble_schedule_six_faces;
extern const tumble_schedule_t tumble_schedule_inclined;
extern const tumble_schedule_t tumble_schedule_inclined_closed;
tumble_status_t tumble_schedule_validate(const tumble_schedule_t *, uint8_t *where);
void tumble_schedule_attitude(const tumble_schedule_t *, uint8_t index, double *a_g);
tumble_status_t tumble_schedule_identify(const tumble_schedule_t *, const bool *measured, uint8_t *unidentified);
tumble_status_t tumble_schedule_harmonic(const tumble_schedule_t *, const bool *measured, tumble_harmonic_map_t *,
                                         uint64_t *missing);
typedef struct { uint8_t count; ...; } tumble_inclined_map_t;
tumble_status_t tumble_schedule_inclinations(const tumble_schedule_t *, const bool *measured, tumble_inclined_map_t *,
                                             uint64_t *missing);
"""

AVERAGING = """
typedef struct { int32_t counts[3]; uint16_t counter; uint8_t status; } tumble_sample_t;
typedef struct {
    int32_t saturation_counts;
    uint32_t min_samples;
    uint16_t max_lost;
    uint16_t stuck_run;
    float noise_counts;
    float stillness_ratio;
} tumble_averaging_config_t;
typedef struct {
    uint32_t saturated;
    uint32_t deviating;
    uint32_t repeated;
    uint32_t reordered;
    uint32_t lost;
} tumble_averaging_counters_t;
typedef struct { int64_t sum_counts[3]; uint32_t samples; float scatter_counts[3]; } tumble_average_t;
typedef struct { tumble_average_t averages[...]; tumble_averaging_counters_t counters; ...; } tumble_averaging_t;

tumble_status_t tumble_averaging_init(tumble_averaging_t *, const tumble_averaging_config_t *);
tumble_status_t tumble_averaging_begin(tumble_averaging_t *, uint8_t index);
tumble_status_t tumble_averaging_add(tumble_averaging_t *, const tumble_averaging_config_t *, const tumble_sample_t *);
tumble_status_t tumble_averaging_finish(tumble_averaging_t *, const tumble_averaging_config_t *);
uint32_t tumble_averaging_samples(const tumble_averaging_t *);
tumble_status_t tumble_averaging_running(const tumble_averaging_t *, double *mean_counts,
                                         double *standard_error_counts);
tumble_status_t tumble_averaging_mean(const tumble_averaging_t *, uint8_t index, double *mean_counts,
                                      double *standard_error_counts);
tumble_status_t tumble_averaging_means(const tumble_averaging_t *, double v_per_count, tumble_means_t *);
"""

ESTIMATOR = """
typedef struct { double k_v_per_g[3][3]; double u0_v[3]; } tumble_coefficients_t;
typedef struct { uint64_t missing; uint8_t unidentified; } tumble_refusal_t;
typedef struct { const double *gains; uint8_t fit_positions; double inclination_rad; } tumble_gain_table_t;
typedef struct { double sine[...]; double cosine[...]; double turn_sine[...]; double turn_cosine[...]; }
    tumble_inclinations_t;
tumble_status_t tumble_inclined_weighted(const tumble_schedule_t *, const tumble_means_t *, const double *weights,
                                         tumble_coefficients_t *, tumble_inclinations_t *, tumble_refusal_t *);

tumble_status_t tumble_estimate_gains(const tumble_gain_table_t *, const tumble_schedule_t *, const tumble_means_t *,
                                      tumble_coefficients_t *);
"""

CALIBRATION = """
typedef struct { double k_inverse_g_per_v[3][3]; double u0_v[3]; } tumble_calibration_t;
typedef struct {
    double scale_v_per_g[3];
    double cosine_xy;
    double cosine_xz;
    double cosine_yz;
    double bias_g[3];
} tumble_intrinsic_t;

tumble_status_t tumble_calibration_invert(const tumble_coefficients_t *, tumble_calibration_t *);
void tumble_calibration_apply(const tumble_calibration_t *, const double *u_v, double *a_g);
void tumble_calibration_apply_counts(const tumble_calibration_t *, double v_per_count, const int32_t *counts,
                                     double *a_g);
tumble_status_t tumble_calibration_intrinsic(const tumble_coefficients_t *, tumble_intrinsic_t *);
"""

VERIFICATION = """
typedef struct {
    double delta_g_g[...];
    double max_abs_fit_g;
    double max_abs_check_g;
    uint8_t fit_positions;
    uint8_t check_positions;
    bool pass;
} tumble_gravity_check_t;

tumble_status_t tumble_gravity_check(const tumble_schedule_t *, const tumble_means_t *, const tumble_calibration_t *,
                                     double limit_g, tumble_gravity_check_t *);
tumble_status_t tumble_closure(const tumble_schedule_t *, const tumble_means_t *, uint8_t mounting,
                               double *difference_v);
void tumble_residual(const tumble_schedule_t *, const tumble_means_t *, const tumble_coefficients_t *, uint8_t index,
                     double *residual_v);
tumble_status_t tumble_residual_rms(const tumble_schedule_t *, const tumble_means_t *, const tumble_coefficients_t *,
                                    double *rms_v);
"""


OPTIMAL = """
typedef struct {
    uint8_t inclinations;
    uint8_t fit_positions;
    uint8_t mountings;
    uint8_t yaws;
    uint8_t seats;
    uint8_t waves;
    uint8_t drifts;
    uint32_t block_crc;
    double k_v_per_g[3][3];
    double sigma_rad[4];
    double sigma_mean_v;
    double u_k_v_per_g[3][3];
    double u_u0_v[3];
    ...;
} tumble_gain_record_t;
typedef struct { double alpha1_rad; double alpha2_rad; double alpha3_rad[...]; ...; } tumble_stand_errors_t;
typedef struct { tumble_stand_errors_t stand; ...; } tumble_optimal_t;

tumble_status_t tumble_gain_record_open(const void *memory, size_t size, const tumble_schedule_t *,
                                        const tumble_gain_record_t **);
const double *tumble_gain_record_gains(const tumble_gain_record_t *);
const double *tumble_gain_record_stand_gains(const tumble_gain_record_t *);
uint32_t tumble_gain_record_schedule_crc(const tumble_schedule_t *);
tumble_status_t tumble_estimate_optimal(const tumble_gain_record_t *, const tumble_schedule_t *,
                                        const tumble_means_t *, tumble_coefficients_t *, tumble_optimal_t *);
"""

STAND_SEEN = """
typedef struct { double value; double u; bool known; } tumble_seen_t;
typedef struct {
    tumble_seen_t alpha1;
    tumble_seen_t alpha2_plus_alpha3;
    tumble_seen_t alpha3_difference;
} tumble_seen_angles_t;
typedef struct { double angle_rad; double mean_variance_v2[...]; } tumble_random_errors_t;
typedef struct { ...; } tumble_fit_work_t;

tumble_seen_t tumble_seen_noise(const uint32_t *samples, const double (*scatter)[3], uint8_t positions);
tumble_status_t tumble_seen_angles(const tumble_schedule_t *, const tumble_means_t *, const tumble_calibration_t *,
                                   const tumble_random_errors_t *, tumble_seen_angles_t *);
tumble_status_t tumble_seen_fit(const tumble_schedule_t *, const tumble_means_t *, const tumble_coefficients_t *,
                                const tumble_random_errors_t *, tumble_fit_work_t *, tumble_seen_angles_t *);
tumble_status_t tumble_seen_angle_error(const tumble_schedule_t *, const tumble_means_t *,
                                        const tumble_coefficients_t *, const tumble_random_errors_t *,
                                        tumble_fit_work_t *, tumble_seen_t *alpha4, double *freedom);
tumble_status_t tumble_seen_angle_chi_squared(const tumble_schedule_t *, const tumble_means_t *,
                                              const tumble_coefficients_t *, const tumble_random_errors_t *,
                                              tumble_fit_work_t *, double *chi_squared, uint8_t *freedom);
"""

UNCERTAINTY = """
typedef struct {
    double axis_tilt_rad;
    double level_rad;
    double remount_rad;
    double angle_rad;
    double noise_v;
    double least_noise_v;
    uint32_t samples;
    bool common_yaw;
    double seat_rad;
    double platform_rad;
    double encoder_rad;
    double drift_v;
    double channel_noise_v[3];
    double channel_drift_v[3];
} tumble_stand_record_t;
typedef struct {
    double noise_v[3];
    double declared_v;
    double variance_v2[3];
    double line_v2[3];
    double lengths_per_sample;
    double rounding_v2;
    uint8_t above;
    uint8_t undithered;
} tumble_noise_t;
double tumble_noise_excess(const tumble_noise_t *, int channel, uint32_t samples, double declared_v2);
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_stand_record_t *stand;
    const tumble_coefficients_t *coefficients;
    const bool *measured;
    const uint32_t *samples;
    uint16_t only;
    const double (*excess_variance_v2)[3];
    const tumble_noise_t *noise;
    const double *attitude;
    double *norm_g;
    const tumble_inclinations_t *inclinations;
    const double *weights;
} tumble_judged_run_t;
typedef struct {
    double best[3];
    double worst_g;
    uint8_t place;
    uint8_t rounds;
    uint8_t halvings;
    bool rises;
} tumble_worst_norm_t;
void tumble_worst_norm_begin(tumble_worst_norm_t *);
void tumble_worst_norm_attitude(const tumble_worst_norm_t *, double[3]);
bool tumble_worst_norm_next(tumble_worst_norm_t *, double);
typedef struct {
    int64_t square_sum[2][3];
    int64_t open_square_sum[2][3];
    uint32_t difference[2][3];
    uint32_t pairs[2];
    uint32_t samples;
    uint32_t block_samples;
} tumble_blocks_t;
tumble_status_t tumble_blocks_init(tumble_blocks_t *, uint32_t samples);
void tumble_blocks_begin(tumble_blocks_t *);
void tumble_blocks_add(tumble_blocks_t *, const int32_t *counts);
void tumble_blocks_finish(tumble_blocks_t *);
tumble_status_t tumble_blocks_noise(const tumble_blocks_t *, const tumble_averaging_t *,
                                    const tumble_stand_record_t *, double v_per_count, tumble_noise_t *);
typedef struct { double k_v_per_g[3][3]; double u0_v[3]; } tumble_uncertainty_t;

tumble_status_t tumble_uncertainty_gains(const tumble_gain_table_t *, const tumble_judged_run_t *,
                                         tumble_uncertainty_t *);
typedef struct {
    double deg[...];
    double u_deg[...];
    double level_rad;
    double u_level_rad;
    uint8_t count;
    bool has_level;
} tumble_shown_inclinations_t;
tumble_status_t tumble_uncertainty_inclinations(const tumble_judged_run_t *, tumble_shown_inclinations_t *,
                                                tumble_refusal_t *);
"""

WHOLE_MODEL = """
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_means_t *means;
    const tumble_stand_record_t *stand;
    const double *mean_variance_v2;
    const double (*channel_variance_v2)[3];
} tumble_whole_run_t;
typedef struct {
    double chi_squared;
    double limit;
    double misfit;
    uint8_t freedom;
    bool misfits;
    bool known;
    ...;
} tumble_whole_work_t;
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_averaging_t *averaging;
    const tumble_coefficients_t *coefficients;
    const tumble_stand_record_t *stand;
    double v_per_count;
} tumble_misfit_run_t;

tumble_status_t tumble_whole_chi_squared(const tumble_whole_run_t *, tumble_whole_work_t *, double *chi_squared,
                                         uint8_t *freedom);
void tumble_whole_begin(tumble_whole_work_t *);
bool tumble_whole_step(tumble_whole_work_t *, const tumble_misfit_run_t *);
"""

# The table of estimators; without functions of their own, those that need a gain record.
ESTIMATORS = """
typedef struct {
    const char *name;
    tumble_status_t (*estimate)(const tumble_schedule_t *, const tumble_means_t *, tumble_coefficients_t *,
                                tumble_refusal_t *);
    tumble_status_t (*uncertainty)(const tumble_judged_run_t *, tumble_uncertainty_t *, tumble_refusal_t *);
} estimator_row_t;
static const estimator_row_t estimator_rows[...];
#define TUMBLE_ESTIMATE_COUNT ...
"""

# Many runs in one call: a call from Python costs more than the estimate.
BATCH = """
typedef tumble_status_t batch_estimator_t(const tumble_schedule_t *, const tumble_means_t *, tumble_coefficients_t *,
                                          tumble_refusal_t *);
tumble_status_t batch_estimate(batch_estimator_t *, const tumble_schedule_t *, size_t runs, const double *means_v,
                               double *coefficients, size_t *where);
tumble_status_t batch_inclined(const tumble_schedule_t *, size_t runs, const double *means_v, const double *weights,
                               double *coefficients, double *seen, size_t *where);
tumble_status_t batch_optimal(const tumble_gain_record_t *, const tumble_schedule_t *, size_t runs,
                              const double *means_v, double *coefficients, double *stand, size_t *where);
"""

# Rows of a run file: a line by Python costs fifty times as much.
ROWS = """
typedef struct {
    char delimiter;
    char decimal;
    uint32_t columns;
    uint32_t width;
    const int8_t *role;
    const int32_t *position;
    double coldest;
    double hottest;
} rows_layout_t;
typedef struct {
    size_t bytes;
    size_t rows;
    size_t blanks;
    bool marked;
    double low_c;
    double high_c;
} rows_found_t;
void rows_parse(const rows_layout_t *, const char *text, size_t size, double line, uint16_t *index, double *rows,
                rows_found_t *);
void rows_scatter(const double (*rows)[4], size_t number, double *scatter);
void rows_squares(const double (*rows)[4], size_t number, double (*sums)[3], double (*squares)[3]);
void rows_sort(uint64_t *values, uint64_t *scratch, size_t number);
"""


def main(output: str) -> None:
    """Write the extension's C source to the file `output`."""
    ffi = cffi.FFI()
    ffi.cdef(
        LIMITS
        + STATUS
        + SCHEDULE
        + AVERAGING
        + ESTIMATOR
        + CALIBRATION
        + VERIFICATION
        + OPTIMAL
        + STAND_SEEN
        + UNCERTAINTY
        + WHOLE_MODEL
        + ESTIMATORS
        + BATCH
        + ROWS
    )
    sources = [Path(__file__).with_name(name).read_text(encoding="utf-8") for name in ("batch.c", "rows.c")]
    ffi.set_source("_tumble_core", "".join([HEADERS, *sources]))
    ffi.emit_c_code(output)


if __name__ == "__main__":
    main(sys.argv[1])
