#include "tumble/core.h"

#include "core/arith.h"
#include "core/normal.h"
#include "core/triangle.h"

#include <stddef.h>

/* The unknowns of the fit: 12 coefficients channel by channel (K_ix, K_iy, K_iz, U0_i), then the angles. */
#define ALPHA1 TUMBLE_COEFFICIENTS
#define ALPHA3 (ALPHA1 + 1)
#define ALPHA2(work) ((work)->unknowns - 1)

#define TINY 1e-12          /* of a row: an entry below it is rounding */
#define INESTIMABLE 1e-6    /* of a combination: what the data do not determine */
#define SMALLEST_NOISE 1e-7 /* of a mean, relative to the largest element of K, so that all have weights */
#define BISECTIONS 44
#define LARGEST_ANGLE_SQUARE 1099511627776.0 /* 2^40, beyond any angle: there a search ends that finds nothing */
#define FREE (-1.0)                          /* for a variance of set angles without bound */

typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_means_t *means;
    const tumble_coefficients_t *coefficients;
    const tumble_random_errors_t *errors;
} run_t;

/* out = M (h, n, v) */
static void turn(const tumble_mounting_t *mounting, double h, double n, double v, double out[3])
{
    for (int i = 0; i < 3; i++) {
        const double *m = mounting->matrix[i];
        out[i] = (m[0] * h) + (m[1] * n) + (m[2] * v);
    }
}

/* What a position has to say, in units of scale_v: three equations, and the direction in which an error of the set
 * angle moves the outputs. */
typedef struct {
    double attitude[TUMBLE_CHANNELS];
    double by_alpha1[TUMBLE_CHANNELS];
    double by_alpha3[TUMBLE_CHANNELS];
    double by_angle[TUMBLE_CHANNELS];
    double residual[TUMBLE_CHANNELS];
    double variance;
    double angle_length; /* of by_angle; by_angle itself is made a unit vector */
    int yaw;
} place_t;

/* K times a change of the attitude, in units of scale_v. */
static void respond(const run_t *run, double scale_v, double a[TUMBLE_CHANNELS])
{
    const double by[3] = {a[0], a[1], a[2]};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double *k = run->coefficients->k_v_per_g[i];
        a[i] = ((k[0] * by[0]) + (k[1] * by[1]) + (k[2] * by[2])) / scale_v;
    }
}

static double noise_of(const run_t *run, double scale_v, uint8_t p)
{
    const double least = SMALLEST_NOISE * SMALLEST_NOISE;
    const double variance = run->errors->mean_variance_v2[p] / (scale_v * scale_v);
    return (variance > least) ? variance : least;
}

static void fill_place(const run_t *run, double scale_v, uint8_t p, place_t *place)
{
    const tumble_mounting_t *mounting = tumble_schedule_mounting_of(run->schedule, p);
    const tumble_angle_t *angle = &run->schedule->positions[p].angle;
    const tumble_angle_t *tilt = &mounting->tilt;
    tumble_schedule_attitude(run->schedule, p, place->attitude);
    turn(mounting, -tilt->sine * angle->sine, tilt->cosine, -tilt->sine * angle->cosine, place->by_alpha1);
    turn(mounting, tilt->sine, -tilt->cosine * angle->sine, 0.0, place->by_alpha3);
    turn(mounting, tilt->cosine * angle->cosine, 0.0, -tilt->cosine * angle->sine, place->by_angle);
    respond(run, scale_v, place->by_alpha1);
    respond(run, scale_v, place->by_alpha3);
    respond(run, scale_v, place->by_angle);
    tumble_residual(run->schedule, run->means, run->coefficients, p, place->residual);
    double square = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        place->residual[i] /= scale_v;
        square += place->by_angle[i] * place->by_angle[i];
    }
    place->angle_length = tumble_sqrt(square);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        place->by_angle[i] /= place->angle_length;
    }
    place->variance = noise_of(run, scale_v, p);
    place->yaw = ALPHA3 + (int)(mounting - run->schedule->mountings);
}

static double *triangle_row(tumble_fit_work_t *work, int j)
{
    return tumble_triangle_row(work->r, work->unknowns, j);
}

/* Turn work->row into the triangle; what is left of its right side is a residual. */
static void add_row(tumble_fit_work_t *work)
{
    tumble_triangle_turn(work->r, work->unknowns, work->row, 0, work->unknowns, TINY);
    work->residual_square += work->row[work->unknowns] * work->row[work->unknowns];
}

static void clear_row(tumble_fit_work_t *work)
{
    for (int j = 0; j <= work->unknowns; j++) {
        work->row[j] = 0.0;
    }
}

/* The row of outputs combined by `mix`, times `weight`. */
static void make_row(tumble_fit_work_t *work, const place_t *place, const double mix[TUMBLE_CHANNELS], double weight)
{
    double *row = work->row;
    clear_row(work);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double by = weight * mix[i];
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            row[(TUMBLE_UNKNOWNS * i) + j] = by * place->attitude[j];
        }
        row[(TUMBLE_UNKNOWNS * i) + TUMBLE_CHANNELS] = by;
        row[ALPHA1] += by * place->by_alpha1[i];
        row[place->yaw] += by * place->by_alpha3[i];
        row[ALPHA2(work)] += by * place->angle_length * place->by_angle[i];
        row[work->unknowns] += by * place->residual[i];
    }
}

/* Standard deviation of the smallest noise over that along the direction of the angle's error. */
static double weight_along(const tumble_fit_work_t *work, const place_t *place)
{
    const double along = work->angle_square * place->angle_length * place->angle_length;
    return tumble_sqrt(work->smallest_v2 / (place->variance + along));
}

/* Three whitened rows of rank two: the outputs less the part of them along the direction of the angle's error. */
static void add_across(tumble_fit_work_t *work, const place_t *place)
{
    const double across = tumble_sqrt(work->smallest_v2 / place->variance);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double mix[TUMBLE_CHANNELS];
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            mix[j] = ((i == j) ? 1.0 : 0.0) - (place->by_angle[i] * place->by_angle[j]);
        }
        make_row(work, place, mix, across);
        work->row[ALPHA2(work)] = 0.0; /* it turns the table too; rounding would count for more than a small weight */
        add_row(work);
    }
}

/* Size of the problem. False: there is nothing to fit, too many mountings, or K is not usable. */
static bool size_up(const run_t *run, tumble_fit_work_t *work)
{
    work->unknowns = (uint8_t)(TUMBLE_COEFFICIENTS + 2 + run->schedule->mounting_count);
    work->scale_v = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            const double size = tumble_abs(run->coefficients->k_v_per_g[i][j]);
            work->scale_v = (size > work->scale_v) ? size : work->scale_v;
        }
    }
    work->smallest_v2 = 0.0;
    for (uint8_t p = 0; (work->scale_v > 0.0) && (p < run->schedule->position_count); p++) {
        if (tumble_normal_uses(run->schedule, run->means->measured, p)) {
            const double variance = noise_of(run, work->scale_v, p);
            const bool first = (work->smallest_v2 == 0.0);
            work->smallest_v2 = (first || (variance < work->smallest_v2)) ? variance : work->smallest_v2;
        }
    }
    return (work->smallest_v2 > 0.0) && (run->schedule->mounting_count <= TUMBLE_MAX_YAWS);
}

/* The rows of all places, along or across the direction of the angle's error; returns by how much the sum of squares of
 * the whitened residuals grows. */
static double add_places(const run_t *run, tumble_fit_work_t *work, bool along)
{
    work->residual_square = 0.0;
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        if (tumble_normal_uses(run->schedule, run->means->measured, p)) {
            place_t place;
            fill_place(run, work->scale_v, p, &place);
            if (along) {
                make_row(work, &place, place.by_angle, weight_along(work, &place));
                add_row(work);
            } else {
                add_across(work, &place);
            }
        }
    }
    return work->residual_square / work->smallest_v2;
}

/* The triangle for one variance of set angles; FREE: they take whatever lies along them. Returns by how much the sum of
 * squares of the whitened residuals exceeds that for free angles: a sum of its own, for where the outputs fit badly the
 * two are large and nearly equal. */
static double factor(const run_t *run, tumble_fit_work_t *work, double angle_square)
{
    for (size_t i = 0; i < (sizeof work->r / sizeof work->r[0]); i++) {
        work->r[i] = 0.0;
    }
    (void)add_places(run, work, false);
    work->angle_square = angle_square;
    return (angle_square < 0.0) ? 0.0 : add_places(run, work, true);
}

static int rank_of(tumble_fit_work_t *work)
{
    int rank = 0;
    for (int j = 0; j < work->unknowns; j++) {
        rank += (triangle_row(work, j)[0] != 0.0) ? 1 : 0;
    }
    return rank;
}

/* The combination of unknowns in work->row becomes R^-T of it: its value is the product with the right sides, its
 * variance its own square, times smallest_v2. Not known where the data do not determine the combination. */
static tumble_seen_t combine(tumble_fit_work_t *work)
{
    tumble_seen_t seen = {.known = true};
    double square = 0.0;
    double *w = work->row;
    for (int j = 0; j < work->unknowns; j++) {
        const double *r = triangle_row(work, j);
        if (r[0] == 0.0) {
            seen.known = seen.known && tumble_within(w[j], INESTIMABLE);
            continue;
        }
        w[j] /= r[0];
        for (int k = j + 1; k < work->unknowns; k++) {
            w[k] -= w[j] * r[k - j];
        }
        seen.value += w[j] * r[work->unknowns - j];
        square += w[j] * w[j];
    }
    seen.u = tumble_sqrt(square * work->smallest_v2);
    return seen.known ? seen : (tumble_seen_t){0};
}

/* The yaws that the data have a say in, as unknowns, in the schedule's order. Returns how many. */
static uint8_t list_yaws(const run_t *run, uint8_t yaws[TUMBLE_MAX_YAWS])
{
    uint8_t count = 0;
    for (uint8_t m = 0; m < run->schedule->mounting_count; m++) {
        bool seen = false;
        for (uint8_t p = 0; p < run->schedule->position_count; p++) {
            seen = seen || (tumble_normal_uses(run->schedule, run->means->measured, p) &&
                            (run->schedule->positions[p].mounting == run->schedule->mountings[m].number));
        }
        yaws[count] = (uint8_t)(ALPHA3 + m);
        count = (uint8_t)(count + (seen ? 1U : 0U));
    }
    return count;
}

static bool is_valid(const run_t *run, const tumble_fit_work_t *work)
{
    return (run->schedule != NULL) && (run->means != NULL) && (run->coefficients != NULL) && (run->errors != NULL) &&
           (work != NULL);
}

tumble_status_t tumble_seen_fit(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                const tumble_coefficients_t *coefficients, const tumble_random_errors_t *errors,
                                tumble_fit_work_t *work, tumble_seen_angles_t *angles)
{
    const run_t run = {schedule, means, coefficients, errors};
    if (!is_valid(&run, work) || (angles == NULL) || !size_up(&run, work)) {
        return TUMBLE_E_ARGUMENT;
    }
    (void)factor(&run, work, errors->angle_rad * errors->angle_rad);
    uint8_t yaws[TUMBLE_MAX_YAWS];
    const uint8_t count = list_yaws(&run, yaws);
    clear_row(work);
    work->row[ALPHA1] = 1.0;
    angles->alpha1 = combine(work);
    clear_row(work);
    work->row[ALPHA2(work)] = 1.0;
    for (uint8_t i = 0; i < count; i++) {
        work->row[yaws[i]] = 1.0 / (double)count;
    }
    angles->alpha2_plus_alpha3 = combine(work);
    angles->alpha3_difference = (tumble_seen_t){0};
    if (count > 1U) {
        clear_row(work);
        work->row[yaws[0]] = 1.0;
        work->row[yaws[1]] = -1.0;
        angles->alpha3_difference = combine(work);
    }
    return TUMBLE_OK;
}

/* How many independent residuals errors of set angles move: with the angles free they are gone. */
static int angle_freedom(const run_t *run, tumble_fit_work_t *work)
{
    (void)factor(run, work, 0.0);
    int freedom = -rank_of(work);
    (void)factor(run, work, FREE);
    freedom += rank_of(work);
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        freedom += tumble_normal_uses(run->schedule, run->means->measured, p) ? 1 : 0;
    }
    return (freedom > 0) ? freedom : 0;
}

/* How fast the expected sum of squares falls with the variance of set angles: the trace of d d^T with the inverse of
 * the residuals' covariance. */
static double slope_of(const run_t *run, tumble_fit_work_t *work)
{
    double sum = 0.0;
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        if (tumble_normal_uses(run->schedule, run->means->measured, p)) {
            place_t place;
            fill_place(run, work->scale_v, p, &place);
            const double weight = weight_along(work, &place);
            make_row(work, &place, place.by_angle, weight);
            const double leverage = combine(work).u;
            const double length = weight * place.angle_length;
            sum += length * length * (1.0 - ((leverage * leverage) / work->smallest_v2)) / work->smallest_v2;
        }
    }
    return sum;
}

/* The variance of set angles at which the sum of squares is what it should be; 0 where there is no excess. */
static double solve_angle_square(const run_t *run, tumble_fit_work_t *work, double wanted)
{
    double low = 0.0;
    double high = work->smallest_v2;
    if (factor(run, work, 0.0) <= wanted) {
        return 0.0;
    }
    while ((high < LARGEST_ANGLE_SQUARE) && (factor(run, work, high) > wanted)) {
        low = high;
        high *= 4.0;
    }
    for (int i = 0; i < BISECTIONS; i++) {
        const double middle = 0.5 * (low + high);
        if (factor(run, work, middle) > wanted) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return 0.5 * (low + high);
}

tumble_status_t tumble_seen_angle_error(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                        const tumble_coefficients_t *coefficients, const tumble_random_errors_t *errors,
                                        tumble_fit_work_t *work, tumble_seen_t *alpha4, double *freedom)
{
    const run_t run = {schedule, means, coefficients, errors};
    if (!is_valid(&run, work) || (alpha4 == NULL) || (freedom == NULL) || !size_up(&run, work)) {
        return TUMBLE_E_ARGUMENT;
    }
    *alpha4 = (tumble_seen_t){0};
    *freedom = 0.0;
    const double moved = (double)angle_freedom(&run, work);
    const double square = (moved > 0.0) ? solve_angle_square(&run, work, moved) : 0.0;
    if (square > 0.0) {
        (void)factor(&run, work, square);
        const double signal = square * slope_of(&run, work);
        *freedom = (signal * signal) / moved;
        alpha4->known = true;
        alpha4->value = tumble_sqrt(square);
        alpha4->u = alpha4->value / tumble_sqrt(2.0 * *freedom);
    }
    return TUMBLE_OK;
}

tumble_status_t tumble_seen_angle_chi_squared(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                              const tumble_coefficients_t *coefficients,
                                              const tumble_random_errors_t *errors, tumble_fit_work_t *work,
                                              double *chi_squared, uint8_t *freedom)
{
    const run_t run = {schedule, means, coefficients, errors};
    if (!is_valid(&run, work) || (chi_squared == NULL) || (freedom == NULL) || !size_up(&run, work)) {
        return TUMBLE_E_ARGUMENT;
    }
    *freedom = (uint8_t)angle_freedom(&run, work);
    *chi_squared = factor(&run, work, errors->angle_rad * errors->angle_rad);
    return TUMBLE_OK;
}
