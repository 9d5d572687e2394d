/* rules.h - what the rules go by (private to the room). */
#ifndef TUMBLE_SETS_RULES_H
#define TUMBLE_SETS_RULES_H

#include "tumble/sets.h"

/* |K_i| of the row that a coefficient (0 to 11) belongs to. */
double tumble_commit_length(const tumble_set_t *set, int c);

/* From one date to a later one, 1 to TUMBLE_COMMIT_MAX_MONTHS. */
double tumble_commit_months(uint64_t later_utc_s, uint64_t earlier_utc_s);

#endif
