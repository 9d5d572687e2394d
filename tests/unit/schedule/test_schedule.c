/* The schedule of the paper, the attitudes it stands for, and look-ups by number. */
#include "model.h"

static void test_the_paper_has_two_mountings_of_nine_positions(void)
{
    TEST_ASSERT_EQUAL_UINT8(2, tumble_schedule_paper.mounting_count);
    TEST_ASSERT_EQUAL_UINT8(18, tumble_schedule_paper.position_count);
    for (unsigned p = 0; p < 18U; p++) {
        const tumble_position_t *position = &tumble_schedule_paper.positions[p];
        TEST_ASSERT_EQUAL_UINT8(p / 9U + 1U, position->mounting);
        TEST_ASSERT_EQUAL_UINT8(p % 9U + 1U, position->number);
        TEST_ASSERT_EQUAL_INT(TUMBLE_USE_FIT, position->use);
        ASSERT_SAME_DOUBLE(45.0 * (double)(p % 9U), position->angle.deg);
    }
}

static void test_the_second_mounting_is_the_first_turned_about_the_bisector_of_y_and_z(void)
{
    static const double identity[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    static const double turned[3][3] = {{-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}};
    for (int m = 0; m < 2; m++) {
        TEST_ASSERT_EQUAL_UINT8(m + 1, tumble_schedule_paper.mountings[m].number);
        ASSERT_SAME_DOUBLE(0.0, tumble_schedule_paper.mountings[m].tilt.deg);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                ASSERT_SAME_DOUBLE((m == 0) ? identity[i][j] : turned[i][j],
                                   tumble_schedule_paper.mountings[m].matrix[i][j]);
            }
        }
    }
}

/* (sin phi, 0, cos phi) in mounting 1, (-sin phi, cos phi, 0) in mounting 2. */
static void test_the_attitudes_of_the_paper_are_exact(void)
{
    static const double half = 0.70710678118654757; /* sqrt(1/2), rounded once */
    const double sine[9] = {0.0, half, 1.0, half, 0.0, -half, -1.0, -half, 0.0};
    const double cosine[9] = {1.0, half, 0.0, -half, -1.0, -half, 0.0, half, 1.0};
    for (uint8_t l = 0; l < 9U; l++) {
        double first[3];
        double second[3];
        tumble_schedule_attitude(&tumble_schedule_paper, l, first);
        tumble_schedule_attitude(&tumble_schedule_paper, (uint8_t)(9U + l), second);
        ASSERT_SAME_DOUBLE(sine[l], first[0]);
        ASSERT_SAME_DOUBLE(0.0, first[1]);
        ASSERT_SAME_DOUBLE(cosine[l], first[2]);
        ASSERT_SAME_DOUBLE(-sine[l], second[0]);
        ASSERT_SAME_DOUBLE(cosine[l], second[1]);
        ASSERT_SAME_DOUBLE(0.0, second[2]);
    }
}

static void test_the_paper_is_valid(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&tumble_schedule_paper, NULL));
}

/* x, y, z, each up and then down; the block lies on six faces of one and the same right-handed frame. */
static void test_hands_lay_every_face_by_a_proper_rotation(void)
{
    TEST_ASSERT_EQUAL_UINT8(6, tumble_schedule_hand_laid.position_count);
    for (uint8_t p = 0; p < 6U; p++) {
        const double (*m)[3] = tumble_schedule_mounting_of(&tumble_schedule_hand_laid, p)->matrix;
        double up[3];
        tumble_schedule_attitude(&tumble_schedule_hand_laid, p, up);
        for (int i = 0; i < 3; i++) {
            const double *row = m[i];
            const double *next = m[(i + 1) % 3];
            const double *third = m[(i + 2) % 3];
            ASSERT_SAME_DOUBLE((i == p / 2) ? ((p % 2 == 0) ? 1.0 : -1.0) : 0.0, up[i] + 0.0);
            for (int j = 0; j < 3; j++) {
                const int k = (j + 1) % 3;
                const int n = (j + 2) % 3;
                TEST_ASSERT_EQUAL_DOUBLE(third[j], row[k] * next[n] - row[n] * next[k]);
            }
        }
    }
}

/* A wedge of 5 degrees: every element of a rotation, both parts of the table angle and both of the tilt take part. */
static void test_attitudes_on_a_tilted_axis_follow_the_model(void)
{
    dice_t dice = {1};
    static const tumble_angle_t tilts[] = {
        LEVEL, {5.0, 0.08715574274765818, 0.99619469809174555}, {-20.0, -0.34202014332566871, 0.93969262078590843}};
    for (int round = 0; round < 500; round++) {
        tumble_mounting_t mountings[2] = {{.number = 3, .tilt = LEVEL}, {.number = 9}};
        random_rotation(&dice, mountings[0].matrix);
        random_rotation(&dice, mountings[1].matrix);
        mountings[1].tilt = tilts[dice_below(&dice, COUNT_OF(tilts))];
        const tumble_position_t positions[2] = {
            {3, 1, TUMBLE_USE_CHECK, steps_of_7_5_deg[dice_below(&dice, STEP_COUNT)]},
            {9, 1, TUMBLE_USE_FIT, steps_of_7_5_deg[dice_below(&dice, STEP_COUNT)]},
        };
        const tumble_schedule_t schedule = {mountings, positions, 2, 2};
        for (uint8_t p = 0; p < 2U; p++) {
            dd_t expected[3];
            double a[3];
            model_attitude(&schedule, p, expected);
            tumble_schedule_attitude(&schedule, p, a);
            for (int axis = 0; axis < 3; axis++) {
                TEST_ASSERT_DOUBLE_WITHIN(4e-16, dd_round(expected[axis]), a[axis]);
            }
        }
    }
}

static void test_positions_are_found_by_their_numbers(void)
{
    for (uint8_t p = 0; p < 18U; p++) {
        const tumble_position_t *position = &tumble_schedule_paper.positions[p];
        TEST_ASSERT_EQUAL_UINT8(p, tumble_schedule_find(&tumble_schedule_paper, position->mounting, position->number));
        TEST_ASSERT_EQUAL_PTR(&tumble_schedule_paper.mountings[p / 9U],
                              tumble_schedule_mounting_of(&tumble_schedule_paper, p));
    }
}

static void test_numbers_that_are_not_there_are_not_found(void)
{
    static const uint8_t absent[][2] = {{1, 0}, {1, 10}, {0, 1}, {3, 1}, {255, 255}};
    for (size_t i = 0; i < COUNT_OF(absent); i++) {
        TEST_ASSERT_EQUAL_UINT8(18, tumble_schedule_find(&tumble_schedule_paper, absent[i][0], absent[i][1]));
    }
}

static void test_look_ups_go_by_number_not_by_order(void)
{
    static const tumble_mounting_t mountings[] = {{7, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, LEVEL, 0},
                                                  {4, {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, LEVEL, 0}};
    static const tumble_position_t positions[] = {
        {4, 8, TUMBLE_USE_FIT, LEVEL}, {7, 8, TUMBLE_USE_FIT, LEVEL}, {4, 200, TUMBLE_USE_CHECK, LEVEL}};
    static const tumble_schedule_t schedule = {mountings, positions, 2, 3};
    TEST_ASSERT_EQUAL_UINT8(0, tumble_schedule_find(&schedule, 4, 8));
    TEST_ASSERT_EQUAL_UINT8(1, tumble_schedule_find(&schedule, 7, 8));
    TEST_ASSERT_EQUAL_UINT8(2, tumble_schedule_find(&schedule, 4, 200));
    TEST_ASSERT_EQUAL_UINT8(3, tumble_schedule_find(&schedule, 7, 200));
    TEST_ASSERT_EQUAL_PTR(&mountings[1], tumble_schedule_mounting_of(&schedule, 0));
    TEST_ASSERT_EQUAL_PTR(&mountings[0], tumble_schedule_mounting_of(&schedule, 1));
}
