/* fixed.h - the numbers of one channel as whole numbers (private to the core).
 *
 * The closed forms add many means and multiply by few constants. Without floating point hardware an addition of doubles
 * takes twenty times the instructions of one of integers. So the numbers of a channel are taken in one unit, such that the
 * largest has 53 or 54 bits: it stays what it is, no other loses more than half a bit of its last one, and sums are exact.
 */
#ifndef TUMBLE_CORE_FIXED_H
#define TUMBLE_CORE_FIXED_H

#include <stdint.h>

#define TUMBLE_FIXED_WHOLE 1076U /* the scale whose unit is 1 */

/* The scale for numbers up to the one with these bits, without its sign: it is the exponent of that double, so the unit is
 * 2^(scale - 1076). Where all are below 2^-959 it is larger, and they count as 0. */
uint32_t tumble_fixed_scale(uint64_t bits);

double tumble_fixed_unit(uint32_t scale);

/* x in units of a scale that fits it, to nearest: below 2^54 in size. */
int64_t tumble_fixed_of(double x, uint32_t scale);

/* a b / 2^53, to nearest: a times b as a factor. a up to 2^59, b up to 2^55 in size. */
int64_t tumble_fixed_product(int64_t a, int64_t b);

/* a times a factor below 2 in size, to nearest. a up to 2^59 in size. */
int64_t tumble_fixed_times(int64_t a, double factor);

#endif
