#include "tumble/core.h"

#include "core/arith.h"
#include "core/course.h"
#include "core/means.h"
#include "core/turn.h"
#include "core/vector.h"

#include <stdbool.h>
#include <stddef.h>

#define PASSES 3          /* the gains, then twice with what is not linear taken out of the means */
#define PASSES_INCLINED 5 /* inclinations may be off by more than any other error */

/* Rows of a record: the coefficients, alpha1, alpha2, the yaws, theta_h of each seat, theta_n of each, the numbers of the
 * encoder, drifts, beta of each inclination, tau of each. */
#define ALPHA1 TUMBLE_COEFFICIENTS
#define ALPHA2 (ALPHA1 + 1)
#define ALPHA3 (ALPHA2 + 1)
#define MAX_ROWS (ALPHA3 + (5 * TUMBLE_MAX_YAWS) + TUMBLE_WAVES + TUMBLE_CHANNELS)

typedef struct {
    const tumble_gain_record_t *record;
    const tumble_schedule_t *schedule;
    tumble_coefficients_t *block; /* of the pass before, as is the stand */
    tumble_stand_errors_t *stand;
    /* What of each fit position's angle error the pass before found to be curvature. About the square of the largest
     * error, so that single precision costs less than 1e-13 of K at 1 mrad; 7e-12 was seen at 29 mrad, and 1e-10 where
     * the positions hardly tell a coefficient. */
    float *curvature_rad;
    double sum[MAX_ROWS]; /* of this pass */
} work_t;

/* Where one fit position is. */
typedef struct {
    const tumble_mounting_t *mounting;
    const tumble_angle_t *angle; /* phi */
    double tilt_rad;             /* alpha1 and beta */
    double yaw_rad;              /* alpha3 */
    double lean_rad;             /* theta_h */
    double turn_rad;             /* alpha2, theta_n, tau, and the encoder's */
} pose_t;

static pose_t pose_of(const work_t *work, uint8_t p)
{
    const tumble_mounting_t *mounting = tumble_schedule_mounting_of(work->schedule, p);
    const tumble_stand_errors_t *stand = work->stand;
    const ptrdiff_t m = mounting - work->schedule->mountings;
    const tumble_angle_t *angle = &work->schedule->positions[p].angle;
    const double encoder_rad = tumble_course_angle_error(angle, stand->encoder_rad);
    return (pose_t){.mounting = mounting,
                    .angle = angle,
                    .tilt_rad = stand->alpha1_rad + stand->beta_rad[m],
                    .yaw_rad = stand->alpha3_rad[m],
                    .lean_rad = stand->theta_h_rad[m],
                    .turn_rad = stand->alpha2_rad + stand->theta_n_rad[m] + encoder_rad + stand->tau_rad[m]};
}

/* out += K M f: what a force f (g) of the table frame adds to the outputs (V). */
static void add_outputs(const double k[3][3], const pose_t *pose, const double f_g[3], double out_v[3])
{
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        double a_g = 0.0;
        for (int n = 0; n < TUMBLE_CHANNELS; n++) {
            a_g += pose->mounting->matrix[j][n] * f_g[n];
        }
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            out_v[i] += k[i][j] * a_g;
        }
    }
}

/* The force on an ideal stand, (h, n, v). */
static void ideal_force(const pose_t *at, double f_g[3])
{
    f_g[0] = at->mounting->tilt.cosine * at->angle->sine;
    f_g[1] = at->mounting->tilt.sine;
    f_g[2] = at->mounting->tilt.cosine * at->angle->cosine;
}

/* Its derivative by the table angle, (v, 0, -h). */
static void turning_force(const pose_t *at, double f_g[3])
{
    f_g[0] = at->mounting->tilt.cosine * at->angle->cosine;
    f_g[1] = 0.0;
    f_g[2] = -at->mounting->tilt.cosine * at->angle->sine;
}

/* From the ideal force to its linear change by what the pose has. */
static void linear_change(const pose_t *at, double f_g[3])
{
    const double h = f_g[0];
    const double n = f_g[1];
    const double v = f_g[2];
    const double tilt = at->mounting->tilt.sine * at->tilt_rad;
    f_g[0] = (v * at->turn_rad) - (tilt * at->angle->sine) + (n * at->yaw_rad);
    f_g[1] = (at->mounting->tilt.cosine * at->tilt_rad) - (h * at->yaw_rad) + (v * at->lean_rad);
    f_g[2] = -((h * at->turn_rad) + (tilt * at->angle->cosine) + (n * at->lean_rad));
}

static bool is_small(double angle_rad)
{
    return tumble_within(angle_rad, TUMBLE_MAX_STAND_ERROR_RAD);
}

/* The force on the stand as it is, turned once by all that adds to the tilt, once by all that adds to the table angle,
 * once by theta_h, once by alpha3. False when one of them is not small. */
static bool exact_force(const pose_t *at, double delta, double f_g[3])
{
    double sine = at->angle->sine;
    f_g[0] = at->mounting->tilt.cosine;
    f_g[1] = at->mounting->tilt.sine;
    f_g[2] = at->angle->cosine;
    tumble_turn(at->tilt_rad, &f_g[1], &f_g[0]);
    tumble_turn(at->turn_rad + delta, &sine, &f_g[2]);
    f_g[2] *= f_g[0];
    f_g[0] *= sine;
    tumble_turn(at->lean_rad, &f_g[1], &f_g[2]); /* n' = n cos + v sin, v' = v cos - n sin */
    tumble_turn(at->yaw_rad, &f_g[0], &f_g[1]);  /* h' = h cos + n sin, n' = n cos - h sin */
    return is_small(at->tilt_rad) && is_small(at->turn_rad + delta) && is_small(at->lean_rad) && is_small(at->yaw_rad);
}

/* The best estimate of an error of the table angle, from what its effect d has in common with what is left of the means:
 * sigma4^2 / (sigma^2 + sigma4^2 w.d) is this, to be multiplied by w; w_i is d_i times the weight of the channel. */
static double angle_gain(const tumble_gain_record_t *record, const double by_angle_v[3], double weighted_v[3])
{
    const double *weights = tumble_gain_record_weights(record);
    const double variance = record->sigma_rad[3] * record->sigma_rad[3];
    const double noise = record->sigma_mean_v * record->sigma_mean_v;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        weighted_v[i] = (weights != NULL) ? (weights[i] * by_angle_v[i]) : by_angle_v[i];
    }
    return variance / (noise + (variance * tumble_dot(weighted_v, by_angle_v)));
}

/* Take out of the means of one position, the fit position number `fit` from 0, what the exact outputs, at the present
 * estimate, have beyond the linear ones. */
static bool subtract_curvature(const work_t *work, uint8_t p, size_t fit, double u_v[3])
{
    const pose_t pose = pose_of(work, p);
    const double course = tumble_course_of((uint8_t)fit, work->record->fit_positions);
    float *const curvature_rad = &work->curvature_rad[fit];
    double f_g[3];
    double by_angle[3] = {0.0, 0.0, 0.0};
    double beyond[3] = {0.0, 0.0, 0.0}; /* first the linear outputs, but for U0 and drift, which are in both */
    turning_force(&pose, f_g);
    add_outputs(work->record->k_v_per_g, &pose, f_g, by_angle);
    ideal_force(&pose, f_g);
    add_outputs(((const tumble_coefficients_t *)work->block)->k_v_per_g, &pose, f_g, beyond);
    linear_change(&pose, f_g);
    add_outputs(work->record->k_v_per_g, &pose, f_g, beyond);
    double weighted[3];
    const double gain = angle_gain(work->record, by_angle, weighted);
    double delta = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        delta += weighted[i] * (u_v[i] - work->block->u0_v[i] - (course * work->stand->drift_v[i]) - beyond[i]);
    }
    delta = (gain * delta) - (double)*curvature_rad;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        beyond[i] = -(beyond[i] + (by_angle[i] * delta));
    }
    const bool small = exact_force(&pose, delta, f_g);
    add_outputs(((const tumble_coefficients_t *)work->block)->k_v_per_g, &pose, f_g, beyond);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        u_v[i] -= beyond[i];
    }
    const double curvature = gain * tumble_dot(weighted, beyond);
    const bool fits = is_small(curvature); /* else a float may not hold it */
    *curvature_rad = fits ? tumble_to_float(curvature) : 0.0F;
    return small && fits;
}

static int rows_of(const tumble_gain_record_t *record)
{
    return ALPHA3 + (int)record->yaws + (2 * (int)record->seats) + (int)record->waves + (int)record->drifts +
           (2 * (int)record->inclinations);
}

/* What the means of one position add to the unknowns; `column`: its first one in the record. */
static void apply_gains(work_t *work, size_t column, const double u_v[3])
{
    const double *gains = tumble_gain_record_gains(work->record);
    const size_t columns = (size_t)work->record->fit_positions * TUMBLE_CHANNELS;
    for (size_t row = 0; row < (size_t)rows_of(work->record); row++) {
        work->sum[row] += tumble_dot(&gains[(row * columns) + column], u_v);
    }
}

/* The sums, and a yaw that the mountings share, become the estimate. False when one is not a number. */
static bool take_over(const work_t *work)
{
    bool finite = true;
    for (int i = 0; i < rows_of(work->record); i++) {
        finite = finite && tumble_is_finite(work->sum[i]);
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            work->block->k_v_per_g[i][j] = work->sum[(TUMBLE_CHANNELS * i) + j];
        }
        work->block->u0_v[i] = work->sum[(TUMBLE_CHANNELS * TUMBLE_CHANNELS) + i];
    }
    work->stand->alpha1_rad = work->sum[ALPHA1];
    work->stand->alpha2_rad = work->sum[ALPHA2];
    for (int m = 0; m < (int)work->record->mountings; m++) {
        work->stand->alpha3_rad[m] = work->sum[ALPHA3 + ((work->record->yaws == 1U) ? 0 : m)];
    }
    const double *const seats = &work->sum[ALPHA3 + (int)work->record->yaws];
    for (int m = 0; m < (int)work->record->seats; m++) {
        work->stand->theta_h_rad[m] = seats[m];
        work->stand->theta_n_rad[m] = seats[(int)work->record->seats + m];
    }
    const double *const waves = &seats[2U * (size_t)work->record->seats];
    for (int n = 0; n < (int)work->record->waves; n++) {
        work->stand->encoder_rad[n] = waves[n];
    }
    for (int i = 0; i < (int)work->record->drifts; i++) {
        work->stand->drift_v[i] = waves[(int)work->record->waves + i];
    }
    const double *const betas = &waves[(size_t)work->record->waves + work->record->drifts];
    for (int m = 0; m < (int)work->record->inclinations; m++) {
        work->stand->beta_rad[m] = betas[m];
        work->stand->tau_rad[m] = betas[(int)work->record->inclinations + m];
    }
    return finite;
}

/* One pass over all fit positions, from an estimate to the next; the first one linear. */
static tumble_status_t pass(work_t *work, const tumble_means_t *means, bool first)
{
    size_t fit = 0;
    bool small = true;
    for (int row = 0; row < MAX_ROWS; row++) {
        work->sum[row] = 0.0;
    }
    for (uint8_t p = 0; p < work->schedule->position_count; p++) {
        if (work->schedule->positions[p].use == TUMBLE_USE_FIT) {
            double u_v[3] = {means->u_v[p][0], means->u_v[p][1], means->u_v[p][2]};
            if (!first) {
                small = subtract_curvature(work, p, fit, u_v) && small;
            }
            apply_gains(work, TUMBLE_CHANNELS * fit, u_v);
            fit++;
        }
    }
    const bool finite = take_over(work);
    if (!small) {
        return TUMBLE_E_STAND_ERROR;
    }
    return finite ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
}

static tumble_status_t check(const tumble_gain_record_t *record, const tumble_schedule_t *schedule,
                             const tumble_means_t *means)
{
    if ((record->fit_positions != tumble_means_fit_positions(schedule)) ||
        (record->mountings != schedule->mounting_count)) {
        return TUMBLE_E_GAIN_TABLE;
    }
    return tumble_means_are_complete(schedule, means) ? TUMBLE_OK : TUMBLE_E_MISSING_POSITION;
}

tumble_status_t tumble_estimate_optimal(const tumble_gain_record_t *record, const tumble_schedule_t *schedule,
                                        const tumble_means_t *means, tumble_coefficients_t *coefficients,
                                        tumble_optimal_t *optimal)
{
    if ((record == NULL) || (optimal == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_status_t status = tumble_means_check(schedule, means, coefficients);
    if (status == TUMBLE_OK) {
        status = check(record, schedule, means);
    }
    if (status != TUMBLE_OK) {
        return status;
    }
    *optimal = (tumble_optimal_t){0};
    work_t work = {.record = record,
                   .schedule = schedule,
                   .block = coefficients,
                   .stand = &optimal->stand,
                   .curvature_rad = optimal->curvature_rad};
    const int passes = (record->inclinations > 0U) ? PASSES_INCLINED : PASSES;
    for (int n = 0; (n < passes) && (status == TUMBLE_OK); n++) {
        status = pass(&work, means, n == 0);
    }
    if (status != TUMBLE_OK) {
        *coefficients = (tumble_coefficients_t){0};
        *optimal = (tumble_optimal_t){0};
    }
    return status;
}

tumble_status_t tumble_optimal_check(const void *source, const tumble_schedule_t *schedule)
{
    const tumble_optimal_source_t *from = source;
    const tumble_gain_record_t *record;
    if ((from == NULL) || (from->work == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    return tumble_gain_record_open(from->record, from->record_bytes, schedule, &record);
}

tumble_status_t tumble_optimal_estimate(const void *source, const tumble_schedule_t *schedule,
                                        const tumble_means_t *means, tumble_coefficients_t *coefficients)
{
    const tumble_optimal_source_t *from = source;
    const tumble_status_t status = tumble_optimal_check(source, schedule);
    return (status == TUMBLE_OK) ? tumble_estimate_optimal(from->record, schedule, means, coefficients, from->work)
                                 : status;
}
