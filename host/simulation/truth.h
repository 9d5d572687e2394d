/* truth.h - the one stand and block that a seed makes of a scenario. */
#ifndef TUMBLE_SIMULATION_TRUTH_H
#define TUMBLE_SIMULATION_TRUTH_H

#include "simulation/geometry.h"
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
    double inclination_rad[TUMBLE_MAX_MOUNTINGS]; /* error of beta, alpha1 not in it; 0 where no bolting is given */
    double tau_rad[TUMBLE_MAX_MOUNTINGS];         /* of the zero of the table angle with it */
    double encoder_rad[TUMBLE_WAVES];
    double drift_v[TUMBLE_CHANNELS];
    sim_random_t remount[TUMBLE_MAX_MOUNTINGS];
    sim_random_t seat[TUMBLE_MAX_MOUNTINGS];
    sim_random_t incline[TUMBLE_MAX_MOUNTINGS];
} sim_truth_t;

/* Draw what is fixed for a run: K, U0, alpha1, alpha2, the platform, encoder and drift; and the first yaw and seat of
 * every bolting, the first errors of every inclination. K, U0, alpha1, platform and encoder stay from run to run: they
 * are those of the scenario's `of_seed`, if it has one. */
void sim_truth_draw(sim_truth_t *truth, const sim_scenario_t *scenario, uint64_t seed);

/* The block has been bolted on again: a new seat for this mounting (index in the schedule), and a new yaw, unless one
 * serves all. */
void sim_truth_remount(sim_truth_t *truth, const sim_scenario_t *scenario, uint8_t mounting_index);

/* The block stays bolted on as in the mounting `before`: yaw and seat are those. */
void sim_truth_keep_bolting(sim_truth_t *truth, uint8_t before, uint8_t mounting_index);

/* The stand has been inclined again for this mounting: new errors of its inclination, where a bolting is given. */
void sim_truth_incline(sim_truth_t *truth, const sim_scenario_t *scenario, uint8_t mounting_index);

/* The inclination of the axis in this mounting (rad): nominal, alpha1, and the error of setting it. */
double sim_truth_beta_rad(const sim_truth_t *truth, const tumble_schedule_t *schedule, uint8_t mounting_index);

/* What the block in this mounting feels of the stand: its errors, and the sag of the block against the axis. */
sim_seat_t sim_truth_seat(const sim_truth_t *truth, const sim_scenario_t *scenario, uint8_t mounting_index);

/* Index of the first mounting of the same bolting: of a mounting for itself its own. */
uint8_t sim_first_of_bolting(const tumble_schedule_t *schedule, uint8_t mounting_index);

/* U0 (V) while the position with this index of the schedule is measured: it drifts by equal steps from fit position to
 * fit position, in the middle of which it is that of the block. Check positions are half a step beyond the one before. */
void sim_truth_bias(const sim_truth_t *truth, const tumble_schedule_t *schedule, uint8_t position,
                    double u0_v[TUMBLE_CHANNELS]);

#endif
