/* hostile_draw.h - the plan of a hostile life, and what its parts are drawn with.
 *
 * Every part has a stream of random numbers of its own (SIM_CAUSE_LIFE): one draw more in one shifts nothing in the
 * others. hostile_plan.c draws the world and the ordinary course, hostile_scenes.c what belongs together,
 * hostile_frames.c single frames.
 */
#ifndef TUMBLE_WORLD_HOSTILE_DRAW_H
#define TUMBLE_WORLD_HOSTILE_DRAW_H

#include "simulation/random.h"
#include "world/config.h"
#include "world/hostile_event.h"

#include <stdbool.h>
#include <stdint.h>

#define BENCH_PLAN_EVENTS 300U

/* Who mounts the block, mends faults and switches the power on again. */
typedef struct {
    double mount_s;
    double mend_s;
    uint32_t mends; /* faults that he mends; then the run stays where it is */
    bool resumes;   /* after a loss of power, else he starts anew */
    bool errs;      /* mounts the block wrongly, once */
} bench_attendant_t;

typedef struct {
    uint64_t seed;
    bench_config_t config; /* complete; its faults are those of `events` */
    bench_attendant_t attendant;
    uint64_t lasts_us;
    uint32_t erase_us;
    uint32_t program_us;
    uint64_t utc_s; /* told at power-on; 0: not */
    bool has_set;   /* the memory holds an active set from the beginning */
    uint32_t count;
    bench_event_t events[BENCH_PLAN_EVENTS]; /* in the order of their times */
} bench_plan_t;

/* Streams: the index of SIM_CAUSE_LIFE. */
enum {
    BENCH_STREAM_WORLD = 0,
    BENCH_STREAM_COURSE,
    BENCH_STREAM_FAULTS,
    BENCH_STREAM_FRAMES,
    BENCH_STREAM_CUTS,
    BENCH_STREAM_SCENES,
    BENCH_STREAM_MEMORY,
    BENCH_STREAM_EVENT = 1000 /* and the event's number */
};

/* Uniform from low to high; a whole number from 0 to count - 1; true with this probability. */
double bench_draw(sim_random_t *stream, double low, double high);
uint32_t bench_pick(sim_random_t *stream, uint32_t count);
bool bench_chance(sim_random_t *stream, double probability);

/* One more event of this kind at this time, to be filled in; with the list full, one that is thrown away. */
bench_event_t *bench_plan_add(bench_plan_t *plan, bench_hostile_t kind, double at_s);
bench_event_t *bench_plan_add_command(bench_plan_t *plan, double at_s, tumble_command_t command, uint8_t argument);

/* An SDO write of up to four bytes to the server of `node`. */
void bench_frame_write(tumble_can_frame_t *frame, uint8_t node, uint16_t index, uint8_t subindex, uint8_t size,
                       uint32_t value);

void bench_plan_faults(bench_plan_t *plan);
void bench_plan_scenes(bench_plan_t *plan);
void bench_plan_frames(bench_plan_t *plan);

/* One random write to an object that a stop depends on; to one of the drive that is read back before a motion. */
void bench_draw_stop_write(sim_random_t *stream, tumble_can_frame_t *frame);
void bench_draw_read_back_write(sim_random_t *stream, tumble_can_frame_t *frame);

/* Where a forged set-point leads; how many positions are forged near each other, and how far apart. */
void bench_draw_set_point(sim_random_t *stream, bench_event_t *event);
void bench_draw_near_positions(sim_random_t *stream, bench_event_t *event);

/* Draw the whole of it (hostile_plan.c). What the configuration does not allow is a mistake of the drawing: null, or the
 * sentence. The plan must not be moved. */
const char *bench_plan_draw(bench_plan_t *plan, uint64_t seed);

#endif
