/* uncertainty.h - how standard uncertainties follow from the gains of an estimator (private to the core).
 *
 * An estimator that is linked only where it is lent states its gains through hooks, so that the others do not bring it.
 */
#ifndef TUMBLE_CORE_UNCERTAINTY_H
#define TUMBLE_CORE_UNCERTAINTY_H

#include "tumble/core.h"

enum { TUMBLE_X, TUMBLE_Y, TUMBLE_Z, TUMBLE_BIAS }; /* the unknowns of a channel: K_ix, K_iy, K_iz, U0_i */

typedef enum {
    TUMBLE_GAINS_AVERAGED,
    TUMBLE_GAINS_REFINED,
    TUMBLE_GAINS_LEAST_SQUARES,
    TUMBLE_GAINS_TABLE,
    TUMBLE_GAINS_HOOKED
} tumble_gains_kind_t;

typedef struct tumble_gains tumble_gains_t;

typedef struct {
    /* Get ready for the coefficient, or with an attitude for |a|. */
    void (*solve)(const tumble_gains_t *gains);
    /* How the axis is inclined in a mounting. */
    const tumble_angle_t *(*tilt)(const tumble_gains_t *gains, const tumble_mounting_t *mounting);
    /* What the three means of the position `p` weigh; its table angle. */
    const tumble_angle_t *(*at)(const tumble_gains_t *gains, uint8_t p, double g[TUMBLE_CHANNELS]);
} tumble_gains_hooks_t;

/* Where the gains of one coefficient come from; of the pointers those that belong to the kind. */
struct tumble_gains {
    const tumble_judged_run_t *run;
    tumble_gains_kind_t kind;
    int channel;
    int unknown;
    const tumble_harmonic_map_t *map;
    const uint8_t *slots; /* with the map: what each position is to it */
    struct tumble_least_squares *least_squares;
    const tumble_gain_table_t *table;
    const tumble_gains_hooks_t *hooks;  /* null, but for hooked ones */
    void *hooked;                       /* what they work with */
    double by_channel[TUMBLE_CHANNELS]; /* with an attitude n: n K^-1, what |a| changes by an output of each */
};

/* What every estimator refuses: TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_uncertainty_check(const tumble_judged_run_t *run, const tumble_uncertainty_t *uncertainty);

/* All that are wanted, one after the other. Returns TUMBLE_OK, TUMBLE_E_NOT_FINITE. */
tumble_status_t tumble_uncertainty_judge(tumble_gains_t *gains, tumble_uncertainty_t *uncertainty);

#endif
