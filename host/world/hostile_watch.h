/* hostile_watch.h - what must hold in a hostile life, judged by the simulation's truth and not by what the firmware says.
 * docs/campaign.md says of each word what must hold, and of each excuse what it excuses and for how long.
 */
#ifndef TUMBLE_WORLD_HOSTILE_WATCH_H
#define TUMBLE_WORLD_HOSTILE_WATCH_H

#include "procedure/states.h"
#include "simulation/drive.h"
#include "tumble/core.h"

#include <stdbool.h>
#include <stdint.h>

#define BENCH_REST_US 6000000U
#define BENCH_NOTICE_US 1000000U /* a stranger's set-point is noticed, and the table stops, by then */
#define BENCH_HOMING_DEG 900.0   /* cable and a turn, braking, and what is turned until a homing that does not end is */
#define BENCH_SPEED_EXCESS 1.02
#define BENCH_TRUTH_COVERAGE 6.0
#define BENCH_CABLE_TOLERANCE_DEG 5.0

/* Word, and what a person reads. */
#define BENCH_VIOLATION_LIST(X)                                                                                        \
    X(BENCH_HOLDS, "none", "nothing is violated")                                                                      \
    X(BENCH_BROKEN_REST, "rest", "the table still turns 6 s after the end")                                            \
    X(BENCH_BROKEN_STAYS, "stays", "the table at rest moves without a command")                                        \
    X(BENCH_BROKEN_CABLE, "cable", "the table goes beyond the cable's limits")                                         \
    X(BENCH_BROKEN_HOMING, "homing", "homing goes farther than the cable's span and a turn")                           \
    X(BENCH_BROKEN_SPEED, "speed", "the table turns for 1 s faster than it was told to")                               \
    X(BENCH_BROKEN_FOREIGN, "foreign", "a stranger's motion is not stopped within 1 s")                                \
    X(BENCH_BROKEN_REASON, "reason", "FAULT or ABORT without a reason")                                                \
    X(BENCH_BROKEN_FINITE, "finite", "a readable object is not a finite number")                                       \
    X(BENCH_BROKEN_TRUTH, "truth", "a set that became active by itself is off by more than 6 u")                       \
    X(BENCH_BROKEN_LOST, "lost", "the active set is lost")                                                             \
    X(BENCH_BROKEN_COUNTER, "counter", "the calibration counter went back, and nothing was told")                      \
    X(BENCH_BROKEN_PROPOSAL, "proposal", "a proposal is lost that nobody has decided about")                           \
    X(BENCH_BROKEN_DECAYED, "decayed", "a record or mark with a flipped bit counts as valid")                          \
    X(BENCH_BROKEN_MEAN, "mean", "a mean is not of its own samples, as many as are configured")                        \
    X(BENCH_BROKEN_LEVEL, "level", "the service level is open, or was not asked for, without its key")                 \
    X(BENCH_BROKEN_RUN, "run", "the run number does not count the runs")                                               \
    X(BENCH_BROKEN_BENCH, "bench", "the bench cannot go on")

typedef enum {
#define BENCH_VIOLATION_ENUM(name, word, sentence) name,
    BENCH_VIOLATION_LIST(BENCH_VIOLATION_ENUM)
#undef BENCH_VIOLATION_ENUM
        BENCH_VIOLATION_KINDS
} bench_broken_t;

#define BENCH_EXCUSE_LIST(X)                                                                                           \
    X(BENCH_EXCUSE_COMMANDED, "commanded")                                                                             \
    X(BENCH_EXCUSE_REWRITTEN, "rewritten")                                                                             \
    X(BENCH_EXCUSE_STEP, "step")   /* fault `step`: a bias changes within a run */                                     \
    X(BENCH_EXCUSE_SLIP, "slip")   /* fault `slip`, below what closure and position tolerance see */                   \
    X(BENCH_EXCUSE_SHORT, "short") /* fault `never_reached`, by less than the position tolerance */                    \
    X(BENCH_EXCUSE_CHANNEL,                                                                                            \
      "channel")                     /* faults `swapped`, `inverted`: for a while, where outputs are alike or small */ \
    X(BENCH_EXCUSE_SAMPLE, "sample") /* a forged sample with a good checksum */                                        \
    X(BENCH_EXCUSE_RULES, "rules")   /* an accepted write to 2050h or 2122h to 2126h */                                \
    X(BENCH_EXCUSE_FLIPPED, "flipped")

typedef enum {
#define BENCH_EXCUSE_ENUM(name, word) name,
    BENCH_EXCUSE_LIST(BENCH_EXCUSE_ENUM)
#undef BENCH_EXCUSE_ENUM
        BENCH_EXCUSES
} bench_excuse_t;

typedef struct {
    bench_broken_t kind;
    uint64_t at_us;
    double value;  /* degrees, uncertainties, or a number of that kind */
    uint32_t what; /* object, coefficient, state: by kind */
} bench_violation_t;

/* The samples of the position that is being averaged, as they came; the frames of the block that came last. */
#define BENCH_RECENT 32U
#define BENCH_COUNTERS 64U

typedef struct {
    tumble_can_frame_t frames[BENCH_RECENT];
    uint32_t next;
    uint8_t index;
    uint32_t count;
    uint16_t counters[BENCH_COUNTERS];
    int64_t sum[TUMBLE_CHANNELS];
} bench_collected_t;

/* Means of a position that were found to be right. */
#define BENCH_KNOWN 4U

typedef struct {
    tumble_average_t means[BENCH_KNOWN];
    uint32_t next;
} bench_known_t;

typedef struct {
    bench_violation_t violation;
    uint32_t excuses;      /* bit per bench_excuse_t */
    uint64_t rest_us;      /* the table must rest by then; SIM_NEVER: no end is pending */
    bool peace;            /* it rests, and nobody has commanded anything */
    uint64_t still_us;     /* since when it stands; SIM_NEVER: it moves */
    uint64_t commanded_us; /* when a stranger commanded the drive last */
    uint64_t fast_us;      /* since when the table turns too fast; SIM_NEVER: it does not */
    double last_deg;
    sim_homing_t homing; /* as last seen */
    bool searches;       /* from the start of a homing until the table rests */
    double from_deg;     /* where that began */
    bool has_set;
    uint32_t counter;
    uint64_t told_by_us; /* a decay must be told by then; SIM_NEVER: none */
    bool told;
    uint32_t proposal;       /* its name; 0: there is none */
    uint64_t decided_us;     /* until then a command about it, or another result, may take it away; SIM_NEVER: power was
                          * lost before that */
    uint64_t level_until_us; /* the service level may be open; */
    uint64_t open_us;        /* since when it is although it may not; SIM_NEVER: it is not */
    bool locked;             /* when the last write was asked for it could not be open */
    uint32_t runs;           /* the run number, when the state changed last */
    bench_collected_t collected;
    bench_known_t known[TUMBLE_MAX_POSITIONS];
    tumble_state_t state;
} bench_watch_t;

const char *bench_broken_name(bench_broken_t kind);
const char *bench_broken_sentence(bench_broken_t kind);
const char *bench_excuse_name(bench_excuse_t excuse);

#endif
