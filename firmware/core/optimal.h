/* optimal.h - the stand-optimal estimator: constant gains for one stand, twice corrected to second order.
 *
 * The gains of a record (gain_record.h) are those of generalised least squares for the stand's declared errors: twelve rows
 * for the coefficients, further rows for the errors that a run shares (axis tilt, level, yaws). They are linear; the
 * outputs are not, and on a stand with a yaw of 15 mrad a linear estimate of K_xx is off by 16 times its uncertainty. So
 * what the exact geometry gives beyond its linearisation is taken out of the means and the gains are applied again, twice:
 * docs/method.md, "stand-optimal weights". Pure functions; no libm, nothing allocated, nothing kept, the record is used
 * where it lies.
 */
#ifndef TUMBLE_CORE_OPTIMAL_H
#define TUMBLE_CORE_OPTIMAL_H

#include "core/estimator.h"
#include "core/gain_record.h"
#include "core/limits.h"
#include "core/schedule.h"
#include "core/status.h"

/* The series for sine and cosine are exact to a double's last bits up to here. No stand is that bad. */
#define TUMBLE_MAX_STAND_ERROR_RAD 0.1

/* What the run tells about the stand, best estimates (rad); an error that the record calls absent is 0. */
typedef struct {
    double alpha1_rad;
    double alpha2_rad;
    double alpha3_rad[TUMBLE_MAX_MOUNTINGS]; /* per mounting of the schedule, in its order; beyond: 0 */
} tumble_stand_errors_t;

/* What the estimator works with beside its stack; the caller owns it. */
typedef struct {
    tumble_stand_errors_t stand;               /* a result, beside the coefficients */
    float curvature_rad[TUMBLE_MAX_POSITIONS]; /* private */
} tumble_optimal_t;

static_assert(sizeof(tumble_optimal_t) <= 208, "a navigation computer with the estimator must stay within 4 kB of RAM");

/* Coefficients and the stand's errors from the means of all fit positions. `record` was opened for this very schedule.
 * Outputs are working memory too: on _STAND_ERROR, and where a result is not finite, they are left zero.
 * Returns TUMBLE_OK, _ARGUMENT (null), _NOT_FINITE (a measured mean that is not a number or beyond TUMBLE_MAX_MEAN_V, or a
 * result that is not finite), _GAIN_TABLE (the record has another number of fit positions or mountings than the schedule),
 * _MISSING_POSITION (a fit position was not measured), _STAND_ERROR (an error of the stand, or of one table angle with
 * alpha2, or its curvature, comes out beyond TUMBLE_MAX_STAND_ERROR_RAD: wrong record, mounting or means). */
tumble_status_t tumble_estimate_optimal(const tumble_gain_record_t *record, const tumble_schedule_t *schedule,
                                        const tumble_means_t *means, tumble_coefficients_t *coefficients,
                                        tumble_optimal_t *optimal);

/* The estimator for a procedure that knows no records: where the record is mapped, and the memory to work with. */
typedef struct {
    const void *record;
    size_t record_bytes; /* of the memory; the record may be shorter */
    tumble_optimal_t *work;
} tumble_optimal_source_t;

/* Is there a right record? `source`: a tumble_optimal_source_t. Returns as tumble_gain_record_open. */
tumble_status_t tumble_optimal_check(const void *source, const tumble_schedule_t *schedule);

/* Check the record again, whole, and estimate. Returns as tumble_gain_record_open and tumble_estimate_optimal; on any
 * refusal `coefficients` holds no result. */
tumble_status_t tumble_optimal_estimate(const void *source, const tumble_schedule_t *schedule,
                                        const tumble_means_t *means, tumble_coefficients_t *coefficients);

#endif
