/* world.h - the course of a run, from power-on to the table at rest; a seed and a configuration determine it to the last
 * bit.
 *
 *     bench_world_init(&world, &config, seed, &watcher);
 *     bench_world_run(&world);   or, to do something in between,   while (bench_world_advance(&world)) { }
 */
#ifndef TUMBLE_WORLD_WORLD_H
#define TUMBLE_WORLD_WORLD_H

#include "world/scene.h"

/* How the firmware is told what `config` says; all that is pointed at must outlive what it is told. */
tumble_navcomp_config_t bench_navcomp_config(const bench_config_t *config, const tumble_port_t *port,
                                             const tumble_navcomp_hooks_t *hooks, bench_stand_memory_t *memory);

/* Power everything on and command the start. Returns TUMBLE_OK or what tumble_navcomp_init says. All that is handed in
 * must outlive the world, which must not be moved. */
tumble_status_t bench_world_init(bench_world_t *world, const bench_config_t *config, uint64_t seed,
                                 const bench_watcher_t *watcher);

/* Go on to the next event. False: the run has ended (world->end), with the table at rest. */
bool bench_world_advance(bench_world_t *world);

/* Has the table come to rest since the end was decided? */
bool bench_world_has_ended(bench_world_t *world);

/* Go on to the end. */
void bench_world_run(bench_world_t *world);

/* When the next event is. */
uint64_t bench_world_next_us(const bench_world_t *world);

/* Stop the table and give up, and end the run as soon as the table rests, whatever becomes of the command. */
void bench_world_end(bench_world_t *world, bench_end_t end);

#endif
