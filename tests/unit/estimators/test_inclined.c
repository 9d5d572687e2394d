/* The block that is bolted on once: inclinations that nobody knows, against outputs made of the exact geometry. */
#include "core/inclined.h"
#include "estimator_bench.h"

#include <math.h>

#define PI 3.14159265358979323846

/* A schedule of inclinations, and what was done in truth. */
typedef struct {
    tumble_mounting_t mountings[TUMBLE_MAX_YAWS];
    tumble_position_t positions[TUMBLE_MAX_POSITIONS];
    tumble_schedule_t schedule;
    double beta[TUMBLE_MAX_YAWS];
    double tau[TUMBLE_MAX_YAWS];
} inclined_run_t;

static inclined_run_t run;
static tumble_means_t means;

static tumble_angle_t angle_at(double deg)
{
    const double radians = deg * (PI / 180.0);
    return (tumble_angle_t){deg, sin(radians), cos(radians)};
}

/* Inclinations 0, 40, -40, then others anywhere; each off by up to `error` rad, as is the zero of its table angle. */
static void draw_run(dice_t *dice, inclined_run_t *done, uint8_t inclinations, double error)
{
    static const double nominal[TUMBLE_MAX_YAWS] = {0.0, 40.0, -40.0, 20.0, -30.0, 5.0};
    static const uint8_t numbers[] = {3, 4, 5, 6};
    uint8_t count = 0;
    double matrix[3][3];
    random_rotation(dice, matrix);
    for (uint8_t k = 0; k < inclinations; k++) {
        const uint8_t positions = numbers[dice_below(dice, COUNT_OF(numbers))];
        const double first_deg = 30.0 * dice_signed_unit(dice);
        done->mountings[k] =
            (tumble_mounting_t){.number = (uint8_t)(k + 1U), .tilt = angle_at(nominal[k]), .bolting = 7};
        memcpy(done->mountings[k].matrix, matrix, sizeof matrix);
        done->beta[k] = nominal[k] * (PI / 180.0) + error * dice_signed_unit(dice);
        done->tau[k] = (k == 0U) ? 0.0 : error * dice_signed_unit(dice);
        for (uint8_t l = 0; l < positions; l++) {
            done->positions[count++] = (tumble_position_t){(uint8_t)(k + 1U), (uint8_t)(l + 1U), TUMBLE_USE_FIT,
                                                           angle_at(first_deg + 360.0 * l / positions)};
        }
    }
    done->schedule = (tumble_schedule_t){done->mountings, done->positions, inclinations, count};
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&done->schedule, NULL));
}

static void measure(const inclined_run_t *done, const tumble_coefficients_t *block, tumble_means_t *them)
{
    for (uint8_t p = 0; p < done->schedule.position_count; p++) {
        const tumble_mounting_t *mounting = tumble_schedule_mounting_of(&done->schedule, p);
        const ptrdiff_t k = mounting - done->mountings;
        const double phi = done->positions[p].angle.deg * (PI / 180.0) + done->tau[k];
        const double f[3] = {cos(done->beta[k]) * sin(phi), sin(done->beta[k]), cos(done->beta[k]) * cos(phi)};
        them->measured[p] = true;
        for (int i = 0; i < 3; i++) {
            them->u_v[p][i] = block->u0_v[i];
            for (int n = 0; n < 9; n++) {
                them->u_v[p][i] += block->k_v_per_g[i][n / 3] * mounting->matrix[n / 3][n % 3] * f[n % 3];
            }
        }
    }
}

static void test_unknown_inclinations_do_not_matter(void)
{
    dice_t dice = {71};
    for (int round = 0; round < 500; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        const double weights[3] = {1.0 + 0.9 * dice_signed_unit(&dice), 1e3, 2e3};
        tumble_coefficients_t found;
        tumble_inclinations_t seen;
        draw_run(&dice, &run, (uint8_t)(3U + dice_below(&dice, 4)), 0.1);
        measure(&run, &block, &means);
        found = estimate_with(tumble_estimate_inclined, &run.schedule, &means);
        assert_coefficients(&block, &found, 3e-13);
        ASSERT_STATUS(TUMBLE_OK, tumble_inclined_weighted(&run.schedule, &means, (round % 2 == 0) ? weights : NULL,
                                                          &found, &seen, NULL));
        assert_coefficients(&block, &found, 3e-13);
        for (int k = 0; k < run.schedule.mounting_count; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, sin(run.beta[k]), seen.sine[k]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, cos(run.beta[k]), seen.cosine[k]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, sin(run.tau[k]), seen.turn_sine[k]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, cos(run.tau[k]), seen.turn_cosine[k]);
        }
    }
}

/* Any size of outputs: nothing overflows, and a power of two changes no bit. */
static void test_outputs_of_any_size(void)
{
    dice_t dice = {72};
    const tumble_coefficients_t block = random_block(&dice);
    draw_run(&dice, &run, 3, 0.01);
    measure(&run, &block, &means);
    tumble_coefficients_t expected = estimate_with(tumble_estimate_inclined, &run.schedule, &means);
    for (int power = -330; power <= 330; power += 66) {
        static tumble_means_t scaled;
        tumble_coefficients_t of_scaled = expected;
        scaled = means;
        for (int cell = 0; cell < 3 * TUMBLE_MAX_POSITIONS; cell++) {
            scaled.u_v[cell / 3][cell % 3] = ldexp(means.u_v[cell / 3][cell % 3], power);
        }
        for (int cell = 0; cell < 9; cell++) {
            of_scaled.k_v_per_g[cell / 3][cell % 3] = ldexp(expected.k_v_per_g[cell / 3][cell % 3], power);
        }
        for (int i = 0; i < 3; i++) {
            of_scaled.u0_v[i] = ldexp(expected.u0_v[i], power);
        }
        const tumble_coefficients_t found = estimate_with(tumble_estimate_inclined, &run.schedule, &scaled);
        assert_same_coefficients(&of_scaled, &found);
    }
}

/* + and - exchanged: nothing in the run shows it, and K along the axis has the other sign. */
static void test_the_sign_is_that_of_the_schedule(void)
{
    dice_t dice = {73};
    tumble_coefficients_t block = random_block(&dice);
    draw_run(&dice, &run, 3, 0.01);
    memcpy(run.mountings[0].matrix, tumble_schedule_paper.mountings[0].matrix, sizeof run.mountings[0].matrix);
    memcpy(run.mountings[1].matrix, run.mountings[0].matrix, sizeof run.mountings[0].matrix);
    memcpy(run.mountings[2].matrix, run.mountings[0].matrix, sizeof run.mountings[0].matrix);
    for (int k = 0; k < 3; k++) {
        run.beta[k] = -run.beta[k];
    }
    measure(&run, &block, &means);
    const tumble_coefficients_t found = estimate_with(tumble_estimate_inclined, &run.schedule, &means);
    for (int i = 0; i < 3; i++) {
        block.k_v_per_g[i][1] = -block.k_v_per_g[i][1];
    }
    assert_coefficients(&block, &found, 1e-13);
}

static const tumble_refusal_t none = {0, 0};

static void test_schedules_that_do_not_offer_it(void)
{
    static const tumble_schedule_t *const others[] = {&tumble_schedule_paper, &tumble_schedule_three_mountings,
                                                      &tumble_schedule_diagonal, &tumble_schedule_six_faces};
    dice_t dice = {74};
    const tumble_coefficients_t block = random_block(&dice);
    for (size_t i = 0; i < COUNT_OF(others); i++) {
        model_means(others[i], &block, &means);
        assert_estimator_refuses(tumble_estimate_inclined, others[i], &means, TUMBLE_E_NOT_INCLINED, none);
    }
    enum { OTHER_BOLTING, NO_BOLTING, OTHER_MATRIX, TWO_ANGLES, UNEQUAL, ONE_SIDE, TWO_INCLINATIONS, WAYS };
    for (int way = 0; way < WAYS; way++) {
        draw_run(&dice, &run, (way == TWO_INCLINATIONS) ? 2 : 3, 0.01);
        measure(&run, &block, &means);
        run.mountings[1].bolting = (way == OTHER_BOLTING) ? 8 : (way == NO_BOLTING) ? 0 : 7;
        if (way == OTHER_MATRIX) {
            random_rotation(&dice, run.mountings[1].matrix);
        } else if (way == TWO_ANGLES) {
            run.positions[0].use = TUMBLE_USE_CHECK;
        } else if (way == UNEQUAL) {
            run.positions[1].angle = angle_at(run.positions[1].angle.deg + 1.0);
        } else if (way == ONE_SIDE) {
            run.mountings[2].tilt = angle_at(10.0);
        } else {
            ; /* it is so already */
        }
        assert_estimator_refuses(tumble_estimate_inclined, &run.schedule, &means, TUMBLE_E_NOT_INCLINED, none);
    }
}

static void test_runs_that_contradict_their_schedule(void)
{
    dice_t dice = {75};
    const tumble_coefficients_t block = random_block(&dice);
    draw_run(&dice, &run, 3, 0.0);
    measure(&run, &block, &means);
    means.measured[4] = false;
    assert_estimator_refuses(tumble_estimate_inclined, &run.schedule, &means, TUMBLE_E_MISSING_POSITION,
                             (tumble_refusal_t){UINT64_C(1) << 4, 0});
    run.beta[2] = 0.3; /* all on one side */
    measure(&run, &block, &means);
    assert_estimator_refuses(tumble_estimate_inclined, &run.schedule, &means, TUMBLE_E_ONE_SIDE, none);
    run.beta[1] = run.beta[2] = run.beta[0] = 0.0; /* never inclined */
    measure(&run, &block, &means);
    assert_estimator_refuses(tumble_estimate_inclined, &run.schedule, &means, TUMBLE_E_ALIKE, none);
    memset(means.u_v, 0, sizeof means.u_v);
    assert_estimator_refuses(tumble_estimate_inclined, &run.schedule, &means, TUMBLE_E_ALIKE, none);
    means.u_v[2][1] = NOT_A_NUMBER;
    assert_estimator_refuses(tumble_estimate_inclined, &run.schedule, &means, TUMBLE_E_NOT_FINITE, none);
    assert_estimator_refuses_null(tumble_estimate_inclined);
}

static void test_a_weight_is_above_0(void)
{
    static const double bad[] = {0.0, -1.0, INFINITE, NOT_A_NUMBER};
    dice_t dice = {76};
    tumble_coefficients_t block = random_block(&dice);
    draw_run(&dice, &run, 3, 0.01);
    measure(&run, &block, &means);
    for (size_t i = 0; i < 3U * COUNT_OF(bad); i++) {
        double weights[3] = {1.0, 1.0, 1.0};
        weights[i % 3U] = bad[i / 3U];
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_inclined_weighted(&run.schedule, &means, weights, &block, NULL, NULL));
    }
}

/* The sum of all coefficients, weighed by `seed`, and of inclinations, of a run that has been solved. */
static double weighed(const double seed[4][3], const double sine_seed[TUMBLE_MAX_YAWS], const tumble_inclined_t *done,
                      int inclinations)
{
    double sum = 0.0;
    for (int k = 0; k < inclinations; k++) {
        sum += sine_seed[k] * done->seen.sine[k];
    }
    for (int n = 0; n < 12; n++) {
        sum += seed[n / 3][n % 3] * ((n < 9) ? done->column[n / 3][n % 3] : done->bias[n % 3]);
    }
    return sum;
}

static void test_gains_are_the_derivatives(void)
{
    static tumble_inclined_map_t map;
    static tumble_inclined_t solved;
    static tumble_inclined_t moved;
    static tumble_harmonics_t gains;
    dice_t dice = {77};
    for (int round = 0; round < 60; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        const double weights[3] = {1.0, 0.5, 2.0};
        double seed[4][3];
        double sine_seed[TUMBLE_MAX_YAWS];
        draw_run(&dice, &run, (uint8_t)(3U + dice_below(&dice, 4)), 0.05);
        measure(&run, &block, &means);
        for (int k = 0; k < TUMBLE_MAX_YAWS; k++) {
            sine_seed[k] = (round % 2 == 0) ? dice_signed_unit(&dice) : 0.0;
        }
        for (int cell = 0; cell < 3 * run.schedule.position_count; cell++) {
            means.u_v[cell / 3][cell % 3] += 1e-3 * dice_signed_unit(&dice);
        }
        for (int n = 0; n < 12; n++) {
            seed[n / 3][n % 3] = dice_signed_unit(&dice);
        }
        ASSERT_STATUS(TUMBLE_OK, tumble_schedule_inclinations(&run.schedule, NULL, &map, NULL));
        ASSERT_STATUS(TUMBLE_OK, tumble_inclined_solve(&map, &means, weights, &solved));
        tumble_inclined_gains(&map, &solved, (const double (*)[3])seed, sine_seed, gains);
        for (int cell = 0; cell < 3 * run.schedule.position_count; cell++) {
            const int p = cell / 3;
            const int i = cell % 3;
            const ptrdiff_t k = tumble_schedule_mounting_of(&run.schedule, (uint8_t)p) - run.mountings;
            const tumble_angle_t *angle = &run.positions[p].angle;
            const double gain =
                (2.0 * (angle->sine * gains[k][TUMBLE_SINE][i] + angle->cosine * gains[k][TUMBLE_COSINE][i]) +
                 gains[k][TUMBLE_LEVEL][i]) /
                map.positions[k];
            const double before = means.u_v[p][i];
            double difference = 0.0;
            for (int sign = -1; sign <= 1; sign += 2) {
                means.u_v[p][i] = before + sign * 1e-5;
                ASSERT_STATUS(TUMBLE_OK, tumble_inclined_solve(&map, &means, weights, &moved));
                difference += sign * weighed((const double (*)[3])seed, sine_seed, &moved, map.count) / 2e-5;
            }
            means.u_v[p][i] = before;
            TEST_ASSERT_DOUBLE_WITHIN(3e-8, difference, gain);
        }
    }
}

/* Three inclinations, the block square on its axes, n positions at each: of the level tells 3/2 + cot^2 beta / 2 of the
 * variance of a mean over n and the squared scale, and no error of an angle anything. */
static void test_the_uncertainty_of_the_level(void)
{
    static const tumble_coefficients_t square = {{{2.5, 0.0, 0.0}, {0.0, 2.5, 0.0}, {0.0, 0.0, 2.5}}, {1.0, 2.0, 3.0}};
    tumble_stand_record_t stand = {.noise_v = 4e-3, .samples = 16};
    const tumble_judged_run_t level = {.schedule = &tumble_schedule_inclined, .stand = &stand, .coefficients = &square};
    const double u_rad = (1e-3 / 2.5) * sqrt((1.5 + 0.5) / 8.0); /* at 45 degrees */
    for (int other = 0; other < 2; other++) {
        tumble_shown_inclinations_t shown;
        ASSERT_STATUS(TUMBLE_OK, tumble_uncertainty_inclinations(&level, &shown, NULL));
        TEST_ASSERT_EQUAL_UINT8(3, shown.count);
        TEST_ASSERT_TRUE(shown.has_level);
        ASSERT_SAME_DOUBLE(0.0, shown.level_rad);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12 * u_rad, u_rad, shown.u_level_rad);
        TEST_ASSERT_DOUBLE_WITHIN(1e-10 * u_rad, u_rad * 180.0 / PI, shown.u_deg[0]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, 45.0, shown.deg[1]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, -45.0, shown.deg[2]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-10 * shown.u_deg[1], shown.u_deg[1], shown.u_deg[2]);
        ASSERT_SAME_DOUBLE(0.0, shown.deg[3]);
        stand.axis_tilt_rad = stand.level_rad = stand.remount_rad = stand.seat_rad = stand.platform_rad = 1e-3;
        stand.angle_rad = 1e-3;
    }
}

/* Of the sines and cosines that a run shows, the angles, up to 0.3 rad off the schedule's. */
static void test_the_angles_of_inclinations(void)
{
    static const tumble_stand_record_t stand = {.noise_v = 1e-4, .samples = 1};
    dice_t dice = {80};
    for (int round = 0; round < 300; round++) {
        tumble_coefficients_t found;
        tumble_inclinations_t seen;
        tumble_shown_inclinations_t shown;
        const tumble_coefficients_t block = random_block(&dice);
        draw_run(&dice, &run, (uint8_t)(3U + dice_below(&dice, 4)), 0.3);
        run.mountings[0].tilt = angle_at((round % 2 == 0) ? 0.0 : 1.0);
        measure(&run, &block, &means);
        ASSERT_STATUS(TUMBLE_OK, tumble_inclined_weighted(&run.schedule, &means, NULL, &found, &seen, NULL));
        const tumble_judged_run_t judged = {
            .schedule = &run.schedule, .stand = &stand, .coefficients = &found, .inclinations = &seen};
        ASSERT_STATUS(TUMBLE_OK, tumble_uncertainty_inclinations(&judged, &shown, NULL));
        TEST_ASSERT_EQUAL_UINT8(run.schedule.mounting_count, shown.count);
        for (int k = 0; k < shown.count; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-10, run.beta[k] * 180.0 / PI, shown.deg[k]);
            TEST_ASSERT_DOUBLE_WITHIN(3e-13, asin(seen.sine[k]) * 180.0 / PI, shown.deg[k]);
        }
        TEST_ASSERT_EQUAL(round % 2 == 0, shown.has_level);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, shown.has_level ? run.beta[0] : 0.0, shown.level_rad);
    }
    const tumble_judged_run_t bad = {.schedule = &tumble_schedule_paper, .stand = &stand};
    tumble_shown_inclinations_t shown = {.count = 3};
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_uncertainty_inclinations(&bad, &shown, NULL));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_uncertainty_inclinations(NULL, &shown, NULL));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_uncertainty_inclinations(&bad, NULL, NULL));
}

/* What was found makes outputs again of which the same is found. */
static void test_a_run_made_again_of_its_coefficients(void)
{
    static tumble_inclined_map_t map;
    static tumble_inclined_t again;
    dice_t dice = {78};
    for (int round = 0; round < 100; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        tumble_inclinations_t seen;
        tumble_coefficients_t found;
        draw_run(&dice, &run, (uint8_t)(3U + dice_below(&dice, 4)), 0.05);
        measure(&run, &block, &means);
        ASSERT_STATUS(TUMBLE_OK, tumble_inclined_weighted(&run.schedule, &means, NULL, &found, &seen, NULL));
        ASSERT_STATUS(TUMBLE_OK, tumble_schedule_inclinations(&run.schedule, NULL, &map, NULL));
        ASSERT_STATUS(TUMBLE_OK, tumble_inclined_again(&map, &found, &seen, NULL, &again));
        for (int k = 0; k < run.schedule.mounting_count; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, seen.sine[k], again.seen.sine[k]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, seen.turn_sine[k], again.seen.turn_sine[k]);
        }
    }
}

static void test_built_in_schedules(void)
{
    dice_t dice = {79};
    const tumble_schedule_t *const schedules[] = {&tumble_schedule_inclined, &tumble_schedule_inclined_closed};
    for (int s = 0; s < 2; s++) {
        const tumble_coefficients_t block = random_block(&dice);
        ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(schedules[s], NULL));
        TEST_ASSERT_EQUAL_UINT8(27 + 9 * s, schedules[s]->position_count);
        model_means(schedules[s], &block, &means);
        const tumble_coefficients_t found = estimate_with(tumble_estimate_inclined, schedules[s], &means);
        assert_coefficients(&block, &found, 1e-13);
        means.measured[8] = false; /* to check only */
        const tumble_coefficients_t without = estimate_with(tumble_estimate_inclined, schedules[s], &means);
        assert_same_coefficients(&found, &without);
    }
}
