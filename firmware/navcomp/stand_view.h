/* stand_view.h - what the present run tells about its stand, for the object dictionary (tumble/core.h).
 *
 * For boards that have the memory and the time: some 4 kB of RAM, and once a result a few generalised least-squares
 * fits of all positions in double precision. It is done when somebody asks for it, between runs. A board that names
 * neither function nor memory (tumble_keeper_config_t) links none of it.
 */
#ifndef TUMBLE_NAVCOMP_STAND_VIEW_H
#define TUMBLE_NAVCOMP_STAND_VIEW_H

#include "core/means.h"
#include "tumble/core.h"
#include "tumble/navcomp.h"

#include <stdbool.h>
#include <stdint.h>

/* Quantities, each with its standard uncertainty: alpha1, alpha2 + alpha3, difference of alpha3, alpha4 (rad), noise of
 * a sample (V). */
#define TUMBLE_STAND_VIEW_QUANTITIES 5U
typedef struct tumble_stand_view {
    double number[2U * TUMBLE_STAND_VIEW_QUANTITIES];
    bool known[TUMBLE_STAND_VIEW_QUANTITIES]; /* else both numbers are 0 */
} tumble_stand_view_t;

/* The board's, all zero at power-on; private but for its size. */
typedef struct tumble_stand_memory {
    tumble_fit_work_t work;
    tumble_means_t means;
    tumble_random_errors_t errors;
    tumble_stand_view_t view;
    uint32_t run_number; /* of which run the view is, */
    uint32_t looked_at;  /* and of which of its results: positions finished so far, and 1. An NMT reset zeroes them */
} tumble_stand_memory_t;

/* The view of the present result; the errors of set angles as declared (navcomp->config->declared), or as the run
 * itself shows them. Of `inclined` the noise alone: its stand is not inclined as the schedule has it
 * (navcomp/inclinations_view.h). Null while there is no result. */
const tumble_stand_view_t *tumble_stand_view(const tumble_navcomp_t *navcomp, tumble_stand_memory_t *memory);

#endif
