#include "core/arith.h"
#include "core/coefficient.h"

#include <stddef.h>

/* Is the temperature within a range that is one? */
static tumble_status_t check(const tumble_thermal_t *thermal, double temperature_c)
{
    if (!tumble_is_finite(temperature_c) || !tumble_is_finite(thermal->lowest_c) ||
        !tumble_is_finite(thermal->highest_c)) {
        return TUMBLE_E_NOT_FINITE;
    }
    const bool outside =
        tumble_exceeds(thermal->lowest_c, temperature_c) || tumble_exceeds(temperature_c, thermal->highest_c);
    return outside ? TUMBLE_E_ARGUMENT : TUMBLE_OK;
}

tumble_status_t tumble_thermal_at(const tumble_thermal_t *thermal, double temperature_c,
                                  tumble_coefficients_t *coefficients)
{
    if ((thermal == NULL) || (coefficients == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_status_t status = check(thermal, temperature_c);
    const double kelvin = temperature_c - thermal->reference_c;
    tumble_coefficients_t found;
    for (int c = 0; (c < TUMBLE_COEFFICIENTS) && (status == TUMBLE_OK); c++) {
        double sum = 0.0;
        for (int m = TUMBLE_THERMAL_POWERS - 1; m >= 0; m--) {
            sum = (sum * kelvin) + tumble_coefficient(&thermal->power[m], c);
        }
        tumble_put_coefficient(&found, c, sum);
        status = tumble_is_finite(sum) ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
    }
    if (status == TUMBLE_OK) {
        *coefficients = found;
    }
    return status;
}

tumble_status_t tumble_thermal_calibration(const tumble_thermal_t *thermal, double temperature_c,
                                           tumble_calibration_t *calibration)
{
    tumble_coefficients_t coefficients;
    const tumble_status_t status = tumble_thermal_at(thermal, temperature_c, &coefficients);
    return (status == TUMBLE_OK) ? tumble_calibration_invert(&coefficients, calibration) : status;
}

/* One coefficient: how far it moves by this difference between run and polynomial, and its uncertainty after that. */
static tumble_status_t move(double difference, double u_prior, double growth, double u_run, double moved[2])
{
    if (tumble_is_positive(-u_prior) || tumble_is_positive(-growth) || tumble_is_positive(-u_run)) {
        return TUMBLE_E_ARGUMENT;
    }
    const double prior = tumble_square(u_prior) + tumble_square(growth);
    const double run = tumble_square(u_run);
    const double both = prior + run;
    if (tumble_within(both, 0.0)) {
        return TUMBLE_E_ARGUMENT;
    }
    moved[0] = (prior / both) * difference;
    moved[1] = ((run / both) * tumble_sqrt(prior)) + ((prior / both) * u_run);
    return tumble_is_finite(moved[0] + moved[1]) ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
}

tumble_status_t tumble_thermal_update(tumble_thermal_t *thermal, tumble_uncertainty_t *uncertainty,
                                      const tumble_uncertainty_t *growth, const tumble_thermal_run_t *run)
{
    if ((thermal == NULL) || (uncertainty == NULL) || (growth == NULL) || (run == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if ((run->coefficients == NULL) || (run->uncertainty == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_coefficients_t there;
    tumble_status_t status = tumble_thermal_at(thermal, run->temperature_c, &there);
    tumble_coefficients_t constant;
    tumble_uncertainty_t u;
    for (int c = 0; (c < TUMBLE_COEFFICIENTS) && (status == TUMBLE_OK); c++) {
        double moved[2] = {0.0, 0.0};
        const double difference = tumble_coefficient(run->coefficients, c) - tumble_coefficient(&there, c);
        status = move(difference, tumble_coefficient(uncertainty, c), tumble_coefficient(growth, c),
                      tumble_coefficient(run->uncertainty, c), moved);
        tumble_put_coefficient(&constant, c, tumble_coefficient(&thermal->power[0], c) + moved[0]);
        tumble_put_coefficient(&u, c, moved[1]);
    }
    if (status == TUMBLE_OK) {
        thermal->power[0] = constant;
        *uncertainty = u;
    }
    return status;
}
