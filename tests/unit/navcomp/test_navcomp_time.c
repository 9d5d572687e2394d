/* The navigation computer and the clock: its deadlines are all that a caller needs to be in time. */
#include "navcomp_bench.h"

static tumble_status_t init(void)
{
    return tumble_navcomp_init(&bench.navcomp, &bench.config);
}

/* 127 samples last as long as the timeout and a heartbeat: longer silence could hide a wrap of the block's counter. */
static void test_the_sample_timeout_stays_below_the_wrap_of_the_counter(void)
{
    bench.procedure.sample_timeout_ms = 1170;
    bench.config.heartbeat_ms = 100;
    bench.config.block_period_us = 10000;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    bench.procedure.sample_timeout_ms = 1171;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, init());
    bench.config.heartbeat_ms = 99;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    bench.procedure.sample_timeout_ms = UINT32_MAX;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, init());
    bench.config.block_period_us = UINT32_MAX;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, init());
    bench.procedure.sample_timeout_ms = 500000000;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
    bench.config.block_period_us = 1;
    static const tumble_sample_source_t source = {0}; /* whose counter has 16 bits */
    bench.config.source = &source;
    TEST_ASSERT_EQUAL(TUMBLE_OK, init());
}

/* The moment of the step that leads into that state. */
static uint64_t entered_us(tumble_state_t state)
{
    uint64_t us = bench.fake.now_us;
    while (bench_progress(&bench).run.state != state) {
        us = bench.fake.now_us;
        TEST_ASSERT_TRUE(us < 600000000U);
        bench_event(&bench);
    }
    return us;
}

/* The caller sleeps until the deadline, but for the block's samples, which are no occasion to look at the clock. */
static uint64_t lasts_us(tumble_state_t state, tumble_reason_t reason)
{
    const uint64_t begin_us = entered_us(state);
    const uint64_t end_us = entered_us(TUMBLE_STATE_FAULT);
    TEST_ASSERT_EQUAL_STRING(tumble_reason_name(reason), tumble_reason_name(bench_progress(&bench).run.reason));
    return end_us - begin_us;
}

static void test_a_caller_that_sleeps_until_the_deadline_sees_a_timeout_when_it_is_due(void)
{
    bench.never_confirm = true;
    bench.procedure.mounting_timeout_ms = 7777;
    bench_start(&bench);
    TEST_ASSERT_EQUAL_UINT64(7777000, lasts_us(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_MOUNTING_NOT_CONFIRMED));
}

static void test_a_state_that_is_never_left_is_as_sharp_with_the_drive_under_way(void)
{
    bench.procedure.home_timeout_ms = 33;
    bench_start(&bench);
    TEST_ASSERT_EQUAL_UINT64(33000, lasts_us(TUMBLE_STATE_HOME, TUMBLE_REASON_HOMING));
}

/* Nothing else wakes it: drive and block say nothing any more, and neither is missed yet. */
static void test_silence_of_the_block_ends_at_its_deadline(void)
{
    bench.procedure.sample_timeout_ms = 333;
    bench.config.heartbeat_timeout_ms = 60000;
    bench_start(&bench);
    const uint64_t silent_us = entered_us(TUMBLE_STATE_AVERAGE);
    bench.block.dead = true;
    bench.drive.dead = true;
    const uint64_t end_us = entered_us(TUMBLE_STATE_FAULT);
    TEST_ASSERT_EQUAL_STRING("TUMBLE_REASON_NO_SAMPLES", tumble_reason_name(bench_progress(&bench).run.reason));
    TEST_ASSERT_EQUAL_UINT64(333000, end_us - silent_us);
}

/* The mark is the same exactly as long as all of these are. */
static void test_the_mark_follows_state_reason_position_and_attempt(void)
{
    uint32_t mark = 0;
    tumble_progress_t last = {.state = TUMBLE_STATE_IDLE};
    bench_power_on(&bench);
    TEST_ASSERT_EQUAL_HEX32(0, tumble_procedure_mark(tumble_navcomp_procedure(&bench.navcomp)));
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_START, 0));
    unsigned changes = 0;
    while (last.state != TUMBLE_STATE_DONE) {
        const tumble_procedure_t *procedure = tumble_navcomp_procedure(&bench.navcomp);
        const tumble_progress_t now = bench_progress(&bench).run;
        const bool same = (now.state == last.state) && (now.reason == last.reason) && (now.index == last.index) &&
                          (now.attempt == last.attempt);
        TEST_ASSERT_EQUAL(same, tumble_procedure_mark(procedure) == mark);
        TEST_ASSERT_EQUAL(now.state, procedure->state);
        mark = tumble_procedure_mark(procedure);
        changes += same ? 0U : 1U;
        last = now;
        bench.block.status = ((changes == 20U) ? (uint8_t)TUMBLE_SAMPLE_SATURATED : 0U);
        if (now.state == TUMBLE_STATE_FAULT) {
            TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_RESUME, 0));
        }
        bench_event(&bench);
    }
    TEST_ASSERT_TRUE(changes > 54U);
}

static const around_t around_each = {bench_begin, NULL};
