/* resident_optimal.c - what a navigation computer with the stand-optimal estimator keeps besides, for the budget: the
 * estimator's working memory, and how the procedure reaches it. The record is the board's own, in non-volatile memory.
 */
#include "tumble/core.h"
#include "tumble/navcomp.h"

extern const tumble_lent_t tumble_resident_lent;

static tumble_optimal_t work;
static const tumble_optimal_source_t source = {NULL, 0, &work};
const tumble_lent_t tumble_resident_lent = {.estimator = TUMBLE_ESTIMATE_OPTIMAL,
                                            .check = tumble_optimal_check,
                                            .estimate = tumble_optimal_estimate,
                                            .source = &source};
