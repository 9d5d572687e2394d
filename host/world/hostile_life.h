/* hostile_life.h - one hostile life: the navigation computer with its memory, on the simulated bus, while what its plan
 * holds happens to it, and the invariants (hostile_watch.h) are watched.
 *
 * The computer may lose its power. Then its memory alone outlives: what was being erased or programmed is left with any
 * bytes, bits elsewhere may flip, and the firmware begins anew on what is there. The rest of the world goes on.
 */
#ifndef TUMBLE_WORLD_HOSTILE_LIFE_H
#define TUMBLE_WORLD_HOSTILE_LIFE_H

#include "world/hostile_state.h"

/* From power-on to the end of the plan, or to the first violation: life->watch.violation. */
void bench_life_run(bench_life_t *life, bench_plan_t *plan);

/* Take events out of a plan whose life broke `kind`, in halves, quarters and so on down to single ones, as long as the
 * life without them breaks it too. `life` is left as the last one that did. */
void bench_plan_shrink(bench_plan_t *plan, bench_life_t *life, bench_broken_t kind);

#endif
