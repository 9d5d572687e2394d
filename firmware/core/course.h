/* course.h - errors that follow the table angle or the course of a run (private to the core).
 *
 *     encoder    a table angle t is off by n0 sin t + n1 cos t + n2 sin 2t + n3 cos 2t, in all mountings alike
 *     drift      channel i gives d_i x more, x growing from -1/2 at the first measured fit position to 1/2 at the last,
 *                by the same step from each to the next
 */
#ifndef TUMBLE_CORE_COURSE_H
#define TUMBLE_CORE_COURSE_H

#include "tumble/core.h"

#include <stdbool.h>

/* What a unit of each number of the encoder adds to a table angle. */
void tumble_course_waves(const tumble_angle_t *angle, double wave[TUMBLE_WAVES]);

/* The error of a table angle, rad, from the numbers of the encoder, rad. */
double tumble_course_angle_error(const tumble_angle_t *angle, const double numbers[TUMBLE_WAVES]);

/* x of the fit position number `fit`, from 0, of so many. */
double tumble_course_of(uint8_t fit, uint8_t fit_positions);

/* x of the measured fit position `p` of the schedule. `measured` may be null: all are. */
double tumble_course_at(const tumble_schedule_t *schedule, const bool *measured, uint8_t p);

/* How one coefficient answers to each number of the encoder, and to each drift. */
typedef struct {
    double by_wave[TUMBLE_WAVES];
    double by_drift[TUMBLE_CHANNELS];
} tumble_course_response_t;

/* Add the answer at the measured fit position `p`: by the gains `g` of its means, and by `turning`, what an error of its
 * table angle does. Errors that the run's stand does not declare are left out. */
void tumble_course_add(const tumble_judged_run_t *run, uint8_t p, double turning, const double g[TUMBLE_CHANNELS],
                       tumble_course_response_t *response);

/* Variance that encoder and drift bring to the coefficient. */
double tumble_course_variance(const tumble_stand_record_t *stand, const tumble_course_response_t *response);

#endif
