#include "node_log.h"

#include "bench/report.h"
#include "canopen/sdo.h"
#include "canopen/sdo_frame.h"
#include "core/bytes.h"
#include "event_log.h"
#include "remedies.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define NODE 1U
#define COMMAND 2U
#define NAMES_BYTES 400U

void node_log_ready(const node_options_t *options)
{
    if (event_log_is_on() || (!options->start && options->progress_fd != STDERR_FILENO)) {
        event_log_start("tumble-node", STDERR_FILENO);
    }
    const char *const memory = (options->nv != NULL) ? options->nv : "none";
    event_log_always(EVENT_LOG_NOTICE, "ready",
                     EVENT_FIELDS(EVENT_WHOLE("node", NODE), EVENT_TEXT("interface", options->interface),
                                  EVENT_TEXT("memory", memory)),
                     "node %u on %s, memory %s; %s", NODE, options->interface, memory,
                     options->start ? "begins a calibration" : "waits for commands");
}

/* Commands. */

void node_log_frame(node_log_t *log, const tumble_can_frame_t *frame)
{
    if (frame->id == TUMBLE_SDO_REQUEST_ID + NODE && (frame->data[0] & TUMBLE_SDO_COMMAND_MASK) == TUMBLE_SDO_DOWNLOAD_REQUEST &&
        tumble_get_u16(&frame->data[1]) == TUMBLE_NAVCOMP_INDEX_COMMAND && frame->data[3] == COMMAND) {
        log->asked = frame->data[4];
    }
}

void node_log_refused(const node_log_t *log, const tumble_progress_t *now)
{
    const char *const name = tumble_command_name((tumble_command_t)log->asked);
    const char *const state = tumble_state_name(now->state);
    event_log_tell(EVENT_LOG_WARNING, "refused",
                   EVENT_FIELDS(EVENT_TEXT("command", name), EVENT_WHOLE("command_number", log->asked),
                                EVENT_TEXT("state", state)),
                   "refused %s (%u) in %s", name, (unsigned)log->asked, state);
}

/* The run. */

static void tell_fault(const tumble_progress_t *now, bool waits)
{
    const char *const reason = tumble_reason_name(now->reason);
    const char *const failed_in = tumble_state_name(now->failed_in);
    const char *const sentence = tumble_reason_sentence(now->reason);
    const char *const remedy = tumble_reason_remedy(now->reason);
    event_log_always(
        EVENT_LOG_ERROR, "fault",
        EVENT_FIELDS(EVENT_TEXT("state", failed_in), EVENT_WHOLE("mounting", now->mounting),
                     EVENT_WHOLE("position", now->position), EVENT_TEXT("reason", reason),
                     EVENT_WHOLE("reason_number", (uint64_t)now->reason), EVENT_TEXT("sentence", sentence),
                     EVENT_TEXT("remedy", remedy), EVENT_WHOLE("drive_code", now->drive_code)),
        "fault at position %u.%u (%s in %s): %s%s%s%s", now->mounting, now->position, reason, failed_in, sentence,
        waits ? "; waits for RESUME or ABORT" : "", event_log_is_on() ? ". Remedy: " : "",
        event_log_is_on() ? remedy : "");
}

static event_log_level_t level_of(const tumble_progress_t *now)
{
    switch (now->state) {
    case TUMBLE_STATE_DONE:
        return (now->reason == TUMBLE_REASON_NONE) ? EVENT_LOG_NOTICE : EVENT_LOG_WARNING;
    case TUMBLE_STATE_ABORT:
        return EVENT_LOG_WARNING;
    case TUMBLE_STATE_WAIT_MOUNTING:
        return EVENT_LOG_NOTICE; /* somebody has something to do */
    default:
        return EVENT_LOG_INFO;
    }
}

/* Why, in words; nothing where nothing is wrong. */
static void describe(const tumble_progress_t *now, const tumble_progress_t *cause, char *text, size_t size)
{
    const bool is_over = now->state == TUMBLE_STATE_DONE || now->state == TUMBLE_STATE_ABORT;
    *text = '\0';
    if (now->state == TUMBLE_STATE_ABORT && cause->reason != TUMBLE_REASON_NONE) {
        (void)snprintf(text, size, ": %s; first cause at position %u.%u: %s in %s, %s",
                       tumble_reason_sentence(now->reason), cause->mounting, cause->position,
                       tumble_reason_name(cause->reason), tumble_state_name(cause->failed_in),
                       tumble_reason_sentence(cause->reason));
    } else if (is_over && now->reason != TUMBLE_REASON_NONE) {
        (void)snprintf(text, size, ": %s. Remedy: %s", tumble_reason_sentence(now->reason),
                       tumble_reason_remedy(now->reason));
    }
}

void node_log_state(const tumble_progress_t *now, const tumble_progress_t *cause, bool waits)
{
    char why[EVENT_LOG_TEXT_BYTES];
    const char *const name = tumble_state_name(now->state);
    if (now->state == TUMBLE_STATE_FAULT) {
        tell_fault(now, waits);
        return;
    }
    describe(now, cause, why, sizeof why);
    event_log_tell(level_of(now), "state",
                   EVENT_FIELDS(EVENT_TEXT("state", name), EVENT_WHOLE("mounting", now->mounting),
                                EVENT_WHOLE("position", now->position), EVENT_WHOLE("index", now->index),
                                EVENT_WHOLE("count", now->count), EVENT_WHOLE("finished", now->finished),
                                EVENT_WHOLE("attempt", now->attempt),
                                EVENT_TEXT("reason", tumble_reason_name(now->reason)),
                                EVENT_TEXT("cause", tumble_reason_name(cause->reason))),
                   "%s at position %u.%u, %u of %u finished: %s%s", name, now->mounting, now->position, now->finished,
                   now->count, tumble_state_sentence(now->state), why);
}

/* What is kept. */

/* Name and sentence of each, until there is no more room. */
static void list_objections(uint16_t objections, char *text, size_t size)
{
    size_t used = 0;
    *text = '\0';
    for (unsigned bit = 0; bit < (unsigned)TUMBLE_OBJECTION_COUNT && used < size; bit++) {
        if ((objections & TUMBLE_OBJECTION_BIT(bit)) != 0U) {
            used += (size_t)snprintf(&text[used], size - used, "%s%s, %s", (used > 0U) ? "; " : "",
                                     tumble_objection_name((tumble_objection_t)bit),
                                     tumble_objection_sentence((tumble_objection_t)bit));
        }
    }
}

static void tell_held(const tumble_sets_state_t *state)
{
    char objections[NAMES_BYTES];
    list_objections(state->objections, objections, sizeof objections);
    event_log_tell(EVENT_LOG_WARNING, "held",
                   EVENT_FIELDS(EVENT_WHOLE("objections", state->objections), EVENT_TEXT("sentence", objections)),
                   "the result is held, ACCEPT or DISCARD it: %s", objections);
}

static void tell_commit(const tumble_sets_state_t *state, const char *how)
{
    event_log_tell(EVENT_LOG_NOTICE, "commit",
                   EVENT_FIELDS(EVENT_TEXT("how", how), EVENT_WHOLE("calibration_counter", state->counter)),
                   "%s: calibration counter %" PRIu32, how, state->counter);
}

static void tell_memory(const tumble_sets_state_t *state)
{
    const tumble_status_t status = (tumble_status_t)state->status;
    event_log_tell(EVENT_LOG_ERROR, "memory",
                   EVENT_FIELDS(EVENT_TEXT("status", tumble_status_name(status)),
                                EVENT_TEXT("sentence", tumble_status_sentence(status))),
                   "the memory failed: %s, %s; the active set is unchanged", tumble_status_name(status),
                   tumble_status_sentence(status));
}

static void tell_verdict(const tumble_sets_state_t *state)
{
    switch ((tumble_verdict_t)state->verdict) {
    case TUMBLE_VERDICT_COMMITTED:
        tell_commit(state, "the result is committed");
        break;
    case TUMBLE_VERDICT_ACCEPTED:
        tell_commit(state, "the proposal is accepted");
        break;
    case TUMBLE_VERDICT_ROLLED_BACK:
        tell_commit(state, "the set before is active again");
        break;
    case TUMBLE_VERDICT_HELD:
        tell_held(state);
        break;
    case TUMBLE_VERDICT_REPEATED:
        event_log_tell(EVENT_LOG_WARNING, "repeated", NULL, "the result is one of before, to the last bit: not stored");
        break;
    case TUMBLE_VERDICT_DISCARDED:
        event_log_tell(EVENT_LOG_NOTICE, "discarded", NULL, "the proposal is discarded");
        break;
    case TUMBLE_VERDICT_FAILED:
        tell_memory(state);
        break;
    case TUMBLE_VERDICT_NONE:
    case TUMBLE_VERDICT_WORKING:
    default:
        break;
    }
}

static void look_at_level(node_log_t *log, const tumble_navcomp_t *navcomp)
{
    const bool is_open = tumble_service_is_open(navcomp);
    if (is_open && !log->is_unlocked) {
        event_log_tell(EVENT_LOG_NOTICE, "unlock", EVENT_FIELDS(EVENT_WHOLE("seconds", TUMBLE_SERVICE_S)),
                       "the service level is open, for %u s", TUMBLE_SERVICE_S);
    } else if (!is_open && log->is_unlocked) {
        event_log_tell(EVENT_LOG_NOTICE, "lock", NULL, "the service level is over");
    }
    log->is_unlocked = is_open;
}

void node_log_look(node_log_t *log, const tumble_navcomp_t *navcomp, const tumble_sets_t *sets)
{
    tumble_sets_state_t state;
    if (!event_log_is_on()) {
        return;
    }
    look_at_level(log, navcomp);
    if (sets == NULL) {
        return;
    }
    tumble_sets_state(sets, &state);
    if (state.verdict != log->verdict) {
        tell_verdict(&state);
    }
    log->verdict = state.verdict;
}

/* The end. */

void node_log_end(const bench_world_t *world, const tumble_progress_t *cause)
{
    const int code = bench_exit_code(world);
    const char *const end = bench_end_name(world->end);
    if (cause->reason == TUMBLE_REASON_NONE) {
        event_log_tell((code == BENCH_EXIT_FAULT) ? EVENT_LOG_ERROR : EVENT_LOG_NOTICE, "end",
                       EVENT_FIELDS(EVENT_TEXT("end", end), EVENT_WHOLE("exit", (uint64_t)code)),
                       "ends with exit code %d (%s)", code, end);
        return;
    }
    const char *const reason = tumble_reason_name(cause->reason);
    const char *const failed_in = tumble_state_name(cause->failed_in);
    const char *const sentence = tumble_reason_sentence(cause->reason);
    const char *const remedy = tumble_reason_remedy(cause->reason);
    event_log_tell((code == BENCH_EXIT_FAULT) ? EVENT_LOG_ERROR : EVENT_LOG_WARNING, "end",
                   EVENT_FIELDS(EVENT_TEXT("end", end), EVENT_WHOLE("exit", (uint64_t)code),
                                EVENT_TEXT("state", failed_in), EVENT_WHOLE("mounting", cause->mounting),
                                EVENT_WHOLE("position", cause->position), EVENT_TEXT("cause", reason),
                                EVENT_WHOLE("cause_number", (uint64_t)cause->reason), EVENT_TEXT("sentence", sentence),
                                EVENT_TEXT("remedy", remedy), EVENT_WHOLE("drive_code", cause->drive_code)),
                   "ends with exit code %d (%s); cause, at position %u.%u: %s in %s, %s. Remedy: %s", code, end,
                   cause->mounting, cause->position, reason, failed_in, sentence, remedy);
}
