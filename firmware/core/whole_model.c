#include "tumble/core.h"

#include "core/arith.h"
#include "core/normal.h"
#include "core/turn.h"
#include "core/vector.h"

#include <stdbool.h>
#include <stddef.h>

#define STEPS 4             /* of Gauss and Newton */
#define SMALLEST_NOISE 1e-7 /* of a mean, relative to the largest element of K, so that all have weights */

/* The unknowns: what a mounting has for itself comes first, so that it is eliminated with the mounting. Then the
 * coefficients channel by channel (K_ix, K_iy, K_iz, U0_i), then what all share. */
#define COEFFICIENTS TUMBLE_WHOLE_LOCAL
#define SHARED (COEFFICIENTS + TUMBLE_COEFFICIENTS)
#define UNKNOWNS TUMBLE_WHOLE_UNKNOWNS

enum { ALPHA1, ALPHA2, PLATFORM, COMMON_YAW };
enum { YAW, THETA_H, THETA_N };

/* Standard deviations of the stand's errors. */
typedef struct {
    double shared_rad[TUMBLE_WHOLE_SHARED];
    double local_rad[TUMBLE_WHOLE_LOCAL];
} sigmas_t;

/* A position, linearised where the step before ended: outputs (V) per g, per sigma of an error, per rad. */
typedef struct {
    double attitude_g[TUMBLE_CHANNELS];
    double by_local[TUMBLE_WHOLE_LOCAL][TUMBLE_CHANNELS];
    double by_shared[TUMBLE_WHOLE_SHARED][TUMBLE_CHANNELS];
    double by_angle[TUMBLE_CHANNELS];
    double residual_v[TUMBLE_CHANNELS]; /* as if the set angle had no error */
    double variance_v2;
} linear_place_t;

static void find_sigmas(const tumble_stand_record_t *stand, sigmas_t *sigmas)
{
    sigmas->shared_rad[ALPHA1] = stand->axis_tilt_rad;
    sigmas->shared_rad[ALPHA2] = stand->level_rad;
    sigmas->shared_rad[PLATFORM] = stand->platform_rad;
    sigmas->shared_rad[COMMON_YAW] = stand->common_yaw ? stand->remount_rad : 0.0;
    sigmas->local_rad[YAW] = stand->common_yaw ? 0.0 : stand->remount_rad;
    sigmas->local_rad[THETA_H] = stand->seat_rad;
    sigmas->local_rad[THETA_N] = stand->seat_rad;
}

/* From (h, n, v) of the table to the block's axes. */
static void to_block(const tumble_mounting_t *mounting, const double f[3], double a[TUMBLE_CHANNELS])
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        a[i] = tumble_dot(mounting->matrix[i], f);
    }
}

/* What the outputs make of a change of the force, times `by`. */
static void respond(const tumble_whole_work_t *work, const tumble_mounting_t *mounting, const double f[3], double by,
                    double out_v[TUMBLE_CHANNELS])
{
    double a[TUMBLE_CHANNELS];
    to_block(mounting, f, a);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        out_v[i] = by * tumble_dot(work->coefficients.k_v_per_g[i], a);
    }
}

static void look_at(const tumble_whole_run_t *run, const tumble_whole_work_t *work, uint8_t p, linear_place_t *place)
{
    const tumble_mounting_t *mounting = tumble_schedule_mounting_of(run->schedule, p);
    const float *own = work->local_rad[mounting - run->schedule->mountings];
    sigmas_t sigmas;
    find_sigmas(run->stand, &sigmas);
    double sine = run->schedule->positions[p].angle.sine;
    double cosine = run->schedule->positions[p].angle.cosine;
    double tilt_sine = mounting->tilt.sine;
    double tilt_cosine = mounting->tilt.cosine;
    const double angle_rad = (double)work->angle_rad[p];
    tumble_turn(work->shared_rad[ALPHA2] + (double)own[THETA_N] + angle_rad, &sine, &cosine);
    tumble_turn(work->shared_rad[ALPHA1], &tilt_sine, &tilt_cosine);
    double force[3] = {tilt_cosine * sine, tilt_sine, tilt_cosine * cosine};
    double by_alpha1[3] = {-tilt_sine * sine, tilt_cosine, -tilt_sine * cosine};
    double by_turn[3] = {tilt_cosine * cosine, 0.0, -tilt_cosine * sine};
    const double lean = (double)own[THETA_H] + work->shared_rad[PLATFORM];
    tumble_turn(lean, &force[1], &force[2]);
    tumble_turn(lean, &by_alpha1[1], &by_alpha1[2]);
    tumble_turn(lean, &by_turn[1], &by_turn[2]);
    double by_lean[3] = {0.0, force[2], -force[1]};
    const double yaw = (double)own[YAW] + work->shared_rad[COMMON_YAW];
    tumble_turn(yaw, &by_lean[0], &by_lean[1]);
    tumble_turn(yaw, &force[0], &force[1]);
    tumble_turn(yaw, &by_alpha1[0], &by_alpha1[1]);
    tumble_turn(yaw, &by_turn[0], &by_turn[1]);
    const double by_yaw[3] = {force[1], -force[0], 0.0};
    to_block(mounting, force, place->attitude_g);
    respond(work, mounting, by_yaw, sigmas.local_rad[YAW], place->by_local[YAW]);
    respond(work, mounting, by_lean, sigmas.local_rad[THETA_H], place->by_local[THETA_H]);
    respond(work, mounting, by_turn, sigmas.local_rad[THETA_N], place->by_local[THETA_N]);
    respond(work, mounting, by_alpha1, sigmas.shared_rad[ALPHA1], place->by_shared[ALPHA1]);
    respond(work, mounting, by_turn, sigmas.shared_rad[ALPHA2], place->by_shared[ALPHA2]);
    respond(work, mounting, by_lean, sigmas.shared_rad[PLATFORM], place->by_shared[PLATFORM]);
    respond(work, mounting, by_yaw, sigmas.shared_rad[COMMON_YAW], place->by_shared[COMMON_YAW]);
    respond(work, mounting, by_turn, 1.0, place->by_angle);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double felt_v = tumble_dot(work->coefficients.k_v_per_g[i], place->attitude_g);
        place->residual_v[i] =
            run->means->u_v[p][i] - work->coefficients.u0_v[i] - felt_v + (place->by_angle[i] * angle_rad);
    }
    place->variance_v2 = tumble_larger(run->mean_variance_v2[p], work->least_v2);
}

static double *triangle_row(tumble_whole_work_t *work, int j)
{
    return &work->triangle[(j * (UNKNOWNS + 1)) - ((j * (j - 1)) / 2)];
}

static void clear_rows(tumble_whole_work_t *work, int from, int to)
{
    for (int j = from; j < to; j++) {
        double *r = triangle_row(work, j);
        for (int k = 0; k <= (UNKNOWNS - j); k++) {
            r[k] = 0.0;
        }
    }
}

/* Turn work->row into the first `columns` rows of the triangle, by Givens rotations. What is then left of its right side
 * is a residual, if these are all. */
static void add_row(tumble_whole_work_t *work, int columns)
{
    double *row = work->row;
    for (int j = 0; j < columns; j++) {
        double *r = triangle_row(work, j);
        const double length = tumble_sqrt((r[0] * r[0]) + (row[j] * row[j]));
        if (tumble_within(row[j], 0.0)) {
            continue;
        }
        const double c = r[0] / length;
        const double s = row[j] / length;
        for (int k = j; k <= UNKNOWNS; k++) {
            const double kept = (c * r[k - j]) + (s * row[k]);
            row[k] = (c * row[k]) - (s * r[k - j]);
            r[k - j] = kept;
        }
    }
    work->residual_square += row[UNKNOWNS] * row[UNKNOWNS];
}

/* An error of the stand is one of its sigmas, give or take one. */
static void add_prior(tumble_whole_work_t *work, int unknown, double error_rad, double sigma_rad, int columns)
{
    for (int k = 0; k <= UNKNOWNS; k++) {
        work->row[k] = 0.0;
    }
    work->row[unknown] = 1.0;
    work->row[UNKNOWNS] = tumble_exceeds(sigma_rad, 0.0) ? (-error_rad / sigma_rad) : 0.0;
    add_row(work, columns);
}

/* The row of the outputs combined by `mix`. */
static void make_row(tumble_whole_work_t *work, const linear_place_t *place, const double mix[TUMBLE_CHANNELS])
{
    double *row = work->row;
    for (int e = 0; e < TUMBLE_WHOLE_LOCAL; e++) {
        row[e] = tumble_dot(mix, place->by_local[e]);
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double *of_channel = &row[COEFFICIENTS + (TUMBLE_UNKNOWNS * i)];
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            of_channel[j] = mix[i] * place->attitude_g[j];
        }
        of_channel[TUMBLE_CHANNELS] = mix[i];
    }
    for (int e = 0; e < TUMBLE_WHOLE_SHARED; e++) {
        row[SHARED + e] = tumble_dot(mix, place->by_shared[e]);
    }
    row[UNKNOWNS] = tumble_dot(mix, place->residual_v);
}

/* Three whitened rows: V^-1/2 = (I - c d d^T) / sqrt(v) for the covariance V = v I + sigma^2 d d^T of the outputs. */
static void add_place(const tumble_whole_run_t *run, tumble_whole_work_t *work, uint8_t p, int columns)
{
    linear_place_t place;
    look_at(run, work, p, &place);
    const double v = place.variance_v2;
    const double square = tumble_dot(place.by_angle, place.by_angle);
    const double along = run->stand->angle_rad * run->stand->angle_rad * square;
    const double c = tumble_exceeds(square, 0.0) ? ((1.0 - tumble_sqrt(v / (v + along))) / square) : 0.0;
    const double weight = 1.0 / tumble_sqrt(v);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double mix[TUMBLE_CHANNELS];
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            mix[j] = weight * (((i == j) ? 1.0 : 0.0) - (c * place.by_angle[i] * place.by_angle[j]));
        }
        make_row(work, &place, mix);
        add_row(work, columns);
    }
}

static bool belongs(const tumble_whole_run_t *run, uint8_t m, uint8_t p)
{
    return (run->schedule->positions[p].mounting == run->schedule->mountings[m].number) &&
           tumble_normal_uses(run->schedule, run->means->measured, p);
}

/* All that one mounting says, into the first `columns` rows. */
static void add_mounting(const tumble_whole_run_t *run, tumble_whole_work_t *work, uint8_t m, int columns)
{
    sigmas_t sigmas;
    find_sigmas(run->stand, &sigmas);
    clear_rows(work, 0, TUMBLE_WHOLE_LOCAL);
    for (int e = 0; e < TUMBLE_WHOLE_LOCAL; e++) {
        add_prior(work, e, (double)work->local_rad[m][e], sigmas.local_rad[e], columns);
    }
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        if (belongs(run, m, p)) {
            add_place(run, work, p, columns);
        }
    }
}

/* The unknowns `from` to below `to`, those after them being known. */
static void substitute_back(tumble_whole_work_t *work, int from, int to)
{
    for (int j = to - 1; j >= from; j--) {
        const double *r = triangle_row(work, j);
        double value = r[UNKNOWNS - j];
        for (int k = j + 1; k < UNKNOWNS; k++) {
            value -= r[k - j] * work->change[k];
        }
        work->change[j] = tumble_within(r[0], 0.0) ? 0.0 : (value / r[0]);
    }
}

static double held(double error_rad)
{
    const double most = TUMBLE_MAX_STAND_ERROR_RAD;
    return tumble_within(error_rad, most) ? error_rad : (tumble_exceeds(error_rad, 0.0) ? most : -most);
}

/* The best estimate of the error of a set angle, from what this step leaves of the outputs. */
static double angle_error(const tumble_whole_run_t *run, tumble_whole_work_t *work, uint8_t p)
{
    linear_place_t place;
    look_at(run, work, p, &place);
    const double square = run->stand->angle_rad * run->stand->angle_rad;
    make_row(work, &place, place.by_angle);
    double along = work->row[UNKNOWNS];
    for (int k = 0; k < UNKNOWNS; k++) {
        along -= work->row[k] * work->change[k];
    }
    return held(square * along / (place.variance_v2 + (square * tumble_dot(place.by_angle, place.by_angle))));
}

/* What a mounting has for itself, after the unknowns of all are known. */
static void update_mounting(const tumble_whole_run_t *run, tumble_whole_work_t *work, uint8_t m)
{
    sigmas_t sigmas;
    find_sigmas(run->stand, &sigmas);
    add_mounting(run, work, m, TUMBLE_WHOLE_LOCAL);
    substitute_back(work, 0, TUMBLE_WHOLE_LOCAL);
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        if (belongs(run, m, p)) {
            work->angle_rad[p] = tumble_to_float(angle_error(run, work, p));
        }
    }
    for (int e = 0; e < TUMBLE_WHOLE_LOCAL; e++) {
        const double error_rad = (double)work->local_rad[m][e] + (sigmas.local_rad[e] * work->change[e]);
        work->local_rad[m][e] = tumble_to_float(held(error_rad));
    }
}

static void update_all(const tumble_whole_run_t *run, tumble_whole_work_t *work)
{
    sigmas_t sigmas;
    find_sigmas(run->stand, &sigmas);
    for (uint8_t m = 0; m < run->schedule->mounting_count; m++) {
        update_mounting(run, work, m);
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double *change = &work->change[COEFFICIENTS + (TUMBLE_UNKNOWNS * i)];
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            work->coefficients.k_v_per_g[i][j] += change[j];
        }
        work->coefficients.u0_v[i] += change[TUMBLE_CHANNELS];
    }
    for (int e = 0; e < TUMBLE_WHOLE_SHARED; e++) {
        work->shared_rad[e] = held(work->shared_rad[e] + (sigmas.shared_rad[e] * work->change[SHARED + e]));
    }
}

/* Solve the problem that is linear where the step before ended; the sum of squares that is left. */
static double take_step(const tumble_whole_run_t *run, tumble_whole_work_t *work)
{
    sigmas_t sigmas;
    find_sigmas(run->stand, &sigmas);
    clear_rows(work, 0, UNKNOWNS);
    work->residual_square = 0.0;
    for (int e = 0; e < TUMBLE_WHOLE_SHARED; e++) {
        add_prior(work, SHARED + e, work->shared_rad[e], sigmas.shared_rad[e], UNKNOWNS);
    }
    for (uint8_t m = 0; m < run->schedule->mounting_count; m++) {
        add_mounting(run, work, m, UNKNOWNS);
    }
    const double square = work->residual_square;
    substitute_back(work, TUMBLE_WHOLE_LOCAL, UNKNOWNS);
    update_all(run, work);
    return square;
}

static double largest_k(const tumble_coefficients_t *coefficients)
{
    double largest = 0.0;
    for (int i = 0; i < (TUMBLE_CHANNELS * TUMBLE_CHANNELS); i++) {
        largest = tumble_larger(largest, tumble_abs(coefficients->k_v_per_g[i / TUMBLE_CHANNELS][i % TUMBLE_CHANNELS]));
    }
    return largest;
}

tumble_status_t tumble_whole_chi_squared(const tumble_whole_run_t *run, tumble_whole_work_t *work, double *chi_squared,
                                         uint8_t *freedom)
{
    if ((run == NULL) || (run->schedule == NULL) || (run->means == NULL) || (run->stand == NULL) ||
        (run->mean_variance_v2 == NULL) || (work == NULL) || (chi_squared == NULL) || (freedom == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    *work = (tumble_whole_work_t){.residual_square = 0.0};
    const tumble_status_t status = tumble_estimate_least_squares(run->schedule, run->means, &work->coefficients, NULL);
    if (status != TUMBLE_OK) {
        return status;
    }
    const double least_v = SMALLEST_NOISE * largest_k(&work->coefficients);
    work->least_v2 = least_v * least_v;
    for (int n = 0; n < STEPS; n++) {
        *chi_squared = take_step(run, work);
    }
    int means = 0;
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        means += tumble_normal_uses(run->schedule, run->means->measured, p) ? TUMBLE_CHANNELS : 0;
    }
    *freedom = (uint8_t)(means - TUMBLE_COEFFICIENTS);
    return TUMBLE_OK;
}
