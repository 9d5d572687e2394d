/* lives.h - hostile lives (docs/campaign.md), one at a time: each seed draws a stand, a run or two, commands, faults,
 * frames of a stranger and losses of power, and the simulation's truth is held against what must hold.
 *
 *     lives_t *lives = lives_new();
 *     const char *violated = lives_live(lives, seed, NULL, 0);
 */
#ifndef TUMBLE_WORLD_LIVES_H
#define TUMBLE_WORLD_LIVES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct lives lives_t;

/* Null: no memory. */
lives_t *lives_new(void);
void lives_free(lives_t *lives);

/* Live the life of a seed, to its end or to the first violation. `events`: with so many of them alone, by their numbers
 * from 0 on, rising; null: with all. Returns the word of what was violated; null: nothing. */
const char *lives_live(lives_t *lives, uint64_t seed, const uint32_t *events, size_t count);

/* When it was violated, and how, in a sentence that lasts until the next call. */
const char *lives_violation(lives_t *lives, uint64_t *at_us);

/* The life in words: line 0 its world, from 1 on its events; null beyond them, and of a life that could not be drawn at
 * all. It lasts until the next call. */
const char *lives_line(lives_t *lives, uint32_t number);

/* What was counted in the life, row by row: a group (violations, faults, events, excuses, ends of a state, sets, all), a
 * name, and how often. Null: there is no such row. */
const char *lives_count(const lives_t *lives, size_t row, const char **name, uint64_t *value);

/* How far the true table has turned. False: there was no world. */
bool lives_travel(const lives_t *lives, bool *at_rest, double *lowest_deg, double *highest_deg);

#endif
