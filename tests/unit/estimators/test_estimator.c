/* The harmonic estimators: exact on an ideal stand, equal to the published functionals on any data. */
#include "estimator_bench.h"
#include "six_faces.h"

static tumble_means_t means;

static estimator_t *const harmonic[] = {tumble_estimate_averaged, tumble_estimate_refined};

static void test_they_are_exact_on_an_ideal_stand(void)
{
    dice_t dice = {11};
    for (int round = 0; round < 2000; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        model_means(&tumble_schedule_paper, &block, &means);
        for (size_t e = 0; e < COUNT_OF(harmonic); e++) {
            const tumble_coefficients_t estimate = estimate_with(harmonic[e], &tumble_schedule_paper, &means);
            assert_coefficients(&block, &estimate, 1e-15);
        }
    }
}

/* The functionals c, s and b of nine outputs, with the weights written out: 1/8, sqrt(2)/8, 1/16. */
typedef struct {
    double c;
    double s;
    double b;
} harmonics_t;

static harmonics_t harmonics_of(const tumble_means_t *them, unsigned mounting, int channel)
{
    static const double c[9][2] = {{1, 0}, {0, 1}, {0, 0}, {0, -1}, {-2, 0}, {0, -1}, {0, 0}, {0, 1}, {1, 0}};
    static const double s[9][2] = {{0, 0}, {0, 1}, {2, 0}, {0, 1}, {0, 0}, {0, -1}, {-2, 0}, {0, -1}, {0, 0}};
    static const double b[9] = {0.5, 1, 1, 1, 1, 1, 1, 1, 0.5};
    const dd_t sqrt2 = {1.4142135623730951, -9.6672933134529135e-17};
    dd_t sums[3] = {{0, 0}, {0, 0}, {0, 0}};
    for (unsigned l = 0; l < 9U; l++) {
        const dd_t u = dd_of(them->u_v[9U * mounting + l][channel]);
        const dd_t weights[3] = {dd_add(dd_of(c[l][0]), dd_multiply(sqrt2, dd_of(c[l][1]))),
                                 dd_add(dd_of(s[l][0]), dd_multiply(sqrt2, dd_of(s[l][1]))), dd_of(b[l])};
        for (int k = 0; k < 3; k++) {
            sums[k] = dd_add(sums[k], dd_multiply(weights[k], u));
        }
    }
    return (harmonics_t){dd_round(sums[0]) / 8.0, dd_round(sums[1]) / 8.0, dd_round(sums[2]) / 8.0};
}

static void test_they_are_the_published_functionals_on_any_data(void)
{
    dice_t dice = {12};
    for (int round = 0; round < 500; round++) {
        tumble_coefficients_t expected;
        for (unsigned cell = 0; cell < 54U; cell++) {
            means.measured[cell / 3U] = true;
            means.u_v[cell / 3U][cell % 3U] = 4.0 * dice_signed_unit(&dice);
        }
        harmonics_t second[3];
        harmonics_t first[3];
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            first[i] = harmonics_of(&means, 0, i);
            second[i] = harmonics_of(&means, 1, i);
            expected.k_v_per_g[i][0] = (first[i].s - second[i].s) / 2.0;
            expected.k_v_per_g[i][1] = second[i].c;
            expected.k_v_per_g[i][2] = first[i].c;
            expected.u0_v[i] = (first[i].b + second[i].b) / 2.0;
        }
        const tumble_coefficients_t averaged = estimate_with(tumble_estimate_averaged, &tumble_schedule_paper, &means);
        assert_coefficients(&expected, &averaged, 1e-15);
        expected.k_v_per_g[1][0] = -second[1].s;
        expected.k_v_per_g[2][0] = first[2].s;
        const tumble_coefficients_t refined = estimate_with(tumble_estimate_refined, &tumble_schedule_paper, &means);
        assert_coefficients(&expected, &refined, 1e-15);
    }
}

/* The block stands turned by a yaw about the vertical of the platform, another in each mounting. */
static void means_with_yaw(const tumble_coefficients_t *block, const double sine[2], const double cosine[2],
                           tumble_means_t *them)
{
    memset(them, 0, sizeof *them);
    for (unsigned p = 0; p < 18U; p++) {
        const unsigned m = p / 9U;
        const tumble_angle_t *table = &tumble_schedule_paper.positions[p].angle;
        const dd_t h = dd_two_product(cosine[m], table->sine);
        const dd_t n = dd_negate(dd_two_product(sine[m], table->sine));
        const dd_t v = dd_of(table->cosine);
        const dd_t a[3] = {(m == 0U) ? h : dd_negate(h), (m == 0U) ? n : v, (m == 0U) ? v : n};
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            them->u_v[p][i] = dd_round(model_output(block, i, a));
        }
        them->measured[p] = true;
    }
}

/* K_yx of mounting 1 and K_zx of mounting 2 see the yaw times a main scale factor; formula (7) leaves them out. */
static void test_refined_keeps_the_yaw_out_of_two_coefficients(void)
{
    static const double sine[2] = {0.02 / 1.0001, -0.034 / 1.000289}; /* 2t / (1 + t^2) of t = 0.01, -0.017 */
    static const double cosine[2] = {0.9999 / 1.0001, 0.999711 / 1.000289};
    dice_t dice = {13};
    for (int round = 0; round < 200; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        tumble_coefficients_t expected = block;
        means_with_yaw(&block, sine, cosine, &means);
        double from_first[3];
        double from_second[3];
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const double *k = block.k_v_per_g[i];
            from_first[i] = k[0] * cosine[0] - k[1] * sine[0];
            from_second[i] = k[0] * cosine[1] + k[2] * sine[1];
            expected.k_v_per_g[i][0] = (from_first[i] + from_second[i]) / 2.0;
        }
        const tumble_coefficients_t averaged = estimate_with(tumble_estimate_averaged, &tumble_schedule_paper, &means);
        assert_coefficients(&expected, &averaged, 2e-15);
        expected.k_v_per_g[1][0] = from_second[1];
        expected.k_v_per_g[2][0] = from_first[2];
        const tumble_coefficients_t refined = estimate_with(tumble_estimate_refined, &tumble_schedule_paper, &means);
        assert_coefficients(&expected, &refined, 2e-15);
    }
}

static void test_they_find_the_positions_in_any_order(void)
{
    static tumble_position_t positions[18];
    dice_t dice = {14};
    for (unsigned p = 0; p < 18U; p++) {
        positions[(5U * p + 2U) % 18U] = tumble_schedule_paper.positions[p];
        positions[(5U * p + 2U) % 18U].number = (uint8_t)(90U - p);
    }
    const tumble_schedule_t shuffled = {tumble_schedule_paper.mountings, positions, 2, 18};
    const tumble_coefficients_t block = random_block(&dice);
    model_means(&shuffled, &block, &means);
    for (size_t e = 0; e < COUNT_OF(harmonic); e++) {
        const tumble_coefficients_t estimate = estimate_with(harmonic[e], &shuffled, &means);
        assert_coefficients(&block, &estimate, 1e-15);
    }
}

/* A mounting turned about the axis of the stand by any angle takes the general way of its matrix. */
static void test_a_circle_may_begin_anywhere(void)
{
    static const tumble_mounting_t mountings[] = {{1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, LEVEL, 0},
                                                  {2, {{0.6, 0, 0.8}, {0.8, 0, -0.6}, {0, 1, 0}}, LEVEL, 0}};
    const tumble_schedule_t turned = {mountings, tumble_schedule_paper.positions, 2, 18};
    dice_t dice = {45};
    for (int round = 0; round < 200; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        model_means(&turned, &block, &means);
        for (size_t e = 0; e < COUNT_OF(harmonic); e++) {
            const tumble_coefficients_t estimate = estimate_with(harmonic[e], &turned, &means);
            assert_coefficients(&block, &estimate, 1e-15);
        }
    }
}

/* A weak channel beside a strong one is as exact as alone. */
static void test_a_channel_does_not_depend_on_the_others(void)
{
    dice_t dice = {44};
    const tumble_coefficients_t block = random_block(&dice);
    model_means(&tumble_schedule_paper, &block, &means);
    const tumble_coefficients_t alone = estimate_with(tumble_estimate_refined, &tumble_schedule_paper, &means);
    for (unsigned p = 0; p < 18U; p++) {
        means.u_v[p][1] *= 1e12;
        means.u_v[p][2] = 0.0;
    }
    const tumble_coefficients_t beside = estimate_with(tumble_estimate_refined, &tumble_schedule_paper, &means);
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        ASSERT_SAME_DOUBLE(alone.k_v_per_g[0][j], beside.k_v_per_g[0][j]);
        ASSERT_SAME_DOUBLE(0.0, beside.k_v_per_g[2][j]);
    }
    ASSERT_SAME_DOUBLE(alone.u0_v[0], beside.u0_v[0]);
    ASSERT_SAME_DOUBLE(0.0, beside.u0_v[2]);
}

static void test_they_name_the_missing_positions(void)
{
    dice_t dice = {15};
    const tumble_coefficients_t block = random_block(&dice);
    model_means(&tumble_schedule_paper, &block, &means);
    for (size_t e = 0; e < COUNT_OF(harmonic); e++) {
        for (unsigned p = 0; p < 18U; p++) {
            means.measured[p] = false;
            means.measured[11] = (p == 10U) ? false : means.measured[11];
            const uint32_t missing = (UINT32_C(1) << p) | ((p == 10U) ? UINT32_C(1) << 11 : 0U);
            assert_estimator_refuses(harmonic[e], &tumble_schedule_paper, &means, TUMBLE_E_MISSING_POSITION,
                                     (tumble_refusal_t){missing, 0});
            means.measured[p] = true;
            means.measured[11] = true;
        }
    }
}

static void test_they_refuse_a_schedule_without_circles(void)
{
    dice_t dice = {16};
    const tumble_coefficients_t block = random_block(&dice);
    model_means(&six_faces, &block, &means);
    for (size_t e = 0; e < COUNT_OF(harmonic); e++) {
        tumble_coefficients_t coefficients;
        tumble_coefficients_t as_they_were;
        tumble_refusal_t refusal = {0xFFFFFFFFU, 0xFF};
        memset(&coefficients, 0x5A, sizeof coefficients);
        as_they_were = coefficients;
        ASSERT_STATUS(TUMBLE_E_NOT_HARMONIC, harmonic[e](&six_faces, &means, &coefficients, &refusal));
        TEST_ASSERT_EQUAL_MEMORY(&as_they_were, &coefficients, sizeof coefficients);
        TEST_ASSERT_EQUAL_HEX8(0, refusal.unidentified);
        ASSERT_STATUS(TUMBLE_E_NOT_HARMONIC, harmonic[e](&six_faces, &means, &coefficients, NULL));
    }
}

static void test_they_refuse_null(void)
{
    assert_estimator_refuses_null(tumble_estimate_averaged);
    assert_estimator_refuses_null(tumble_estimate_refined);
}

static void test_they_refuse_what_is_not_finite(void)
{
    assert_estimator_refuses_what_is_not_finite(tumble_estimate_averaged);
    assert_estimator_refuses_what_is_not_finite(tumble_estimate_refined);
    assert_estimator_has_the_documented_range(tumble_estimate_averaged);
    assert_estimator_has_the_documented_range(tumble_estimate_refined);
}

static void test_they_ignore_check_positions_and_what_was_not_measured(void)
{
    assert_estimator_ignores_what_is_not_for_it(tumble_estimate_averaged);
    assert_estimator_ignores_what_is_not_for_it(tumble_estimate_refined);
}
