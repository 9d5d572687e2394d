#include "core/inclined.h"

#include "core/arith.h"
#include "core/means.h"
#include "core/normal.h"
#include "core/vector.h"

#include <stddef.h>
#include <string.h>

#define ROTATION_TOLERANCE 1e-9
#define ANGLE_TOLERANCE 1e-9 /* of sums over a mounting's angles, as a share of their number */
#define LEAST_APART 1e-3     /* of the level parts at the two steepest inclinations, as a share of the largest output */

/* ---- What a schedule offers. ---- */

/* Are these angles such that a constant, their sines and their cosines do not mix? Then each part is a sum over the means.
 * So it is for three or more that divide a turn equally. */
static bool separates(const tumble_schedule_t *schedule, uint8_t mounting, uint8_t *count)
{
    double sums[5] = {0.0, 0.0, 0.0, 0.0, 0.0}; /* of sin, cos, sin cos, sin^2 - cos^2, 1 */
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const tumble_position_t *position = &schedule->positions[p];
        if ((position->mounting == mounting) && (position->use == TUMBLE_USE_FIT)) {
            const double sine = position->angle.sine;
            const double cosine = position->angle.cosine;
            const double terms[5] = {sine, cosine, sine * cosine, (sine * sine) - (cosine * cosine), 1.0};
            for (int i = 0; i < 5; i++) {
                sums[i] += terms[i];
            }
            (*count)++;
        }
    }
    bool separate = (*count >= 3U);
    for (int i = 0; i < 4; i++) {
        separate = separate && tumble_within(sums[i], ANGLE_TOLERANCE * sums[4]);
    }
    return separate;
}

static bool are_equal(const double one[3][3], const double other[3][3])
{
    bool equal = true;
    for (int i = 0; i < 9; i++) {
        equal = equal && tumble_within(one[i / 3][i % 3] - other[i / 3][i % 3], ROTATION_TOLERANCE);
    }
    return equal;
}

static double tilt_of(const tumble_schedule_t *schedule, uint8_t m)
{
    return schedule->mountings[m].tilt.sine;
}

/* All inclinations of one bolting that positions are fitted at, in the schedule's order, and which is the steepest either
 * way. */
tumble_status_t tumble_schedule_inclinations(const tumble_schedule_t *schedule, const bool *measured,
                                             tumble_inclined_map_t *map, uint64_t *missing)
{
    if ((schedule == NULL) || (map == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    bool fits = true;
    uint64_t lacking = 0;
    *map = (tumble_inclined_map_t){.schedule = schedule};
    for (uint8_t m = 0; (m < schedule->mounting_count) && fits; m++) {
        const tumble_mounting_t *mounting = &schedule->mountings[m];
        uint8_t positions = 0;
        const bool separate = separates(schedule, mounting->number, &positions);
        if (positions > 0U) {
            const tumble_mounting_t *first = (map->count > 0U) ? &schedule->mountings[map->mounting[0]] : mounting;
            fits = separate && (map->count < TUMBLE_MAX_YAWS) && (mounting->bolting > 0U) &&
                   (mounting->bolting == first->bolting) && are_equal(mounting->matrix, first->matrix) &&
                   tumble_is_positive(mounting->tilt.cosine);
        }
        if ((positions > 0U) && fits) {
            map->mounting[map->count] = m;
            map->positions[map->count] = positions;
            map->highest = tumble_exceeds(mounting->tilt.sine, tilt_of(schedule, map->mounting[map->highest]))
                               ? map->count
                               : map->highest;
            map->lowest = tumble_exceeds(tilt_of(schedule, map->mounting[map->lowest]), mounting->tilt.sine)
                              ? map->count
                              : map->lowest;
            map->count++;
        }
    }
    for (uint8_t p = 0; (measured != NULL) && (p < schedule->position_count); p++) {
        if (!measured[p] && (schedule->positions[p].use == TUMBLE_USE_FIT)) {
            lacking |= UINT64_C(1) << p;
        }
    }
    fits = fits && (map->count >= 3U) && tumble_is_positive(tilt_of(schedule, map->mounting[map->highest])) &&
           tumble_is_positive(-tilt_of(schedule, map->mounting[map->lowest]));
    if (missing != NULL) {
        *missing = fits ? lacking : 0U;
    }
    if (!fits) {
        return TUMBLE_E_NOT_INCLINED;
    }
    return (lacking == 0U) ? TUMBLE_OK : TUMBLE_E_MISSING_POSITION;
}

/* ---- The closed form. ---- */

/* Of n angles that divide a turn equally: s = 2/n sum U sin p, c = 2/n sum U cos p, b = 1/n sum U, as in formula (3). */
static void find_harmonics(const tumble_inclined_map_t *map, const tumble_means_t *means, tumble_harmonics_t found)
{
    const tumble_schedule_t *schedule = map->schedule;
    for (uint8_t k = 0; k < map->count; k++) {
        double sums[TUMBLE_HARMONICS][TUMBLE_CHANNELS] = {0};
        const uint8_t number = schedule->mountings[map->mounting[k]].number;
        for (uint8_t p = 0; p < schedule->position_count; p++) {
            const tumble_position_t *position = &schedule->positions[p];
            if ((position->mounting == number) && (position->use == TUMBLE_USE_FIT)) {
                for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                    const double u = means->u_v[p][i];
                    sums[TUMBLE_SINE][i] += 2.0 * u * position->angle.sine;
                    sums[TUMBLE_COSINE][i] += 2.0 * u * position->angle.cosine;
                    sums[TUMBLE_LEVEL][i] += u;
                }
            }
        }
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            for (int part = 0; part < TUMBLE_HARMONICS; part++) {
                found[k][part][i] = sums[part][i] / (double)map->positions[k];
            }
        }
    }
}

/* The weights of the channels such that what turns is at most 1: no square of it overflows, whatever the offsets. */
static void find_weights(const tumble_inclined_map_t *map, const double weights[TUMBLE_CHANNELS],
                         tumble_inclined_t *run)
{
    double largest = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        run->weight[i] = (weights == NULL) ? 1.0 : weights[i];
        for (uint8_t k = 0; k < map->count; k++) {
            for (int part = 0; part < TUMBLE_LEVEL; part++) {
                largest = tumble_larger(largest, tumble_abs(run->weight[i] * run->harmonics[k][part][i]));
            }
        }
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        run->weight[i] = tumble_is_positive(largest) ? (run->weight[i] / largest) : 0.0;
    }
}

/* How far a level part has moved since the first inclination: beside an offset of thousands of g little else is left. */
static double moved(const tumble_inclined_t *run, uint8_t k, int channel)
{
    return run->harmonics[k][TUMBLE_LEVEL][channel] - run->harmonics[0][TUMBLE_LEVEL][channel];
}

/* Where each inclination lies along the line that the level parts lie on: t_k = d . w b_k, less their mean; and how much
 * gravity is left across the axis there: A2_k = sum w^2 (s^2 + c^2) = A^2 cos^2 beta_k. */
static tumble_status_t find_places(const tumble_inclined_map_t *map, tumble_inclined_t *run)
{
    double mean = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        run->along[i] = run->weight[i] *
                        (run->harmonics[map->highest][TUMBLE_LEVEL][i] - run->harmonics[map->lowest][TUMBLE_LEVEL][i]);
    }
    run->apart = tumble_sqrt(tumble_dot(run->along, run->along));
    if (!tumble_exceeds(run->apart, LEAST_APART)) {
        return TUMBLE_E_ALIKE;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        run->along[i] /= run->apart;
    }
    for (uint8_t k = 0; k < map->count; k++) {
        double place = 0.0;
        double square = 0.0;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            place += run->along[i] * (run->weight[i] * moved(run, k, i));
            square += tumble_square(run->weight[i] * run->harmonics[k][TUMBLE_SINE][i]) +
                      tumble_square(run->weight[i] * run->harmonics[k][TUMBLE_COSINE][i]);
        }
        run->place[k] = place;
        run->square[k] = square;
        mean += place / (double)map->count;
    }
    for (uint8_t k = 0; k < map->count; k++) {
        run->place[k] -= mean;
    }
    return TUMBLE_OK;
}

/* The parabola A2 = p + q t + r t^2 through three points, by least squares through more: its bend is what t^2 has beside a
 * line. At its vertex the axis is level: there A^2 = p - q^2 / (4 r), and with sin beta = 0 at the vertex and
 * A2 = A^2 (1 - sin^2 beta), sin beta_k = sqrt(-r / A^2) (t_k + q / (2 r)). */
static tumble_status_t find_inclinations(const tumble_inclined_map_t *map, tumble_inclined_t *run)
{
    const double count = (double)map->count;
    double cubes = 0.0;
    double mean = 0.0;
    double linear = 0.0;
    double bent = 0.0;
    run->places_squared = 0.0;
    run->bends_squared = 0.0;
    for (uint8_t k = 0; k < map->count; k++) {
        const double t = run->place[k];
        run->places_squared += t * t;
        cubes += t * t * t;
        linear += t * run->square[k];
        mean += run->square[k] / count;
    }
    run->skew = cubes / run->places_squared;
    run->spread = run->places_squared / count;
    for (uint8_t k = 0; k < map->count; k++) {
        const double t = run->place[k];
        run->bend[k] = (t * t) - (run->skew * t) - run->spread;
        run->bends_squared += tumble_square(run->bend[k]);
        bent += run->bend[k] * run->square[k];
    }
    run->r = tumble_is_positive(run->bends_squared) ? (bent / run->bends_squared) : 0.0;
    if (!tumble_is_positive(-run->r)) {
        return TUMBLE_E_ALIKE; /* no three different ones, or no parabola that is open downwards */
    }
    run->q = (linear / run->places_squared) - (run->r * run->skew);
    run->vertex = (mean - (run->r * run->spread)) - (tumble_square(run->q) / (4.0 * run->r));
    if (!tumble_is_positive(run->vertex)) {
        return TUMBLE_E_ALIKE;
    }
    run->slope = tumble_sqrt(-run->r / run->vertex);
    run->middle = run->slope * (run->q / (2.0 * run->r));
    for (uint8_t k = 0; k < map->count; k++) {
        run->seen.sine[k] = (run->slope * run->place[k]) + run->middle;
        if (!tumble_is_positive(1.0 - tumble_square(run->seen.sine[k]))) {
            return TUMBLE_E_ALIKE;
        }
        run->seen.cosine[k] = tumble_sqrt(1.0 - tumble_square(run->seen.sine[k]));
    }
    const bool both =
        tumble_is_positive(run->seen.sine[map->highest]) && tumble_is_positive(-run->seen.sine[map->lowest]);
    return both ? TUMBLE_OK : TUMBLE_E_ONE_SIDE;
}

/* K_in and U0_i: the line of the level parts over sin beta_k. */
static void find_axial(const tumble_inclined_map_t *map, tumble_inclined_t *run)
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double sum = 0.0;
        double mean = 0.0;
        for (uint8_t k = 0; k < map->count; k++) {
            sum += run->place[k] * moved(run, k, i);
            mean += run->harmonics[k][TUMBLE_LEVEL][i] / (double)map->count;
        }
        run->column[1][i] = sum / (run->slope * run->places_squared);
        run->bias[i] = mean - (run->column[1][i] * run->middle);
    }
}

/* K_ih and K_iv: the means of (s_ik, c_ik) / cos beta_k, each turned by the zero tau_k of its table angle onto the first:
 * tan tau_k = sum w^2 (v_k h_0 - h_k v_0) / sum w^2 (h_k h_0 + v_k v_0). */
static tumble_status_t find_transverse(const tumble_inclined_map_t *map, tumble_inclined_t *run)
{
    const double (*first)[TUMBLE_CHANNELS] = (const double (*)[TUMBLE_CHANNELS])run->harmonics[0];
    (void)memset(run->column[0], 0, sizeof run->column[0]);
    (void)memset(run->column[2], 0, sizeof run->column[2]);
    for (uint8_t k = 0; k < map->count; k++) {
        const double (*harmonic)[TUMBLE_CHANNELS] = (const double (*)[TUMBLE_CHANNELS])run->harmonics[k];
        double along = 0.0;
        double across = 0.0;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const double weight = tumble_square(run->weight[i]);
            along += weight * ((harmonic[TUMBLE_SINE][i] * first[TUMBLE_SINE][i]) +
                               (harmonic[TUMBLE_COSINE][i] * first[TUMBLE_COSINE][i]));
            across += weight * ((harmonic[TUMBLE_COSINE][i] * first[TUMBLE_SINE][i]) -
                                (harmonic[TUMBLE_SINE][i] * first[TUMBLE_COSINE][i]));
        }
        const double length = tumble_sqrt(tumble_square(along) + tumble_square(across));
        if (!tumble_is_positive(length)) {
            return TUMBLE_E_ALIKE;
        }
        run->length[k] = length;
        run->seen.turn_cosine[k] = along / length;
        run->seen.turn_sine[k] = across / length;
        const double share = 1.0 / (run->seen.cosine[k] * (double)map->count);
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            run->column[0][i] += share * ((run->seen.turn_cosine[k] * harmonic[TUMBLE_SINE][i]) +
                                          (run->seen.turn_sine[k] * harmonic[TUMBLE_COSINE][i]));
            run->column[2][i] += share * ((run->seen.turn_cosine[k] * harmonic[TUMBLE_COSINE][i]) -
                                          (run->seen.turn_sine[k] * harmonic[TUMBLE_SINE][i]));
        }
    }
    return TUMBLE_OK;
}

/* From the harmonics on. */
static tumble_status_t solve(const tumble_inclined_map_t *map, const double weights[TUMBLE_CHANNELS],
                             tumble_inclined_t *run)
{
    find_weights(map, weights, run);
    tumble_status_t status = find_places(map, run);
    if (status == TUMBLE_OK) {
        status = find_inclinations(map, run);
    }
    if (status == TUMBLE_OK) {
        find_axial(map, run);
        status = find_transverse(map, run);
    }
    return status;
}

tumble_status_t tumble_inclined_solve(const tumble_inclined_map_t *map, const tumble_means_t *means,
                                      const double weights[TUMBLE_CHANNELS], tumble_inclined_t *run)
{
    find_harmonics(map, means, run->harmonics);
    return solve(map, weights, run);
}

/* s = cos beta (K_h cos tau - K_v sin tau), c = cos beta (K_h sin tau + K_v cos tau), b = U0 + K_n sin beta. */
tumble_status_t tumble_inclined_again(const tumble_inclined_map_t *map, const tumble_coefficients_t *coefficients,
                                      const tumble_inclinations_t *inclinations, const double weights[TUMBLE_CHANNELS],
                                      tumble_inclined_t *run)
{
    const tumble_mounting_t *mountings = map->schedule->mountings;
    const double (*matrix)[3] = mountings[map->mounting[0]].matrix;
    for (uint8_t k = 0; k < map->count; k++) {
        const tumble_angle_t *tilt = &mountings[map->mounting[k]].tilt;
        const double sine = (inclinations != NULL) ? inclinations->sine[k] : tilt->sine;
        const double cosine = (inclinations != NULL) ? inclinations->cosine[k] : tilt->cosine;
        const double turn_sine = (inclinations != NULL) ? inclinations->turn_sine[k] : 0.0;
        const double turn_cosine = (inclinations != NULL) ? inclinations->turn_cosine[k] : 1.0;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            double column[3] = {0.0, 0.0, 0.0};
            for (int n = 0; n < 9; n++) {
                column[n % 3] += coefficients->k_v_per_g[i][n / 3] * matrix[n / 3][n % 3];
            }
            run->harmonics[k][TUMBLE_SINE][i] = cosine * ((column[0] * turn_cosine) - (column[2] * turn_sine));
            run->harmonics[k][TUMBLE_COSINE][i] = cosine * ((column[0] * turn_sine) + (column[2] * turn_cosine));
            run->harmonics[k][TUMBLE_LEVEL][i] = coefficients->u0_v[i] + (column[1] * sine);
        }
    }
    return solve(map, weights, run);
}

/* K M = (K_h, K_n, K_v), so K = (K_h, K_n, K_v) M^T. */
static void to_coefficients(const tumble_inclined_map_t *map, const tumble_inclined_t *run,
                            tumble_coefficients_t *coefficients)
{
    const double (*matrix)[3] = map->schedule->mountings[map->mounting[0]].matrix;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double row[3] = {run->column[0][i], run->column[1][i], run->column[2][i]};
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            coefficients->k_v_per_g[i][j] = tumble_dot(row, matrix[j]);
        }
        coefficients->u0_v[i] = run->bias[i];
    }
}

static bool are_weights(const double weights[TUMBLE_CHANNELS])
{
    bool valid = true;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        valid = valid && ((weights == NULL) || tumble_is_positive(weights[i]));
    }
    return valid;
}

tumble_status_t tumble_inclined_weighted(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                         const double weights[TUMBLE_CHANNELS], tumble_coefficients_t *coefficients,
                                         tumble_inclinations_t *seen, tumble_refusal_t *refusal)
{
    tumble_inclined_map_t map;
    tumble_inclined_t run;
    uint64_t missing = 0;
    tumble_status_t status = tumble_means_check(schedule, means, coefficients);
    if ((status == TUMBLE_OK) && !are_weights(weights)) {
        status = TUMBLE_E_ARGUMENT;
    }
    if (status == TUMBLE_OK) {
        status = tumble_schedule_inclinations(schedule, means->measured, &map, &missing);
    }
    if (refusal != NULL) {
        *refusal = (tumble_refusal_t){missing, 0};
    }
    if (status == TUMBLE_OK) {
        status = tumble_inclined_solve(&map, means, weights, &run);
    }
    if (status == TUMBLE_OK) {
        to_coefficients(&map, &run, coefficients);
        if (seen != NULL) {
            *seen = run.seen;
        }
    }
    return status;
}

tumble_status_t tumble_estimate_inclined(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                         tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    return tumble_inclined_weighted(schedule, means, NULL, coefficients, NULL, refusal);
}

/* ---- For a procedure that knows no inclinations. ---- */

tumble_status_t tumble_inclined_check(const void *source, const tumble_schedule_t *schedule)
{
    const tumble_inclined_source_t *from = source;
    tumble_inclined_map_t map;
    if ((from == NULL) || (from->seen == NULL) || !are_weights(from->weights)) {
        return TUMBLE_E_ARGUMENT;
    }
    return tumble_schedule_inclinations(schedule, NULL, &map, NULL);
}

tumble_status_t tumble_inclined_estimate(const void *source, const tumble_schedule_t *schedule,
                                         const tumble_means_t *means, tumble_coefficients_t *coefficients)
{
    const tumble_inclined_source_t *from = source;
    if ((from == NULL) || (from->seen == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    return tumble_inclined_weighted(schedule, means, from->weights, coefficients, from->seen, NULL);
}

/* ---- The same backwards: what a unit of each number adds to a weighed sum of coefficients. ---- */

/* Of find_transverse. What a turn adds is one number, its tangent: the length of the two sums does not matter. */
static void transverse_backwards(const tumble_inclined_map_t *map, const tumble_inclined_t *run,
                                 const double seed[4][TUMBLE_CHANNELS], double sine[TUMBLE_MAX_YAWS],
                                 tumble_harmonics_t gains)
{
    const double (*first)[TUMBLE_CHANNELS] = run->harmonics[0];
    for (uint8_t k = 0; k < map->count; k++) {
        const double (*harmonic)[TUMBLE_CHANNELS] = run->harmonics[k];
        const double cosine = run->seen.turn_cosine[k];
        const double turned = run->seen.turn_sine[k];
        const double share = 1.0 / (run->seen.cosine[k] * (double)map->count);
        double stretch = 0.0; /* of both columns with 1 / cos beta_k */
        double turning = 0.0; /* of both with the angle */
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const double s = harmonic[TUMBLE_SINE][i];
            const double c = harmonic[TUMBLE_COSINE][i];
            const double h = share * ((cosine * s) + (turned * c));
            const double v = share * ((cosine * c) - (turned * s));
            gains[k][TUMBLE_SINE][i] += share * ((cosine * seed[0][i]) - (turned * seed[2][i]));
            gains[k][TUMBLE_COSINE][i] += share * ((turned * seed[0][i]) + (cosine * seed[2][i]));
            stretch += (h * seed[0][i]) + (v * seed[2][i]);
            turning += (v * seed[0][i]) - (h * seed[2][i]);
        }
        sine[k] += stretch * (run->seen.sine[k] / tumble_square(run->seen.cosine[k]));
        turning /= run->length[k];
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const double weight = turning * tumble_square(run->weight[i]);
            /* across cosine - along turned, by each of its four numbers */
            gains[k][TUMBLE_COSINE][i] +=
                weight * ((cosine * first[TUMBLE_SINE][i]) - (turned * first[TUMBLE_COSINE][i]));
            gains[k][TUMBLE_SINE][i] -=
                weight * ((cosine * first[TUMBLE_COSINE][i]) + (turned * first[TUMBLE_SINE][i]));
            gains[0][TUMBLE_SINE][i] +=
                weight * ((cosine * harmonic[TUMBLE_COSINE][i]) - (turned * harmonic[TUMBLE_SINE][i]));
            gains[0][TUMBLE_COSINE][i] -=
                weight * ((cosine * harmonic[TUMBLE_SINE][i]) + (turned * harmonic[TUMBLE_COSINE][i]));
        }
    }
}

/* What the numbers of the parabola add. */
typedef struct {
    double place[TUMBLE_MAX_YAWS];
    double square[TUMBLE_MAX_YAWS];
    double slope;
    double middle;
    double places_squared;
} added_t;

/* Of find_axial. */
static void axial_backwards(const tumble_inclined_map_t *map, const tumble_inclined_t *run,
                            const double seed[4][TUMBLE_CHANNELS], added_t *added, tumble_harmonics_t gains)
{
    const double scale = 1.0 / (run->slope * run->places_squared);
    double sum = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double axial = seed[1][i] - (seed[3][i] * run->middle);
        for (uint8_t k = 0; k < map->count; k++) {
            gains[k][TUMBLE_LEVEL][i] += (seed[3][i] / (double)map->count) + (run->place[k] * (axial * scale));
            added->place[k] += run->harmonics[k][TUMBLE_LEVEL][i] * (axial * scale);
        }
        added->middle -= seed[3][i] * run->column[1][i];
        sum += axial * run->column[1][i];
    }
    added->slope -= sum / run->slope;
    added->places_squared -= sum / run->places_squared;
}

/* Of find_inclinations. */
static void parabola_backwards(const tumble_inclined_map_t *map, const tumble_inclined_t *run,
                               const double sine[TUMBLE_MAX_YAWS], added_t *added)
{
    const double count = (double)map->count;
    for (uint8_t k = 0; k < map->count; k++) {
        added->place[k] += sine[k] * run->slope;
        added->slope += sine[k] * run->place[k];
        added->middle += sine[k];
    }
    added->slope += added->middle * (run->q / (2.0 * run->r));
    const double vertex = -added->slope * (run->slope / (2.0 * run->vertex));
    const double q = (added->middle * (run->slope / (2.0 * run->r))) - (vertex * (run->q / (2.0 * run->r)));
    const double r = ((added->slope * run->slope) - (2.0 * added->middle * run->middle)) / (2.0 * run->r) +
                     (vertex * tumble_square(run->q / (2.0 * run->r)));
    const double bent = (r - (q * run->skew) - (vertex * run->spread)) / run->bends_squared;
    double skew = -q * run->r;
    double spread = -vertex * run->r;
    const double linear = q / run->places_squared;
    for (uint8_t k = 0; k < map->count; k++) {
        const double bend = bent * (run->square[k] - (2.0 * run->r * run->bend[k]));
        added->square[k] += (vertex / count) + (bent * run->bend[k]) + (linear * run->place[k]);
        added->place[k] += (linear * run->square[k]) + (bend * ((2.0 * run->place[k]) - run->skew));
        skew -= bend * run->place[k];
        spread -= bend;
    }
    added->places_squared +=
        (spread / count) - (linear * (run->q + (run->r * run->skew))) - (skew * (run->skew / run->places_squared));
    for (uint8_t k = 0; k < map->count; k++) {
        added->place[k] += (3.0 * skew * tumble_square(run->place[k]) / run->places_squared) +
                           (2.0 * added->places_squared * run->place[k]);
    }
}

/* Of find_places. */
static void places_backwards(const tumble_inclined_map_t *map, const tumble_inclined_t *run, const added_t *added,
                             tumble_harmonics_t gains)
{
    double along[TUMBLE_CHANNELS] = {0};
    double mean = 0.0;
    for (uint8_t k = 0; k < map->count; k++) {
        mean += added->place[k] / (double)map->count;
    }
    for (uint8_t k = 0; k < map->count; k++) {
        const double place = added->place[k] - mean;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const double squared = 2.0 * added->square[k] * tumble_square(run->weight[i]);
            gains[k][TUMBLE_SINE][i] += squared * run->harmonics[k][TUMBLE_SINE][i];
            gains[k][TUMBLE_COSINE][i] += squared * run->harmonics[k][TUMBLE_COSINE][i];
            gains[k][TUMBLE_LEVEL][i] += place * run->weight[i] * run->along[i];
            along[i] += place * run->weight[i] * run->harmonics[k][TUMBLE_LEVEL][i];
        }
    }
    const double lengthwise = tumble_dot(along, run->along);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double turned = run->weight[i] * ((along[i] - (lengthwise * run->along[i])) / run->apart);
        gains[map->highest][TUMBLE_LEVEL][i] += turned;
        gains[map->lowest][TUMBLE_LEVEL][i] -= turned;
    }
}

void tumble_inclined_gains(const tumble_inclined_map_t *map, const tumble_inclined_t *run,
                           const double seed[4][TUMBLE_CHANNELS], const double sine_seed[TUMBLE_MAX_YAWS],
                           tumble_harmonics_t gains)
{
    double sine[TUMBLE_MAX_YAWS];
    added_t added = {0};
    (void)memcpy(sine, sine_seed, sizeof sine);
    (void)memset(gains, 0, sizeof(tumble_harmonics_t));
    transverse_backwards(map, run, seed, sine, gains);
    axial_backwards(map, run, seed, &added, gains);
    parabola_backwards(map, run, sine, &added);
    places_backwards(map, run, &added, gains);
}
