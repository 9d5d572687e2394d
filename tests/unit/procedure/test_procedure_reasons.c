/* Every reason code, reached by the fault that it names; every timeout of every state that waits; the table stopped. */
#include "procedure/procedure_internal.h"
#include "procedure_bench.h"

/* Ways to break a run, and what must come of each. */

/* `before` acts before the start, `during` when the position at `index` is in `state`. */
typedef struct {
    tumble_reason_t reason;
    tumble_state_t failed_in;
    void (*before)(bench_t *bench);
    void (*during)(bench_t *bench);
    tumble_state_t state;
    uint8_t index;
    bool timeout;
} fault_case_t;

static tumble_position_t spoilt[18];
static tumble_schedule_t schedule;

#define ACT(name, act)                                                                                                 \
    static void name(bench_t *b)                                                                                       \
    {                                                                                                                  \
        act;                                                                                                           \
    }

static void use_copy_of_paper(bench_t *b)
{
    memcpy(spoilt, tumble_schedule_paper.positions, sizeof spoilt);
    schedule = tumble_schedule_paper;
    schedule.positions = spoilt;
    b->config.schedule = &schedule;
}

static void invalid_schedule(bench_t *b)
{
    use_copy_of_paper(b);
    spoilt[4].number = 4;
}

static void schedule_without_a_position(bench_t *b)
{
    use_copy_of_paper(b);
    schedule.position_count = 17;
}

/* One mounting alone never points gravity along y. */
static void schedule_of_one_mounting(bench_t *b)
{
    use_copy_of_paper(b);
    schedule.position_count = 9;
    b->config.estimate = TUMBLE_ESTIMATE_LEAST_SQUARES;
}

ACT(too_few_samples, b->config.samples = 9)
ACT(bad_gates, b->averaging.stillness_ratio = 0.0F)
ACT(short_cable, b->config.cable_max_deg = 300.0)
ACT(stand_offline, b->stand.state = TUMBLE_STAND_OFFLINE)

static void stand_in_its_own_world(bench_t *b)
{
    b->stand.never_arrives = true;
    b->stand.state = TUMBLE_STAND_MOVING;
}

static void stand_faulty(bench_t *b)
{
    b->stand.stays_faulty = true;
    bench_break_stand(b, TUMBLE_STAND_FAULT_DRIVE, 0x2310);
}

#define STAND_FAULT(name, fault, code) ACT(name, bench_break_stand(b, fault, code))

STAND_FAULT(heartbeat_of_stand, TUMBLE_STAND_FAULT_HEARTBEAT, 0)
STAND_FAULT(drive_fault, TUMBLE_STAND_FAULT_DRIVE, 0x3210)
STAND_FAULT(stand_fault_beyond_the_list, (tumble_stand_fault_t)99, 1)
STAND_FAULT(power_lost, TUMBLE_STAND_FAULT_POWER, 0)
STAND_FAULT(stall, TUMBLE_STAND_FAULT_STALL, 0x8611)
STAND_FAULT(homing_error, TUMBLE_STAND_FAULT_HOMING, 0)
STAND_FAULT(protocol_error, TUMBLE_STAND_FAULT_PROTOCOL, 0)
STAND_FAULT(stand_timeout, TUMBLE_STAND_FAULT_TIMEOUT, 0)
STAND_FAULT(stop_not_seen, TUMBLE_STAND_FAULT_STOP, 0)
STAND_FAULT(runs_away, TUMBLE_STAND_FAULT_RUNAWAY, 0)
STAND_FAULT(scale_is_wrong, TUMBLE_STAND_FAULT_SCALE, 0)
STAND_FAULT(position_lost, TUMBLE_STAND_FAULT_POSITION, 0)
STAND_FAULT(foreign_command, TUMBLE_STAND_FAULT_FOREIGN, 0)

ACT(move_refused, b->stand.refuses_moves = true)
ACT(homing_refused, b->stand.refuses_homing = true)
ACT(never_arrives, b->stand.never_arrives = true)

/* Within tolerance, but never at rest. */
static void never_content(bench_t *b)
{
    b->stand.state = TUMBLE_STAND_MOVING;
    b->stand.never_arrives = true;
}

ACT(encoder_leaves, b->stand.error_deg = -0.06)
ACT(encoder_is_nonsense, b->stand.error_deg = (double)NAN)
ACT(block_slips, b->block.slip_deg = 25.0)
ACT(block_drifts, b->block.drift_v = 0.0021)
ACT(block_dead, tumble_procedure_set_block_alive(&b->procedure, false))
ACT(block_silent, b->block.silent = true)
ACT(time_frozen, b->block.frozen_time = true)
ACT(counter_frozen, b->block.frozen_counter = true)
ACT(samples_lost, b->block.lose_every = 5)
ACT(samples_corrupted, b->block.corrupt_every = 2)

/* The gaps in the counter alone would be allowed. */
static void samples_corrupted_and_few_lost(bench_t *b)
{
    b->block.corrupt_every = 2;
    b->averaging.max_lost = 100;
    b->config.retries = 0;
}

ACT(samples_corrupted_altogether, b->block.corrupt_every = 1)
ACT(self_test, b->block.status = TUMBLE_SAMPLE_SELF_TEST)
ACT(converter, b->block.status = TUMBLE_SAMPLE_CONVERTER)
ACT(too_hot, b->block.status = TUMBLE_SAMPLE_TEMPERATURE)
ACT(says_saturated, b->block.status = TUMBLE_SAMPLE_SATURATED)
ACT(saturated, b->block.u0_v[1] = 9.0)

static void stuck(bench_t *b)
{
    b->averaging.stuck_run = 15;
    b->averaging.max_lost = 20;
    b->block.noise_counts = 0;
}

ACT(restless, b->block.noise_counts = 200)

/* Never as certain as it should be. */
ACT(out_of_budget, b->config.error_budget_v = 1e-9)

/* Farther from one sample to the next than the averaging can sum. */
ACT(leaping, b->block.add_counts = 3000000)
ACT(warming, b->block.warming_half_c = 3)
ACT(operator_away, b->operator_is_away = true)
ACT(wrong_mounting, b->operator_mounts = 1)
ACT(stays_in_mounting_1, b->operator_mounts = 0)

static void swapped_xz(bench_t *b)
{
    b->block.channel[0] = 2;
    b->block.channel[2] = 0;
}

static void swapped_xy(bench_t *b)
{
    b->block.channel[0] = 1;
    b->block.channel[1] = 0;
}

ACT(inverted_z, b->block.sign[2] = -1.0)
ACT(inverted_x, b->block.sign[0] = -1.0)
ACT(scale_far_off, b->config.nominal_scale_v_per_g = -0.5)

/* Small angles tell the directions little, so a dead channel shows in the solution only. */
static void dead_channel_at_small_angles(bench_t *b)
{
    static const tumble_position_t positions[] = {
        {1, 1, TUMBLE_USE_FIT, {0.0, 0.0, 1.0}},
        {1, 2, TUMBLE_USE_FIT, {7.5, 0.1305261922200516, 0.99144486137381038}},
        {1, 3, TUMBLE_USE_FIT, {15.0, 0.25881904510252074, 0.96592582628906831}},
        {2, 1, TUMBLE_USE_FIT, {0.0, 0.0, 1.0}},
        {2, 2, TUMBLE_USE_FIT, {7.5, 0.1305261922200516, 0.99144486137381038}},
        {2, 3, TUMBLE_USE_FIT, {15.0, 0.25881904510252074, 0.96592582628906831}},
    };
    schedule = tumble_schedule_paper;
    schedule.positions = positions;
    schedule.position_count = 6;
    b->config.schedule = &schedule;
    b->config.estimate = TUMBLE_ESTIMATE_LEAST_SQUARES;
    b->block.dead[0] = true;
}

ACT(bus_down, tumble_procedure_set_bus_up(&b->procedure, false))
ACT(unsupervised, tumble_procedure_set_supervised(&b->procedure, false))
#define CASE(reason, failed, before, during, index, state, late)                                                       \
    {TUMBLE_REASON_##reason, TUMBLE_STATE_##failed, before, during, TUMBLE_STATE_##state, index, late}
#define BEFORE(reason, failed, act) CASE(reason, failed, act, NULL, 0, IDLE, false)
#define LATE_BEFORE(reason, failed, act) CASE(reason, failed, act, NULL, 0, IDLE, true)
#define DURING(reason, failed, act, index, state) CASE(reason, failed, NULL, act, index, state, false)
#define LATE_DURING(reason, failed, act, index, state) CASE(reason, failed, NULL, act, index, state, true)

static const fault_case_t fault_cases[] = {
    BEFORE(SCHEDULE, PREFLIGHT, invalid_schedule),
    BEFORE(SCHEDULE, PREFLIGHT, schedule_without_a_position),
    BEFORE(SCHEDULE, PREFLIGHT, schedule_of_one_mounting),
    BEFORE(CONFIGURATION, PREFLIGHT, too_few_samples),
    BEFORE(CONFIGURATION, PREFLIGHT, bad_gates),
    BEFORE(CABLE_LIMIT, PREFLIGHT, short_cable),
    LATE_BEFORE(STAND_OFFLINE, PREFLIGHT, stand_offline),
    LATE_BEFORE(STAND_OFFLINE, PREFLIGHT, stand_in_its_own_world),
    LATE_BEFORE(DRIVE_FAULT, PREFLIGHT, stand_faulty),
    LATE_BEFORE(NO_SAMPLES, PREFLIGHT, block_silent),
    LATE_BEFORE(BLOCK_HEARTBEAT, PREFLIGHT, block_dead),
    LATE_BEFORE(BLOCK_STATUS, PREFLIGHT, self_test),
    LATE_BEFORE(BLOCK_STATUS, PREFLIGHT, converter),
    LATE_BEFORE(SAMPLES_CORRUPTED, PREFLIGHT, samples_corrupted_altogether),
    BEFORE(BUS, PREFLIGHT, bus_down),

    LATE_BEFORE(WARM_UP, WARM_UP, warming),
    LATE_BEFORE(WARM_UP, WARM_UP, too_hot),
    DURING(BLOCK_STATUS, WARM_UP, self_test, 0, WARM_UP),
    DURING(DRIVE_FAULT, WARM_UP, drive_fault, 0, WARM_UP),
    DURING(STAND_HEARTBEAT, WARM_UP, stand_offline, 0, WARM_UP),
    DURING(BLOCK_HEARTBEAT, WARM_UP, block_dead, 0, WARM_UP),
    LATE_DURING(NO_SAMPLES, WARM_UP, block_silent, 0, WARM_UP),

    LATE_BEFORE(MOUNTING_NOT_CONFIRMED, WAIT_MOUNTING, operator_away),
    LATE_DURING(MOUNTING_NOT_CONFIRMED, WAIT_MOUNTING, operator_away, 8, AVERAGE),

    BEFORE(STAND_PROTOCOL, HOME, homing_refused),
    LATE_DURING(HOMING, HOME, never_arrives, 0, HOME),
    DURING(HOMING, HOME, homing_error, 0, HOME),
    DURING(DRIVE_POWER, HOME, power_lost, 0, HOME),
    DURING(BUS, HOME, bus_down, 0, HOME),

    DURING(STAND_PROTOCOL, MOVE, move_refused, 2, AVERAGE),
    DURING(STAND_PROTOCOL, MOVE, protocol_error, 2, MOVE),
    LATE_DURING(TARGET_NOT_REACHED, MOVE, never_arrives, 2, MOVE),
    DURING(TARGET_NOT_REACHED, MOVE, stand_timeout, 2, MOVE),
    DURING(STALL, MOVE, stall, 2, MOVE),
    DURING(DRIVE_FAULT, MOVE, drive_fault, 11, MOVE),
    DURING(DRIVE_FAULT, MOVE, stand_fault_beyond_the_list, 11, MOVE),
    DURING(DRIVE_POWER, MOVE, power_lost, 2, MOVE),
    DURING(STOP_NOT_CONFIRMED, MOVE, stop_not_seen, 2, MOVE),
    DURING(RUNAWAY, MOVE, runs_away, 2, MOVE),
    DURING(SCALE, MOVE, scale_is_wrong, 2, MOVE),
    DURING(SLIP, MOVE, position_lost, 2, MOVE),
    DURING(FOREIGN_COMMAND, MOVE, foreign_command, 2, MOVE),
    DURING(STAND_HEARTBEAT, MOVE, heartbeat_of_stand, 2, MOVE),
    DURING(BLOCK_HEARTBEAT, MOVE, block_dead, 2, MOVE),
    DURING(BUS, MOVE, bus_down, 2, MOVE),
    DURING(SLIP, SETTLE, encoder_leaves, 3, SETTLE),
    LATE_DURING(TARGET_NOT_REACHED, SETTLE, never_content, 3, SETTLE),
    LATE_DURING(NO_SAMPLES, SETTLE, block_silent, 3, SETTLE),
    LATE_DURING(NO_SAMPLES, SETTLE, time_frozen, 3, SETTLE),
    DURING(BLOCK_STATUS, SETTLE, too_hot, 3, SETTLE),
    DURING(SAMPLES_CORRUPTED, SETTLE, samples_corrupted_altogether, 3, SETTLE),
    DURING(STAND_HEARTBEAT, SETTLE, heartbeat_of_stand, 3, SETTLE),
    DURING(SLIP, AVERAGE, encoder_leaves, 3, AVERAGE),
    DURING(SLIP, AVERAGE, encoder_is_nonsense, 3, AVERAGE),
    DURING(SLIP, AVERAGE, block_slips, 1, MOVE),
    DURING(SLIP, AVERAGE, block_slips, 3, MOVE),
    DURING(SLIP, AVERAGE, block_drifts, 8, MOVE),
    LATE_DURING(NO_SAMPLES, AVERAGE, block_silent, 3, AVERAGE),
    DURING(SAMPLES_LOST, AVERAGE, samples_lost, 3, AVERAGE),
    LATE_DURING(NO_SAMPLES, SETTLE, counter_frozen, 3, AVERAGE), /* after the repetition: its samples tell no time */
    DURING(SAMPLES_CORRUPTED, SETTLE, samples_corrupted, 3, AVERAGE),
    DURING(SAMPLES_CORRUPTED, AVERAGE, samples_corrupted_and_few_lost, 3, AVERAGE),
    DURING(BLOCK_STATUS, AVERAGE, converter, 3, AVERAGE),
    DURING(BLOCK_HEARTBEAT, AVERAGE, block_dead, 3, AVERAGE),
    DURING(SATURATED, AVERAGE, says_saturated, 3, AVERAGE),
    DURING(SATURATED, AVERAGE, saturated, 3, MOVE),
    DURING(STUCK, AVERAGE, stuck, 3, MOVE),
    DURING(NOT_STILL, AVERAGE, restless, 3, MOVE),
    DURING(NOT_STILL, AVERAGE, leaping, 3, MOVE),
    DURING(UNCERTAIN, AVERAGE, out_of_budget, 3, MOVE),
    LATE_DURING(TARGET_NOT_REACHED, SETTLE, never_content, 3, AVERAGE),
    DURING(STAND_HEARTBEAT, AVERAGE, heartbeat_of_stand, 3, AVERAGE),
    DURING(BUS, AVERAGE, bus_down, 3, AVERAGE),
    BEFORE(SUPERVISION, PREFLIGHT, unsupervised),
    BEFORE(WRONG_MOUNTING, AVERAGE, wrong_mounting),
    DURING(WRONG_MOUNTING, AVERAGE, stays_in_mounting_1, 8, AVERAGE),
    BEFORE(SWAPPED_CHANNELS, AVERAGE, swapped_xz),
    BEFORE(SWAPPED_CHANNELS, AVERAGE, swapped_xy),
    BEFORE(SWAPPED_CHANNELS, AVERAGE, inverted_z),
    BEFORE(SWAPPED_CHANNELS, AVERAGE, inverted_x),
    BEFORE(SWAPPED_CHANNELS, AVERAGE, scale_far_off),
    BEFORE(SINGULAR, SOLVE, dead_channel_at_small_angles),
};

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
    for (size_t i = 0; i < COUNT_OF(fault_cases); i++) {
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
        for (size_t i = 0; i < COUNT_OF(fault_cases); i++) {
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
        for (size_t i = 0; i < COUNT_OF(fault_cases); i++) {
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
    ASSERT_ENDS(&bench, TUMBLE_STATE_DONE, TUMBLE_REASON_GRAVITY_CHECK);
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
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_STALL, 0x8611);
    bench_tick(&bench);
    ASSERT_ENDED(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_STALL);
    TEST_ASSERT_EQUAL_HEX16(0x8611, bench_progress(&bench).drive_code);
}

static void test_details_of_a_refusal_are_readable(void)
{
    bench_init(&bench);
    schedule_without_a_position(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    tumble_progress_t progress = bench_progress(&bench);
    ASSERT_STATUS(TUMBLE_E_NOT_HARMONIC, progress.status);
    bench_init(&bench);
    schedule_of_one_mounting(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    progress = bench_progress(&bench);
    ASSERT_STATUS(TUMBLE_E_RANK, progress.status);
}
