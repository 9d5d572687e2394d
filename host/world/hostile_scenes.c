/* What belongs together: a fault alone or a frame alone seldom meets the moment at which it hurts. */
#include "world/hostile.h"

#include "canopen/cia402.h"
#include "navcomp/service.h"

#define FOR_GOOD 0.0
#define LIFE_FAULTS 4U

/* A fault that begins at a time. */
static sim_fault_t *add_fault(bench_plan_t *plan, sim_fault_kind_t kind, double at_s, double duration_s)
{
    sim_fault_t *const fault = &bench_plan_add(plan, BENCH_HOSTILE_FAULT, at_s)->fault;
    *fault = (sim_fault_t){.kind = kind,
                           .at_time = true,
                           .time_s = at_s,
                           .duration_s = duration_s,
                           .times = 1,
                           .channels = 1,
                           .count = UINT32_MAX,
                           .probability = 1.0,
                           .mask = TUMBLE_CAN_MAX_ID};
    return fault;
}

static uint16_t draw_identifier(sim_random_t *stream)
{
    static const uint16_t IDS[] = {0x000, 0x082, 0x083, 0x181, 0x182, 0x182, 0x202, 0x202, 0x582,
                                   0x602, 0x581, 0x601, 0x683, 0x683, 0x693, 0x701, 0x702, 0x703};
    return IDS[bench_pick(stream, sizeof IDS / sizeof IDS[0])];
}

static void draw_frame_fault(sim_random_t *stream, sim_fault_t *fault)
{
    fault->id = draw_identifier(stream);
    fault->mask = bench_chance(stream, 0.2) ? 0x780U : (bench_chance(stream, 0.1) ? 0U : TUMBLE_CAN_MAX_ID);
    fault->count = bench_chance(stream, 0.7) ? 1U + bench_pick(stream, 30) : UINT32_MAX;
    fault->probability = bench_chance(stream, 0.5) ? bench_draw(stream, 0.01, 0.7) : 1.0;
    fault->value = bench_draw(stream, 0.001, 1.0); /* of a delay, s */
}

/* The value of a fault, where it means anything: as likely small as large. */
static void draw_value(sim_random_t *stream, sim_fault_t *fault)
{
    static const uint8_t PAIRS[] = {3, 5, 6};
    static const double SCALES[] = {0.1, 0.25, 0.5, 0.9, 1.1, 2.0, 4.0, 10.0};
    const double sign = bench_chance(stream, 0.5) ? 1.0 : -1.0;
    const double size = bench_draw(stream, 0.0, 1.0);
    fault->channels = (uint8_t)(1U + bench_pick(stream, 7));
    switch (fault->kind) {
    case SIM_FAULT_DRIVE_FAULT:
        fault->value = 0x3210;
        break;
    case SIM_FAULT_NEVER_REACHED:
        fault->value = 0.2 + 20.0 * size;
        break;
    case SIM_FAULT_RUNAWAY:
        fault->value = bench_chance(stream, 0.5) ? 0.0 : 720.0 * size * size;
        break;
    case SIM_FAULT_POSITION_SCALE:
        fault->value = SCALES[bench_pick(stream, sizeof SCALES / sizeof SCALES[0])];
        break;
    case SIM_FAULT_SLIP:
        fault->value = sign * 20.0 * size * size;
        fault->count = bench_pick(stream, 2);
        break;
    case SIM_FAULT_NOISY:
        fault->value = 2e-4 + 0.02 * size * size;
        break;
    case SIM_FAULT_SWAPPED:
        fault->channels = PAIRS[bench_pick(stream, 3)];
        break;
    case SIM_FAULT_STEP:
        fault->value = sign * 0.2 * size * size * size;
        break;
    case SIM_FAULT_STATUS:
        fault->value = (double)(1U << bench_pick(stream, 4));
        break;
    case SIM_FAULT_WARM:
        fault->value = sign * 20.0 * size;
        break;
    default:
        fault->count = bench_chance(stream, 0.7) ? 1U + bench_pick(stream, 40) : UINT32_MAX;
        break;
    }
}

void bench_plan_faults(bench_plan_t *plan)
{
    sim_random_t stream;
    sim_random_open(&stream, plan->seed, SIM_CAUSE_LIFE, BENCH_STREAM_FAULTS);
    const uint32_t faults = bench_chance(&stream, 0.7) ? 1U + bench_pick(&stream, LIFE_FAULTS) : 0U;
    for (uint32_t i = 0; i < faults; i++) {
        const double at_s = bench_draw(&stream, 0.0, 1e-6 * (double)plan->lasts_us);
        const double short_s = bench_draw(&stream, 0.01, 2.0);
        const double long_s = bench_draw(&stream, 1.0, 30.0);
        const double duration_s = bench_chance(&stream, 0.4) ? short_s : bench_chance(&stream, 0.7) ? long_s : FOR_GOOD;
        sim_fault_t *const fault =
            add_fault(plan, (sim_fault_kind_t)bench_pick(&stream, SIM_FAULT_KINDS), at_s, duration_s);
        if (fault->kind >= SIM_FAULT_FRAME_DROP) {
            draw_frame_fault(&stream, fault);
        } else {
            draw_value(&stream, fault);
        }
        if (bench_chance(&stream, 0.4)) {
            fault->at_time = false;
            fault->mounting = (uint8_t)(1U + bench_pick(&stream, 2));
            fault->position = (uint8_t)(1U + bench_pick(&stream, 9));
            fault->phase = (sim_phase_t)bench_pick(&stream, 5);
            fault->delay_s = bench_draw(&stream, 0.0, 0.8);
        }
    }
}

/* The table is set in motion by command, the way to stop it is tampered with, and then it is told to stop. */
static void void_the_stop(bench_plan_t *plan, sim_random_t *stream)
{
    const bool turns = bench_chance(stream, 0.4);
    const double at_s = bench_draw(stream, 2.0, 8.0);
    const double moves_s = turns ? at_s + 16.0 : at_s;
    const double writes_s = moves_s + bench_draw(stream, -0.5, 2.5);
    plan->count = 0; /* a run would be in the way */
    bench_plan_add_command(plan, at_s, TUMBLE_COMMAND_HOME_AXIS, 0);
    if (turns) {
        bench_plan_add_command(plan, moves_s, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg =
            bench_draw(stream, 200.0, 399.0);
    } else if (bench_chance(stream, 0.8)) {
        (void)add_fault(plan, SIM_FAULT_HOMING_ENDLESS, bench_draw(stream, 0.0, 2.0), FOR_GOOD);
    }
    if (bench_chance(stream, 0.3)) { /* the stranger knows the key */
        bench_event_t *const key = bench_plan_add(plan, BENCH_HOSTILE_SDO_NAVCOMP, writes_s - 0.1);
        bench_frame_write(&key->frame, 1, 0x2006, 1, 4, TUMBLE_SERVICE_KEY);
    }
    for (uint32_t i = 1U + bench_pick(stream, 2); i > 0U; i--) {
        bench_event_t *const event = bench_plan_add(plan, BENCH_HOSTILE_SDO_NAVCOMP, writes_s);
        bench_draw_stop_write(stream, &event->frame);
    }
    bench_event_t *const abort =
        bench_plan_add_command(plan, writes_s + bench_draw(stream, 0.05, 3.0), TUMBLE_COMMAND_ABORT, 0);
    abort->by_host = bench_chance(stream, 0.3);
}

static void lose_the_mark(bench_plan_t *plan, sim_random_t *stream)
{
    const sim_fault_kind_t kind = bench_chance(stream, 0.7) ? SIM_FAULT_HOMING_ENDLESS : SIM_FAULT_HOMING_FAILS;
    const double at_s = bench_draw(stream, 0.0, 1.0);
    (void)add_fault(plan, kind, at_s, bench_chance(stream, 0.7) ? FOR_GOOD : bench_draw(stream, 10.0, 60.0));
    if (bench_chance(stream, 0.4)) {
        bench_plan_add_command(plan, at_s + 1.0, TUMBLE_COMMAND_HOME_AXIS, 0);
    }
}

/* Position reports that nobody sent, while nothing moves: each a part of a turn further than the one before. */
static void garble_the_count(bench_plan_t *plan, sim_random_t *stream)
{
    static const double STEPS_DEG[] = {120.0, -120.0, 120.0, -120.0, 90.0, -90.0, 170.0, 240.0};
    static const uint32_t STATES[] = {1U << TUMBLE_STATE_WAIT_MOUNTING, 1U << TUMBLE_STATE_WAIT_MOUNTING,
                                      1U << TUMBLE_STATE_DONE, 1U << TUMBLE_STATE_AVERAGE | 1U << TUMBLE_STATE_SETTLE,
                                      1U << TUMBLE_STATE_MOVE};
    bench_event_t *const event = bench_plan_add(plan, BENCH_HOSTILE_POSITION, bench_draw(stream, 10.0, 60.0));
    event->moment.states = STATES[bench_pick(stream, 5)];
    event->moment.delay_us = (uint32_t)bench_draw(stream, 5000.0, 250000.0);
    event->angle_deg = STEPS_DEG[bench_pick(stream, 8)];
    event->count = 1U + bench_pick(stream, 3);
    if (bench_chance(stream, 0.4)) {
        event->kind = BENCH_HOSTILE_NEAR_POSITION;
        bench_draw_near_positions(stream, event);
    }
    plan->attendant.errs = false;
    if (event->moment.states == 1U << TUMBLE_STATE_DONE) {
        bench_event_t *const turn =
            bench_plan_add_command(plan, 1e-6 * (double)event->moment.at_us, TUMBLE_COMMAND_TURN_AXIS, 0);
        turn->moment.states = event->moment.states;
        turn->moment.delay_us = event->moment.delay_us + (uint32_t)bench_draw(stream, 1e5, 2e6);
        turn->angle_deg = bench_draw(stream, -30.0, 400.0);
    }
}

/* The limits first, then set-points, each less than half a turn off: by the shorter way of a drive that wraps. */
static void lead_away(bench_plan_t *plan, sim_random_t *stream, double at_s)
{
    const double sign = bench_chance(stream, 0.5) ? 1.0 : -1.0;
    const uint32_t count = 1U + bench_pick(stream, 5);
    bench_frame_write(&bench_plan_add(plan, BENCH_HOSTILE_SDO_DRIVE, at_s - 0.1)->frame, 2, TUMBLE_402_SOFTWARE_LIMIT,
                      1, 4, 0x80000001U);
    bench_frame_write(&bench_plan_add(plan, BENCH_HOSTILE_SDO_DRIVE, at_s - 0.05)->frame, 2, TUMBLE_402_SOFTWARE_LIMIT,
                      2, 4, 0x7FFFFFFFU);
    for (uint32_t i = 0; i < count; i++) {
        bench_event_t *const event = bench_plan_add(plan, BENCH_HOSTILE_SDO_SET_POINT, at_s + 0.8 * i);
        bench_draw_set_point(stream, event);
        if (i > 0U) {
            event->relative = true;
            event->angle_deg = sign * bench_draw(stream, 100.0, 175.0);
        }
    }
}

/* The table turns by command, alone on the stand, and something is wrong with what moves it or tells where it is. */
static void spoil_a_motion(bench_plan_t *plan, sim_random_t *stream)
{
    static const sim_fault_kind_t KINDS[] = {SIM_FAULT_RUNAWAY, SIM_FAULT_RUNAWAY, SIM_FAULT_FROZEN_POSITION,
                                             SIM_FAULT_POSITION_SCALE};
    const double at_s = bench_draw(stream, 2.0, 8.0);
    const bool homes = bench_chance(stream, 0.4);
    const double moves_s = at_s + (homes ? 0.0 : 16.0);
    const double spoils_s = moves_s + bench_draw(stream, -0.5, 2.5);
    const uint32_t what = bench_pick(stream, 10);
    plan->count = 0; /* a run would be in the way */
    bench_plan_add_command(plan, at_s, TUMBLE_COMMAND_HOME_AXIS, 0);
    if (!homes) {
        const double angle_deg = bench_chance(stream, 0.5) ? bench_draw(stream, -30.0, 400.0) : 400.0;
        bench_plan_add_command(plan, moves_s, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = angle_deg;
    }
    if (homes && bench_chance(stream, 0.5)) {
        (void)add_fault(plan, SIM_FAULT_HOMING_ENDLESS, at_s - 1.0, FOR_GOOD);
    }
    if (what < 4U) {
        sim_fault_t *const fault = add_fault(plan, KINDS[what], spoils_s, FOR_GOOD);
        draw_value(stream, fault);
    } else if (what < 6U) {
        plan->config.scenario.drive.speed_deg_s = 90.0; /* which makes such steps plausible */
        plan->config.profile.velocity_deg_s = 0.0;
        bench_draw_near_positions(stream, bench_plan_add(plan, BENCH_HOSTILE_NEAR_POSITION, spoils_s));
        bench_plan_add_command(plan, moves_s + 12.0, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = 395.0;
    } else if (what < 8U) {
        lead_away(plan, stream, spoils_s);
    } else {
        plan->config.profile.velocity_deg_s = 0.5 * plan->config.scenario.drive.speed_deg_s;
        bench_draw_read_back_write(stream, &bench_plan_add(plan, BENCH_HOSTILE_SDO_DRIVE, spoils_s)->frame);
        bench_plan_add_command(plan, moves_s + 30.0, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = 185.0;
        bench_plan_add_command(plan, moves_s + 50.0, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = -25.0;
    }
}

/* A result waits for its operator, and power is lost. */
static void leave_a_proposal(bench_plan_t *plan, sim_random_t *stream)
{
    bench_event_t *const cut = bench_plan_add(plan, BENCH_HOSTILE_CUT, 10.0);
    cut->off_us = (uint32_t)bench_draw(stream, 1e4, 8e6);
    cut->moment.states = 1U << TUMBLE_STATE_DONE;
    cut->moment.delay_us = (uint32_t)bench_draw(stream, 1e3, 15e6);
    cut->count = bench_chance(stream, 0.5) ? 1U : 0U;
    plan->has_set = false;
    plan->config.keeping.first = false;
}

static void command_the_drive(bench_plan_t *plan, sim_random_t *stream)
{
    const bench_hostile_t kind = bench_chance(stream, 0.5) ? BENCH_HOSTILE_SET_POINT : BENCH_HOSTILE_SDO_SET_POINT;
    bench_event_t *const event = bench_plan_add(plan, kind, bench_draw(stream, 1.0, 1e-6 * (double)plan->lasts_us));
    bench_draw_set_point(stream, event);
    if (bench_chance(stream, 0.5)) {
        event->moment.states = bench_chance(stream, 0.5) ? 1U << TUMBLE_STATE_IDLE : 1U << TUMBLE_STATE_WAIT_MOUNTING;
    }
}

void bench_plan_scenes(bench_plan_t *plan)
{
    static void (*const SCENES[])(bench_plan_t *plan, sim_random_t *stream) = {
        void_the_stop,  lose_the_mark,  garble_the_count, garble_the_count, command_the_drive,
        spoil_a_motion, spoil_a_motion, spoil_a_motion,   leave_a_proposal};
    sim_random_t stream;
    sim_random_open(&stream, plan->seed, SIM_CAUSE_LIFE, BENCH_STREAM_SCENES);
    if (bench_chance(&stream, 0.4)) {
        SCENES[bench_pick(&stream, sizeof SCENES / sizeof SCENES[0])](plan, &stream);
    }
}
