/* What counts as rest, to the count and to the report, and the first rung of the ladder. */
#include "drive_bench.h"
#include "stand/drive402/internal.h"

/* In quick stop active, and still braking: the position alone tells. */
static void brake(void)
{
    start_move(&common);
    played.quick_stop_stays = true;
    played.hides_standstill = true;
    played.brakes_for_ms = 100000;
    played.goal = 10000000;
    stop_for(20);
    played.moving = false; /* the test moves it */
    played.event_only = true;
}

static void test_reports_of_rest_must_follow_each_other(void)
{
    brake();
    for (int i = 0; i < 10; i++) {
        played.actual++;
        report_now();
        report_now();
        assert_state_after(0, TUMBLE_STAND_MOVING);
    }
    report_now();
    report_now();
    assert_state_after(0, TUMBLE_STAND_STOPPED);
}

/* Process data may be lost: the same once more before any other way, also where no report asks for it. */
static void test_the_first_way_is_process_data_again(void)
{
    start_move(&common);
    played.goal = 10000000;
    played.write_count = 0;
    played.misses = 1;
    played.report_ms = 10000;
    played.counts_per_ms = 1;
    stop_for(195);
    TEST_ASSERT_TRUE(played.moving);
    run_ms(10);
    TEST_ASSERT_FALSE(played.moving);
    played.report_ms = 0;
    run_to(TUMBLE_STAND_STOPPED, 100);
    TEST_ASSERT_EQUAL_UINT32(1, bench.drive.report.stop.rungs[0]);
    TEST_ASSERT_EQUAL_UINT32(0, bench.drive.report.stop.rungs[1]);
    TEST_ASSERT_EQUAL_UINT(0, played.write_count);
}

/* At rest it may stray so far, and not one count further. */
static void test_an_axis_at_rest_may_stray_to_the_last_count(void)
{
    bring_home(&common);
    move_to(90.0);
    run_ms(3000);
    TEST_ASSERT_TRUE(bench.drive.rest_counts > 1U);
    played.actual += (int32_t)bench.drive.rest_counts;
    report_now();
    report_now();
    TEST_ASSERT_EQUAL_UINT32(0, bench.drive.report.stop.implausible);
    assert_state_after(0, TUMBLE_STAND_IN_POSITION);
    played.actual += 1;
    report_now();
    report_now();
    TEST_ASSERT_EQUAL_UINT32(2, bench.drive.report.stop.implausible);
    assert_fault(TUMBLE_STAND_FAULT_POSITION);
}
