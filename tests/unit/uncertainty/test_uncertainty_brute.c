/* Standard uncertainties against brute force: gains from unit means, derivatives from differences. */
#include "random_schedule.h"
#include "uncertainty_bench.h"

/* The gains of an estimator, from what it makes of unit means: one column per fit position and channel. */
static void gains_of(estimator_t *estimator, const tumble_schedule_t *schedule, double *gains)
{
    static tumble_means_t means;
    const size_t columns = 3U * (size_t)count_fit_positions(schedule);
    size_t column = 0;
    for (unsigned p = 0; p < schedule->position_count; p++) {
        for (int i = 0; (i < 3) && (schedule->positions[p].use == TUMBLE_USE_FIT); i++) {
            memset(&means, 0, sizeof means);
            for (unsigned all = 0; all < schedule->position_count; all++) {
                means.measured[all] = true;
            }
            means.u_v[p][i] = 1.0;
            const tumble_coefficients_t unit = estimate_with(estimator, schedule, &means);
            for (size_t row = 0; row < 12U; row++) {
                gains[row * columns + column] = (row < 9U) ? unit.k_v_per_g[row / 3U][row % 3U] : unit.u0_v[row - 9U];
            }
            column++;
        }
    }
}

/* Every error of a stand is a change of the schedule's data: this moves one position, by the sine and cosine of a
 * small x. */
typedef enum { ALPHA1, ALPHA2, ALPHA3, THETA_H, ERRORS } error_t;

static void move_position(tumble_mounting_t *mounting, tumble_angle_t *angle, error_t error, double sine, double cosine)
{
    if (error == ALPHA1) {
        const tumble_angle_t tilt = mounting->tilt;
        mounting->tilt.sine = tilt.sine * cosine + tilt.cosine * sine;
        mounting->tilt.cosine = tilt.cosine * cosine - tilt.sine * sine;
    } else if (error == ALPHA2) {
        const tumble_angle_t level = *angle;
        angle->sine = level.sine * cosine + level.cosine * sine;
        angle->cosine = level.cosine * cosine - level.sine * sine;
    } else if (error == ALPHA3) {
        for (int i = 0; i < 3; i++) {
            const double h = mounting->matrix[i][0];
            const double n = mounting->matrix[i][1];
            mounting->matrix[i][0] = h * cosine - n * sine;
            mounting->matrix[i][1] = n * cosine + h * sine;
        }
    } else {
        for (int i = 0; i < 3; i++) {
            const double n = mounting->matrix[i][1];
            const double v = mounting->matrix[i][2];
            mounting->matrix[i][1] = n * cosine - v * sine;
            mounting->matrix[i][2] = v * cosine + n * sine;
        }
    }
}

#define STEP 0x1p-20

/* Derivative of the force at one position by central differences: good to about 1e-10. */
static void force_derivative(const tumble_schedule_t *schedule, unsigned p, error_t error, double derivative[3])
{
    double force[2][3];
    for (int side = 0; side < 2; side++) {
        tumble_mounting_t mounting = *model_mounting(schedule, p);
        tumble_position_t position = schedule->positions[p];
        const double x = (side == 0) ? -STEP : STEP;
        move_position(&mounting, &position.angle, error, x * (1.0 - STEP * STEP / 6.0), 1.0 - STEP * STEP / 2.0);
        const tumble_schedule_t moved = {&mounting, &position, 1, 1};
        dd_t a[3];
        model_attitude(&moved, 0, a);
        for (int j = 0; j < 3; j++) {
            force[side][j] = dd_round(a[j]);
        }
    }
    for (int j = 0; j < 3; j++) {
        derivative[j] = (force[1][j] - force[0][j]) / (2.0 * STEP);
    }
}

static double wave_at(const tumble_schedule_t *schedule, unsigned p, int number)
{
    const double angle = schedule->positions[p].angle.deg * acos(-1.0) / 180.0 * ((number < 2) ? 1.0 : 2.0);
    return ((number % 2) == 0) ? sin(angle) : cos(angle);
}

/* One row by brute force. */
static double brute_force(const tumble_judged_run_t *run, const double *gains)
{
    const tumble_schedule_t *schedule = run->schedule;
    const tumble_stand_record_t *stand = run->stand;
    double sums[ERRORS] = {0};
    double by_mounting[ERRORS][256] = {{0}};
    double squares = 0.0;
    double waves[4] = {0};
    double drifts[3] = {0};
    int fit = 0;
    const int fits = (int)count_fit_positions(schedule);
    for (unsigned p = 0; p < schedule->position_count; p++) {
        if (schedule->positions[p].use != TUMBLE_USE_FIT) {
            continue;
        }
        const double n = (double)((run->samples != NULL) ? run->samples[p] : stand->samples);
        for (int error = 0; error < ERRORS; error++) {
            double force[3];
            double effect = 0.0;
            force_derivative(schedule, p, (error_t)error, force);
            for (int i = 0; i < 3; i++) {
                for (int j = 0; j < 3; j++) {
                    effect += gains[i] * run->coefficients->k_v_per_g[i][j] * force[j];
                }
            }
            sums[error] += effect;
            by_mounting[error][schedule->positions[p].mounting] += effect;
            squares += (error == ALPHA2) ? stand->angle_rad * stand->angle_rad * effect * effect : 0.0;
            for (int wave = 0; (wave < 4) && (error == ALPHA2); wave++) {
                waves[wave] += effect * wave_at(schedule, p, wave);
            }
        }
        for (int i = 0; i < 3; i++) {
            drifts[i] += gains[i] * ((fits > 1) ? (double)fit / (fits - 1) - 0.5 : -0.5);
        }
        fit++;
        for (int i = 0; i < 3; i++) {
            const double noise = stand->noise_v / sqrt(n);
            const double counted = (noise > stand->least_noise_v) ? noise : stand->least_noise_v;
            const double excess = (run->excess_variance_v2 != NULL) ? run->excess_variance_v2[p][i] : 0.0;
            squares += (counted * counted + excess) * gains[i] * gains[i];
        }
        gains += 3;
    }
    const double tilt = stand->axis_tilt_rad * sums[ALPHA1];
    const double level = stand->level_rad * sums[ALPHA2];
    const double platform = stand->platform_rad * sums[THETA_H];
    double yaw = stand->common_yaw ? sums[ALPHA3] * sums[ALPHA3] : 0.0;
    double seat = 0.0;
    for (int m = 0; m < 256; m++) {
        yaw += stand->common_yaw ? 0.0 : by_mounting[ALPHA3][m] * by_mounting[ALPHA3][m];
        seat += by_mounting[THETA_H][m] * by_mounting[THETA_H][m] + by_mounting[ALPHA2][m] * by_mounting[ALPHA2][m];
    }
    for (int n = 0; n < 4; n++) {
        squares += stand->encoder_rad * stand->encoder_rad * waves[n] * waves[n];
        squares += (n < 3) ? stand->drift_v * stand->drift_v * drifts[n] * drifts[n] : 0.0;
    }
    return sqrt(tilt * tilt + level * level + platform * platform + stand->remount_rad * stand->remount_rad * yaw +
                stand->seat_rad * stand->seat_rad * seat + squares);
}

static tumble_stand_record_t random_stand(dice_t *dice)
{
    return (tumble_stand_record_t){
        .axis_tilt_rad = 1e-3 * magnitude(dice_signed_unit(dice)),
        .level_rad = 1e-3 * magnitude(dice_signed_unit(dice)),
        .remount_rad = 1e-3 * magnitude(dice_signed_unit(dice)),
        .angle_rad = 1e-3 * magnitude(dice_signed_unit(dice)),
        .noise_v = 1e-3 * magnitude(dice_signed_unit(dice)),
        .least_noise_v = 1e-4 * magnitude(dice_signed_unit(dice)),
        .samples = 1U + dice_below(dice, 100),
        .common_yaw = dice_below(dice, 2) == 0U,
        .seat_rad = 1e-3 * magnitude(dice_signed_unit(dice)),
        .platform_rad = 1e-3 * magnitude(dice_signed_unit(dice)),
        .encoder_rad = 1e-3 * magnitude(dice_signed_unit(dice)),
        .drift_v = 1e-3 * magnitude(dice_signed_unit(dice)),
    };
}

static void assert_as_by_brute_force(const tumble_judged_run_t *run, const double *gains,
                                     const tumble_uncertainty_t *found)
{
    const size_t columns = 3U * (size_t)count_fit_positions(run->schedule);
    double expected[12];
    for (size_t row = 0; row < 12U; row++) {
        expected[row] = brute_force(run, gains + row * columns);
    }
    const double k[3][3] = {{expected[0], expected[1], expected[2]},
                            {expected[3], expected[4], expected[5]},
                            {expected[6], expected[7], expected[8]}};
    assert_uncertainties(k, expected + 9, found, 1e-8);
}

static double table[12 * 3 * TUMBLE_MAX_POSITIONS];

static void test_least_squares_on_any_schedule(void)
{
    static random_schedule_t s;
    dice_t dice = {72};
    int judged_schedules = 0;
    for (int round = 0; round < 60; round++) {
        random_schedule(&dice, &s);
        const tumble_coefficients_t block = random_block(&dice);
        const tumble_stand_record_t stand = random_stand(&dice);
        const tumble_judged_run_t run = {.schedule = &s.schedule, .stand = &stand, .coefficients = &block};
        uint8_t unidentified = 0;
        if (tumble_schedule_identify(&s.schedule, NULL, &unidentified) != TUMBLE_OK) {
            tumble_uncertainty_t found;
            tumble_refusal_t refusal = {1, 0};
            ASSERT_STATUS(TUMBLE_E_RANK, tumble_uncertainty_least_squares(&run, &found, &refusal));
            TEST_ASSERT_EQUAL_HEX8(unidentified, refusal.unidentified);
            TEST_ASSERT_EQUAL_HEX64(0, refusal.missing);
            continue;
        }
        gains_of(tumble_estimate_least_squares, &s.schedule, table);
        const tumble_uncertainty_t found = judged(tumble_uncertainty_least_squares, &run);
        assert_as_by_brute_force(&run, table, &found);
        judged_schedules++;
    }
    TEST_ASSERT_GREATER_THAN_INT(20, judged_schedules);
}

static void test_harmonic_estimators_among_other_positions(void)
{
    static tumble_position_t positions[TUMBLE_MAX_POSITIONS];
    static const struct {
        judge_t *judge;
        estimator_t *estimator;
    } pairs[] = {{tumble_uncertainty_averaged, tumble_estimate_averaged},
                 {tumble_uncertainty_refined, tumble_estimate_refined}};
    dice_t dice = {73};
    positions[0] = (tumble_position_t){1, 101, TUMBLE_USE_FIT, steps_of_7_5_deg[3]};
    positions[1] = (tumble_position_t){2, 101, TUMBLE_USE_CHECK, steps_of_7_5_deg[9]};
    memcpy(positions + 2, tumble_schedule_paper.positions, 18U * sizeof positions[0]);
    const tumble_schedule_t extended = {tumble_schedule_paper.mountings, positions, 2, 20};
    uint32_t samples[20];
    static double excess[20][3];
    for (int round = 0; round < 20; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        const tumble_stand_record_t stand = random_stand(&dice);
        for (int p = 0; p < 20; p++) {
            samples[p] = 1U + dice_below(&dice, 100);
        }
        samples[1] = 0; /* of a check position: nobody asks */
        for (int i = 0; i < 60; i++) {
            excess[i / 3][i % 3] = 1e-6 * magnitude(dice_signed_unit(&dice));
        }
        const tumble_judged_run_t run = {.schedule = &extended,
                                         .stand = &stand,
                                         .coefficients = &block,
                                         .samples = samples,
                                         .excess_variance_v2 = (round % 2 != 0) ? excess : NULL};
        for (size_t pair = 0; pair < COUNT_OF(pairs); pair++) {
            gains_of(pairs[pair].estimator, &extended, table);
            const tumble_uncertainty_t found = judged(pairs[pair].judge, &run);
            assert_as_by_brute_force(&run, table, &found);
        }
    }
}

static void test_any_gain_table(void)
{
    static random_schedule_t s;
    dice_t dice = {74};
    for (int round = 0; round < 40; round++) {
        random_schedule(&dice, &s);
        const tumble_coefficients_t block = random_block(&dice);
        const tumble_stand_record_t stand = random_stand(&dice);
        const tumble_judged_run_t run = {.schedule = &s.schedule, .stand = &stand, .coefficients = &block};
        const tumble_gain_table_t gains = {table, count_fit_positions(&s.schedule), 0.0};
        for (size_t g = 0; g < COUNT_OF(table); g++) {
            table[g] = 3.0 * dice_signed_unit(&dice);
        }
        tumble_uncertainty_t found;
        ASSERT_STATUS(TUMBLE_OK, tumble_uncertainty_gains(&gains, &run, &found));
        assert_as_by_brute_force(&run, table, &found);
    }
}

/* What was not measured is as if the schedule did not have it. */
static void test_positions_that_were_not_measured_do_not_count(void)
{
    dice_t dice = {75};
    const tumble_coefficients_t block = random_block(&dice);
    const tumble_stand_record_t stand = random_stand(&dice);
    const tumble_schedule_t shorter = {tumble_schedule_paper.mountings, tumble_schedule_paper.positions, 2, 15};
    bool measured[18];
    for (int p = 0; p < 18; p++) {
        measured[p] = p < 15;
    }
    tumble_judged_run_t run = run_on_paper(&stand, &block);
    run.measured = measured;
    const tumble_judged_run_t short_run = {.schedule = &shorter, .stand = &stand, .coefficients = &block};
    const tumble_uncertainty_t found = judged(tumble_uncertainty_least_squares, &run);
    const tumble_uncertainty_t expected = judged(tumble_uncertainty_least_squares, &short_run);
    assert_uncertainties(expected.k_v_per_g, expected.u0_v, &found, 1e-15);
    measured[15] = measured[16] = measured[17] = true;
    const tumble_uncertainty_t all = judged(tumble_uncertainty_refined, &run);
    run.measured = NULL;
    const tumble_uncertainty_t none = judged(tumble_uncertainty_refined, &run);
    TEST_ASSERT_EQUAL_MEMORY(&none, &all, sizeof all);
}
