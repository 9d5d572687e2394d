#include "gateway_log.h"

#include "event_log.h"
#include "run_log.h"

#include <inttypes.h>
#include <stdio.h>

#define COMMAND_OBJECT 0x2002U
#define COMMAND_SUBINDEX 2U
#define WHAT_BYTES 60U

/* Clients. */

void gateway_log_connected(const gateway_address_t *address, uint16_t clients)
{
    event_log_tell(EVENT_LOG_INFO, "connected",
                   EVENT_FIELDS(EVENT_TEXT("client", address->text), EVENT_WHOLE("clients", clients)),
                   "client %s connected, %u in all", address->text, (unsigned)clients);
}

void gateway_log_disconnected(const gateway_address_t *address, const char *why, uint16_t clients)
{
    event_log_tell(
        EVENT_LOG_INFO, "disconnected",
        EVENT_FIELDS(EVENT_TEXT("client", address->text), EVENT_TEXT("why", why), EVENT_WHOLE("clients", clients)),
        "client %s disconnected, %s; %u left", address->text, why, (unsigned)clients);
}

void gateway_log_turned_away(const gateway_address_t *address)
{
    event_log_tell(EVENT_LOG_WARNING, "turned_away", EVENT_FIELDS(EVENT_TEXT("client", address->text)),
                   "client %s is turned away: all places are taken", address->text);
}

/* What they write. */

static void what_was_refused(const gateway_refusal_t *refusal, char what[WHAT_BYTES])
{
    if (refusal->command != 0U && refusal->command <= UINT8_MAX) {
        (void)snprintf(what, WHAT_BYTES, "%s (%u)", tumble_command_name((tumble_command_t)refusal->command),
                       (unsigned)refusal->command);
    } else {
        (void)snprintf(what, WHAT_BYTES, "registers %u to %u", (unsigned)refusal->at,
                       (unsigned)refusal->at + refusal->count - 1U);
    }
}

/* By an exception, of one that is unlocked. */
static void tell_exception(const gateway_refusal_t *refusal, const char *who)
{
    static const char *const reasons[] = {
        [GATEWAY_ILLEGAL_ADDRESS] = "these registers cannot be written together",
        [GATEWAY_ILLEGAL_VALUE] = "a value is out of its range",
        [GATEWAY_BUSY] = "another command is under way",
        [GATEWAY_TARGET_FAILED] = "the node does not answer",
    };
    const char *const why = reasons[refusal->exception];
    char what[WHAT_BYTES];
    what_was_refused(refusal, what);
    event_log_tell(EVENT_LOG_WARNING, "refused",
                   EVENT_FIELDS(EVENT_TEXT("client", who), EVENT_TEXT("command", what), EVENT_TEXT("why", why),
                                EVENT_WHOLE("exception", refusal->exception)),
                   "%s: %s refused with exception %02Xh: %s", who, what, (unsigned)refusal->exception, why);
}

static void tell_refusal(const gateway_refusal_t *refusal, const char *who)
{
    if (refusal->has_wrong_keys) {
        event_log_tell(EVENT_LOG_WARNING, "refused",
                       EVENT_FIELDS(EVENT_TEXT("client", who), EVENT_TEXT("why", "wrong keys")), "%s: wrong keys", who);
    } else if (refusal->exception == (uint8_t)GATEWAY_ILLEGAL_FUNCTION) {
        event_log_tell(EVENT_LOG_WARNING, "refused",
                       EVENT_FIELDS(EVENT_TEXT("client", who), EVENT_TEXT("why", "locked")),
                       "%s: writing refused, the session is locked or commands are not allowed", who);
    } else {
        tell_exception(refusal, who);
    }
}

/* The last thing that is written is what was meant. */
static void describe(const gateway_command_t *sent, char what[WHAT_BYTES])
{
    const gateway_write_t *const one = &sent->writes[(sent->count > 0U) ? sent->count - 1U : 0U];
    if (one->index == COMMAND_OBJECT && one->subindex == COMMAND_SUBINDEX) {
        (void)snprintf(what, WHAT_BYTES, "%s (%u)", tumble_command_name((tumble_command_t)one->bytes[0]),
                       (unsigned)one->bytes[0]);
    } else {
        (void)snprintf(what, WHAT_BYTES, "setting %04Xh:%u", (unsigned)one->index, (unsigned)one->subindex);
    }
}

static void tell_result(const gateway_command_t *sent, const char *who)
{
    static const char *const outcomes[] = {
        [GATEWAY_RESULT_ACCEPTED] = "accepted",
        [GATEWAY_RESULT_REFUSED] = "refused by the node",
        [GATEWAY_RESULT_UNANSWERED] = "not answered by the node",
        [GATEWAY_RESULT_UNFIT] = "not sent: the object cannot hold the value",
        [GATEWAY_RESULT_NO_SERVICE] = "not sent: it needs the service level",
    };
    const bool is_accepted = sent->result == (uint8_t)GATEWAY_RESULT_ACCEPTED;
    const char *const outcome = outcomes[sent->result];
    char what[WHAT_BYTES];
    char code[WHAT_BYTES] = "";
    describe(sent, what);
    if (sent->abort != 0U) {
        (void)snprintf(code, sizeof code, ", abort code %08" PRIX32 "h", sent->abort);
    }
    event_log_tell(is_accepted ? EVENT_LOG_NOTICE : EVENT_LOG_WARNING, is_accepted ? "command" : "refused",
                   EVENT_FIELDS(EVENT_TEXT("client", who), EVENT_TEXT("command", what), EVENT_TEXT("why", outcome),
                                EVENT_WHOLE("abort_code", sent->abort)),
                   "%s: %s %s%s", who, what, outcome, code);
}

void gateway_log_session(gateway_stream_t *stream, const char *who, uint64_t now_us)
{
    const gateway_session_t *const session = &stream->session;
    const gateway_told_t told = stream->told;
    const gateway_told_t now = {.refusals = session->refusal.number,
                                .executed = session->staged[GATEWAY_HOLDING_EXECUTE],
                                .result = session->sent.result,
                                .is_unlocked = now_us < session->unlocked_until_us};
    stream->told = now;
    if (now.refusals != told.refusals && now.refusals != 0U) {
        tell_refusal(&session->refusal, who);
    }
    if (now.is_unlocked != told.is_unlocked) {
        event_log_tell(now.is_unlocked ? EVENT_LOG_NOTICE : EVENT_LOG_INFO, now.is_unlocked ? "unlock" : "lock",
                       EVENT_FIELDS(EVENT_TEXT("client", who)), "%s: the session is %s", who,
                       now.is_unlocked ? "unlocked" : "locked");
    }
    if ((now.result != told.result || now.executed != told.executed) && now.result > (uint8_t)GATEWAY_RESULT_PENDING) {
        tell_result(&session->sent, who);
    }
}

/* The node. Of its run, the objects have neither the first cause nor whether the program waits after a fault. */

/* An integer of up to 32 bits of a snapshot. False: it has none. */
static bool value_of(const gateway_snapshot_t *snapshot, uint16_t index, uint8_t subindex, uint32_t *number)
{
    for (size_t i = 0; i < GATEWAY_VALUES; i++) {
        const gateway_value_t value = gateway_value(i);
        const bool is_valid = (snapshot->words[value.validity] & (1U << value.bit)) != 0U;
        if (value.index == index && value.subindex == subindex && is_valid && value.size <= 4U) {
            const uint32_t high = snapshot->words[value.at];
            *number = (value.size <= 2U) ? high : high << 16 | snapshot->words[value.at + 1U];
            return true;
        }
    }
    return false;
}

static uint32_t value_or_0(const gateway_snapshot_t *snapshot, uint16_t index, uint8_t subindex)
{
    uint32_t number = 0;
    (void)value_of(snapshot, index, subindex, &number);
    return number;
}

static void log_run(gateway_log_t *log, const gateway_snapshot_t *snapshot)
{
    uint32_t state;
    uint32_t reason;
    if (!value_of(snapshot, 0x2000U, 0, &state) || !value_of(snapshot, 0x2001U, 0, &reason)) {
        return;
    }
    const tumble_progress_t now = {
        .state = (tumble_state_t)state,
        .reason = (tumble_reason_t)reason,
        .failed_in = (tumble_state_t)value_or_0(snapshot, 0x2004U, 1),
        .drive_code = (uint16_t)value_or_0(snapshot, 0x2004U, 3),
        .index = (uint8_t)value_or_0(snapshot, 0x2003U, 1),
        .count = (uint8_t)value_or_0(snapshot, 0x2003U, 2),
        .finished = (uint8_t)value_or_0(snapshot, 0x2003U, 3),
        .mounting = (uint8_t)value_or_0(snapshot, 0x2003U, 4),
        .position = (uint8_t)value_or_0(snapshot, 0x2003U, 5),
        .attempt = (uint8_t)value_or_0(snapshot, 0x2003U, 6),
    };
    if (!log->has_progress || run_log_is_news(&now, &log->progress)) {
        run_log_state(&now, NULL, false);
    }
    log->has_progress = true;
    log->progress = now;
}

static void log_sets(gateway_log_t *log, const gateway_snapshot_t *snapshot)
{
    uint32_t verdict;
    uint32_t counter;
    if (value_of(snapshot, 0x2120U, 7, &verdict) && value_of(snapshot, 0x2120U, 2, &counter)) {
        const tumble_sets_state_t state = {.verdict = (uint8_t)verdict,
                                           .counter = counter,
                                           .objections = (uint16_t)value_or_0(snapshot, 0x2120U, 6),
                                           .more_objections = (uint16_t)value_or_0(snapshot, 0x2120U, 15),
                                           .status = (uint8_t)value_or_0(snapshot, 0x2120U, 8)};
        run_log_sets(&log->sets, &state);
    }
}

static void log_link(gateway_log_t *log, const gateway_poller_t *poller)
{
    static const struct {
        const char *word;
        const char *sentence;
    } links[] = {
        [GATEWAY_LINK_UNKNOWN] = {"unknown", "not known"},
        [GATEWAY_LINK_UP] = {"up", "the node answers"},
        [GATEWAY_LINK_SILENT] = {"silent", "the node is silent: its power, its number, the bus"},
        [GATEWAY_LINK_DOWN] = {"down", "the interface is down"},
    };
    if (poller->link_state != log->link) {
        event_log_tell(
            (poller->link_state == (uint8_t)GATEWAY_LINK_UP) ? EVENT_LOG_NOTICE : EVENT_LOG_WARNING, "link",
            EVENT_FIELDS(EVENT_WHOLE("node", poller->node), EVENT_TEXT("link", links[poller->link_state].word)),
            "node %u: %s", (unsigned)poller->node, links[poller->link_state].sentence);
    }
    log->link = poller->link_state;
}

void gateway_log_node(gateway_log_t *log, const gateway_poller_t *poller)
{
    if (!event_log_is_on()) {
        return;
    }
    log_link(log, poller);
    if (poller->published.number != log->snapshot) {
        log_run(log, &poller->published);
        log_sets(log, &poller->published);
    }
    log->snapshot = poller->published.number;
}
