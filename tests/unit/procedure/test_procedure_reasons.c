/* Every reason code, reached by the fault that it names; every timeout of every state that waits; the table stopped. */
#include "procedure/procedure_internal.h"
#include "procedure_faults.h"

/* What the timeouts of a run can add up to after it was broken. */
#define LONGEST_US 12000000

static void run_case(const fault_case_t *c, const char *which)
{
    bench_init(&bench);
    if (c->before != NULL) {
        c->before(&bench);
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    if (c->during != NULL) {
        bench_run_to_position(&bench, c->index, c->state);
        c->during(&bench);
    }
    const uint64_t broken_us = bench.now_us;
    bench_run(&bench);
    const tumble_progress_t progress = bench_progress(&bench);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(tumble_reason_name(c->reason), tumble_reason_name(progress.reason), which);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(tumble_state_name(TUMBLE_STATE_FAULT), tumble_state_name(progress.state), which);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(tumble_state_name(c->failed_in), tumble_state_name(progress.failed_in), which);
    TEST_ASSERT_EQUAL_UINT_MESSAGE(1, bench.stand.stops, which);
    TEST_ASSERT_NOT_EQUAL_MESSAGE(TUMBLE_STAND_MOVING, bench.stand.state, which);
    TEST_ASSERT_NOT_EQUAL_MESSAGE(TUMBLE_STAND_HOMING, bench.stand.state, which);
    TEST_ASSERT_LESS_THAN_UINT64_MESSAGE(LONGEST_US, bench.now_us - broken_us, which);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(c->timeout ? 1 : 0, counters()->timeouts > 0U, which);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(1, counters()->faults, which);
}

static void test_every_fault_has_its_reason(void)
{
    for (size_t i = 0; i < fault_case_count; i++) {
        char which[80];
        (void)snprintf(which, sizeof which, "case %u: %s", (unsigned)i, tumble_reason_name(fault_cases[i].reason));
        run_case(&fault_cases[i], which);
    }
}

/* A status that no gate gives today is not tried again. */
static void test_a_position_refused_by_any_other_status_is_stuck(void)
{
    bench_start(&bench);
    TEST_ASSERT_EQUAL(OUTCOME_FAULT, tumble_refuse_position(&bench.procedure, TUMBLE_E_RANK));
    TEST_ASSERT_EQUAL(TUMBLE_REASON_STUCK, bench_reason_of(&bench));
    TEST_ASSERT_EQUAL_UINT32(0, counters()->retries);
}

/* NONE, COMMAND, GRAVITY_CHECK and INHIBITED are no faults; every other reason has a case above. */
static void test_no_reason_is_left_out(void)
{
    for (int reason = 0; reason < (int)TUMBLE_REASON_COUNT; reason++) {
        bool found = (reason == (int)TUMBLE_REASON_NONE) || (reason == (int)TUMBLE_REASON_COMMAND) ||
                     (reason == (int)TUMBLE_REASON_GRAVITY_CHECK) || (reason == (int)TUMBLE_REASON_INHIBITED);
        for (size_t i = 0; i < fault_case_count; i++) {
            found = found || ((int)fault_cases[i].reason == reason);
        }
        TEST_ASSERT_TRUE_MESSAGE(found, tumble_reason_name((tumble_reason_t)reason));
    }
}

static void test_every_state_that_waits_has_a_case_for_its_timeout(void)
{
    static const tumble_state_t waiting[] = {TUMBLE_STATE_PREFLIGHT, TUMBLE_STATE_WARM_UP, TUMBLE_STATE_WAIT_MOUNTING,
                                             TUMBLE_STATE_HOME,      TUMBLE_STATE_MOVE,    TUMBLE_STATE_SETTLE,
                                             TUMBLE_STATE_AVERAGE};
    for (size_t s = 0; s < COUNT_OF(waiting); s++) {
        bool found = false;
        for (size_t i = 0; i < fault_case_count; i++) {
            found = found || (fault_cases[i].timeout && (fault_cases[i].failed_in == waiting[s]));
        }
        TEST_ASSERT_TRUE_MESSAGE(found, tumble_state_name(waiting[s]));
    }
}

/* A state's time is over neither early nor late, and when it said: at one microsecond less it still waits. */
static void expect_timeout(tumble_state_t state, uint32_t ms, tumble_reason_t reason)
{
    TEST_ASSERT_EQUAL_STRING(tumble_state_name(state), tumble_state_name(bench_state_of(&bench)));
    TEST_ASSERT_EQUAL_UINT64(0, tumble_procedure_next_us(&bench.procedure)); /* its time has not begun */
    tumble_procedure_step(&bench.procedure, bench.now_us);
    TEST_ASSERT_EQUAL_UINT64(bench.now_us + ((uint64_t)ms * 1000U), tumble_procedure_next_us(&bench.procedure));
    tumble_procedure_step(&bench.procedure, bench.now_us + ((uint64_t)ms * 1000U) - 1U);
    TEST_ASSERT_EQUAL_STRING(tumble_state_name(state), tumble_state_name(bench_state_of(&bench)));
    tumble_procedure_step(&bench.procedure, bench.now_us + ((uint64_t)ms * 1000U));
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, reason);
    tumble_procedure_step(&bench.procedure, bench.now_us + ((uint64_t)ms * 1000U));
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, tumble_procedure_next_us(&bench.procedure)); /* waits for nothing */
}

static void start_and_run_to(tumble_state_t state)
{
    bench_start(&bench);
    bench.config.sample_timeout_ms = 100000;
    bench.operator_is_away = (state == TUMBLE_STATE_WAIT_MOUNTING);
    bench_run_to(&bench, state);
    bench.procedure.restart_timer = true;
}

static void test_timeouts_are_exact(void)
{
    start_and_run_to(TUMBLE_STATE_PREFLIGHT);
    expect_timeout(TUMBLE_STATE_PREFLIGHT, 1000, TUMBLE_REASON_NO_SAMPLES);
    start_and_run_to(TUMBLE_STATE_WARM_UP);
    expect_timeout(TUMBLE_STATE_WARM_UP, 2000, TUMBLE_REASON_WARM_UP);
    start_and_run_to(TUMBLE_STATE_WAIT_MOUNTING);
    expect_timeout(TUMBLE_STATE_WAIT_MOUNTING, 3000, TUMBLE_REASON_MOUNTING_NOT_CONFIRMED);
    start_and_run_to(TUMBLE_STATE_HOME);
    expect_timeout(TUMBLE_STATE_HOME, 1000, TUMBLE_REASON_HOMING);
    start_and_run_to(TUMBLE_STATE_MOVE);
    expect_timeout(TUMBLE_STATE_MOVE, 1000, TUMBLE_REASON_TARGET_NOT_REACHED);
    start_and_run_to(TUMBLE_STATE_SETTLE);
    expect_timeout(TUMBLE_STATE_SETTLE, 800, TUMBLE_REASON_NO_SAMPLES);
    start_and_run_to(TUMBLE_STATE_AVERAGE);
    bench.config.retries = 0;
    expect_timeout(TUMBLE_STATE_AVERAGE, 1000, TUMBLE_REASON_SAMPLES_LOST);
    start_and_run_to(TUMBLE_STATE_AVERAGE);
    bench.config.sample_timeout_ms = 300;
    expect_timeout(TUMBLE_STATE_AVERAGE, 300, TUMBLE_REASON_NO_SAMPLES);
}

static void test_a_late_mean_is_tried_again_first(void)
{
    start_and_run_to(TUMBLE_STATE_AVERAGE);
    tumble_procedure_step(&bench.procedure, bench.now_us);
    tumble_procedure_step(&bench.procedure, bench.now_us + 1000000U);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_SETTLE, bench_state_of(&bench));
    TEST_ASSERT_EQUAL_UINT32(1, counters()->retries);
    TEST_ASSERT_EQUAL_UINT32(1, counters()->timeouts);
    bench.now_us += 1000000U;
    bench_run_to_done(&bench);
}

/* The bias of 0.3 g on every channel that the first position must bear with, and a scale that is a tenth off. */
static void test_bias_and_scale_are_no_wrong_mounting(void)
{
    for (unsigned signs = 0; signs < 16U; signs++) {
        bench_start(&bench);
        for (unsigned i = 0; i < 3U; i++) {
            bench.block.u0_v[i] = ((signs & (1U << i)) != 0U) ? 0.6 : -0.6;
            for (unsigned j = 0; j < 3U; j++) {
                bench.block.k_v_per_g[i][j] *= ((signs & 8U) != 0U) ? 1.1 : 0.9;
            }
        }
        bench_run_to_done(&bench);
    }
}

static void test_a_failed_gravity_check_is_a_result(void)
{
    bench_init(&bench);
    bench.config.gravity_limit_g = 1e-9;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run(&bench);
    ASSERT_ENDED(&bench, TUMBLE_STATE_DONE, TUMBLE_REASON_GRAVITY_CHECK);
    const tumble_result_t result = bench_result(&bench);
    TEST_ASSERT_FALSE(result.pass);
    TEST_ASSERT_TRUE(result.check->max_abs_fit_g > 1e-9);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, -2.0, result.coefficients->k_v_per_g[0][0]);
}

/* The drive's emergency message may come after its statusword. */
static void test_the_drives_code_is_taken_even_when_late(void)
{
    bench_start(&bench);
    bench_run_to_position(&bench, 2, TUMBLE_STATE_MOVE);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_DRIVE, 0);
    bench_run(&bench);
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_STALL, 0x8611);
    bench_tick(&bench);
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_STALL);
    const tumble_progress_t progress = bench_progress(&bench);
    TEST_ASSERT_EQUAL_HEX16(0x8611, progress.drive_code);
}

static void test_details_of_a_refusal_are_readable(void)
{
    bench_init(&bench);
    schedule_without_a_position(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    tumble_progress_t progress = bench_progress(&bench);
    ASSERT_STATUS(TUMBLE_E_NOT_HARMONIC, progress.status);
    TEST_ASSERT_EQUAL_HEX64(0, tumble_procedure_refusal(&bench.procedure).missing);
    bench_init(&bench);
    schedule_of_one_mounting(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    progress = bench_progress(&bench);
    ASSERT_STATUS(TUMBLE_E_RANK, progress.status);
    TEST_ASSERT_EQUAL_HEX8(0x2, tumble_procedure_refusal(&bench.procedure).unidentified); /* K_iy */
}
