/* The stand-optimal estimator against a transcription of its definition in matrices, on arbitrary gains. */
#include "estimator_bench.h"
#include "optimal_definition.h"
#include "tumble/core.h"

static gain_bytes_t record;
static random_schedule_t random;
static tumble_means_t means;

static void random_means_of(dice_t *dice, const tumble_schedule_t *schedule)
{
    memset(&means, 0, sizeof means);
    for (unsigned p = 0; p < schedule->position_count; p++) {
        means.measured[p] = (schedule->positions[p].use == TUMBLE_USE_FIT) || (dice_below(dice, 2) == 0U);
        for (int i = 0; i < 3; i++) {
            means.u_v[p][i] = means.measured[p] ? dice_signed_unit(dice) : NOT_A_NUMBER;
        }
    }
}

/* Gains of any kind; those of the stand small, so that its errors come out below a tenth of a radian. */
static void random_gains(dice_t *dice, const tumble_schedule_t *schedule, unsigned yaws, double stand_size)
{
    const unsigned columns = 3U * count_fit_positions(schedule);
    empty_gains(schedule, yaws, &record);
    for (unsigned n = 0; n < 9U; n++) {
        set_number(&record, AT_K + n, dice_signed_unit(dice));
    }
    set_number(&record, AT_SIGMA + 3U, 0.01 * magnitude(dice_signed_unit(dice)));
    set_number(&record, AT_NOISE, 1.0); /* so that a position's own angle takes a small part of what is left */
    for (unsigned g = 0; g < (14U + yaws) * columns; g++) {
        const double size = ((g < 12U * columns) ? 1.0 : stand_size) / (double)columns;
        set_number(&record, AT_GAINS + g, size * dice_signed_unit(dice));
    }
    seal(&record);
}

static void assert_agrees(const definition_t *expected, const tumble_coefficients_t *found,
                          const tumble_stand_errors_t *stand, double tolerance)
{
    for (unsigned n = 0; n < 9U; n++) {
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected->x[n], found->k_v_per_g[n / 3U][n % 3U]);
    }
    for (unsigned i = 0; i < 3U; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected->x[9U + i], found->u0_v[i]);
    }
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected->x[12], stand->alpha1_rad);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected->x[13], stand->alpha2_rad);
    for (unsigned m = 0; m < TUMBLE_MAX_YAWS; m++) {
        const unsigned row = 14U + ((expected->rows == 15U) ? 0U : m);
        const double yaw = (m < expected->schedule->mounting_count) ? expected->x[row] : 0.0;
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, yaw, stand->alpha3_rad[m]);
    }
}

static void test_it_does_what_its_definition_says(void)
{
    dice_t dice = {50};
    for (int round = 0; round < 400; round++) {
        tumble_coefficients_t found;
        tumble_optimal_t optimal;
        random_schedule(&dice, &random);
        const unsigned yaws = (dice_below(&dice, 2) == 0U) ? 1U : random.schedule.mounting_count;
        random_gains(&dice, &random.schedule, yaws, (round % 4 == 0) ? 0.0 : 0.05);
        random_means_of(&dice, &random.schedule);
        const definition_t expected = solve_by_definition(&record, &random.schedule, &means, yaws);
        const tumble_gain_record_t *opened = open_gains(&record, &random.schedule);
        ASSERT_STATUS(TUMBLE_OK, tumble_estimate_optimal(opened, &random.schedule, &means, &found, &optimal));
        /* What it keeps in single precision is a part of 1e-7 of an angle of at most 1e-2. */
        assert_agrees(&expected, &found, &optimal.stand, 1e-10);
    }
}

static void test_without_a_positions_own_error_it_agrees_to_the_last_bits(void)
{
    dice_t dice = {51};
    for (int round = 0; round < 200; round++) {
        tumble_coefficients_t found;
        tumble_optimal_t optimal;
        random_schedule(&dice, &random);
        random_gains(&dice, &random.schedule, random.schedule.mounting_count, 0.05);
        set_number(&record, AT_SIGMA + 3U, 0.0);
        seal(&record);
        random_means_of(&dice, &random.schedule);
        const definition_t expected =
            solve_by_definition(&record, &random.schedule, &means, random.schedule.mounting_count);
        const tumble_gain_record_t *opened = open_gains(&record, &random.schedule);
        ASSERT_STATUS(TUMBLE_OK, tumble_estimate_optimal(opened, &random.schedule, &means, &found, &optimal));
        assert_agrees(&expected, &found, &optimal.stand, 5e-15);
    }
}

/* On a stand without errors it is the linear estimator of the same gains. */
static void test_a_perfect_stand_leaves_the_gains_alone(void)
{
    dice_t dice = {52};
    tumble_coefficients_t linear;
    tumble_coefficients_t found;
    tumble_optimal_t optimal;
    random_gains(&dice, &tumble_schedule_paper, 2, 0.0);
    set_number(&record, AT_SIGMA + 3U, 0.0);
    seal(&record);
    random_means_of(&dice, &tumble_schedule_paper);
    const tumble_gain_record_t *opened = open_gains(&record, &tumble_schedule_paper);
    const tumble_gain_table_t table = {tumble_gain_record_gains(opened), opened->fit_positions, 0.0};
    ASSERT_STATUS(TUMBLE_OK, tumble_estimate_gains(&table, &tumble_schedule_paper, &means, &linear));
    ASSERT_STATUS(TUMBLE_OK, tumble_estimate_optimal(opened, &tumble_schedule_paper, &means, &found, &optimal));
    assert_coefficients(&linear, &found, 1e-15);
    TEST_ASSERT_EACH_EQUAL_HEX8(0, &optimal.stand, sizeof optimal.stand);
}

static const tumble_gain_record_t *paper_gains(void)
{
    dice_t dice = {53};
    random_gains(&dice, &tumble_schedule_paper, 2, 0.02);
    random_means_of(&dice, &tumble_schedule_paper);
    return open_gains(&record, &tumble_schedule_paper);
}

static void assert_leaves_outputs_alone(tumble_status_t expected, const tumble_gain_record_t *opened,
                                        const tumble_schedule_t *schedule)
{
    tumble_coefficients_t found;
    tumble_optimal_t optimal;
    memset(&found, 0x5A, sizeof found);
    memset(&optimal, 0x5A, sizeof optimal);
    ASSERT_STATUS(expected, tumble_estimate_optimal(opened, schedule, &means, &found, &optimal));
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, &found, sizeof found);
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, &optimal, sizeof optimal);
}

static void assert_leaves_outputs_zero(tumble_status_t expected, const tumble_gain_record_t *opened)
{
    tumble_coefficients_t found;
    tumble_optimal_t optimal;
    memset(&found, 0x5A, sizeof found);
    memset(&optimal, 0x5A, sizeof optimal);
    ASSERT_STATUS(expected, tumble_estimate_optimal(opened, &tumble_schedule_paper, &means, &found, &optimal));
    TEST_ASSERT_EACH_EQUAL_HEX8(0, &found, sizeof found);
    TEST_ASSERT_EACH_EQUAL_HEX8(0, &optimal, sizeof optimal);
}

static void test_null_pointers_are_refused(void)
{
    const tumble_gain_record_t *opened = paper_gains();
    tumble_coefficients_t found;
    tumble_optimal_t optimal;
    assert_leaves_outputs_alone(TUMBLE_E_ARGUMENT, NULL, &tumble_schedule_paper);
    assert_leaves_outputs_alone(TUMBLE_E_ARGUMENT, opened, NULL);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_estimate_optimal(opened, &tumble_schedule_paper, NULL, &found, &optimal));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_estimate_optimal(opened, &tumble_schedule_paper, &means, NULL, &optimal));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_estimate_optimal(opened, &tumble_schedule_paper, &means, &found, NULL));
}

static void test_every_fit_position_must_be_measured_by_a_number(void)
{
    const tumble_gain_record_t *opened = paper_gains();
    for (unsigned cell = 0; cell < 54U; cell++) {
        const double good = means.u_v[cell / 3U][cell % 3U];
        means.measured[cell / 3U] = false;
        assert_leaves_outputs_alone(TUMBLE_E_MISSING_POSITION, opened, &tumble_schedule_paper);
        means.measured[cell / 3U] = true;
        means.u_v[cell / 3U][cell % 3U] = (cell % 2U == 0U) ? NOT_A_NUMBER : one_ulp_beyond(TUMBLE_MAX_MEAN_V);
        assert_leaves_outputs_alone(TUMBLE_E_NOT_FINITE, opened, &tumble_schedule_paper);
        means.u_v[cell / 3U][cell % 3U] = good;
    }
}

static void test_a_record_of_other_counts_is_refused(void)
{
    const tumble_gain_record_t *opened = paper_gains();
    tumble_schedule_t other = tumble_schedule_paper;
    other.position_count = 17;
    assert_leaves_outputs_alone(TUMBLE_E_GAIN_TABLE, opened, &other);
    other = tumble_schedule_paper;
    other.mounting_count = 1;
    assert_leaves_outputs_alone(TUMBLE_E_GAIN_TABLE, opened, &other);
}

/* One gain makes alpha1, alpha2 or a yaw as large as the first mean. */
static void test_an_error_that_no_stand_can_have_is_refused(void)
{
    static const double largest = TUMBLE_MAX_STAND_ERROR_RAD;
    for (unsigned row = 12; row < 16U; row++) {
        tumble_coefficients_t found;
        tumble_optimal_t optimal;
        empty_gains(&tumble_schedule_paper, 2, &record);
        set_number(&record, gain_index(&tumble_schedule_paper, row, 0), 1.0);
        seal(&record);
        const tumble_gain_record_t *opened = open_gains(&record, &tumble_schedule_paper);
        dice_t dice = {54};
        random_means_of(&dice, &tumble_schedule_paper);
        for (int sign = -1; sign <= 1; sign += 2) {
            means.u_v[0][0] = sign * largest;
            ASSERT_STATUS(TUMBLE_OK, tumble_estimate_optimal(opened, &tumble_schedule_paper, &means, &found, &optimal));
            means.u_v[0][0] = one_ulp_beyond(sign * largest);
            assert_leaves_outputs_zero(TUMBLE_E_STAND_ERROR, opened);
        }
    }
}

/* Without gains K stays 0, so what the angle does to the outputs all counts as curvature, and the error doubles. */
static void test_an_angle_that_no_table_can_miss_is_refused(void)
{
    dice_t dice = {55};
    for (unsigned p = 0; p < 18U; p++) {
        empty_gains(&tumble_schedule_paper, 2, &record);
        set_number(&record, AT_K, 1.0);
        set_number(&record, AT_K + 4U, 1.0);
        set_number(&record, AT_K + 8U, 1.0);
        set_number(&record, AT_SIGMA + 3U, 1.0);
        set_number(&record, AT_NOISE, 1e-9);
        seal(&record);
        const tumble_gain_record_t *opened = open_gains(&record, &tumble_schedule_paper);
        tumble_coefficients_t found;
        tumble_optimal_t optimal;
        random_means_of(&dice, &tumble_schedule_paper);
        memset(means.u_v, 0, sizeof means.u_v);
        double ahead[3];
        double yaw[3];
        double tilt[3];
        derivatives_at(&tumble_schedule_paper, (uint8_t)p, tilt, ahead, yaw);
        for (int i = 0; i < 3; i++) {
            means.u_v[p][i] = 0.0499 * ahead[i];
        }
        ASSERT_STATUS(TUMBLE_OK, tumble_estimate_optimal(opened, &tumble_schedule_paper, &means, &found, &optimal));
        for (int i = 0; i < 3; i++) {
            means.u_v[p][i] = 0.0501 * ahead[i];
        }
        assert_leaves_outputs_zero(TUMBLE_E_STAND_ERROR, opened);
    }
}

static void test_a_result_that_overflows_is_refused(void)
{
    empty_gains(&tumble_schedule_paper, 2, &record);
    set_number(&record, gain_index(&tumble_schedule_paper, 11, 53), 1e100);
    set_number(&record, gain_index(&tumble_schedule_paper, 0, 3), 1e100);
    set_number(&record, gain_index(&tumble_schedule_paper, 13, 7), 1.0);
    seal(&record);
    const tumble_gain_record_t *opened = open_gains(&record, &tumble_schedule_paper);
    dice_t dice = {56};
    random_means_of(&dice, &tumble_schedule_paper);
    means.u_v[1][0] = 1e100;
    means.u_v[2][1] = 0.09;
    means.u_v[17][2] = 1e100;
    assert_leaves_outputs_zero(TUMBLE_E_NOT_FINITE, opened);
}

/* The curvature of one position's angle is kept as a float: one beyond it must not get there. */
static void test_a_curvature_beyond_a_float_is_refused(void)
{
    dice_t dice = {57};
    empty_gains(&tumble_schedule_paper, 2, &record);
    set_number(&record, AT_K, 1e-20);
    set_number(&record, AT_SIGMA + 3U, 1.0);
    set_number(&record, AT_NOISE, 1e-25);
    set_number(&record, gain_index(&tumble_schedule_paper, 0, 0), 1e60);
    seal(&record);
    random_means_of(&dice, &tumble_schedule_paper);
    memset(means.u_v, 0, sizeof means.u_v);
    means.u_v[0][0] = 1.0;
    assert_leaves_outputs_zero(TUMBLE_E_STAND_ERROR, open_gains(&record, &tumble_schedule_paper));
}

static void test_through_a_source_the_record_is_checked_every_time(void)
{
    tumble_coefficients_t found;
    tumble_coefficients_t expected;
    tumble_optimal_t optimal;
    tumble_optimal_t work;
    ASSERT_STATUS(TUMBLE_OK,
                  tumble_estimate_optimal(paper_gains(), &tumble_schedule_paper, &means, &expected, &optimal));
    tumble_optimal_source_t source = {record.bytes, record.size, &work};
    ASSERT_STATUS(TUMBLE_OK, tumble_optimal_check(&source, &tumble_schedule_paper));
    ASSERT_STATUS(TUMBLE_OK, tumble_optimal_estimate(&source, &tumble_schedule_paper, &means, &found));
    assert_same_coefficients(&expected, &found);
    TEST_ASSERT_EQUAL_MEMORY(&optimal, &work, sizeof work);
    record.bytes[1000] ^= 1U;
    ASSERT_STATUS(TUMBLE_E_CRC, tumble_optimal_check(&source, &tumble_schedule_paper));
    ASSERT_STATUS(TUMBLE_E_CRC, tumble_optimal_estimate(&source, &tumble_schedule_paper, &means, &found));
    record.bytes[1000] ^= 1U;
    means.measured[4] = false;
    ASSERT_STATUS(TUMBLE_E_MISSING_POSITION, tumble_optimal_estimate(&source, &tumble_schedule_paper, &means, &found));
    source.work = NULL;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_optimal_check(&source, &tumble_schedule_paper));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_optimal_check(NULL, &tumble_schedule_paper));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_optimal_estimate(NULL, &tumble_schedule_paper, &means, &found));
    assert_same_coefficients(&expected, &found);
}
