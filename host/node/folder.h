/* folder.h - the run folder: run.csv, bus.log and bench.json, complete or not there at all.
 *
 * The files are written beside their final names and renamed when the run is over, so that a run that is killed leaves
 * nothing that looks finished.
 *
 * run.csv has one row per averaged sample, position by position in the schedule's order:
 * mounting,position,ux,uy,uz (V, 17 digits),cx,cy,cz (raw counts),counter (the block's, 16 bits),timestamp (its ms),
 * temperature (its, deg C), time_s (the timestamp with its wraps counted, from the first averaged sample on)
 * bus.log has one line per frame in the form of candump -L: (seconds.microseconds) INTERFACE ID#DATA, UTC.
 */
#ifndef TUMBLE_NODE_FOLDER_H
#define TUMBLE_NODE_FOLDER_H

#include "procedure/procedure.h"
#include "tumble/core.h"
#include "world/world.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef struct {
    tumble_block_sample_t sample;
    uint64_t block_ms; /* its timestamp with the wraps counted */
} bench_timed_sample_t;

typedef struct {
    bench_timed_sample_t *samples;
    uint32_t count;
    uint32_t room;
} bench_recorded_t;

typedef struct {
    const char *path;
    const char *interface;
    FILE *log;
    bool created; /* the folder was not there before */
    bool failed;  /* a write or an allocation failed */
    bool timed;   /* a sample has come: */
    uint64_t block_ms;
    uint64_t heard_us; /* when that was here */
    bench_recorded_t positions[TUMBLE_MAX_POSITIONS];
} bench_folder_t;

/* Make the folder, or take an empty one, and begin. Null, or what is wrong. */
const char *bench_folder_open(bench_folder_t *folder, const char *path, const char *interface);

/* What goes into it. `now_us`: of any clock that runs on; between two samples it may differ from the block's by 2 s. */
void bench_folder_frame(bench_folder_t *folder, uint64_t time_us, const tumble_can_frame_t *frame);
void bench_folder_sample(bench_folder_t *folder, uint64_t now_us, tumble_taken_t taken,
                         const tumble_block_sample_t *sample);

/* Write the rest, bench.json by `document`, and give all files their names. Null, or what is wrong; then nothing is left
 * behind. */
const char *bench_folder_close(bench_folder_t *folder, const bench_world_t *world,
                               void (*document)(const void *context, FILE *out), const void *context);

#endif
