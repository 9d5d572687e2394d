/* Which coefficients a schedule, or what was measured of it, can identify. */
#include "eigen.h"
#include "random_schedule.h"
#include "six_faces.h"

#define K_IX 1U
#define K_IY 2U
#define K_IZ 4U
#define U0 8U
#define UNTOUCHED 0xA5U

static void assert_identify(const tumble_schedule_t *schedule, const bool *measured, unsigned expected)
{
    const tumble_status_t status = (expected == 0U) ? TUMBLE_OK : TUMBLE_E_RANK;
    uint8_t unidentified = UNTOUCHED;
    ASSERT_STATUS(status, tumble_schedule_identify(schedule, measured, &unidentified));
    TEST_ASSERT_EQUAL_HEX8(expected, unidentified);
    ASSERT_STATUS(status, tumble_schedule_identify(schedule, measured, NULL));
}

static void test_the_paper_identifies_all_twelve(void)
{
    assert_identify(&tumble_schedule_paper, NULL, 0);
}

static void test_one_mounting_of_the_paper_leaves_one_axis_out(void)
{
    const tumble_position_t *positions = tumble_schedule_paper.positions;
    const tumble_schedule_t first = {tumble_schedule_paper.mountings, positions, 2, 9};
    const tumble_schedule_t second = {tumble_schedule_paper.mountings, positions + 9, 2, 9};
    assert_identify(&first, NULL, K_IY);
    assert_identify(&second, NULL, K_IZ);
}

static void test_only_measured_positions_count(void)
{
    bool measured[18] = {false};
    assert_identify(&tumble_schedule_paper, measured, K_IX | K_IY | K_IZ | U0);
    for (int p = 0; p < 9; p++) {
        measured[p] = true;
    }
    assert_identify(&tumble_schedule_paper, measured, K_IY);
    measured[9] = true;
    assert_identify(&tumble_schedule_paper, measured, 0);
    measured[9] = false;
    measured[11] = true; /* (-1, 0, 0) again */
    assert_identify(&tumble_schedule_paper, measured, K_IY);
}

static void test_four_well_chosen_positions_are_enough_and_three_never_are(void)
{
    bool measured[18] = {false};
    measured[0] = true; /* z */
    measured[2] = true; /* x */
    measured[6] = true; /* -x */
    assert_identify(&tumble_schedule_paper, measured, K_IY);
    measured[9] = true; /* y */
    assert_identify(&tumble_schedule_paper, measured, 0);
    measured[0] = false;
    assert_identify(&tumble_schedule_paper, measured, K_IZ);
    measured[0] = true;
    measured[6] = false; /* any part of the bias could be a part of all three */
    assert_identify(&tumble_schedule_paper, measured, K_IX | K_IY | K_IZ | U0);
}

static void test_a_single_position_identifies_nothing(void)
{
    const tumble_position_t position = {1, 1, TUMBLE_USE_FIT, LEVEL};
    const tumble_schedule_t schedule = {tumble_schedule_paper.mountings, &position, 2, 1};
    assert_identify(&schedule, NULL, K_IX | K_IY | K_IZ | U0);
}

/* Two opposite positions: only the axis between them. */
static void test_two_opposite_positions_identify_one_axis_and_the_bias(void)
{
    static const tumble_position_t positions[] = {{1, 1, TUMBLE_USE_FIT, LEVEL}, {1, 2, TUMBLE_USE_FIT, {180, 0, -1}}};
    const tumble_schedule_t schedule = {tumble_schedule_paper.mountings, positions, 2, 2};
    assert_identify(&schedule, NULL, K_IX | K_IY);
}

static void test_six_faces_identify_all_and_each_axis_needs_a_pair(void)
{
    assert_identify(&six_faces, NULL, 0);
    for (unsigned axis = 0; axis < 3U; axis++) {
        bool measured[6] = {true, true, true, true, true, true};
        measured[2U * axis] = false;
        assert_identify(&six_faces, measured, 0);
        measured[2U * axis + 1U] = false;
        assert_identify(&six_faces, measured, 1U << axis);
    }
}

static void test_check_positions_do_not_count(void)
{
    tumble_position_t positions[6];
    memcpy(positions, six_faces_positions, sizeof positions);
    positions[2].use = TUMBLE_USE_CHECK;
    positions[3].use = TUMBLE_USE_CHECK;
    const tumble_schedule_t schedule = {six_faces_mountings, positions, 3, 6};
    static const bool all[6] = {true, true, true, true, true, true};
    assert_identify(&schedule, NULL, K_IY);
    assert_identify(&schedule, all, K_IY);
    for (int p = 0; p < 6; p++) {
        positions[p].use = TUMBLE_USE_CHECK;
    }
    assert_identify(&schedule, NULL, K_IX | K_IY | K_IZ | U0);
}

/* One mounting turned on an axis with two tilts: +sine in four positions, -sine or none in four more. */
static void assert_two_tilts(tumble_angle_t first, tumble_angle_t second, unsigned expected)
{
    const tumble_mounting_t mountings[] = {{1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, first, 0},
                                           {2, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, second, 0}};
    tumble_position_t positions[8];
    for (uint8_t p = 0; p < 8U; p++) {
        positions[p] = (tumble_position_t){(uint8_t)(p / 4U + 1U), (uint8_t)(p + 1U), TUMBLE_USE_FIT,
                                           steps_of_7_5_deg[(p % 4U) * (STEP_COUNT / 4U)]};
    }
    const tumble_schedule_t schedule = {mountings, positions, 2, 8};
    assert_identify(&schedule, NULL, expected);
}

static const tumble_angle_t level = LEVEL;

/* On one axis in one mounting the component along the axis is constant: as good as a bias. */
static void test_one_tilted_axis_confuses_its_component_with_the_bias(void)
{
    const tumble_angle_t tilt = {5.0, 0.08715574274765818, 0.99619469809174555};
    assert_two_tilts(tilt, tilt, K_IY | U0);
    assert_two_tilts(level, level, K_IY);
}

static void test_two_tilts_tell_them_apart(void)
{
    const tumble_angle_t up = {5.0, 0.08715574274765818, 0.99619469809174555};
    const tumble_angle_t down = {-5.0, -0.08715574274765818, 0.99619469809174555};
    assert_two_tilts(up, level, 0);
    assert_two_tilts(up, down, 0);
}

/* Opposite tilts make a column +-sine(tilt) orthogonal to all others: its root mean square is the sensitivity. */
static void test_the_weakest_sensitivity_that_counts_is_a_thousandth_of_g(void)
{
    assert_two_tilts((tumble_angle_t){0.05786874714686748, 0.00101, 0.99999948994986998},
                     (tumble_angle_t){-0.05786874714686748, -0.00101, 0.99999948994986998}, 0);
    assert_two_tilts((tumble_angle_t){0.056722830983628514, 0.00098999999999999999, 0.99999950994987996},
                     (tumble_angle_t){-0.056722830983628514, -0.00098999999999999999, 0.99999950994987996}, K_IY);
}

/* For any schedule: unidentified exactly when a direction is weaker than the limit, and then the coefficients that
 * take part in such a direction are named. Cases too close to the limit to call are left out. */
static void test_random_schedules_against_their_eigenvalues(void)
{
    static random_schedule_t random;
    dice_t dice = {3};
    int full = 0;
    int deficient = 0;
    for (int round = 0; round < 2000; round++) {
        bool measured[TUMBLE_MAX_POSITIONS];
        random_schedule(&dice, &random);
        for (int p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
            measured[p] = dice_below(&dice, 3) != 0U;
        }
        const eigen_t eigen = eigen_of_design(&random.schedule, measured);
        unsigned named = 0;
        bool doubtful = false;
        for (int k = 0; k < 4; k++) {
            const double sensitivity = sqrt((eigen.value[k] > 0.0) ? eigen.value[k] : 0.0);
            doubtful = doubtful || (sensitivity > 1e-7 && sensitivity < 2e-3);
            for (int j = 0; j < 4 && sensitivity < 1e-3; j++) {
                const double part = magnitude(eigen.vector[k][j]);
                named |= (part > 1e-3) ? 1U << j : 0U;
                doubtful = doubtful || (part > 1e-9 && part < 1e-3);
            }
        }
        if (!doubtful) {
            assert_identify(&random.schedule, measured, named);
            full += (named == 0U) ? 1 : 0;
            deficient += (named != 0U) ? 1 : 0;
        }
    }
    TEST_ASSERT_GREATER_THAN(500, full);
    TEST_ASSERT_GREATER_THAN(200, deficient);
}

static void test_null_is_refused(void)
{
    uint8_t unidentified = UNTOUCHED;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_schedule_identify(NULL, NULL, &unidentified));
    TEST_ASSERT_EQUAL_HEX8(UNTOUCHED, unidentified);
}
