/* `refined` with circles that are kept, from means and from sums of counts. */
#include "estimator_bench.h"

static const tumble_schedule_t *const built_in[] = {&tumble_schedule_paper, &tumble_schedule_three_mountings,
                                                    &tumble_schedule_diagonal, &tumble_schedule_diagonal_closed};
static const tumble_averaging_config_t config = {INT32_MAX, 1, 0, 0, 0.0F, 1.0F};
static tumble_harmonic_map_t map;
static tumble_averaging_t averaging;
static tumble_means_t means;

static void keep(const tumble_schedule_t *schedule)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_harmonic(schedule, NULL, &map, NULL));
}

/* Sums as finished positions leave them. */
static void set_sums(dice_t *dice, uint8_t positions, uint32_t bits, uint32_t samples)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_init(&averaging, &config));
    for (uint8_t p = 0; p < positions; p++) {
        tumble_average_t average = {.samples = samples};
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const double size = ldexp((double)average.samples, (int)bits);
            average.sum_counts[i] = (int64_t)(dice_signed_unit(dice) * size);
        }
        ASSERT_STATUS(TUMBLE_OK, tumble_averaging_restore(&averaging, &config, p, &average));
    }
}

static void assert_sums_and_means_agree(const tumble_schedule_t *schedule, double v_per_count)
{
    tumble_coefficients_t found;
    keep(schedule);
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_means(&averaging, v_per_count, &means));
    const tumble_coefficients_t expected = estimate_with(tumble_estimate_refined, schedule, &means);
    ASSERT_STATUS(TUMBLE_OK, tumble_refined_of_sums(&map, &averaging, v_per_count, &found));
    assert_coefficients(&expected, &found, 2e-15);
}

static void test_kept_circles_give_the_same_bits(void)
{
    dice_t dice = {41};
    for (int round = 0; round < 400; round++) {
        const tumble_schedule_t *schedule = built_in[round % 4];
        tumble_coefficients_t found;
        for (unsigned cell = 0; cell < 3U * TUMBLE_MAX_POSITIONS; cell++) {
            means.measured[cell / 3U] = true;
            means.u_v[cell / 3U][cell % 3U] = ldexp(dice_signed_unit(&dice), dice_between(&dice, -40, 40));
        }
        keep(schedule);
        const tumble_coefficients_t expected = estimate_with(tumble_estimate_refined, schedule, &means);
        ASSERT_STATUS(TUMBLE_OK, tumble_refined_of_means(&map, &means, &found));
        assert_same_coefficients(&expected, &found);
    }
}

static void test_sums_of_equal_counts_give_what_their_means_give(void)
{
    dice_t dice = {42};
    for (int round = 0; round < 400; round++) {
        const uint32_t samples = 1U + dice_below(&dice, 1000);
        set_sums(&dice, TUMBLE_MAX_POSITIONS, dice_below(&dice, 31), samples);
        assert_sums_and_means_agree(built_in[round % 4], ldexp(0.3, dice_between(&dice, -60, 60)));
        assert_sums_and_means_agree(built_in[round % 4], -1e-6);
    }
    set_sums(&dice, TUMBLE_MAX_POSITIONS, 30, TUMBLE_MAX_SAMPLES);
    assert_sums_and_means_agree(&tumble_schedule_paper, 1e-6);
}

/* Each channel has its own unit: a weak one beside a strong one is as exact as alone. */
static void test_a_channel_does_not_depend_on_the_others(void)
{
    dice_t dice = {44};
    tumble_coefficients_t alone;
    tumble_coefficients_t beside;
    set_sums(&dice, 18, 20, 50);
    keep(&tumble_schedule_paper);
    ASSERT_STATUS(TUMBLE_OK, tumble_refined_of_sums(&map, &averaging, 1e-6, &alone));
    for (uint8_t p = 0; p < 18U; p++) {
        averaging.averages[p].sum_counts[1] *= 1000;
        averaging.averages[p].sum_counts[2] = 0;
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_refined_of_sums(&map, &averaging, 1e-6, &beside));
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        ASSERT_SAME_DOUBLE(alone.k_v_per_g[0][j], beside.k_v_per_g[0][j]);
        ASSERT_SAME_DOUBLE(0.0, beside.k_v_per_g[2][j]);
    }
    ASSERT_SAME_DOUBLE(alone.u0_v[0], beside.u0_v[0]);
    ASSERT_SAME_DOUBLE(0.0, beside.u0_v[2]);
}

/* A mounting turned about the axis of the stand by any angle takes the general way of its matrix. */
static void test_a_circle_may_begin_anywhere(void)
{
    tumble_mounting_t mountings[2] = {tumble_schedule_paper.mountings[0],
                                      {2, {{0.6, 0, 0.8}, {0.8, 0, -0.6}, {0, 1, 0}}, LEVEL, 0}};
    const tumble_schedule_t turned = {mountings, tumble_schedule_paper.positions, 2, 18};
    dice_t dice = {45};
    for (int round = 0; round < 200; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        tumble_coefficients_t found;
        model_means(&turned, &block, &means);
        keep(&turned);
        ASSERT_STATUS(TUMBLE_OK, tumble_refined_of_means(&map, &means, &found));
        assert_coefficients(&block, &found, 1e-15);
    }
}

static void assert_means_refused(tumble_status_t expected)
{
    tumble_coefficients_t found;
    tumble_coefficients_t as_they_were;
    memset(&found, 0x5A, sizeof found);
    as_they_were = found;
    ASSERT_STATUS(expected, tumble_refined_of_means(&map, &means, &found));
    TEST_ASSERT_EQUAL_MEMORY(&as_they_were, &found, sizeof found);
}

static void assert_sums_refused(tumble_status_t expected, double v_per_count)
{
    tumble_coefficients_t found;
    tumble_coefficients_t as_they_were;
    memset(&found, 0x5A, sizeof found);
    as_they_were = found;
    ASSERT_STATUS(expected, tumble_refined_of_sums(&map, &averaging, v_per_count, &found));
    TEST_ASSERT_EQUAL_MEMORY(&as_they_were, &found, sizeof found);
}

static void test_means_that_are_not_there_or_no_numbers(void)
{
    static const double none[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1.0000000000000002e100};
    dice_t dice = {46};
    const tumble_coefficients_t block = random_block(&dice);
    model_means(&tumble_schedule_paper, &block, &means);
    keep(&tumble_schedule_paper);
    for (uint8_t p = 0; p < 18U; p++) {
        const double before = means.u_v[p][p % 3U];
        for (size_t n = 0; n < COUNT_OF(none); n++) {
            means.u_v[p][p % 3U] = none[n];
            assert_means_refused(TUMBLE_E_NOT_FINITE);
        }
        means.measured[p] = false;
        assert_means_refused(TUMBLE_E_MISSING_POSITION);
        means.measured[p] = true;
        means.u_v[p][p % 3U] = before;
    }
    means.measured[18] = true;
    means.u_v[18][0] = (double)NAN; /* of no position in the map */
    tumble_coefficients_t found;
    ASSERT_STATUS(TUMBLE_OK, tumble_refined_of_means(&map, &means, &found));
    assert_coefficients(&block, &found, 1e-15);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_refined_of_means(NULL, &means, &found));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_refined_of_means(&map, NULL, &found));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_refined_of_means(&map, &means, NULL));
}

static void test_sums_that_are_not_there(void)
{
    dice_t dice = {47};
    tumble_coefficients_t found;
    set_sums(&dice, 18, 20, 50);
    keep(&tumble_schedule_paper);
    ASSERT_STATUS(TUMBLE_OK, tumble_refined_of_sums(&map, &averaging, TUMBLE_MAX_V_PER_COUNT, &found));
    ASSERT_STATUS(TUMBLE_OK, tumble_refined_of_sums(&map, &averaging, -TUMBLE_MAX_V_PER_COUNT, &found));
    assert_sums_refused(TUMBLE_E_ARGUMENT, 0.0);
    assert_sums_refused(TUMBLE_E_ARGUMENT, (double)NAN);
    assert_sums_refused(TUMBLE_E_ARGUMENT, (double)INFINITY);
    assert_sums_refused(TUMBLE_E_ARGUMENT, 1.1e90);
    for (uint8_t p = 0; p < 18U; p++) {
        const tumble_average_t before = averaging.averages[p];
        averaging.averages[p].samples = 49;
        assert_sums_refused(TUMBLE_E_STATE, 1e-6);
        averaging.averages[p].samples = 0;
        assert_sums_refused(TUMBLE_E_MISSING_POSITION, 1e-6);
        averaging.averages[p] = before;
    }
    const int32_t counts[TUMBLE_CHANNELS] = {1, 2, 3};
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_begin(&averaging, 4));
    tumble_averaging_accumulate(&averaging, counts);
    assert_sums_refused(TUMBLE_E_MISSING_POSITION, 1e-6);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_refined_of_sums(NULL, &averaging, 1e-6, &found));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_refined_of_sums(&map, NULL, 1e-6, &found));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_refined_of_sums(&map, &averaging, 1e-6, NULL));
}
