/* instant_table.h - a kind of stand of one's own: a table that is wherever it is told to be. */
#ifndef TUMBLE_TESTS_UNIT_INSTANT_TABLE_H
#define TUMBLE_TESTS_UNIT_INSTANT_TABLE_H

#include "tumble/stand.h"

typedef struct {
    tumble_stand_report_t report;
    double angle_deg;
    uint8_t state; /* tumble_stand_state_t */
} instant_table_t;

extern const tumble_stand_kind_t instant_table_kind; /* it has no profile */

#endif
