/* Finding the 2 x 9 positions of the paper in any schedule, by geometry. */
#include "model.h"
#include "six_faces.h"

#define SLOT(mounting, position) (UINT32_C(1) << (((mounting) - 1) * 9 + (position) - 1))
#define ALL_SLOTS ((UINT32_C(1) << 18) - 1U)
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

static void assert_refused(tumble_status_t expected, const bool *flags, uint32_t expected_missing)
{
    tumble_harmonic_map_t map;
    uint32_t missing = UNTOUCHED;
    ASSERT_STATUS(expected, tumble_schedule_harmonic(&schedule, flags, &map, &missing));
    TEST_ASSERT_EQUAL_HEX32(expected_missing, missing);
    ASSERT_STATUS(expected, tumble_schedule_harmonic(&schedule, flags, &map, NULL));
}

static tumble_harmonic_map_t map_of(const bool *flags)
{
    tumble_harmonic_map_t map;
    uint32_t missing = UNTOUCHED;
    memset(&map, UNTOUCHED, sizeof map);
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_harmonic(&schedule, flags, &map, &missing));
    TEST_ASSERT_EQUAL_HEX32(0, missing);
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_harmonic(&schedule, flags, &map, NULL));
    return map;
}

static void test_the_paper_maps_to_itself(void)
{
    const tumble_harmonic_map_t map = map_of(NULL);
    const tumble_harmonic_map_t same = map_of(measured);
    for (unsigned slot = 0; slot < 18U; slot++) {
        TEST_ASSERT_EQUAL_UINT8(slot, map.index[slot / 9U][slot % 9U]);
        TEST_ASSERT_EQUAL_UINT8(slot, same.index[slot / 9U][slot % 9U]);
    }
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

static void test_each_position_that_the_schedule_lacks_is_named(void)
{
    for (int p = 0; p < 18; p++) {
        set_up();
        positions[p] = positions[17];
        schedule.position_count = 17;
        assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, SLOT(p / 9 + 1, p % 9 + 1));
        assert_refused(TUMBLE_E_NOT_HARMONIC, measured, SLOT(p / 9 + 1, p % 9 + 1));
    }
    schedule = six_faces;
    const uint32_t up_and_down = SLOT(1, 1) | SLOT(1, 5); /* the third mounting of the six faces is the paper's first */
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, ALL_SLOTS & ~up_and_down);
}

/* Positions 1 and 9 are one attitude, but not one position: a full turn lies between. */
static void test_the_first_and_the_ninth_do_not_stand_for_each_other(void)
{
    positions[8].angle = positions[0].angle;
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, SLOT(1, 9));
    positions[0].angle.deg = 360.0;
    positions[8].angle.deg = 360.0;
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, SLOT(1, 1));
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
        const tumble_harmonic_map_t map = map_of(NULL);
        for (unsigned slot = 0; slot < 18U; slot++) {
            TEST_ASSERT_EQUAL_UINT8(at[slot], map.index[slot / 9U][slot % 9U]);
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
    mountings[3] = (tumble_mounting_t){4, {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, LEVEL};
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
    const tumble_harmonic_map_t map = map_of(measured);
    for (unsigned slot = 0; slot < 18U; slot++) {
        TEST_ASSERT_EQUAL_UINT8(slot, map.index[slot / 9U][slot % 9U]);
    }
}

static void test_check_positions_fill_no_slot(void)
{
    positions[4].use = TUMBLE_USE_CHECK;
    positions[11].use = TUMBLE_USE_CHECK;
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, SLOT(1, 5) | SLOT(2, 3));
}

static void test_a_tilted_axis_is_not_the_papers(void)
{
    mountings[0].tilt = (tumble_angle_t){0.05786874714686748, 0.00101, 0.99999948994986998};
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, ALL_SLOTS & 0x1FFU);
}

/* An axis turned end over end is level again, but every attitude on it is reversed. */
static void test_an_axis_turned_end_over_end_is_not_the_papers(void)
{
    mountings[1].tilt = (tumble_angle_t){180.0, 0.0, -1.0};
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&schedule, NULL));
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, ALL_SLOTS & ~0x1FFU);
}

static void test_null_is_refused(void)
{
    tumble_harmonic_map_t map;
    uint32_t missing = UNTOUCHED;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_schedule_harmonic(NULL, NULL, &map, &missing));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_schedule_harmonic(&schedule, NULL, NULL, &missing));
    TEST_ASSERT_EQUAL_HEX32(UNTOUCHED, missing);
}

static void test_another_rotation_is_not_the_papers(void)
{
    for (int element = 0; element < 9; element++) {
        set_up();
        mountings[1].matrix[element / 3][element % 3] += 1e-3;
        assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, ALL_SLOTS & ~0x1FFU);
    }
}

static void test_a_slightly_different_angle_is_not_the_papers(void)
{
    positions[1].angle = (tumble_angle_t){45.001, 0.70711912204256, 0.70709444};
    assert_refused(TUMBLE_E_NOT_HARMONIC, NULL, SLOT(1, 2));
}

/* A second visit to an attitude fills the slot when the first was not measured. */
static void test_a_repeated_position_may_stand_in(void)
{
    positions[18] = positions[3];
    positions[18].number = 44;
    schedule.position_count = 19;
    measured[3] = false;
    const tumble_harmonic_map_t map = map_of(measured);
    TEST_ASSERT_EQUAL_UINT8(18, map.index[0][3]);
    measured[18] = false;
    assert_refused(TUMBLE_E_MISSING_POSITION, measured, SLOT(1, 4));
}

static void test_a_refusal_leaves_the_map_as_it_was(void)
{
    tumble_harmonic_map_t map;
    tumble_harmonic_map_t as_it_was;
    memset(&map, UNTOUCHED, sizeof map);
    as_it_was = map;
    measured[7] = false;
    ASSERT_STATUS(TUMBLE_E_MISSING_POSITION, tumble_schedule_harmonic(&schedule, measured, &map, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &map, sizeof map);
    ASSERT_STATUS(TUMBLE_E_NOT_HARMONIC, tumble_schedule_harmonic(&six_faces, NULL, &map, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &map, sizeof map);
}

static const around_t around_each = {set_up, NULL};
