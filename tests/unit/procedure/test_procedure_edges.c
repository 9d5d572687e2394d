/* The procedure at its limits: exact counts, exact bounds, what is reset when. */
#include "procedure_bench.h"

static void test_init_needs_no_clean_memory(void)
{
    memset(&bench.procedure, 0xA5, sizeof bench.procedure);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
    bench_start_to_done(&bench);
    TEST_ASSERT_EQUAL_UINT32(18, counters()->positions);
}

static void test_what_sample_tells(void)
{
    tumble_taken_t taken = {99, 99};
    tumble_block_sample_t sample = bench_make_sample(&bench);
    TEST_ASSERT_FALSE(tumble_procedure_sample(&bench.procedure, &sample, &taken));
    TEST_ASSERT_EQUAL_UINT8(99, taken.index);
    TEST_ASSERT_EQUAL_UINT32(99, taken.ordinal);
    bench_run_to_position(&bench, 0, TUMBLE_STATE_AVERAGE);
    sample = bench_make_sample(&bench);
    TEST_ASSERT_TRUE(tumble_procedure_sample(&bench.procedure, &sample, NULL));
    sample.raw.counter++;
    TEST_ASSERT_TRUE(tumble_procedure_sample(&bench.procedure, &sample, &taken));
    TEST_ASSERT_EQUAL_UINT8(0, taken.index);
    TEST_ASSERT_EQUAL_UINT32(2, taken.ordinal);
    TEST_ASSERT_FALSE(tumble_procedure_sample(&bench.procedure, &sample, &taken)); /* repeated */
}

/* The last sample of the last position is taken although the state has moved on by then; the next finds a machine
 * that computes. */
static void test_no_sample_is_taken_while_computing(void)
{
    bench_run_to_position(&bench, 17, TUMBLE_STATE_AVERAGE);
    tumble_taken_t taken = {0, 0};
    tumble_block_sample_t sample = bench_make_sample(&bench);
    while (bench_state_of(&bench) == TUMBLE_STATE_AVERAGE) {
        TEST_ASSERT_TRUE(tumble_procedure_sample(&bench.procedure, &sample, &taken));
        sample.raw.counter++;
    }
    TEST_ASSERT_EQUAL_UINT32(20, taken.ordinal);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SOLVE, bench_state_of(&bench));
    TEST_ASSERT_FALSE(tumble_procedure_sample(&bench.procedure, &sample, &taken));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SOLVE, bench_state_of(&bench)); /* a step does it */
    for (int part = 0; part < 3; part++) {
        TEST_ASSERT_EQUAL(TUMBLE_STATE_SOLVE, bench_state_of(&bench));
        tumble_procedure_step(&bench.procedure, bench.now_us);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_VERIFY, bench_state_of(&bench));
}

static void test_counts_of_what_the_source_reports(void)
{
    tumble_procedure_sample_faults(&bench.procedure, 2, 5);
    tumble_procedure_sample_faults(&bench.procedure, 1, 7);
    TEST_ASSERT_EQUAL_UINT32(3, counters()->corrupted);
    TEST_ASSERT_EQUAL_UINT32(12, counters()->lost);
    bench_ticks(&bench, 2);
    TEST_ASSERT_EQUAL_UINT32(2, counters()->samples);
}

static void corrupt_while_averaging(uint16_t frames)
{
    bench_start(&bench);
    bench.averaging.max_lost = 100;
    bench_run_to_position(&bench, 2, TUMBLE_STATE_AVERAGE);
    tumble_procedure_sample_faults(&bench.procedure, frames, 0);
}

static void test_corrupted_frames_are_allowed_up_to_the_limit(void)
{
    corrupt_while_averaging(3);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_AVERAGE, bench_state_of(&bench));
    bench_run(&bench);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->refused);
    corrupt_while_averaging(4);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
    ASSERT_STATUS(TUMBLE_E_CRC, bench_progress(&bench).status);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->refused);
    corrupt_while_averaging(0);
    bench.config.max_corrupted = UINT16_MAX - 1U;
    tumble_procedure_sample_faults(&bench.procedure, 40000, 0);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_AVERAGE, bench_state_of(&bench));
    tumble_procedure_sample_faults(&bench.procedure, 40000, 0); /* stops at the end of its range */
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
}

static void test_corrupted_frames_before_the_table_stands_do_not_count(void)
{
    bench_run_to_position(&bench, 2, TUMBLE_STATE_MOVE);
    tumble_procedure_sample_faults(&bench.procedure, 100, 0);
    bench_run_to_done(&bench);
    TEST_ASSERT_EQUAL_UINT32(0, counters()->refused);
}

static void test_lost_samples_end_a_position_at_once(void)
{
    bench_run_to_position(&bench, 2, TUMBLE_STATE_AVERAGE);
    bench_tick(&bench);
    bench.block.counter = (uint16_t)(bench.block.counter + 2U);
    bench_tick(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_AVERAGE, bench_state_of(&bench)); /* two are allowed */
    bench.block.counter++;
    bench_tick(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
    ASSERT_STATUS(TUMBLE_E_LOST, bench_progress(&bench).status);
}

static void test_saturation_ends_a_position_at_once(void)
{
    bench_run_to_position(&bench, 2, TUMBLE_STATE_AVERAGE);
    bench_tick(&bench);
    bench.block.u0_v[0] = 12.0;
    bench_tick(&bench);
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SATURATED);
}

static void test_a_leap_ends_a_position_at_once_and_is_tried_again(void)
{
    bench_run_to_position(&bench, 2, TUMBLE_STATE_AVERAGE);
    bench_tick(&bench);
    bench.block.u0_v[0] += 3.0;
    bench_tick(&bench);
    bench.block.u0_v[0] -= 3.0;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
    ASSERT_STATUS(TUMBLE_E_DEVIATION, bench_progress(&bench).status);
    bench_run_to_done(&bench);
}

/* A spread of exactly the band, and exactly so many samples. */
static void test_warm_up_to_the_sample(void)
{
    bench.operator_is_away = true;
    bench.config.warm_up_samples = 4;
    static const int8_t spread_half_c[] = {0, 2, 1, 0};
    bench_run_to(&bench, TUMBLE_STATE_WARM_UP);
    for (size_t i = 0; i < COUNT_OF(spread_half_c); i++) {
        TEST_ASSERT_EQUAL(TUMBLE_STATE_WARM_UP, bench_state_of(&bench));
        bench.block.temperature_half_c = (int8_t)(-100 + spread_half_c[i]);
        bench_tick(&bench);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_state_of(&bench));
}

/* What falls out of the band begins a new run of four by itself; a complaint of the block begins with nothing. */
static void test_warm_up_starts_again_to_the_sample(void)
{
    bench.operator_is_away = true;
    bench.config.warm_up_samples = 4;
    static const int8_t falling_half_c[] = {9, 7, 6, 6, 5, 4};
    static const uint8_t status[] = {0, 0, 0, 0, 0, 0};
    bench_run_to(&bench, TUMBLE_STATE_WARM_UP);
    for (size_t i = 0; i < COUNT_OF(falling_half_c); i++) {
        TEST_ASSERT_EQUAL(TUMBLE_STATE_WARM_UP, bench_state_of(&bench));
        bench.block.temperature_half_c = falling_half_c[i];
        bench.block.status = status[i];
        bench_tick(&bench);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_state_of(&bench));
}

static void test_warm_up_counts_nothing_while_too_cold(void)
{
    bench.operator_is_away = true;
    bench.config.warm_up_samples = 3;
    bench_run_to(&bench, TUMBLE_STATE_WARM_UP);
    bench_ticks(&bench, 2);
    bench.block.status = TUMBLE_SAMPLE_TEMPERATURE;
    bench_tick(&bench);
    bench.block.status = 0;
    bench_ticks(&bench, 2);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WARM_UP, bench_state_of(&bench));
    bench_tick(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_state_of(&bench));
}

/* Both ends of the tolerance still hold; the least beyond is a slip. */
static void test_the_tolerance_is_the_last_angle_that_holds(void)
{
    static const double errors_deg[] = {0.0625, -0.0625};
    for (size_t i = 0; i < COUNT_OF(errors_deg); i++) {
        bench_start(&bench);
        bench.config.position_tolerance_deg = 0.0625;
        bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
        bench.stand.error_deg = errors_deg[i];
        bench_run_to_position(&bench, 3, TUMBLE_STATE_AVERAGE);
        bench_tick(&bench);
        TEST_ASSERT_EQUAL(TUMBLE_STATE_AVERAGE, bench_state_of(&bench));
        bench.stand.error_deg = errors_deg[i] * 1.001;
        bench_tick(&bench);
        ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SLIP);
    }
}

/* Whether it is the table or the count that slipped nobody knows: a run that goes on homes first. */
static void test_after_a_slip_of_the_angle_a_run_homes_again(void)
{
    bench_start(&bench);
    bench_run_to_position(&bench, 3, TUMBLE_STATE_SETTLE);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->homings);
    bench.stand.error_deg = 360.0;
    bench_tick(&bench);
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SLIP);
    bench.stand.error_deg = 0.0;
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    bench_run_to_done(&bench);
    TEST_ASSERT_EQUAL_UINT32(2, counters()->homings);
}

static void test_states_that_wait_for_nothing_wait_for_ever(void)
{
    bench_init(&bench);
    tumble_procedure_step(&bench.procedure, UINT64_C(1) << 62);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, bench_state_of(&bench));
    bench_start(&bench);
    bench_run_to(&bench, TUMBLE_STATE_MOVE);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_DRIVE, 1);
    bench_run(&bench);
    const uint32_t timeouts = counters()->timeouts;
    for (unsigned i = 0; i < 3U; i++) {
        tumble_procedure_step(&bench.procedure, (UINT64_C(1) << 62) + i);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_state_of(&bench));
    TEST_ASSERT_EQUAL_UINT32(timeouts, counters()->timeouts);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->faults);
}

/* A clock that goes back is a fault of the port; it must not end a wait. */
static void test_a_clock_that_goes_back_ends_nothing(void)
{
    bench_run_to(&bench, TUMBLE_STATE_SETTLE);
    tumble_procedure_step(&bench.procedure, bench.now_us);
    tumble_procedure_step(&bench.procedure, 0);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
}

static void test_the_mounting_on_the_table_can_be_repeated(void)
{
    bench_run_to_position(&bench, 12, TUMBLE_STATE_AVERAGE);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_repeat_mounting(&bench.procedure, 2));
    TEST_ASSERT_EQUAL_UINT8(9, bench_progress(&bench).finished);
    bench_run_to_done(&bench);
    TEST_ASSERT_EQUAL_UINT(3, bench.confirmations); /* it is put on anew */
    TEST_ASSERT_EQUAL_UINT32(21, counters()->positions);
}

static void test_a_homing_that_failed_is_not_taken_for_done(void)
{
    bench.stand.loses_home = true;
    bench_run_to_position(&bench, 4, TUMBLE_STATE_MOVE);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_POWER, 0);
    bench_run(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    bench_run_to(&bench, TUMBLE_STATE_HOME);
    bench.stand.never_arrives = true;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_HOMING);
    bench.stand.never_arrives = false;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure)); /* stopped, and still not homed */
    bench_run_to_done(&bench);
    TEST_ASSERT_EQUAL_UINT(3, bench.stand.homes);
}

static void test_the_drives_code_belongs_to_its_fault(void)
{
    bench_run_to_position(&bench, 4, TUMBLE_STATE_MOVE);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_DRIVE, 0x7300);
    bench_run(&bench);
    TEST_ASSERT_EQUAL_HEX16(0x7300, bench_progress(&bench).drive_code);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    TEST_ASSERT_EQUAL_HEX16(0, bench_progress(&bench).drive_code);
    bench_run_to_position(&bench, 4, TUMBLE_STATE_AVERAGE);
    bench.stand.error_deg = 1.0;
    bench_run(&bench); /* no fault of the drive: its old code does not count */
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SLIP);
    TEST_ASSERT_EQUAL_HEX16(0, bench_progress(&bench).drive_code);
}

static void test_the_stands_refusal_is_readable(void)
{
    bench_run_to_position(&bench, 2, TUMBLE_STATE_AVERAGE);
    bench.stand.refuses_moves = true;
    bench_run(&bench);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, bench_progress(&bench).status);
}

static void test_a_new_start_forgets_attempts_and_closures(void)
{
    bench_run_to_position(&bench, 11, TUMBLE_STATE_AVERAGE);
    TEST_ASSERT_TRUE(tumble_procedure_closure_g(&bench.procedure, 0) > 0.0);
    bench.block.lose_every = 3;
    bench_run_to_position(&bench, 11, TUMBLE_STATE_SETTLE);
    TEST_ASSERT_EQUAL_UINT8(1, bench_progress(&bench).attempt);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_abort(&bench.procedure));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    TEST_ASSERT_EQUAL_UINT8(0, bench_progress(&bench).attempt);
    TEST_ASSERT_EQUAL_UINT8(0, bench_progress(&bench).index);
    TEST_ASSERT_EQUAL_UINT8(0, bench_progress(&bench).finished);
    ASSERT_SAME_DOUBLE(0.0, tumble_procedure_closure_g(&bench.procedure, 0));
}

static void test_a_closure_is_gone_while_its_mounting_is_measured_again(void)
{
    bench_run_to_position(&bench, 11, TUMBLE_STATE_AVERAGE);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_repeat_mounting(&bench.procedure, 1));
    bench_run_to_position(&bench, 0, TUMBLE_STATE_AVERAGE);
    ASSERT_SAME_DOUBLE(0.0, tumble_procedure_closure_g(&bench.procedure, 0));
    TEST_ASSERT_TRUE(tumble_procedure_closure_g(&bench.procedure, 1) > 0.0);
}

static const around_t around_each = {begin_run, NULL};
