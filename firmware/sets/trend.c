#include "tumble/sets.h"

#include "core/arith.h"

#include <stddef.h>

#define LEAST_U 1e-100
#define GREATEST 1e100

/* Of a mean; and the sum of two is the place of their product. */
enum { MONTH, VALUE };

static bool is_above_zero(double u)
{
    return !tumble_is_positive(-u) && !tumble_within(u, 0.0);
}

static bool is_usable(double value, double u)
{
    return tumble_within(value, GREATEST) && tumble_within(u, GREATEST) && !tumble_exceeds(LEAST_U, u);
}

static double months_since(uint64_t first_utc_s, uint64_t date_utc_s)
{
    return (date_utc_s >= first_utc_s) ? ((double)(date_utc_s - first_utc_s) / TUMBLE_MONTH_S)
                                       : -((double)(first_utc_s - date_utc_s) / TUMBLE_MONTH_S);
}

tumble_status_t tumble_trend_add(tumble_trend_sums_t *sums, uint64_t date_utc_s, double value, double u)
{
    if ((sums == NULL) || (date_utc_s == 0U) || !is_above_zero(u)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!is_usable(value, u)) {
        return TUMBLE_E_NOT_FINITE;
    }
    if (sums->count == 0U) {
        sums->first_utc_s = date_utc_s;
        sums->first_value = value;
        sums->unit = u;
    }
    const double root_weight = sums->unit / u;
    const double weight = root_weight * root_weight;
    const double off[2] = {months_since(sums->first_utc_s, date_utc_s) - sums->mean[MONTH],
                           (value - sums->first_value) - sums->mean[VALUE]};
    sums->weight += weight;
    const double share = weight / sums->weight;
    const double both = weight * (1.0 - share); /* of a deviation from the mean before, times one from the mean after */
    for (int i = MONTH; i <= VALUE; i++) {
        sums->mean[i] += share * off[i];
        for (int j = i; j <= VALUE; j++) {
            sums->products[i + j] += both * off[i] * off[j];
        }
    }
    sums->count++;
    return TUMBLE_OK;
}

tumble_status_t tumble_trend_fit(const tumble_trend_sums_t *sums, tumble_trend_t *trend)
{
    if ((sums == NULL) || (trend == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if ((sums->count < 2U) || !tumble_exceeds(sums->products[MONTH + MONTH], 0.0)) {
        return TUMBLE_E_TOO_FEW;
    }
    const double slope = sums->products[MONTH + VALUE] / sums->products[MONTH + MONTH];
    const double u_slope = sums->unit / tumble_sqrt(sums->products[MONTH + MONTH]);
    const double left =
        (sums->products[VALUE + VALUE] - (slope * sums->products[MONTH + VALUE])) / (sums->unit * sums->unit);
    if (!tumble_is_finite(slope) || !tumble_is_finite(u_slope) || !tumble_is_finite(left)) {
        return TUMBLE_E_NOT_FINITE;
    }
    *trend = (tumble_trend_t){slope, u_slope, tumble_is_positive(left) ? left : 0.0, sums->count - 2U};
    return TUMBLE_OK;
}
