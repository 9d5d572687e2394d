/* border.h - the simulated world as one object: firmware, stand, block, bus, operator and faults, for whoever holds it.
 *
 *     world_t *world = world_new();
 *     world_set(world, "procedure.samples = 50", &line);
 *     world_power_on(world, seed, WORLD_BY_ITSELF, false);
 *     while (world_advance(world, WORLD_FOREVER, WORLD_CHANGE) != WORLD_ENDED) { world_report(world, &report); }
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

/* How it stands. */

#define WORLD_POSITIONS 36
#define WORLD_MOUNTINGS 36

typedef struct {
    uint8_t mounting;
    uint8_t number;
    bool fit;      /* else check */
    bool measured; /* its mean is kept; else the next three are 0 */
    uint32_t samples;
    double u_v[3];
    double standard_error_v[3];
    double delta_g_g; /* with a result */
    double alpha4_rad;
} world_position_t;

typedef struct {
    const char *kind;
    uint32_t times; /* how often it has come */
} world_fault_t;

typedef struct {
    uint64_t seed;
    uint64_t now_us;
    uint64_t frames; /* that went over the bus */
    world_end_t end;
    /* the table's true travel since power-on */
    bool at_rest;
    double lowest_deg;
    double highest_deg;
    /* the procedure */
    const char *state;
    const char *failed_in;
    const char *reason;
    const char *reason_sentence;
    const char *status;
    uint32_t reason_number;
    uint16_t drive_code;
    uint8_t mounting;
    uint8_t position;
    uint8_t index;
    uint8_t count;
    uint8_t finished;
    uint8_t attempt;
    uint32_t samples; /* of the open position */
    uint32_t wanted;
    bool has_mean;
    double mean_v[3];
    double standard_error_v[3];
    bool moving;
    bool has_angle; /* it is known where the table stands */
    double angle_deg;
    /* an open question */
    const char *question; /* mounting, angle, fault; null: none */
    uint8_t question_mounting;
    double question_deg;
    const char *question_reason;
    const char *question_sentence;
    /* what the drive has refused; index 0: nothing */
    uint16_t refused_index;
    uint8_t refused_subindex;
    uint32_t refused_abort;
    const char *refused_step;
    char refused_sentence[200];
    /* the result */
    const char *estimator;
    bool has_result;
    bool pass;
    double k_v_per_g[9];
    double u0_v[3];
    double max_abs_fit_g;
    double max_abs_check_g;
    double limit_g;
    double v_per_count;
    uint8_t mounting_count;
    uint8_t position_count;
    double closure_g[WORLD_MOUNTINGS];
    world_position_t positions[WORLD_POSITIONS];
    bool has_uncertainty;
    double u_k_v_per_g[9];
    double u_u0_v[3];
    bool has_noise;
    uint32_t block_samples;
    double noise_v[3];
    double declared_v;
    uint8_t above; /* a bit for each channel with more than was declared */
    /* the truth */
    double true_k_v_per_g[9];
    double true_u0_v[3];
    double alpha1_rad;
    double alpha2_rad;
    double alpha3_rad[WORLD_MOUNTINGS];
    double theta_h_rad[WORLD_MOUNTINGS];
    double theta_n_rad[WORLD_MOUNTINGS];
    bool inclines; /* a bolting has several inclinations: the errors of setting them are in the next two */
    double beta_rad[WORLD_MOUNTINGS];
    double tau_rad[WORLD_MOUNTINGS];
    double encoder_rad[4];
    double drift_v[3];
    /* the faults of the keys */
    uint32_t fault_count;
    world_fault_t faults[16];
} world_report_t;

void world_report(world_t *world, world_report_t *report);

/* A counter of firmware or bus: its name, null where there is no such row; and its value. */
const char *world_counter(const world_t *world, size_t row, uint64_t *value);

#endif
