/* Every reason to stop, reached by the fault that it names: in bounded virtual time, with the table at rest. */
#include "sim_bench.h"
#include "world/world.h"

typedef struct {
    tumble_reason_t reason;
    tumble_state_t failed_in;
    double within_s;
    const char *lines;
} case_t;

/* The operator does not mend: the run ends in FAULT with the reason. */
static const case_t FAULTS[] = {
    {TUMBLE_REASON_SCHEDULE, TUMBLE_STATE_PREFLIGHT, 1,
     "mounting = 1  0 0 1  1 0 0 0 1 0 0 0 1\nposition = 1 1 fit  0 0 1\nposition = 1 2 fit  90 1 0\n"
     "procedure.estimator = least_squares\n"},
    {TUMBLE_REASON_CONFIGURATION, TUMBLE_STATE_PREFLIGHT, 1, "procedure.position_tolerance_deg = 0\n"},
    {TUMBLE_REASON_CABLE_LIMIT, TUMBLE_STATE_PREFLIGHT, 1,
     "procedure.cable_min_deg = -10\nprocedure.cable_max_deg = 100\n"},
    {TUMBLE_REASON_STAND_OFFLINE, TUMBLE_STATE_PREFLIGHT, 11, "fault = drive_silent time=0\n"},
    {TUMBLE_REASON_STAND_PROTOCOL, TUMBLE_STATE_PREFLIGHT, 11, "profile.write = 0x2000 0 4 1\n"},
    {TUMBLE_REASON_STAND_HEARTBEAT, TUMBLE_STATE_MOVE, 15, "fault = drive_silent at=1.4 phase=move delay=0.2\n"},
    {TUMBLE_REASON_DRIVE_FAULT, TUMBLE_STATE_MOVE, 15, "fault = drive_fault at=1.3 phase=move delay=0.3 value=8976\n"},
    {TUMBLE_REASON_DRIVE_FAULT, TUMBLE_STATE_AVERAGE, 15, "fault = drive_fault at=1.3 value=8976\n"},
    {TUMBLE_REASON_DRIVE_POWER, TUMBLE_STATE_MOVE, 15,
     "fault = drive_power_cycle at=1.4 phase=move delay=0.3 duration=0.3\n"},
    {TUMBLE_REASON_STALL, TUMBLE_STATE_MOVE, 15, "fault = stall at=1.4 phase=move delay=0.3\n"},
    {TUMBLE_REASON_HOMING, TUMBLE_STATE_HOME, 30, "fault = homing_fails at=1.1 phase=mount\n"},
    {TUMBLE_REASON_HOMING, TUMBLE_STATE_HOME, 25, "fault = homing_endless at=1.1 phase=mount\n"},
    {TUMBLE_REASON_HOMING, TUMBLE_STATE_HOME, 25, /* the quick stop is lost, and the next one */
     "fault = homing_endless at=1.1 phase=home\n"
     "fault = frame_drop at=1.1 phase=home delay=16 id=514 mask=2047 count=2 probability=1\n"},
    {TUMBLE_REASON_TARGET_NOT_REACHED, TUMBLE_STATE_MOVE, 50, "fault = never_reached at=1.4 value=0.5\n"},
    {TUMBLE_REASON_SLIP, TUMBLE_STATE_AVERAGE, 30, "fault = slip at=1.8 phase=settle value=1.5\n"},      /* closure */
    {TUMBLE_REASON_SLIP, TUMBLE_STATE_AVERAGE, 15, "fault = slip at=1.4 delay=0.1 value=0.5 count=1\n"}, /* encoder */
    {TUMBLE_REASON_BLOCK_HEARTBEAT, TUMBLE_STATE_AVERAGE, 15, "fault = block_silent at=1.5\n"},
    {TUMBLE_REASON_BLOCK_HEARTBEAT, TUMBLE_STATE_MOVE, 15, "fault = block_silent at=1.5 phase=move\n"},
    {TUMBLE_REASON_NO_SAMPLES, TUMBLE_STATE_AVERAGE, 15, "fault = no_samples at=1.5\n"},
    {TUMBLE_REASON_SAMPLES_LOST, TUMBLE_STATE_AVERAGE, 20,
     "fault = lost_samples at=1.5 delay=0.2 count=20 times=9 duration=0.4\n"},
    {TUMBLE_REASON_SAMPLES_CORRUPTED, TUMBLE_STATE_SETTLE, 20, "fault = wrong_crc at=1.5\n"},
    {TUMBLE_REASON_SAMPLES_CORRUPTED, TUMBLE_STATE_SETTLE, 20,
     "fault = frame_corrupt time=10 id=0x693 probability=0.5\n"},
    {TUMBLE_REASON_BLOCK_STATUS, TUMBLE_STATE_AVERAGE, 15, "fault = status at=1.5 value=4\n"},
    {TUMBLE_REASON_SATURATED, TUMBLE_STATE_AVERAGE, 15, "fault = saturated at=1.2 channels=y\n"},
    {TUMBLE_REASON_STUCK, TUMBLE_STATE_AVERAGE, 15, "fault = stuck at=1.2 channels=z\n"},
    {TUMBLE_REASON_NOT_STILL, TUMBLE_STATE_AVERAGE, 15, "fault = noisy at=1.2 channels=z value=0.01\n"},
    {TUMBLE_REASON_WARM_UP, TUMBLE_STATE_WARM_UP, 25,
     "block.start_c = 10\nblock.end_c = 40\nblock.warm_s = 300\nprocedure.warm_up_timeout_ms = 20000\n"
     "procedure.warm_up_samples = 10000\n"},
    {TUMBLE_REASON_MOUNTING_NOT_CONFIRMED, TUMBLE_STATE_WAIT_MOUNTING, 601, "operator.mount_s = -1\n"},
    {TUMBLE_REASON_WRONG_MOUNTING, TUMBLE_STATE_AVERAGE, 10,
     "operator.wrong_mounting = 1\noperator.mounted_instead = 2\n"},
    {TUMBLE_REASON_WRONG_MOUNTING, TUMBLE_STATE_AVERAGE, 35,
     "operator.wrong_mounting = 2\noperator.mounted_instead = 1\n"},
    {TUMBLE_REASON_SWAPPED_CHANNELS, TUMBLE_STATE_AVERAGE, 10, "fault = swapped time=0 channels=xz\n"},
    {TUMBLE_REASON_SWAPPED_CHANNELS, TUMBLE_STATE_AVERAGE, 10, "fault = swapped time=0 channels=xy\n"},
    {TUMBLE_REASON_SWAPPED_CHANNELS, TUMBLE_STATE_AVERAGE, 10, "fault = inverted time=0 channels=z\n"},
    {TUMBLE_REASON_SWAPPED_CHANNELS, TUMBLE_STATE_AVERAGE, 10, "fault = inverted time=0 channels=x\n"},
    {TUMBLE_REASON_UNCERTAIN, TUMBLE_STATE_AVERAGE, 15, "procedure.error_budget_v = 1e-6\n"},
    {TUMBLE_REASON_BUS, TUMBLE_STATE_AVERAGE, 15, "fault = bus_off at=1.5\n"},
    {TUMBLE_REASON_RUNAWAY, TUMBLE_STATE_MOVE, 15, "fault = runaway at=1.5 phase=move\n"},
    {TUMBLE_REASON_RUNAWAY, TUMBLE_STATE_MOVE, 15, "fault = runaway at=1.5 phase=move delay=0.3 value=30\n"},
    {TUMBLE_REASON_HOMING, TUMBLE_STATE_HOME, 24, "fault = runaway time=0\n"},
    {TUMBLE_REASON_STALL, TUMBLE_STATE_MOVE, 15, "fault = frozen_position at=1.5 phase=move delay=0.3\n"},
    {TUMBLE_REASON_STALL, TUMBLE_STATE_HOME, 5, "fault = frozen_position time=0\nfault = homing_endless time=0\n"},
    {TUMBLE_REASON_SCALE, TUMBLE_STATE_HOME, 5, "fault = position_scale time=0 value=0.5\n"},
    {TUMBLE_REASON_BUS, TUMBLE_STATE_MOVE, 15, "fault = bus_off at=1.5 phase=move delay=0.3\n"},
};

/* Trouble that the firmware copes with by itself, or that somebody mends: the run passes. */
static const char *const MENDED[] = {
    "fault = lost_samples at=1.5 delay=0.1 count=3\n",
    "fault = wrong_crc at=1.5 count=3\n",
    "fault = repeated_samples at=1.5 count=3\n",
    "fault = reordered_samples at=1.5 count=1\n",
    "fault = noisy at=1.2 channels=z value=0.01 duration=0.2\n",
    "fault = frame_drop time=3 id=0x683 probability=0.01\n",
    "fault = frame_duplicate time=3 id=0x693 probability=0.1\n",
    "fault = frame_reorder time=3 id=0x683 mask=0x7EF count=2\n",
    "fault = frame_delay time=3 id=0x683 count=2 value=0.005\n",
    "fault = frame_drop time=3 id=0x182 count=3\n",
    "fault = frame_drop at=1.3 phase=move delay=0.5 id=0x202 count=1\n", /* the target of the second leg */
    "fault = frame_drop at=2.4 phase=move delay=0.5 id=0x202 count=3\n",
    "operator.wrong_mounting = 2\noperator.mounted_instead = 1\noperator.mend_s = 5\noperator.mends = 1\n",
    "operator.wrong_mounting = 1\noperator.mounted_instead = 2\noperator.mend_s = 5\noperator.mends = 1\n",
    "fault = drive_fault at=1.3 phase=move delay=0.3 value=8976\noperator.mend_s = 3\noperator.mends = 1\n",
    "fault = stall at=1.4 phase=move delay=0.3\noperator.mend_s = 3\noperator.mends = 1\n",
    "fault = drive_power_cycle at=1.4 phase=move delay=0.3 duration=0.3\noperator.mend_s = 3\noperator.mends = 1\n",
    "fault = stuck at=1.2 channels=z\noperator.mend_s = 3\noperator.mends = 1\n",
    "fault = drive_silent at=2.3 phase=move duration=2\noperator.mend_s = 5\noperator.mends = 1\n",
};

static void assert_case(const case_t *c)
{
    run_lines(c->lines, 1, NULL);
    TEST_ASSERT_EQUAL_INT_MESSAGE(WORLD_FAULT, world.end, c->lines);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(tumble_reason_name(c->reason), tumble_reason_name(world.progress.reason),
                                     c->lines);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(tumble_state_name(c->failed_in), tumble_state_name(world.progress.failed_in),
                                     c->lines);
    TEST_ASSERT_TRUE_MESSAGE(world.end == WORLD_FAULT || world.end == WORLD_TOO_LONG, c->lines);
    TEST_ASSERT_TRUE_MESSAGE(bench_world_is_at_rest(&world), c->lines);
    TEST_ASSERT_TRUE_MESSAGE((double)world.clock.now_us * 1e-6 <= c->within_s, c->lines);
    for (uint32_t i = 0; i < world.config->scenario.fault_count; i++) {
        TEST_ASSERT_TRUE_MESSAGE(world.script.states[i].times > 0U, c->lines);
    }
}

static void test_every_fault_ends_in_its_reason(void)
{
    for (size_t i = 0; i < COUNT_OF(FAULTS); i++) {
        assert_case(&FAULTS[i]);
    }
}

/* The reasons that no fault of the bench leads to are known by name. */
static void test_no_reason_is_forgotten(void)
{
    static const tumble_reason_t OTHERS[] = {
        TUMBLE_REASON_NONE,               /* a run without faults */
        TUMBLE_REASON_COMMAND,            /* test_an_abort_stops_the_table */
        TUMBLE_REASON_GRAVITY_CHECK,      /* test_a_failed_gravity_check_is_a_result */
        TUMBLE_REASON_SINGULAR,           /* test_a_singular_block_is_refused */
        TUMBLE_REASON_INHIBITED,          /* test_keeper_inhibit.c: the bench has no keeper */
        TUMBLE_REASON_STOP_NOT_CONFIRMED, /* test_sim_stop.c, and the two that follow */
        TUMBLE_REASON_FOREIGN_COMMAND,
        TUMBLE_REASON_SUPERVISION,
    };
    for (int reason = 0; reason < TUMBLE_REASON_COUNT; reason++) {
        bool known = false;
        for (size_t i = 0; i < COUNT_OF(FAULTS); i++) {
            known = known || FAULTS[i].reason == (tumble_reason_t)reason;
        }
        for (size_t i = 0; i < COUNT_OF(OTHERS); i++) {
            known = known || OTHERS[i] == (tumble_reason_t)reason;
        }
        TEST_ASSERT_TRUE_MESSAGE(known, tumble_reason_name((tumble_reason_t)reason));
    }
}

static void test_what_is_mended_passes(void)
{
    for (size_t i = 0; i < COUNT_OF(MENDED); i++) {
        run_lines(MENDED[i], 1, NULL);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("TUMBLE_REASON_NONE", tumble_reason_name(world.progress.reason), MENDED[i]);
        TEST_ASSERT_TRUE_MESSAGE(has_passed(), MENDED[i]);
    }
}

/* Homed wrongly, a run may pass, and the table be a turn or two away: so it is the cable that is looked at. */
static void test_the_table_keeps_to_its_cable(void)
{
    static const char *const LINES[] = {
        "drive.wrap_counts = 360000\n", /* homing ends a count below zero, at 359997 */
        "operator.mends=3\noperator.mend_s=2\nfault = bus_off at=1.9 phase=average duration=0.4\n"
        "fault = drive_power_cycle at=1.9 phase=average duration=0.1\n", /* its boot-up message finds no bus */
    };
    static const bench_watcher_t NOBODY = {0};
    for (size_t i = 0; i < COUNT_OF(LINES); i++) {
        double least_deg = 0.0;
        double most_deg = 0.0;
        TEST_ASSERT_NULL(read_lines(LINES[i]));
        ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, 1, &NOBODY));
        while (bench_world_advance(&world)) {
            const double deg = sim_axis_actual_deg(&world.drive.axis, world.clock.now_us);
            least_deg = (deg < least_deg) ? deg : least_deg;
            most_deg = (deg > most_deg) ? deg : most_deg;
        }
        TEST_ASSERT_TRUE_MESSAGE(has_passed(), LINES[i]);
        TEST_ASSERT_TRUE_MESSAGE(least_deg >= config.procedure.cable_min_deg, LINES[i]);
        TEST_ASSERT_TRUE_MESSAGE(most_deg <= config.procedure.cable_max_deg, LINES[i]);
        TEST_ASSERT_TRUE_MESSAGE(most_deg > 359.0, LINES[i]);
    }
}

static void test_an_abort_stops_the_table(void)
{
    static const bench_watcher_t NOBODY = {0};
    TEST_ASSERT_NULL(read_lines(""));
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, 1, &NOBODY));
    run_to_a_move();
    const uint64_t told_us = world.clock.now_us;
    bench_world_end(&world, WORLD_INTERRUPTED);
    bench_world_run(&world);
    TEST_ASSERT_EQUAL_INT(WORLD_INTERRUPTED, world.end);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_COMMAND, world.progress.reason);
    TEST_ASSERT_TRUE(bench_world_is_at_rest(&world));
    TEST_ASSERT_TRUE(world.clock.now_us - told_us < 1000000U);
}

/* The computer starts anew while the table turns: the axis brakes, and is not let go of before it stands. */
static void test_a_reset_by_nmt_does_not_let_the_table_coast(void)
{
    static const bench_watcher_t NOBODY = {0};
    static const uint8_t COMMANDS[] = {TUMBLE_NMT_RESET_NODE, TUMBLE_NMT_RESET_COMMUNICATION};
    for (size_t i = 0; i < COUNT_OF(COMMANDS); i++) {
        const tumble_can_frame_t reset = {.id = TUMBLE_NMT_ID, .length = 2, .data = {COMMANDS[i], 1}};
        TEST_ASSERT_NULL(read_lines(""));
        ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, 1, &NOBODY));
        double speed_deg_s = 0.0;
        while (world.progress.index != 3U || speed_deg_s < 20.0) {
            TEST_ASSERT_TRUE(bench_world_advance(&world));
            (void)sim_axis_commanded_deg(&world.drive.axis, world.clock.now_us, &speed_deg_s);
        }
        const uint64_t told_us = world.clock.now_us;
        ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&world.bus, BENCH_BUS_GUEST, &reset));
        while (world.clock.now_us - told_us < 500000U && bench_world_advance(&world)) {
        }
        TEST_ASSERT_TRUE(sim_axis_end_us(&world.drive.axis) <= told_us + 500000U);
        TEST_ASSERT_TRUE(sim_axis_end_us(&world.drive.axis) > told_us);
    }
}

static bench_question_t asked;

static bool ask(void *context, const bench_question_t *question)
{
    (void)context;
    asked = *question;
    return true;
}

/* Run until somebody is asked. False: it has ended. */
static bool run_to_question(void)
{
    asked.kind = BENCH_QUESTION_NONE;
    while (asked.kind == BENCH_QUESTION_NONE) {
        if (!bench_world_advance(&world)) {
            return false;
        }
    }
    return true;
}

/* A mounting, a fault that is mended, an answer that the firmware refuses, and the other mounting. */
static void test_questions_are_answered_from_outside(void)
{
    static const bench_watcher_t ASKER = {.on_question = ask};
    TEST_ASSERT_NULL(read_lines("fault = drive_fault at=1.3 phase=move delay=0.3 value=8976\n"));
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, 1, &ASKER));
    TEST_ASSERT_TRUE(run_to_question());
    TEST_ASSERT_EQUAL_INT(BENCH_QUESTION_MOUNTING, asked.kind);
    TEST_ASSERT_EQUAL_UINT8(1, asked.mounting);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, bench_operator_answer(&world, WORLD_ANSWER_REPEAT_POSITION, 40));
    ASSERT_STATUS(TUMBLE_OK, bench_operator_answer(&world, WORLD_ANSWER_DONE, 0));
    TEST_ASSERT_TRUE(run_to_question());
    TEST_ASSERT_EQUAL_INT(BENCH_QUESTION_FAULT, asked.kind);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_DRIVE_FAULT, asked.reason);
    ASSERT_STATUS(TUMBLE_OK, bench_operator_answer(&world, WORLD_ANSWER_DONE, 0));
    TEST_ASSERT_TRUE(run_to_question());
    TEST_ASSERT_EQUAL_INT(BENCH_QUESTION_MOUNTING, asked.kind);
    TEST_ASSERT_EQUAL_UINT8(2, asked.mounting);
    ASSERT_STATUS(TUMBLE_OK, bench_operator_answer(&world, WORLD_ANSWER_DONE, 0));
    TEST_ASSERT_FALSE(run_to_question());
    TEST_ASSERT_EQUAL_INT(WORLD_DONE, world.end);
}

/* Whatever the operator repeats: as long as the fault is there, he is asked about it anew. */
static void test_a_fault_that_comes_again_is_asked_about_again(void)
{
    static const bench_watcher_t ASKER = {.on_question = ask};
    static const struct {
        world_answer_t answer;
        uint8_t argument;
    } REPEATS[] = {
        {WORLD_ANSWER_REPEAT_POSITION, 1}, {WORLD_ANSWER_REPEAT_POSITION, 1}, {WORLD_ANSWER_REPEAT_MOUNTING, 1}};
    TEST_ASSERT_NULL(read_lines("fault = bus_off at=1.5\n")); /* it fails again at once */
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, 1, &ASKER));
    TEST_ASSERT_TRUE(run_to_question());
    ASSERT_STATUS(TUMBLE_OK, bench_operator_answer(&world, WORLD_ANSWER_DONE, 0));
    for (size_t i = 0; i < COUNT_OF(REPEATS); i++) {
        do {
            TEST_ASSERT_TRUE(run_to_question());
        } while (asked.kind == BENCH_QUESTION_MOUNTING &&
                 bench_operator_answer(&world, WORLD_ANSWER_DONE, 0) == TUMBLE_OK);
        TEST_ASSERT_EQUAL_INT(BENCH_QUESTION_FAULT, asked.kind);
        TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_BUS, asked.reason);
        ASSERT_STATUS(TUMBLE_OK, bench_operator_answer(&world, REPEATS[i].answer, REPEATS[i].argument));
    }
}

static void test_a_fault_may_be_left_as_it_is(void)
{
    static const bench_watcher_t ASKER = {.on_question = ask};
    TEST_ASSERT_NULL(read_lines("fault = homing_fails at=1.1 phase=mount\n"));
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, 1, &ASKER));
    TEST_ASSERT_TRUE(run_to_question());
    ASSERT_STATUS(TUMBLE_OK, bench_operator_answer(&world, WORLD_ANSWER_DONE, 0));
    TEST_ASSERT_TRUE(run_to_question());
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_HOMING, asked.reason);
    ASSERT_STATUS(TUMBLE_OK, bench_operator_answer(&world, WORLD_ANSWER_LEAVE, 0));
    TEST_ASSERT_FALSE(run_to_question());
    TEST_ASSERT_EQUAL_INT(WORLD_FAULT, world.end);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_HOMING, world.progress.reason);
}

static void test_a_failed_gravity_check_is_a_result(void)
{
    run_lines("procedure.gravity_limit_g = 1e-7\n", 1, NULL);
    TEST_ASSERT_EQUAL_INT(WORLD_DONE, world.end);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_GRAVITY_CHECK, world.progress.reason);
    TEST_ASSERT_FALSE(has_passed());
    (void)found();
}

/* Channel x feels along z what channel z feels. Within 10 degrees about 0 nothing points so far the wrong way that the
 * checks on the way would see it. */
static void test_a_singular_block_is_refused(void)
{
    run_lines(
        "block.k = 0 0 -0.6  0 -2 0  0 0 -2\nblock.u0 = 0 0 0\nblock.noise_v = 0 0 0\n"
        "procedure.estimator = least_squares\n"
        "mounting = 1  0 0 1  1 0 0  0 1 0  0 0 1\nmounting = 2  0 0 1  -1 0 0  0 0 1  0 1 0\n"
        "position = 1 1 fit  -10 -0.17364817766693035 0.98480775301220806\nposition = 1 2 fit  0 0 1\n"
        "position = 1 3 fit  10 0.17364817766693035 0.98480775301220806\n"
        "position = 2 1 fit  -10 -0.17364817766693035 0.98480775301220806\nposition = 2 2 fit  0 0 1\n"
        "position = 2 3 fit  10 0.17364817766693035 0.98480775301220806\n",
        1, NULL);
    TEST_ASSERT_EQUAL_INT(WORLD_FAULT, world.end);
    TEST_ASSERT_EQUAL_INT(TUMBLE_REASON_SINGULAR, world.progress.reason);
    TEST_ASSERT_FALSE(has_passed());
}
