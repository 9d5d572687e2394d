/* Gain tables: the layout of rows and columns, and that a table of an estimator is that estimator. */
#include "estimator_bench.h"
#include "random_schedule.h"

#define MOST_COLUMNS (3 * TUMBLE_MAX_POSITIONS)

static double gains[TUMBLE_COEFFICIENTS * MOST_COLUMNS];
static tumble_position_t positions[TUMBLE_MAX_POSITIONS];
static tumble_schedule_t schedule; /* the paper's with a check position before, between and after */
static tumble_means_t means;
static tumble_gain_table_t table;

#define FIT_POSITIONS 18U
#define COLUMNS (3U * FIT_POSITIONS)

static void set_up(void)
{
    uint8_t at = 0;
    for (uint8_t p = 0; p < FIT_POSITIONS; p++) {
        if (p % 6U == 0U) {
            positions[at] = (tumble_position_t){1, (uint8_t)(100U + p), TUMBLE_USE_CHECK, steps_of_7_5_deg[p]};
            at++;
        }
        positions[at] = tumble_schedule_paper.positions[p];
        at++;
    }
    positions[at] = (tumble_position_t){2, 100, TUMBLE_USE_CHECK, steps_of_7_5_deg[5]};
    schedule = (tumble_schedule_t){tumble_schedule_paper.mountings, positions, 2, (uint8_t)(at + 1U)};
    dice_t dice = {23};
    for (unsigned p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        means.measured[p] = p < schedule.position_count;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            means.u_v[p][i] = dice_signed_unit(&dice);
        }
    }
    memset(gains, 0, sizeof gains);
    table = (tumble_gain_table_t){gains, FIT_POSITIONS, 0.0};
}

static double coefficient(const tumble_coefficients_t *coefficients, unsigned row)
{
    return (row < 9U) ? coefficients->k_v_per_g[row / 3U][row % 3U] : coefficients->u0_v[row - 9U];
}

static void assert_refused(tumble_status_t expected)
{
    tumble_coefficients_t coefficients;
    tumble_coefficients_t as_they_were;
    memset(&coefficients, 0x5A, sizeof coefficients);
    as_they_were = coefficients;
    ASSERT_STATUS(expected, tumble_estimate_gains(&table, &schedule, &means, &coefficients));
    TEST_ASSERT_EQUAL_MEMORY(&as_they_were, &coefficients, sizeof coefficients);
}

static void test_each_gain_belongs_to_one_coefficient_and_one_mean(void)
{
    for (unsigned row = 0; row < TUMBLE_COEFFICIENTS; row++) {
        unsigned column = 0;
        for (unsigned p = 0; p < schedule.position_count; p++) {
            for (unsigned i = 0; i < 3U && positions[p].use == TUMBLE_USE_FIT; i++) {
                tumble_coefficients_t estimate;
                gains[row * COLUMNS + column] = 1.0;
                ASSERT_STATUS(TUMBLE_OK, tumble_estimate_gains(&table, &schedule, &means, &estimate));
                for (unsigned other = 0; other < TUMBLE_COEFFICIENTS; other++) {
                    ASSERT_SAME_DOUBLE((other == row) ? means.u_v[p][i] : 0.0, coefficient(&estimate, other));
                }
                gains[row * COLUMNS + column] = 0.0;
                column++;
            }
        }
        TEST_ASSERT_EQUAL_UINT(COLUMNS, column);
    }
}

/* Column by column from the estimator's answer to a unit mean. */
static void tabulate(estimator_t *estimator)
{
    static tumble_means_t unit;
    unsigned column = 0;
    unit = means;
    memset(unit.u_v, 0, sizeof unit.u_v);
    for (unsigned p = 0; p < schedule.position_count; p++) {
        for (unsigned i = 0; i < 3U && positions[p].use == TUMBLE_USE_FIT; i++) {
            unit.u_v[p][i] = 1.0;
            const tumble_coefficients_t answer = estimate_with(estimator, &schedule, &unit);
            for (unsigned row = 0; row < TUMBLE_COEFFICIENTS; row++) {
                gains[row * COLUMNS + column] = coefficient(&answer, row);
            }
            unit.u_v[p][i] = 0.0;
            column++;
        }
    }
}

static void test_the_table_of_an_estimator_is_that_estimator(void)
{
    static estimator_t *const estimators[] = {tumble_estimate_averaged, tumble_estimate_refined,
                                              tumble_estimate_least_squares};
    dice_t dice = {24};
    for (size_t e = 0; e < COUNT_OF(estimators); e++) {
        tabulate(estimators[e]);
        for (int round = 0; round < 100; round++) {
            const tumble_coefficients_t block = random_block(&dice);
            tumble_coefficients_t estimate;
            model_means(&schedule, &block, &means);
            ASSERT_STATUS(TUMBLE_OK, tumble_estimate_gains(&table, &schedule, &means, &estimate));
            assert_coefficients(&block, &estimate, 1e-15);
            for (unsigned cell = 0; cell < 3U * schedule.position_count; cell++) {
                means.u_v[cell / 3U][cell % 3U] = 4.0 * dice_signed_unit(&dice);
            }
            ASSERT_STATUS(TUMBLE_OK, tumble_estimate_gains(&table, &schedule, &means, &estimate));
            const tumble_coefficients_t expected = estimate_with(estimators[e], &schedule, &means);
            assert_coefficients(&expected, &estimate, 5e-15);
        }
    }
}

static void test_the_largest_table_fits(void)
{
    static random_schedule_t random;
    dice_t dice = {25};
    tumble_coefficients_t estimate;
    do {
        random_schedule(&dice, &random);
    } while (random.schedule.position_count < TUMBLE_MAX_POSITIONS);
    for (int p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        random.positions[p].use = TUMBLE_USE_FIT;
        means.measured[p] = true;
    }
    table.fit_positions = TUMBLE_MAX_POSITIONS;
    gains[COUNT_OF(gains) - 1U] = 3.0;
    ASSERT_STATUS(TUMBLE_OK, tumble_estimate_gains(&table, &random.schedule, &means, &estimate));
    ASSERT_SAME_DOUBLE(3.0 * means.u_v[TUMBLE_MAX_POSITIONS - 1][2], estimate.u0_v[2]);
}

static void test_null_pointers_are_refused(void)
{
    tumble_coefficients_t estimate;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_estimate_gains(NULL, &schedule, &means, &estimate));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_estimate_gains(&table, NULL, &means, &estimate));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_estimate_gains(&table, &schedule, NULL, &estimate));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_estimate_gains(&table, &schedule, &means, NULL));
    table.gains = NULL;
    assert_refused(TUMBLE_E_ARGUMENT);
}

static void test_a_table_for_another_number_of_positions_is_refused(void)
{
    static const uint8_t wrong[] = {0, FIT_POSITIONS - 1, FIT_POSITIONS + 1, FIT_POSITIONS + 4, UINT8_MAX};
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        table.fit_positions = wrong[i];
        assert_refused(TUMBLE_E_GAIN_TABLE);
    }
    means.measured[1] = false; /* not even asked for */
    assert_refused(TUMBLE_E_GAIN_TABLE);
}

static void test_every_fit_position_must_be_measured_and_no_other(void)
{
    tumble_coefficients_t estimate;
    for (unsigned p = 0; p < schedule.position_count; p++) {
        const bool needed = positions[p].use == TUMBLE_USE_FIT;
        means.measured[p] = false;
        if (needed) {
            assert_refused(TUMBLE_E_MISSING_POSITION);
        } else {
            ASSERT_STATUS(TUMBLE_OK, tumble_estimate_gains(&table, &schedule, &means, &estimate));
        }
        means.measured[p] = true;
    }
    schedule = tumble_schedule_paper;
    for (unsigned p = 0; p < FIT_POSITIONS; p++) {
        means.measured[p] = false;
        assert_refused(TUMBLE_E_MISSING_POSITION);
        means.measured[p] = true;
    }
}

static void test_what_is_not_finite_is_refused_where_it_was_measured(void)
{
    static const double bad[] = {NOT_A_NUMBER, INFINITE, -INFINITE, 1.0000001 * TUMBLE_MAX_MEAN_V};
    for (unsigned cell = 0; cell < 3U * schedule.position_count; cell++) {
        const double good = means.u_v[cell / 3U][cell % 3U];
        means.u_v[cell / 3U][cell % 3U] = bad[cell % COUNT_OF(bad)];
        assert_refused(TUMBLE_E_NOT_FINITE); /* even though all gains are zero */
        means.u_v[cell / 3U][cell % 3U] = good;
    }
    tumble_coefficients_t estimate;
    means.measured[0] = false;
    means.u_v[0][0] = NOT_A_NUMBER;
    ASSERT_STATUS(TUMBLE_OK, tumble_estimate_gains(&table, &schedule, &means, &estimate));
}

static void test_every_gain_must_be_a_number_in_range(void)
{
    static const double bad[] = {NOT_A_NUMBER, INFINITE, -INFINITE, 1.0000001 * TUMBLE_MAX_GAIN,
                                 -1.0000001 * TUMBLE_MAX_GAIN};
    for (unsigned g = 0; g < TUMBLE_COEFFICIENTS * COLUMNS; g++) {
        gains[g] = bad[g % COUNT_OF(bad)];
        assert_refused(TUMBLE_E_GAIN_TABLE);
        gains[g] = 0.0;
    }
    tumble_coefficients_t estimate;
    for (unsigned g = 0; g < TUMBLE_COEFFICIENTS * COLUMNS; g++) {
        gains[g] = TUMBLE_MAX_GAIN;
        means.u_v[1U + g % FIT_POSITIONS][g % 3U] = TUMBLE_MAX_MEAN_V;
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_estimate_gains(&table, &schedule, &means, &estimate));
    for (unsigned row = 0; row < TUMBLE_COEFFICIENTS; row++) {
        TEST_ASSERT_DOUBLE_IS_DETERMINATE(coefficient(&estimate, row));
    }
}
