#include "world/scene.h"

#include "simulation/geometry.h"

#include <string.h>

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

void bench_world_mount(bench_world_t *world, uint8_t index)
{
    const sim_scenario_t *const scenario = &world->config->scenario;
    sim_geometry_t geometry;
    if (world->person.mounted[index]++ > 0U) {
        sim_truth_remount(&world->truth, scenario, index);
    }
    const sim_truth_t *const truth = &world->truth;
    sim_seat_t seat = {.alpha1_rad = truth->alpha1_rad,
                       .alpha2_rad = truth->alpha2_rad,
                       .alpha3_rad = truth->alpha3_rad[index],
                       .theta_h_rad = truth->theta_h_rad[index],
                       .theta_n_rad = truth->theta_n_rad[index]};
    memcpy(seat.encoder_rad, truth->encoder_rad, sizeof seat.encoder_rad);
    sim_geometry_init(&geometry, &scenario->schedule.mountings[index], &seat);
    sim_block_mount(&world->block, &geometry);
}
