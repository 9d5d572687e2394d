#include "tumble/core.h"

#include "core/arith.h"
#include "core/course.h"
#include "core/harmonic.h"
#include "core/inclined.h"
#include "core/means.h"
#include "core/normal.h"
#include "core/one_copy.h"
#include "core/stand_record.h"
#include "core/vector.h"

#include <stddef.h>

enum { X, Y, Z, BIAS }; /* the unknowns of a channel: K_ix, K_iy, K_iz, U0_i */

typedef enum { AVERAGED, REFINED, LEAST_SQUARES, TABLE, INCLINED } kind_t;

typedef struct {
    tumble_normal_t normal;
    double column[TUMBLE_UNKNOWNS]; /* of N^-1, the one of the unknown */
} least_squares_t;

typedef struct {
    tumble_inclined_map_t map;
    tumble_inclined_t run;
    tumble_harmonics_t gains; /* of the coefficient, or with an attitude of |a| */
} inclined_t;

/* Where the gains of one coefficient come from; of the pointers those that belong to the kind. */
typedef struct {
    const tumble_judged_run_t *run;
    kind_t kind;
    int channel;
    int unknown;
    const tumble_harmonic_map_t *map;
    const uint8_t *slots; /* with the map: what each position is to it */
    least_squares_t *least_squares;
    inclined_t *inclined;
    const tumble_gain_table_t *table;
    double by_channel[TUMBLE_CHANNELS]; /* with an attitude n: n K^-1, what |a| changes by an output of each */
} gains_t;

/* What one unit of each source does to one coefficient; of the noise, what it does as it is. */
typedef struct {
    double alpha1;
    double alpha2;
    double alpha4_squared;
    double noise_squared;
    double yaw; /* of alpha3 and theta_h common to all mountings, and of those of each bolting */
    double yaws_squared;
    double lean;
    double seats_squared;
    double variance_v2[TUMBLE_CHANNELS]; /* of the noise of a mean */
    uint32_t samples[TUMBLE_CHANNELS];   /* of so many samples: the next one mostly has as many */
    tumble_course_response_t course;
} response_t;

/* The same of what the mountings of one bolting share. */
typedef struct {
    double alpha3;
    double theta_h;
    double theta_n;
} bolted_t;

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

static double harmonic_gain(const gains_t *gains, uint8_t p)
{
    const uint32_t slot = gains->slots[p];
    const double weight = (double)(slot & SIXTEENTHS) / 16.0;
    if (gains->unknown == BIAS) {
        return tumble_divide(0.5 * weight, (double)gains->map->count);
    }
    const uint8_t share = tumble_circle_share(gains->map, gains->kind == REFINED, gains->channel, gains->unknown,
                                              (int)(slot >> NORMAL_SHIFT));
    if ((slot == 0U) || (share == 0U)) {
        return 0.0;
    }
    const tumble_angle_t *angle = &gains->run->schedule->positions[p].angle;
    const double *axis = tumble_schedule_mounting_of(gains->run->schedule, p)->matrix[gains->unknown];
    return tumble_divide(weight * ((axis[0] * angle->sine) + (axis[2] * angle->cosine)), (double)share);
}

/* The gain that least squares gives the mean of a position in one unknown: its row times that column of N^-1. The row
 * is left in `row`. */
static double least_squares_gain(const gains_t *gains, uint8_t p, double row[TUMBLE_UNKNOWNS])
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
static void solve_column(const gains_t *gains)
{
    const double *attitude = gains->run->attitude;
    double *column = gains->least_squares->column;
    for (int j = 0; j < TUMBLE_UNKNOWNS; j++) {
        const bool counts = (attitude != NULL) || (j == gains->unknown);
        column[j] = !counts ? 0.0 : ((attitude == NULL) || (j == BIAS)) ? 1.0 : attitude[j];
    }
    tumble_normal_solve(&gains->least_squares->normal, column);
}

/* Where the mounting of a position stands among the inclinations. */
static uint8_t inclination_of(const gains_t *gains, const tumble_mounting_t *mounting)
{
    const tumble_inclined_map_t *map = &gains->inclined->map;
    uint8_t k = 0;
    while ((k < (map->count - 1U)) && (&gains->run->schedule->mountings[map->mounting[k]] != mounting)) {
        k++;
    }
    return k;
}

/* What a harmonic weighs, times what the mean weighs in it (core/inclined.c). */
static void inclined_gain(const gains_t *gains, uint8_t p, double g[TUMBLE_CHANNELS])
{
    const tumble_angle_t *angle = &gains->run->schedule->positions[p].angle;
    const uint8_t k = inclination_of(gains, tumble_schedule_mounting_of(gains->run->schedule, p));
    const double (*of)[TUMBLE_CHANNELS] = gains->inclined->gains[k];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double waves = (of[TUMBLE_SINE][i] * angle->sine) + (of[TUMBLE_COSINE][i] * angle->cosine);
        g[i] = ((2.0 * waves) + of[TUMBLE_LEVEL][i]) / (double)gains->inclined->map.positions[k];
    }
}

/* The gains of the harmonics in the coefficient, or with an attitude n in the length of the shown specific force. K_ij is
 * the sum of K_ih, K_in, K_iv over row j of the mounting's matrix. */
static void solve_inclined(const gains_t *gains)
{
    const tumble_inclined_map_t *map = &gains->inclined->map;
    const double (*matrix)[3] = map->schedule->mountings[map->mounting[0]].matrix;
    const double *attitude = gains->run->attitude;
    double seed[TUMBLE_UNKNOWNS][TUMBLE_CHANNELS] = {{0.0}};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const bool counts = (attitude != NULL) || (i == gains->channel);
        const double weight = !counts ? 0.0 : (attitude != NULL) ? gains->by_channel[i] : 1.0;
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            const double of_axis = (attitude != NULL) ? attitude[j] : (j == gains->unknown) ? 1.0 : 0.0;
            for (int n = 0; n < 3; n++) {
                seed[n][i] += weight * of_axis * matrix[j][n];
            }
        }
        seed[BIAS][i] = ((attitude != NULL) || (gains->unknown == BIAS)) ? weight : 0.0;
    }
    tumble_inclined_gains(map, &gains->inclined->run, seed, gains->inclined->gains);
}

/* The gains of the position `p`, the fit position number `fit` from 0, for its three channels. False if all are 0. */
static bool gains_of_one(const gains_t *gains, uint8_t p, size_t fit, double g[TUMBLE_CHANNELS])
{
    if (gains->kind == TABLE) {
        const size_t row_length = (size_t)gains->table->fit_positions * TUMBLE_CHANNELS;
        const int row = (gains->unknown == BIAS) ? (TUMBLE_CHANNELS * TUMBLE_CHANNELS) + gains->channel
                                                 : (TUMBLE_CHANNELS * gains->channel) + gains->unknown;
        for (size_t i = 0; i < TUMBLE_CHANNELS; i++) {
            g[i] = gains->table->gains[((size_t)row * row_length) + (fit * TUMBLE_CHANNELS) + i];
        }
        return true;
    }
    if (gains->kind == INCLINED) {
        inclined_gain(gains, p, g);
        return true;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        g[i] = 0.0;
    }
    double row[TUMBLE_UNKNOWNS];
    g[gains->channel] = (gains->kind == LEAST_SQUARES) ? least_squares_gain(gains, p, row) : harmonic_gain(gains, p);
    return tumble_is_positive(tumble_abs(g[gains->channel]));
}

/* Of the length of the shown specific force at an attitude n, which an error of K_ij shortens by w_i n_j of it, and one
 * of U0_i by w_i, with w = n K^-1. */
static void norm_gains(gains_t *gains, uint8_t p, size_t fit, double g[TUMBLE_CHANNELS])
{
    double of_one[TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        g[i] = 0.0;
    }
    for (gains->channel = X; gains->channel <= Z; gains->channel++) {
        const int last = (gains->kind == LEAST_SQUARES) ? X : BIAS; /* its column holds the sum already */
        for (gains->unknown = X; gains->unknown <= last; gains->unknown++) {
            const bool is_sum = (gains->kind == LEAST_SQUARES) || (gains->unknown == BIAS);
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

static bool gains_at(gains_t *gains, uint8_t p, size_t fit, double g[TUMBLE_CHANNELS])
{
    if ((gains->run->attitude == NULL) || (gains->kind == INCLINED)) {
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
static void close_mounting(const tumble_angle_t *tilt, const channel_t *channels, int first, int last,
                           response_t *response, bolted_t *bolted)
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
    response->alpha2 += turning;
    bolted->alpha3 += alpha3;
    bolted->theta_h += theta_h;
    bolted->theta_n += turning;
}

static void close_bolting(const bolted_t *bolted, response_t *response)
{
    response->yaw += bolted->alpha3;
    response->yaws_squared += tumble_square(bolted->alpha3);
    response->lean += bolted->theta_h;
    response->seats_squared += tumble_square(bolted->theta_h) + tumble_square(bolted->theta_n);
}

/* All sources in quadrature. */
static double combined(const tumble_stand_record_t *stand, const response_t *response)
{
    const double yaws_squared = stand->common_yaw ? tumble_square(response->yaw) : response->yaws_squared;
    return tumble_sqrt(
        tumble_square(stand->axis_tilt_rad * response->alpha1) + tumble_square(stand->level_rad * response->alpha2) +
        (tumble_square(stand->remount_rad) * yaws_squared) +
        (tumble_square(stand->angle_rad) * response->alpha4_squared) + response->noise_squared +
        (tumble_square(stand->seat_rad) * response->seats_squared) +
        tumble_square(stand->platform_rad * response->lean) + tumble_course_variance(stand, &response->course));
}

/* The inclination of the axis, and the angle of the table from its zero: as the run shows them where it does. */
static tumble_angle_t tilt_of(const gains_t *gains, const tumble_mounting_t *mounting)
{
    if (gains->kind != INCLINED) {
        return mounting->tilt;
    }
    const tumble_inclinations_t *seen = &gains->inclined->run.seen;
    const uint8_t k = inclination_of(gains, mounting);
    return (tumble_angle_t){0.0, seen->sine[k], seen->cosine[k]};
}

static tumble_angle_t angle_of(const gains_t *gains, const tumble_mounting_t *mounting, const tumble_angle_t *angle)
{
    if (gains->kind != INCLINED) {
        return *angle;
    }
    const tumble_inclinations_t *seen = &gains->inclined->run.seen;
    const uint8_t k = inclination_of(gains, mounting);
    return (tumble_angle_t){angle->deg, (angle->sine * seen->turn_cosine[k]) + (angle->cosine * seen->turn_sine[k]),
                            (angle->cosine * seen->turn_cosine[k]) - (angle->sine * seen->turn_sine[k])};
}

/* A coefficient is made of the means of its channel, but of all three by a table, as is |a|. */
static void add_mounting(gains_t *gains, const tumble_mounting_t *mounting, response_t *response, bolted_t *bolted)
{
    const tumble_judged_run_t *run = gains->run;
    const bool of_all = (gains->kind == TABLE) || (gains->kind == INCLINED) || (run->attitude != NULL);
    const int first = of_all ? X : gains->channel;
    const int last = of_all ? Z : gains->channel;
    channel_t channels[TUMBLE_CHANNELS];
    size_t fit = 0;
    const tumble_angle_t tilt = tilt_of(gains, mounting);
    for (int i = first; i <= last; i++) {
        open_channel(run->coefficients, mounting, i, &channels[i]);
    }
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        const tumble_position_t *position = &run->schedule->positions[p];
        const bool used = tumble_normal_uses(run->schedule, run->measured, p);
        double g[TUMBLE_CHANNELS];
        if (used && (position->mounting == mounting->number) && gains_at(gains, p, fit, g)) {
            const tumble_angle_t angle = angle_of(gains, mounting, &position->angle);
            double turning = 0.0;
            for (int i = first; i <= last; i++) {
                turning += add_mean(&angle, g[i], &channels[i]);
            }
            turning *= tilt.cosine;
            response->alpha4_squared += tumble_square(turning);
            tumble_course_add(run, p, turning, g, &response->course);
            add_noise(run, p, g, response);
        }
        fit += used ? 1U : 0U;
    }
    close_mounting(&tilt, channels, first, last, response, bolted);
}

/* Is it the same bolting as that of an earlier one? */
static bool is_bolted_on(const tumble_schedule_t *schedule, uint8_t m)
{
    const uint8_t bolting = schedule->mountings[m].bolting;
    bool earlier = false;
    for (uint8_t n = 0; n < m; n++) {
        earlier = earlier || ((bolting > 0U) && (schedule->mountings[n].bolting == bolting));
    }
    return earlier;
}

/* Mounting by mounting, so that no number has to be kept for each. */
static double uncertainty_of(gains_t *gains)
{
    const tumble_schedule_t *schedule = gains->run->schedule;
    response_t response = {0};
    if (gains->kind == INCLINED) {
        solve_inclined(gains);
    }
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        bolted_t bolted = {0};
        for (uint8_t n = m; (n < schedule->mounting_count) && !is_bolted_on(schedule, m); n++) {
            const uint8_t bolting = schedule->mountings[n].bolting;
            if ((n == m) || ((bolting > 0U) && (bolting == schedule->mountings[m].bolting))) {
                add_mounting(gains, &schedule->mountings[n], &response, &bolted);
            }
        }
        close_bolting(&bolted, &response);
    }
    return combined(gains->run->stand, &response);
}

static bool is_wanted(const gains_t *gains)
{
    const int coefficient = (gains->unknown == BIAS) ? ((TUMBLE_CHANNELS * TUMBLE_CHANNELS) + gains->channel)
                                                     : ((TUMBLE_CHANNELS * gains->channel) + gains->unknown);
    const uint32_t bit = UINT32_C(1) << (uint32_t)coefficient;
    return (gains->run->only == 0U) || ((gains->run->only & bit) != 0U);
}

/* One unknown of each channel; the column of N^-1 is the same for all three. Infinities and NaN add up in `check`. */
static void judge_unknown(gains_t *gains, tumble_uncertainty_t *uncertainty, double *check)
{
    bool solved = (gains->kind != LEAST_SQUARES);
    for (gains->channel = X; gains->channel <= Z; gains->channel++) {
        if (!is_wanted(gains)) {
            continue;
        }
        if (!solved) {
            solve_column(gains);
            solved = true;
        }
        const double u = uncertainty_of(gains);
        *((gains->unknown == BIAS) ? &uncertainty->u0_v[gains->channel]
                                   : &uncertainty->k_v_per_g[gains->channel][gains->unknown]) = u;
        *check += u;
    }
}

/* The columns of K^-1 are the cross products of the rows of K over its determinant. */
static tumble_status_t judge_norm(gains_t *gains)
{
    const tumble_judged_run_t *run = gains->run;
    const double (*k)[TUMBLE_CHANNELS] = run->coefficients->k_v_per_g;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double column[3];
        tumble_cross(k[(i + 1) % 3], k[(i + 2) % 3], column);
        gains->by_channel[i] = tumble_dot(run->attitude, column) / tumble_dot(k[i], column);
    }
    if (gains->kind == LEAST_SQUARES) {
        solve_column(gains);
    }
    *run->norm_g = uncertainty_of(gains);
    return tumble_is_finite(*run->norm_g) ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
}

/* All that are wanted, one after the other. */
static tumble_status_t judge(gains_t *gains, tumble_uncertainty_t *uncertainty)
{
    if (gains->run->attitude != NULL) {
        return judge_norm(gains);
    }
    double check = 0.0;
    for (gains->unknown = X; gains->unknown <= BIAS; gains->unknown++) {
        judge_unknown(gains, uncertainty, &check);
    }
    if (!tumble_is_finite(check)) {
        *uncertainty = (tumble_uncertainty_t){0};
        return TUMBLE_E_NOT_FINITE;
    }
    return TUMBLE_OK;
}

static tumble_status_t check_arguments(const tumble_judged_run_t *run, const tumble_uncertainty_t *uncertainty)
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

static tumble_status_t judge_harmonic(kind_t kind, const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                      tumble_refusal_t *refusal)
{
    tumble_status_t status = check_arguments(run, uncertainty);
    tumble_harmonic_map_t map;
    uint8_t slots[TUMBLE_MAX_POSITIONS] = {0};
    gains_t gains = {.run = run, .kind = kind, .map = &map, .slots = slots};
    uint64_t missing = 0;
    if (status == TUMBLE_OK) {
        status = tumble_schedule_harmonic(run->schedule, run->measured, &map, &missing);
    }
    report(refusal, missing, 0);
    if (status == TUMBLE_OK) {
        find_slots(&map, slots);
        status = judge(&gains, uncertainty);
    }
    return status;
}

tumble_status_t tumble_uncertainty_averaged(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                            tumble_refusal_t *refusal)
{
    return judge_harmonic(AVERAGED, run, uncertainty, refusal);
}

tumble_status_t tumble_uncertainty_refined(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                           tumble_refusal_t *refusal)
{
    return judge_harmonic(REFINED, run, uncertainty, refusal);
}

/* Not inlined: else a matrix lies on the stack below the other estimators' judges, too. */
TUMBLE_ONE_COPY tumble_status_t tumble_uncertainty_least_squares(const tumble_judged_run_t *run,
                                                                 tumble_uncertainty_t *uncertainty,
                                                                 tumble_refusal_t *refusal)
{
    const tumble_status_t status = check_arguments(run, uncertainty);
    report(refusal, 0, 0);
    if (status != TUMBLE_OK) {
        return status;
    }
    least_squares_t least_squares;
    gains_t gains = {.run = run, .kind = LEAST_SQUARES, .least_squares = &least_squares};
    tumble_normal_build(&least_squares.normal, run->schedule, run->measured);
    const uint8_t unidentified = tumble_normal_unidentified(&least_squares.normal);
    report(refusal, 0, unidentified);
    return (unidentified == 0U) ? judge(&gains, uncertainty) : TUMBLE_E_RANK;
}

/* Not inlined, as above. */
TUMBLE_ONE_COPY tumble_status_t tumble_uncertainty_inclined(const tumble_judged_run_t *run,
                                                            tumble_uncertainty_t *uncertainty,
                                                            tumble_refusal_t *refusal)
{
    tumble_status_t status = check_arguments(run, uncertainty);
    inclined_t inclined;
    gains_t gains = {.run = run, .kind = INCLINED, .inclined = &inclined};
    uint64_t missing = 0;
    if (status == TUMBLE_OK) {
        status = tumble_schedule_inclinations(run->schedule, run->measured, &inclined.map, &missing);
    }
    report(refusal, missing, 0);
    if (status == TUMBLE_OK) {
        status =
            tumble_inclined_again(&inclined.map, run->coefficients, run->inclinations, run->weights, &inclined.run);
    }
    return (status == TUMBLE_OK) ? judge(&gains, uncertainty) : status;
}

tumble_status_t tumble_inclined_uncertainty(const void *source, const tumble_judged_run_t *run,
                                            tumble_uncertainty_t *uncertainty)
{
    const tumble_inclined_source_t *from = source;
    if ((from == NULL) || (from->seen == NULL) || (run == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_judged_run_t judged = *run;
    judged.inclinations = from->seen;
    judged.weights = from->weights;
    return tumble_uncertainty_inclined(&judged, uncertainty, NULL);
}

static bool every_fit_position_is_measured(const tumble_judged_run_t *run)
{
    bool measured = true;
    for (uint8_t p = 0; (run->measured != NULL) && (p < run->schedule->position_count); p++) {
        measured = measured && (run->measured[p] || (run->schedule->positions[p].use != TUMBLE_USE_FIT));
    }
    return measured;
}

tumble_status_t tumble_uncertainty_gains(const tumble_gain_table_t *table, const tumble_judged_run_t *run,
                                         tumble_uncertainty_t *uncertainty)
{
    const tumble_status_t status = check_arguments(run, uncertainty);
    if ((status != TUMBLE_OK) || (table == NULL) || (table->gains == NULL)) {
        return (status != TUMBLE_OK) ? status : TUMBLE_E_ARGUMENT;
    }
    if (table->fit_positions != tumble_means_fit_positions(run->schedule)) {
        return TUMBLE_E_GAIN_TABLE;
    }
    if (!every_fit_position_is_measured(run)) {
        return TUMBLE_E_MISSING_POSITION;
    }
    gains_t gains = {.run = run, .kind = TABLE, .table = table};
    return judge(&gains, uncertainty);
}
