/* keeper.h - the life of the coefficient sets (tumble/sets.h) in a navigation computer with non-volatile memory.
 *
 *     static tumble_keeper_t keeper = {.config = &config};  the board's; config before tumble_navcomp_init
 *     navcomp_config.keeping = &tumble_keeper_calls;
 *     navcomp_config.keeper = &keeper;
 *
 * The keeper tells the sets what happens to the run, and does what they ask for. It saves parameters (1010h) in the
 * same memory, measures the block at rest (2152h), and shows all of it in the object dictionary. It works in navcomp's
 * own step and makes at most one call of the memory in each; nothing waits.
 *
 * Not re-entrant; its functions are called from where navcomp's are called.
 */
#ifndef TUMBLE_NAVCOMP_KEEPER_H
#define TUMBLE_NAVCOMP_KEEPER_H

#include "navcomp/keeping.h"
#include "navcomp/parameters.h"
#include "sample/at_rest.h"
#include "tumble/navcomp.h"
#include "tumble/sets.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

struct tumble_stand_memory;
struct tumble_stand_view;
struct tumble_inclinations_memory;
struct tumble_inclinations_view;

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

    /* tumble_stand_view and its memory (navcomp/stand_view.h); null: the dictionary tells nothing of the stand. */
    const struct tumble_stand_view *(*stand_view)(const tumble_navcomp_t *navcomp, struct tumble_stand_memory *memory);
    struct tumble_stand_memory *stand_memory;

    /* tumble_inclinations_view and its memory (navcomp/inclinations_view.h); null: nothing of its inclinations. */
    const struct tumble_inclinations_view *(*inclinations_view)(const tumble_navcomp_t *navcomp,
                                                                struct tumble_inclinations_memory *memory);
    struct tumble_inclinations_memory *inclinations_memory;
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

/* The object. `config` is the board's to set before init; `sets` is to be read through the functions of tumble/sets.h;
 * everything else is private. */
typedef struct {
    tumble_sets_t sets;
    const tumble_keeper_config_t *config;
    tumble_navcomp_t *navcomp;
    tumble_sets_run_t run;
    tumble_sets_owner_t owner;
    uint8_t shown_position; /* 2150h:1 */
    uint8_t shown_entry;    /* 2160h:1 */
    bool decay_told;        /* by an emergency message that is not cleared yet */
    bool disturbed;         /* a part of the run that gave the last result was: see TUMBLE_KEEPER_DISTURBED_ONE_IN */
    uint32_t undisturbed;   /* where the balance below stood when the run, or its repetition, began */
    tumble_parameters_t parameters;
    tumble_at_rest_t at_rest; /* 2152h */
    uint64_t due_us;          /* next step */
} tumble_keeper_t;

static_assert(sizeof(tumble_keeper_t) <= ((sizeof(void *) == 4U) ? 2224U : 2424U), "the keeper must stay small");

/* For tumble_navcomp_config_t.keeping, with a tumble_keeper_t as `keeper`. Its init returns as tumble_sets_init:
 * TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NV. It reads everything that is kept. If the memory is busy, the rest is read
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

/* tumble_sets_inhibit; a run under way is given up and the table stopped, with TUMBLE_REASON_INHIBITED. */
void tumble_keeper_inhibit(tumble_keeper_t *keeper, uint16_t seconds);

/* For navcomp: bring up to date what the sets know of the run. */
void tumble_keeper_look(tumble_keeper_t *keeper);

#endif
