/* Finding the circles of the closed forms in any schedule, by geometry. */
#include "core/harmonic.h"
#include "model.h"
#include "six_faces.h"

#define SLOT(mounting, position) (UINT64_C(1) << (((mounting) - 1) * 9 + (position) - 1)) /* of the paper */
#define ALL_SLOTS ((UINT64_C(1) << 18) - 1U)
#define UNTOUCHED 0xA5U

/* A copy of the paper's schedule with room for more. */
static tumble_mounting_t mountings[TUMBLE_MAX_MOUNTINGS];
static tumble_position_t positions[TUMBLE_MAX_POSITIONS];
static tumble_schedule_t schedule;
static bool measured[TUMBLE_MAX_POSITIONS];

static void set_up(void)
{
    memcpy(mountings, tumble_schedule_paper.mountings, 2U * sizeof mountings[0]);
    memcpy(positions, tumble_schedule_paper.positions, 18U * sizeof positions[0]);
    schedule = (tumble_schedule_t){mountings, positions, 2, 18};
    for (int p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        measured[p] = true;
    }
}

static void assert_refused(tumble_status_t expected, const bool *flags, uint64_t expected_missing)
{
    tumble_harmonic_map_t map;
    uint64_t missing = UNTOUCHED;
    ASSERT_STATUS(expected, tumble_schedule_harmonic(&schedule, flags, &map, &missing));
    TEST_ASSERT_EQUAL_HEX64(expected_missing, missing);
    ASSERT_STATUS(expected, tumble_schedule_harmonic(&schedule, flags, &map, NULL));
}

static void assert_circles(const tumble_schedule_t *any, const bool *flags, uint8_t x, uint8_t y, uint8_t z)
{
    tumble_harmonic_map_t map;
    uint64_t missing = UNTOUCHED;
    memset(&map, UNTOUCHED, sizeof map);
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_harmonic(any, flags, &map, &missing));
    TEST_ASSERT_EQUAL_HEX64(0, missing);
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_harmonic(any, flags, &map, NULL));
    TEST_ASSERT_EQUAL_UINT8(x, map.circles[0]);
    TEST_ASSERT_EQUAL_UINT8(y, map.circles[1]);
    TEST_ASSERT_EQUAL_UINT8(z, map.circles[2]);
}

static tumble_circle_t circle_of(const bool *flags, uint8_t m)
{
    static tumble_harmonic_map_t map;
    memset(&map, UNTOUCHED, sizeof map);
    (void)tumble_schedule_harmonic(&schedule, flags, &map, NULL);
    TEST_ASSERT_EQUAL_PTR(&schedule, map.schedule);
    for (uint8_t c = 0; c < map.count; c++) {
        if (map.circle[c].mounting == m) {
            return map.circle[c];
        }
    }
    TEST_FAIL_MESSAGE("this mounting is no circle");
    return map.circle[0];
}

static void test_the_circles_of_the_paper(void)
{
    assert_circles(&schedule, NULL, 0, 1, 1);
    assert_circles(&schedule, measured, 0, 1, 1);
    for (uint8_t m = 0; m < 2U; m++) {
        const tumble_circle_t circle = circle_of((m == 0U) ? NULL : measured, m);
        TEST_ASSERT_EQUAL_UINT8(1, circle.stride);
        TEST_ASSERT_EQUAL_UINT8(1U + m, circle.normal);
        for (uint8_t step = 0; step < 9U; step++) {
            TEST_ASSERT_EQUAL_UINT8(9U * m + step, circle.index[step]);
        }
    }
}

static void test_the_circles_of_the_other_schedules(void)
{
    assert_circles(&tumble_schedule_three_mountings, NULL, 1, 1, 1);
    assert_circles(&tumble_schedule_diagonal, NULL, 1, 1, 1);
    schedule = tumble_schedule_diagonal;
    const tumble_circle_t circle = circle_of(NULL, 2);
    TEST_ASSERT_EQUAL_UINT8(2, circle.stride);
    TEST_ASSERT_EQUAL_UINT8(0, circle.normal);
    for (uint8_t step = 1; step < 9U; step += 2U) {
        TEST_ASSERT_EQUAL_UINT8(8U + step / 2U, circle.index[step]);
    }
    schedule = tumble_schedule_six_faces;
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
}

/* Nine positions or the four diagonals, and nothing between: four that were picked out of more would waste the rest. */
static void test_diagonals_among_others_are_no_circle(void)
{
    memcpy(positions, tumble_schedule_diagonal.positions, 12U * sizeof positions[0]);
    memcpy(mountings, tumble_schedule_diagonal.mountings, 3U * sizeof mountings[0]);
    schedule.mounting_count = 3;
    schedule.position_count = 13;
    positions[12] = (tumble_position_t){3, 5, TUMBLE_USE_FIT, tumble_schedule_paper.positions[0].angle};
    assert_circles(&schedule, NULL, 0, 1, 1);
    positions[12].use = TUMBLE_USE_CHECK;
    assert_circles(&schedule, NULL, 1, 1, 1);
    positions[12] = positions[8];
    positions[12].number = 5;
    assert_circles(&schedule, NULL, 1, 1, 1);
}

/* Any turn of the block about the axis of the stand leaves the circle where it is; turned over, its normal points the
 * other way. */
static void test_a_circle_may_begin_anywhere(void)
{
    mountings[1] = (tumble_mounting_t){2, {{0.6, 0, 0.8}, {0.8, 0, -0.6}, {0, 1, 0}}, LEVEL, 0};
    assert_circles(&schedule, NULL, 0, 1, 1);
    mountings[1] = (tumble_mounting_t){2, {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}, LEVEL, 0};
    assert_circles(&schedule, NULL, 1, 1, 0);
    mountings[1] = mountings[0];
    mountings[1].number = 2;
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
}

static void test_the_share_of_a_circle(void)
{
    static const tumble_harmonic_map_t paper = {.circles = {0, 1, 1}, .count = 2};
    static const tumble_harmonic_map_t many = {.circles = {2, 1, 3}, .count = 6};
    for (int i = 0; i < 3; i++) {
        for (int normal = 0; normal < 3; normal++) {
            for (int j = 0; j < 3; j++) {
                const uint8_t held = (j == 0) ? 2 : 1;
                const uint8_t all = (uint8_t)(6U - many.circles[j]);
                TEST_ASSERT_EQUAL_UINT8((normal == j) ? 0 : held, tumble_circle_share(&paper, false, i, j, normal));
                TEST_ASSERT_EQUAL_UINT8((normal == j) ? 0 : all, tumble_circle_share(&many, false, i, j, normal));
                const uint8_t both =
                    (i == j) ? ((normal == j) ? 0 : all) : ((normal == 3 - i - j) ? many.circles[normal] : 0);
                TEST_ASSERT_EQUAL_UINT8(both, tumble_circle_share(&many, true, i, j, normal));
            }
        }
    }
    TEST_ASSERT_EQUAL_UINT8(1, tumble_circle_share(&paper, true, 1, 0, 2)); /* K_yx: mounting 2 alone */
    TEST_ASSERT_EQUAL_UINT8(0, tumble_circle_share(&paper, true, 1, 0, 1));
    TEST_ASSERT_EQUAL_UINT8(1, tumble_circle_share(&paper, true, 2, 0, 1)); /* K_zx: mounting 1 alone */
    TEST_ASSERT_EQUAL_UINT8(1, tumble_circle_share(&paper, true, 1, 2, 1)); /* no circle holds y and z */
}

static void test_each_missing_position_is_named(void)
{
    for (int p = 0; p < 18; p++) {
        measured[p] = false;
        assert_refused(TUMBLE_E_MISSING_POSITION, measured, SLOT(p / 9 + 1, p % 9 + 1));
        measured[p] = true;
    }
    measured[0] = false;
    measured[17] = false;
    measured[13] = false;
    assert_refused(TUMBLE_E_MISSING_POSITION, measured, SLOT(1, 1) | SLOT(2, 9) | SLOT(2, 5));
    memset(measured, 0, sizeof measured);
    assert_refused(TUMBLE_E_MISSING_POSITION, measured, ALL_SLOTS);
}

static void test_a_schedule_that_lacks_a_position(void)
{
    for (int p = 0; p < 18; p++) {
        set_up();
        positions[p] = positions[17];
        schedule.position_count = 17;
        assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
        assert_refused(TUMBLE_E_NOT_HARMONIC, measured, 0);
    }
}

/* Positions 1 and 9 are one attitude, but not one position: a full turn lies between. */
static void test_the_first_and_the_ninth_do_not_stand_for_each_other(void)
{
    positions[8].angle = positions[0].angle;
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
    positions[0].angle.deg = 360.0;
    positions[8].angle.deg = 360.0;
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
}

static void test_numbers_and_order_do_not_matter(void)
{
    dice_t dice = {4};
    for (int round = 0; round < 100; round++) {
        uint8_t at[18];
        set_up();
        for (uint8_t p = 0; p < 18U; p++) {
            at[p] = p;
        }
        for (uint32_t p = 17; p > 0U; p--) {
            const uint32_t other = dice_below(&dice, p + 1U);
            const uint8_t kept = at[p];
            at[p] = at[other];
            at[other] = kept;
        }
        for (uint8_t p = 0; p < 18U; p++) {
            positions[at[p]] = tumble_schedule_paper.positions[p];
            positions[at[p]].number = (uint8_t)(250U - at[p]);
            positions[at[p]].mounting = (p < 9U) ? 77 : 5;
        }
        mountings[0] = tumble_schedule_paper.mountings[1];
        mountings[0].number = 5;
        mountings[1] = tumble_schedule_paper.mountings[0];
        mountings[1].number = 77;
        for (uint8_t slot = 0; slot < 18U; slot++) { /* the first mounting stands second */
            TEST_ASSERT_EQUAL_UINT8(at[slot], circle_of(NULL, 1U - slot / 9U).index[slot % 9U]);
        }
    }
}

static void test_extra_positions_and_mountings_do_no_harm(void)
{
    const tumble_angle_t angles[] = {steps_of_7_5_deg[3],
                                     {405.0, positions[1].angle.sine, positions[1].angle.cosine},
                                     {-45.0, positions[7].angle.sine, positions[7].angle.cosine}};
    mountings[2] = mountings[0];
    mountings[2].number = 3;
    mountings[2].tilt = (tumble_angle_t){5.0, 0.08715574274765818, 0.99619469809174555};
    mountings[3] = (tumble_mounting_t){4, {{0, 0.6, 0.8}, {0, -0.8, 0.6}, {1, 0, 0}}, LEVEL, 0};
    schedule.mounting_count = 4;
    for (uint8_t p = 18; p < TUMBLE_MAX_POSITIONS; p++) {
        positions[p] = (tumble_position_t){3, p, TUMBLE_USE_FIT, positions[p % 9U].angle};
        positions[p].mounting = (p < 24U) ? 3 : 4;
        if (p > 32U) {
            positions[p].mounting = 1;
            positions[p].angle = angles[p - 33U];
        }
    }
    schedule.position_count = TUMBLE_MAX_POSITIONS;
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&schedule, NULL));
    assert_circles(&schedule, measured, 0, 1, 1);
    for (uint8_t slot = 0; slot < 18U; slot++) {
        TEST_ASSERT_EQUAL_UINT8(slot, circle_of(measured, slot / 9U).index[slot % 9U]);
    }
}

static void test_check_positions_fill_no_slot(void)
{
    positions[4].use = TUMBLE_USE_CHECK;
    positions[11].use = TUMBLE_USE_CHECK;
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
}

static void test_a_tilted_axis_is_not_the_papers(void)
{
    mountings[0].tilt = (tumble_angle_t){0.05786874714686748, 0.00101, 0.99999948994986998};
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
}

/* An axis turned end over end is level again, but every attitude on it is reversed. */
static void test_an_axis_turned_end_over_end_is_not_the_papers(void)
{
    mountings[1].tilt = (tumble_angle_t){180.0, 0.0, -1.0};
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&schedule, NULL));
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
}

static void test_null_is_refused(void)
{
    tumble_harmonic_map_t map;
    uint64_t missing = UNTOUCHED;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_schedule_harmonic(NULL, NULL, &map, &missing));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_schedule_harmonic(&schedule, NULL, NULL, &missing));
    TEST_ASSERT_EQUAL_HEX64(UNTOUCHED, missing);
}

static void test_an_axis_beside_the_stands_is_no_circle(void)
{
    for (int j = 0; j < 3; j++) {
        set_up();
        mountings[1].matrix[j][1] += 1e-3;
        assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
    }
}

static void test_a_slightly_different_angle_is_not_the_papers(void)
{
    positions[1].angle = (tumble_angle_t){45.001, 0.70711912204256, 0.70709444};
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, 0);
}

/* A second visit to an attitude fills the slot when the first was not measured. */
static void test_a_repeated_position_may_stand_in(void)
{
    positions[18] = positions[3];
    positions[18].number = 44;
    schedule.position_count = 19;
    TEST_ASSERT_EQUAL_UINT8(3, circle_of(measured, 0).index[3]);
    measured[3] = false;
    assert_circles(&schedule, measured, 0, 1, 1);
    TEST_ASSERT_EQUAL_UINT8(18, circle_of(measured, 0).index[3]);
    measured[18] = false;
    assert_refused(TUMBLE_E_MISSING_POSITION, measured, UINT64_C(1) << 18);
}
