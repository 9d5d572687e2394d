/* readout.h - what is known of a run that goes on or has ended, by names and numbers for people. */
#ifndef TUMBLE_WORLD_READOUT_H
#define TUMBLE_WORLD_READOUT_H

#include "world/world.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Where the table of the simulation has been since power-on, whatever its drive reports; and whether it rests now. */
typedef struct {
    double lowest_deg;
    double highest_deg;
    bool at_rest;
} bench_travel_t;

bench_travel_t bench_travel(const bench_world_t *world);

/* Does the schedule name boltings? Then the inclinations of the stand belong to the truth. */
bool bench_inclines(const tumble_schedule_t *schedule);

/* The name of a counter, null where there is no such row; and its value: of the firmware, of the simulated bus, and of
 * both, one behind the other. */
const char *bench_firmware_counter(const bench_world_t *world, size_t row, uint64_t *value);
const char *bench_bus_counter(const sim_bus_t *bus, size_t row, uint64_t *value);
const char *bench_counter(const bench_world_t *world, size_t row, uint64_t *value);

/* Mean (V) of the position at `index` and its standard error. False: not finished. */
bool bench_mean(const bench_world_t *world, uint8_t index, double mean_v[TUMBLE_CHANNELS],
                double error_v[TUMBLE_CHANNELS]);

/* What a drive has refused, or not done in time, as a sentence: object, abort code, and in which step; and that step's
 * name (tumble_stand_step_t). */
#define BENCH_REFUSAL_BYTES 200
void bench_refusal_sentence(const tumble_stand_refusal_t *refusal, char *text, size_t size);
const char *bench_step_name(uint8_t step);

/* "done", "fault", "interrupted", "too long", "left". */
const char *bench_end_name(world_end_t end);

#endif
