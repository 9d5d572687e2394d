#include "tumble/core.h"

#include "core/accumulator.h"
#include "core/arith.h"
#include "core/one_copy.h"
#include "core/stand_record.h"
#include "core/vector.h"

#include <stddef.h>

#define BASIS 3             /* 1, sin phi, cos phi */
#define RANK 1e-9           /* a pivot this small a part of its diagonal element is rounding: too few attitudes */
#define SMALLEST_NOISE 1e-7 /* of a mean, relative to the largest element of its row of K, so that all have weights */
#define ZERO_SQUARE 9e-4 /* (0.03 rad)^2: how far the zero of the table angle moves from one inclination to the next */
#define HALF_STEP 0.5    /* less noise than that, in counts: samples round alike */

/* A position as the fit sees it. */
typedef struct {
    double basis[BASIS];
    double residual_v[TUMBLE_CHANNELS];
    double by_angle_v[TUMBLE_CHANNELS]; /* per rad of the set angle; 0 for a channel that is left out */
    double weighted_v[TUMBLE_CHANNELS]; /* the same over the variance */
    double variance_v2[TUMBLE_CHANNELS];
} fitted_t;

double tumble_misfit_limit(int freedom)
{
    return tumble_chi_squared_limit((double)freedom, TUMBLE_MISFIT_SIGMAS);
}

static void reset_test(tumble_misfit_work_t *work)
{
    for (size_t i = 0; i < (sizeof work->triangle / sizeof work->triangle[0]); i++) {
        work->triangle[i] = 0.0;
    }
    for (int i = 0; i < TUMBLE_MISFIT_UNKNOWNS; i++) {
        work->right[i] = 0.0;
    }
    work->square = 0.0;
    work->counted = 0;
    work->position = 0;
}

void tumble_misfit_begin(tumble_misfit_work_t *work)
{
    work->mounting = 0;
    work->test = 0;
    work->misfit = false;
    reset_test(work);
}

static bool is_in(const tumble_misfit_work_t *work, int channel)
{
    return channel != ((int)work->test - 1);
}

/* Variance of an angle's error at one position, the encoder's included, as if it were drawn there anew. The test of the
 * whole model knows better; this one asks less of such a stand. */
static double angle_variance(const tumble_stand_record_t *stand)
{
    return tumble_square(stand->angle_rad) + (2.0 * tumble_square(stand->encoder_rad));
}

/* Variance of a mean: its noise, with the rounding of the converter. What an angle's error adds across `by_angle_v` is
 * added, which on a coarse stand exceeds the noise: by its second order, or by `across_square`, the square of the angle by
 * which `by_angle_v` may be turned. So is the mean square of a drift over the run. */
static double variance_of(const tumble_misfit_run_t *run, int i, uint32_t samples, double across_square)
{
    const double step_v = tumble_abs(run->v_per_count);
    const double noise_v = tumble_stand_noise_v(run->stand, i);
    const double rounding_v2 = tumble_square(step_v) / 12.0;
    const double n = (double)samples;
    const double scale_v = tumble_largest(run->coefficients->k_v_per_g[i]);
    double variance = tumble_exceeds(HALF_STEP * step_v, noise_v) ? ((tumble_square(noise_v) / n) + rounding_v2)
                                                                  : ((tumble_square(noise_v) + rounding_v2) / n);
    variance = tumble_larger(variance, tumble_square(run->stand->least_noise_v));
    variance = tumble_larger(variance, tumble_square(SMALLEST_NOISE * scale_v));
    variance += tumble_square(tumble_stand_drift_v(run->stand, i)) / 12.0;
    return variance + (across_square * angle_variance(run->stand) * tumble_square(scale_v));
}

/* Along the block's axes: a specific force given along h and v of the table. */
static void turn_to_block(const tumble_mounting_t *mounting, double h, double v, double along[TUMBLE_CHANNELS])
{
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        along[j] = (mounting->matrix[j][0] * h) + (mounting->matrix[j][2] * v);
    }
}

/* Where nobody measures the inclination, an error of a set angle counts as on a level axis, where the outputs feel it most,
 * and somewhat across: the zero of the table angle is not known either. */
static void fill_place(const tumble_misfit_work_t *work, const tumble_misfit_run_t *run, uint8_t p, fitted_t *place)
{
    const tumble_mounting_t *mounting = &run->schedule->mountings[work->mounting];
    const tumble_angle_t *angle = &run->schedule->positions[p].angle;
    const double sine = mounting->tilt.cosine * angle->sine;
    const double cosine = mounting->tilt.cosine * angle->cosine;
    const bool inclined = mounting->bolting > 0U;
    const double across_square = inclined ? ZERO_SQUARE : angle_variance(run->stand);
    const tumble_angle_t tilted = {0.0, sine, cosine};
    const tumble_angle_t *most = inclined ? angle : &tilted;
    double force[TUMBLE_CHANNELS];
    double by_angle[TUMBLE_CHANNELS];
    double mean_v[TUMBLE_CHANNELS];
    tumble_average_mean(&run->averaging->averages[p], mean_v, run->v_per_count);
    place->basis[0] = 1.0;
    place->basis[1] = angle->sine;
    place->basis[2] = angle->cosine;
    turn_to_block(mounting, sine, cosine, force);
    turn_to_block(mounting, most->cosine, -most->sine, by_angle);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double *k = run->coefficients->k_v_per_g[i];
        place->residual_v[i] = mean_v[i] - run->coefficients->u0_v[i] - tumble_dot(k, force);
        place->by_angle_v[i] = is_in(work, i) ? tumble_dot(k, by_angle) : 0.0;
        place->variance_v2[i] = variance_of(run, i, run->averaging->averages[p].samples, across_square);
        place->weighted_v[i] = place->by_angle_v[i] / place->variance_v2[i];
    }
}

/* V^-1 = diag(1 / v) - kappa w w^T with w_i = d_i / v_i, by Sherman and Morrison. */
static double weight(const fitted_t *place, double kappa, int i, int j)
{
    const double own = (i == j) ? (1.0 / place->variance_v2[i]) : 0.0;
    return own - (kappa * place->weighted_v[i] * place->weighted_v[j]);
}

/* Add the rows that channel `i` has in the normal equations. */
static void add_channel(tumble_misfit_work_t *work, const fitted_t *place, double kappa, int i)
{
    double weighted = 0.0; /* (V^-1 r)_i */
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        if (!is_in(work, j)) {
            continue;
        }
        const double w = weight(place, kappa, i, j);
        weighted += w * place->residual_v[j];
        for (int k = 0; (j <= i) && (k < BASIS); k++) {
            const int row = (BASIS * i) + k;
            double *to = &work->triangle[((row * (row + 1)) / 2) + (BASIS * j)];
            const int columns = (j == i) ? (k + 1) : BASIS;
            for (int l = 0; l < columns; l++) {
                to[l] += w * place->basis[k] * place->basis[l];
            }
        }
    }
    for (int k = 0; k < BASIS; k++) {
        work->right[(BASIS * i) + k] += weighted * place->basis[k];
    }
    work->square += weighted * place->residual_v[i];
    work->counted++;
}

static void add_position(tumble_misfit_work_t *work, const tumble_misfit_run_t *run, uint8_t p)
{
    fitted_t place;
    fill_place(work, run, p, &place);
    const double angle_square = angle_variance(run->stand);
    const double kappa = angle_square / (1.0 + (angle_square * tumble_dot(place.by_angle_v, place.weighted_v)));
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        if (is_in(work, i)) {
            add_channel(work, &place, kappa, i);
        }
    }
}

/* What is left of a number without the products of two rows so far. */
static double without_products(double number, const double *a, const double *b, int count)
{
    for (int k = 0; k < count; k++) {
        number -= a[k] * b[k];
    }
    return number;
}

/* Cholesky, row by row, with the right side carried along: what the fit explains leaves the sum of squares. An unknown
 * that the positions do not determine is left out. Returns how many are determined. */
static int solve(tumble_misfit_work_t *work)
{
    int rank = 0;
    for (int row = 0; row < TUMBLE_MISFIT_UNKNOWNS; row++) {
        double *r = &work->triangle[(row * (row + 1)) / 2];
        const double diagonal = r[row];
        for (int column = 0; column <= row; column++) {
            const double *c = &work->triangle[(column * (column + 1)) / 2];
            const double sum = without_products(r[column], r, c, column);
            if (column < row) {
                r[column] = tumble_exceeds(c[column], 0.0) ? (sum / c[column]) : 0.0;
            } else {
                r[row] = tumble_exceeds(sum, RANK * diagonal) ? tumble_sqrt(sum) : 0.0;
            }
        }
        const double right = without_products(work->right[row], r, work->right, row);
        work->right[row] = tumble_exceeds(r[row], 0.0) ? (right / r[row]) : 0.0;
        work->square -= tumble_square(work->right[row]);
        rank += tumble_exceeds(r[row], 0.0) ? 1 : 0;
    }
    return rank;
}

/* A sum that is no number does not fit either. */
static bool is_large(double chi_squared, int freedom)
{
    return (freedom > 0) && !tumble_within(chi_squared, tumble_misfit_limit(freedom));
}

/* False: that was the last test. */
TUMBLE_ONE_COPY static bool end_test(tumble_misfit_work_t *work, const tumble_misfit_run_t *run)
{
    const int freedom = (int)work->counted - solve(work);
    if (work->test == 0U) {
        work->all_square = work->square;
        work->all_freedom = (uint8_t)freedom;
        work->misfit = work->misfit || is_large(work->square, freedom);
    } else {
        work->misfit = work->misfit || is_large(work->all_square - work->square, (int)work->all_freedom - freedom);
    }
    work->test++;
    if (work->test == (uint8_t)TUMBLE_MISFIT_TESTS) {
        work->test = 0;
        work->mounting++;
    }
    reset_test(work);
    return work->mounting < run->schedule->mounting_count;
}

static bool belongs(const tumble_misfit_work_t *work, const tumble_misfit_run_t *run, uint8_t p)
{
    const uint8_t mounting = run->schedule->positions[p].mounting;
    return (mounting == run->schedule->mountings[work->mounting].number) && (run->averaging->averages[p].samples != 0U);
}

bool tumble_misfit_step(tumble_misfit_work_t *work, const tumble_misfit_run_t *run)
{
    while ((work->position < run->schedule->position_count) && !belongs(work, run, work->position)) {
        work->position++;
    }
    if (work->position == run->schedule->position_count) {
        return end_test(work, run);
    }
    add_position(work, run, work->position);
    work->position++;
    return true;
}
