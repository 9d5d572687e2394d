/* keeper_values.h - the values behind the keeper's objects (keeper_objects.h): what they stand for, and their hooks.
 *
 * The structs here give an entry its place; the numbers are made when they are asked for.
 */
#ifndef TUMBLE_NAVCOMP_KEEPER_VALUES_H
#define TUMBLE_NAVCOMP_KEEPER_VALUES_H

#include "canopen/dictionary.h"
#include "navcomp/inclinations_view.h"
#include "navcomp/keeper.h"
#include "navcomp/stand_view.h"
#include "tumble/core.h"

/* A position of the schedule, and its mean. */
typedef struct {
    double mean_v[TUMBLE_CHANNELS];
    double standard_error_v[TUMBLE_CHANNELS];
    double angle_deg;
    uint32_t samples;
    uint8_t index; /* in the schedule */
    uint8_t count; /* of positions in the schedule */
    uint8_t mounting;
    uint8_t number;
    uint8_t use;
} tumble_position_view_t;

/* Of each coefficient, V/g or V a month. */
typedef struct {
    double per_month[TUMBLE_COEFFICIENTS];
    double u_per_month[TUMBLE_COEFFICIENTS];
} tumble_trend_view_t;

extern const tumble_object_hooks_t tumble_keeper_object_hooks;

/* The table and its hooks; their context is the tumble_navcomp_t, whose `keeper` is a tumble_keeper_t. */
extern const tumble_node_extension_t tumble_keeper_extension;

#endif
