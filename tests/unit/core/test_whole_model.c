/* The whole model: exact small cases. The witness and the statistics are tested from Python, on many runs. */
#include "support.h"
#include "tumble/core.h"

#include <math.h>

#define P 18
#define FREEDOM 42

static const tumble_coefficients_t block = {{{2.0, 0.04, -0.03}, {0.02, 1.9, 0.05}, {-0.01, 0.03, 2.1}},
                                            {0.1, -0.2, 0.05}};
static tumble_means_t means;
static double variance_v2[P];
static tumble_stand_record_t stand;
static tumble_whole_work_t work;
static double square;
static uint8_t freedom;

/* Outputs on an ideal stand, each off by at most `noise_v`. */
static void make_means(double noise_v)
{
    dice_t dice = {11};
    for (uint8_t p = 0; p < P; p++) {
        double a_g[3];
        tumble_schedule_attitude(&tumble_schedule_paper, p, a_g);
        for (int i = 0; i < 3; i++) {
            const double *k = block.k_v_per_g[i];
            means.u_v[p][i] = block.u0_v[i] + (k[0] * a_g[0]) + (k[1] * a_g[1]) + (k[2] * a_g[2]) +
                              (noise_v * dice_signed_unit(&dice));
        }
        means.measured[p] = true;
        variance_v2[p] = 1e-8;
    }
}

static void set_up(void)
{
    memset(&means, 0, sizeof means);
    memset(&work, 0xA5, sizeof work);
    stand = (tumble_stand_record_t){0};
    make_means(0.0);
}

static tumble_status_t look(void)
{
    const tumble_whole_run_t run = {&tumble_schedule_paper, &means, &stand, variance_v2, NULL};
    return tumble_whole_chi_squared(&run, &work, &square, &freedom);
}

static double least_squares_residuals(void)
{
    tumble_coefficients_t found;
    double sum = 0.0;
    ASSERT_STATUS(TUMBLE_OK, tumble_estimate_least_squares(&tumble_schedule_paper, &means, &found, NULL));
    for (uint8_t p = 0; p < P; p++) {
        double r[3];
        tumble_residual(&tumble_schedule_paper, &means, &found, p, r);
        sum += ((r[0] * r[0]) + (r[1] * r[1]) + (r[2] * r[2])) / variance_v2[p];
    }
    return sum;
}

static void test_an_ideal_run_leaves_nothing(void)
{
    stand = (tumble_stand_record_t){.axis_tilt_rad = 1e-4, .level_rad = 1e-3, .remount_rad = 1e-3, .angle_rad = 1e-4};
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_TRUE(square < 1e-16);
    TEST_ASSERT_EQUAL_UINT8(FREEDOM, freedom);
}

static void test_without_errors_of_the_stand_it_is_plain_least_squares(void)
{
    make_means(3e-4);
    ASSERT_STATUS(TUMBLE_OK, look());
    const double plain = least_squares_residuals();
    TEST_ASSERT_TRUE(plain > 10.0);
    TEST_ASSERT_TRUE(fabs(square - plain) < 1e-9 * plain);
}

static void test_half_the_variance_is_twice_the_square(void)
{
    make_means(3e-4);
    ASSERT_STATUS(TUMBLE_OK, look());
    const double before = square;
    for (int p = 0; p < P; p++) {
        variance_v2[p] /= 2.0;
    }
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_TRUE(fabs(square - (2.0 * before)) < 1e-9 * before);
}

static void test_whatever_the_stand_may_do_leaves_less(void)
{
    make_means(3e-4);
    ASSERT_STATUS(TUMBLE_OK, look());
    double before = square;
    double *const errors[] = {&stand.axis_tilt_rad, &stand.remount_rad, &stand.angle_rad};
    for (size_t i = 0; i < COUNT_OF(errors); i++) {
        *errors[i] = 1e-3;
        ASSERT_STATUS(TUMBLE_OK, look());
        TEST_ASSERT_TRUE(square < before);
        before = square;
    }
    TEST_ASSERT_EQUAL_UINT8(FREEDOM, freedom);
}

/* A common yaw turns K; two yaws are seen. */
static void test_a_common_yaw_leaves_all(void)
{
    make_means(3e-4);
    ASSERT_STATUS(TUMBLE_OK, look());
    const double before = square;
    stand.remount_rad = 1e-3;
    stand.level_rad = 0.0;
    ASSERT_STATUS(TUMBLE_OK, look());
    const double two = square;
    stand.common_yaw = true;
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_TRUE((two < square) && (square < before));
}

/* Two positions turned by as much as one may be: what is held there leaves a misfit, not a failure. */
static void test_errors_of_the_stand_are_held(void)
{
    stand.angle_rad = 0.5;
    for (int i = 0; i < 3; i++) {
        means.u_v[4][i] = means.u_v[2][i]; /* a quarter of a turn from where it should be */
    }
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_TRUE(square > 1e3);
    for (int p = 0; p < P; p++) {
        TEST_ASSERT_TRUE(fabsf(work.angle_rad[p]) <= (float)TUMBLE_MAX_STAND_ERROR_RAD);
    }
}

static void test_a_position_that_was_not_measured_is_left_out(void)
{
    make_means(3e-4);
    means.measured[7] = false;
    means.u_v[7][0] = NOT_A_NUMBER;
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_EQUAL_UINT8(FREEDOM - 3, freedom);
    TEST_ASSERT_TRUE(square > 0.0);
}

static void test_no_noise_at_all_is_a_little(void)
{
    make_means(3e-4);
    memset(variance_v2, 0, sizeof variance_v2);
    ASSERT_STATUS(TUMBLE_OK, look());
    TEST_ASSERT_TRUE((square > 1e6) && (square < 1e12));
}

static void test_refusals(void)
{
    const tumble_whole_run_t runs[] = {
        {NULL, &means, &stand, variance_v2, NULL},
        {&tumble_schedule_paper, NULL, &stand, variance_v2, NULL},
        {&tumble_schedule_paper, &means, NULL, variance_v2, NULL},
        {&tumble_schedule_paper, &means, &stand, NULL, NULL},
    };
    for (size_t i = 0; i < COUNT_OF(runs); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_whole_chi_squared(&runs[i], &work, &square, &freedom));
    }
    const tumble_whole_run_t run = {&tumble_schedule_paper, &means, &stand, variance_v2, NULL};
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_whole_chi_squared(NULL, &work, &square, &freedom));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_whole_chi_squared(&run, NULL, &square, &freedom));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_whole_chi_squared(&run, &work, NULL, &freedom));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_whole_chi_squared(&run, &work, &square, NULL));
    for (int p = 0; p < 9; p++) {
        means.measured[p] = false;
    }
    ASSERT_STATUS(TUMBLE_E_RANK, look());
    means.u_v[12][0] = NOT_A_NUMBER;
    ASSERT_STATUS(TUMBLE_E_NOT_FINITE, look());
}

/* In steps, from averages. */

#define V_PER_COUNT 1e-9
#define SAMPLES 16U

static tumble_averaging_t averaging;

/* The averages that these means are of; the means are then what the averages say. */
static void make_averages(void)
{
    memset(&averaging, 0, sizeof averaging);
    averaging.open.index = UINT8_MAX;
    for (uint8_t p = 0; p < P; p++) {
        averaging.averages[p].samples = means.measured[p] ? SAMPLES : 0U;
        for (int i = 0; i < 3; i++) {
            averaging.averages[p].sum_counts[i] = (int64_t)llround(means.u_v[p][i] / V_PER_COUNT * SAMPLES);
        }
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_means(&averaging, V_PER_COUNT, &means));
}

static uint32_t test_in_steps(const tumble_schedule_t *schedule, const tumble_coefficients_t *start)
{
    const tumble_misfit_run_t run = {schedule, &averaging, start, &stand, V_PER_COUNT};
    uint32_t steps = 1;
    tumble_whole_begin(&work);
    TEST_ASSERT_FALSE(work.known);
    while (tumble_whole_step(&work, &run)) {
        TEST_ASSERT_FALSE(work.known);
        steps++;
    }
    return steps;
}

static void declare(void)
{
    stand = (tumble_stand_record_t){.axis_tilt_rad = 1e-4,
                                    .level_rad = 1e-4,
                                    .remount_rad = 1e-3,
                                    .angle_rad = 1e-4,
                                    .noise_v = 1.6e-3,
                                    .seat_rad = 1e-4};
    for (int p = 0; p < P; p++) {
        variance_v2[p] = stand.noise_v * stand.noise_v / SAMPLES;
    }
}

static void come_to_the_same_bits(uint32_t least_steps, uint32_t most_steps)
{
    tumble_coefficients_t start;
    ASSERT_STATUS(TUMBLE_OK, look());
    const double at_once = square;
    ASSERT_STATUS(TUMBLE_OK, tumble_estimate_least_squares(&tumble_schedule_paper, &means, &start, NULL));
    const uint32_t steps = test_in_steps(&tumble_schedule_paper, &start);
    TEST_ASSERT_TRUE((steps > least_steps) && (steps < most_steps));
    TEST_ASSERT_TRUE(work.known && !work.misfits);
    TEST_ASSERT_EQUAL_DOUBLE(at_once, work.chi_squared);
    TEST_ASSERT_EQUAL_UINT8(FREEDOM - 3, work.freedom);
    TEST_ASSERT_EQUAL_DOUBLE(sqrt(at_once / (FREEDOM - 3)), work.misfit);
    TEST_ASSERT_EQUAL_DOUBLE(tumble_chi_squared_limit(FREEDOM - 3, TUMBLE_WHOLE_SIGMAS), work.limit);
}

static void test_steps_come_to_the_same_bits(void)
{
    make_means(3e-4);
    means.measured[7] = false;
    make_averages();
    declare();
    come_to_the_same_bits(1000U, 1300U);
    const double plain = square;
    stand.encoder_rad = 1e-4;
    stand.drift_v = 1e-3;
    come_to_the_same_bits(1400U, 1900U);
    TEST_ASSERT_TRUE(square < plain);
}

/* A change of unit: a channel's outputs, noise and drift times a factor. What has no unit stays. */
static void test_a_channel_in_another_unit_fits_as_well(void)
{
    static const double factor[3] = {0.15, -1.0, 5.0};
    static double by_channel[P][3];
    make_means(3e-4);
    declare();
    stand.encoder_rad = 1e-4;
    stand.drift_v = 1e-3;
    ASSERT_STATUS(TUMBLE_OK, look());
    const double before = square;
    for (int i = 0; i < 3; i++) {
        stand.channel_drift_v[i] = fabs(factor[i]) * stand.drift_v;
        for (int p = 0; p < P; p++) {
            means.u_v[p][i] *= factor[i];
            by_channel[p][i] = factor[i] * factor[i] * variance_v2[p];
        }
    }
    const tumble_whole_run_t run = {&tumble_schedule_paper, &means, &stand, NULL, (const double (*)[3])by_channel};
    ASSERT_STATUS(TUMBLE_OK, tumble_whole_chi_squared(&run, &work, &square, &freedom));
    TEST_ASSERT_TRUE(fabs(square - before) < 1e-9 * before);
    TEST_ASSERT_TRUE(fabs(work.coefficients.k_v_per_g[2][2]) > 10.0);
}

/* From averages: a channel with four times the counts, and four times the noise. */
static void test_each_channel_is_judged_by_its_own_noise(void)
{
    make_means(3e-4);
    make_averages();
    declare();
    (void)test_in_steps(&tumble_schedule_paper, &block);
    const double before = work.chi_squared;
    tumble_coefficients_t start = block;
    for (int p = 0; p < P; p++) {
        averaging.averages[p].sum_counts[1] *= -4;
    }
    for (int j = 0; j < 3; j++) {
        start.k_v_per_g[1][j] *= -4.0;
    }
    start.u0_v[1] *= -4.0;
    stand.channel_noise_v[1] = 4.0 * stand.noise_v;
    (void)test_in_steps(&tumble_schedule_paper, &start);
    TEST_ASSERT_TRUE(fabs(work.chi_squared - before) < 1e-9 * before);
}

/* 99.9 % quantiles, from tables. */
static void test_the_limit_is_near_the_true_quantile(void)
{
    static const struct {
        int freedom;
        double quantile;
    } known[] = {{3, 16.2662}, {6, 22.4577}, {24, 51.1786}, {42, 76.0838}, {69, 111.055}, {96, 144.567}};
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const double over = tumble_chi_squared_limit(known[i].freedom, TUMBLE_WHOLE_SIGMAS) / known[i].quantile - 1.0;
        TEST_ASSERT_TRUE((over > 0.0) && (over < 1.8e-2));
    }
}

/* Whatever estimate it begins with. */
static void test_no_estimator_takes_part(void)
{
    make_means(3e-4);
    make_averages();
    declare();
    ASSERT_STATUS(TUMBLE_OK, look());
    tumble_coefficients_t start = block;
    for (int i = 0; i < 3; i++) {
        start.k_v_per_g[i][i] *= 1.01;
        start.u0_v[i] += 1e-2;
    }
    (void)test_in_steps(&tumble_schedule_paper, &start);
    TEST_ASSERT_TRUE(fabs(work.chi_squared - square) < 1e-9 * square);
}

static void test_a_block_that_moved_misfits(void)
{
    make_means(3e-4);
    for (int p = 9; p < P; p++) {
        means.u_v[p][0] += 5e-3; /* between the mountings: neither of them shows it */
    }
    make_averages();
    declare();
    (void)test_in_steps(&tumble_schedule_paper, &block);
    TEST_ASSERT_TRUE(work.known && work.misfits);
    TEST_ASSERT_TRUE(work.chi_squared > work.limit);
}

/* Declared noise below half a count: samples round alike. Then a mean is no better than a sample. */
static void test_rounding_alike_is_not_averaged(void)
{
    make_means(3e-4);
    make_averages();
    declare();
    stand.noise_v = 0.4 * V_PER_COUNT;
    (void)test_in_steps(&tumble_schedule_paper, &block);
    const double alike = work.least_v2[0]; /* 1e-7 of K is more than a count here: nothing else is to be seen */
    TEST_ASSERT_TRUE(work.place.variance_v2[0] == alike);
    const tumble_misfit_run_t coarse = {&tumble_schedule_paper, &averaging, &block, &stand, 1e-3};
    stand.noise_v = 4e-4;
    tumble_whole_begin(&work);
    while (tumble_whole_step(&work, &coarse)) {
    }
    const double expected = (1.6e-7 / SAMPLES) + (1e-6 / 12.0);
    TEST_ASSERT_TRUE(fabs(work.place.variance_v2[2] - expected) < 1e-12 * expected);
    stand.least_noise_v = 1e-2;
    tumble_whole_begin(&work);
    while (tumble_whole_step(&work, &coarse)) {
    }
    TEST_ASSERT_TRUE(fabs(work.place.variance_v2[2] - 1e-4) < 1e-16);
}

/* Four positions, twelve means, twelve unknowns. */
static void test_without_freedom_nothing_is_known(void)
{
    make_means(0.0);
    for (int p = 0; p < P; p++) {
        means.measured[p] = (p == 0) || (p == 2) || (p == 4) || (p == 11);
    }
    make_averages();
    declare();
    (void)test_in_steps(&tumble_schedule_paper, &block);
    TEST_ASSERT_EQUAL_UINT8(0, work.freedom);
    TEST_ASSERT_FALSE(work.known || work.misfits);
}

static void test_a_sum_that_is_no_number_misfits(void)
{
    tumble_coefficients_t start = block;
    make_averages();
    declare();
    start.u0_v[1] = NOT_A_NUMBER;
    (void)test_in_steps(&tumble_schedule_paper, &start);
    TEST_ASSERT_TRUE(work.misfits && !work.known);
}

/* What the inclinations of one bolting have in common, and those of the other do not, is not among the unknowns. */
static void test_of_inclinations_in_two_boltings_nothing_is_known(void)
{
    static tumble_mounting_t mountings[3];
    memcpy(mountings, tumble_schedule_inclined.mountings, sizeof mountings);
    mountings[2].bolting = 2;
    const tumble_schedule_t schedule = {mountings, tumble_schedule_inclined.positions, 3, 27};
    make_averages();
    declare();
    const tumble_misfit_run_t run = {&schedule, &averaging, &block, &stand, V_PER_COUNT};
    tumble_whole_begin(&work);
    TEST_ASSERT_FALSE(tumble_whole_step(&work, &run));
    TEST_ASSERT_FALSE(work.known);
    TEST_ASSERT_FALSE(work.misfits);
}

/* Given up in the middle: what was found is forgotten, and the next test knows nothing of it. */
static void test_a_test_may_begin_anew_at_any_step(void)
{
    make_means(3e-4);
    make_averages();
    declare();
    const tumble_misfit_run_t run = {&tumble_schedule_paper, &averaging, &block, &stand, V_PER_COUNT};
    const uint32_t steps = test_in_steps(&tumble_schedule_paper, &block);
    const double before = work.chi_squared;
    for (uint32_t stop = 1; stop < steps; stop += 97U) {
        tumble_whole_begin(&work);
        for (uint32_t i = 0; i < stop; i++) {
            TEST_ASSERT_TRUE(tumble_whole_step(&work, &run));
        }
        TEST_ASSERT_EQUAL_UINT32(steps, test_in_steps(&tumble_schedule_paper, &block));
        TEST_ASSERT_EQUAL_DOUBLE(before, work.chi_squared);
    }
}
