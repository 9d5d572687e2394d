/* procedure.h - the state machine that walks a schedule: mount, home, turn, settle, average, solve, verify, propose.
 *
 * It knows the core and the stand interface, no bus and no clock: time comes in as a parameter, samples are handed in.
 * The caller owns the object and every configuration; nothing is allocated, no function waits. Not re-entrant.
 *
 * Settling and averaging depend only on what arrives: the stand's report of being in position, then the block's samples
 * with their own counters and timestamps. The time parameter drives timeouts alone, so a recorded run replays to the
 * same bits anywhere. Every state that waits for something has a bounded time; IDLE, DONE, FAULT and ABORT wait for
 * nothing and leave the table at rest.
 *
 * The way of a run is in procedure_states.c. A fault stops the table and keeps what was measured: `resume` goes through
 * PREFLIGHT to NEXT again, which picks the first position without a mean, those of the current mounting first.
 */
#ifndef TUMBLE_PROCEDURE_PROCEDURE_H
#define TUMBLE_PROCEDURE_PROCEDURE_H

#include "procedure/states.h"
#include "sample/block_sample.h"
#include "tumble/core.h"
#include "tumble/stand.h"

#include <stdbool.h>
#include <stdint.h>

/* An estimator that a board lends, with data of its own, so that a computer that does not use it need not link it. For
 * TUMBLE_ESTIMATE_OPTIMAL set the functions to tumble_optimal_check, tumble_optimal_estimate, tumble_optimal_uncertainty of
 * tumble/core.h and `source` to a tumble_optimal_source_t; for TUMBLE_ESTIMATE_INCLINED likewise tumble_inclined_*. */
typedef struct tumble_lent {
    tumble_estimate_t estimator;
    tumble_status_t (*check)(const void *source, const tumble_schedule_t *schedule);
    tumble_status_t (*estimate)(const void *source, const tumble_schedule_t *schedule, const tumble_means_t *means,
                                tumble_coefficients_t *coefficients);
    tumble_status_t (*uncertainty)(const void *source, const tumble_judged_run_t *run,
                                   tumble_uncertainty_t *uncertainty); /* null: none is stated */
    const void *source;
    const struct tumble_lent *next; /* another one that the board lends; null at the end */
} tumble_lent_t;

/* With an error budget: so many samples lie between one look at the standard error and the next. */
#define TUMBLE_BUDGET_CHECK_SAMPLES 8U

typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_averaging_config_t *averaging; /* min_samples there is the smallest; samples below the largest */
    tumble_estimate_t estimate;
    const tumble_lent_t *lent; /* the estimators that the board lends; null: none */
    uint32_t samples;          /* per position; averaging->min_samples to TUMBLE_MAX_SAMPLES. With the stuck gate on, a
                                       position must have averaging->stuck_run, or as many as honest noise leaves equal in
                                       one case of 100,000: 3 with noise of 127 counts, 4 from 19, 7 from 2.8, 14 from 1 or less */
    double error_budget_v;     /* a position is finished before that once the standard error of every channel's
                                       mean is at most this, V; if it never is, that is a fault; 0: always `samples` */
    double v_per_count;        /* size of one count, V; finite, not 0 */
    double nominal_scale_v_per_g;  /* signed, not 0; good to a tenth: for the checks of direction and closure */
    double gravity_limit_g;        /* limit of the gravity check; above 0 */
    double closure_limit_g;        /* |U9 - U1| over the nominal scale that calls a slip; above 0 */
    double position_tolerance_deg; /* actual against commanded angle that calls a slip; above 0 */
    double approach_deg;           /* every angle is approached upwards, from at least this far below; 0: no matter */
    double cable_min_deg;          /* the table may turn from here ... */
    double cable_max_deg;          /* ... to here; the procedure turns back rather than go beyond */
    uint16_t settle_ms;            /* by the block's timestamps, after the stand is in position; below 4096 */
    uint16_t max_corrupted;        /* corrupted frames allowed per position */
    uint8_t retries;               /* times that one position is repeated by itself before it is a fault */
    int8_t warm_up_band_half_c;    /* temperature must stay within this band; 0 or more ... */
    uint16_t warm_up_samples;      /* ... for so many samples in a row; 0: no warm-up */
    uint32_t preflight_timeout_ms; /* all timeouts: above 0 */
    uint32_t warm_up_timeout_ms;
    uint32_t mounting_timeout_ms;
    uint32_t home_timeout_ms;
    uint32_t move_timeout_ms;   /* of one move; reaching an angle from below may take two */
    uint32_t settle_timeout_ms; /* above settle_ms */
    uint32_t average_timeout_ms;
    uint32_t sample_timeout_ms; /* silence of the block that is a fault, in states that need samples */
    uint32_t motion_margin_ms;  /* a motion may take so much longer than way / speed and ramps, and may show no progress
                                 * for so long (stand/bounds.h); 0: TUMBLE_MOTION_MARGIN_MS */
    double channel_scale_v_per_g[TUMBLE_CHANNELS]; /* of a channel that differs; 0: as nominal_scale_v_per_g says */
} tumble_procedure_config_t;

/* Monotonic since init, over all runs; they stop at UINT32_MAX. */
typedef struct {
    uint32_t samples;   /* handed in, whatever became of them */
    uint32_t corrupted; /* frames, as reported by the sample source */
    uint32_t lost;      /* samples, as reported by the sample source */
    uint32_t averaged;  /* samples that went into a mean, kept or not */
    uint32_t positions; /* means kept */
    uint32_t refused;   /* positions refused by a gate or a check */
    uint32_t retries;   /* of those, repeated without asking */
    uint32_t timeouts;
    uint32_t moves;   /* commands given to the stand */
    uint32_t unwinds; /* angles replaced by an equivalent one for the cable's sake */
    uint32_t homings;
    uint32_t faults; /* entries into FAULT */
    uint32_t resumes;
    uint32_t commands_refused;
} tumble_procedure_counters_t;

/* The object. Its fields are private: read them through the functions below. */
typedef struct {
    int8_t coldest_half_c;
    int8_t warmest_half_c;
    uint8_t stand_state; /* tumble_stand_state_t, as at the last look at the stand */
    tumble_state_t state;
    tumble_state_t failed_in;
    tumble_reason_t reason;
    tumble_status_t status;
    uint8_t index;
    uint8_t attempt;
    uint8_t mounted;      /* index of the mounting that is confirmed */
    uint8_t block_status; /* what keeps the block from passing PREFLIGHT */
    bool restart_run;     /* the next step sets the start of the run, */
    bool restart_timer;   /* that of the state, */
    bool heard;           /* and the time of the last sample */
    bool marked;          /* the first sample of this state has come */
    bool leading_in;      /* on the way to the point below the angle */
    bool begun;           /* averaging is initialised for this run */
    bool warm;
    bool homed;
    bool restored; /* means of a run that lost power are in, and no mounting has been confirmed since */
    bool solved;   /* there is a result */
    bool block_alive;
    bool bus_up;
    bool supervised;
    bool clearing;      /* PREFLIGHT: the stand's fault is still to be cleared */
    uint16_t corrupted; /* frames at this position */
    union {
        uint16_t warm_run;   /* WARM_UP: samples within the band */
        uint16_t parts_done; /* SOLVE: of its three */
    };
    uint16_t last_counter;
    uint16_t last_timestamp_ms;
    uint16_t drive_code;
    const tumble_procedure_config_t *config;
    tumble_stand_t stand;
    uint32_t settled_ms; /* of the block's time since the table is in position */
    uint64_t now_us;
    uint64_t started_us;
    uint64_t entered_us;
    uint64_t heard_us;
    double target_deg; /* where the position is measured */
    tumble_averaging_t averaging;
    union {
        tumble_means_t means; /* in SOLVE and in VERIFY */
        struct {
            tumble_gravity_check_t check; /* from PROPOSE on */
            tumble_misfit_work_t misfit;  /* lent to whoever judges what is proposed, while it must stay */
        } found;
    } work;
    tumble_coefficients_t coefficients;
    tumble_calibration_t calibration;
    tumble_procedure_counters_t counters;
} tumble_procedure_t;

/* Would a run with this configuration be refused at once? PREFLIGHT asks the same. `reason` (may be null) receives
 * TUMBLE_REASON_NONE, TUMBLE_REASON_CONFIGURATION, TUMBLE_REASON_SCHEDULE or TUMBLE_REASON_CABLE_LIMIT.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT (a number out of range, an estimator that is not lent, or a position with no table
 * angle within the cable's limits), or what tumble_schedule_validate, tumble_schedule_identify, (for the harmonic
 * estimators) tumble_schedule_harmonic or the `check` of a lent one returns. */
tumble_status_t tumble_procedure_validate(const tumble_procedure_config_t *config, tumble_reason_t *reason);

/* The configured estimator, if the board lends it; else null. */
const tumble_lent_t *tumble_procedure_lent(const tumble_procedure_config_t *config);

/* Get ready, in IDLE. The procedure keeps pointers to `config` and `stand`. In IDLE, DONE and ABORT the numbers of the
 * configuration may change if `start` is the next command; the schedule and the pointers may change before init only.
 * The configuration is checked when a run starts or goes on.
 * Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT (null). */
tumble_status_t tumble_procedure_init(tumble_procedure_t *procedure, const tumble_procedure_config_t *config,
                                      const tumble_stand_t *stand);

/* Let time pass: look at the stand, go on, watch the timeouts. `now_us` never goes back. Call it after every frame
 * handed to the stand, so that a replay sees the stand in the same states; more often does no harm. */
void tumble_procedure_step(tumble_procedure_t *procedure, uint64_t now_us);

/* The moment at which step has something to do by itself, a timeout of the present state; 0: at once; UINT64_MAX:
 * never. Silence of the block counts from the first step after its last sample. */
uint64_t tumble_procedure_next_us(const tumble_procedure_t *procedure);

/* Which mean a sample went into. Ordinal 1: the position begins (again), what it held before is forgotten. */
typedef struct {
    uint8_t index;    /* of the position in the schedule */
    uint32_t ordinal; /* 1 to the number of samples per position */
} tumble_taken_t;

/* Hand in one sample, in the order of arrival. True: it went into a mean, and `taken` (may be null) tells which. A
 * sample that is refused or not wanted is counted; the caller need do nothing. */
bool tumble_procedure_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample, tumble_taken_t *taken);

/* Tell of what the sample source could not hand in, in the order of arrival with the samples: frames refused as
 * corrupted and samples missing since the last call. Corrupted frames are judged per position; missing samples are only
 * counted here, because the averaging follows the sample counter by itself. */
void tumble_procedure_sample_faults(tumble_procedure_t *procedure, uint16_t corrupted, uint16_t lost);

/* Is the block's heartbeat there, is the bus up? Both count as true until told otherwise; telling again is harmless.
 * The block may be silent while the operator handles it; a lost bus is a fault in every state of a run. */
void tumble_procedure_set_block_alive(tumble_procedure_t *procedure, bool alive);
void tumble_procedure_set_bus_up(tumble_procedure_t *procedure, bool up);

/* Are stand and block watched as configured? True until told otherwise; a run does not begin, nor go on, without. */
void tumble_procedure_set_supervised(tumble_procedure_t *procedure, bool supervised);

/* Commands. Each returns TUMBLE_OK, TUMBLE_E_STATE when the state does not allow it, or TUMBLE_E_ARGUMENT; refusals are
 * counted. Each comment ends with the states that allow the command (procedure_states.c). */

/* Begin a run; results of the last one are gone. IDLE, DONE, ABORT. */
tumble_status_t tumble_procedure_start(tumble_procedure_t *procedure);

/* Stop the table and give up. The table is stopped even when the command is refused. Every state of a run, and
 * FAULT. */
tumble_status_t tumble_procedure_abort(tumble_procedure_t *procedure);

/* The same for another reason than a command, in the same states; else nothing, not even a count. */
void tumble_procedure_give_up(tumble_procedure_t *procedure, tumble_reason_t reason);

/* The mounting with this number has been put on the table; its positions are (all) measured from now on. WAIT_MOUNTING,
 * and FAULT when it came from the mounting (not confirmed, wrong, swapped channels): the run then goes on at once.
 * TUMBLE_E_ARGUMENT: another mounting is wanted. */
tumble_status_t tumble_procedure_confirm_mounting(tumble_procedure_t *procedure, uint8_t mounting);

/* Go on at the failed position after a fault has been mended; a fault of the stand is cleared first. FAULT. In IDLE,
 * once means have been put back by `restore`: go on with that run. Mounting and homing are asked for again. The first
 * mounting that is confirmed keeps its means: confirming it says that nobody has touched the block. If somebody has,
 * repeat it (tumble_procedure_repeat_mounting). */
tumble_status_t tumble_procedure_resume(tumble_procedure_t *procedure);

/* Put back the mean of a position that a run had finished before it lost power. Put back all of them in the order in
 * which they were measured, in IDLE, before `resume`; `start` forgets them. The configuration must have passed
 * tumble_procedure_validate. The mean must pass the gates (tumble_averaging_restore) and the checks of direction and
 * closure again. If it is refused, the position counts as not measured.
 * Returns TUMBLE_OK, TUMBLE_E_STATE, TUMBLE_E_ARGUMENT (index; a mean that this run would not have kept),
 * TUMBLE_E_TOO_FEW, TUMBLE_E_STUCK, TUMBLE_E_NOT_STILL. */
tumble_status_t tumble_procedure_restore(tumble_procedure_t *procedure, uint8_t index, const tumble_average_t *average);

/* Measure one position anew. It must be of the mounting that is on the table, because every mounting sits a little
 * differently: TUMBLE_E_STATE otherwise. WAIT_MOUNTING, SETTLE, AVERAGE, FAULT, DONE. */
tumble_status_t tumble_procedure_repeat_position(tumble_procedure_t *procedure, uint8_t index);

/* Measure a mounting anew, from mounting it. WAIT_MOUNTING, SETTLE, AVERAGE, FAULT, DONE. */
tumble_status_t tumble_procedure_repeat_mounting(tumble_procedure_t *procedure, uint8_t mounting);

/* For a caller that looks at every step: it changes exactly when state, reason, position or attempt change, and is 0
 * before the first start. */
static inline uint32_t tumble_procedure_mark(const tumble_procedure_t *procedure)
{
    return ((uint32_t)procedure->state << 24) | ((uint32_t)procedure->reason << 16) |
           ((uint32_t)procedure->index << 8) | procedure->attempt;
}

/* Where the run stands, and what an estimate of the remaining time needs. */
typedef struct {
    tumble_state_t state;
    tumble_state_t failed_in; /* the state that FAULT or ABORT came from */
    tumble_reason_t reason;   /* of FAULT, ABORT, or of a DONE that fails the gravity check; otherwise NONE */
    tumble_status_t status;   /* what the core or the stand said of the last refusal; TUMBLE_OK: nothing */
    uint16_t drive_code;      /* the drive's own error code behind a fault of the stand, 0 if none */
    uint8_t index;            /* of the position in the schedule, 0 to count - 1 */
    uint8_t count;            /* positions of the schedule */
    uint8_t finished;         /* of those, with a mean */
    uint8_t mounting;         /* numbers of that position's mounting (in WAIT_MOUNTING the one asked for) and its own */
    uint8_t position;
    uint8_t attempt;  /* 0 at the first, 1 at the first repetition, ... */
    uint32_t samples; /* in the open mean */
    uint32_t samples_wanted;
    double target_deg;      /* table angle of the position; may be a whole number of turns off the schedule's */
    double inclination_deg; /* of the axis in that mounting, as the schedule says, */
    bool stays_bolted;      /* to which the block is not mounted anew: the stand is inclined */
    uint64_t elapsed_us;    /* local clock since the run started; for display only */
} tumble_progress_t;

void tumble_procedure_progress(const tumble_procedure_t *procedure, tumble_progress_t *progress);

/* Mean of the open position so far and its standard error, in volts. Returns as tumble_averaging_running. */
tumble_status_t tumble_procedure_running(const tumble_procedure_t *procedure, double mean_v[TUMBLE_CHANNELS],
                                         double standard_error_v[TUMBLE_CHANNELS]);

/* The finished means, as in tumble/core.h; valid as long as the object. */
const tumble_averaging_t *tumble_procedure_averages(const tumble_procedure_t *procedure);

/* The result of a run. A result that fails the gravity check is a result, too, with `pass` false. */
typedef struct {
    const tumble_coefficients_t *coefficients;
    const tumble_calibration_t *calibration;
    const tumble_gravity_check_t *check;
    bool pass;
} tumble_result_t;

/* The result, valid until the next start or repetition. Returns TUMBLE_OK, or TUMBLE_E_STATE before PROPOSE. */
tumble_status_t tumble_procedure_result(const tumble_procedure_t *procedure, tumble_result_t *result);

/* Has the position at `index` a finished mean? */
bool tumble_procedure_has_mean(const tumble_procedure_t *procedure, uint8_t index);

/* Closure of a mounting (index in the schedule): the largest |U9 - U1| of its channels over the nominal scale, in g; 0
 * while it is not complete, or when it has no such pair. Computed from the means at every call. */
double tumble_procedure_closure_g(const tumble_procedure_t *procedure, uint8_t mounting_index);

const tumble_procedure_counters_t *tumble_procedure_counters(const tumble_procedure_t *procedure);

#endif
