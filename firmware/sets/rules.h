/* rules.h - may a new set of coefficients replace the active one by itself?
 *
 * A pure function: candidate, active set and limits in, a bit per objection out; none: commit. Whatever cannot be
 * judged is an objection. The set is then held as a proposal with these bits, for an operator to accept or discard.
 *
 * Everything is relative to the length of a row of the candidate's K, |K_i| = sqrt(K_ix^2 + K_iy^2 + K_iz^2) in V/g:
 * a scale factor's limit is a ratio, a cross-axis sensitivity's an angle in rad, and a bias's is in g.
 *
 *     uncertainty   u_c / |K_i| <= uncertainty[c]
 *     change        |c - c_active| / |K_i| <= coverage sqrt(u_c^2 + u_c,active^2) / |K_i|
 *                                             + drift_per_month[c] months + drift_per_kelvin[c] kelvin
 *
 * with months the time between the dates of the two sets, at least 1 (and 1 where a date is unknown) and at most
 * TUMBLE_COMMIT_MAX_MONTHS, and kelvin the difference of their temperatures (0 where one is unknown). An uncertainty of
 * the active set that is unknown counts as 0: what is not known excuses no change.
 *
 * TUMBLE_OBJECTION_DOES_NOT_FIT is not found here, for a set has no means in it: the caller adds it (tumble/core.h).
 */
#ifndef TUMBLE_SETS_RULES_H
#define TUMBLE_SETS_RULES_H

#include "tumble/core.h"
#include "sets/set_record.h"

#include <stdbool.h>
#include <stdint.h>

/* Drift is allowed for so many months at most, however far apart the dates are: a clock that is years ahead would else
 * excuse any change, and after so long a time somebody should look at what has become of the block. */
#define TUMBLE_COMMIT_MAX_MONTHS 24.0

/* Bit numbers travel over CAN and Modbus: new ones go to the end, 16 at most. */
#define TUMBLE_OBJECTION_LIST(X)                                                                                       \
    X(TUMBLE_OBJECTION_GRAVITY_CHECK, "the result fails the gravity check")                                            \
    X(TUMBLE_OBJECTION_NOT_FINITE, "a number of the set is infinite or not a number, or a row of K is zero")           \
    X(TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN, "the uncertainties are not known: the stand is not declared")              \
    X(TUMBLE_OBJECTION_UNCERTAIN, "a coefficient is less certain than its limit asks")                                 \
    X(TUMBLE_OBJECTION_CHANGE, "a coefficient changed by more than drift and uncertainty explain")                     \
    X(TUMBLE_OBJECTION_OTHER_BLOCK, "the active set is of a block with another serial number")                         \
    X(TUMBLE_OBJECTION_FIRST, "there is no active set to compare with")                                                \
    X(TUMBLE_OBJECTION_OLDER, "it is dated before the active set: the clock is wrong or the run is an old one")        \
    X(TUMBLE_OBJECTION_REPLAYED, "the same coefficients, to the last bit, were found before: the run is not new")      \
    X(TUMBLE_OBJECTION_LIMITS, "a limit of these rules is out of its range")                                           \
    X(TUMBLE_OBJECTION_BY_HAND, "every set is to be accepted by an operator")                                          \
    X(TUMBLE_OBJECTION_OTHER_RULES, "the rules were changed from the board's")                                         \
    X(TUMBLE_OBJECTION_DOES_NOT_FIT, "the means scatter by more than the declared stand and noise explain")

/* The bit numbers. */
typedef enum {
#define TUMBLE_OBJECTION_ENUM(name, sentence) name,
    TUMBLE_OBJECTION_LIST(TUMBLE_OBJECTION_ENUM)
#undef TUMBLE_OBJECTION_ENUM
    TUMBLE_OBJECTION_COUNT
} tumble_objection_t;

#define TUMBLE_OBJECTION_BIT(objection) ((uint16_t)((uint32_t)1U << (unsigned)(objection)))

/* tumble_commit_limits_t.flags */
enum {
    TUMBLE_COMMIT_BY_ITSELF = 1, /* else every set waits for an operator */
    TUMBLE_COMMIT_FIRST = 2      /* with no active set the first one may be committed, too */
};

/* Coefficients in the order K row by row, then U0. */
typedef struct {
    float uncertainty[TUMBLE_COEFFICIENTS];      /* largest standard uncertainty, ratio or g; above 0, to 1 */
    float drift_per_month[TUMBLE_COEFFICIENTS];  /* plausible change, ratio or g per TUMBLE_MONTH_S; 0 to 1 */
    float drift_per_kelvin[TUMBLE_COEFFICIENTS]; /* ratio or g per K; 0 to 1 */
    float coverage;                              /* k, how many combined standard uncertainties; 1 to 10 */
    uint8_t flags;                               /* TUMBLE_COMMIT_... */
} tumble_commit_limits_t;

/* The objections to `candidate`, as bits; `active` null: there is none. `replayed`: the caller has seen these
 * coefficients before. Some 200 double operations, 15 square roots. No other pointer may be null. */
uint16_t tumble_commit_objections(const tumble_set_t *candidate, const tumble_set_t *active,
                                  const tumble_commit_limits_t *limits, bool replayed);

/* Are these limits in their ranges? */
bool tumble_commit_limits_valid(const tumble_commit_limits_t *limits);

/* Name and sentence of a bit number; safe for values outside the list, never null. */
const char *tumble_objection_name(tumble_objection_t objection);
const char *tumble_objection_sentence(tumble_objection_t objection);

#endif
