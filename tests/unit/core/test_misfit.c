/* The fit of a run: against plain elimination with dense weights, and what it must not see. */
#include "simulation/random.h"
#include "support.h"
#include "tumble/core.h"

#include <math.h>
#include <string.h>

#define V_PER_COUNT 1e-9 /* fine enough not to round what is asked for */
#define SAMPLES 16U
#define NONE 3

static tumble_averaging_t averaging;
static tumble_misfit_work_t work;
static tumble_coefficients_t block;
static tumble_stand_record_t stand;
static const tumble_schedule_t *schedule;
static sim_random_t noise;

static void set_up(void)
{
    static const tumble_coefficients_t usual = {{{2.01, 0.02, 0.01}, {0.03, 1.99, -0.02}, {0.01, 0.04, 2.0}},
                                                {0.03, 0.01, -0.02}};
    block = usual;
    memset(&averaging, 0, sizeof averaging);
    averaging.open.index = UINT8_MAX;
    stand = (tumble_stand_record_t){.angle_rad = 2e-4, .noise_v = 1e-4, .samples = 1};
    schedule = &tumble_schedule_paper;
    sim_random_open(&noise, 5, SIM_CAUSE_NOISE, 0);
}

/* The mean of a position, at a table angle, axis and yaw that are off. */
static void outputs(uint8_t p, double alpha1, double alpha2, double alpha3, double u_v[3])
{
    const tumble_position_t *const position = &schedule->positions[p];
    const tumble_mounting_t *const mounting = tumble_schedule_mounting_of(schedule, p);
    const double phi = position->angle.deg * 3.14159265358979323846 / 180.0 + alpha2;
    const double tilt = atan2(mounting->tilt.sine, mounting->tilt.cosine) + alpha1;
    const double f[3] = {cos(tilt) * sin(phi), sin(tilt), cos(tilt) * cos(phi)};
    const double turned[3] = {f[0] * cos(alpha3) + f[1] * sin(alpha3), f[1] * cos(alpha3) - f[0] * sin(alpha3), f[2]};
    for (int i = 0; i < 3; i++) {
        u_v[i] = block.u0_v[i];
        for (int j = 0; j < 3; j++) {
            for (int n = 0; n < 3; n++) {
                u_v[i] += block.k_v_per_g[i][j] * mounting->matrix[j][n] * turned[n];
            }
        }
    }
}

static void set_mean(uint8_t p, const double u_v[3])
{
    tumble_average_t *const average = &averaging.averages[p];
    average->samples = SAMPLES;
    for (int i = 0; i < 3; i++) {
        average->sum_counts[i] = (int64_t)llround(u_v[i] / V_PER_COUNT * SAMPLES);
    }
}

/* A run on this stand; `by` times its random errors. */
static void draw(double alpha1, double alpha2, double alpha3, double by)
{
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        double u_v[3];
        outputs(p, alpha1, alpha2 + by * stand.angle_rad * sim_random_normal(&noise),
                alpha3 * (double)schedule->positions[p].mounting, u_v);
        for (int i = 0; i < 3; i++) {
            u_v[i] += by * stand.noise_v / sqrt(SAMPLES) * sim_random_normal(&noise);
        }
        set_mean(p, u_v);
    }
}

static bool step(void)
{
    const tumble_misfit_run_t run = {schedule, &averaging, &block, &stand, V_PER_COUNT};
    return tumble_misfit_step(&work, &run);
}

static uint32_t judge(void)
{
    uint32_t steps = 1;
    memset(&work, 0xA5, sizeof work);
    tumble_misfit_begin(&work);
    while (step()) {
        steps++;
        TEST_ASSERT_LESS_THAN_UINT32(1000, steps);
    }
    return steps;
}

static bool fits(void)
{
    (void)judge();
    return !work.misfit;
}

/* Solve a x = b of n rows, with the largest pivot; a and b are lost. */
static void eliminate(long double a[9][9], long double b[9], int n)
{
    for (int c = 0; c < n; c++) {
        int pivot = c;
        for (int r = c; r < n; r++) {
            pivot = (fabsl(a[r][c]) > fabsl(a[pivot][c])) ? r : pivot;
        }
        for (int k = 0; k < n; k++) {
            const long double kept = a[c][k];
            a[c][k] = a[pivot][k];
            a[pivot][k] = kept;
        }
        const long double kept = b[c];
        b[c] = b[pivot];
        b[pivot] = kept;
        for (int r = 0; r < n; r++) {
            const long double factor = (r == c) ? 0.0L : a[r][c] / a[c][c];
            for (int k = c; k < n; k++) {
                a[r][k] -= factor * a[c][k];
            }
            b[r] -= factor * b[c];
        }
    }
    for (int c = 0; c < n; c++) {
        b[c] /= a[c][c];
    }
}

/* V^-1 of a position by elimination, without the share of a channel that is left out (0 to 2, or NONE). */
static void invert(uint8_t p, int left_out, long double inverse[3][3])
{
    const tumble_angle_t *const angle = &schedule->positions[p].angle;
    const tumble_mounting_t *const mounting = tumble_schedule_mounting_of(schedule, p);
    const double square = stand.angle_rad * stand.angle_rad;
    const double v = (1e-4 * 1e-4 + V_PER_COUNT * V_PER_COUNT / 12.0) / SAMPLES;
    const double second = square * square; /* times the square of the row's largest element */
    double d[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; (j < 3) && (i != left_out); j++) {
            d[i] +=
                block.k_v_per_g[i][j] * (mounting->matrix[j][0] * angle->cosine - mounting->matrix[j][2] * angle->sine);
        }
    }
    for (int column = 0; column < 3; column++) {
        long double a[9][9] = {{0.0L}};
        long double b[9] = {0.0L};
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                a[i][j] = (long double)square * d[i] * d[j] +
                          ((i == j) ? (long double)(v + second * pow(block.k_v_per_g[i][i], 2.0)) : 0.0L);
            }
        }
        b[column] = 1.0L;
        eliminate(a, b, 3);
        for (int i = 0; i < 3; i++) {
            inverse[i][column] = b[i];
        }
    }
}

/* The sum of squares that all three channels of a mounting leave, from the means themselves. */
static double expected_square(uint8_t mounting)
{
    long double a[9][9] = {{0.0L}};
    long double b[9] = {0.0L};
    long double right[9];
    long double square = 0.0L;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        long double weight[3][3];
        if (schedule->positions[p].mounting != mounting) {
            continue;
        }
        const double x[3] = {1.0, schedule->positions[p].angle.sine, schedule->positions[p].angle.cosine};
        invert(p, NONE, weight);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                const long double u = (long double)averaging.averages[p].sum_counts[j] * V_PER_COUNT / SAMPLES;
                square += (long double)averaging.averages[p].sum_counts[i] * V_PER_COUNT / SAMPLES * weight[i][j] * u;
                for (int k = 0; k < 3; k++) {
                    b[3 * i + k] += x[k] * weight[i][j] * u;
                    for (int l = 0; l < 3; l++) {
                        a[3 * i + k][3 * j + l] += x[k] * weight[i][j] * x[l];
                    }
                }
            }
        }
    }
    memcpy(right, b, sizeof right);
    eliminate(a, b, 9);
    for (int k = 0; k < 9; k++) {
        square -= b[k] * right[k];
    }
    return (double)square;
}

/* The last mounting's sum is what the work still holds. On a coarse stand the largest K of a row counts: it is on the
 * diagonal. */
static void test_the_sum_is_that_of_plain_elimination(void)
{
    for (int runs = 0; runs < 50; runs++) {
        stand.angle_rad = (runs < 25) ? 2e-4 : 5e-3;
        draw(1e-4, 2e-4, 3e-4, 1.0);
        (void)judge();
        const double expected = expected_square(2);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * expected, expected, work.all_square);
        TEST_ASSERT_EQUAL_UINT8(18, work.all_freedom);
    }
}

/* The sum of a mounting before it is fitted. A channel that is left out must not change how the others weigh. */
static void test_a_channel_that_is_left_out_has_no_weight(void)
{
    draw(1e-4, 2e-4, 3e-4, 1.0);
    tumble_misfit_begin(&work);
    for (int left_out = 0; left_out < 3; left_out++) {
        long double expected = 0.0L;
        for (uint8_t p = 0; p < 9U; p++) {
            double u_v[3];
            long double weight[3][3];
            outputs(p, 0.0, 0.0, 0.0, u_v);
            invert(p, left_out, weight);
            for (int k = 0; k < 9; k++) {
                const int i = k / 3;
                const int j = k % 3;
                const int64_t *const sums = averaging.averages[p].sum_counts;
                const long double product = ((long double)sums[i] * V_PER_COUNT / SAMPLES - u_v[i]) *
                                            ((long double)sums[j] * V_PER_COUNT / SAMPLES - u_v[j]);
                expected += ((i == left_out) || (j == left_out)) ? 0.0L : weight[i][j] * product;
            }
        }
        while ((work.test != (uint8_t)(left_out + 1)) || (work.position < 9U)) {
            TEST_ASSERT_TRUE(step());
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * (double)expected, (double)expected, work.square);
    }
}

/* From tables; Wilson and Hilferty are a little above. */
static void test_the_limit_is_the_quantile(void)
{
    static const struct {
        int freedom;
        double quantile;
        double above;
    } known[] = {{1, 17.315, 0.092}, {4, 25.998, 0.035}, {6, 30.493, 0.024}, {18, 52.470, 0.008}, {99, 165.530, 0.001}};
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const double over = tumble_misfit_limit(known[i].freedom) / known[i].quantile - 1.0;
        TEST_ASSERT_TRUE((over >= 0.0) && (over <= known[i].above));
    }
}

/* However large: they are the same all around the circle. */
static void test_systematic_errors_of_the_stand_are_none_of_its_business(void)
{
    draw(0.1, 0.0, 0.0, 0.0);
    TEST_ASSERT_TRUE(fits());
    draw(0.0, 0.1, 0.0, 0.0);
    TEST_ASSERT_TRUE(fits());
    draw(0.01, -0.02, 0.05, 0.0);
    TEST_ASSERT_TRUE(fits());
    block.u0_v[1] += 0.1; /* nor is a wrong estimate */
    block.k_v_per_g[2][0] += 0.1;
    TEST_ASSERT_TRUE(fits());
    TEST_ASSERT_TRUE(work.all_square < 1.0);
}

/* An inclination that is 10 mrad off, on an axis that is out of level by 50, with a zero of its own: all of it is on the
 * circle. Honest runs fit, by what the schedule says of the inclinations; a mean that is off does not. */
static void test_inclinations_that_nobody_measured_are_none_either(void)
{
    schedule = &tumble_schedule_inclined;
    draw(0.06, 0.01, 0.01, 0.0);
    TEST_ASSERT_TRUE(fits());
    TEST_ASSERT_TRUE(work.all_square < 1e-3);
    unsigned misfits = 0;
    for (int runs = 0; runs < 4000; runs++) {
        draw((runs % 2 == 0) ? 0.06 : -0.06, 0.01, 0.01, 1.0);
        misfits += fits() ? 0U : 1U;
    }
    TEST_ASSERT_LESS_OR_EQUAL_UINT(4U, misfits);
    averaging.averages[12].sum_counts[1] += (int64_t)llround(5e-3 / V_PER_COUNT * SAMPLES);
    TEST_ASSERT_FALSE(fits());
}

/* Each channel and position, in steps that only the noise hides. */
static void test_a_single_mean_that_is_off_does_not_fit(void)
{
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        for (int i = 0; i < 3; i++) {
            double u_v[3];
            draw(0.0, 0.0, 0.0, 0.0);
            outputs(p, 0.0, 0.0, 0.0, u_v);
            u_v[i] += 1e-3;
            set_mean(p, u_v);
            const bool angle_explains =
                fits(); /* 1e-3 V are 2.5 standard deviations of an angle, where it moves the channel */
            outputs(p, 0.0, 0.0, 0.0, u_v);
            u_v[i] += 5e-3;
            set_mean(p, u_v);
            TEST_ASSERT_FALSE(fits());
            double clean[3];
            outputs(p, 0.0, 1e-3, 0.0, clean);
            const bool turns = fabs(clean[i] - (u_v[i] - 5e-3)) > 1e-4;
            TEST_ASSERT_TRUE(turns || !angle_explains);
        }
    }
}

static tumble_position_t few[8];

/* So many positions of each mounting, every 90 degrees. */
static void shorten(uint8_t each)
{
    static tumble_schedule_t short_schedule;
    for (uint8_t p = 0; p < (2U * each); p++) {
        few[p] = tumble_schedule_paper.positions[(p < each) ? (2U * p) : (9U + 2U * (p - each))];
    }
    short_schedule = (tumble_schedule_t){tumble_schedule_paper.mountings, few, 2, (uint8_t)(2U * each)};
    schedule = &short_schedule;
}

/* Four attitudes leave each channel one freedom: what is too much for that one is not for the three together. */
static void test_a_single_freedom_is_judged(void)
{
    static const double factors[] = {0.9, 1.1};
    shorten(4);
    for (size_t i = 0; i < COUNT_OF(factors); i++) {
        double off_v = 1e-3;
        for (int again = 0; again < 2; again++) {
            double u_v[3];
            draw(0.0, 0.0, 0.0, 0.0);
            outputs(4, 0.0, 0.0, 0.0, u_v);
            u_v[1] += off_v;
            set_mean(4, u_v);
            (void)judge();
            TEST_ASSERT_EQUAL_UINT8(3, work.all_freedom);
            off_v *= sqrt(factors[i] * tumble_misfit_limit(1) / work.all_square);
        }
        TEST_ASSERT_TRUE(work.all_square < tumble_misfit_limit(3));
        TEST_ASSERT_EQUAL(factors[i] > 1.0, work.misfit);
    }
}

static void test_a_position_that_was_not_measured_is_left_out(void)
{
    draw(0.0, 0.0, 0.0, 1.0);
    averaging.averages[12].samples = 0;
    TEST_ASSERT_TRUE(fits());
    TEST_ASSERT_EQUAL_UINT8(15, work.all_freedom);
}

static void test_a_mounting_with_three_attitudes_passes(void)
{
    shorten(3);
    draw(0.0, 0.0, 0.0, 1000.0);
    TEST_ASSERT_EQUAL_UINT32(2U * 4U * (3U + 1U), judge());
    TEST_ASSERT_FALSE(work.misfit);
    TEST_ASSERT_EQUAL_UINT8(0, work.all_freedom);
    for (uint8_t p = 0; p < 3U; p++) {
        few[p] = tumble_schedule_paper.positions[0]; /* one attitude, thrice: it must repeat itself */
    }
    draw(0.0, 0.0, 0.0, 1.0);
    TEST_ASSERT_TRUE(fits());
    draw(0.0, 0.0, 0.0, 1000.0);
    TEST_ASSERT_FALSE(fits());
}

static void test_a_number_that_is_none_does_not_fit(void)
{
    draw(0.0, 0.0, 0.0, 1.0);
    TEST_ASSERT_TRUE(fits());
    block.k_v_per_g[0][0] = NAN;
    TEST_ASSERT_FALSE(fits());
}

/* A channel with four times the outputs and the noise is judged as before: the first test, of all channels. */
static void test_each_channel_is_judged_by_its_own_noise(void)
{
    draw(0.0, 0.0, 0.0, 1.0);
    (void)judge();
    const double before = work.all_square;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        averaging.averages[p].sum_counts[2] *= 4;
    }
    for (int j = 0; j < 3; j++) {
        block.k_v_per_g[2][j] *= 4.0;
    }
    block.u0_v[2] *= 4.0;
    (void)judge();
    TEST_ASSERT_TRUE(fabs(work.all_square - before) > 0.1 * before);
    stand.channel_noise_v[2] = 4.0 * stand.noise_v;
    (void)judge();
    TEST_ASSERT_TRUE(fabs(work.all_square - before) <
                     1e-4 * before); /* second order is the row's, rounding the count's */
}
