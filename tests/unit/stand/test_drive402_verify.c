/* Before a motion the drive is asked for what the motion depends on: a stranger may have changed it. */
#include "drive_bench.h"

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint32_t ours;
} motion_object_t;

static const motion_object_t objects[] = {
    {0x6081, 0, 100000}, {0x6083, 0, 18000}, {0x6085, 0, 72050}, {0x6099, 1, 2000}};

static uint32_t kept(const motion_object_t *object)
{
    for (size_t i = 0; i < COUNT_OF(played.kept); i++) {
        if ((played.kept[i].index == object->index) && (played.kept[i].subindex == object->subindex)) {
            return played.kept[i].value;
        }
    }
    return 0;
}

static tumble_status_t begin_motion(bool homes)
{
    return homes ? bench.stand.kind->home(bench.stand.self) : bench.stand.kind->move(bench.stand.self, 30.0);
}

static void test_what_differs_is_written_again_before_the_axis_turns(void)
{
    for (size_t i = 0; i < COUNT_OF(objects); i++) {
        for (int homes = 0; homes < 2; homes++) {
            bring_home(&common);
            TEST_ASSERT_EQUAL_UINT32(objects[i].ours, kept(&objects[i]));
            scripted_drive_change(&played, objects[i].index, objects[i].subindex, 3U * objects[i].ours);
            ASSERT_STATUS(TUMBLE_OK, begin_motion(homes != 0));
            while (!scripted_drive_moves(&played)) {
                run_ms(1);
            }
            TEST_ASSERT_EQUAL_UINT32(objects[i].ours, kept(&objects[i]));
            run_to(TUMBLE_STAND_IN_POSITION, 500);
            TEST_ASSERT_EQUAL_HEX16(0, bench.drive.report.refusal.index);
        }
    }
}

static void test_widened_limits_are_narrowed_again(void)
{
    bring_home(CHANGED(common, made.software_limits = true));
    played.limits[0] = -36000000;
    played.limits[1]++; /* one count is one too many */
    ASSERT_STATUS(TUMBLE_OK, begin_motion(false));
    run_to(TUMBLE_STAND_IN_POSITION, 500);
    TEST_ASSERT_EQUAL_INT32(-3000, played.limits[0]);
    TEST_ASSERT_EQUAL_INT32(40000, played.limits[1]);
}

static void test_a_drive_may_round_its_quantities(void)
{
    bring_home(&common);
    scripted_drive_change(&played, 0x6081, 0, 100000U - (100000U / 64U));
    scripted_drive_change(&played, 0x6083, 0, 18000U + (18000U / 64U));
    const unsigned writes = played.write_count;
    ASSERT_STATUS(TUMBLE_OK, begin_motion(false));
    run_to(TUMBLE_STAND_IN_POSITION, 500);
    TEST_ASSERT_EQUAL_UINT(writes, played.write_count);
    scripted_drive_change(&played, 0x6081, 0, 100000U - (100000U / 64U) - 2U);
    move_to(0.0);
    TEST_ASSERT_EQUAL_UINT(writes + 1U, played.write_count);
}

/* It is written again and again until the time of a handshake is over. */
static void test_a_drive_that_does_not_keep_it_does_not_turn(void)
{
    for (size_t i = 0; i < COUNT_OF(objects); i++) {
        for (int homes = 0; homes < 2; homes++) {
            bring_home(&common);
            scripted_drive_change(&played, objects[i].index, objects[i].subindex, 2U * objects[i].ours);
            played.keeps_nothing = true;
            ASSERT_STATUS(TUMBLE_OK, begin_motion(homes != 0));
            for (unsigned ms = 0; ms < 200U; ms++) {
                run_ms(1);
                TEST_ASSERT_EQUAL_HEX16(0, scripted_drive_moves(&played) ? objects[i].index : 0U);
            }
            assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
            TEST_ASSERT_EQUAL_HEX16(objects[i].index, bench.drive.report.refusal.index);
            TEST_ASSERT_EQUAL_UINT8(objects[i].subindex, bench.drive.report.refusal.subindex);
            TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, bench.drive.report.refusal.abort);
        }
    }
}

/* Between the read-back and the motion no state but these is shown. */
static void test_meanwhile_the_stand_is_on_its_way(void)
{
    bring_home(&common);
    played.sdo_is_deaf = true;
    ASSERT_STATUS(TUMBLE_OK, begin_motion(false));
    assert_state_after(20, TUMBLE_STAND_MOVING);
    stop_at_rest();
    played.sdo_is_deaf = false;
    ASSERT_STATUS(TUMBLE_OK, begin_motion(true));
    assert_state_after(1, TUMBLE_STAND_HOMING);
    run_to(TUMBLE_STAND_IN_POSITION, 500);
}
