#include "procedure/procedure_internal.h"

#include "core/arith.h"

#define UNHEALTHY (TUMBLE_SAMPLE_SELF_TEST | TUMBLE_SAMPLE_CONVERTER)

/* The stand should have taken this command: it was there and at rest. */
static outcome_t follow_command(tumble_procedure_t *procedure, tumble_status_t status)
{
    if (status == TUMBLE_OK) {
        return OUTCOME_STAY;
    }
    procedure->status = status;
    return tumble_fail(procedure, TUMBLE_REASON_STAND_PROTOCOL);
}

/* PREFLIGHT: the data are usable, the stand is up and at rest, the block talks. */

static tumble_status_t begin_averaging(tumble_procedure_t *procedure)
{
    if (procedure->begun) {
        return TUMBLE_OK;
    }
    const tumble_status_t status = tumble_averaging_init(&procedure->averaging, procedure->config->averaging);
    procedure->begun = (status == TUMBLE_OK);
    return status;
}

outcome_t tumble_preflight_enter(tumble_procedure_t *procedure)
{
    procedure->reason = TUMBLE_REASON_NONE;
    procedure->failed_in = TUMBLE_STATE_IDLE;
    procedure->drive_code = 0;
    procedure->block_status = 0;
    procedure->corrupted = 0;
    procedure->marked = false;
    tumble_reason_t reason;
    procedure->status = tumble_examine(procedure->config, &reason, &procedure->refusal);
    if (procedure->status == TUMBLE_OK) {
        reason = TUMBLE_REASON_CONFIGURATION;
        procedure->status = begin_averaging(procedure);
    }
    if (procedure->status != TUMBLE_OK) {
        return tumble_fail(procedure, reason);
    }
    if (!procedure->supervised) {
        return tumble_fail(procedure, TUMBLE_REASON_SUPERVISION);
    }
    procedure->clearing = (tumble_stand_state(&procedure->stand) == TUMBLE_STAND_FAULT);
    return OUTCOME_STAY;
}

/* A stand that is still enforcing a stop refuses: ask again at the next step. Once it has accepted, a new fault is not
 * cleared without a command. */
static void clear_fault(tumble_procedure_t *procedure)
{
    if (procedure->clearing) {
        procedure->status = tumble_stand_clear_fault(&procedure->stand);
        procedure->clearing = (procedure->status != TUMBLE_OK);
    }
}

static bool stand_is_at_rest(const tumble_procedure_t *procedure)
{
    const tumble_stand_state_t state = tumble_stand_state(&procedure->stand);
    return (state == TUMBLE_STAND_READY) || (state == TUMBLE_STAND_STOPPED) || (state == TUMBLE_STAND_IN_POSITION);
}

outcome_t tumble_preflight_poll(tumble_procedure_t *procedure)
{
    clear_fault(procedure);
    const bool ready = procedure->marked && procedure->block_alive && stand_is_at_rest(procedure);
    return ready ? OUTCOME_DONE : OUTCOME_STAY;
}

outcome_t tumble_preflight_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
                                  tumble_taken_t *taken)
{
    (void)taken;
    procedure->block_status = sample->raw.status & UNHEALTHY;
    procedure->marked = (procedure->block_status == 0U);
    return tumble_preflight_poll(procedure);
}

outcome_t tumble_preflight_late(tumble_procedure_t *procedure)
{
    if (tumble_stand_state(&procedure->stand) == TUMBLE_STAND_FAULT) {
        return tumble_fail(procedure, tumble_stand_reason(procedure));
    }
    if (!stand_is_at_rest(procedure)) {
        return tumble_fail(procedure, TUMBLE_REASON_STAND_OFFLINE);
    }
    if (!procedure->block_alive) {
        return tumble_fail(procedure, TUMBLE_REASON_BLOCK_HEARTBEAT);
    }
    if (procedure->block_status != 0U) {
        return tumble_fail(procedure, TUMBLE_REASON_BLOCK_STATUS);
    }
    const bool spoilt = procedure->corrupted > procedure->config->max_corrupted;
    return tumble_fail(procedure, spoilt ? TUMBLE_REASON_SAMPLES_CORRUPTED : TUMBLE_REASON_NO_SAMPLES);
}

/* WARM_UP: the temperature stays within a band for so many samples in a row. */

outcome_t tumble_warm_up_enter(tumble_procedure_t *procedure)
{
    procedure->warm_run = 0;
    return (procedure->warm || (procedure->config->warm_up_samples == 0U)) ? OUTCOME_DONE : OUTCOME_STAY;
}

static void follow_temperature(tumble_procedure_t *procedure, int8_t now_half_c)
{
    if ((procedure->warm_run == 0U) || (now_half_c < procedure->coldest_half_c)) {
        procedure->coldest_half_c = now_half_c;
    }
    if ((procedure->warm_run == 0U) || (now_half_c > procedure->warmest_half_c)) {
        procedure->warmest_half_c = now_half_c;
    }
    const int spread = (int)procedure->warmest_half_c - (int)procedure->coldest_half_c;
    if (spread > procedure->config->warm_up_band_half_c) {
        procedure->coldest_half_c = now_half_c;
        procedure->warmest_half_c = now_half_c;
        procedure->warm_run = 0;
    }
    procedure->warm_run++;
}

outcome_t tumble_warm_up_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
                                tumble_taken_t *taken)
{
    (void)taken;
    if ((sample->raw.status & UNHEALTHY) != 0U) {
        return tumble_fail(procedure, TUMBLE_REASON_BLOCK_STATUS);
    }
    if ((sample->raw.status & TUMBLE_SAMPLE_TEMPERATURE) != 0U) {
        procedure->warm_run = 0;
        return OUTCOME_STAY;
    }
    follow_temperature(procedure, sample->temperature_half_c);
    procedure->warm = (procedure->warm_run >= procedure->config->warm_up_samples);
    return procedure->warm ? OUTCOME_DONE : OUTCOME_STAY;
}

/* NEXT and WAIT_MOUNTING: first the positions that are left of the mounting on the table, then those of the others, so
 * that nobody has to mount the block more often than needed. */

outcome_t tumble_next_enter(tumble_procedure_t *procedure)
{
    const uint8_t count = procedure->config->schedule->position_count;
    uint8_t next = tumble_first_unmeasured(procedure, procedure->mounted);
    if (next == count) {
        next = tumble_first_unmeasured(procedure, TUMBLE_NOT_MOUNTED);
    }
    if (next == count) {
        procedure->parts_done = 0;
        return OUTCOME_OTHER;
    }
    procedure->index = next;
    procedure->attempt = 0;
    return OUTCOME_DONE;
}

outcome_t tumble_wait_mounting_poll(tumble_procedure_t *procedure)
{
    const bool right = procedure->mounted == tumble_mounting_index(procedure->config->schedule, procedure->index);
    return right ? OUTCOME_DONE : OUTCOME_STAY;
}

/* HOME: once per run, and whenever the stand says that it is not homed. */

outcome_t tumble_home_enter(tumble_procedure_t *procedure)
{
    if (procedure->homed && (tumble_stand_state(&procedure->stand) != TUMBLE_STAND_READY)) {
        return OUTCOME_DONE;
    }
    procedure->homed = false;
    tumble_count(&procedure->counters.homings);
    return follow_command(procedure, tumble_stand_home(&procedure->stand));
}

outcome_t tumble_home_poll(tumble_procedure_t *procedure)
{
    procedure->homed = (tumble_stand_state(&procedure->stand) == TUMBLE_STAND_IN_POSITION);
    return procedure->homed ? OUTCOME_DONE : OUTCOME_STAY;
}

/* MOVE: always up to the angle. Play in a gear leaves the table at two places, one for each direction; coming from
 * below every time, all positions have the same error, which is one error of the table's zero.
 *
 *     angle
 *       ^                                       o  here: above the target
 *       |                                        :
 *     target  - - - - - - - - +--- measured - - - : - - - - - - - - - - +--- measured
 *       |                    /                     :                   /
 *       |                   /                       :                 /  second move
 *     target - approach_deg  - - - - - - - - - - - - +---------------+
 *       |                 /                             first move, `leading_in`
 *       |   o-------------   here: far enough below, one move
 *
 * A `here` between the two lines, or one that is no number, leads in as well: what is not known to be below is above.
 */

static outcome_t command_move(tumble_procedure_t *procedure, double angle_deg)
{
    procedure->restart_timer = true;
    tumble_count(&procedure->counters.moves);
    return follow_command(procedure, tumble_stand_move(&procedure->stand, angle_deg));
}

outcome_t tumble_move_enter(tumble_procedure_t *procedure)
{
    const tumble_procedure_config_t *config = procedure->config;
    const double scheduled_deg = config->schedule->positions[procedure->index].angle.deg;
    double target_deg = scheduled_deg;
    (void)tumble_choose_turn(config, scheduled_deg, &target_deg); /* PREFLIGHT has seen that there is one */
    tumble_add_up(&procedure->counters.unwinds, tumble_within(target_deg - scheduled_deg, 0.0) ? 0U : 1U);
    procedure->target_deg = target_deg;
    const double below_deg = target_deg - config->approach_deg;
    const double here_deg = procedure->stand.kind->angle_deg(procedure->stand.self);
    procedure->leading_in = tumble_is_positive(config->approach_deg) &&
                            (tumble_exceeds(here_deg, below_deg) || !tumble_is_finite(here_deg));
    return command_move(procedure, procedure->leading_in ? below_deg : target_deg);
}

outcome_t tumble_move_poll(tumble_procedure_t *procedure)
{
    if (tumble_stand_state(&procedure->stand) != TUMBLE_STAND_IN_POSITION) {
        return OUTCOME_STAY;
    }
    if (procedure->leading_in) {
        procedure->leading_in = false;
        return command_move(procedure, procedure->target_deg);
    }
    return OUTCOME_DONE;
}

/* SETTLE: wait until settle_ms of the block's own time have passed since the stand came into position and stayed there.
 * The local clock does not count here: a replayed log must settle at the same sample. */

outcome_t tumble_settle_enter(tumble_procedure_t *procedure)
{
    procedure->corrupted = 0;
    procedure->settled_ms = 0;
    procedure->marked = false;
    return OUTCOME_STAY;
}

outcome_t tumble_settle_poll(tumble_procedure_t *procedure)
{
    if (tumble_stand_state(&procedure->stand) != TUMBLE_STAND_IN_POSITION) {
        procedure->settled_ms = 0;
        procedure->marked = false;
        return OUTCOME_STAY;
    }
    if (procedure->corrupted > procedure->config->max_corrupted) {
        return tumble_refuse_position(procedure, TUMBLE_E_CRC);
    }
    return (procedure->settled_ms >= procedure->config->settle_ms) ? OUTCOME_DONE : OUTCOME_STAY;
}

/* The block's timestamp wraps after 4.096 s, so times are added up from sample to sample. A sample that came twice or
 * late (its counter is not ahead of the last one's) would add nearly a whole period: it tells no time. */
outcome_t tumble_settle_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
                               tumble_taken_t *taken)
{
    (void)taken;
    if ((sample->raw.status & (UNHEALTHY | TUMBLE_SAMPLE_TEMPERATURE)) != 0U) {
        return tumble_fail(procedure, TUMBLE_REASON_BLOCK_STATUS);
    }
    if (tumble_stand_state(&procedure->stand) != TUMBLE_STAND_IN_POSITION) {
        return OUTCOME_STAY;
    }
    const uint16_t ahead = (uint16_t)(sample->raw.counter - procedure->last_counter);
    const bool fresh = (ahead != 0U) && (ahead <= (uint16_t)INT16_MAX);
    if (procedure->marked && fresh) {
        const uint32_t passed_ms = (uint32_t)sample->timestamp_ms - procedure->last_timestamp_ms;
        procedure->settled_ms += passed_ms % TUMBLE_TIMESTAMP_PERIOD_MS;
    }
    if (fresh || !procedure->marked) {
        procedure->marked = true;
        procedure->last_counter = sample->raw.counter;
        procedure->last_timestamp_ms = sample->timestamp_ms;
    }
    return tumble_settle_poll(procedure);
}

outcome_t tumble_settle_late(tumble_procedure_t *procedure)
{
    const bool steady = (tumble_stand_state(&procedure->stand) == TUMBLE_STAND_IN_POSITION);
    return tumble_fail(procedure, steady ? TUMBLE_REASON_NO_SAMPLES : TUMBLE_REASON_TARGET_NOT_REACHED);
}

/* FAULT and ABORT: the table stops, whatever it was doing. */

outcome_t tumble_fault_enter(tumble_procedure_t *procedure)
{
    tumble_count(&procedure->counters.faults);
    tumble_stand_stop(&procedure->stand);
    return OUTCOME_STAY;
}

/* A drive sends its error code, and what kind of fault it is, in messages of their own, which may come a moment
 * later. */
outcome_t tumble_fault_poll(tumble_procedure_t *procedure)
{
    const bool stand_fault = (tumble_stand_state(&procedure->stand) == TUMBLE_STAND_FAULT);
    if (stand_fault && (procedure->reason == TUMBLE_REASON_DRIVE_FAULT)) {
        procedure->reason = tumble_stand_reason(procedure);
    }
    if (stand_fault && (procedure->drive_code == 0U)) {
        procedure->drive_code = tumble_stand_report(&procedure->stand)->fault_code;
    }
    return OUTCOME_STAY;
}

outcome_t tumble_abort_enter(tumble_procedure_t *procedure)
{
    tumble_stand_stop(&procedure->stand);
    return OUTCOME_STAY;
}

/* That the table does not stop matters more than why it was told to. */
outcome_t tumble_abort_poll(tumble_procedure_t *procedure)
{
    const bool stand_fault = (tumble_stand_state(&procedure->stand) == TUMBLE_STAND_FAULT);
    if (stand_fault && (tumble_stand_fault(&procedure->stand) == TUMBLE_STAND_FAULT_STOP)) {
        procedure->reason = TUMBLE_REASON_STOP_NOT_CONFIRMED;
    }
    return OUTCOME_STAY;
}
