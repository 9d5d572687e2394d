/* The stand seen in the data: exact small cases. The statistics are tested from Python, on many runs. */
#include "core/vector.h"
#include "random_schedule.h"
#include "support.h"
#include "tumble/core.h"

#include <math.h>

#define P 18
#define PI 3.14159265358979323846

typedef struct {
    double alpha1;
    double alpha2;
    double alpha3[2];
    double delta[P];
} stand_errors_t;

static const tumble_coefficients_t block = {{{2.0, 0.04, -0.03}, {0.02, 1.9, 0.05}, {-0.01, 0.03, 2.1}},
                                            {0.1, -0.2, 0.05}};
static tumble_means_t means;
static tumble_calibration_t calibration;
static tumble_random_errors_t errors;
static tumble_fit_work_t work;
static tumble_seen_angles_t seen;

/* Outputs of the paper's schedule on a stand with errors, on the exact geometry. */
static void make_means(const stand_errors_t *e)
{
    for (int p = 0; p < P; p++) {
        const int m = p / 9;
        const double angle = (45.0 * (p % 9) * PI / 180.0) + e->alpha2 + e->delta[p];
        const double h = cos(e->alpha1) * sin(angle);
        const double n = sin(e->alpha1);
        const double v = cos(e->alpha1) * cos(angle);
        const double yawed_h = (h * cos(e->alpha3[m])) + (n * sin(e->alpha3[m]));
        const double yawed_n = (n * cos(e->alpha3[m])) - (h * sin(e->alpha3[m]));
        const double first[3] = {yawed_h, yawed_n, v};
        const double second[3] = {-yawed_h, v, yawed_n};
        const double *a = (m == 0) ? first : second;
        for (int i = 0; i < 3; i++) {
            const double *k = block.k_v_per_g[i];
            means.u_v[p][i] = block.u0_v[i] + (k[0] * a[0]) + (k[1] * a[1]) + (k[2] * a[2]);
        }
        means.measured[p] = true;
    }
}

static void set_up(void)
{
    static const stand_errors_t none = {0};
    memset(&means, 0, sizeof means);
    memset(&errors, 0, sizeof errors);
    for (int p = 0; p < P; p++) {
        errors.mean_variance_v2[p] = 1e-10; /* 10 uV */
    }
    make_means(&none);
    ASSERT_STATUS(TUMBLE_OK, tumble_calibration_invert(&block, &calibration));
}

static void look_closed(void)
{
    memset(&seen, 0x5A, sizeof seen);
    ASSERT_STATUS(TUMBLE_OK, tumble_seen_angles(&tumble_schedule_paper, &means, &calibration, &errors, &seen));
}

static void look_fitted(void)
{
    memset(&seen, 0x5A, sizeof seen);
    memset(&work, 0x5A, sizeof work);
    ASSERT_STATUS(TUMBLE_OK, tumble_seen_fit(&tumble_schedule_paper, &means, &block, &errors, &work, &seen));
}

static void assert_angles(double tolerance, double alpha1, double both, double difference)
{
    TEST_ASSERT_TRUE(seen.alpha1.known && seen.alpha2_plus_alpha3.known && seen.alpha3_difference.known);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, alpha1, seen.alpha1.value);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, both, seen.alpha2_plus_alpha3.value);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, difference, seen.alpha3_difference.value);
}

static void test_an_ideal_stand_shows_no_angles(void)
{
    look_closed();
    assert_angles(1e-15, 0.0, 0.0, 0.0);
    look_fitted();
    assert_angles(1e-13, 0.0, 0.0, 0.0);
}

static void test_every_angle_is_seen_for_itself(void)
{
    static const stand_errors_t cases[] = {
        {.alpha1 = 1e-6},
        {.alpha2 = -2e-6},
        {.alpha3 = {3e-6, 0.0}},
        {.alpha3 = {0.0, -3e-6}},
        {.alpha1 = -1e-6, .alpha2 = 2e-6, .alpha3 = {-4e-6, 5e-6}},
    };
    for (size_t c = 0; c < COUNT_OF(cases); c++) {
        const stand_errors_t *e = &cases[c];
        const double both = e->alpha2 + ((e->alpha3[0] + e->alpha3[1]) / 2.0);
        make_means(e);
        look_closed();
        assert_angles(1e-10, e->alpha1, both, e->alpha3[0] - e->alpha3[1]);
        look_fitted();
        assert_angles(1e-10, e->alpha1, both, e->alpha3[0] - e->alpha3[1]);
    }
}

/* Set angles alone: u(alpha1) = alpha4 / sqrt 32, of the sum sqrt(3/32), of the difference sqrt(3/8). */
static void test_uncertainties_of_the_closed_form(void)
{
    errors.angle_rad = 1e-4;
    memset(errors.mean_variance_v2, 0, sizeof errors.mean_variance_v2);
    look_closed();
    TEST_ASSERT_DOUBLE_WITHIN(1e-17, 1e-4 * sqrt(1.0 / 32.0), seen.alpha1.u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-17, 1e-4 * sqrt(3.0 / 32.0), seen.alpha2_plus_alpha3.u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-17, 1e-4 * sqrt(3.0 / 8.0), seen.alpha3_difference.u);
    ASSERT_STATUS(TUMBLE_OK, tumble_seen_angles(&tumble_schedule_paper, &means, &calibration, NULL, &seen));
    ASSERT_SAME_DOUBLE(0.0, seen.alpha1.u);
}

/* The fit is never worse, and where set angles prevail alpha1 is far better. */
static void test_the_fit_is_sharper(void)
{
    errors.angle_rad = 2e-4;
    look_closed();
    const tumble_seen_angles_t closed = seen;
    look_fitted();
    TEST_ASSERT_TRUE(seen.alpha1.u < (0.1 * closed.alpha1.u));
    TEST_ASSERT_TRUE(seen.alpha2_plus_alpha3.u < closed.alpha2_plus_alpha3.u);
    TEST_ASSERT_TRUE(seen.alpha3_difference.u < closed.alpha3_difference.u);
}

static void test_the_fit_is_as_sharp_as_the_noise(void)
{
    look_fitted();
    const double u = seen.alpha1.u;
    for (int p = 0; p < P; p++) {
        errors.mean_variance_v2[p] *= 4.0;
    }
    look_fitted();
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * u, 2.0 * u, seen.alpha1.u);
}

static void test_no_excess_over_the_noise_is_not_known(void)
{
    tumble_seen_t alpha4 = {1.0, 1.0, true};
    double freedom = 5.0;
    ASSERT_STATUS(TUMBLE_OK,
                  tumble_seen_angle_error(&tumble_schedule_paper, &means, &block, &errors, &work, &alpha4, &freedom));
    TEST_ASSERT_FALSE(alpha4.known);
    ASSERT_SAME_DOUBLE(0.0, alpha4.value);
    ASSERT_SAME_DOUBLE(0.0, freedom);
}

/* At the estimate chi-squared is its degrees of freedom, 16 of 18 angles: the two circles' own zeros cannot be seen. */
static void test_the_error_of_set_angles_makes_chi_squared_right(void)
{
    stand_errors_t e = {.alpha1 = 1e-5, .alpha3 = {2e-5, -3e-5}};
    dice_t dice = {77};
    for (int p = 0; p < P; p++) {
        e.delta[p] = 1e-6 * (double)dice_between(&dice, -100, 100);
    }
    make_means(&e);
    tumble_seen_t alpha4;
    double freedom = 0.0;
    double square = 0.0;
    uint8_t count = 0;
    ASSERT_STATUS(TUMBLE_OK,
                  tumble_seen_angle_error(&tumble_schedule_paper, &means, &block, &errors, &work, &alpha4, &freedom));
    TEST_ASSERT_TRUE(alpha4.known);
    TEST_ASSERT_DOUBLE_WITHIN(3e-5, 58e-6, alpha4.value); /* 100e-6 / sqrt 3 */
    TEST_ASSERT_TRUE((freedom > 15.0) && (freedom <= 16.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, alpha4.value / sqrt(2.0 * freedom), alpha4.u);
    errors.angle_rad = alpha4.value;
    ASSERT_STATUS(TUMBLE_OK, tumble_seen_angle_chi_squared(&tumble_schedule_paper, &means, &block, &errors, &work,
                                                           &square, &count));
    TEST_ASSERT_EQUAL_UINT8(16, count);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 16.0, square);
}

/* Outputs that fit 10,000 times worse than the noise allows, as behind a coarse converter: chi-squared of the angles is
 * the small difference of two sums beyond 1e9, and must not be found as one. */
static void test_residuals_far_beyond_the_noise(void)
{
    dice_t dice = {78};
    for (int p = 0; p < P; p++) {
        errors.mean_variance_v2[p] = 1e-12;
        for (int i = 0; i < 3; i++) {
            means.u_v[p][i] += 1e-4 * (double)dice_between(&dice, -100, 100);
        }
    }
    tumble_seen_t alpha4;
    double freedom = 0.0;
    double square = 0.0;
    uint8_t count = 0;
    ASSERT_STATUS(TUMBLE_OK,
                  tumble_seen_angle_error(&tumble_schedule_paper, &means, &block, &errors, &work, &alpha4, &freedom));
    TEST_ASSERT_TRUE(alpha4.known);
    errors.angle_rad = alpha4.value;
    ASSERT_STATUS(TUMBLE_OK, tumble_seen_angle_chi_squared(&tumble_schedule_paper, &means, &block, &errors, &work,
                                                           &square, &count));
    TEST_ASSERT_EQUAL_UINT8(16, count);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 16.0, square);
}

static void tilt(tumble_mounting_t mountings[2], double alpha1)
{
    static const double tilts[2] = {0.3, -0.2};
    for (int m = 0; m < 2; m++) {
        mountings[m].tilt.sine = sin(tilts[m] + alpha1);
        mountings[m].tilt.cosine = cos(tilts[m] + alpha1);
    }
}

/* Where the mountings are tilted differently no K explains what the axis adds to both. */
static void test_the_axis_is_seen_behind_tilted_mountings(void)
{
    tumble_mounting_t mountings[2];
    const tumble_schedule_t schedule = {mountings, tumble_schedule_paper.positions, 2, P};
    memcpy(mountings, tumble_schedule_paper.mountings, sizeof mountings);
    tilt(mountings, 1e-6);
    for (uint8_t p = 0; p < P; p++) {
        double a[3];
        tumble_schedule_attitude(&schedule, p, a);
        for (int i = 0; i < 3; i++) {
            means.u_v[p][i] = block.u0_v[i] + tumble_dot(block.k_v_per_g[i], a);
        }
    }
    tilt(mountings, 0.0);
    ASSERT_STATUS(TUMBLE_OK, tumble_seen_fit(&schedule, &means, &block, &errors, &work, &seen));
    TEST_ASSERT_TRUE(seen.alpha1.known);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 1e-6, seen.alpha1.value);
}

static const tumble_position_t check_position = {.mounting = 3, .number = 1, .use = TUMBLE_USE_CHECK};

/* A mounting for check positions alone, in front of the paper's two, changes no bit of what they show. */
static void test_a_mounting_for_checks_alone_takes_no_part(void)
{
    const stand_errors_t e = {.alpha1 = -1e-6, .alpha2 = 2e-6, .alpha3 = {-4e-6, 5e-6}};
    make_means(&e);
    errors.angle_rad = 2e-4;
    look_fitted();
    const tumble_seen_angles_t expected = seen;

    static tumble_mounting_t mountings[3];
    static tumble_position_t positions[P + 1];
    mountings[0] = tumble_schedule_paper.mountings[0];
    mountings[0].number = 3;
    memcpy(&mountings[1], tumble_schedule_paper.mountings, 2 * sizeof mountings[0]);
    memcpy(positions, tumble_schedule_paper.positions, P * sizeof positions[0]);
    positions[P] = check_position;
    positions[P].angle = positions[0].angle;
    means.measured[P] = true;
    const tumble_schedule_t schedule = {mountings, positions, 3, P + 1};
    ASSERT_STATUS(TUMBLE_OK, tumble_seen_fit(&schedule, &means, &block, &errors, &work, &seen));
    assert_angles(1e-15, expected.alpha1.value, expected.alpha2_plus_alpha3.value, expected.alpha3_difference.value);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, expected.alpha1.u, seen.alpha1.u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, expected.alpha2_plus_alpha3.u, seen.alpha2_plus_alpha3.u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, expected.alpha3_difference.u, seen.alpha3_difference.u);
}

/* One mounting shows no tilt of the axis; the rank says so, no number does. */
static void test_what_cannot_be_told_is_not_known(void)
{
    for (int p = 9; p < P; p++) {
        means.measured[p] = false;
    }
    ASSERT_STATUS(TUMBLE_E_MISSING_POSITION,
                  tumble_seen_angles(&tumble_schedule_paper, &means, &calibration, &errors, &seen));
    look_fitted();
    TEST_ASSERT_FALSE(seen.alpha1.known || seen.alpha2_plus_alpha3.known || seen.alpha3_difference.known);
    ASSERT_SAME_DOUBLE(0.0, seen.alpha1.value);
}

static void test_the_noise_is_pooled_by_degrees_of_freedom(void)
{
    static const uint32_t samples[4] = {1, 2, 5, 0};
    static const double scatter[4][3] = {{9, 9, 9}, {1, 2, 3}, {2, 2, 1}, {9, 9, 9}};
    const double variance = (((1.0 + 4.0 + 9.0) * 1.0) + ((4.0 + 4.0 + 1.0) * 4.0)) / 15.0;
    const tumble_seen_t noise = tumble_seen_noise(samples, scatter, 4);
    TEST_ASSERT_TRUE(noise.known);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, sqrt(variance), noise.value);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, sqrt(variance / 30.0), noise.u);
    TEST_ASSERT_FALSE(tumble_seen_noise(samples, scatter, 1).known);
}

static void test_the_fit_takes_six_mountings(void)
{
    tumble_mounting_t mountings[TUMBLE_MAX_YAWS + 1];
    tumble_position_t positions[TUMBLE_MAX_YAWS + 1];
    tumble_schedule_t schedule;
    free_attitudes(TUMBLE_MAX_YAWS, mountings, positions, &schedule);
    ASSERT_STATUS(TUMBLE_OK, tumble_seen_fit(&schedule, &means, &block, &errors, &work, &seen));
    free_attitudes(TUMBLE_MAX_YAWS + 1, mountings, positions, &schedule);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_fit(&schedule, &means, &block, &errors, &work, &seen));
}

static void test_bad_arguments(void)
{
    const tumble_schedule_t *s = &tumble_schedule_paper;
    static const tumble_coefficients_t zero = {0};
    tumble_seen_t alpha4;
    double number;
    uint8_t count;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_angles(NULL, &means, &calibration, &errors, &seen));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_angles(s, NULL, &calibration, &errors, &seen));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_angles(s, &means, NULL, &errors, &seen));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_angles(s, &means, &calibration, &errors, NULL));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_fit(NULL, &means, &block, &errors, &work, &seen));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_fit(s, &means, &block, &errors, NULL, &seen));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_fit(s, &means, &zero, &errors, &work, &seen));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_angle_error(s, &means, &block, NULL, &work, &alpha4, &number));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_angle_error(s, &means, &block, &errors, &work, NULL, &number));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_angle_chi_squared(s, NULL, &block, &errors, &work, &number, &count));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_seen_angle_chi_squared(s, &means, &block, &errors, &work, NULL, &count));
}
