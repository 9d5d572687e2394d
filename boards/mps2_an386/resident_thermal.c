/* resident_thermal.c - what a navigation computer keeps that also keeps sets with slopes, for the budget: as
 * resident_keeper.c, and the memory for one of them.
 */
#include "navcomp/keeper.h"
#include "navcomp/uncertainty.h"

extern const tumble_keeper_config_t tumble_resident_keeper_config;
extern const tumble_keeping_t *const tumble_resident_keeping;

static tumble_thermal_sets_t thermal_sets;
const tumble_keeper_config_t tumble_resident_keeper_config = {
    .sets = {.thermal = &thermal_sets},
    .uncertainty = tumble_navcomp_uncertainty,
    .norm = tumble_navcomp_norm,
};
const tumble_keeping_t *const tumble_resident_keeping = &tumble_keeper_calls;
tumble_keeper_t tumble_resident_keeper;
