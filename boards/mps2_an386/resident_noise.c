/* resident_noise.c - what a board that declares its stand lends besides, for the budget: memory for the noise of a run. The
 * stand itself is the board's own.
 */
#include "navcomp/uncertainty.h"

extern const tumble_declared_t tumble_resident_declared;

static tumble_run_noise_t noise;
const tumble_declared_t tumble_resident_declared = {.take = tumble_navcomp_take_noise, .noise = &noise};
