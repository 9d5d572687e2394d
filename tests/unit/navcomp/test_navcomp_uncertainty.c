/* The uncertainties that the navigation computer states: those of its own result, estimator, samples and stand. */
#include "gain_bench.h"
#include "navcomp/uncertainty.h"
#include "sim_bench.h"
#include "tumble/core.h"

static tumble_uncertainty_t stated;

static void set_up(void)
{
    memset(&stated, 0x5A, sizeof stated);
}

/* With an error budget every mean has its own number of samples. */
static void test_they_are_those_of_the_estimator_in_use(void)
{
    static const char *const lines[] = {"procedure.estimator = averaged\n", "procedure.estimator = refined\n",
                                        "procedure.estimator = least_squares\nprocedure.error_budget_v = 6e-5\n"
                                        "stand.remount = common\nstand.limits = sigma3\n"};
    tumble_status_t (*const judges[])(const tumble_judged_run_t *, tumble_uncertainty_t *, tumble_refusal_t *) = {
        tumble_uncertainty_averaged, tumble_uncertainty_refined, tumble_uncertainty_least_squares};
    for (size_t c = 0; c < COUNT_OF(lines); c++) {
        run_lines(lines[c], 1, NULL);
        const tumble_averaging_t *averages = tumble_procedure_averages(tumble_navcomp_procedure(&world.navcomp));
        const tumble_coefficients_t coefficients = found();
        const double per_sigma = (c == 2U) ? 3.0 : 1.0;
        const tumble_stand_record_t stand = {.axis_tilt_rad = 2e-5 / per_sigma,
                                             .level_rad = 2e-5 / per_sigma,
                                             .remount_rad = 4e-4 / per_sigma,
                                             .angle_rad = 4e-5 / per_sigma,
                                             .noise_v = 3e-4,
                                             .samples = 1,
                                             .common_yaw = c == 2U};
        uint32_t samples[18];
        for (size_t p = 0; p < 18U; p++) {
            samples[p] = averages->averages[p].samples;
        }
        const tumble_judged_run_t run = {
            &tumble_schedule_paper, &stand, &coefficients, NULL, samples, 0, NULL, NULL, NULL, NULL, NULL, NULL};
        tumble_uncertainty_t expected;
        ASSERT_STATUS(TUMBLE_OK, judges[c](&run, &expected, NULL));
        ASSERT_STATUS(TUMBLE_E_PORT_BUSY, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, &stated));
        ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, &stated));
        TEST_ASSERT_EQUAL_MEMORY(&expected, &stated, sizeof stated);
    }
}

static const tumble_noise_t *noise_of_run(void)
{
    const tumble_noise_t *noise = NULL;
    ASSERT_STATUS(TUMBLE_E_PORT_BUSY, tumble_navcomp_noise(&world.navcomp, &noise));
    ASSERT_STATUS(TUMBLE_E_PORT_BUSY, tumble_navcomp_uncertainty(&world.navcomp, 1, &stated));
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_noise(&world.navcomp, &noise));
    return noise;
}

/* Of every position of 50 samples: 3 pairs of 8, one of 16. */
static void test_every_position_counts_once(void)
{
    run_lines("", 1, NULL);
    TEST_ASSERT_EQUAL_UINT32(18U * 3U, config.noise.blocks.pairs[0]);
    TEST_ASSERT_EQUAL_UINT32(18U, config.noise.blocks.pairs[1]);
    const tumble_noise_t *noise = noise_of_run();
    TEST_ASSERT_EQUAL_HEX8(0, noise->above);
    TEST_ASSERT_DOUBLE_WITHIN(0.2 * 3e-4, 3e-4, noise->noise_v[0]);
    run_lines("", 2, NULL); /* forgotten at power-on */
    TEST_ASSERT_EQUAL_UINT32(18U, config.noise.blocks.pairs[1]);
}

/* Too few samples for any; and as many as a position has at least. */
static void test_how_long_blocks_are(void)
{
    run_lines("procedure.samples = 7\naveraging.stuck_run = 0\n", 1, NULL);
    TEST_ASSERT_EQUAL_UINT32(0, config.noise.blocks.block_samples);
    TEST_ASSERT_DOUBLE_WITHIN(0.2 * 3e-4, 3e-4, noise_of_run()->noise_v[1]);
    run_lines("procedure.error_budget_v = 6e-5\nprocedure.samples = 200\n", 1, NULL);
    TEST_ASSERT_EQUAL_UINT32(4, config.noise.blocks.block_samples); /* 16 samples at least, not 200 */
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(18U * 2U, config.noise.blocks.pairs[0]);
}

static void test_correlated_noise_is_above_and_counts(void)
{
    tumble_uncertainty_t white;
    run_lines("", 1, NULL);
    (void)noise_of_run();
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, &white));
    run_lines("block.noise_correlation = 0.9 0 0.5\n", 1, NULL);
    TEST_ASSERT_EQUAL_HEX8(5, noise_of_run()->above);
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, &stated));
    TEST_ASSERT_TRUE(stated.u0_v[0] > 2.0 * white.u0_v[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * white.u0_v[1], white.u0_v[1], stated.u0_v[1]);
    TEST_ASSERT_TRUE(stated.u0_v[2] > 1.2 * white.u0_v[2]);
}

/* Samples that scatter beyond all measure: then nothing is certain. */
static void test_sums_at_their_end_state_nothing(void)
{
    run_lines("", 1, NULL);
    config.noise.blocks.square_sum[1][2] = INT64_MAX;
    const tumble_noise_t *noise = NULL;
    ASSERT_STATUS(TUMBLE_E_PORT_BUSY, tumble_navcomp_uncertainty(&world.navcomp, 1, &stated));
    ASSERT_STATUS(TUMBLE_E_DEVIATION, tumble_navcomp_uncertainty(&world.navcomp, 1, &stated));
    ASSERT_STATUS(TUMBLE_E_DEVIATION, tumble_navcomp_noise(&world.navcomp, &noise));
}

static void test_without_a_result_or_a_stand_nothing_is_stated(void)
{
    static tumble_navcomp_t fresh;
    run_lines("", 1, NULL);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_uncertainty(NULL, TUMBLE_ALL_COEFFICIENTS, &stated));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, NULL));
    static bench_stand_memory_t stand;
    tumble_navcomp_config_t other = world.navcomp_config;
    other.stand_memory = &stand;
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_init(&fresh, &other));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_navcomp_uncertainty(&fresh, TUMBLE_ALL_COEFFICIENTS, &stated));
    const tumble_declared_t bare = {world.navcomp_config.declared->stand, NULL, NULL};
    world.navcomp_config.declared = &bare;
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, &stated));
    const tumble_lent_t mute = {.estimator = TUMBLE_ESTIMATE_OPTIMAL};
    world.navcomp.procedure_config.estimate = TUMBLE_ESTIMATE_OPTIMAL;
    world.navcomp.procedure_config.lent = &mute; /* of which no uncertainties are stated */
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, &stated));
    world.navcomp.procedure_config.lent = NULL; /* which this board does not lend */
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, &stated));
    world.navcomp_config.declared = NULL;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_uncertainty(&world.navcomp, TUMBLE_ALL_COEFFICIENTS, &stated));
}

static void test_those_of_a_gain_record_are_for_the_k_it_was_made_for(void)
{
    static gain_bytes_t record;
    static const tumble_coefficients_t made_for = {{{2.0, 0.1, 0.0}, {0.0, 2.1, 0.0}, {0.3, 0.0, 1.9}}, {0}};
    static const tumble_coefficients_t another = {{{5.0, 0.0, 0.0}, {0.0, 5.0, 0.0}, {0.0, 0.0, 5.0}}, {1.0, 1.0, 1.0}};
    static const tumble_stand_record_t stand = {1e-5,  2e-5, 3e-4, 4e-5, 3e-4, 0.0, 50,
                                                false, 0.0,  0.0,  0.0,  0.0,  {0}, {0}};
    dice_t dice = {91};
    empty_gains(&tumble_schedule_paper, 2, &record);
    for (unsigned n = 0; n < 9U; n++) {
        set_number(&record, AT_K + n, made_for.k_v_per_g[n / 3U][n % 3U]);
    }
    for (unsigned g = 0; g < 12U * 54U; g++) {
        set_number(&record, AT_GAINS + g, (double)dice_between(&dice, -100, 100));
    }
    seal(&record);
    tumble_optimal_t work;
    tumble_optimal_source_t source = {record.bytes, record.size, &work};
    const tumble_gain_table_t table = {tumble_gain_record_gains(open_gains(&record, &tumble_schedule_paper)), 18, 0.0};
    tumble_judged_run_t run = {
        &tumble_schedule_paper, &stand, &made_for, NULL, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL};
    tumble_uncertainty_t expected;
    ASSERT_STATUS(TUMBLE_OK, tumble_uncertainty_gains(&table, &run, &expected));
    run.coefficients = &another;
    ASSERT_STATUS(TUMBLE_OK, tumble_optimal_uncertainty(&source, &run, &stated));
    TEST_ASSERT_EQUAL_MEMORY(&expected, &stated, sizeof stated);

    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_optimal_uncertainty(NULL, &run, &stated));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_optimal_uncertainty(&source, NULL, &stated));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_optimal_uncertainty(&source, &run, NULL));
    run.coefficients = NULL;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_optimal_uncertainty(&source, &run, &stated));
    run.coefficients = &another;
    record.bytes[1000] ^= 1U;
    ASSERT_STATUS(TUMBLE_E_CRC, tumble_optimal_uncertainty(&source, &run, &stated));
    run.only = 1; /* the first of twelve calls */
    ASSERT_STATUS(TUMBLE_E_CRC, tumble_optimal_uncertainty(&source, &run, &stated));
    run.only = 2; /* the record has passed with the first one */
    ASSERT_STATUS(TUMBLE_OK, tumble_optimal_uncertainty(&source, &run, &stated));
}
