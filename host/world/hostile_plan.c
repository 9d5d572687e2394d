#include "world/hostile.h"

#include <stdlib.h>
#include <string.h>

double bench_draw(sim_random_t *stream, double low, double high)
{
    return low + (high - low) * sim_random_unit(stream);
}

uint32_t bench_pick(sim_random_t *stream, uint32_t count)
{
    return (uint32_t)((sim_random_u64(stream) >> 32) * (uint64_t)count >> 32);
}

bool bench_chance(sim_random_t *stream, double probability)
{
    return sim_random_unit(stream) < probability;
}

bench_event_t *bench_plan_add(bench_plan_t *plan, bench_hostile_t kind, double at_s)
{
    static bench_event_t beyond;
    bench_event_t *const event = (plan->count < BENCH_PLAN_EVENTS) ? &plan->events[plan->count] : &beyond;
    *event = (bench_event_t){.kind = kind, .number = plan->count};
    event->moment.at_us = (uint64_t)((at_s > 0.0) ? at_s * 1e6 : 0.0);
    plan->count += (event != &beyond) ? 1U : 0U;
    return event;
}

bench_event_t *bench_plan_add_command(bench_plan_t *plan, double at_s, tumble_command_t command, uint8_t argument)
{
    bench_event_t *const event = bench_plan_add(plan, BENCH_HOSTILE_COMMAND, at_s);
    event->command = command;
    event->argument = argument;
    return event;
}

/* The world. */

static void draw_drive(bench_config_t *config, sim_random_t *stream)
{
    static const uint32_t WRAPS[] = {0, 0, 360000, 360000, 720000};
    static const double SPEEDS[] = {90.0, 90.0, 60.0, 30.0};
    sim_drive_config_t *const drive = &config->scenario.drive;
    drive->wrap_counts = WRAPS[bench_pick(stream, 5)];
    drive->sign = bench_chance(stream, 0.5) ? 1 : -1;
    drive->latches_stale_target = bench_chance(stream, 0.5);
    drive->reaction_us = (uint32_t)bench_draw(stream, 200.0, 20000.0);
    drive->report_us = (uint32_t)bench_draw(stream, 5000.0, 50000.0);
    drive->speed_deg_s = SPEEDS[bench_pick(stream, 4)];
    drive->axis.settling_s = 0.1;
    config->profile.homing_fast_deg_s = (drive->speed_deg_s < 45.0) ? drive->speed_deg_s : 45.0;
    config->profile.velocity_deg_s = (drive->speed_deg_s >= 60.0 && bench_chance(stream, 0.5)) ? 30.0 : 0.0;
    config->profile.stop = (uint8_t)(bench_chance(stream, 0.3) ? TUMBLE_STOP_BY_HALT : TUMBLE_STOP_BY_QUICK_STOP);
}

static void draw_measuring(bench_config_t *config, sim_random_t *stream)
{
    static const tumble_estimate_t ESTIMATES[] = {TUMBLE_ESTIMATE_AVERAGED, TUMBLE_ESTIMATE_REFINED,
                                                  TUMBLE_ESTIMATE_LEAST_SQUARES};
    tumble_procedure_config_t *const procedure = &config->procedure;
    config->scenario.stand.remount_rad = 4e-5;
    config->scenario.block.sample_period_us = bench_chance(stream, 0.5) ? 10000U : 20000U;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        config->scenario.block.sensor.noise_v[i] = 2e-4;
    }
    procedure->samples = 24;
    procedure->estimate = ESTIMATES[bench_pick(stream, 3)];
    procedure->settle_ms = 100;
    procedure->warm_up_samples = 5;
    procedure->mounting_timeout_ms = 20000;
    procedure->warm_up_timeout_ms = 20000;
    procedure->retries = (uint8_t)bench_pick(stream, 3);
}

static void draw_keeping(bench_plan_t *plan, sim_random_t *stream)
{
    bench_keeping_t *const keeping = &plan->config.keeping;
    (void)strcpy(keeping->serial, "TB-0001");
    keeping->first = bench_chance(stream, 0.7); /* else the first result is held */
    keeping->settings.gravity_m_s2 = 9.81;
    plan->has_set = bench_chance(stream, 0.5);
    plan->utc_s = bench_chance(stream, 0.7) ? 1800000000U : 0U;
    plan->erase_us = bench_chance(stream, 0.5) ? (uint32_t)bench_draw(stream, 1000.0, 80000.0) : 0U;
    plan->program_us = bench_chance(stream, 0.5) ? (uint32_t)bench_draw(stream, 20.0, 3000.0) : 0U;
}

static void draw_attendant(bench_plan_t *plan, sim_random_t *stream)
{
    plan->attendant = (bench_attendant_t){
        .mount_s = bench_draw(stream, 0.3, 3.0),
        .mend_s = bench_draw(stream, 1.0, 10.0),
        .mends = bench_pick(stream, 4),
        .resumes = bench_chance(stream, 0.6),
        .errs = bench_chance(stream, 0.03),
    };
    plan->config.scenario.person = (sim_operator_config_t){.mount_s = -1.0, .turn_s = -1.0, .mend_s = -1.0};
}

static void draw_world(bench_plan_t *plan)
{
    sim_random_t stream;
    sim_random_open(&stream, plan->seed, SIM_CAUSE_LIFE, BENCH_STREAM_WORLD);
    bench_config_t *const config = &plan->config;
    bench_config_defaults(config);
    draw_drive(config, &stream);
    draw_measuring(config, &stream);
    draw_keeping(plan, &stream);
    draw_attendant(plan, &stream);
    config->starts = false;
    plan->lasts_us = (uint64_t)(bench_draw(&stream, 80.0, 180.0) * 1e6);
    config->virtual_limit_s = 1e-6 * (double)plan->lasts_us + 1.0; /* the plan ends it */
}

/* The ordinary course: a run, perhaps another, and what people do besides. */

static void draw_command(bench_plan_t *plan, sim_random_t *stream)
{
    static const tumble_command_t COMMANDS[] = {TUMBLE_COMMAND_START,
                                                TUMBLE_COMMAND_ABORT,
                                                TUMBLE_COMMAND_ABORT,
                                                TUMBLE_COMMAND_HOME_AXIS,
                                                TUMBLE_COMMAND_TURN_AXIS,
                                                TUMBLE_COMMAND_TURN_AXIS,
                                                TUMBLE_COMMAND_RESUME,
                                                TUMBLE_COMMAND_CLEAR_FAULT,
                                                TUMBLE_COMMAND_REPEAT_POSITION,
                                                TUMBLE_COMMAND_REPEAT_MOUNTING,
                                                TUMBLE_COMMAND_CONFIRM_MOUNTING,
                                                TUMBLE_COMMAND_ACCEPT,
                                                TUMBLE_COMMAND_DISCARD,
                                                TUMBLE_COMMAND_ROLLBACK};
    const double at_s = bench_draw(stream, 0.0, 1e-6 * (double)plan->lasts_us);
    const tumble_command_t command = COMMANDS[bench_pick(stream, sizeof COMMANDS / sizeof COMMANDS[0])];
    const bool of_a_mounting = command == TUMBLE_COMMAND_REPEAT_MOUNTING || command == TUMBLE_COMMAND_CONFIRM_MOUNTING;
    bench_event_t *const event =
        bench_plan_add_command(plan, at_s, command, (uint8_t)(of_a_mounting ? 1U + bench_pick(stream, 2) : 0U));
    event->by_host = bench_chance(stream, 0.3);
    if (command == TUMBLE_COMMAND_REPEAT_POSITION) {
        event->argument = (uint8_t)bench_pick(stream, 20);
    } else if (command == TUMBLE_COMMAND_TURN_AXIS) {
        event->angle_deg = bench_draw(stream, -40.0, 410.0);
    }
}

static void draw_course(bench_plan_t *plan)
{
    sim_random_t stream;
    sim_random_open(&stream, plan->seed, SIM_CAUSE_LIFE, BENCH_STREAM_COURSE);
    const uint32_t commands = bench_chance(&stream, 0.5) ? bench_pick(&stream, 7) : 0U;
    if (bench_chance(&stream, 0.85)) {
        bench_plan_add_command(plan, bench_draw(&stream, 0.2, 4.0), TUMBLE_COMMAND_START, 0)->by_host = true;
    }
    if (bench_chance(&stream, 0.6)) {
        bench_plan_add_command(plan, bench_draw(&stream, 60.0, 120.0), TUMBLE_COMMAND_START, 0);
    }
    for (uint32_t i = 0; i < commands; i++) {
        draw_command(plan, &stream);
    }
}

static void draw_cuts(bench_plan_t *plan)
{
    sim_random_t stream;
    sim_random_open(&stream, plan->seed, SIM_CAUSE_LIFE, BENCH_STREAM_CUTS);
    const uint32_t cuts = bench_chance(&stream, 0.35) ? 1U + bench_pick(&stream, 3) : 0U;
    for (uint32_t i = 0; i < cuts; i++) {
        const double at_s = bench_draw(&stream, 0.0, 1e-6 * (double)plan->lasts_us);
        bench_event_t *const cut = bench_plan_add(plan, BENCH_HOSTILE_CUT, at_s);
        cut->off_us = (uint32_t)(1e6 * bench_draw(&stream, 0.01, 8.0));
        cut->moment.writing = bench_chance(&stream, 0.5);
        cut->moment.delay_us = bench_chance(&stream, 0.5) ? (uint32_t)bench_draw(&stream, 0.0, 20000.0) : 0U;
        const uint32_t flips = bench_chance(&stream, 0.5) ? 1U : 1U + bench_pick(&stream, 8);
        cut->count = bench_chance(&stream, 0.3) ? flips : 0U;
    }
}

/* Before the next event of the same time comes the one drawn before. */
static int compare(const void *a, const void *b)
{
    const bench_event_t *const one = a;
    const bench_event_t *const other = b;
    if (one->moment.at_us != other->moment.at_us) {
        return (one->moment.at_us < other->moment.at_us) ? -1 : 1;
    }
    return (one->number < other->number) ? -1 : 1;
}

const char *bench_plan_draw(bench_plan_t *plan, uint64_t seed)
{
    memset(plan, 0, sizeof *plan);
    plan->seed = seed;
    draw_world(plan);
    draw_course(plan);
    bench_plan_faults(plan);
    draw_cuts(plan);
    bench_plan_scenes(plan);
    bench_plan_frames(plan);
    qsort(plan->events, plan->count, sizeof plan->events[0], compare);
    const char *const wrong = bench_config_complete(&plan->config);
    return (wrong != NULL) ? wrong : bench_config_refused(&plan->config);
}
