/* coefficient.h - the twelve coefficients by their number: K row by row, then U0 (private to the firmware).
 *
 * So a loop over all twelve needs no separate cases for K and U0.
 */
#ifndef TUMBLE_CORE_COEFFICIENT_H
#define TUMBLE_CORE_COEFFICIENT_H

#include "tumble/core.h"

#include <assert.h>
#include <stddef.h>
#include <string.h>

static_assert((sizeof(tumble_coefficients_t) == (TUMBLE_COEFFICIENTS * sizeof(double))) &&
                  (sizeof(tumble_uncertainty_t) == sizeof(tumble_coefficients_t)) &&
                  (offsetof(tumble_coefficients_t, k_v_per_g) == 0U) &&
                  (offsetof(tumble_uncertainty_t, k_v_per_g) == 0U),
              "the members lie in the order of the numbers");

/* One of a tumble_coefficients_t, or of a tumble_uncertainty_t. */
static inline double tumble_coefficient(const void *twelve, int c)
{
    double one;
    (void)memcpy(&one, (const uint8_t *)twelve + ((size_t)c * sizeof one), sizeof one);
    return one;
}

static inline void tumble_put_coefficient(void *twelve, int c, double one)
{
    (void)memcpy((uint8_t *)twelve + ((size_t)c * sizeof one), &one, sizeof one);
}

#endif
