/* hostile_shrink.h - the fewest events of a life that still break the same invariant. */
#ifndef TUMBLE_BENCH_HOSTILE_SHRINK_H
#define TUMBLE_BENCH_HOSTILE_SHRINK_H

#include "bench/hostile_life.h"

/* Take events out of a plan whose life broke `kind`, in halves, quarters and so on down to single ones, as long as the
 * life without them breaks it too. `life` is left as the last one that did. */
void bench_plan_shrink(bench_plan_t *plan, bench_life_t *life, bench_broken_t kind);

#endif
