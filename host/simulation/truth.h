/* truth.h - the one stand and block that a seed makes of a scenario. */
#ifndef TUMBLE_SIMULATION_TRUTH_H
#define TUMBLE_SIMULATION_TRUTH_H

#include "simulation/scenario.h"
#include "tumble/core.h"

#include <stdint.h>

typedef struct {
    tumble_coefficients_t block;
    double alpha1_rad;
    double alpha2_rad;
    double alpha3_rad[TUMBLE_MAX_MOUNTINGS]; /* by mounting of the schedule; of its last mounting */
    double alpha4_rad[TUMBLE_MAX_POSITIONS]; /* by position of the schedule; when it was last averaged */
    double platform_rad;
    double theta_h_rad[TUMBLE_MAX_MOUNTINGS]; /* as alpha3_rad; the platform's is in it */
    double theta_n_rad[TUMBLE_MAX_MOUNTINGS];
    double encoder_rad[TUMBLE_WAVES];
    double drift_v[TUMBLE_CHANNELS];
    sim_random_t remount[TUMBLE_MAX_MOUNTINGS];
    sim_random_t seat[TUMBLE_MAX_MOUNTINGS];
} sim_truth_t;

/* Draw what is fixed for a run: K, U0, alpha1, alpha2, the platform, encoder and drift, and the first yaw and seat of every mounting. */
void sim_truth_draw(sim_truth_t *truth, const sim_scenario_t *scenario, uint64_t seed);

/* The block has been mounted again: a new seat for this mounting (index in the schedule), and a new yaw, unless one
 * serves all. */
void sim_truth_remount(sim_truth_t *truth, const sim_scenario_t *scenario, uint8_t mounting_index);

/* U0 (V) while the position with this index of the schedule is measured: it drifts by equal steps from fit position to
 * fit position, in the middle of which it is that of the block. Check positions are half a step beyond the one before. */
void sim_truth_bias(const sim_truth_t *truth, const tumble_schedule_t *schedule, uint8_t position,
                    double u0_v[TUMBLE_CHANNELS]);

#endif
