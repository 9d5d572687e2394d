/* keeper_rules_harness.c - the commit rules on cases from stdin, one a line, numbers in hexadecimal; their objections on
 * stdout, a line each.
 *
 *     12 values and 12 uncertainties of the candidate, the same of the active set, 12 limits of uncertainty, drift a month
 *     and drift a kelvin each, coverage, dates of both, temperatures of both (degrees C)
 */
#include "tumble/sets.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double number(void)
{
    char word[64];
    if (scanf("%63s", word) != 1) {
        exit(0);
    }
    return strtod(word, NULL);
}

static void read_coefficients(double k[3][3], double u0[3])
{
    for (int c = 0; c < 12; c++) {
        *((c < 9) ? &k[c / 3][c % 3] : &u0[c - 9]) = number();
    }
}

static tumble_set_t read_set(void)
{
    tumble_set_t set = {.flags = TUMBLE_SET_HAS_UNCERTAINTY | TUMBLE_SET_HAS_CHECK | TUMBLE_SET_HAS_TEMPERATURE,
                        .block_serial = "TB-0001",
                        .limit_g = 1.0,
                        .fit_positions = 18};
    read_coefficients(set.coefficients.k_v_per_g, set.coefficients.u0_v);
    read_coefficients(set.uncertainty.k_v_per_g, set.uncertainty.u0_v);
    return set;
}

static void read_limits(float limits[12])
{
    for (int c = 0; c < 12; c++) {
        limits[c] = (float)number();
    }
}

int main(void)
{
    for (;;) {
        tumble_commit_limits_t limits = {.flags = TUMBLE_COMMIT_BY_ITSELF};
        tumble_set_t candidate = read_set();
        tumble_set_t active = read_set();
        read_limits(limits.uncertainty);
        read_limits(limits.drift_per_month);
        read_limits(limits.drift_per_kelvin);
        limits.coverage = (float)number();
        candidate.date_utc_s = (uint64_t)number();
        active.date_utc_s = (uint64_t)number();
        candidate.temperature_c = number();
        active.temperature_c = number();
        (void)printf("%u\n", tumble_commit_objections(&candidate, &active, &limits, false));
    }
}
