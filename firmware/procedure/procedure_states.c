/* procedure_states.c - every state of a run: what it does, then, in the table at the end, where it leads, how long it may
 * last, what is watched in it and which commands it allows.
 */
#include "procedure/procedure_internal.h"

#include "core/arith.h"
#include "core/one_copy.h"

#include <assert.h>
#include <stddef.h>

#define UNHEALTHY (TUMBLE_SAMPLE_SELF_TEST | TUMBLE_SAMPLE_CONVERTER)

/* What goes wrong in a run, and whether trying again may help. */

outcome_t tumble_fail(tumble_procedure_t *procedure, tumble_reason_t reason)
{
    procedure->reason = reason;
    return OUTCOME_FAULT;
}

tumble_reason_t tumble_stand_reason(const tumble_procedure_t *procedure)
{
    static const uint8_t reasons[TUMBLE_STAND_FAULT_SCALE + 1] = {
        [TUMBLE_STAND_FAULT_NONE] = TUMBLE_REASON_DRIVE_FAULT,
        [TUMBLE_STAND_FAULT_DRIVE] = TUMBLE_REASON_DRIVE_FAULT,
        [TUMBLE_STAND_FAULT_STALL] = TUMBLE_REASON_STALL,
        [TUMBLE_STAND_FAULT_HEARTBEAT] = TUMBLE_REASON_STAND_HEARTBEAT,
        [TUMBLE_STAND_FAULT_HOMING] = TUMBLE_REASON_HOMING,
        [TUMBLE_STAND_FAULT_PROTOCOL] = TUMBLE_REASON_STAND_PROTOCOL,
        [TUMBLE_STAND_FAULT_POWER] = TUMBLE_REASON_DRIVE_POWER,
        [TUMBLE_STAND_FAULT_TIMEOUT] = TUMBLE_REASON_TARGET_NOT_REACHED,
        [TUMBLE_STAND_FAULT_STOP] = TUMBLE_REASON_STOP_NOT_CONFIRMED,
        [TUMBLE_STAND_FAULT_POSITION] = TUMBLE_REASON_SLIP,
        [TUMBLE_STAND_FAULT_FOREIGN] = TUMBLE_REASON_FOREIGN_COMMAND,
        [TUMBLE_STAND_FAULT_RUNAWAY] = TUMBLE_REASON_RUNAWAY,
        [TUMBLE_STAND_FAULT_SCALE] = TUMBLE_REASON_SCALE,
    };
    const unsigned fault = (unsigned)tumble_stand_fault(&procedure->stand);
    return (fault < sizeof reasons) ? (tumble_reason_t)reasons[fault] : TUMBLE_REASON_DRIVE_FAULT;
}

/* What a refusal of a position means, and whether measuring it again may help. The last row stands for any other. */
typedef struct {
    uint8_t status;
    uint8_t reason;
    bool mendable;
} refusal_row_t;

#define REFUSAL(status, reason, mendable) {(uint8_t)TUMBLE_E_##status, (uint8_t)TUMBLE_REASON_##reason, (mendable)}

outcome_t tumble_refuse_position(tumble_procedure_t *procedure, tumble_status_t status)
{
    static const refusal_row_t refusals[] = {
        REFUSAL(LOST, SAMPLES_LOST, true),     REFUSAL(TOO_FEW, SAMPLES_LOST, true),
        REFUSAL(CRC, SAMPLES_CORRUPTED, true), REFUSAL(NOT_STILL, NOT_STILL, true),
        REFUSAL(DEVIATION, NOT_STILL, true),   REFUSAL(SATURATED, SATURATED, false),
        REFUSAL(UNCERTAIN, UNCERTAIN, true),   REFUSAL(STUCK, STUCK, false),
    };
    const size_t last = (sizeof refusals / sizeof refusals[0]) - 1U;
    size_t row = 0;
    while ((row < last) && (refusals[row].status != (uint8_t)status)) {
        row++;
    }
    procedure->status = status;
    tumble_count(&procedure->counters.refused);
    if (refusals[row].mendable && (procedure->attempt < procedure->config->retries)) {
        procedure->attempt++;
        tumble_count(&procedure->counters.retries);
        return OUTCOME_OTHER;
    }
    return tumble_fail(procedure, (tumble_reason_t)refusals[row].reason);
}

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

static outcome_t preflight_enter(tumble_procedure_t *procedure)
{
    procedure->reason = TUMBLE_REASON_NONE;
    procedure->failed_in = TUMBLE_STATE_IDLE;
    procedure->drive_code = 0;
    procedure->block_status = 0;
    procedure->corrupted = 0;
    procedure->marked = false;
    tumble_reason_t reason;
    procedure->status = tumble_procedure_validate(procedure->config, &reason);
    if (procedure->status == TUMBLE_OK) {
        reason = TUMBLE_REASON_CONFIGURATION;
        procedure->status = tumble_begin_averaging(procedure);
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

static bool stand_is_at_rest(const tumble_procedure_t *procedure)
{
    const tumble_stand_state_t state = (tumble_stand_state_t)procedure->stand_state;
    return (state == TUMBLE_STAND_READY) || (state == TUMBLE_STAND_STOPPED) || (state == TUMBLE_STAND_IN_POSITION);
}

/* A stand that is still enforcing a stop refuses: ask again at the next step. Once it has accepted, a new fault is not
 * cleared without a command. */

static outcome_t preflight_poll(tumble_procedure_t *procedure)
{
    if (procedure->clearing) {
        procedure->status = tumble_stand_clear_fault(&procedure->stand);
        procedure->clearing = (procedure->status != TUMBLE_OK);
        procedure->stand_state = (uint8_t)tumble_stand_state(&procedure->stand);
    }
    const bool ready = procedure->marked && procedure->block_alive && stand_is_at_rest(procedure);
    return ready ? OUTCOME_DONE : OUTCOME_STAY;
}

static outcome_t preflight_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
                                  tumble_taken_t *taken)
{
    (void)taken;
    procedure->block_status = sample->raw.status & UNHEALTHY;
    procedure->marked = (procedure->block_status == 0U);
    return preflight_poll(procedure);
}

static outcome_t preflight_late(tumble_procedure_t *procedure)
{
    if (procedure->stand_state == (uint8_t)TUMBLE_STAND_FAULT) {
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

static outcome_t warm_up_enter(tumble_procedure_t *procedure)
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

static outcome_t warm_up_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
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

static outcome_t next_enter(tumble_procedure_t *procedure)
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

static outcome_t wait_mounting_poll(tumble_procedure_t *procedure)
{
    const bool right = procedure->mounted == tumble_mounting_index(procedure->config->schedule, procedure->index);
    return right ? OUTCOME_DONE : OUTCOME_STAY;
}

/* HOME: once per run, and whenever the stand says that it is not homed. */

static outcome_t home_enter(tumble_procedure_t *procedure)
{
    if (procedure->homed && (tumble_stand_state(&procedure->stand) != TUMBLE_STAND_READY)) {
        return OUTCOME_DONE;
    }
    procedure->homed = false;
    tumble_count(&procedure->counters.homings);
    return follow_command(procedure, tumble_stand_home(&procedure->stand));
}

static outcome_t home_poll(tumble_procedure_t *procedure)
{
    procedure->homed = (procedure->stand_state == (uint8_t)TUMBLE_STAND_IN_POSITION);
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

static outcome_t move_enter(tumble_procedure_t *procedure)
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

static outcome_t move_poll(tumble_procedure_t *procedure)
{
    if (procedure->stand_state != (uint8_t)TUMBLE_STAND_IN_POSITION) {
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

static outcome_t settle_enter(tumble_procedure_t *procedure)
{
    procedure->corrupted = 0;
    procedure->settled_ms = 0;
    procedure->marked = false;
    return OUTCOME_STAY;
}

static outcome_t settle_poll(tumble_procedure_t *procedure)
{
    if (procedure->stand_state != (uint8_t)TUMBLE_STAND_IN_POSITION) {
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
static outcome_t settle_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
                               tumble_taken_t *taken)
{
    (void)taken;
    if ((sample->raw.status & (UNHEALTHY | TUMBLE_SAMPLE_TEMPERATURE)) != 0U) {
        return tumble_fail(procedure, TUMBLE_REASON_BLOCK_STATUS);
    }
    if (procedure->stand_state != (uint8_t)TUMBLE_STAND_IN_POSITION) {
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
    return settle_poll(procedure);
}

static outcome_t settle_late(tumble_procedure_t *procedure)
{
    const bool steady = (procedure->stand_state == (uint8_t)TUMBLE_STAND_IN_POSITION);
    return tumble_fail(procedure, steady ? TUMBLE_REASON_NO_SAMPLES : TUMBLE_REASON_TARGET_NOT_REACHED);
}

/* AVERAGE. */

static outcome_t average_enter(tumble_procedure_t *procedure)
{
    (void)tumble_averaging_begin(&procedure->averaging, procedure->index);
    return OUTCOME_STAY;
}

/* Has the position slipped, or was it never what it should be? A mounting that is wrong must be confirmed anew. */
static outcome_t check_position(tumble_procedure_t *procedure)
{
    tumble_reason_t reason = tumble_check_direction(procedure, procedure->index);
    if (reason == TUMBLE_REASON_NONE) {
        reason = tumble_check_closure(procedure, procedure->index);
    }
    if (reason == TUMBLE_REASON_NONE) {
        tumble_count(&procedure->counters.positions);
        return OUTCOME_DONE;
    }
    tumble_count(&procedure->counters.refused);
    tumble_forget_position(procedure, procedure->index);
    if (reason != TUMBLE_REASON_SLIP) {
        procedure->mounted = TUMBLE_NOT_MOUNTED;
    }
    return tumble_fail(procedure, reason);
}

/* Is the mean of every channel as certain as the budget asks? `fixed` where there is no budget. */
static bool is_certain(const tumble_procedure_t *procedure, bool fixed)
{
    double mean_v[TUMBLE_CHANNELS];
    double error_v[TUMBLE_CHANNELS];
    const double budget_v = procedure->config->error_budget_v;
    if (!tumble_is_positive(budget_v)) {
        return fixed;
    }
    bool certain = (tumble_procedure_running(procedure, mean_v, error_v) == TUMBLE_OK);
    for (int i = 0; certain && (i < TUMBLE_CHANNELS); i++) {
        certain = tumble_within(error_v[i], budget_v);
    }
    return certain;
}

static outcome_t finish_position(tumble_procedure_t *procedure)
{
    const bool certain = is_certain(procedure, true);
    tumble_status_t status = tumble_averaging_finish(&procedure->averaging, procedure->config->averaging);
    if ((status == TUMBLE_OK) && !certain) {
        tumble_forget_position(procedure, procedure->index);
        status = TUMBLE_E_UNCERTAIN;
    }
    return (status == TUMBLE_OK) ? check_position(procedure) : tumble_refuse_position(procedure, status);
}

/* A position that will be refused anyway is given up at once. The standard error is looked at every eighth sample only,
 * from the smallest number of samples on: stopping on a small scatter prefers scatters that are small by chance, and the
 * more often one looks, the more the error is understated (docs/method.md, "Averaging as long as needed"). */
static outcome_t average_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
                                tumble_taken_t *taken)
{
    const tumble_averaging_config_t *gates = procedure->config->averaging;
    const tumble_status_t status = tumble_averaging_add(&procedure->averaging, gates, &sample->raw);
    if (status == TUMBLE_E_UNHEALTHY) {
        return ((sample->raw.status & TUMBLE_SAMPLE_SATURATED) != 0U)
                   ? tumble_refuse_position(procedure, TUMBLE_E_SATURATED)
                   : tumble_fail(procedure, TUMBLE_REASON_BLOCK_STATUS);
    }
    const uint32_t samples = procedure->averaging.averages[procedure->index].samples;
    if (status == TUMBLE_OK) {
        tumble_count(&procedure->counters.averaged);
        taken->index = procedure->index;
        taken->ordinal = samples;
    }
    const bool spoilt = (status == TUMBLE_E_SATURATED) || (status == TUMBLE_E_DEVIATION) ||
                        (procedure->averaging.open.lost > gates->max_lost);
    const bool look = (status == TUMBLE_OK) && (samples >= gates->min_samples) &&
                      (((samples - gates->min_samples) % TUMBLE_BUDGET_CHECK_SAMPLES) == 0U);
    const bool complete = spoilt || (samples >= procedure->config->samples) || (look && is_certain(procedure, false));
    return complete ? finish_position(procedure) : OUTCOME_STAY;
}

static outcome_t average_late(tumble_procedure_t *procedure)
{
    return tumble_refuse_position(procedure, TUMBLE_E_TOO_FEW);
}

/* SOLVE, VERIFY, PROPOSE. */

typedef tumble_status_t (*estimator_t)(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                       tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

static outcome_t fail_to_solve(tumble_procedure_t *procedure, tumble_status_t status)
{
    procedure->status = status;
    return tumble_fail(procedure, TUMBLE_REASON_SINGULAR);
}

TUMBLE_ONE_COPY static void make_means(tumble_procedure_t *procedure)
{
    (void)tumble_averaging_means(&procedure->averaging, procedure->config->v_per_count, &procedure->work.means);
}

static tumble_status_t estimate(tumble_procedure_t *procedure)
{
#define ESTIMATOR(number, name, needs, estimate, uncertainty) [TUMBLE_ESTIMATE_##number] = (estimate),
#define NONE_OF_ITS_OWN(number, name, needs) [TUMBLE_ESTIMATE_##number] = NULL,
    static const estimator_t estimators[] = {TUMBLE_ESTIMATOR_LIST(ESTIMATOR, NONE_OF_ITS_OWN)};
    const tumble_procedure_config_t *config = procedure->config;
    const estimator_t own = estimators[config->estimate];
    if (own == NULL) {
        const tumble_lent_t *lent = tumble_procedure_lent(config);
        return lent->estimate(lent->source, config->schedule, &procedure->work.means, &procedure->coefficients);
    }
    return own(config->schedule, &procedure->work.means, &procedure->coefficients, NULL);
}

/* A part for each step, so that none is long. */
static outcome_t solve_poll(tumble_procedure_t *procedure)
{
    tumble_status_t status = TUMBLE_OK;
    outcome_t outcome = OUTCOME_STAY;
    procedure->parts_done++;
    if (procedure->parts_done == 1U) {
        make_means(procedure);
    } else if (procedure->parts_done == 2U) {
        status = estimate(procedure);
    } else {
        status = tumble_calibration_invert(&procedure->coefficients, &procedure->calibration);
        outcome = OUTCOME_DONE;
    }
    return (status == TUMBLE_OK) ? outcome : fail_to_solve(procedure, status);
}

/* The check's result takes the memory of the means, which nothing has touched since SOLVE made them. */
static outcome_t verify_poll(tumble_procedure_t *procedure)
{
    tumble_gravity_check_t found;
    const tumble_status_t status =
        tumble_gravity_check(procedure->config->schedule, &procedure->work.means, &procedure->calibration,
                             procedure->config->gravity_limit_g, &found);
    if (status != TUMBLE_OK) {
        return fail_to_solve(procedure, status);
    }
    procedure->work.found.check = found;
    return OUTCOME_DONE;
}

/* A result that fails the check is offered too: it is readable, with `pass` false. */
static outcome_t propose_poll(tumble_procedure_t *procedure)
{
    procedure->solved = true;
    procedure->reason = procedure->work.found.check.pass ? TUMBLE_REASON_NONE : TUMBLE_REASON_GRAVITY_CHECK;
    return OUTCOME_DONE;
}

/* FAULT and ABORT: the table stops, whatever it was doing. */

static outcome_t fault_enter(tumble_procedure_t *procedure)
{
    tumble_count(&procedure->counters.faults);
    tumble_stand_stop(&procedure->stand);
    return OUTCOME_STAY;
}

/* A drive sends its error code, and what kind of fault it is, in messages of their own, which may come a moment
 * later. */
static outcome_t fault_poll(tumble_procedure_t *procedure)
{
    const bool stand_fault = (procedure->stand_state == (uint8_t)TUMBLE_STAND_FAULT);
    if (stand_fault && (procedure->reason == TUMBLE_REASON_DRIVE_FAULT)) {
        procedure->reason = tumble_stand_reason(procedure);
    }
    if (stand_fault && (procedure->drive_code == 0U)) {
        procedure->drive_code = tumble_stand_report(&procedure->stand)->fault_code;
    }
    return OUTCOME_STAY;
}

static outcome_t abort_enter(tumble_procedure_t *procedure)
{
    tumble_stand_stop(&procedure->stand);
    return OUTCOME_STAY;
}

/* That the table does not stop matters more than why it was told to. */
static outcome_t abort_poll(tumble_procedure_t *procedure)
{
    const bool stand_fault = (procedure->stand_state == (uint8_t)TUMBLE_STAND_FAULT);
    if (stand_fault && (tumble_stand_fault(&procedure->stand) == TUMBLE_STAND_FAULT_STOP)) {
        procedure->reason = TUMBLE_REASON_STOP_NOT_CONFIRMED;
    }
    return OUTCOME_STAY;
}

/* The table. */

#define LASTS(member) (uint8_t)offsetof(tumble_procedure_config_t, member)
#define TO(state) (uint8_t)TUMBLE_STATE_##state
#define BECAUSE(reason) (uint8_t)TUMBLE_REASON_##reason

static_assert(sizeof(tumble_procedure_config_t) <= UINT8_MAX, "an offset into the configuration is one byte");

/* The two commands of a run that may come at any time, and those of a moment when the table is at rest. */
#define IN_MOTION COMMAND_ABORT
#define AT_REST (COMMAND_ABORT | COMMAND_REPEAT)

/* The way of a run. `>`: passed at once when it is so already. Every state of a run leads to FAULT or ABORT too.
 *
 *     IDLE --start--> PREFLIGHT --> WARM_UP --> NEXT --> WAIT_MOUNTING > HOME > MOVE --> SETTLE --> AVERAGE
 *                         ^                     ^  |     (confirmed)   (homed)             ^         |  |
 *                      resume                   |  |                                       + another +  |
 *                         |                     |  | nothing is left                         attempt    |
 *                       FAULT                   |  |                                                    |
 *                                               +--|------------ the position has its mean -------------+
 *                                                  v
 *                                                SOLVE --> VERIFY --> PROPOSE --> DONE
 *
 * No run goes on for ever: attempts are counted, and every state of a run that waits has a timeout.
 */
/* clang-format off */
const tumble_row_t tumble_procedure_rows[TUMBLE_STATE_COUNT] = {
    [TUMBLE_STATE_IDLE] = {
        .commands = COMMAND_START | COMMAND_RESUME, /* a run that lost power */
    },
    [TUMBLE_STATE_PREFLIGHT] = {
        .enter = preflight_enter, .poll = preflight_poll, .sample = preflight_sample,
        .timeout = LASTS(preflight_timeout_ms), .late = preflight_late,
        .done = TO(WARM_UP),
        .watch = WATCH_BUS, .commands = IN_MOTION,
    },
    [TUMBLE_STATE_WARM_UP] = {
        .enter = warm_up_enter, .sample = warm_up_sample,
        .timeout = LASTS(warm_up_timeout_ms), .late_reason = BECAUSE(WARM_UP),
        .done = TO(NEXT),
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK | WATCH_SAMPLES, .commands = IN_MOTION,
    },
    [TUMBLE_STATE_NEXT] = {
        .enter = next_enter,
        .done = TO(WAIT_MOUNTING),
        .other = TO(SOLVE), /* nothing is left to measure */
    },
    [TUMBLE_STATE_WAIT_MOUNTING] = {
        .poll = wait_mounting_poll,
        .timeout = LASTS(mounting_timeout_ms), .late_reason = BECAUSE(MOUNTING_NOT_CONFIRMED),
        .done = TO(HOME),
        .watch = WATCH_BUS | WATCH_STAND, .commands = AT_REST | COMMAND_CONFIRM,
    },
    [TUMBLE_STATE_HOME] = {
        .enter = home_enter, .poll = home_poll,
        .timeout = LASTS(home_timeout_ms), .late_reason = BECAUSE(HOMING),
        .done = TO(MOVE),
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK, .commands = IN_MOTION,
    },
    [TUMBLE_STATE_MOVE] = {
        .enter = move_enter, .poll = move_poll,
        .timeout = LASTS(move_timeout_ms), .late_reason = BECAUSE(TARGET_NOT_REACHED),
        .done = TO(SETTLE),
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK, .commands = IN_MOTION,
    },
    [TUMBLE_STATE_SETTLE] = {
        .enter = settle_enter, .poll = settle_poll, .sample = settle_sample,
        .timeout = LASTS(settle_timeout_ms), .late = settle_late,
        .done = TO(AVERAGE),
        .other = TO(SETTLE), /* another attempt */
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK | WATCH_SAMPLES | WATCH_ANGLE, .commands = AT_REST,
    },
    [TUMBLE_STATE_AVERAGE] = {
        .enter = average_enter, .sample = average_sample,
        .timeout = LASTS(average_timeout_ms), .late = average_late,
        .done = TO(NEXT),
        .other = TO(SETTLE), /* another attempt */
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK | WATCH_SAMPLES | WATCH_ANGLE | WATCH_POSITION,
        .commands = AT_REST,
    },
    [TUMBLE_STATE_SOLVE] = {
        .poll = solve_poll, .done = TO(VERIFY), .pauses = true, .commands = AT_REST,
    },
    [TUMBLE_STATE_VERIFY] = {
        .poll = verify_poll, .done = TO(PROPOSE), .pauses = true, .commands = AT_REST,
    },
    [TUMBLE_STATE_PROPOSE] = {
        .poll = propose_poll, .done = TO(DONE), .pauses = true, .commands = AT_REST,
    },
    [TUMBLE_STATE_DONE] = {
        .commands = COMMAND_START | COMMAND_REPEAT,
    },
    [TUMBLE_STATE_FAULT] = {
        .enter = fault_enter, .poll = fault_poll,
        .commands = AT_REST | COMMAND_CONFIRM | COMMAND_RESUME,
    },
    [TUMBLE_STATE_ABORT] = {
        .enter = abort_enter, .poll = abort_poll,
        .commands = COMMAND_START,
    },
};
/* clang-format on */
