#include "sets/rules.h"

#include "core/arith.h"
#include "core/coefficient.h"
#include "core/vector.h"

#include <stddef.h>
#include <string.h>

#define ROWS_END (TUMBLE_CHANNELS * TUMBLE_CHANNELS) /* behind the coefficients of K come those of U0 */
#define MAX_RATIO 1.0
#define MIN_COVERAGE 1.0
#define MAX_COVERAGE 10.0

static double value_of(const tumble_set_t *set, int c)
{
    return tumble_coefficient(&set->coefficients, c);
}

/* 0 where it is not known. */
static double uncertainty_of(const tumble_set_t *set, int c)
{
    return ((set->flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U) ? tumble_coefficient(&set->uncertainty, c) : 0.0;
}

double tumble_commit_length(const tumble_set_t *set, int c)
{
    const double *row = set->coefficients.k_v_per_g[(c < ROWS_END) ? (c / TUMBLE_CHANNELS) : (c - ROWS_END)];
    return tumble_sqrt(tumble_dot(row, row));
}

/* The limits. */

/* Compare as doubles, by functions: comparing floats would link another part of the library. */
static bool is_ratio(float limit)
{
    return tumble_within((double)limit, MAX_RATIO) && !tumble_is_positive(-(double)limit);
}

bool tumble_commit_limits_valid(const tumble_commit_limits_t *limits)
{
    const double coverage = (double)limits->coverage;
    bool valid = tumble_within(coverage, MAX_COVERAGE) && !tumble_is_positive(MIN_COVERAGE - coverage) &&
                 ((limits->flags & ~(unsigned)(TUMBLE_COMMIT_BY_ITSELF | TUMBLE_COMMIT_FIRST)) == 0U);
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        valid = valid && is_ratio(limits->uncertainty[c]) && tumble_is_positive((double)limits->uncertainty[c]) &&
                is_ratio(limits->drift_per_month[c]) && is_ratio(limits->drift_per_kelvin[c]);
    }
    return valid;
}

/* The candidate by itself. */

static bool passes_gravity_check(const tumble_set_t *set)
{
    return ((set->flags & TUMBLE_SET_HAS_CHECK) != 0U) && ((set->fit_positions + set->check_positions) > 0) &&
           tumble_is_positive(set->limit_g) && tumble_within(set->max_abs_fit_g, set->limit_g) &&
           tumble_within(set->max_abs_check_g, set->limit_g);
}

static bool is_finite(const tumble_set_t *set)
{
    bool finite = true;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double u = uncertainty_of(set, c);
        finite = finite && tumble_is_finite(value_of(set, c)) && tumble_is_positive(tumble_commit_length(set, c)) &&
                 tumble_is_finite(u) && !tumble_is_positive(-u);
    }
    return finite;
}

static unsigned object_if(bool objects, tumble_objection_t objection)
{
    return objects ? TUMBLE_OBJECTION_BIT(objection) : 0U;
}

static unsigned judge_alone(const tumble_set_t *candidate)
{
    return object_if(!passes_gravity_check(candidate), TUMBLE_OBJECTION_GRAVITY_CHECK) |
           object_if(!is_finite(candidate), TUMBLE_OBJECTION_NOT_FINITE) |
           object_if((candidate->flags & TUMBLE_SET_HAS_UNCERTAINTY) == 0U, TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN);
}

static bool is_certain(const tumble_set_t *candidate, const tumble_commit_limits_t *limits)
{
    bool certain = true;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double allowed = (double)limits->uncertainty[c] * tumble_commit_length(candidate, c);
        certain = certain && tumble_within(uncertainty_of(candidate, c), allowed);
    }
    return certain;
}

/* The candidate and the active set. */

static bool are_dated(const tumble_set_t *candidate, const tumble_set_t *active)
{
    return (candidate->date_utc_s != 0U) && (active->date_utc_s != 0U);
}

double tumble_commit_months(uint64_t later_utc_s, uint64_t earlier_utc_s)
{
    double months = 1.0;
    if ((earlier_utc_s != 0U) && (later_utc_s > earlier_utc_s)) {
        months = tumble_larger((double)(later_utc_s - earlier_utc_s) / TUMBLE_MONTH_S, months);
    }
    return tumble_exceeds(TUMBLE_COMMIT_MAX_MONTHS, months) ? months : TUMBLE_COMMIT_MAX_MONTHS;
}

static double kelvin_between(const tumble_set_t *candidate, const tumble_set_t *active)
{
    const unsigned both = (unsigned)candidate->flags & active->flags;
    return ((both & TUMBLE_SET_HAS_TEMPERATURE) != 0U) ? tumble_abs(candidate->temperature_c - active->temperature_c)
                                                       : 0.0;
}

static bool is_plausible(const tumble_set_t *candidate, const tumble_set_t *active,
                         const tumble_commit_limits_t *limits)
{
    const double months = tumble_commit_months(candidate->date_utc_s, active->date_utc_s);
    const double kelvin = kelvin_between(candidate, active);
    bool plausible = true;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double u_new = uncertainty_of(candidate, c);
        const double u_old = uncertainty_of(active, c);
        const double drift =
            ((double)limits->drift_per_month[c] * months) + ((double)limits->drift_per_kelvin[c] * kelvin);
        const double allowed = ((double)limits->coverage * tumble_sqrt((u_new * u_new) + (u_old * u_old))) +
                               (drift * tumble_commit_length(candidate, c));
        plausible = plausible && tumble_within(value_of(candidate, c) - value_of(active, c), allowed);
    }
    return plausible;
}

static unsigned compare(const tumble_set_t *candidate, const tumble_set_t *active)
{
    const bool same_block =
        (memcmp(candidate->block_serial, active->block_serial, sizeof candidate->block_serial) == 0);
    const bool older = are_dated(candidate, active) && (candidate->date_utc_s < active->date_utc_s);
    return object_if(!same_block, TUMBLE_OBJECTION_OTHER_BLOCK) | object_if(older, TUMBLE_OBJECTION_OLDER);
}

/* What the limits say of numbers that are numbers. */
static unsigned judge_by_limits(const tumble_set_t *candidate, const tumble_set_t *active,
                                const tumble_commit_limits_t *limits)
{
    const bool plausible = (active == NULL) || is_plausible(candidate, active, limits);
    return object_if(!is_certain(candidate, limits), TUMBLE_OBJECTION_UNCERTAIN) |
           object_if(!plausible, TUMBLE_OBJECTION_CHANGE);
}

uint16_t tumble_commit_objections(const tumble_set_t *candidate, const tumble_set_t *active,
                                  const tumble_commit_limits_t *limits, bool replayed)
{
    unsigned objections = judge_alone(candidate);
    const bool valid = tumble_commit_limits_valid(limits);
    if (valid && ((objections & TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NOT_FINITE)) == 0U)) {
        objections |= judge_by_limits(candidate, active, limits);
    }
    objections |= (active != NULL) ? compare(candidate, active)
                                   : object_if((limits->flags & TUMBLE_COMMIT_FIRST) == 0U, TUMBLE_OBJECTION_FIRST);
    objections |= object_if(replayed, TUMBLE_OBJECTION_REPLAYED);
    objections |= object_if(!valid, TUMBLE_OBJECTION_LIMITS);
    objections |= object_if((limits->flags & TUMBLE_COMMIT_BY_ITSELF) == 0U, TUMBLE_OBJECTION_BY_HAND);
    return (uint16_t)objections;
}
