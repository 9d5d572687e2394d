/* stand_rules.h - what tumble/stand.h promises of every kind of stand, as checks: each kind is held to the same ones.
 *
 * Whoever writes a kind of his own fills in a played_stand_t and asks which rule it breaks.
 */
#ifndef TUMBLE_TESTS_UNIT_STAND_RULES_H
#define TUMBLE_TESTS_UNIT_STAND_RULES_H

#include "tumble/stand.h"

#include <stdbool.h>

/* A stand, and what plays the world at its other end. */
typedef struct {
    tumble_stand_t stand;

    /* Power on, with contact: it becomes READY by itself. */
    void (*begin)(void);

    /* A millisecond passes for both. */
    void (*pass)(void);

    /* The table turns, in truth. Null: a person turns it, and nobody can tell. */
    bool (*turns)(void);

    /* Where it stands, in truth. */
    double (*angle_deg)(void);

    /* Contact is lost, and comes back. */
    void (*lose)(void);
    void (*find)(void);

    unsigned most_ms;  /* that a home, a move or a stop may last */
    unsigned fault_ms; /* after which a lost contact must be a fault, and the table at rest */
} played_stand_t;

/* The first rule that it breaks, in a sentence; null: it keeps them all. */
const char *stand_rules_broken(const played_stand_t *played);

#endif
