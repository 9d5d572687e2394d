/* Where the table is sent: every angle from the same side, within the cable's limits. */
#include "procedure_bench.h"

#include "angles.h"

static void run(void)
{
    bench_start_to_done(&bench);
}

static void assert_moves(const double *expected_deg, size_t count)
{
    TEST_ASSERT_EQUAL_UINT(count, bench.stand.moves);
    for (size_t i = 0; i < count; i++) {
        ASSERT_SAME_DOUBLE(expected_deg[i], bench.stand.moves_deg[i]);
    }
}

/* Up from below at home, up through the turn, and back below 0 for the second mounting. */
static void test_the_papers_schedule(void)
{
    static const double expected_deg[] = {-5, 0, 45, 90, 135, 180, 225, 270, 315, 360,
                                          -5, 0, 45, 90, 135, 180, 225, 270, 315, 360};
    run();
    assert_moves(expected_deg, COUNT_OF(expected_deg));
}

static void test_without_an_approach_every_angle_is_one_move(void)
{
    bench.config.approach_deg = 0.0;
    bench.config.cable_min_deg = 0.0;
    run();
    TEST_ASSERT_EQUAL_UINT(18, bench.stand.moves);
}

/* From exactly the approach below there is no need to go back. */
static void test_an_approach_as_long_as_the_step(void)
{
    static const double expected_deg[] = {-45, 0, 45, 90, 135, 180, 225, 270, 315, 360,
                                          -45, 0, 45, 90, 135, 180, 225, 270, 315, 360};
    bench.config.approach_deg = 45.0;
    bench.config.cable_min_deg = -45.0;
    run();
    assert_moves(expected_deg, COUNT_OF(expected_deg));
}

/* A cable that ends at 0 leaves no way up to 0: a turn further is the same attitude. */
static void test_an_equivalent_turn_within_the_cable(void)
{
    static const double expected_deg[] = {360, 40, 45, 90, 135, 180, 225, 270, 315, 360, 355,
                                          360, 40, 45, 90, 135, 180, 225, 270, 315, 360};
    bench.config.cable_min_deg = 0.0;
    bench.config.cable_max_deg = 360.0;
    run();
    assert_moves(expected_deg, COUNT_OF(expected_deg));
    TEST_ASSERT_EQUAL_UINT32(2, counters()->unwinds);
}

/* One turn and a little: what lies beyond is reached by turning back. */
static void test_unwinding(void)
{
    static const double expected_deg[] = {-5, 0, 45, 90, 135, 180, -140, -135, -90, -45, 0,
                                          -5, 0, 45, 90, 135, 180, -140, -135, -90, -45, 0};
    bench.config.cable_min_deg = -180.0;
    bench.config.cable_max_deg = 180.0;
    run();
    assert_moves(expected_deg, COUNT_OF(expected_deg));
    TEST_ASSERT_EQUAL_UINT32(8, counters()->unwinds);
}

/* Every final move goes up, by the approach at least, and nothing leaves the cable, wherever its limits are. */
static void test_always_from_below_and_never_beyond(void)
{
    dice_t dice = {7};
    for (int i = 0; i < 60; i++) {
        bench_init(&bench);
        bench.config.approach_deg = 1.0 + (double)dice_below(&dice, 30);
        bench.config.cable_min_deg = -400.0 + (double)dice_below(&dice, 700);
        const double room_deg = bench.config.approach_deg + 360.0 + (double)dice_below(&dice, 90);
        bench.config.cable_max_deg = bench.config.cable_min_deg + room_deg;
        run();
        double here_deg = 0.0;
        size_t reached = 0;
        for (size_t m = 0; m < bench.stand.moves; m++) {
            const double to_deg = bench.stand.moves_deg[m];
            TEST_ASSERT_TRUE(to_deg >= bench.config.cable_min_deg);
            TEST_ASSERT_TRUE(to_deg <= bench.config.cable_max_deg);
            double off_deg = to_deg - tumble_schedule_paper.positions[reached].angle.deg;
            while (off_deg > 180.0) {
                off_deg -= 360.0;
            }
            while (off_deg < -180.0) {
                off_deg += 360.0;
            }
            if (off_deg == 0.0) {
                TEST_ASSERT_TRUE((to_deg - here_deg) >= bench.config.approach_deg);
                reached++;
            } else {
                TEST_ASSERT_DOUBLE_WITHIN(1e-9, -bench.config.approach_deg, off_deg);
            }
            here_deg = to_deg;
        }
        TEST_ASSERT_EQUAL_UINT(18, reached);
    }
}

static void test_the_scheduled_turn_is_kept_when_allowed(void)
{
    static const tumble_position_t positions[] = {
        {1, 1, TUMBLE_USE_FIT, {720.0, 0.0, 1.0}},   {1, 2, TUMBLE_USE_FIT, {450.0, 1.0, 0.0}},
        {1, 3, TUMBLE_USE_FIT, {-540.0, 0.0, -1.0}}, {2, 1, TUMBLE_USE_FIT, {0.0, 0.0, 1.0}},
        {2, 2, TUMBLE_USE_FIT, {90.0, 1.0, 0.0}},    {2, 3, TUMBLE_USE_FIT, {180.0, 0.0, -1.0}},
    };
    static const double expected_deg[] = {720, 445, 450, -545, -540, 0, 90, 180};
    tumble_schedule_t schedule = tumble_schedule_paper;
    schedule.positions = positions;
    schedule.position_count = 6;
    bench.config.schedule = &schedule;
    bench.config.estimate = TUMBLE_ESTIMATE_LEAST_SQUARES;
    bench.config.cable_min_deg = -600.0;
    bench.config.cable_max_deg = 720.0;
    run();
    assert_moves(expected_deg, COUNT_OF(expected_deg));
    TEST_ASSERT_EQUAL_UINT32(0, counters()->unwinds);
}

/* After a stop somewhere on the way the side is judged by where the table stands. */
static void test_the_side_is_judged_by_the_actual_angle(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to_position(&bench, 3, TUMBLE_STATE_MOVE);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_STALL, 0);
    bench_run(&bench);
    bench.stand.angle_deg = 134.0; /* too near */
    const unsigned moves = bench.stand.moves;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    TEST_ASSERT_EQUAL_UINT(moves + 2U, bench.stand.moves);
    ASSERT_SAME_DOUBLE(130.0, bench.stand.moves_deg[moves]);
    ASSERT_SAME_DOUBLE(135.0, bench.stand.moves_deg[moves + 1U]);
}

static void expect_refused(tumble_reason_t reason, tumble_status_t status, int line)
{
    tumble_reason_t found;
    UNITY_TEST_ASSERT_EQUAL_INT(status, tumble_procedure_validate(&bench.config, &found), (UNITY_LINE_TYPE)line, NULL);
    UNITY_TEST_ASSERT_EQUAL_INT(reason, found, (UNITY_LINE_TYPE)line, NULL);
    bench_init(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_validate(&bench.config, &found));
    TEST_ASSERT_EQUAL(TUMBLE_REASON_NONE, found);
}

#define EXPECT_OUT_OF_RANGE(member, value)                                                                             \
    do {                                                                                                               \
        bench.config.member = (value);                                                                                 \
        expect_refused(TUMBLE_REASON_CONFIGURATION, TUMBLE_E_ARGUMENT, __LINE__);                                      \
    } while (0)

/* With the stuck gate on a position must be able to show a stuck channel: by a run that long, or by so many equal samples that
 * noise does not make them. */
static void test_samples_too_few_for_the_stuck_gate(void)
{
    static const struct {
        float noise_counts;
        uint32_t enough;
    } cases[] = {{251.0F, 3}, {100.0F, 4}, {10.0F, 5}, {3.0F, 7}, {1.0F, 14}, {0.1F, 14}, {0.0F, 14}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        tumble_reason_t reason;
        bench.averaging.noise_counts = cases[i].noise_counts;
        bench.averaging.min_samples = 1;
        for (uint32_t samples = 1; samples <= 20U; samples++) {
            bench.config.samples = samples;
            bench.averaging.stuck_run = 20;
            const tumble_status_t expected = (samples < cases[i].enough) ? TUMBLE_E_ARGUMENT : TUMBLE_OK;
            ASSERT_STATUS(expected, tumble_procedure_validate(&bench.config, &reason));
            TEST_ASSERT_EQUAL((expected == TUMBLE_OK) ? TUMBLE_REASON_NONE : TUMBLE_REASON_CONFIGURATION, reason);
            bench.averaging.stuck_run = (uint16_t)((samples < 2U) ? 2U : samples);
            ASSERT_STATUS((samples < 2U) ? TUMBLE_E_ARGUMENT : TUMBLE_OK,
                          tumble_procedure_validate(&bench.config, &reason));
            bench.averaging.stuck_run = 0; /* the gate is off */
            ASSERT_STATUS(TUMBLE_OK, tumble_procedure_validate(&bench.config, &reason));
        }
        bench.averaging.stuck_run = 20; /* a position may end with the fewest */
        bench.config.error_budget_v = 1e-3;
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_validate(&bench.config, &reason));
        bench.averaging.min_samples = cases[i].enough;
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_validate(&bench.config, &reason));
        bench_init(&bench);
    }
}

static void test_configurations_out_of_range(void)
{
    const double nan = (double)NAN;
    const double inf = (double)INFINITY;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_validate(NULL, NULL));
    EXPECT_OUT_OF_RANGE(schedule, NULL);
    EXPECT_OUT_OF_RANGE(averaging, NULL);
    EXPECT_OUT_OF_RANGE(estimate, (tumble_estimate_t)3);
    EXPECT_OUT_OF_RANGE(samples, 9);
    EXPECT_OUT_OF_RANGE(samples, (uint32_t)TUMBLE_MAX_SAMPLES + 1U);
    EXPECT_OUT_OF_RANGE(v_per_count, 0.0);
    EXPECT_OUT_OF_RANGE(v_per_count, nan);
    EXPECT_OUT_OF_RANGE(nominal_scale_v_per_g, 0.0);
    EXPECT_OUT_OF_RANGE(nominal_scale_v_per_g, -inf);
    EXPECT_OUT_OF_RANGE(gravity_limit_g, 0.0);
    EXPECT_OUT_OF_RANGE(gravity_limit_g, inf);
    EXPECT_OUT_OF_RANGE(closure_limit_g, -1e-3);
    EXPECT_OUT_OF_RANGE(position_tolerance_deg, 0.0);
    EXPECT_OUT_OF_RANGE(position_tolerance_deg, nan);
    EXPECT_OUT_OF_RANGE(approach_deg, -1.0);
    EXPECT_OUT_OF_RANGE(approach_deg, inf);
    EXPECT_OUT_OF_RANGE(cable_min_deg, nan);
    EXPECT_OUT_OF_RANGE(cable_min_deg, 400.0);
    EXPECT_OUT_OF_RANGE(cable_max_deg, inf);
    bench.config.settle_timeout_ms = 5000;
    EXPECT_OUT_OF_RANGE(settle_ms, 4096);
    EXPECT_OUT_OF_RANGE(warm_up_band_half_c, -1);
    EXPECT_OUT_OF_RANGE(preflight_timeout_ms, 0);
    EXPECT_OUT_OF_RANGE(warm_up_timeout_ms, 0);
    EXPECT_OUT_OF_RANGE(mounting_timeout_ms, 0);
    EXPECT_OUT_OF_RANGE(home_timeout_ms, 0);
    EXPECT_OUT_OF_RANGE(move_timeout_ms, 0);
    EXPECT_OUT_OF_RANGE(settle_timeout_ms, 200);
    EXPECT_OUT_OF_RANGE(average_timeout_ms, 0);
    EXPECT_OUT_OF_RANGE(sample_timeout_ms, 0);
}

static void test_configurations_at_the_end_of_their_range(void)
{
    bench.config.samples = bench.averaging.min_samples;
    bench.config.approach_deg = 0.0;
    bench.config.settle_ms = 4095;
    bench.config.settle_timeout_ms = 4096;
    bench.config.warm_up_band_half_c = 0;
    bench.config.preflight_timeout_ms = 1;
    bench.config.warm_up_timeout_ms = 1;
    bench.config.mounting_timeout_ms = 1;
    bench.config.home_timeout_ms = 1;
    bench.config.move_timeout_ms = 1;
    bench.config.average_timeout_ms = 1;
    bench.config.sample_timeout_ms = 1;
    bench.config.v_per_count = -1e-6;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_validate(&bench.config, NULL));
    bench.config.samples = (uint32_t)TUMBLE_MAX_SAMPLES;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_validate(&bench.config, NULL));
}

static void test_cables_that_are_just_too_short(void)
{
    tumble_reason_t reason;
    bench.config.cable_min_deg = -5.0;
    bench.config.cable_max_deg = 315.0; /* 360 is 0 again */
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_validate(&bench.config, &reason));
    bench.config.cable_max_deg = 314.9;
    expect_refused(TUMBLE_REASON_CABLE_LIMIT, TUMBLE_E_ARGUMENT, __LINE__);
    bench.config.approach_deg = 0.0;
    bench.config.cable_min_deg = 1.0; /* everything but the first position and its like */
    bench.config.cable_max_deg = 359.0;
    expect_refused(TUMBLE_REASON_CABLE_LIMIT, TUMBLE_E_ARGUMENT, __LINE__);
    bench.config.cable_min_deg = 360.0 * 15.0;
    bench.config.cable_max_deg = bench.config.cable_min_deg + 365.0;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_validate(&bench.config, &reason));
    bench.config.cable_min_deg = 1e6;
    bench.config.cable_max_deg = 1.1e6;
    expect_refused(TUMBLE_REASON_CABLE_LIMIT, TUMBLE_E_ARGUMENT, __LINE__);
}

static const around_t around_each = {begin, NULL};
