/* hostile_plan.h - a hostile life as its seed draws it: the world, who lives in it, and what will happen. */
#ifndef TUMBLE_BENCH_HOSTILE_PLAN_H
#define TUMBLE_BENCH_HOSTILE_PLAN_H

#include "bench/hostile_draw.h"

/* Draw it. What the configuration does not allow is a mistake of the drawing: null, or the sentence. The plan must not
 * be moved. */
const char *bench_plan_draw(bench_plan_t *plan, uint64_t seed);

#endif
