#include "procedure/states.h"

typedef struct {
    const char *name;
    const char *sentence;
} entry_t;

#define ENTRY(value, sentence) {#value, (sentence)},

static const entry_t *state_entry(tumble_state_t state)
{
    static const entry_t states[] = {TUMBLE_STATE_LIST(ENTRY)};
    static const entry_t unknown_state = {"TUMBLE_STATE_UNKNOWN", "this state is not in the list"};
    const unsigned index = (unsigned)state;
    return (index < (unsigned)TUMBLE_STATE_COUNT) ? &states[index] : &unknown_state;
}

static const entry_t *reason_entry(tumble_reason_t reason)
{
    static const entry_t reasons[] = {TUMBLE_REASON_LIST(ENTRY)};
    static const entry_t unknown_reason = {"TUMBLE_REASON_UNKNOWN", "this reason is not in the list"};
    const unsigned index = (unsigned)reason;
    return (index < (unsigned)TUMBLE_REASON_COUNT) ? &reasons[index] : &unknown_reason;
}

const char *tumble_state_name(tumble_state_t state)
{
    return state_entry(state)->name;
}

const char *tumble_state_sentence(tumble_state_t state)
{
    return state_entry(state)->sentence;
}

const char *tumble_reason_name(tumble_reason_t reason)
{
    return reason_entry(reason)->name;
}

const char *tumble_reason_sentence(tumble_reason_t reason)
{
    return reason_entry(reason)->sentence;
}
