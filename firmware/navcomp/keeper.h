/* keeper.h - the life of the coefficient sets (tumble/sets.h) in a navigation computer with non-volatile memory: judged,
 * committed or held, due again, resumed.
 *
 *     static tumble_keeper_t keeper = {.config = &config};  the board's; config before tumble_navcomp_init
 *     navcomp_config.keeping = &tumble_keeper_calls;
 *     navcomp_config.keeper = &keeper;
 *
 * A finished run becomes a set, is judged by the rules, and committed, or held as the proposal. A result that the store
 * has held before, to the last bit, is not stored again. After every finished position a checkpoint is written, so that
 * a run that lost power can go on. When the memory refuses a job, that is counted, and the active set stays. An entry
 * of the history or of the checkpoint is tried TUMBLE_SETS_TRIES times in all; then the history waits for the next job
 * of the store, the checkpoint for the next mean. A checkpoint ends with its run: when a run is started anew, given up, or
 * done and stored, no checkpoint is left.
 *
 * The keeper saves parameters (1010h) in the same memory, measures the block at rest (2152h), and shows all of it in the
 * object dictionary. It works in navcomp's own step and makes at most one call of the memory in each; nothing waits.
 *
 * Not re-entrant; its functions are called from where navcomp's are called.
 */
#ifndef TUMBLE_NAVCOMP_KEEPER_H
#define TUMBLE_NAVCOMP_KEEPER_H

#include "navcomp/parameters.h"
#include "navcomp/views.h"
#include "sample/at_rest.h"
#include "tumble/navcomp.h"
#include "tumble/sets.h"

/* The board's, const; must outlive the keeper. */
typedef struct {
    tumble_sets_config_t sets;

    /* tumble_navcomp_uncertainty where the stand is declared; null: no set has uncertainties, and so none is committed
     * by itself. Called once for each coefficient of a result, one in each step. */
    tumble_status_t (*uncertainty)(const tumble_navcomp_t *navcomp, uint16_t coefficients,
                                   tumble_uncertainty_t *uncertainty);

    /* tumble_navcomp_norm beside it; null: nobody asks whether the uncertainty shows the limit at every attitude. Called
     * once in a step, some 60 times for a result. */
    tumble_status_t (*norm)(const tumble_navcomp_t *navcomp, const double attitude[3], double *norm_g);

    /* tumble_stand_view and its memory (navcomp/views.h); null: the dictionary tells nothing of the stand. */
    const tumble_stand_view_t *(*stand_view)(const tumble_navcomp_t *navcomp, tumble_stand_memory_t *memory);
    tumble_stand_memory_t *stand_memory;

    /* tumble_inclinations_view and its memory (likewise); null: nothing of its inclinations. */
    const tumble_inclinations_view_t *(*inclinations_view)(const tumble_navcomp_t *navcomp,
                                                           tumble_inclinations_memory_t *memory);
    tumble_inclinations_memory_t *inclinations_memory;
} tumble_keeper_config_t;

/* The emergency message (1003h) while TUMBLE_DUE_DECAYED is set. Its first four info bytes are the present calibration
 * counter, little endian. "No error" follows when the next set becomes active. */
#define TUMBLE_KEEPER_EMCY_DECAYED 0xFF20U

/* A run of which more than one in so many samples was lost, corrupted, repeated or out of order is disturbed, and so is
 * one in which as many position reports, per sample, were not believed. No set comes of it by itself
 * (TUMBLE_OBJECTION_DISTURBED): a second block, or a node that forges reports, may be on the bus. The samples of a mean
 * have limits of their own besides (max_lost, max_corrupted). */
#define TUMBLE_KEEPER_DISTURBED_ONE_IN 20U

/* The transmit PDO that is triggered when the calibration counter, the verdict or what is due changes. */
#define TUMBLE_KEEPER_PDO 3U

/* The object. `config` is the board's to set before init. `store` and `history` are to be read by their own functions;
 * `settings`, `counters` and `sequence` may be read; everything else is private. The small members come first, because a
 * Cortex-M reaches them by shorter instructions. */
typedef struct {
    uint8_t task;  /* what goes on over several steps, */
    uint8_t at;    /* and how far */
    uint8_t job;   /* what the store is doing for us: the verdict that it will be */
    uint8_t wants; /* bits: what is to be done when the memory is free */
    uint8_t verdict;
    uint8_t status;
    uint8_t resumable;
    uint8_t trying;        /* the checkpoint's job: a position + 1, or TRYING_..., */
    uint8_t tries;         /* begun so often */
    uint8_t history_tries; /* left for the entry of the active set */
    bool run_was_on;
    bool run_resumed;
    bool has_checkpoint; /* the run's own has been begun; else it is tried again with its next mean */
    bool was_inhibited;
    bool stale;        /* the active set may have changed */
    bool repeated;     /* the result being judged has been seen before */
    bool looked_again; /* for what it was to be compared with, which could not be read */
    bool has_utc;
    bool has_active;
    bool has_active_half_c;
    bool decayed;           /* the history knows of a later set than the store */
    bool decay_told;        /* by an emergency message that is not cleared yet */
    bool disturbed;         /* a part of the run that gave the last result was: see TUMBLE_KEEPER_DISTURBED_ONE_IN */
    uint8_t shown_position; /* 2150h:1 */
    uint8_t shown_entry;    /* 2160h:1 */
    uint32_t objections;
    uint16_t off_temperature; /* samples in a row */
    int16_t active_half_c;
    const tumble_keeper_config_t *config;
    tumble_navcomp_t *navcomp;
    uint32_t undisturbed;   /* where the balance of the run's samples stood when the run, or its repetition, began */
    uint32_t warm_samples;  /* how many averaged samples of the run */
    uint32_t fingerprint;   /* of the run that is kept */
    uint32_t sequence;      /* of the active set: the calibration counter, which grows with every change of that set and
                             * with nothing else. Only when it decays the counter goes back to that of the set before,
                             * and TUMBLE_DUE_DECAYED is set; the next set gets a number that no set had. 0: the factory
                             * set, or none */
    uint32_t shown;         /* what the state message told last */
    uint32_t rules;         /* fingerprint of those that are in force after power-on, */
    uint32_t rules_written; /* and of those that are being saved */
    uint32_t accepted;      /* the proposal that is to become active */
    int64_t warmth_half_c;  /* sum over the averaged samples of the run */
    uint64_t saved;         /* one bit per position whose mean is in the checkpoint, or on its way there */
    uint64_t lost;          /* of `saved`: those that the memory would not take */
    uint64_t unfit;         /* one bit per position whose mean is kept and could not be put back */
    uint64_t now_us;        /* of the last step */
    uint64_t utc_us;        /* UTC at the port's time 0 */
    uint64_t active_utc_s;  /* date of the active set; 0: unknown */
    uint64_t active_us;     /* power-on, or when the active set changed, if later */
    tumble_worst_norm_t worst_norm;
    uint64_t inhibit_us; /* the host's inhibit ends here */
    uint64_t pause_us;   /* no start by itself before */
    tumble_sets_counters_t counters;
    tumble_sets_settings_t settings;
    tumble_set_t set; /* the result; its uncertainties are served until the next one comes */
    tumble_store_t store;
    tumble_history_t history;
    tumble_checkpoint_t checkpoint;
    tumble_parameters_t parameters;
    tumble_at_rest_t at_rest; /* 2152h */
} tumble_keeper_t;

static_assert(sizeof(tumble_keeper_t) <= ((sizeof(void *) == 4U) ? 2224U : 2424U), "the keeper must stay small");

/* For tumble_navcomp_config_t.keeping, with a tumble_keeper_t as `keeper`. Its init returns TUMBLE_OK;
 * TUMBLE_E_ARGUMENT (no configuration, a serial number or settings out of range, no memory behind the port); TUMBLE_E_NV
 * (tumble_regions_check: then there is no set, and nothing is kept). It reads everything that is kept. If the memory is busy, the rest is read
 * step by step, and until then there is no set.
 *
 * It adds commands to tumble_navcomp_command; each is refused with TUMBLE_E_STATE where it is not allowed. While no run
 * is on and the memory is not at work: TUMBLE_COMMAND_ACCEPT (there must be a proposal, and tumble_navcomp_accept must
 * name it, otherwise TUMBLE_E_ARGUMENT), TUMBLE_COMMAND_DISCARD (there must be a proposal), TUMBLE_COMMAND_ROLLBACK
 * (there must be something to go back to, and no proposal). In IDLE: TUMBLE_COMMAND_RESUME goes on with the run that
 * lost power, within some steps (there must be one, and block, stand, schedule, configuration and active set must be
 * those with which it began).
 *
 * It also refuses others. While inhibited: every command that begins or resumes a run or turns the table. Until the
 * saved parameters (1010h) are in force after power-on or an NMT reset: TUMBLE_COMMAND_START. While the result is
 * judged, for some 100 ms after DONE (with the whole-model test for as long as a thousand steps more take):
 * TUMBLE_COMMAND_START, TUMBLE_COMMAND_REPEAT_POSITION and TUMBLE_COMMAND_REPEAT_MOUNTING. */
extern const tumble_keeping_t tumble_keeper_calls;

/* Is the memory at work? Is there something left to do? */
bool tumble_keeper_busy(const tumble_keeper_t *keeper);
bool tumble_keeper_has_work(const tumble_keeper_t *keeper);

void tumble_keeper_state(const tumble_keeper_t *keeper, tumble_sets_state_t *state);

/* The uncertainties of the present result.
 * Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY (they are being computed, or a run is on), TUMBLE_E_STATE (not known). */
tumble_status_t tumble_keeper_uncertainty(const tumble_keeper_t *keeper, const tumble_uncertainty_t **uncertainty);

/* How the present result fits the whole model: the verdict in the first members of tumble_whole_work_t. Returns likewise;
 * TUMBLE_E_STATE also where nobody asked, or there is nothing to judge by. */
tumble_status_t tumble_keeper_whole_model(const tumble_keeper_t *keeper, const tumble_whole_work_t **found);

/* Settings. tumble_keeper_change and tumble_keeper_configure check all of them and take all or none. tumble_keeper_change is
 * for those outside. What the board's program sets by tumble_keeper_configure becomes the board's rules, unless other
 * rules were in force before. Both return TUMBLE_OK, TUMBLE_E_ARGUMENT (null, or one is out of range), TUMBLE_E_STATE
 * (a run is on). */
tumble_status_t tumble_keeper_change(tumble_keeper_t *keeper, const tumble_sets_settings_t *settings);
tumble_status_t tumble_keeper_configure(tumble_keeper_t *keeper, const tumble_sets_settings_t *settings);

/* The calendar: seconds since 1970-01-01T00:00:00 UTC, from here on kept by the port's clock; 0: no longer known. At
 * most TUMBLE_SETS_MAX_UTC_S.
 * Returns TUMBLE_OK or TUMBLE_E_ARGUMENT. Without it sets carry no date, and the interval counts from power-on, or from
 * the last change of the active set. */
#define TUMBLE_SETS_MAX_UTC_S (UINT64_C(1) << 40)
tumble_status_t tumble_keeper_set_utc(tumble_keeper_t *keeper, uint64_t utc_s);

/* The host's inhibit (say, while navigating): no run may be on for so many seconds from now; 0 ends it. A run under way is
 * given up and the table stopped, with TUMBLE_REASON_INHIBITED. It expires, so that a host that has died does not inhibit
 * for ever; a living host repeats it in time. An inhibit that must hold without the host belongs to the board:
 * config->sets.inhibited. */
void tumble_keeper_inhibit(tumble_keeper_t *keeper, uint16_t seconds);

/* Drift of a coefficient (0 to 11: K row by row, then U0), in V/g or V per TUMBLE_MONTH_S. It takes the sets of this
 * block in the history that are dated and have uncertainties, without those that a rollback gave up and the copies that
 * it brought back. Each call reads the whole history.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_PORT_BUSY (the memory is at work: ask again), TUMBLE_E_TOO_FEW,
 * TUMBLE_E_NOT_FINITE, or why an entry could not be read: TUMBLE_E_NV, TUMBLE_E_FRAME, TUMBLE_E_CRC. */
tumble_status_t tumble_keeper_trend(tumble_keeper_t *keeper, uint8_t coefficient, tumble_trend_t *trend);

/* What the objects show (keeper_objects.h), made when it is asked for. */

/* A position of the schedule, and its mean. */
typedef struct {
    double mean_v[TUMBLE_CHANNELS];
    double standard_error_v[TUMBLE_CHANNELS];
    double angle_deg;
    uint32_t samples;
    uint8_t index; /* in the schedule */
    uint8_t count; /* of positions in the schedule */
    uint8_t mounting;
    uint8_t number;
    uint8_t use;
} tumble_position_view_t;

/* Of each coefficient, V/g or V a month. */
typedef struct {
    double per_month[TUMBLE_COEFFICIENTS];
    double u_per_month[TUMBLE_COEFFICIENTS];
} tumble_trend_view_t;

/* The table and its hooks; their context is the tumble_navcomp_t, whose `keeper` is a tumble_keeper_t. */
extern const tumble_object_hooks_t tumble_keeper_object_hooks;
extern const tumble_node_extension_t tumble_keeper_extension;

#endif
