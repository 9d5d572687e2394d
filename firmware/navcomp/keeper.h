/* keeper.h - what the navigation computer does with its results: judge, commit or hold, recalibrate in time, resume.
 *
 *     static tumble_keeper_t keeper = {.config = &config};  the board's; config before tumble_navcomp_init
 *     navcomp_config.keeping = &tumble_keeper_calls;
 *     navcomp_config.keeper = &keeper;
 *
 * When a run is DONE the keeper makes a set of its result, judges it (store/commit_rules.h), and commits it or holds it
 * as the proposal. A result that the store has held before, to the last bit, is not stored again. After every finished
 * position it writes a checkpoint, so that a run that lost power can go on. All this goes on in navcomp's own step, at
 * most one call of the memory each; nothing waits. What the memory refuses is counted, and the active set stays. An
 * entry of the history, and what is done to the checkpoint, is tried again when refused, TUMBLE_KEEPER_TRIES times in
 * all; then the history waits for the next job of the store, the checkpoint for the next mean.
 *
 * A checkpoint ends with the run that it is of: a run that is started anew, given up, or done and stored, leaves none.
 *
 * Not re-entrant; its functions are called from where navcomp's are called.
 */
#ifndef TUMBLE_NAVCOMP_KEEPER_H
#define TUMBLE_NAVCOMP_KEEPER_H

#include "tumble/core.h"
#include "sample/at_rest.h"
#include "navcomp/keeping.h"
#include "tumble/navcomp.h"
#include "navcomp/parameters.h"
#include "store/checkpoint.h"
#include "store/commit_rules.h"
#include "store/history.h"
#include "store/store.h"
#include "store/trend.h"

#include <stdbool.h>
#include <stdint.h>

struct tumble_stand_memory;
struct tumble_stand_view;

/* tumble_keeper_settings_t.flags */
enum {
    TUMBLE_KEEPER_STARTS = 1 /* begins a run by itself when one is due, unless a proposal waits */
};

#define TUMBLE_KEEPER_MIN_PAUSE_S 60U
#define TUMBLE_KEEPER_TRIES 3U

/* What may be changed over CAN, between runs. */
typedef struct {
    tumble_commit_limits_t limits;
    double gravity_m_s2;          /* of the place, recorded with every set; 9.7 to 9.9; 0: not known */
    uint32_t interval_s;          /* a run is due so long after the last set; 0: never by time */
    uint32_t pause_s;             /* no start by itself so long after the last one, the end of any run, and a
                                   * TUMBLE_COMMAND_HOME_AXIS or _TURN_AXIS; TUMBLE_KEEPER_MIN_PAUSE_S or more */
    uint16_t temperature_samples; /* a run is due after so many samples in a row, 1 or more, ... */
    uint8_t temperature_half_c;   /* ... at more than this from the active set's temperature, half degrees C; 0: never */
    uint8_t flags;                /* TUMBLE_KEEPER_... */
} tumble_keeper_settings_t;

/* The board's, const; must outlive the keeper. */
typedef struct {
    const char *serial;                       /* of the block, 1 to TUMBLE_SET_SERIAL_BYTES characters */
    const tumble_keeper_settings_t *settings; /* at power-on */

    /* May no run be on now, as far as the board knows (a discrete input, the vehicle's state)? Asked at least every
     * heartbeat. May be null: never inhibited by the board. */
    bool (*inhibited)(void *context);
    void *context; /* handed to it */

    /* tumble_navcomp_uncertainty where the stand is declared; null: no set has uncertainties, and so none is committed
     * by itself. Called once for each coefficient of a result, one a step. */
    tumble_status_t (*uncertainty)(const tumble_navcomp_t *navcomp, uint16_t coefficients,
                                   tumble_uncertainty_t *uncertainty);

    /* tumble_stand_view and its memory (navcomp/stand_view.h); null: the dictionary tells nothing of the stand. */
    const struct tumble_stand_view *(*stand_view)(const tumble_navcomp_t *navcomp,
                                                  struct tumble_stand_memory *memory);
    struct tumble_stand_memory *stand_memory;
} tumble_keeper_config_t;

/* A clock that is set back by less than this makes no run due. */
#define TUMBLE_KEEPER_CLOCK_SLACK_S 3600U

/* The emergency message (1003h) while TUMBLE_DUE_DECAYED is set. The first four of its own bytes: the counter as it is
 * now, little endian. "No error" follows when the next set becomes active. */
#define TUMBLE_KEEPER_EMCY_DECAYED 0xFF20U

/* Why a run is due: bits. */
enum {
    TUMBLE_DUE_TIME = 1,        /* the interval is over */
    TUMBLE_DUE_TEMPERATURE = 2, /* the block is warmer or colder than it was when calibrated */
    TUMBLE_DUE_NO_SET = 4,      /* there is no active set */
    TUMBLE_DUE_DATE = 8,        /* the active set is dated more than TUMBLE_KEEPER_CLOCK_SLACK_S after the present */
    TUMBLE_DUE_DECAYED = 16     /* the active set has decayed in the memory, and the one before it counts */
};

/* What became of the last result, or of the last command about sets. The numbers travel over CAN and Modbus. */
typedef enum {
    TUMBLE_VERDICT_NONE = 0,        /* nothing yet since power-on */
    TUMBLE_VERDICT_WORKING = 1,     /* not decided or not written yet */
    TUMBLE_VERDICT_COMMITTED = 2,   /* the result is the active set */
    TUMBLE_VERDICT_HELD = 3,        /* it is the proposal; see `objections` */
    TUMBLE_VERDICT_REPEATED = 4,    /* it is one that the store has held before: nothing was written */
    TUMBLE_VERDICT_ACCEPTED = 5,    /* the proposal is the active set */
    TUMBLE_VERDICT_DISCARDED = 6,   /* the proposal is gone */
    TUMBLE_VERDICT_ROLLED_BACK = 7, /* the set before is active again */
    TUMBLE_VERDICT_FAILED = 8       /* the memory failed; see `status` */
} tumble_verdict_t;

/* Monotonic since power-on; they stop at UINT32_MAX. Store, history and checkpoint have their own. */
typedef struct {
    uint32_t judged; /* results */
    uint32_t committed;
    uint32_t held;
    uint32_t repeated;
    uint32_t accepted;
    uint32_t discarded;
    uint32_t rolled_back;
    uint32_t failures;     /* jobs of the memory that ended in anything but TUMBLE_OK */
    uint32_t checkpoints;  /* positions kept */
    uint32_t resumed;      /* runs gone on with after a loss of power */
    uint32_t not_resumed;  /* RESUME refused: nothing kept, or of another block, stand, schedule or configuration */
    uint32_t inhibited;    /* commands refused, runs given up and tables stopped because of the inhibit */
    uint32_t self_started;
    uint32_t refused;      /* commands about sets in a state that does not allow them, and to start before what was
                            * saved is in force */
} tumble_keeper_counters_t;

/* The object. `config` is the board's to set, everything else private: read it through the functions below. */
typedef struct {
    const tumble_keeper_config_t *config;
    tumble_navcomp_t *navcomp;
    tumble_keeper_settings_t settings;
    tumble_store_t store;
    tumble_history_t history;
    tumble_checkpoint_t checkpoint;
    tumble_parameters_t parameters;
    tumble_keeper_counters_t counters;
    tumble_set_t set;         /* the result; its uncertainties are served until the next one comes */
    tumble_misfit_work_t misfit; /* of the result: does it fit the declared stand? */
    tumble_at_rest_t at_rest; /* 2152h */
    uint64_t saved;           /* one bit per position whose mean is in the checkpoint, or on its way there */
    uint64_t lost;            /* of `saved`: those that the memory would not take */
    uint64_t unfit;           /* one bit per position whose mean is kept and could not be put back */
    uint64_t now_us;          /* of the last step */
    uint64_t utc_us;          /* UTC at the port's time 0 */
    uint64_t active_utc_s;    /* date of the active set; 0: unknown */
    uint64_t active_us;       /* power-on, or when the active set changed, if later */
    uint64_t inhibit_us;      /* the host's inhibit ends here */
    uint64_t pause_us;        /* no start by itself before */
    uint64_t due_us;          /* next step */
    int64_t warmth_half_c;    /* sum over the averaged samples of the run */
    uint32_t warm_samples;    /* how many */
    uint32_t fingerprint;     /* of the run that is kept */
    uint32_t sequence;        /* of the active set, as last seen */
    uint32_t shown;           /* what the PDO told last */
    uint32_t rules;           /* fingerprint of those that are in force after power-on, */
    uint32_t rules_written;   /* and of those that are being saved */
    uint32_t accepted;        /* the proposal that is to become active */
    uint16_t objections;
    uint16_t off_temperature; /* samples in a row */
    uint8_t shown_position; /* 2150h:1 */
    uint8_t shown_entry;    /* 2160h:1 */
    int16_t active_half_c;
    uint8_t task;             /* what goes on over several steps, */
    uint8_t at;               /* and how far */
    uint8_t job;              /* what the store is doing for us */
    uint8_t wants;            /* bits: what is to be done when the memory is free */
    uint8_t verdict;
    uint8_t status;
    uint8_t resumable;
    uint8_t trying;           /* the checkpoint's job: a position + 1, or TRYING_..., */
    uint8_t tries;            /* begun so often */
    uint8_t history_tries;    /* left for the entry of the active set */
    bool run_was_on;
    bool run_resumed;
    bool has_checkpoint;      /* the run's own has been begun; else it is tried again with its next mean */
    bool was_inhibited;
    bool stale;               /* the active set may have changed */
    bool repeated;            /* the result being judged has been seen before */
    bool looked_again;        /* for what it was to be compared with, which could not be read */
    bool has_utc;
    bool has_active;
    bool has_active_half_c;
    bool decayed;             /* the history knows of a later set than the store */
    bool decay_told;          /* by an emergency message that is not cleared yet */
} tumble_keeper_t;

static_assert(sizeof(tumble_keeper_t) <= ((sizeof(void *) == 4U) ? 2816U : 3072U), "the keeper must stay small");

/* What tumble_navcomp_config_t.keeping points to; `keeper` is a tumble_keeper_t. Its init returns TUMBLE_OK; _ARGUMENT (no
 * configuration, a serial number or settings out of range, no memory behind the port); _NV (regions.h). It reads the
 * whole of what is kept, unless the memory is busy: then the rest is read step by step, and until then there is no set.
 *
 * Commands that are its own, by tumble_navcomp_command: TUMBLE_COMMAND_ACCEPT and _DISCARD (there must be a proposal,
 * and ACCEPT must name it, tumble_navcomp_accept: else TUMBLE_E_ARGUMENT),
 * _ROLLBACK (something to go back to, and no proposal), all three only while no run is on and the memory is not at work;
 * and in IDLE TUMBLE_COMMAND_RESUME: go on with the run that lost power (there must be one, and block, stand,
 * schedule, configuration and active set be those that it was begun with); it begins within some steps. While inhibited
 * everything that begins or goes on with a run, or turns the table, is refused, and so is TUMBLE_COMMAND_START until what
 * was saved (1010h) is in force after power-on or an NMT reset. For some 100 ms after DONE the result is looked at: until
 * then START, REPEAT_POSITION and REPEAT_MOUNTING are refused. Refusals: TUMBLE_E_STATE. */
extern const tumble_keeping_t tumble_keeper_calls;

/* A set by value, as tumble_store_read. */
tumble_status_t tumble_keeper_set(tumble_keeper_t *keeper, tumble_which_set_t which, tumble_set_t *set);

/* The calibration counter: grows with every change of the active set, and by nothing else, unless that decays: then it
 * is the one of the set before, and what comes next gets one that none had; TUMBLE_DUE_DECAYED and
 * TUMBLE_KEEPER_EMCY_DECAYED tell of it. 0: the factory set, or none.
 * The keeper triggers transmit PDO TUMBLE_KEEPER_PDO when it, the verdict or what is due changes. */
uint32_t tumble_keeper_counter(const tumble_keeper_t *keeper);
#define TUMBLE_KEEPER_PDO 3U

/* What else is readable, in one copy. */
typedef struct {
    uint64_t utc_s;      /* 0: not known */
    uint32_t counter;    /* tumble_keeper_counter */
    uint32_t age_s;      /* of the active set, by its date, or else since power-on or its change; 0 if there is none */
    uint32_t due_in_s;   /* until the interval is over; 0: it is, or there is no interval */
    uint16_t inhibit_s;  /* left of the host's inhibit, rounded up */
    uint16_t objections; /* to the last result: TUMBLE_OBJECTION_BIT */
    uint8_t verdict;     /* tumble_verdict_t */
    uint8_t status;      /* tumble_status_t of the last failure of the memory */
    uint8_t due;         /* TUMBLE_DUE_... */
    uint8_t resumable;   /* finished positions of a run that lost power and may be gone on with; 0: none */
    bool inhibited;      /* by host or board */
    bool busy;           /* the memory is at work, or about to be */
    bool has_proposal;
    bool has_factory;
} tumble_keeper_state_t;

void tumble_keeper_state(const tumble_keeper_t *keeper, tumble_keeper_state_t *state);

const tumble_keeper_counters_t *tumble_keeper_counters(const tumble_keeper_t *keeper);

/* Settings. `configure` looks at all of them and takes all or none: TUMBLE_OK, TUMBLE_E_ARGUMENT (one is out of range),
 * TUMBLE_E_STATE (a run is on). The board's program needs no service level for it, and what it sets are the board's rules
 * unless others were in force before. */
const tumble_keeper_settings_t *tumble_keeper_settings(const tumble_keeper_t *keeper);
tumble_status_t tumble_keeper_configure(tumble_keeper_t *keeper, const tumble_keeper_settings_t *settings);

/* The calendar: seconds since 1970-01-01T00:00:00 UTC, from here on kept by the port's clock; 0: no longer known. At
 * most TUMBLE_KEEPER_MAX_UTC_S. Returns TUMBLE_OK or TUMBLE_E_ARGUMENT. Without it sets carry no date, and the interval
 * counts from power-on, or from the last change of the active set. */
#define TUMBLE_KEEPER_MAX_UTC_S (UINT64_C(1) << 40)
tumble_status_t tumble_keeper_set_utc(tumble_keeper_t *keeper, uint64_t utc_s);

/* The host's inhibit (say, while navigating): no run may be on for so many seconds from now; 0 ends it. A run under way is
 * given up and the table stopped, with TUMBLE_REASON_INHIBITED. It expires, so that a host that has died does not inhibit
 * for ever; one that lives tells it again in time. What must not hang on a living host is the board's:
 * config->inhibited. */
void tumble_keeper_inhibit(tumble_keeper_t *keeper, uint16_t seconds);

/* The history: tumble_history_count and tumble_history_read. Only for reading. */
tumble_history_t *tumble_keeper_history(tumble_keeper_t *keeper);

/* Drift of a coefficient (0 to 11: K row by row, then U0) over the sets of the history that are dated and have
 * uncertainties, of this block, and were neither given up by a rollback nor brought back by one (they are there
 * already), in V/g or V per TUMBLE_MONTH_S. Reads the whole history, once for each call. Returns TUMBLE_OK,
 * _ARGUMENT, _PORT_BUSY (the memory is at work: ask again), _TOO_FEW, _NOT_FINITE, or why an entry could not be read. */
tumble_status_t tumble_keeper_trend(tumble_keeper_t *keeper, uint8_t coefficient, tumble_trend_t *trend);

#endif
