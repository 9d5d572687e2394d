/* optimal_uncertainty.h - what the stand-optimal estimator's own gains make of a stand's errors.
 *
 * Of the gains of a record, at the K that the record was made for: the second-order correction (optimal.h) makes up
 * for a block that differs from it, which a propagation through the old gains would overstate (docs/method.md).
 */
#ifndef TUMBLE_CORE_OPTIMAL_UNCERTAINTY_H
#define TUMBLE_CORE_OPTIMAL_UNCERTAINTY_H

#include "core/status.h"
#include "core/uncertainty.h"

/* `source`: a tumble_optimal_source_t. `run->coefficients` are not looked at, but may not be null. The record is
 * checked whole, unless `run->only` leaves out the first coefficient: then it has been, with that one. Returns as
 * tumble_gain_record_open and tumble_uncertainty_gains. */
tumble_status_t tumble_optimal_uncertainty(const void *source, const tumble_judged_run_t *run,
                                           tumble_uncertainty_t *uncertainty);

#endif
