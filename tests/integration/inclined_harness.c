/* The force that the simulation puts on a block on an inclined stand, for another language to compare with.
 *
 *     inclined_harness SEED inclination_rad sag_across_rad_per_g sag_along_rad_per_g
 *
 * prints the errors that the seed draws: alpha1, alpha2; a line for each mounting of `inclined_closed`: alpha3, theta_h,
 * theta_n, beta, tau; and a line for each position: the force on x, y, z, without errors of the set angles.
 */
#include "simulation/geometry.h"
#include "simulation/truth.h"

#include <stdio.h>
#include <stdlib.h>

#define LARGE_RAD 1e-2 /* errors that no term of higher order can hide behind */

int main(int count, char **words)
{
    sim_scenario_t scenario;
    sim_truth_t truth;
    if (count != 5) {
        return 2;
    }
    sim_scenario_defaults(&scenario);
    scenario.schedule = tumble_schedule_inclined_closed;
    scenario.stand.axis_tilt_rad = scenario.stand.level_rad = scenario.stand.remount_rad = LARGE_RAD;
    scenario.stand.seat_rad = scenario.stand.platform_rad = LARGE_RAD;
    scenario.stand.inclination_rad = strtod(words[2], NULL);
    scenario.stand.sag_across_rad_per_g = strtod(words[3], NULL);
    scenario.stand.sag_along_rad_per_g = strtod(words[4], NULL);
    sim_truth_draw(&truth, &scenario, strtoull(words[1], NULL, 10));
    (void)printf("%.17g %.17g\n", truth.alpha1_rad, truth.alpha2_rad);
    const tumble_schedule_t *const schedule = &scenario.schedule;
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        (void)printf("%.17g %.17g %.17g %.17g %.17g\n", truth.alpha3_rad[m], truth.theta_h_rad[m], truth.theta_n_rad[m],
                     sim_truth_beta_rad(&truth, schedule, m), truth.tau_rad[m]);
    }
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const uint8_t m = (uint8_t)(schedule->positions[p].mounting - 1U);
        const sim_seat_t seat = sim_truth_seat(&truth, &scenario, m);
        sim_geometry_t geometry;
        double force[3];
        sim_geometry_init(&geometry, &schedule->mountings[m], &seat);
        sim_geometry_force(&geometry, schedule->positions[p].angle.deg, force);
        (void)printf("%.17g %.17g %.17g\n", force[0], force[1], force[2]);
    }
    return 0;
}
