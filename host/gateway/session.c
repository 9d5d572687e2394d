#include "session.h"

#include "core/bytes.h"

#include <string.h>

#define MAGIC_WORD 0x54554D42U
#define KNOWN_NUMBER 123456.0F
#define NO_AGE UINT32_MAX
#define US_PER_MS 1000U
#define US_PER_S 1000000U
#define LARGEST_BYTE 255U
#define KEYS 2U
#define ANGLES_PER_DEG 1e5
#define VALUE_WORDS (sizeof(double) / sizeof(uint16_t))

#define ACCESS_ALLOWED 1U
#define ACCESS_UNLOCKED 2U

static bool is_unlocked(const gateway_session_t *session, uint64_t now_us)
{
    return now_us < session->unlocked_until_us;
}

/* Reading. */

static uint32_t age_ms(const gateway_snapshot_t *snapshot, uint64_t now_us)
{
    const uint64_t age = (now_us - snapshot->taken_us) / US_PER_MS;
    return (snapshot->number == 0U || age > NO_AGE) ? NO_AGE : (uint32_t)age;
}

/* Was all of its snapshot read after its last command? */
static bool is_fresh(const gateway_session_t *session)
{
    const int32_t behind = (int32_t)(session->snapshot.ended - session->sent.ended);
    return session->snapshot.number != 0U && session->sent.result != GATEWAY_RESULT_PENDING && behind >= 0;
}

/* What is the gateway's own is as it is now, whatever the snapshot. */
static void put_own(gateway_session_t *session, const gateway_t *gateway, uint64_t now_us)
{
    uint16_t *const words = session->snapshot.words;
    gateway_put_u32(&words[GATEWAY_INPUT_MAGIC_WORD], MAGIC_WORD);
    words[GATEWAY_INPUT_MAP_VERSION] = GATEWAY_MAP_VERSION;
    gateway_put_f32(&words[GATEWAY_INPUT_KNOWN_NUMBER], KNOWN_NUMBER);
    gateway_put_u32(&words[GATEWAY_INPUT_SNAPSHOT_NUMBER], session->snapshot.number);
    gateway_put_u32(&words[GATEWAY_INPUT_SNAPSHOT_HELD], session->snapshot.number);
    words[GATEWAY_INPUT_LINK_STATE] = gateway->poller.link_state;
    gateway_put_u32(&words[GATEWAY_INPUT_AGE_OF_THE_SNAPSHOT], age_ms(&session->snapshot, now_us));
    words[GATEWAY_INPUT_UNIT] = gateway->settings.unit;
    words[GATEWAY_INPUT_NODE] = gateway->settings.node;
    words[GATEWAY_INPUT_ACCESS] = (uint16_t)((gateway->settings.allow_commands ? ACCESS_ALLOWED : 0U) |
                                             (is_unlocked(session, now_us) ? ACCESS_UNLOCKED : 0U));
    words[GATEWAY_INPUT_CLIENTS] = gateway->clients;
    words[GATEWAY_INPUT_FRESH] = is_fresh(session) ? 1U : 0U;
    for (size_t i = 0; i < GATEWAY_COUNTERS; i++) {
        gateway_put_u32(&words[GATEWAY_INPUT_COUNTERS + 2U * i], gateway->counters[i]);
    }
}

static bool covers_number(uint16_t at, uint16_t count)
{
    return at < GATEWAY_INPUT_SNAPSHOT_NUMBER + 2U && at + (unsigned)count > GATEWAY_INPUT_SNAPSHOT_NUMBER;
}

const uint16_t *gateway_session_input(gateway_session_t *session, const gateway_t *gateway, uint16_t at, uint16_t count,
                                      uint64_t now_us)
{
    const uint64_t held_us = now_us - session->renewed_us;
    const bool goes_on = at > session->last_at && held_us <= GATEWAY_PASS_US;
    const bool is_stale = session->snapshot.number == 0U || (held_us > GATEWAY_HOLD_US && !goes_on);
    if (is_stale || covers_number(at, count)) {
        session->snapshot = gateway->poller.published;
        session->renewed_us = now_us;
    }
    session->last_at = at;
    put_own(session, gateway, now_us);
    return session->snapshot.words;
}

void gateway_session_holding(const gateway_session_t *session, uint16_t *words, uint64_t now_us)
{
    memcpy(words, session->staged, sizeof session->staged);
    if (is_unlocked(session, now_us)) {
        words[GATEWAY_HOLDING_UNLOCKED_FOR] =
            (uint16_t)((session->unlocked_until_us - now_us + US_PER_S - 1U) / US_PER_S);
    }
    words[GATEWAY_HOLDING_RESULT] = session->sent.result;
    words[GATEWAY_HOLDING_RESULT_OF] = session->staged[GATEWAY_HOLDING_EXECUTE];
    gateway_put_u32(&words[GATEWAY_HOLDING_ABORT_CODE], session->sent.abort);
}

/* Writing. */

/* Whoever opens the lock is another than who let it close, as far as anybody knows: on the serial line, say. */
static void forget_staged(gateway_session_t *session)
{
    const uint16_t executed = session->staged[GATEWAY_HOLDING_EXECUTE];
    memset(session->staged, 0, sizeof session->staged);
    session->staged[GATEWAY_HOLDING_EXECUTE] = executed;
    session->has_angle = false;
    session->has_proposal = false;
    session->is_setting_done = false;
}

static void end_service(const gateway_session_t *session, gateway_t *gateway)
{
    if (gateway->service == session) {
        gateway->service = NULL;
        gateway->poller.queue.ends_service = true;
    }
}

static bool are_keys(const uint16_t *words)
{
    return words[0] == GATEWAY_KEY_1 && words[1] == GATEWAY_KEY_2;
}

static gateway_exception_t unlock(gateway_session_t *session, gateway_t *gateway, const uint16_t *keys, uint64_t now_us)
{
    if (!are_keys(keys)) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_WRONG_KEYS]);
        session->unlocked_until_us = 0;
        end_service(session, gateway);
        return GATEWAY_ILLEGAL_VALUE;
    }
    if (!is_unlocked(session, now_us)) {
        forget_staged(session);
        end_service(session, gateway); /* another opened it, on a serial line */
    }
    session->unlocked_until_us = now_us + gateway->settings.unlock_us;
    return GATEWAY_OK;
}

/* Can a request begin and end there? It may pass over what cannot be written. */
static bool is_writable(unsigned at)
{
    return (at >= GATEWAY_HOLDING_COMMAND_OBJECT && at <= GATEWAY_HOLDING_EXECUTE) || at >= GATEWAY_HOLDING_SETTING;
}

/* What is passed over must be 0. */
static bool fits(uint16_t at, uint16_t value)
{
    switch (at) {
    case GATEWAY_HOLDING_COMMAND_OBJECT:
        return value < GATEWAY_COMMAND_OBJECTS;
    case GATEWAY_HOLDING_ARGUMENT:
    case GATEWAY_HOLDING_COMMAND:
        return value <= LARGEST_BYTE;
    case GATEWAY_HOLDING_EXECUTE:
        return value != 0U;
    case GATEWAY_HOLDING_SETTING:
        return value == 0U || gateway_target(value).number != 0U;
    default:
        return value == 0U || is_writable(at);
    }
}

static gateway_exception_t stage(gateway_session_t *session, uint16_t at, uint16_t value)
{
    session->is_setting_done = session->is_setting_done && at == GATEWAY_HOLDING_EXECUTE;
    session->has_angle |= at == GATEWAY_HOLDING_ANGLE || at == GATEWAY_HOLDING_ANGLE + 1U;
    session->has_proposal |= at == GATEWAY_HOLDING_PROPOSAL || at == GATEWAY_HOLDING_PROPOSAL + 1U;
    session->staged[at] = value;
    return fits(at, value) ? GATEWAY_OK : GATEWAY_ILLEGAL_VALUE;
}

static uint32_t staged_u32(const gateway_session_t *session, uint16_t at)
{
    return (uint32_t)session->staged[at] << 16 | session->staged[at + 1U];
}

static double angle_deg(const gateway_session_t *session)
{
    return (double)(int32_t)staged_u32(session, GATEWAY_HOLDING_ANGLE) / ANGLES_PER_DEG;
}

static double value_of(const gateway_session_t *session)
{
    uint8_t bytes[sizeof(double)];
    for (size_t i = 0; i < VALUE_WORDS; i++) {
        tumble_put_u16(&bytes[2U * i], session->staged[GATEWAY_HOLDING_VALUE + VALUE_WORDS - 1U - i]);
    }
    return tumble_get_f64(bytes);
}

static gateway_command_t command_of(gateway_session_t *session)
{
    const double angle = angle_deg(session);
    const uint32_t proposal = staged_u32(session, GATEWAY_HOLDING_PROPOSAL);
    const gateway_command_t made =
        gateway_command(gateway_command_objects[session->staged[GATEWAY_HOLDING_COMMAND_OBJECT]],
                        (uint8_t)session->staged[GATEWAY_HOLDING_ARGUMENT], session->has_angle ? &angle : NULL,
                        session->has_proposal ? &proposal : NULL, (uint8_t)session->staged[GATEWAY_HOLDING_COMMAND]);
    session->has_angle = false;
    session->has_proposal = false;
    return made;
}

/* The service level of the node is open for the session alone that opened it last. */
static bool has_service(const gateway_session_t *session, const gateway_t *gateway, uint64_t now_us)
{
    return gateway->service == session && now_us < gateway->service_until_us;
}

static void note_key(const gateway_session_t *session, gateway_t *gateway, double key, uint64_t now_us)
{
    if (key == (double)GATEWAY_SERVICE_NUMBER) {
        gateway->service = session;
        gateway->service_until_us = now_us + GATEWAY_SERVICE_US;
        gateway->poller.queue.ends_service = false;
    } else if (gateway->service == session && key == 0.0) {
        gateway->service = NULL;
    } else {
        /* the node refuses it, and nothing changes */
    }
}

static gateway_exception_t send(gateway_session_t *session, gateway_t *gateway)
{
    return gateway_queue_add(&gateway->poller.queue, &session->sent) ? GATEWAY_OK : GATEWAY_BUSY;
}

/* The node may have refused the key, as in a run: then the level, should it be open, is not this session's. */
static void drop_refused_key(gateway_session_t *session, gateway_t *gateway)
{
    if (session->sent_key && session->sent.result != GATEWAY_RESULT_ACCEPTED && gateway->service == session) {
        gateway->service = NULL;
    }
    session->sent_key = false;
}

/* Nothing is sent of what does not fit, or needs a level that this session has not. */
static gateway_exception_t execute_setting(gateway_session_t *session, gateway_t *gateway, uint64_t now_us)
{
    const gateway_target_t target = gateway_target(session->staged[GATEWAY_HOLDING_SETTING]);
    const uint32_t key = staged_u32(session, GATEWAY_HOLDING_SERVICE_KEY);
    drop_refused_key(session, gateway);
    session->sent = gateway_setting(target, key, value_of(session));
    session->staged[GATEWAY_HOLDING_SETTING] = 0;
    session->staged[GATEWAY_HOLDING_SERVICE_KEY] = 0;
    session->staged[GATEWAY_HOLDING_SERVICE_KEY + 1U] = 0;
    if (session->sent.result == GATEWAY_RESULT_UNFIT) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_VALUES_UNFIT]);
        return GATEWAY_OK;
    }
    if (target.service && key == 0U && !has_service(session, gateway, now_us)) {
        session->sent.result = (uint8_t)GATEWAY_RESULT_NO_SERVICE;
        return GATEWAY_OK;
    }
    const gateway_exception_t wrong = send(session, gateway);
    if (wrong == GATEWAY_OK && key != 0U) {
        note_key(session, gateway, (double)key, now_us);
    }
    if (wrong == GATEWAY_OK && target.number == GATEWAY_SERVICE_KEY) {
        session->sent_key = true;
        note_key(session, gateway, value_of(session), now_us);
    }
    return wrong;
}

static gateway_exception_t execute(gateway_session_t *session, gateway_t *gateway, uint64_t now_us)
{
    if (gateway->poller.link_state != GATEWAY_LINK_UP) {
        return GATEWAY_TARGET_FAILED;
    }
    session->is_setting_done = session->staged[GATEWAY_HOLDING_SETTING] != 0U;
    if (session->is_setting_done) {
        return execute_setting(session, gateway, now_us);
    }
    drop_refused_key(session, gateway);
    session->sent = command_of(session);
    return send(session, gateway);
}

/* A request for a setting come once more, as after a lost answer: what is staged now is a command that nobody wants. */
static bool is_repeated(const gateway_session_t *session, const gateway_session_t *before)
{
    return session->is_setting_done &&
           session->staged[GATEWAY_HOLDING_EXECUTE] == before->staged[GATEWAY_HOLDING_EXECUTE];
}

/* All or nothing: what does not go well is taken back. */
static gateway_exception_t stage_all(gateway_session_t *session, gateway_t *gateway, uint16_t at, uint16_t count,
                                     const uint16_t *words, uint64_t now_us)
{
    const gateway_session_t before = *session;
    gateway_exception_t wrong = GATEWAY_OK;
    for (uint16_t i = 0; i < count && wrong == GATEWAY_OK; i++) {
        wrong = stage(session, (uint16_t)(at + i), words[i]);
    }
    const bool executes = at <= GATEWAY_HOLDING_EXECUTE && at + (unsigned)count > GATEWAY_HOLDING_EXECUTE;
    if (wrong == GATEWAY_OK && executes && !is_repeated(session, &before)) {
        wrong = execute(session, gateway, now_us);
    }
    if (wrong != GATEWAY_OK) {
        *session = before;
    }
    return wrong;
}

static gateway_exception_t write_staged(gateway_session_t *session, gateway_t *gateway, uint16_t at, uint16_t count,
                                        const uint16_t *words, uint64_t now_us)
{
    if (!is_writable(at) || !is_writable(at + (unsigned)count - 1U)) {
        return GATEWAY_ILLEGAL_ADDRESS;
    }
    if (!is_unlocked(session, now_us)) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_LOCKED]);
        return GATEWAY_ILLEGAL_FUNCTION;
    }
    if (session->sent.result == GATEWAY_RESULT_PENDING) {
        return GATEWAY_BUSY;
    }
    const gateway_exception_t wrong = stage_all(session, gateway, at, count, words, now_us);
    if (wrong == GATEWAY_OK) {
        session->unlocked_until_us = now_us + gateway->settings.unlock_us;
    }
    return wrong;
}

/* The keys, and behind them, with the register between as 0, what is staged: for clients that connect for each request
 * anew. */
static gateway_exception_t write_keys(gateway_session_t *session, gateway_t *gateway, uint16_t count,
                                      const uint16_t *words, uint64_t now_us)
{
    const uint64_t before_us = session->unlocked_until_us;
    gateway_exception_t wrong = unlock(session, gateway, words, now_us);
    if (wrong != GATEWAY_OK || count == KEYS) {
        return wrong;
    }
    wrong = (words[KEYS] != 0U)
                ? GATEWAY_ILLEGAL_VALUE
                : write_staged(session, gateway, KEYS + 1U, (uint16_t)(count - KEYS - 1U), &words[KEYS + 1U], now_us);
    if (wrong != GATEWAY_OK) {
        session->unlocked_until_us = before_us;
    }
    return wrong;
}

static gateway_exception_t write_any(gateway_session_t *session, gateway_t *gateway, uint16_t at, uint16_t count,
                                     const uint16_t *words, uint64_t now_us)
{
    if (!gateway->settings.allow_commands) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_LOCKED]);
        return GATEWAY_ILLEGAL_FUNCTION;
    }
    if (at == GATEWAY_HOLDING_UNLOCK_KEY_1 && (count == KEYS || count > KEYS + 1U)) {
        return write_keys(session, gateway, count, words, now_us);
    }
    return write_staged(session, gateway, at, count, words, now_us);
}

/* What a register would have been; nothing of a request that is refused is staged. */
static uint16_t would_be(const gateway_session_t *session, uint16_t at, uint16_t count, const uint16_t *words,
                         uint16_t which)
{
    return (which >= at && which - at < count) ? words[which - at] : session->staged[which];
}

static void note_refusal(gateway_session_t *session, gateway_exception_t exception, uint16_t at, uint16_t count,
                         const uint16_t *words)
{
    const bool executes = at <= GATEWAY_HOLDING_EXECUTE && at + (unsigned)count > GATEWAY_HOLDING_EXECUTE;
    const bool is_command = executes && would_be(session, at, count, words, GATEWAY_HOLDING_SETTING) == 0U;
    session->refusal = (gateway_refusal_t){
        .number = session->refusal.number + 1U,
        .at = at,
        .count = count,
        .exception = (uint8_t)exception,
        .has_wrong_keys = exception == GATEWAY_ILLEGAL_VALUE && at == GATEWAY_HOLDING_UNLOCK_KEY_1 && !are_keys(words),
        .command = is_command ? would_be(session, at, count, words, GATEWAY_HOLDING_COMMAND) : 0U,
    };
}

gateway_exception_t gateway_session_write(gateway_session_t *session, gateway_t *gateway, uint16_t at, uint16_t count,
                                          const uint16_t *words, uint64_t now_us)
{
    const gateway_exception_t wrong = write_any(session, gateway, at, count, words, now_us);
    if (wrong != GATEWAY_OK) {
        note_refusal(session, wrong, at, count, words);
    }
    return wrong;
}

void gateway_session_close(gateway_session_t *session, gateway_t *gateway)
{
    gateway_queue_forget(&gateway->poller.queue, &session->sent);
    end_service(session, gateway);
    *session = (gateway_session_t){0};
}
