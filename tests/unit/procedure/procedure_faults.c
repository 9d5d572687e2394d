#include "procedure_faults.h"

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

void schedule_without_a_position(bench_t *b)
{
    use_copy_of_paper(b);
    schedule.position_count = 17;
}

/* One mounting alone never points gravity along y. */
void schedule_of_one_mounting(bench_t *b)
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

const fault_case_t fault_cases[] = {
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

const size_t fault_case_count = COUNT_OF(fault_cases);
