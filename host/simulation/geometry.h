/* geometry.h - the exact geometry of a block on a stand that is not quite level (docs/method.md, "Stand, mountings").
 *
 * In the table frame (h horizontal across the axis, n along the axis, v up at table angle 0) the specific force is
 *     f = (cos t sin p, sin t, cos t cos p),   p = table angle + alpha2 + theta_n + delta,   t = known tilt + alpha1;
 * a seat that leans turns it about h,
 *     (n, v) -> (n cos theta_h + v sin theta_h, v cos theta_h - n sin theta_h);
 * the block's yaw alpha3 turns it about v,
 *     h' = h cos alpha3 + n sin alpha3,  n' = -h sin alpha3 + n cos alpha3,  v' = v;
 * the mounting's matrix M brings it to the block's axes: a = M (h', n', v'). All of it is linear in (sin p, cos p, 1),
 * so a mounting is one 3 x 3 matrix, worked out once.
 */
#ifndef TUMBLE_SIMULATION_GEOMETRY_H
#define TUMBLE_SIMULATION_GEOMETRY_H

#include "tumble/core.h"

#include <stdbool.h>

typedef struct {
    double a[3][3];   /* block axes x, y, z over (sin p, cos p, 1) */
    double level_deg; /* alpha2 + theta_n */
    double encoder_deg[TUMBLE_WAVES];
    bool turns_true; /* all of these are 0 */
} sim_geometry_t;

/* The errors of the stand that do not change as long as a block stays mounted. */
typedef struct {
    double alpha1_rad;
    double alpha2_rad;
    double alpha3_rad;
    double theta_h_rad;
    double theta_n_rad;
    double encoder_rad[TUMBLE_WAVES]; /* by sine and cosine of the table angle, and of its double */
} sim_seat_t;

void sim_geometry_init(sim_geometry_t *geometry, const tumble_mounting_t *mounting, const sim_seat_t *seat);

/* Specific force (g) on the block's axes with the table at `actual_deg` (its own error delta included). */
void sim_geometry_force(const sim_geometry_t *geometry, double actual_deg, double a_g[3]);

#endif
