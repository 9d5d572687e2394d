/* views.h - what the present run tells about its stand, for the object dictionary (tumble/core.h): the errors of the stand,
 * and its inclinations (tumble_uncertainty_inclinations).
 *
 * For boards that have the memory and the time: some 4 kB of RAM for the errors, and once a result a few generalised
 * least-squares fits of all positions in double precision; for the inclinations of boards that lend the estimator
 * `inclined` and declare their stand, as much work as one uncertainty for each. It is done when somebody asks for it, between
 * runs. A board that names neither function nor memory (tumble_keeper_config_t) links none of it.
 */
#ifndef TUMBLE_NAVCOMP_VIEWS_H
#define TUMBLE_NAVCOMP_VIEWS_H

#include "core/means.h"
#include "tumble/core.h"
#include "tumble/navcomp.h"

/* Of which run a view is, and of which of its results: positions finished so far, and 1. An NMT reset zeroes them. */
typedef struct {
    uint32_t run_number;
    uint32_t looked_at;
} tumble_view_mark_t;

/* Quantities, each with its standard uncertainty: alpha1, alpha2 + alpha3, difference of alpha3, alpha4 (rad), noise of
 * a sample (V). */
#define TUMBLE_STAND_VIEW_QUANTITIES 5U
typedef struct {
    double number[2U * TUMBLE_STAND_VIEW_QUANTITIES];
    bool known[TUMBLE_STAND_VIEW_QUANTITIES]; /* else both numbers are 0 */
} tumble_stand_view_t;

/* The board's, all zero at power-on; private but for its size. So is the other. */
typedef struct {
    tumble_fit_work_t work;
    tumble_means_t means;
    tumble_random_errors_t errors;
    tumble_stand_view_t view;
    tumble_view_mark_t mark;
} tumble_stand_memory_t;

/* The view of the present result; the errors of set angles as declared (navcomp->config->declared), or as the run
 * itself shows them. Of `inclined` the noise alone: its stand is not inclined as the schedule has it. Null while there is no
 * result. */
const tumble_stand_view_t *tumble_stand_view(const tumble_navcomp_t *navcomp, tumble_stand_memory_t *memory);

/* Likewise: inclinations (deg), as tumble_inclined_map_t has them, and the error of the level axis (rad). */
#define TUMBLE_INCLINATIONS_VIEW_QUANTITIES (TUMBLE_MAX_YAWS + 1U)
typedef struct {
    double number[2U * TUMBLE_INCLINATIONS_VIEW_QUANTITIES];
    bool known[TUMBLE_INCLINATIONS_VIEW_QUANTITIES];
} tumble_inclinations_view_t;

typedef struct {
    tumble_inclinations_view_t view;
    tumble_view_mark_t mark;
} tumble_inclinations_memory_t;

/* The view of the present result; with nothing known in it where the run refuses that. Ask before another estimator is
 * written for the next run. Null while there is no result, while the configured estimator is another, and where no stand is
 * declared. */
const tumble_inclinations_view_t *tumble_inclinations_view(const tumble_navcomp_t *navcomp,
                                                           tumble_inclinations_memory_t *memory);

#endif
