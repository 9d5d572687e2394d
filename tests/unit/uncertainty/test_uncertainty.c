/* Standard uncertainties: closed forms on the paper's schedule, and what is refused. */
#include "uncertainty_bench.h"

static const tumble_coefficients_t straight = {{{2, 0, 0}, {0, -3, 0}, {0, 0, 5}}, {1, 2, 3}};
static const tumble_stand_record_t no_errors = {.samples = 1};

static void assert_on_paper(judge_t *judge, const tumble_stand_record_t *stand, const tumble_coefficients_t *block,
                            const double k[3][3], const double u0[3])
{
    const tumble_judged_run_t run = run_on_paper(stand, block);
    const tumble_uncertainty_t found = judged(judge, &run);
    assert_uncertainties(k, u0, &found, 1e-12);
}

/* Sums of squares of the weights: c 14/64, s 16/64, b 7.5/64; the mean of two mountings has half of them. */
static void test_noise_alone(void)
{
    const tumble_stand_record_t stand = {.noise_v = 3.0, .samples = 9};
    const double c = sqrt(14.0) / 8.0;
    const double s = 0.5 / sqrt(2.0);
    const double b = sqrt(7.5 / 128.0);
    const double averaged[3][3] = {{s, c, c}, {s, c, c}, {s, c, c}};
    const double refined[3][3] = {{s, c, c}, {0.5, c, c}, {0.5, c, c}};
    const double u0[3] = {b, b, b};
    assert_on_paper(tumble_uncertainty_averaged, &stand, &straight, averaged, u0);
    assert_on_paper(tumble_uncertainty_refined, &stand, &straight, refined, u0);
}

/* Channel by channel; 0 leaves it to the number for all. */
static void test_noise_and_drift_of_each_channel(void)
{
    const tumble_stand_record_t stand = {.noise_v = 3.0,
                                         .drift_v = 0.5,
                                         .samples = 9,
                                         .channel_noise_v = {0.0, 30.0, 0.3},
                                         .channel_drift_v = {2.0, 0.0, 8.0}};
    const double noise[3] = {3.0, 30.0, 0.3};
    const double drift[3] = {2.0, 0.5, 8.0};
    double k[3][3];
    double u0[3];
    for (int i = 0; i < 3; i++) {
        const tumble_stand_record_t alike = {.noise_v = noise[i], .drift_v = drift[i], .samples = 9};
        const tumble_judged_run_t run = run_on_paper(&alike, &straight);
        const tumble_uncertainty_t found = judged(tumble_uncertainty_refined, &run);
        memcpy(k[i], found.k_v_per_g[i], sizeof k[i]);
        u0[i] = found.u0_v[i];
    }
    assert_on_paper(tumble_uncertainty_refined, &stand, &straight, (const double (*)[3])k, u0);
}

static void test_a_channel_with_a_number_out_of_range_is_refused(void)
{
    tumble_stand_record_t stand = no_errors;
    const tumble_judged_run_t run = run_on_paper(&stand, &straight);
    tumble_uncertainty_t found;
    stand.channel_noise_v[2] = -1e-9;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_uncertainty_refined(&run, &found, NULL));
    stand.channel_noise_v[2] = 0.0;
    stand.channel_drift_v[0] = 1e101;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_uncertainty_refined(&run, &found, NULL));
}

/* However many samples a mean has. */
static void test_the_least_noise_of_a_mean(void)
{
    const tumble_stand_record_t noisy = {.noise_v = 3.0, .samples = 1};
    const tumble_stand_record_t averaged = {.noise_v = 3.0, .samples = 9, .least_noise_v = 0.5};
    const tumble_stand_record_t floored = {.noise_v = 3.0, .samples = 1000000, .least_noise_v = 1.5};
    const tumble_judged_run_t runs[] = {run_on_paper(&noisy, &straight), run_on_paper(&averaged, &straight),
                                        run_on_paper(&floored, &straight)};
    const double u = judged(tumble_uncertainty_refined, &runs[0]).k_v_per_g[1][0];
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1.5, u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.5, judged(tumble_uncertainty_refined, &runs[1]).k_v_per_g[1][0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.75, judged(tumble_uncertainty_refined, &runs[2]).k_v_per_g[1][0]);
}

/* An axis tilted by 1 rad, to first order: n feels 1 g all the time, in mounting 1 on y and in mounting 2 on z. */
static void test_axis_tilt_alone(void)
{
    const tumble_stand_record_t stand = {.axis_tilt_rad = 1.0, .samples = 1};
    const double k[3][3] = {{0}};
    const double u0[3] = {0.0, 1.5, 2.5};
    assert_on_paper(tumble_uncertainty_averaged, &stand, &straight, k, u0);
    assert_on_paper(tumble_uncertainty_refined, &stand, &straight, k, u0);
}

/* A turn by alpha2 about the axis mixes x with z in mounting 1 and with y in mounting 2. */
static void test_level_alone(void)
{
    const tumble_stand_record_t stand = {.level_rad = 0.5, .samples = 1};
    const double averaged[3][3] = {{0, 1, 1}, {0.75, 0, 0}, {1.25, 0, 0}};
    const double refined[3][3] = {{0, 1, 1}, {1.5, 0, 0}, {2.5, 0, 0}};
    const double u0[3] = {0, 0, 0};
    assert_on_paper(tumble_uncertainty_averaged, &stand, &straight, averaged, u0);
    assert_on_paper(tumble_uncertainty_refined, &stand, &straight, refined, u0);
}

/* A yaw puts -sin phi on y in mounting 1, on z in mounting 2. */
static void test_remounting_alone(void)
{
    const tumble_stand_record_t stand = {.remount_rad = 1.0, .samples = 1};
    const double averaged[3][3] = {{0, 0, 0}, {1.5, 0, 0}, {2.5, 0, 0}};
    const double nothing[3][3] = {{0}};
    const double u0[3] = {0, 0, 0};
    assert_on_paper(tumble_uncertainty_averaged, &stand, &straight, averaged, u0);
    assert_on_paper(tumble_uncertainty_refined, &stand, &straight, nothing, u0);
}

/* K_xx is off by (K_xz yaw2 - K_xy yaw1) / 2: two draws in quadrature, or one that may cancel. */
static void test_one_yaw_or_two(void)
{
    const tumble_coefficients_t block = {{{2, 0.03, 0.04}, {0, 2, 0}, {0, 0, 2}}, {0, 0, 0}};
    tumble_stand_record_t stand = {.remount_rad = 1.0, .samples = 1};
    const tumble_judged_run_t run = run_on_paper(&stand, &block);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.025, judged(tumble_uncertainty_refined, &run).k_v_per_g[0][0]);
    stand.common_yaw = true;
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.005, judged(tumble_uncertainty_refined, &run).k_v_per_g[0][0]);
}

/* K straight: sums over the positions of weight squared times the derivative squared. */
static void test_set_angles_alone(void)
{
    const tumble_stand_record_t stand = {.angle_rad = 1.0, .samples = 1};
    const double same = sqrt(1.0 / 32.0);
    const double refined[3][3] = {{2 * same, 2 * sqrt(10.0 / 64.0), 2 * sqrt(10.0 / 64.0)},
                                  {3 * sqrt(12.0 / 64.0), 3 * 0.25, 0},
                                  {5 * sqrt(12.0 / 64.0), 0, 5 * 0.25}};
    const double averaged[3][3] = {{refined[0][0], refined[0][1], refined[0][2]},
                                   {refined[1][0] / 2, refined[1][1], 0},
                                   {refined[2][0] / 2, 0, refined[2][2]}};
    const double u0[3] = {2 * sqrt(14.0 / 512.0), 3 * 0.125, 5 * 0.125};
    assert_on_paper(tumble_uncertainty_refined, &stand, &straight, refined, u0);
    assert_on_paper(tumble_uncertainty_averaged, &stand, &straight, averaged, u0);
}

/* Whatever the platform is off square, K_yz and K_zy follow it by K_yy and K_zz: 0.1 rad of 3 and 5 V/g. */
static void test_a_tilted_platform(void)
{
    const tumble_stand_record_t stand = {.platform_rad = 0.1, .samples = 1};
    const double k[3][3] = {{0, 0, 0}, {0, 0, 0.3}, {0, 0.5, 0}};
    const double u0[3] = {0};
    assert_on_paper(tumble_uncertainty_refined, &stand, &straight, k, u0);
    assert_on_paper(tumble_uncertainty_averaged, &stand, &straight, k, u0);
    assert_on_paper(tumble_uncertainty_least_squares, &stand, &straight, k, u0);
}

static void test_sources_add_in_quadrature(void)
{
    const tumble_stand_record_t stand = {1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 0.0, 1, false, 6e-3, 7e-3, 8e-3, 9e-3, {0}, {0}};
    const tumble_stand_record_t alone[9] = {
        {.axis_tilt_rad = 1e-3, .samples = 1}, {.level_rad = 2e-3, .samples = 1},   {.remount_rad = 3e-3, .samples = 1},
        {.angle_rad = 4e-3, .samples = 1},     {.noise_v = 5e-3, .samples = 1},     {.seat_rad = 6e-3, .samples = 1},
        {.platform_rad = 7e-3, .samples = 1},  {.encoder_rad = 8e-3, .samples = 1}, {.drift_v = 9e-3, .samples = 1}};
    dice_t dice = {71};
    const tumble_coefficients_t block = random_block(&dice);
    double k[3][3] = {{0}};
    double u0[3] = {0};
    for (int source = 0; source < 9; source++) {
        const tumble_judged_run_t run = run_on_paper(&alone[source], &block);
        const tumble_uncertainty_t part = judged(tumble_uncertainty_refined, &run);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                k[i][j] += part.k_v_per_g[i][j] * part.k_v_per_g[i][j];
            }
            u0[i] += part.u0_v[i] * part.u0_v[i];
        }
    }
    for (int cell = 0; cell < 12; cell++) {
        double *square = (cell < 9) ? &k[cell / 3][cell % 3] : &u0[cell - 9];
        *square = sqrt(*square);
    }
    assert_on_paper(tumble_uncertainty_refined, &stand, &block, k, u0);
}

static void assert_refuses(judge_t *judge, const tumble_judged_run_t *run, tumble_status_t expected, uint64_t missing)
{
    tumble_uncertainty_t uncertainty;
    tumble_uncertainty_t as_it_was;
    tumble_refusal_t refusal = {0xFFFFFFFFU, 0xFF};
    memset(&uncertainty, 0x5A, sizeof uncertainty);
    as_it_was = (expected == TUMBLE_E_NOT_FINITE) ? (tumble_uncertainty_t){0} : uncertainty;
    ASSERT_STATUS(expected, judge(run, &uncertainty, &refusal));
    TEST_ASSERT_EQUAL_HEX64(missing, refusal.missing);
    TEST_ASSERT_EQUAL_HEX8(0, refusal.unidentified);
    ASSERT_STATUS(expected, judge(run, &uncertainty, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &uncertainty, sizeof uncertainty);
}

static tumble_status_t by_table(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                tumble_refusal_t *refusal)
{
    static double table[12 * 54];
    const tumble_gain_table_t gains = {table, 18, 0.0};
    for (size_t g = 0; g < COUNT_OF(table); g++) {
        table[g] = 0.01 * (double)(g % 7U);
    }
    if (refusal != NULL) {
        *refusal = (tumble_refusal_t){0, 0};
    }
    return tumble_uncertainty_gains(&gains, run, uncertainty);
}

static judge_t *const judges[] = {tumble_uncertainty_averaged, tumble_uncertainty_refined,
                                  tumble_uncertainty_least_squares, by_table};

static void test_null_pointers_are_refused(void)
{
    const tumble_judged_run_t good = run_on_paper(&no_errors, &straight);
    for (size_t j = 0; j < COUNT_OF(judges); j++) {
        tumble_judged_run_t bad = good;
        bad.schedule = NULL;
        assert_refuses(judges[j], &bad, TUMBLE_E_ARGUMENT, 0);
        bad = good;
        bad.stand = NULL;
        assert_refuses(judges[j], &bad, TUMBLE_E_ARGUMENT, 0);
        bad = good;
        bad.coefficients = NULL;
        assert_refuses(judges[j], &bad, TUMBLE_E_ARGUMENT, 0);
        assert_refuses(judges[j], NULL, TUMBLE_E_ARGUMENT, 0);
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, judges[j](&good, NULL, NULL));
    }
    tumble_uncertainty_t uncertainty;
    const tumble_gain_table_t empty = {NULL, 18, 0.0};
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_uncertainty_gains(NULL, &good, &uncertainty));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_uncertainty_gains(&empty, &good, &uncertainty));
}

static void test_a_stand_out_of_range_is_refused(void)
{
    static const double bad[] = {-1e-300, NOT_A_NUMBER, INFINITE, -INFINITE};
    for (int source = 0; source < 10; source++) {
        const double largest = (source < 7) ? TUMBLE_MAX_STAND_SIGMA_RAD : TUMBLE_MAX_MEAN_V;
        tumble_stand_record_t stand = no_errors;
        double *const sigmas[] = {&stand.axis_tilt_rad, &stand.level_rad,    &stand.remount_rad, &stand.angle_rad,
                                  &stand.seat_rad,      &stand.platform_rad, &stand.encoder_rad, &stand.drift_v,
                                  &stand.noise_v,       &stand.least_noise_v};
        const tumble_judged_run_t run = run_on_paper(&stand, &straight);
        *sigmas[source] = largest;
        (void)judged(tumble_uncertainty_refined, &run);
        for (size_t b = 0; b <= COUNT_OF(bad); b++) {
            *sigmas[source] = (b < COUNT_OF(bad)) ? bad[b] : one_ulp_beyond(largest);
            for (size_t j = 0; j < COUNT_OF(judges); j++) {
                assert_refuses(judges[j], &run, TUMBLE_E_ARGUMENT, 0);
            }
        }
    }
}

static void test_a_mean_of_no_samples_is_refused(void)
{
    tumble_stand_record_t stand = no_errors;
    uint32_t samples[18];
    tumble_judged_run_t run = run_on_paper(&stand, &straight);
    stand.samples = 0;
    assert_refuses(tumble_uncertainty_refined, &run, TUMBLE_E_ARGUMENT, 0);
    stand.samples = 1;
    run.samples = samples;
    for (int empty = 0; empty < 18; empty++) {
        for (int p = 0; p < 18; p++) {
            samples[p] = (p == empty) ? 0U : 1U;
        }
        assert_refuses(tumble_uncertainty_refined, &run, TUMBLE_E_ARGUMENT, 0);
    }
}

static void test_a_k_that_is_no_number_or_too_large_is_refused(void)
{
    static const double bad[] = {NOT_A_NUMBER, INFINITE, -INFINITE, 1e200};
    const tumble_stand_record_t stand = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1, false, 1.0, 1.0, 1.0, 1.0, {0}, {0}};
    for (int cell = 0; cell < 9; cell++) {
        for (size_t b = 0; b < COUNT_OF(bad); b++) {
            tumble_coefficients_t block = straight;
            block.k_v_per_g[cell / 3][cell % 3] = bad[b];
            const tumble_judged_run_t run = run_on_paper(&stand, &block);
            for (size_t j = 0; j < COUNT_OF(judges); j++) {
                assert_refuses(judges[j], &run, TUMBLE_E_NOT_FINITE, 0);
            }
        }
    }
}

static void test_refusals_of_the_estimators(void)
{
    const tumble_schedule_t shorter = {tumble_schedule_paper.mountings, tumble_schedule_paper.positions, 2, 17};
    bool measured[18];
    tumble_judged_run_t run = {.schedule = &shorter, .stand = &no_errors, .coefficients = &straight};
    assert_refuses(tumble_uncertainty_averaged, &run, TUMBLE_E_NOT_HARMONIC, 0);
    assert_refuses(by_table, &run, TUMBLE_E_GAIN_TABLE, 0);
    run = run_on_paper(&no_errors, &straight);
    run.measured = measured;
    for (unsigned lost = 0; lost < 18U; lost++) {
        for (unsigned p = 0; p < 18U; p++) {
            measured[p] = p != lost;
        }
        assert_refuses(tumble_uncertainty_averaged, &run, TUMBLE_E_MISSING_POSITION, UINT32_C(1) << lost);
        assert_refuses(tumble_uncertainty_refined, &run, TUMBLE_E_MISSING_POSITION, UINT32_C(1) << lost);
        assert_refuses(by_table, &run, TUMBLE_E_MISSING_POSITION, 0);
    }
}

/* A gain table asks for every fit position, but not for those that are checked only. */
static void test_a_gain_table_does_not_ask_for_check_positions(void)
{
    tumble_position_t positions[19];
    bool measured[19];
    memcpy(positions, tumble_schedule_paper.positions, 18U * sizeof positions[0]);
    positions[18] = (tumble_position_t){1, 101, TUMBLE_USE_CHECK, steps_of_7_5_deg[3]};
    const tumble_schedule_t extended = {tumble_schedule_paper.mountings, positions, 2, 19};
    for (int p = 0; p < 19; p++) {
        measured[p] = p < 18;
    }
    const tumble_judged_run_t run = {&extended, &no_errors, &straight, measured, NULL, 0,
                                     NULL,      NULL,       NULL,      NULL,     NULL, NULL};
    (void)judged(by_table, &run);
}
