/* resident_keeper.c - what a navigation computer with non-volatile memory keeps besides, for the budget: the keeper, and
 * how it reaches the uncertainties. The memory itself is the board's own.
 */
#include "navcomp/keeper.h"
#include "navcomp/uncertainty.h"

extern const tumble_keeper_config_t tumble_resident_keeper_config;
extern const tumble_keeping_t *const tumble_resident_keeping;

const tumble_keeper_config_t tumble_resident_keeper_config = {.uncertainty = tumble_navcomp_uncertainty,
                                                              .norm = tumble_navcomp_norm};
const tumble_keeping_t *const tumble_resident_keeping = &tumble_keeper_calls;
tumble_keeper_t tumble_resident_keeper;
