/* inclinations_view.h - what the present run says of the inclinations of its stand, for the object dictionary
 * (tumble_uncertainty_inclinations in tumble/core.h).
 *
 * For boards that lend the estimator `inclined` and declare their stand. It is done when somebody asks for it, once a
 * result, between runs: as much work as one uncertainty for each inclination. A board that names neither function nor
 * memory (tumble_keeper_config_t) links none of it.
 */
#ifndef TUMBLE_NAVCOMP_INCLINATIONS_VIEW_H
#define TUMBLE_NAVCOMP_INCLINATIONS_VIEW_H

#include "tumble/core.h"
#include "tumble/navcomp.h"

#include <stdbool.h>
#include <stdint.h>

/* Quantities, each with its standard uncertainty: inclinations (deg), as tumble_inclined_map_t has them, and the error of
 * the level axis (rad). */
#define TUMBLE_INCLINATIONS_VIEW_QUANTITIES (TUMBLE_MAX_YAWS + 1U)
typedef struct tumble_inclinations_view {
    double number[2U * TUMBLE_INCLINATIONS_VIEW_QUANTITIES];
    bool known[TUMBLE_INCLINATIONS_VIEW_QUANTITIES]; /* else both numbers are 0 */
} tumble_inclinations_view_t;

/* The board's, all zero at power-on; private but for its size. */
typedef struct tumble_inclinations_memory {
    tumble_inclinations_view_t view;
    uint32_t run_number; /* of which result the view is, as in tumble_stand_memory_t */
    uint32_t looked_at;
} tumble_inclinations_memory_t;

/* The view of the present result; with nothing known in it where the run refuses that. Ask before another estimator is
 * written for the next run. Null while there is no result, while the configured estimator is another, and where no stand is
 * declared. */
const tumble_inclinations_view_t *tumble_inclinations_view(const tumble_navcomp_t *navcomp,
                                                           tumble_inclinations_memory_t *memory);

#endif
