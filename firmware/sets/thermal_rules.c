/* What a run at one temperature makes of an active set with slopes. */
#include "core/arith.h"
#include "core/coefficient.h"
#include "sets/record.h"
#include "sets/rules.h"

#define NEAR_SIGMAS 3.0
#define ROUNDING 1e-6 /* of single precision, and more */

static double temperature_of(const tumble_set_t *run)
{
    return ((run->flags & TUMBLE_SET_HAS_TEMPERATURE) != 0U) ? run->temperature_c : (double)NAN;
}

/* Was the set made of this very run? Noise makes the gravity check of every run another, to the last bit. The coefficients
 * of both are then near; so a run that only looks the same, and is not, would not have changed much. */
static bool is_of_run(const tumble_set_t *set, const tumble_set_t *run)
{
    bool same = ((run->flags & set->flags & TUMBLE_SET_HAS_CHECK) != 0U) &&
                tumble_within(run->max_abs_fit_g - set->max_abs_fit_g, 0.0) &&
                tumble_within(run->max_abs_check_g - set->max_abs_check_g, 0.0) &&
                tumble_within(run->closure_v - set->closure_v, 0.0);
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double difference = tumble_coefficient(&run->coefficients, c) - tumble_coefficient(&set->coefficients, c);
        const double near =
            (NEAR_SIGMAS * tumble_coefficient(&set->uncertainty, c)) + (ROUNDING * tumble_commit_length(run, c));
        same = same && tumble_within(difference, near);
    }
    return same;
}

static uint32_t bring(tumble_thermal_sets_t *sets, const tumble_store_t *store, const tumble_set_t *run,
                      tumble_set_t *set)
{
    sets->moves = false;
    if (!tumble_store_has(store, TUMBLE_SET_ACTIVE) || ((set->flags & TUMBLE_SET_HAS_SLOPES) == 0U)) {
        return 0;
    }
    tumble_thermal_from_record(store->bytes, set, &sets->thermal);
    sets->uncertainty = set->uncertainty;
    sets->is_known = ((set->flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U);
    sets->date_utc_s = set->date_utc_s;
    sets->moves = (tumble_thermal_at(&sets->thermal, temperature_of(run), &set->coefficients) == TUMBLE_OK);
    if (sets->moves && is_of_run(set, run)) {
        set->coefficients = run->coefficients;
    }
    return sets->moves ? 0U : TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_TEMPERATURE);
}

/* Of what the run and the polynomials say together; or else of the run alone: as if it were certain, and anything might
 * have changed. */
static void make(tumble_thermal_sets_t *sets, tumble_store_t *store, const tumble_set_t *run,
                 const tumble_commit_limits_t *limits)
{
    tumble_set_t made = *run;
    tumble_uncertainty_t growth;
    const bool change = (run->reasons & TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE)) != 0U;
    const bool both = sets->is_known && !change && ((run->flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U);
    const tumble_thermal_run_t there = {run->temperature_c, &run->coefficients, &made.uncertainty};
    const double months = tumble_commit_months(run->date_utc_s, sets->date_utc_s);
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        tumble_put_coefficient(
            &growth, c, both ? ((double)limits->drift_per_month[c] * months * tumble_commit_length(run, c)) : 1.0);
        if (!both) {
            tumble_put_coefficient(&sets->uncertainty, c, 0.0);
            tumble_put_coefficient(&made.uncertainty, c, 0.0);
        }
    }
    if (tumble_thermal_update(&sets->thermal, &sets->uncertainty, &growth, &there) == TUMBLE_OK) {
        made.uncertainty = both ? sets->uncertainty : run->uncertainty;
        (void)tumble_thermal_put(store, &made, &sets->thermal);
    }
}

static uint32_t bring_or_make(tumble_thermal_sets_t *sets, tumble_store_t *store, const tumble_set_t *run,
                              const tumble_commit_limits_t *limits, tumble_set_t *set)
{
    if (set != NULL) {
        return bring(sets, store, run, set);
    }
    if (sets->moves && (store->cells.plan != NULL)) {
        make(sets, store, run, limits);
    }
    return 0;
}

void tumble_thermal_sets_init(tumble_thermal_sets_t *sets)
{
    *sets = (tumble_thermal_sets_t){.read_set = tumble_thermal_read_set, .consult = bring_or_make};
}
