/* The invariants of the table, and those that a state shows. */
#include "world/hostile_invariants.h"

#include <math.h>

#define PEACE_US 1000000U /* it has stood for so long: it rests */

void bench_watch_ended(bench_life_t *life)
{
    if (life->watch.rest_us == SIM_NEVER && !life->watch.peace) {
        life->watch.rest_us = life->world.clock.now_us + BENCH_REST_US;
        life->watch.still_us = SIM_NEVER; /* what is on its way to the drive may still set it in motion */
    }
}

static bool is_of_a_run(tumble_state_t state)
{
    return state != TUMBLE_STATE_IDLE && state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT &&
           state != TUMBLE_STATE_FAULT;
}

void bench_watch_change(bench_life_t *life, const tumble_progress_t *progress)
{
    const bool was_on = is_of_a_run(life->watch.state);
    const tumble_state_t state = progress->state;
    const bool changed = state != life->watch.state;
    const bool waited = !was_on && life->watch.state != TUMBLE_STATE_FAULT;
    const bool may_begin = !was_on && (changed || state == TUMBLE_STATE_ABORT); /* and failed or aborted at once */
    bench_watch_count_run(life, waited && is_of_a_run(state), may_begin);
    life->watch.state = state;
    if (is_of_a_run(state)) {
        life->watch.level_until_us = 0; /* it ends with the beginning of a run */
    } else if (state == TUMBLE_STATE_DONE && changed) {
        bench_watch_may_go(life, true); /* the new result takes its place */
    }
    if ((state == TUMBLE_STATE_FAULT || state == TUMBLE_STATE_ABORT) && progress->reason == TUMBLE_REASON_NONE) {
        bench_watch_break(life, BENCH_BROKEN_REASON, 0.0, (uint32_t)state);
    }
    if (changed && !is_of_a_run(state) && (was_on || state != TUMBLE_STATE_IDLE)) {
        bench_watch_ended(life);
        life->counts.ends[state][progress->reason]++;
    }
}

/* The way in which the table comes to rest from its full speed. */
static double braking_deg(const sim_drive_config_t *drive)
{
    return drive->speed_deg_s * drive->speed_deg_s / (2.0 * drive->acceleration_deg_s2);
}

/* A stranger has commanded the drive so lately that the computer need not have noticed. */
static bool is_excused(const bench_life_t *life)
{
    const bench_watch_t *const watch = &life->watch;
    return bench_watch_has_excuse(life, BENCH_EXCUSE_COMMANDED) &&
           life->world.clock.now_us < watch->commanded_us + BENCH_NOTICE_US;
}

static bench_broken_t blamed(const bench_life_t *life, bench_broken_t otherwise)
{
    return bench_watch_has_excuse(life, BENCH_EXCUSE_COMMANDED) ? BENCH_BROKEN_FOREIGN : otherwise;
}

/* A table that stands for a moment, say between the search for the mark and the way back to it, does not rest. */
static void look_for_peace(bench_watch_t *watch, uint64_t now_us, bool moves)
{
    watch->still_us = moves ? SIM_NEVER : (watch->still_us == SIM_NEVER) ? now_us : watch->still_us;
    if (watch->rest_us != SIM_NEVER && !moves && now_us - watch->still_us >= PEACE_US) {
        watch->rest_us = SIM_NEVER;
        watch->peace = true;
    }
}

static void look_at_rest(bench_life_t *life, bool moves, double deg)
{
    bench_watch_t *const watch = &life->watch;
    const uint64_t now_us = life->world.clock.now_us;
    look_for_peace(watch, now_us, moves);
    if (!moves || is_excused(life)) {
        return;
    }
    if (watch->rest_us != SIM_NEVER && now_us >= watch->rest_us) {
        bench_watch_break(life, blamed(life, BENCH_BROKEN_REST), deg, (uint32_t)watch->state);
    } else if (watch->peace) {
        bench_watch_break(life, blamed(life, BENCH_BROKEN_STAYS), deg, (uint32_t)watch->state);
    }
}

/* On the way back it may be beyond: after a stranger has taken it there. */
static void look_at_cable(bench_life_t *life, bool moves, double deg)
{
    const bench_config_t *const config = &life->plan->config;
    const sim_drive_config_t *const drive = &config->scenario.drive;
    const double unseen_deg = drive->speed_deg_s * 1e-6 * drive->report_us; /* between two reports */
    const double tolerance_deg = BENCH_CABLE_TOLERANCE_DEG + unseen_deg + braking_deg(drive);
    const double last_deg = life->watch.last_deg;
    const bool below = deg < config->procedure.cable_min_deg - tolerance_deg && deg < last_deg;
    const bool above = deg > config->procedure.cable_max_deg + tolerance_deg && deg > last_deg;
    if (moves && (below || above) && !is_excused(life)) {
        bench_watch_break(life, blamed(life, BENCH_BROKEN_CABLE), deg, (uint32_t)life->watch.state);
    }
}

static bool is_under_way(sim_homing_t homing)
{
    return homing == SIM_HOMING_SEARCH || homing == SIM_HOMING_APPROACH;
}

/* A homing that was broken off counts until the table rests. */
static void look_at_homing(bench_life_t *life, bool moves, double deg)
{
    bench_watch_t *const watch = &life->watch;
    const sim_homing_t homing = life->world.drive.homing;
    if (is_under_way(homing) && !is_under_way(watch->homing)) {
        watch->searches = true;
        watch->from_deg = deg;
        life->counts.homings++;
    } else if (!is_under_way(homing) && (!moves || homing == SIM_HOMING_ATTAINED)) {
        watch->searches = false;
    }
    watch->homing = homing;
    if (watch->searches && fabs(deg - watch->from_deg) > BENCH_HOMING_DEG) {
        bench_watch_break(life, BENCH_BROKEN_HOMING, deg - watch->from_deg, (uint32_t)watch->state);
    }
}

/* What a stranger has changed is read back before a motion; what he changes on its way may count for its next leg. */
static void look_at_speed(bench_life_t *life, double velocity_deg_s, double deg)
{
    bench_watch_t *const watch = &life->watch;
    const uint64_t now_us = life->world.clock.now_us;
    const tumble_drive_profile_t *const profile = &life->plan->config.profile;
    const double told_deg_s = is_under_way(watch->homing) ? profile->homing_fast_deg_s : profile->velocity_deg_s;
    if (fabs(velocity_deg_s) <= told_deg_s * BENCH_SPEED_EXCESS) {
        watch->fast_us = SIM_NEVER;
    } else if (watch->fast_us == SIM_NEVER) {
        watch->fast_us = now_us;
    } else if (now_us - watch->fast_us > BENCH_NOTICE_US) {
        bench_watch_break(life, BENCH_BROKEN_SPEED, deg, (uint32_t)watch->state);
    }
}

static void look_at_table(bench_life_t *life)
{
    const bench_world_t *const world = &life->world;
    const uint64_t now_us = world->clock.now_us;
    const bool moves = now_us < sim_axis_end_us(world->axis);
    double velocity_deg_s;
    if (bench_watch_has_excuse(life, BENCH_EXCUSE_REWRITTEN)) {
        return;
    }
    const double deg = sim_axis_commanded_deg(world->axis, now_us, &velocity_deg_s);
    look_at_rest(life, moves, deg);
    look_at_homing(life, moves, deg);
    look_at_speed(life, velocity_deg_s, deg);
    if (world->drive.homing == SIM_HOMING_ATTAINED && world->drive.powered) {
        look_at_cable(life, moves, deg);
    }
    life->watch.last_deg = deg;
}

void bench_watch_look(bench_life_t *life)
{
    look_at_table(life);
    if (!life->world.off) {
        bench_watch_rules(life);
        bench_watch_sets(life);
    }
}
