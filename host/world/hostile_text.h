/* hostile_text.h - a life in words: its world, its events, and what was violated, a line each. */
#ifndef TUMBLE_WORLD_HOSTILE_TEXT_H
#define TUMBLE_WORLD_HOSTILE_TEXT_H

#include "world/hostile_draw.h"
#include "world/hostile_watch.h"

#define BENCH_TEXT_BYTES 240

typedef struct {
    char text[BENCH_TEXT_BYTES];
} bench_text_t;

bench_text_t bench_text_world(const bench_plan_t *plan);
bench_text_t bench_text_event(const bench_event_t *event);
bench_text_t bench_text_violation(const bench_violation_t *violation);

#endif
