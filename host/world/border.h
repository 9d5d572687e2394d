/* border.h - the simulated world as one object: firmware, stand, block, bus, operator and faults, for whoever holds it.
 *
 *     world_t *world = world_new();
 *     world_set(world, "procedure.samples = 50", &line);
 *     world_power_on(world, seed, WORLD_BY_ITSELF, false);
 *     while (world_advance(world, WORLD_FOREVER, WORLD_CHANGE) != WORLD_ENDED) { printf("%s\n", world_event(world, WORLD_CHANGE)); }
 *
 * Seed and keys determine all that happens, to the last bit. Virtual time goes on within world_advance alone, up to a
 * moment or to one of the events that the caller waits for. What has gone over the bus, and what went into the means, is
 * recorded from power-on. Not for several threads at once; two worlds share nothing.
 *
 * Before power-on there are keys, gains and world_check alone.
 *
 * A sentence that a function returns says what is wrong, and lasts until the next call of that world; null is good.
 */
#ifndef TUMBLE_WORLD_BORDER_H
#define TUMBLE_WORLD_BORDER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct world world_t;

/* A world with the defaults of all keys, the paper's stand; null: no memory. */
world_t *world_new(void);
void world_free(world_t *world);

/* Keys: `KEY = VALUES`, as a line of a scenario file. */

typedef struct {
    const char *name;  /* null: there is no such row */
    const char *range; /* of a value, for people */
    const char *about; /* unit and meaning */
    uint8_t count;     /* values; of three, one may stand for all */
} world_key_t;

/* The row of the table of keys; its texts last until the next call. */
world_key_t world_key(size_t row);

/* A kind of fault, and what it does; null: there is no such row. */
const char *world_fault_kind(size_t row, const char **about);

/* Set a key before power-on. */
const char *world_set(world_t *world, const char *line);

/* The gain record of the estimator `optimal`. */
const char *world_set_gains(world_t *world, const uint8_t *record, size_t size);

/* Once all keys are set: what no single one can show. Power-on asks this, too. */
const char *world_check(world_t *world);

/* Who acts when the firmware waits for a person. */
typedef enum {
    WORLD_BY_ITSELF = 0, /* the simulated operator, in the time that the keys give him */
    WORLD_ON_CONFIRM,    /* he does what was asked once somebody on the bus has confirmed it */
    WORLD_NEVER,         /* nobody */
    WORLD_ASKED          /* the caller: world_answer */
} world_operator_t;

/* Before power-on: record neither frames nor samples, for runs by the thousand. */
void world_record_nothing(world_t *world);

/* Power everything on, and command the start unless firmware.starts = no. `memory`: the firmware has non-volatile
 * memory, empty at first, and keeps coefficients; keeper.serial names the block then. */
const char *world_power_on(world_t *world, uint64_t seed, world_operator_t operator, bool memory);

/* Time. */

#define WORLD_FOREVER UINT64_MAX

/* What has happened; a set of bits. */
enum {
    WORLD_FRAME = 1,     /* a frame went over the bus that did not come from world_send */
    WORLD_CHANGE = 2,    /* the procedure has moved on: another state, position or attempt */
    WORLD_AVERAGED = 4,  /* another tenth of a position's samples has gone into its mean */
    WORLD_QUESTION = 8,  /* the firmware waits for a person */
    WORLD_ENDED = 16,    /* for good, and the table is at rest or will never be */
    WORLD_NO_MEMORY = 32 /* instead of all others: something could not be recorded, and time stands still */
};

uint64_t world_now_us(const world_t *world);

/* Let time pass: to `until_us`, or until something of `stop_at` has happened, all of one moment's event included; or to
 * the end, always. Returns what has happened of `stop_at`, and WORLD_ENDED. */
unsigned world_advance(world_t *world, uint64_t until_us, unsigned stop_at);

/* How a run ends, or is told to end. */
typedef enum {
    WORLD_RUNNING = 0,
    WORLD_DONE,        /* the procedure is DONE */
    WORLD_FAULT,       /* FAULT or ABORT, and nobody mends it */
    WORLD_INTERRUPTED, /* told to stop from outside */
    WORLD_TOO_LONG,    /* limit of virtual time */
    WORLD_LEFT         /* whoever held it has left */
} world_end_t;

/* Stop the table and give up; the world ends when the table rests. */
void world_end(world_t *world, world_end_t end);

/* What is done to it. */

/* Put a frame on the bus, as one more node. */
const char *world_send(world_t *world, uint16_t id, uint8_t length, const uint8_t *data);

/* Turn the table, for a drive of the caller's (present.drive = no): to at most 36000 deg either way, at 1e-5 to 1e5 deg/s. */
const char *world_turn_table(world_t *world, double angle_deg, double speed_deg_s);

typedef enum {
    WORLD_ANSWER_DONE = 0, /* mounted, turned, or mended: go on */
    WORLD_ANSWER_ABORT,
    WORLD_ANSWER_REPEAT_POSITION, /* argument: index in the schedule */
    WORLD_ANSWER_REPEAT_MOUNTING, /* argument: number of the mounting */
    WORLD_ANSWER_LEAVE            /* do nothing: the run ends where it is */
} world_answer_t;

/* Answer the open question: do it, and tell the firmware. */
const char *world_answer(world_t *world, world_answer_t answer, uint8_t argument);

/* The navigation computer's power. Without it the memory alone lasts; with it, the firmware begins anew, and waits for
 * a command. The world goes on, if it had ended. */
const char *world_set_power(world_t *world, bool on);

/* Command a calibration. */
const char *world_start(world_t *world);

/* The bytes of the memory, which outlive power; null: there is none. */
uint8_t *world_memory(world_t *world, size_t *size);

/* What was recorded. */

typedef struct {
    uint64_t time_us; /* its end */
    uint16_t id;
    uint8_t length;
    uint8_t sender; /* 0 the computer, 1 the drive, 2 the block, 3 world_send */
    uint8_t data[8];
} world_frame_t;

typedef struct {
    uint64_t block_ms; /* its timestamp, unwrapped */
    int32_t counts[3];
    uint32_t ordinal;
    uint16_t counter;
    uint16_t timestamp_ms;
    uint8_t index; /* of the position in the schedule */
    int8_t temperature_half_c;
} world_sample_t;

/* All frames, and the samples of the means that were kept, in the order of the schedule; valid until the next call. */
const world_frame_t *world_frames(const world_t *world, size_t *count);
const world_sample_t *world_samples(world_t *world, size_t *count);

/* Volts of a count. */
double world_step_v(const world_t *world);

/* Mounting and number of the position at an index of the schedule. False: there is none. */
bool world_position(const world_t *world, size_t index, uint8_t *mounting, uint8_t *number);

/* How it stands, as JSON. It lasts until the next call. */

/* What was found by now: tumble.bench/1. */
const char *world_document(world_t *world);

/* The event of tumble-node's progress (report.h) for a bit of what has happened, CHANGE, AVERAGED or QUESTION; of 0: the
 * table's angle. Null: there is no question; the table does not turn. */
const char *world_event(world_t *world, unsigned happened);

#endif
