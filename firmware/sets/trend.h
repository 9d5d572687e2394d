/* trend.h - how a coefficient drifts: a weighted straight line through its values over time. Pure functions.
 *
 * Each value weighs (u of the first / u)^2. Means and sums of products are carried along (West, Comm. ACM 22, 1979, 532), relative to the
 * first date, so nothing cancels. The uncertainty of the drift is that of independent values; what all calibrations on
 * one stand have in common does not make a drift, and then it is stated too large, not too small.
 */
#ifndef TUMBLE_SETS_TREND_H
#define TUMBLE_SETS_TREND_H

#include "tumble/status.h"

#include <stdint.h>

#define TUMBLE_MONTH_S 2629746.0 /* a twelfth of a Gregorian year of 365.2425 days */

/* Begun as all zero. */
typedef struct {
    uint64_t first_utc_s;
    double first_value;
    double unit; /* u of the first value, which weighs 1 */
    double weight;
    double mean_month;
    double mean_value;
    double month_month; /* weighted sums of products of deviations from the means */
    double month_value;
    double value_value;
    uint32_t count;
} tumble_trend_sums_t;

typedef struct {
    double per_month;     /* unit of the values per TUMBLE_MONTH_S */
    double u_per_month;   /* its standard uncertainty, from those of the values */
    double chi_squared;   /* of the line; `freedom` where the uncertainties are right and the drift is a line */
    uint32_t freedom;     /* values - 2 */
} tumble_trend_t;

/* One more value, in any order of time. Returns TUMBLE_OK; _ARGUMENT (null, date 0, or u not above 0); _NOT_FINITE
 * (the value, or u, no number or beyond 1e100 in magnitude, or u below 1e-100). */
tumble_status_t tumble_trend_add(tumble_trend_sums_t *sums, uint64_t date_utc_s, double value, double u);

/* Returns TUMBLE_OK; _ARGUMENT (null); _TOO_FEW (fewer than two values, or all of one date); _NOT_FINITE (overflow). */
tumble_status_t tumble_trend_fit(const tumble_trend_sums_t *sums, tumble_trend_t *trend);

#endif
