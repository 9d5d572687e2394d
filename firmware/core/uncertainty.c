#include "core/uncertainty.h"

#include "core/arith.h"
#include "core/course.h"
#include "core/harmonic.h"
#include "core/means.h"
#include "core/normal.h"
#include "core/one_copy.h"
#include "core/stand_record.h"
#include "core/vector.h"

#include <stddef.h>

typedef struct tumble_least_squares {
    tumble_normal_t normal;
    double column[TUMBLE_UNKNOWNS]; /* of N^-1, the one of the unknown */
} least_squares_t;

/* What one unit of each source does to one coefficient; of the noise, what it does as it is. */
enum { ALPHA3, THETA_H, THETA_N, OF_BOLTING };

typedef struct {
    double alpha1;
    double alpha4_squared;
    double noise_squared;
    double common[OF_BOLTING]; /* were they common to all boltings; THETA_N is alpha2 then */
    double own[OF_BOLTING];    /* of the present bolting: of all its mountings up to here */
    double yaws_squared;       /* of those of each bolting */
    double seats_squared;
    double variance_v2[TUMBLE_CHANNELS]; /* of the noise of a mean */
    uint32_t samples[TUMBLE_CHANNELS];   /* of so many samples: the next one mostly has as many */
    tumble_course_response_t course;
} response_t;

/* A channel in one mounting: what it gives of a force along h, n, v of the table frame (its row of K M), and the sums
 * over its means of their gains, times the sine of the table angle, 1, and its cosine. */
typedef struct {
    double force[3];
    double moment[3];
} channel_t;

#define NORMAL_SHIFT 4U
#define SIXTEENTHS 0xFU

/* What each mean weighs in s and c, times sine or cosine (closed_form.c), and twice what it weighs in b: of nine positions
 * 1/4, but the two ends, which share one attitude, 1/8; of the diagonals 1/2. */
static void find_slots(const tumble_harmonic_map_t *map, uint8_t slots[TUMBLE_MAX_POSITIONS])
{
    for (uint8_t m = 0; m < map->count; m++) {
        const tumble_circle_t *circle = &map->circle[m];
        for (uint32_t step = circle->stride - 1U; step < TUMBLE_STEPS; step += circle->stride) {
            const bool is_end = (step == 0U) || (step == (TUMBLE_STEPS - 1U));
            const uint32_t weight = is_end ? 2U : (4U * circle->stride);
            slots[circle->index[step]] = (uint8_t)(weight | ((uint32_t)circle->normal << NORMAL_SHIFT));
        }
    }
}

static double harmonic_gain(const tumble_gains_t *gains, uint8_t p)
{
    const uint32_t slot = gains->slots[p];
    const double weight = (double)(slot & SIXTEENTHS) / 16.0;
    if (gains->unknown == TUMBLE_BIAS) {
        return tumble_divide(0.5 * weight, (double)gains->map->count);
    }
    const uint8_t share = tumble_circle_share(gains->map, gains->kind == TUMBLE_GAINS_REFINED, gains->channel,
                                              gains->unknown, (int)(slot >> NORMAL_SHIFT));
    if ((slot == 0U) || (share == 0U)) {
        return 0.0;
    }
    const tumble_angle_t *angle = &gains->run->schedule->positions[p].angle;
    const double *axis = tumble_schedule_mounting_of(gains->run->schedule, p)->matrix[gains->unknown];
    return tumble_divide(weight * ((axis[0] * angle->sine) + (axis[2] * angle->cosine)), (double)share);
}

/* The gain that least squares gives the mean of a position in one unknown: its row times that column of N^-1. The row
 * is left in `row`. */
static double least_squares_gain(const tumble_gains_t *gains, uint8_t p, double row[TUMBLE_UNKNOWNS])
{
    double gain = 0.0;
    tumble_normal_row(gains->run->schedule, p, row);
    for (int j = 0; j < TUMBLE_UNKNOWNS; j++) {
        gain += row[j] * gains->least_squares->column[j];
    }
    return gain;
}

/* The column of N^-1 that belongs to the unknown, or with an attitude n the sum of them that is U0_i + K_i n. A fit is
 * corrected from its residual (normal.h), this is not: what the condition of N takes from it, 1e-8 of it at the worst, is
 * nothing to an uncertainty. */
static void solve_column(const tumble_gains_t *gains)
{
    const double *attitude = gains->run->attitude;
    double *column = gains->least_squares->column;
    for (int j = 0; j < TUMBLE_UNKNOWNS; j++) {
        const bool counts = (attitude != NULL) || (j == gains->unknown);
        column[j] = !counts ? 0.0 : ((attitude == NULL) || (j == TUMBLE_BIAS)) ? 1.0 : attitude[j];
    }
    tumble_normal_solve(&gains->least_squares->normal, column);
}

/* The gains of the position `p`, the fit position number `fit` from 0, for its three channels. False if all are 0. */
static bool gains_of_one(const tumble_gains_t *gains, uint8_t p, size_t fit, double g[TUMBLE_CHANNELS])
{
    if (gains->kind == TUMBLE_GAINS_TABLE) {
        const size_t row_length = (size_t)gains->table->fit_positions * TUMBLE_CHANNELS;
        const int row = (gains->unknown == TUMBLE_BIAS) ? (TUMBLE_CHANNELS * TUMBLE_CHANNELS) + gains->channel
                                                        : (TUMBLE_CHANNELS * gains->channel) + gains->unknown;
        for (size_t i = 0; i < TUMBLE_CHANNELS; i++) {
            g[i] = gains->table->gains[((size_t)row * row_length) + (fit * TUMBLE_CHANNELS) + i];
        }
        return true;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        g[i] = 0.0;
    }
    double row[TUMBLE_UNKNOWNS];
    g[gains->channel] =
        (gains->kind == TUMBLE_GAINS_LEAST_SQUARES) ? least_squares_gain(gains, p, row) : harmonic_gain(gains, p);
    return tumble_is_positive(tumble_abs(g[gains->channel]));
}

/* Of the length of the shown specific force at an attitude n, which an error of K_ij shortens by w_i n_j of it, and one
 * of U0_i by w_i, with w = n K^-1. */
static void norm_gains(tumble_gains_t *gains, uint8_t p, size_t fit, double g[TUMBLE_CHANNELS])
{
    double of_one[TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        g[i] = 0.0;
    }
    for (gains->channel = TUMBLE_X; gains->channel <= TUMBLE_Z; gains->channel++) {
        const int last =
            (gains->kind == TUMBLE_GAINS_LEAST_SQUARES) ? TUMBLE_X : TUMBLE_BIAS; /* its column holds the sum already */
        for (gains->unknown = TUMBLE_X; gains->unknown <= last; gains->unknown++) {
            const bool is_sum = (gains->kind == TUMBLE_GAINS_LEAST_SQUARES) || (gains->unknown == TUMBLE_BIAS);
            const double weight =
                gains->by_channel[gains->channel] * (is_sum ? 1.0 : gains->run->attitude[gains->unknown]);
            if (gains_of_one(gains, p, fit, of_one)) {
                for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                    g[i] += weight * of_one[i];
                }
            }
        }
    }
}

static bool gains_at(tumble_gains_t *gains, uint8_t p, size_t fit, double g[TUMBLE_CHANNELS])
{
    if (gains->run->attitude == NULL) {
        return gains_of_one(gains, p, fit, g);
    }
    norm_gains(gains, p, fit, g);
    return true;
}

static double noise_variance_v2(const tumble_judged_run_t *run, int i, uint32_t samples)
{
    const tumble_stand_record_t *stand = run->stand;
    const double declared_v2 = tumble_larger(tumble_square(tumble_stand_noise_v(stand, i)) / (double)samples,
                                             tumble_square(stand->least_noise_v));
    return (run->noise != NULL) ? (declared_v2 + tumble_noise_excess(run->noise, i, samples, declared_v2))
                                : declared_v2;
}

/* What the noise of the mean of a position does. Not inlined: else its numbers lie on the stack below add_mounting's. */
TUMBLE_ONE_COPY static void add_noise(const tumble_judged_run_t *run, uint8_t p, const double g[TUMBLE_CHANNELS],
                                      response_t *response)
{
    const uint32_t samples = (run->samples != NULL) ? run->samples[p] : run->stand->samples;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        if (tumble_is_positive(tumble_abs(g[i]))) { /* most are 0 */
            if (samples != response->samples[i]) {  /* a division costs as much as all the rest */
                response->samples[i] = samples;
                response->variance_v2[i] = noise_variance_v2(run, i, samples);
            }
            double variance_v2 = response->variance_v2[i];
            if (run->excess_variance_v2 != NULL) {
                variance_v2 += run->excess_variance_v2[p][i];
            }
            response->noise_squared += tumble_square(g[i]) * variance_v2;
        }
    }
}

static void open_channel(const tumble_coefficients_t *coefficients, const tumble_mounting_t *mounting, int i,
                         channel_t *channel)
{
    const double *k = coefficients->k_v_per_g[i];
    for (int n = 0; n < 3; n++) {
        channel->force[n] =
            (k[0] * mounting->matrix[0][n]) + (k[1] * mounting->matrix[1][n]) + (k[2] * mounting->matrix[2][n]);
        channel->moment[n] = 0.0;
    }
}

/* Add a mean to its channel. What an error of its table angle does to the coefficient, but for cos t. */
static double add_mean(const tumble_angle_t *angle, double gain, channel_t *channel)
{
    const double part[3] = {gain * angle->sine, gain, gain * angle->cosine};
    for (int n = 0; n < 3; n++) {
        channel->moment[n] += part[n];
    }
    return (channel->force[0] * part[2]) - (channel->force[2] * part[0]);
}

/* Add what the errors of the mounting do. The derivatives of the force f = (cos t sin p, sin t, cos t cos p) by each at
 * zero error:
 *     alpha1           (-sin t sin p, cos t, -sin t cos p)
 *     alpha2, delta    ( cos t cos p,     0, -cos t sin p)
 *     theta_n          the same
 *     alpha3           ( sin t, -cos t sin p, 0)               the yaw turns h towards n
 *     theta_h          (0, cos t cos p, -sin t)                the tilt turns n towards v
 * What is common to all mountings adds up before it is squared. */
TUMBLE_ONE_COPY static void close_mounting(const tumble_angle_t *tilt, const channel_t *channels, int first, int last,
                                           response_t *response)
{
    double sum[3][3] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}; /* of force times moment */
    for (int i = first; i <= last; i++) {
        for (int n = 0; n < 9; n++) {
            sum[n / 3][n % 3] += channels[i].force[n / 3] * channels[i].moment[n % 3];
        }
    }
    const double turning = tilt->cosine * (sum[0][2] - sum[2][0]);
    const double alpha3 = (tilt->sine * sum[0][1]) - (tilt->cosine * sum[1][0]);
    const double theta_h = (tilt->cosine * sum[1][2]) - (tilt->sine * sum[2][1]);
    response->alpha1 += (tilt->cosine * sum[1][1]) - (tilt->sine * (sum[0][0] + sum[2][2]));
    response->own[ALPHA3] += alpha3;
    response->own[THETA_H] += theta_h;
    response->own[THETA_N] += turning;
}

/* Before a block is bolted on anew, and at the end. */
static void close_bolting(response_t *response)
{
    response->yaws_squared += tumble_square(response->own[ALPHA3]);
    response->seats_squared += tumble_square(response->own[THETA_H]) + tumble_square(response->own[THETA_N]);
    for (int e = 0; e < OF_BOLTING; e++) {
        response->common[e] += response->own[e];
        response->own[e] = 0.0;
    }
}

/* All sources in quadrature. */
static double combined(const tumble_stand_record_t *stand, const response_t *response)
{
    const double yaws_squared = stand->common_yaw ? tumble_square(response->common[ALPHA3]) : response->yaws_squared;
    return tumble_sqrt(tumble_square(stand->axis_tilt_rad * response->alpha1) +
                       tumble_square(stand->level_rad * response->common[THETA_N]) +
                       (tumble_square(stand->remount_rad) * yaws_squared) +
                       (tumble_square(stand->angle_rad) * response->alpha4_squared) + response->noise_squared +
                       (tumble_square(stand->seat_rad) * response->seats_squared) +
                       tumble_square(stand->platform_rad * response->common[THETA_H]) +
                       tumble_course_variance(stand, &response->course));
}

/* A coefficient is made of the means of its channel, but of all three by a table, as is |a|. */
static void add_mounting(tumble_gains_t *gains, const tumble_mounting_t *mounting, response_t *response)
{
    const tumble_judged_run_t *run = gains->run;
    const bool of_all = (gains->kind >= TUMBLE_GAINS_TABLE) || (run->attitude != NULL);
    const int first = of_all ? TUMBLE_X : gains->channel;
    const int last = of_all ? TUMBLE_Z : gains->channel;
    channel_t channels[TUMBLE_CHANNELS];
    size_t fit = 0;
    const tumble_gains_hooks_t *hooks = gains->hooks;
    const tumble_angle_t *tilt = (hooks != NULL) ? hooks->tilt(gains, mounting) : &mounting->tilt;
    for (int i = first; i <= last; i++) {
        open_channel(run->coefficients, mounting, i, &channels[i]);
    }
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        const tumble_position_t *position = &run->schedule->positions[p];
        const bool used = tumble_normal_uses(run->schedule, run->measured, p);
        double g[TUMBLE_CHANNELS];
        const tumble_angle_t *angle = &position->angle;
        bool counts = used && (position->mounting == mounting->number);
        if (counts && (hooks != NULL)) {
            angle = hooks->at(gains, p, g);
        } else if (counts) {
            counts = gains_at(gains, p, fit, g);
        } else {
            /* of another mounting, or not measured */
        }
        if (counts) {
            double turning = 0.0;
            for (int i = first; i <= last; i++) {
                turning += add_mean(angle, g[i], &channels[i]);
            }
            turning *= tilt->cosine;
            response->alpha4_squared += tumble_square(turning);
            tumble_course_add(run, p, turning, g, &response->course);
            add_noise(run, p, g, response);
        }
        fit += used ? 1U : 0U;
    }
    close_mounting(tilt, channels, first, last, response);
}

/* Mounting by mounting, so that no number has to be kept for each. */
static double uncertainty_of(tumble_gains_t *gains)
{
    const tumble_schedule_t *schedule = gains->run->schedule;
    response_t response = {0};
    if (gains->hooks != NULL) {
        gains->hooks->solve(gains);
    }
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        if (!tumble_schedule_stays_bolted(schedule, m)) {
            close_bolting(&response);
        }
        add_mounting(gains, &schedule->mountings[m], &response);
    }
    close_bolting(&response);
    return combined(gains->run->stand, &response);
}

static bool is_wanted(const tumble_gains_t *gains)
{
    const int coefficient = (gains->unknown == TUMBLE_BIAS) ? ((TUMBLE_CHANNELS * TUMBLE_CHANNELS) + gains->channel)
                                                            : ((TUMBLE_CHANNELS * gains->channel) + gains->unknown);
    const uint32_t bit = UINT32_C(1) << (uint32_t)coefficient;
    return (gains->run->only == 0U) || ((gains->run->only & bit) != 0U);
}

/* One unknown of each channel; the column of N^-1 is the same for all three. Infinities and NaN add up in `check`. */
static void judge_unknown(tumble_gains_t *gains, tumble_uncertainty_t *uncertainty, double *check)
{
    bool solved = (gains->kind != TUMBLE_GAINS_LEAST_SQUARES);
    for (gains->channel = TUMBLE_X; gains->channel <= TUMBLE_Z; gains->channel++) {
        if (!is_wanted(gains)) {
            continue;
        }
        if (!solved) {
            solve_column(gains);
            solved = true;
        }
        const double u = uncertainty_of(gains);
        *((gains->unknown == TUMBLE_BIAS) ? &uncertainty->u0_v[gains->channel]
                                          : &uncertainty->k_v_per_g[gains->channel][gains->unknown]) = u;
        *check += u;
    }
}

/* The columns of K^-1 are the cross products of the rows of K over its determinant. */
static tumble_status_t judge_norm(tumble_gains_t *gains)
{
    const tumble_judged_run_t *run = gains->run;
    const double (*k)[TUMBLE_CHANNELS] = run->coefficients->k_v_per_g;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double column[3];
        tumble_cross(k[(i + 1) % 3], k[(i + 2) % 3], column);
        gains->by_channel[i] = tumble_dot(run->attitude, column) / tumble_dot(k[i], column);
    }
    if (gains->kind == TUMBLE_GAINS_LEAST_SQUARES) {
        solve_column(gains);
    }
    *run->norm_g = uncertainty_of(gains);
    return tumble_is_finite(*run->norm_g) ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
}

tumble_status_t tumble_uncertainty_judge(tumble_gains_t *gains, tumble_uncertainty_t *uncertainty)
{
    if (gains->run->attitude != NULL) {
        return judge_norm(gains);
    }
    double check = 0.0;
    for (gains->unknown = TUMBLE_X; gains->unknown <= TUMBLE_BIAS; gains->unknown++) {
        judge_unknown(gains, uncertainty, &check);
    }
    if (!tumble_is_finite(check)) {
        *uncertainty = (tumble_uncertainty_t){0};
        return TUMBLE_E_NOT_FINITE;
    }
    return TUMBLE_OK;
}

tumble_status_t tumble_uncertainty_check(const tumble_judged_run_t *run, const tumble_uncertainty_t *uncertainty)
{
    if ((run == NULL) || ((run->attitude != NULL) ? (run->norm_g == NULL) : (uncertainty == NULL)) ||
        (run->schedule == NULL) || (run->stand == NULL) || (run->coefficients == NULL) ||
        !tumble_stand_record_is_valid(run->stand)) {
        return TUMBLE_E_ARGUMENT;
    }
    bool counted = true;
    for (uint8_t p = 0; (run->samples != NULL) && (p < run->schedule->position_count); p++) {
        counted = counted && (!tumble_normal_uses(run->schedule, run->measured, p) || (run->samples[p] >= 1U));
    }
    return counted ? TUMBLE_OK : TUMBLE_E_ARGUMENT;
}

static void report(tumble_refusal_t *refusal, uint64_t missing, uint8_t unidentified)
{
    if (refusal != NULL) {
        *refusal = (tumble_refusal_t){missing, unidentified};
    }
}

static tumble_status_t judge_harmonic(tumble_gains_kind_t kind, const tumble_judged_run_t *run,
                                      tumble_uncertainty_t *uncertainty, tumble_refusal_t *refusal)
{
    tumble_status_t status = tumble_uncertainty_check(run, uncertainty);
    tumble_harmonic_map_t map;
    uint8_t slots[TUMBLE_MAX_POSITIONS] = {0};
    tumble_gains_t gains = {.run = run, .kind = kind, .map = &map, .slots = slots};
    uint64_t missing = 0;
    if (status == TUMBLE_OK) {
        status = tumble_schedule_harmonic(run->schedule, run->measured, &map, &missing);
    }
    report(refusal, missing, 0);
    if (status == TUMBLE_OK) {
        find_slots(&map, slots);
        status = tumble_uncertainty_judge(&gains, uncertainty);
    }
    return status;
}

tumble_status_t tumble_uncertainty_averaged(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                            tumble_refusal_t *refusal)
{
    return judge_harmonic(TUMBLE_GAINS_AVERAGED, run, uncertainty, refusal);
}

tumble_status_t tumble_uncertainty_refined(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                           tumble_refusal_t *refusal)
{
    return judge_harmonic(TUMBLE_GAINS_REFINED, run, uncertainty, refusal);
}

/* Not inlined: else a matrix lies on the stack below the other estimators' judges, too. */
TUMBLE_ONE_COPY tumble_status_t tumble_uncertainty_least_squares(const tumble_judged_run_t *run,
                                                                 tumble_uncertainty_t *uncertainty,
                                                                 tumble_refusal_t *refusal)
{
    const tumble_status_t status = tumble_uncertainty_check(run, uncertainty);
    report(refusal, 0, 0);
    if (status != TUMBLE_OK) {
        return status;
    }
    least_squares_t least_squares;
    tumble_gains_t gains = {.run = run, .kind = TUMBLE_GAINS_LEAST_SQUARES, .least_squares = &least_squares};
    tumble_normal_build(&least_squares.normal, run->schedule, run->measured);
    const uint8_t unidentified = tumble_normal_unidentified(&least_squares.normal);
    report(refusal, 0, unidentified);
    return (unidentified == 0U) ? tumble_uncertainty_judge(&gains, uncertainty) : TUMBLE_E_RANK;
}
