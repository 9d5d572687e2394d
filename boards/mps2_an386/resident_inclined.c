/* resident_inclined.c - what a navigation computer with the estimator of inclinations keeps besides, for the budget: what
 * a run says of its inclinations, and how the procedure reaches the estimator.
 */
#include "tumble/core.h"
#include "tumble/navcomp.h"

extern const tumble_lent_t tumble_resident_lent;

static tumble_inclinations_t seen;
static const tumble_inclined_source_t source = {NULL, &seen};
const tumble_lent_t tumble_resident_lent = {.estimator = TUMBLE_ESTIMATE_INCLINED,
                                            .check = tumble_inclined_check,
                                            .estimate = tumble_inclined_estimate,
                                            .source = &source};
