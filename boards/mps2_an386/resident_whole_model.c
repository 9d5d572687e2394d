/* resident_whole_model.c - what a navigation computer keeps that also tests the whole model, for the budget: as
 * resident_keeper.c, and the memory of the test.
 */
#include "navcomp/keeper.h"
#include "navcomp/uncertainty.h"

extern const tumble_keeper_config_t tumble_resident_keeper_config;
extern const tumble_keeping_t *const tumble_resident_keeping;

static tumble_whole_work_t whole_work;
const tumble_keeper_config_t tumble_resident_keeper_config = {
    .sets = {.whole_step = tumble_whole_step, .whole_work = &whole_work},
    .uncertainty = tumble_navcomp_uncertainty,
    .norm = tumble_navcomp_norm,
};
const tumble_keeping_t *const tumble_resident_keeping = &tumble_keeper_calls;
tumble_keeper_t tumble_resident_keeper;
