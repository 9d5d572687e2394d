#include "world/world.h"

static uint64_t in_us(double seconds)
{
    return (uint64_t)(seconds * 1e6 + 0.5);
}

static void set_alarm(bench_world_t *world)
{
    uint64_t next_us = SIM_NEVER;
    for (uint32_t i = 0; i < world->config->scenario.fault_count; i++) {
        const bench_fault_state_t *const state = &world->script.states[i];
        next_us = (state->begin_us < next_us) ? state->begin_us : next_us;
        next_us = (state->end_us < next_us) ? state->end_us : next_us;
    }
    sim_clock_set(&world->clock, SIM_ACTOR_FAULTS, next_us);
}

void bench_fault_script_init(bench_world_t *world)
{
    for (uint32_t i = 0; i < SIM_MAX_FAULTS; i++) {
        const sim_fault_t *const fault = &world->config->scenario.faults[i];
        const bool timed = i < world->config->scenario.fault_count && fault->at_time;
        world->script.states[i] = (bench_fault_state_t){
            .begin_us = timed ? in_us(fault->time_s + fault->delay_s) : SIM_NEVER, .end_us = SIM_NEVER};
    }
    set_alarm(world);
}

static bool is_phase(sim_phase_t phase, tumble_state_t state)
{
    switch (phase) {
    case SIM_PHASE_MOUNT:
        return state == TUMBLE_STATE_WAIT_MOUNTING;
    case SIM_PHASE_HOME:
        return state == TUMBLE_STATE_HOME;
    case SIM_PHASE_MOVE:
        return state == TUMBLE_STATE_MOVE;
    case SIM_PHASE_SETTLE:
        return state == TUMBLE_STATE_SETTLE;
    default:
        return state == TUMBLE_STATE_AVERAGE;
    }
}

void bench_fault_script_update(bench_world_t *world, const tumble_progress_t *progress)
{
    const sim_scenario_t *const scenario = &world->config->scenario;
    for (uint32_t i = 0; i < scenario->fault_count; i++) {
        const sim_fault_t *const fault = &scenario->faults[i];
        bench_fault_state_t *const state = &world->script.states[i];
        if (!fault->at_time && state->begin_us == SIM_NEVER && !state->in_force && state->times < fault->times &&
            progress->mounting == fault->mounting && progress->position == fault->position &&
            is_phase(fault->phase, progress->state)) {
            state->begin_us = world->clock.now_us + in_us(fault->delay_s);
        }
    }
    set_alarm(world);
}

static void set_frame_fault(bench_world_t *world, uint32_t number, const sim_fault_t *fault, bool on)
{
    if (!on) {
        sim_bus_end_fault(&world->bus, number);
        return;
    }
    sim_bus_fault_t frames = {
        .kind = (sim_frame_fault_t)(fault->kind - SIM_FAULT_FRAME_DROP),
        .match = fault->id & fault->mask,
        .mask = fault->mask,
        .count = fault->count,
        .delay_us = (uint32_t)in_us((fault->value > 0.0) ? fault->value : 0.0),
        .probability = fault->probability,
    };
    sim_random_open(&frames.random, world->seed, SIM_CAUSE_BUS_FAULT, number);
    sim_bus_begin_fault(&world->bus, number, &frames);
}

/* What has to be done at once, beyond an effect that is there to be looked at. `on` or over again. */
static void act(bench_world_t *world, uint32_t number, bool on)
{
    const sim_fault_t *const fault = &world->config->scenario.faults[number];
    sim_drive_t *const drive = &world->drive;
    switch (fault->kind) {
    case SIM_FAULT_DRIVE_FAULT:
        if (on) {
            sim_drive_fail(drive, (uint16_t)fault->value, true);
        } else {
            sim_drive_mend(drive);
        }
        break;
    case SIM_FAULT_STALL:
        sim_axis_jam(world->axis, world->clock.now_us, on);
        sim_drive_disturb(drive);
        break;
    case SIM_FAULT_RUNAWAY:
        sim_drive_run_away(drive);
        break;
    case SIM_FAULT_FROZEN_POSITION:
    case SIM_FAULT_POSITION_SCALE:
        sim_drive_disturb(drive);
        break;
    case SIM_FAULT_SLIP:
        sim_axis_slip(world->axis, on ? fault->value : -fault->value, fault->count == 1U);
        sim_drive_disturb(drive);
        break;
    case SIM_FAULT_DRIVE_SILENT:
        sim_bus_set_down(&world->bus, BENCH_BUS_DRIVE, on);
        break;
    case SIM_FAULT_DRIVE_POWER_CYCLE:
        sim_drive_set_power(drive, !on);
        break;
    case SIM_FAULT_BLOCK_SILENT:
        sim_bus_set_down(&world->bus, BENCH_BUS_BLOCK, on);
        break;
    case SIM_FAULT_BLOCK_POWER_CYCLE:
        sim_block_set_power(&world->block, !on);
        break;
    case SIM_FAULT_BUS_OFF:
        sim_bus_set_down(&world->bus, BENCH_BUS_NAVCOMP, on);
        break;
    default:
        if (sim_fault_of(fault->kind) == SIM_OF_FRAMES) {
            set_frame_fault(world, number, fault, on);
        }
        break;
    }
}

static void set_fault(bench_world_t *world, uint32_t number, bool on)
{
    const sim_fault_t *const fault = &world->config->scenario.faults[number];
    const sim_fault_effect_t effect = {
        .on = on,
        .channels = on ? fault->channels : 0U,
        .count = on ? fault->count : 0U,
        .value = on ? fault->value : 0.0,
    };
    world->drive.faults[fault->kind] = effect;
    world->block.faults[fault->kind] = effect;
    world->block.sensor.faults[fault->kind] = effect;
    act(world, number, on);
    sim_block_disturb(&world->block);
}

void bench_fault_script_mend(bench_world_t *world)
{
    for (uint32_t i = 0; i < world->config->scenario.fault_count; i++) {
        bench_fault_state_t *const state = &world->script.states[i];
        if (state->in_force && state->end_us == SIM_NEVER) {
            state->in_force = false;
            set_fault(world, i, false);
        }
    }
}

static void begin_or_end(bench_world_t *world, uint32_t number)
{
    const double duration_s = world->config->scenario.faults[number].duration_s;
    bench_fault_state_t *const state = &world->script.states[number];
    const uint64_t now_us = world->clock.now_us;
    if (state->end_us <= now_us) {
        state->end_us = SIM_NEVER;
        state->in_force = false;
        set_fault(world, number, false);
    }
    if (state->begin_us <= now_us) {
        state->begin_us = SIM_NEVER;
        state->times++;
        state->in_force = true;
        state->end_us = (duration_s > 0.0) ? now_us + in_us(duration_s) : SIM_NEVER;
        set_fault(world, number, true);
    }
}

void bench_fault_script_on_alarm(bench_world_t *world)
{
    for (uint32_t i = 0; i < world->config->scenario.fault_count; i++) {
        begin_or_end(world, i);
    }
    set_alarm(world);
}
