#include "procedure/procedure_internal.h"

#include "core/arith.h"
#include "core/one_copy.h"

#include <stddef.h>
#include <string.h>

#define US_PER_MS 1000U

/* The engine. */

TUMBLE_ONE_COPY static const tumble_row_t *row_of(const tumble_procedure_t *procedure)
{
    return &tumble_procedure_rows[procedure->state];
}

/* Is the table, by its own report, off the angle where the position is measured? */
static bool table_slipped(const tumble_procedure_t *procedure)
{
    const double off_deg = procedure->stand.kind->angle_deg(procedure->stand.self) - procedure->target_deg;
    return !tumble_within(off_deg, procedure->config->position_tolerance_deg);
}

/* The table's angle changes only with a report of the stand, and a step follows every report. So this check, which
 * needs floating point, need not run for samples, which come far more often. */
enum { BETWEEN_REPORTS = WATCH_BUS | WATCH_STAND | WATCH_BLOCK | WATCH_POSITION };

/* Ask the stand, check what the row watches, then at what the state waits for. */
static outcome_t check_row(tumble_procedure_t *procedure, const tumble_row_t *row, unsigned which)
{
    const unsigned watched = row->watch & which;
    procedure->stand_state = (uint8_t)tumble_stand_state(&procedure->stand);
    if (((watched & WATCH_BUS) != 0U) && !procedure->bus_up) {
        return tumble_fail(procedure, TUMBLE_REASON_BUS);
    }
    if (((watched & WATCH_STAND) != 0U) && (procedure->stand_state == (uint8_t)TUMBLE_STAND_FAULT)) {
        return tumble_fail(procedure, tumble_stand_reason(procedure));
    }
    if (((watched & WATCH_STAND) != 0U) && (procedure->stand_state == (uint8_t)TUMBLE_STAND_OFFLINE)) {
        return tumble_fail(procedure, TUMBLE_REASON_STAND_HEARTBEAT);
    }
    if (((watched & WATCH_BLOCK) != 0U) && !procedure->block_alive) {
        return tumble_fail(procedure, TUMBLE_REASON_BLOCK_HEARTBEAT);
    }
    if (((watched & WATCH_ANGLE) != 0U) && table_slipped(procedure)) {
        tumble_stand_lose_position(&procedure->stand);
        procedure->homed = false; /* nobody knows whether it is the table or the count that slipped */
        return tumble_fail(procedure, TUMBLE_REASON_SLIP);
    }
    if (((watched & WATCH_POSITION) != 0U) && (procedure->stand_state != (uint8_t)TUMBLE_STAND_IN_POSITION)) {
        return tumble_refuse_position(procedure, TUMBLE_E_NOT_STILL);
    }
    if (((watched & WATCH_POSITION) != 0U) && (procedure->corrupted > procedure->config->max_corrupted)) {
        return tumble_refuse_position(procedure, TUMBLE_E_CRC);
    }
    return (row->poll != NULL) ? row->poll(procedure) : OUTCOME_STAY;
}

static tumble_state_t next_of(const tumble_row_t *row, outcome_t outcome)
{
    const uint8_t next = (outcome == OUTCOME_DONE) ? row->done : row->other;
    return (outcome == OUTCOME_FAULT) ? TUMBLE_STATE_FAULT : (tumble_state_t)next;
}

/* On to a state, and further by the table until one waits for something, so that the number of steps between two samples
 * makes no difference. Terminates: every cycle contains a state that waits for a sample or for the stand. */
static void go_to(tumble_procedure_t *procedure, tumble_state_t state)
{
    tumble_state_t next = state;
    outcome_t outcome;
    do {
        if (next == TUMBLE_STATE_FAULT) {
            procedure->failed_in = procedure->state;
        }
        procedure->state = next;
        procedure->restart_timer = true;
        const tumble_row_t *row = row_of(procedure);
        outcome = (row->enter != NULL) ? row->enter(procedure) : OUTCOME_STAY;
        if ((outcome == OUTCOME_STAY) && !row->pauses) {
            outcome = check_row(procedure, row, WATCH_ALL);
        }
        next = next_of(row, outcome);
    } while (outcome != OUTCOME_STAY);
}

static void follow(tumble_procedure_t *procedure, outcome_t outcome)
{
    if (outcome != OUTCOME_STAY) {
        go_to(procedure, next_of(row_of(procedure), outcome));
    }
}

/* Time. */

static uint32_t timeout_ms(const tumble_procedure_t *procedure, size_t offset)
{
    uint32_t ms;
    (void)memcpy(&ms, (const unsigned char *)procedure->config + offset, sizeof ms);
    return ms;
}

/* When the state has lasted too long, and when the block has been silent for too long in it. */
static uint64_t late_us(const tumble_procedure_t *procedure)
{
    const size_t offset = row_of(procedure)->timeout;
    const uint64_t lasts_us = (uint64_t)timeout_ms(procedure, offset) * US_PER_MS;
    return (offset != 0U) ? (procedure->entered_us + lasts_us) : UINT64_MAX;
}

static uint64_t silent_us(const tumble_procedure_t *procedure)
{
    const bool watched = (row_of(procedure)->watch & WATCH_SAMPLES) != 0U;
    const uint64_t lasts_us = (uint64_t)procedure->config->sample_timeout_ms * US_PER_MS;
    return watched ? (procedure->heard_us + lasts_us) : UINT64_MAX;
}

/* Timers run from the first step after their cause, so that commands and samples need no clock. */
static void read_clock(tumble_procedure_t *procedure, uint64_t now_us)
{
    procedure->now_us = (now_us > procedure->now_us) ? now_us : procedure->now_us;
    if (procedure->restart_run) {
        procedure->restart_run = false;
        procedure->started_us = procedure->now_us;
    }
    if (procedure->restart_timer) {
        procedure->entered_us = procedure->now_us;
    }
    if (procedure->restart_timer || procedure->heard) {
        procedure->heard_us = procedure->now_us;
    }
    procedure->restart_timer = false;
    procedure->heard = false;
}

static outcome_t end_late(tumble_procedure_t *procedure)
{
    const tumble_row_t *row = row_of(procedure);
    const bool silent = (procedure->now_us >= silent_us(procedure));
    if (!silent && (procedure->now_us < late_us(procedure))) {
        return OUTCOME_STAY;
    }
    tumble_count(&procedure->counters.timeouts);
    if (silent) {
        return tumble_fail(procedure, TUMBLE_REASON_NO_SAMPLES);
    }
    return (row->late != NULL) ? row->late(procedure) : tumble_fail(procedure, (tumble_reason_t)row->late_reason);
}

void tumble_procedure_step(tumble_procedure_t *procedure, uint64_t now_us)
{
    follow(procedure, check_row(procedure, row_of(procedure), WATCH_ALL));
    read_clock(procedure, now_us);
    follow(procedure, end_late(procedure));
}

uint64_t tumble_procedure_next_us(const tumble_procedure_t *procedure)
{
    const uint64_t end_us = tumble_earlier(late_us(procedure), silent_us(procedure));
    return (procedure->restart_timer || row_of(procedure)->pauses) ? 0U : end_us;
}

/* Samples. */

bool tumble_procedure_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample, tumble_taken_t *taken)
{
    tumble_taken_t into = {0, 0};
    const tumble_row_t *row = &tumble_procedure_rows[procedure->state];
    tumble_count(&procedure->counters.samples);
    procedure->heard = true;
    if (row->pauses) {
        return false; /* work for a step */
    }
    outcome_t outcome = check_row(procedure, row, BETWEEN_REPORTS);
    if (outcome != OUTCOME_STAY) {
        follow(procedure, outcome);
        row = row_of(procedure);
    }
    outcome = (row->sample != NULL) ? row->sample(procedure, sample, &into) : OUTCOME_STAY;
    if (outcome != OUTCOME_STAY) {
        follow(procedure, outcome);
    }
    if ((into.ordinal != 0U) && (taken != NULL)) {
        *taken = into;
    }
    return into.ordinal != 0U;
}

void tumble_procedure_sample_faults(tumble_procedure_t *procedure, uint16_t corrupted, uint16_t lost)
{
    follow(procedure, check_row(procedure, row_of(procedure),
                                BETWEEN_REPORTS)); /* they come after whatever the stand did before */
    const uint32_t sum = (uint32_t)procedure->corrupted + corrupted;
    tumble_add_up(&procedure->counters.corrupted, corrupted);
    tumble_add_up(&procedure->counters.lost, lost);
    procedure->corrupted = (sum < UINT16_MAX) ? (uint16_t)sum : UINT16_MAX;
    follow(procedure, check_row(procedure, row_of(procedure), BETWEEN_REPORTS));
}

void tumble_procedure_set_block_alive(tumble_procedure_t *procedure, bool alive)
{
    procedure->block_alive = alive;
}

void tumble_procedure_set_bus_up(tumble_procedure_t *procedure, bool up)
{
    procedure->bus_up = up;
}

void tumble_procedure_set_supervised(tumble_procedure_t *procedure, bool supervised)
{
    procedure->supervised = supervised;
}

/* Commands. */

tumble_status_t tumble_procedure_init(tumble_procedure_t *procedure, const tumble_procedure_config_t *config,
                                      const tumble_stand_t *stand)
{
    if ((procedure == NULL) || (config == NULL) || (stand == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    (void)memset(procedure, 0, sizeof *procedure);
    procedure->config = config;
    procedure->stand = *stand;
    procedure->mounted = TUMBLE_NOT_MOUNTED;
    procedure->block_alive = true;
    procedure->bus_up = true;
    procedure->supervised = true;
    return TUMBLE_OK;
}

static tumble_status_t refuse_command(tumble_procedure_t *procedure, tumble_status_t status)
{
    tumble_count(&procedure->counters.commands_refused);
    return status;
}

static bool allows(const tumble_procedure_t *procedure, unsigned command)
{
    return (row_of(procedure)->commands & command) != 0U;
}

tumble_status_t tumble_procedure_start(tumble_procedure_t *procedure)
{
    if (!allows(procedure, COMMAND_START)) {
        return refuse_command(procedure, TUMBLE_E_STATE);
    }
    procedure->begun = false;
    procedure->warm = false;
    procedure->homed = false;
    procedure->restored = false;
    procedure->solved = false;
    procedure->mounted = TUMBLE_NOT_MOUNTED;
    procedure->index = 0;
    procedure->attempt = 0;
    procedure->restart_run = true;
    go_to(procedure, TUMBLE_STATE_PREFLIGHT);
    return TUMBLE_OK;
}

void tumble_procedure_give_up(tumble_procedure_t *procedure, tumble_reason_t reason)
{
    if (!allows(procedure, COMMAND_ABORT)) {
        return;
    }
    if (procedure->state != TUMBLE_STATE_FAULT) {
        procedure->failed_in = procedure->state;
    }
    procedure->reason = reason;
    go_to(procedure, TUMBLE_STATE_ABORT);
}

tumble_status_t tumble_procedure_abort(tumble_procedure_t *procedure)
{
    if (!allows(procedure, COMMAND_ABORT)) {
        tumble_stand_stop(&procedure->stand);
        return refuse_command(procedure, TUMBLE_E_STATE);
    }
    tumble_procedure_give_up(procedure, TUMBLE_REASON_COMMAND);
    return TUMBLE_OK;
}

tumble_status_t tumble_procedure_resume(tumble_procedure_t *procedure)
{
    const bool failed = (procedure->state == TUMBLE_STATE_FAULT);
    if (!allows(procedure, COMMAND_RESUME) || (!failed && !procedure->restored)) {
        return refuse_command(procedure, TUMBLE_E_STATE);
    }
    procedure->restart_run = procedure->restart_run || !failed;
    tumble_count(&procedure->counters.resumes);
    go_to(procedure, TUMBLE_STATE_PREFLIGHT);
    return TUMBLE_OK;
}

static bool is_about_mounting(tumble_reason_t reason)
{
    return (reason == TUMBLE_REASON_MOUNTING_NOT_CONFIRMED) || (reason == TUMBLE_REASON_WRONG_MOUNTING) ||
           (reason == TUMBLE_REASON_SWAPPED_CHANNELS);
}

TUMBLE_ONE_COPY static void forget_mounting(tumble_procedure_t *procedure, uint8_t mounting_index)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        if (tumble_mounting_index(schedule, p) == mounting_index) {
            tumble_forget_position(procedure, p);
        }
    }
}

tumble_status_t tumble_procedure_confirm_mounting(tumble_procedure_t *procedure, uint8_t mounting)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    const bool failed = (procedure->state == TUMBLE_STATE_FAULT);
    if (!allows(procedure, COMMAND_CONFIRM) || (failed && !is_about_mounting(procedure->reason))) {
        return refuse_command(procedure, TUMBLE_E_STATE);
    }
    if (mounting != schedule->positions[procedure->index].mounting) {
        return refuse_command(procedure, TUMBLE_E_ARGUMENT);
    }
    procedure->mounted = tumble_mounting_index(schedule, procedure->index);
    if (!procedure->restored) {
        forget_mounting(procedure, procedure->mounted); /* it sits a little differently now */
    }
    procedure->restored = false;
    go_to(procedure, failed ? TUMBLE_STATE_PREFLIGHT : TUMBLE_STATE_NEXT);
    return TUMBLE_OK;
}

tumble_status_t tumble_procedure_repeat_position(tumble_procedure_t *procedure, uint8_t index)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    if (!allows(procedure, COMMAND_REPEAT) || !procedure->begun) {
        return refuse_command(procedure, TUMBLE_E_STATE);
    }
    if (index >= schedule->position_count) {
        return refuse_command(procedure, TUMBLE_E_ARGUMENT);
    }
    if (tumble_mounting_index(schedule, index) != procedure->mounted) {
        return refuse_command(procedure, TUMBLE_E_STATE);
    }
    tumble_forget_position(procedure, index);
    go_to(procedure, TUMBLE_STATE_PREFLIGHT);
    return TUMBLE_OK;
}

tumble_status_t tumble_procedure_repeat_mounting(tumble_procedure_t *procedure, uint8_t mounting)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    if (!allows(procedure, COMMAND_REPEAT) || !procedure->begun) {
        return refuse_command(procedure, TUMBLE_E_STATE);
    }
    const uint8_t m = tumble_schedule_find_mounting(schedule, mounting);
    if (m == schedule->mounting_count) {
        return refuse_command(procedure, TUMBLE_E_ARGUMENT);
    }
    forget_mounting(procedure, m);
    if (procedure->mounted == m) {
        procedure->mounted = TUMBLE_NOT_MOUNTED;
    }
    go_to(procedure, TUMBLE_STATE_PREFLIGHT);
    return TUMBLE_OK;
}
