/* Every way a schedule can be bad data, each with its own status and the place of the fault. */
#include "model.h"

#define UNTOUCHED 0xA5U
#define NOWHERE 0xFFU

/* A good schedule of two mountings and four positions, spoilt anew by each test. */
static tumble_mounting_t mountings[TUMBLE_MAX_MOUNTINGS + 1];
static tumble_position_t positions[TUMBLE_MAX_POSITIONS + 1];
static tumble_schedule_t schedule;

static void set_up(void)
{
    static const tumble_mounting_t mounting = {1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, LEVEL, 0};
    for (unsigned m = 0; m < COUNT_OF(mountings); m++) {
        mountings[m] = mounting;
        mountings[m].number = (uint8_t)(m + 1U);
    }
    for (unsigned p = 0; p < COUNT_OF(positions); p++) {
        positions[p] =
            (tumble_position_t){(uint8_t)(p % 2U + 1U), (uint8_t)(p / 2U + 1U), TUMBLE_USE_FIT, steps_of_7_5_deg[p]};
    }
    schedule = (tumble_schedule_t){mountings, positions, 2, 4};
}

static void assert_refused(tumble_status_t expected, uint8_t expected_where)
{
    uint8_t where = UNTOUCHED;
    ASSERT_STATUS(expected, tumble_schedule_validate(&schedule, &where));
    if (expected_where != NOWHERE) {
        TEST_ASSERT_EQUAL_UINT8(expected_where, where);
    }
    ASSERT_STATUS(expected, tumble_schedule_validate(&schedule, NULL));
}

static void assert_accepted(void)
{
    uint8_t where;
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&schedule, &where));
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&schedule, NULL));
}

static void test_null_pointers_are_refused(void)
{
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_schedule_validate(NULL, NULL));
    schedule.mountings = NULL;
    assert_refused(TUMBLE_E_ARGUMENT, NOWHERE);
    schedule.mountings = mountings;
    schedule.positions = NULL;
    assert_refused(TUMBLE_E_ARGUMENT, NOWHERE);
}

static void test_a_fault_that_has_no_place_leaves_where_as_it_was(void)
{
    uint8_t where = UNTOUCHED;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_schedule_validate(NULL, &where));
    TEST_ASSERT_EQUAL_UINT8(UNTOUCHED, where);
    schedule.position_count = 0;
    ASSERT_STATUS(TUMBLE_E_SCHEDULE_SIZE, tumble_schedule_validate(&schedule, &where));
    TEST_ASSERT_EQUAL_UINT8(UNTOUCHED, where);
}

static void test_sizes_have_limits(void)
{
    schedule.mounting_count = 0;
    assert_refused(TUMBLE_E_SCHEDULE_SIZE, NOWHERE);
    schedule.mounting_count = TUMBLE_MAX_MOUNTINGS + 1;
    assert_refused(TUMBLE_E_SCHEDULE_SIZE, NOWHERE);
    schedule.mounting_count = TUMBLE_MAX_MOUNTINGS;
    assert_accepted();
    schedule.position_count = 0;
    assert_refused(TUMBLE_E_SCHEDULE_SIZE, NOWHERE);
    schedule.position_count = TUMBLE_MAX_POSITIONS + 1;
    assert_refused(TUMBLE_E_SCHEDULE_SIZE, NOWHERE);
    schedule.position_count = TUMBLE_MAX_POSITIONS;
    assert_accepted();
    schedule.mounting_count = 2;
    schedule.position_count = 1;
    assert_accepted();
}

static void test_the_smallest_schedule_is_one_position(void)
{
    schedule.mounting_count = 1;
    schedule.position_count = 1;
    assert_accepted();
}

static void test_mounting_numbers_are_unique(void)
{
    schedule.mounting_count = 4;
    mountings[3].number = 1;
    assert_refused(TUMBLE_E_SCHEDULE_DUPLICATE, 3);
    mountings[3].number = 3;
    assert_refused(TUMBLE_E_SCHEDULE_DUPLICATE, 3);
    mountings[3].number = 200;
    assert_accepted();
}

static void test_position_numbers_are_unique_within_a_mounting(void)
{
    positions[2].number = positions[0].number;
    assert_refused(TUMBLE_E_SCHEDULE_DUPLICATE, 2);
    set_up();
    positions[3].number = positions[1].number;
    assert_refused(TUMBLE_E_SCHEDULE_DUPLICATE, 3);
    positions[3].number = 255;
    assert_accepted();
}

static void test_a_position_needs_a_mounting_of_the_schedule(void)
{
    for (uint8_t p = 0; p < 4U; p++) {
        set_up();
        positions[p].mounting = 3;
        assert_refused(TUMBLE_E_SCHEDULE_MOUNTING, p);
        positions[p].mounting = 0;
        assert_refused(TUMBLE_E_SCHEDULE_MOUNTING, p);
    }
}

static void test_every_element_of_a_rotation_counts(void)
{
    static const double wrong[] = {1e-6, -1e-6, 0.5, NOT_A_NUMBER, INFINITE, -INFINITE, 1e200};
    for (int element = 0; element < 9; element++) {
        for (size_t i = 0; i < COUNT_OF(wrong); i++) {
            set_up();
            mountings[1].matrix[element / 3][element % 3] += wrong[i];
            assert_refused(TUMBLE_E_SCHEDULE_ROTATION, 1);
        }
    }
}

static void test_a_rotation_is_orthonormal_to_1e_9(void)
{
    mountings[0].matrix[0][1] = 1.1e-9;
    assert_refused(TUMBLE_E_SCHEDULE_ROTATION, 0);
    mountings[0].matrix[0][1] = -0.9e-9;
    assert_accepted();
    mountings[0].matrix[0][1] = 0.0;
    mountings[0].matrix[2][2] = 1.0 + 1e-8;
    assert_refused(TUMBLE_E_SCHEDULE_ROTATION, 0);
    mountings[0].matrix[2][2] = 1.0 - 1e-10;
    assert_accepted();
}

static void test_matrices_that_are_not_proper_rotations(void)
{
    static const double improper[][3][3] = {
        {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}},                                        /* one axis reflected */
        {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},                                      /* the point reflection */
        {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},                                         /* two axes exchanged */
        {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}},                                         /* a scale */
        {{1, 0, 0}, {1, 0, 0}, {0, 0, 1}},                                         /* two equal rows */
        {{1, 0, 0}, {0, 1, 0}, {0, 1, 0}},                                         /* the same, below */
        {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}},    {{1, 0.1, 0}, {0, 1, 0}, {0, 0, 1}}, /* a shear */
    };
    for (size_t i = 0; i < COUNT_OF(improper); i++) {
        memcpy(mountings[1].matrix, improper[i], sizeof improper[i]);
        assert_refused(TUMBLE_E_SCHEDULE_ROTATION, 1);
    }
}

/* The 24 ways to put a cube down, and their 24 mirror images: which axis where, and three signs. */
static void test_every_rotation_of_a_cube_is_accepted_and_no_reflection(void)
{
    static const int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    int accepted = 0;
    for (unsigned way = 0; way < 48U; way++) {
        bool proper = way / 8U < 3U; /* the first three orders are even */
        memset(mountings[1].matrix, 0, sizeof mountings[1].matrix);
        for (unsigned row = 0; row < 3U; row++) {
            const bool negative = (way & (1U << row)) != 0U;
            mountings[1].matrix[row][orders[way / 8U][row]] = negative ? -1.0 : 1.0;
            proper = (proper != negative);
        }
        if (proper) {
            assert_accepted();
            accepted++;
        } else {
            assert_refused(TUMBLE_E_SCHEDULE_ROTATION, 1);
        }
    }
    TEST_ASSERT_EQUAL_INT(24, accepted);
}

static void test_any_proper_rotation_is_accepted(void)
{
    dice_t dice = {2};
    for (int round = 0; round < 300; round++) {
        random_rotation(&dice, mountings[0].matrix);
        random_rotation(&dice, mountings[1].matrix);
        assert_accepted();
        for (int k = 0; k < 3; k++) { /* the same, reflected */
            mountings[1].matrix[k][0] = -mountings[1].matrix[k][0];
        }
        assert_refused(TUMBLE_E_SCHEDULE_ROTATION, 1);
    }
}

static void test_what_comes_first_is_reported_first(void)
{
    positions[3].angle.sine = 2.0;
    assert_refused(TUMBLE_E_SCHEDULE_ANGLE, 3);
    positions[3].number = positions[1].number;
    assert_refused(TUMBLE_E_SCHEDULE_DUPLICATE, 3);
    positions[3].mounting = 99;
    assert_refused(TUMBLE_E_SCHEDULE_MOUNTING, 3);
    positions[2].angle.sine = 2.0;
    assert_refused(TUMBLE_E_SCHEDULE_ANGLE, 2);
    mountings[1].tilt.sine = 2.0;
    assert_refused(TUMBLE_E_SCHEDULE_ANGLE, 1);
    mountings[1].matrix[0][0] = -1.0;
    assert_refused(TUMBLE_E_SCHEDULE_ROTATION, 1);
    mountings[1].number = mountings[0].number;
    assert_refused(TUMBLE_E_SCHEDULE_DUPLICATE, 1);
    mountings[0].matrix[0][0] = -1.0;
    assert_refused(TUMBLE_E_SCHEDULE_ROTATION, 0);
    schedule.mounting_count = 0;
    assert_refused(TUMBLE_E_SCHEDULE_SIZE, NOWHERE);
}

static void test_a_position_is_for_the_fit_or_for_the_check(void)
{
    positions[1].use = TUMBLE_USE_CHECK;
    assert_accepted();
    positions[1].use = (tumble_use_t)2;
    assert_refused(TUMBLE_E_ARGUMENT, 1);
}
