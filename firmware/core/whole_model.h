/* whole_model.h - what the files of the whole-model test share (private to the core).
 *
 *     whole_place.c    a position, linearised
 *     whole_model.c    the rounds of Gauss and Newton, in steps
 *     whole_run.c      the runs that are tested: from means all at once, from averages in steps
 */
#ifndef TUMBLE_CORE_WHOLE_MODEL_H
#define TUMBLE_CORE_WHOLE_MODEL_H

#include "tumble/core.h"

#include <stdbool.h>

/* Standard deviations of the stand's errors; 0: there is none. */
typedef struct {
    double shared_rad[TUMBLE_WHOLE_SHARED];
    double local_rad[TUMBLE_WHOLE_LOCAL]; /* of a mounting or an inclination */
    double course[TUMBLE_WHOLE_COURSE];   /* rad; V */
} tumble_whole_sigmas_t;

/* What a run says of a position. */
typedef struct {
    bool measured;
    double u_v[TUMBLE_CHANNELS];
    double variance_v2[TUMBLE_CHANNELS];
    double course; /* tumble_course_at; 0 where no drift is declared */
} tumble_whole_reading_t;

/* What is tested. */
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_stand_record_t *stand;
    uint8_t bolted; /* tumble_schedule_count_bolted: above 0, the mountings are inclinations */
} tumble_whole_model_t;

/* Standard deviations of the errors of a stand, at a mounting of the schedule. */
void tumble_whole_sigmas(const tumble_whole_model_t *model, uint8_t mounting, tumble_whole_sigmas_t *sigmas);

/* Linearise the position work->position of work->mounting where the round before ended, into work->place. */
void tumble_whole_linearise(const tumble_whole_model_t *model, const tumble_whole_reading_t *reading,
                            tumble_whole_work_t *work);

/* Begin a test with these coefficients. */
void tumble_whole_start(tumble_whole_work_t *work, const tumble_coefficients_t *coefficients);

/* Take one step. `reading`: of the position work->position, if there is one. False: that was the last step, and
 * chi_squared and freedom are there. */
bool tumble_whole_go_on(const tumble_whole_model_t *model, const tumble_whole_reading_t *reading,
                        tumble_whole_work_t *work);

#endif
