#include "simulation/motion.h"

#include <assert.h>
#include <math.h> /* sqrt, fabs: exact or correctly rounded */

void sim_motion_rest(sim_motion_t *motion, double position)
{
    motion->count = 0;
    motion->end_s = 0.0;
    motion->end_position = position;
}

/* Append a piece and go on from its end. */
static void append(sim_motion_t *motion, double duration_s, double *position, double *velocity, double acceleration)
{
    assert(motion->count < SIM_MOTION_PIECES);
    motion->pieces[motion->count++] = (sim_motion_piece_t){motion->end_s, *position, *velocity, acceleration};
    motion->end_s += duration_s;
    *position += (*velocity + 0.5 * acceleration * duration_s) * duration_s;
    *velocity += acceleration * duration_s;
}

static void append_brake(sim_motion_t *motion, double *position, double *velocity, double deceleration)
{
    if (*velocity != 0.0) {
        append(motion, fabs(*velocity) / deceleration, position, velocity,
               (*velocity > 0.0) ? -deceleration : deceleration);
        *velocity = 0.0;
    }
}

void sim_motion_stop(sim_motion_t *motion, double position, double velocity, double deceleration)
{
    sim_motion_rest(motion, position);
    append_brake(motion, &position, &velocity, deceleration);
    motion->end_position = position;
}

/* Towards a target that lies ahead, slow enough to stop before it. `way` is 1 or -1. */
static void append_trapezoid(sim_motion_t *motion, double *position, double *velocity, double target, double way,
                             double speed, double acceleration, double deceleration)
{
    const double distance = fabs(target - *position);
    const double start = fabs(*velocity);
    /* Peak of a triangle: (peak^2 - start^2) / 2 acceleration + peak^2 / 2 deceleration = distance. */
    const double triangle =
        sqrt((2.0 * distance * acceleration + start * start) * deceleration / (acceleration + deceleration));
    const double peak = (triangle < speed) ? triangle : speed;
    const double change = (peak >= start) ? acceleration : deceleration;
    const double ramp = fabs(peak * peak - start * start) / (2.0 * change);
    const double cruise = distance - ramp - peak * peak / (2.0 * deceleration);
    append(motion, fabs(peak - start) / change, position, velocity, (peak >= start) ? way * change : -way * change);
    if (cruise > 0.0) {
        append(motion, cruise / peak, position, velocity, 0.0);
    }
    append(motion, peak / deceleration, position, velocity, -way * deceleration);
}

void sim_motion_move(sim_motion_t *motion, double position, double velocity, double target, double speed,
                     double acceleration, double deceleration)
{
    assert(speed > 0.0 && acceleration > 0.0 && deceleration > 0.0);
    sim_motion_rest(motion, position);
    const double braking = velocity * fabs(velocity) / (2.0 * deceleration);
    const double way = (target >= position) ? 1.0 : -1.0;
    if (way * velocity < 0.0 || fabs(braking) > fabs(target - position)) {
        append_brake(motion, &position, &velocity, deceleration);
    }
    if (position != target) {
        append_trapezoid(motion, &position, &velocity, target, (target > position) ? 1.0 : -1.0, speed, acceleration,
                         deceleration);
    }
    motion->end_position = target;
}

void sim_motion_at(const sim_motion_t *motion, double time_s, double *position, double *velocity)
{
    if (time_s >= motion->end_s) {
        *position = motion->end_position;
        *velocity = 0.0;
        return;
    }
    uint32_t i = motion->count - 1U;
    while (i > 0U && motion->pieces[i].start_s > time_s) {
        i--;
    }
    const sim_motion_piece_t *const piece = &motion->pieces[i];
    const double t = time_s - piece->start_s;
    *position = piece->position + (piece->velocity + 0.5 * piece->acceleration * t) * t;
    *velocity = piece->velocity + piece->acceleration * t;
}
