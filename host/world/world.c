#include "world/world.h"

#include "simulation/geometry.h"

#include <stddef.h>
#include <string.h>

#define REST_LIMIT_US 120000000U /* an axis that does not come to rest by then never will */

/* What drive and block have no use for: the block's samples, and, without any PDO, the PDOs of others. */
#define FIRST_SAMPLE_ID 0x680U
#define LAST_SAMPLE_ID 0x6FFU
#define FIRST_PDO_ID 0x180U
#define LAST_PDO_ID 0x57FU

static void on_sample_averaged(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    bench_world_t *const world = context;
    world->truth.alpha4_rad[taken.index] = sim_axis_error_rad(world->axis);
    if (world->watcher->on_sample != NULL) {
        world->watcher->on_sample(world->watcher->context, taken, sample);
    }
}

/* Power on, one after the other. */

static void init_table(bench_world_t *world)
{
    const sim_scenario_t *const scenario = &world->config->scenario;
    sim_random_t stream;
    sim_random_open(&stream, world->seed, SIM_CAUSE_POWER_ON, 0);
    const double angle_deg = scenario->drive.power_on_deg * sim_random_symmetric(&stream);
    sim_angle_error_init(&world->angle_error, world->seed, &scenario->schedule, scenario->stand.law,
                         scenario->stand.angle_rad);
    if (world->config->stand == BENCH_STAND_DRIVE && world->config->present.drive) {
        world->axis = &world->drive.axis;
        sim_drive_init(&world->drive, &scenario->drive, &world->clock, &world->bus, BENCH_BUS_DRIVE,
                       &world->angle_error, angle_deg);
        sim_bus_set_deaf(&world->bus, BENCH_BUS_DRIVE, FIRST_SAMPLE_ID, LAST_SAMPLE_ID);
    } else {
        world->axis = &world->hand;
        sim_axis_init(&world->hand, &scenario->drive.axis, &world->angle_error, angle_deg);
    }
}

static void init_block(bench_world_t *world)
{
    const sim_block_config_t *const config = &world->config->scenario.block;
    world->sensor = config->sensor;
    memcpy(world->sensor.k_v_per_g, world->truth.block.k_v_per_g, sizeof world->sensor.k_v_per_g);
    memcpy(world->sensor.u0_v, world->truth.block.u0_v, sizeof world->sensor.u0_v);
    if (world->config->present.block) {
        sim_block_init(&world->block, config, &world->sensor, world->seed, &world->clock, &world->bus, BENCH_BUS_BLOCK,
                       world->axis);
        sim_bus_set_deaf(&world->bus, BENCH_BUS_BLOCK, FIRST_SAMPLE_ID, LAST_SAMPLE_ID);
        sim_bus_set_deaf(&world->bus, BENCH_BUS_BLOCK, FIRST_PDO_ID, LAST_PDO_ID);
    }
    bench_world_mount(world, 0);
    world->operator.mounted[0] = 0; /* it merely lies there */
}

tumble_navcomp_config_t bench_navcomp_config(const bench_config_t *config, const tumble_port_t *port,
                                             const tumble_navcomp_hooks_t *hooks, bench_stand_memory_t *memory)
{
#define STAND(name, word, kind, type, profile, node) {&(kind), &config->profile, (node)},
    const struct {
        const tumble_stand_kind_t *kind;
        const void *profile;
        uint8_t node;
    } stands[] = {BENCH_STAND_LIST(STAND)}, *const stand = &stands[config->stand];
#undef STAND
    return (tumble_navcomp_config_t){
        .port = port,
        .procedure = &config->procedure,
        .stand = stand->kind,
        .stand_profile = stand->profile,
        .stand_memory = memory,
        .stand_bytes = sizeof *memory,
        .hooks = hooks,
        .declared = &config->declared,
        .block_period_us = config->scenario.block.sample_period_us,
        .heartbeat_ms = config->heartbeat_ms,
        .heartbeat_timeout_ms = config->heartbeat_timeout_ms,
        .node = 1,
        .stand_node = stand->node,
        .block_node = 3,
    };
}

static tumble_status_t init_navcomp(bench_world_t *world)
{
    const bench_config_t *const config = world->config;
    world->firmware = (sim_bus_end_t){&world->bus, BENCH_BUS_NAVCOMP};
    world->port = sim_bus_port(&world->firmware);
    world->hooks = (tumble_navcomp_hooks_t){world, on_sample_averaged};
    world->navcomp_config = bench_navcomp_config(config, &world->port, &world->hooks, &world->stand);
    world->navcomp_config.second_client = &world->second_client;
    if (config->present.navcomp) {
        sim_bus_attach(&world->bus, BENCH_BUS_NAVCOMP, SIM_ACTOR_NAVCOMP);
    }
    for (uint8_t n = BENCH_BUS_GUEST; n < SIM_BUS_NODES; n++) {
        sim_bus_attach_sender(&world->bus, n);
    }
    sim_bus_set_loop(&world->bus, BENCH_BUS_NAVCOMP, config->loop_us);
    tumble_status_t status = tumble_navcomp_init(&world->navcomp, &world->navcomp_config);
    if (status == TUMBLE_OK && config->present.navcomp) {
        status = config->starts ? tumble_navcomp_command(&world->navcomp, TUMBLE_COMMAND_START, 0) : TUMBLE_OK;
        sim_clock_set(&world->clock, SIM_ACTOR_NAVCOMP, 0);
    }
    return status;
}

tumble_status_t bench_world_init(bench_world_t *world, const bench_config_t *config, uint64_t seed,
                                 const bench_watcher_t *watcher)
{
    memset(world, 0, sizeof *world);
    world->config = config;
    world->watcher = watcher;
    world->seed = seed;
    world->ending_us = SIM_NEVER;
    world->limit_us = (uint64_t)(config->virtual_limit_s * 1e6);
    sim_clock_init(&world->clock);
    sim_bus_init(&world->bus, &world->clock, &config->wire, config->scenario.bits_per_second);
    world->bus.tap = watcher->on_frame;
    world->bus.tap_context = watcher->context;
    sim_truth_draw(&world->truth, &config->scenario, seed);
    bench_operator_init(world);
    init_table(world);
    init_block(world);
    bench_fault_script_init(world);
    return init_navcomp(world);
}

static void end_with(bench_world_t *world, world_end_t end)
{
    if (world->wanted_end == WORLD_RUNNING) {
        world->wanted_end = end;
        world->ending_us = world->clock.now_us;
    }
}

void bench_world_end(bench_world_t *world, world_end_t end)
{
    if (world->config->present.navcomp) {
        bench_world_abort(world);
    }
    end_with(world, end);
}

/* True: it has moved on. */
static bool follow_procedure(bench_world_t *world)
{
    const tumble_procedure_t *const procedure = tumble_navcomp_procedure(&world->navcomp);
    const uint32_t mark = tumble_procedure_mark(procedure);
    if (mark == world->mark) {
        return false;
    }
    world->mark = mark;
    tumble_procedure_progress(procedure, &world->progress);
    world->angle_error.position = world->progress.index;
    sim_truth_bias(&world->truth, &world->config->scenario.schedule, world->progress.index, world->sensor.u0_v);
    bench_fault_script_update(world, &world->progress);
    if (world->watcher->on_change != NULL) {
        world->watcher->on_change(world->watcher->context, &world->progress);
    }
    return true;
}

static void look_for_end(bench_world_t *world)
{
    const tumble_state_t state = world->progress.state;
    if (!world->config->starts) {
        return; /* its guests decide when all is done */
    }
    const bool was_reset = world->started && state == TUMBLE_STATE_IDLE; /* by a guest, through NMT */
    world->started = world->started || state != TUMBLE_STATE_IDLE;
    if (state == TUMBLE_STATE_DONE) {
        end_with(world, WORLD_DONE);
    } else if (was_reset || state == TUMBLE_STATE_ABORT ||
               (state == TUMBLE_STATE_FAULT && !bench_operator_is_awaited(world))) {
        end_with(world, WORLD_FAULT);
    }
}

static void step_navcomp(bench_world_t *world)
{
    tumble_navcomp_step(&world->navcomp);
    world->steps++;
    if (follow_procedure(world) || world->config->stand == BENCH_STAND_OPERATOR) { /* who may ask for an angle */
        bench_operator_update(world);
    }
    look_for_end(world);
    const uint64_t next_us = tumble_navcomp_next_deadline_us(&world->navcomp);
    const uint64_t soonest_us = world->clock.now_us + (world->config->loop_us > 0U ? world->config->loop_us : 1U);
    sim_clock_set_no_later(&world->clock, SIM_ACTOR_NAVCOMP, (next_us < soonest_us) ? soonest_us : next_us);
}

static void dispatch(bench_world_t *world, sim_actor_t actor)
{
    switch (actor) {
    case SIM_ACTOR_BUS:
        sim_bus_on_alarm(&world->bus);
        break;
    case SIM_ACTOR_NAVCOMP:
        if (!world->off) {
            step_navcomp(world);
        }
        break;
    case SIM_ACTOR_BLOCK:
        sim_block_on_alarm(&world->block);
        break;
    case SIM_ACTOR_DRIVE:
        sim_drive_on_alarm(&world->drive);
        break;
    case SIM_ACTOR_OPERATOR:
        bench_operator_on_alarm(world);
        break;
    case SIM_ACTOR_FAULTS:
        bench_fault_script_on_alarm(world);
        break;
    case SIM_ACTOR_DELAY:
        sim_bus_on_delay(&world->bus);
        break;
    default:
        break;
    }
}

uint64_t bench_world_next_us(const bench_world_t *world)
{
    return sim_clock_next_us(&world->clock);
}

bool bench_world_has_ended(bench_world_t *world)
{
    if (world->wanted_end == WORLD_RUNNING) {
        return false;
    }
    const bool given_up = world->clock.now_us > world->ending_us + REST_LIMIT_US;
    const bool busy = world->watcher->is_busy != NULL && world->watcher->is_busy(world->watcher->context);
    if ((busy || !bench_world_is_at_rest(world)) && !given_up) {
        return false;
    }
    world->end = world->wanted_end;
    return true;
}

bool bench_world_advance(bench_world_t *world)
{
    sim_actor_t actor;
    if (bench_world_has_ended(world)) {
        return false;
    }
    if (!sim_clock_next(&world->clock, world->limit_us, &actor)) {
        world->end = (world->wanted_end != WORLD_RUNNING) ? world->wanted_end : WORLD_TOO_LONG;
        return false;
    }
    dispatch(world, actor);
    return true;
}

void bench_world_run(bench_world_t *world)
{
    while (bench_world_advance(world)) {
    }
}

void bench_world_abort(bench_world_t *world)
{
    (void)tumble_navcomp_command(&world->navcomp, TUMBLE_COMMAND_ABORT, 0);
    sim_clock_set(&world->clock, SIM_ACTOR_NAVCOMP, world->clock.now_us);
}

bool bench_world_is_at_rest(const bench_world_t *world)
{
    return world->clock.now_us >= sim_axis_end_us(world->axis);
}

void bench_world_pass(bench_world_t *world, uint64_t now_us)
{
    const uint64_t next_us = sim_clock_next_us(&world->clock);
    const uint64_t to_us = (now_us < next_us) ? now_us : next_us;
    world->clock.now_us = (to_us > world->clock.now_us) ? to_us : world->clock.now_us;
}

void bench_world_turn(bench_world_t *world, double angle_deg, double speed_deg_s)
{
    const double acceleration = world->config->scenario.drive.acceleration_deg_s2;
    const sim_axis_dynamics_t dynamics = {speed_deg_s, acceleration, acceleration};
    sim_axis_move(world->axis, world->clock.now_us, angle_deg, &dynamics);
    sim_block_disturb(&world->block);
}

/* In this mounting, or in another one of its bolting. */
static bool was_bolted_on(const bench_world_t *world, uint8_t index)
{
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    const uint8_t first = sim_first_of_bolting(schedule, index);
    bool was = false;
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        was = was || (world->operator.mounted[m] > 0U && sim_first_of_bolting(schedule, m) == first);
    }
    return was;
}

static bool stays_bolted(const bench_world_t *world, uint8_t index)
{
    const tumble_mounting_t *const mountings = world->config->scenario.schedule.mountings;
    return mountings[index].bolting > 0U && mountings[index].bolting == mountings[world->operator.on_table].bolting;
}

bool bench_world_inclines(const bench_world_t *world, uint8_t index)
{
    return stays_bolted(world, index) && was_bolted_on(world, index);
}

void bench_world_mount(bench_world_t *world, uint8_t index)
{
    const sim_scenario_t *const scenario = &world->config->scenario;
    bench_operator_t *const operator = &world->operator;
    const bool stays = stays_bolted(world, index);
    const bool again = was_bolted_on(world, index);
    sim_geometry_t geometry;
    if (stays) {
        sim_truth_keep_bolting(&world->truth, operator->on_table, index);
    } else if (again) {
        sim_truth_remount(&world->truth, scenario, index);
    }
    if (operator->mounted[index]++ > 0U) {
        sim_truth_incline(&world->truth, scenario, index);
    }
    operator->on_table = index;
    operator->inclined = stays && again;
    const sim_seat_t seat = sim_truth_seat(&world->truth, scenario, index);
    sim_geometry_init(&geometry, &scenario->schedule.mountings[index], &seat);
    sim_block_mount(&world->block, &geometry);
}
