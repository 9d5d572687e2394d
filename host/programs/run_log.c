#include "run_log.h"

#include "event_log.h"

#include <inttypes.h>
#include <stdio.h>

#define NAMES_BYTES (EVENT_LOG_TEXT_BYTES - sizeof HELD)
#define HELD "the result is held, ACCEPT or DISCARD it: "
#define MORE_BYTES (sizeof "; and 99 more")

/* The run. */

bool run_log_is_news(const tumble_progress_t *now, const tumble_progress_t *before)
{
    return now->state != before->state || now->index != before->index || now->attempt != before->attempt ||
           now->reason != before->reason || (now->state == TUMBLE_STATE_FAULT && now->failed_in != before->failed_in);
}

static void tell_fault(const tumble_progress_t *now, bool waits)
{
    const char *const reason = tumble_reason_name(now->reason);
    const char *const failed_in = tumble_state_name(now->failed_in);
    const char *const sentence = tumble_reason_sentence(now->reason);
    const char *const remedy = tumble_reason_remedy(now->reason);
    event_log_always(EVENT_LOG_ERROR, "fault",
                     EVENT_FIELDS(EVENT_TEXT("state", failed_in), EVENT_WHOLE("mounting", now->mounting),
                                  EVENT_WHOLE("position", now->position), EVENT_TEXT("reason", reason),
                                  EVENT_WHOLE("reason_number", (uint64_t)now->reason), EVENT_TEXT("sentence", sentence),
                                  EVENT_TEXT("remedy", remedy), EVENT_WHOLE("drive_code", now->drive_code)),
                     "fault at position %u.%u (%s in %s): %s%s%s%s", now->mounting, now->position, reason, failed_in,
                     sentence, waits ? "; waits for RESUME or ABORT" : "", event_log_is_on() ? ". Remedy: " : "",
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

/* Why, in words; nothing where nothing is wrong, or where the command to give up may have followed from a fault that
 * nobody here has seen. */
static void describe(const tumble_progress_t *now, const tumble_progress_t *cause, char *text, size_t size)
{
    const bool is_over = now->state == TUMBLE_STATE_DONE || now->state == TUMBLE_STATE_ABORT;
    *text = '\0';
    if (now->state == TUMBLE_STATE_ABORT && cause == NULL) {
        (void)snprintf(text, size, ": %s", tumble_reason_sentence(now->reason));
    } else if (now->state == TUMBLE_STATE_ABORT && cause->reason != TUMBLE_REASON_NONE) {
        (void)snprintf(text, size, ": %s; first cause at position %u.%u: %s in %s, %s",
                       tumble_reason_sentence(now->reason), cause->mounting, cause->position,
                       tumble_reason_name(cause->reason), tumble_state_name(cause->failed_in),
                       tumble_reason_sentence(cause->reason));
    } else if (is_over && now->reason != TUMBLE_REASON_NONE) {
        (void)snprintf(text, size, ": %s. Remedy: %s", tumble_reason_sentence(now->reason),
                       tumble_reason_remedy(now->reason));
    }
}

void run_log_state(const tumble_progress_t *now, const tumble_progress_t *cause, bool waits)
{
    char why[EVENT_LOG_TEXT_BYTES];
    const char *const name = tumble_state_name(now->state);
    if (now->state == TUMBLE_STATE_FAULT) {
        tell_fault(now, waits);
        return;
    }
    describe(now, cause, why, sizeof why);
    event_log_tell(
        level_of(now), "state",
        EVENT_FIELDS(
            EVENT_TEXT("state", name), EVENT_WHOLE("mounting", now->mounting), EVENT_WHOLE("position", now->position),
            EVENT_WHOLE("index", now->index), EVENT_WHOLE("count", now->count), EVENT_WHOLE("finished", now->finished),
            EVENT_WHOLE("attempt", now->attempt), EVENT_TEXT("reason", tumble_reason_name(now->reason)),
            EVENT_TEXT((cause != NULL) ? "cause" : NULL, (cause != NULL) ? tumble_reason_name(cause->reason) : NULL)),
        "%s at position %u.%u, %u of %u finished: %s%s", name, now->mounting, now->position, now->finished, now->count,
        tumble_state_sentence(now->state), why);
}

/* What is kept. */

static unsigned count_bits(uint32_t bits)
{
    unsigned count = 0;
    for (uint32_t left = bits; left != 0U; left &= left - 1U) {
        count++;
    }
    return count;
}

/* Name and sentence of each that fits whole, and how many more there are. */
static void list_objections(uint32_t objections, char *text, size_t size)
{
    unsigned left = count_bits(objections);
    size_t used = 0;
    *text = '\0';
    for (unsigned bit = 0; left > 0U; bit++) {
        if ((objections & TUMBLE_OBJECTION_BIT(bit)) == 0U) {
            continue;
        }
        const char *const between = (used > 0U) ? "; " : "";
        const size_t room = size - used - ((left > 1U) ? MORE_BYTES : 0U);
        const int length =
            snprintf(&text[used], room, "%s%s, %s", between, tumble_objection_name((tumble_objection_t)bit),
                     tumble_objection_sentence((tumble_objection_t)bit));
        if ((size_t)length >= room) {
            (void)snprintf(&text[used], size - used, "%sand %u more", between, left);
            return;
        }
        used += (size_t)length;
        left--;
    }
}

static void tell_held(const tumble_sets_state_t *state)
{
    const uint32_t bits = state->objections | ((uint32_t)state->more_objections << TUMBLE_OBJECTION_MORE);
    char objections[NAMES_BYTES];
    list_objections(bits, objections, sizeof objections);
    event_log_tell(EVENT_LOG_WARNING, "held",
                   EVENT_FIELDS(EVENT_WHOLE("objections", bits), EVENT_TEXT("sentence", objections)), HELD "%s",
                   objections);
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

static bool is_commit(uint8_t verdict)
{
    return verdict == (uint8_t)TUMBLE_VERDICT_COMMITTED || verdict == (uint8_t)TUMBLE_VERDICT_ACCEPTED ||
           verdict == (uint8_t)TUMBLE_VERDICT_ROLLED_BACK;
}

void run_log_sets(run_log_sets_t *told, const tumble_sets_state_t *state)
{
    const bool commits = is_commit(state->verdict);
    const bool is_open = commits || state->verdict == (uint8_t)TUMBLE_VERDICT_WORKING; /* a counter may be to come */
    const bool is_news = commits ? state->counter > told->counter : state->verdict != told->verdict;
    if (told->has_begun && is_news) {
        tell_verdict(state);
    }
    if (!told->has_begun || !is_open || (commits && is_news)) {
        told->counter = state->counter;
    }
    told->has_begun = true;
    told->verdict = state->verdict;
}

/* The interface. */

void link_log_update(link_log_t *told, const can_socket_t *can)
{
    if (can->counters.downs != told->downs) {
        event_log_tell(EVENT_LOG_WARNING, "link", EVENT_FIELDS(EVENT_TEXT("link", "down")), "the interface %s is down",
                       can->name);
        told->is_down = true;
    }
    told->downs = can->counters.downs;
    if (told->is_down && !can->is_down) {
        event_log_tell(EVENT_LOG_NOTICE, "link", EVENT_FIELDS(EVENT_TEXT("link", "up")), "the interface %s is up again",
                       can->name);
        told->is_down = false;
    }
}

void link_report(bench_json_t *json, const can_socket_counters_t *counters)
{
    bench_json_whole(json, "kernel_received", counters->received);
    bench_json_whole(json, "kernel_sent", counters->sent);
    bench_json_whole(json, "kernel_dropped", counters->dropped);
    bench_json_whole(json, "kernel_busy", counters->busy);
    bench_json_whole(json, "error_frames", counters->errors);
    bench_json_whole(json, "bus_offs", counters->bus_offs);
    bench_json_whole(json, "interface_downs", counters->downs);
}
