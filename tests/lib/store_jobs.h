/* store_jobs.h - the jobs of the store under disturbance, and what may be found after it. Needs no Unity. */
#ifndef STORE_JOBS_H
#define STORE_JOBS_H

#include "store_power.h"
#include "store_sets.h"

static tumble_store_t jobs_store;

/* Sets by their tags; 0: there is none. What a loss of power must not touch, and what the job is to make of it. */
typedef struct {
    unsigned active;
    unsigned previous;
    unsigned proposal;
    unsigned factory;
    uint8_t origin; /* of the active set */
    uint8_t proposal_origin;
} sets_t;

static sets_t jobs_before;
enum { FACTORY = 1, FIRST = 2, SECOND = 3, THIRD = 4, HELD = 5, NEW = 6, TAGS = 7, MIXED = 255 };

static inline bool jobs_boot(nv_memory_t *memory)
{
    return tumble_store_init(&jobs_store, &memory->nv) == TUMBLE_OK && store_settles(&jobs_store);
}

static inline unsigned tag_of(tumble_which_set_t which, uint8_t *origin)
{
    tumble_set_t set;
    *origin = 0;
    if (!tumble_store_has(&jobs_store, which)) {
        return 0;
    }
    if (tumble_store_read(&jobs_store, which, &set) != TUMBLE_OK) {
        return MIXED;
    }
    *origin = set.origin;
    for (unsigned tag = 1; tag < TAGS; tag++) {
        if (set_is(&set, tag)) {
            return tag;
        }
    }
    return MIXED;
}

static inline sets_t jobs_sets(void)
{
    uint8_t ignored;
    sets_t sets;
    sets.active = tag_of(TUMBLE_SET_ACTIVE, &sets.origin);
    sets.previous = tag_of(TUMBLE_SET_PREVIOUS, &ignored);
    sets.proposal = tag_of(TUMBLE_SET_PROPOSAL, &sets.proposal_origin);
    sets.factory = tag_of(TUMBLE_SET_FACTORY, &ignored);
    return sets;
}

static inline tumble_status_t ended(tumble_status_t begun)
{
    if (begun != TUMBLE_OK) {
        return begun;
    }
    return store_settles(&jobs_store) ? tumble_store_outcome(&jobs_store) : TUMBLE_E_PORT_BUSY;
}

static inline tumble_status_t job_commit(void)
{
    const tumble_set_t set = set_of(NEW);
    return ended(tumble_store_commit(&jobs_store, &set));
}

static inline tumble_status_t job_hold(void)
{
    const tumble_set_t set = set_of(NEW);
    return ended(tumble_store_hold(&jobs_store, &set));
}

static inline tumble_status_t job_factory(void)
{
    const tumble_set_t set = set_of(NEW);
    return ended(tumble_store_write_factory(&jobs_store, &set));
}

static inline tumble_status_t job_accept(void)
{
    return ended(tumble_store_accept(&jobs_store, 0));
}

static inline tumble_status_t job_discard(void)
{
    return ended(tumble_store_discard(&jobs_store));
}

static inline tumble_status_t job_rollback(void)
{
    return ended(tumble_store_rollback(&jobs_store));
}

/* Preparations. Each ends with a note of what is there. */
static inline void put_commit(unsigned tag)
{
    const tumble_set_t set = set_of(tag);
    (void)ended(tumble_store_commit(&jobs_store, &set));
}

static inline void put_hold(unsigned tag)
{
    const tumble_set_t set = set_of(tag);
    (void)ended(tumble_store_hold(&jobs_store, &set));
}

static inline void prepare(nv_memory_t *memory, bool factory, unsigned commits, bool held, unsigned rollbacks)
{
    const tumble_set_t set = set_of(FACTORY);
    (void)jobs_boot(memory);
    if (factory) {
        (void)ended(tumble_store_write_factory(&jobs_store, &set));
    }
    for (unsigned i = 0; i < commits; i++) {
        put_commit(FIRST + i);
    }
    for (unsigned i = 0; i < rollbacks; i++) {
        (void)job_rollback();
    }
    if (held) {
        put_hold(HELD);
    }
    jobs_before = jobs_sets();
}

/* clang-format off: a line each */
static inline void with_nothing(nv_memory_t *memory)
{
    prepare(memory, false, 0, false, 0);
}
static inline void with_factory(nv_memory_t *memory)
{
    prepare(memory, true, 0, false, 0);
}
static inline void with_one(nv_memory_t *memory)
{
    prepare(memory, true, 1, false, 0);
}
static inline void with_two(nv_memory_t *memory)
{
    prepare(memory, true, 2, false, 0);
}
static inline void with_two_alone(nv_memory_t *memory)
{
    prepare(memory, false, 2, false, 0);
}
static inline void with_three(nv_memory_t *memory)
{
    prepare(memory, true, 3, false, 0);
}
static inline void with_held(nv_memory_t *memory)
{
    prepare(memory, true, 2, true, 0);
}
static inline void with_held_first(nv_memory_t *memory)
{
    prepare(memory, false, 0, true, 0);
}
static inline void with_rolled_back(nv_memory_t *memory)
{
    prepare(memory, true, 2, false, 1);
}
/* clang-format on */

/* An accepted proposal that has not been cleared. */
static inline void with_stale(nv_memory_t *memory)
{
    prepare(memory, true, 2, true, 0);
    nv_arm(memory, (nv_fault_t){3, DONE_NOTHING, THEN_CUT});
    (void)job_accept();
    nv_arm(memory, nv_no_fault);
    jobs_before = (sets_t){HELD, THIRD - 1, 0, FACTORY, TUMBLE_ORIGIN_ACCEPTED, 0};
}

static inline void with_torn_factory(nv_memory_t *memory)
{
    memset(memory->bytes, 0x5A, 200);
    prepare(memory, false, 1, false, 0);
}

/* Where neither slot has a valid set, or the other slot has been given up, the factory set is all there is to go to. */
static inline bool previous_is(unsigned tag, unsigned previous)
{
    return tag == previous || tag == jobs_before.factory;
}

static inline bool rest_is_as_before(const sets_t *now)
{
    return now->factory == jobs_before.factory;
}

static inline bool active_is_as_before(const sets_t *now)
{
    return now->active == jobs_before.active && now->origin == jobs_before.origin;
}

static inline state_t look_commit(void)
{
    const sets_t now = jobs_sets();
    if (!rest_is_as_before(&now) || now.proposal != jobs_before.proposal) {
        return STATE_BAD;
    }
    if (now.active == NEW) {
        return (now.previous == jobs_before.active && now.origin == TUMBLE_ORIGIN_COMMITTED) ? STATE_AFTER : STATE_BAD;
    }
    return (active_is_as_before(&now) && previous_is(now.previous, jobs_before.previous)) ? STATE_BEFORE : STATE_BAD;
}

static inline state_t look_hold(void)
{
    const sets_t now = jobs_sets();
    if (!rest_is_as_before(&now) || !active_is_as_before(&now) || now.previous != jobs_before.previous) {
        return STATE_BAD;
    }
    if (now.proposal == NEW) {
        return (now.proposal_origin == TUMBLE_ORIGIN_HELD) ? STATE_AFTER : STATE_BAD;
    }
    return (now.proposal == 0U || now.proposal == jobs_before.proposal) ? STATE_BEFORE : STATE_BAD;
}

static inline state_t look_discard(void)
{
    const sets_t now = jobs_sets();
    if (!rest_is_as_before(&now) || !active_is_as_before(&now) || now.previous != jobs_before.previous) {
        return STATE_BAD;
    }
    return (now.proposal == 0U) ? STATE_AFTER : (now.proposal == jobs_before.proposal) ? STATE_BEFORE : STATE_BAD;
}

static inline state_t look_accept(void)
{
    const sets_t now = jobs_sets();
    if (!rest_is_as_before(&now)) {
        return STATE_BAD;
    }
    if (now.active == jobs_before.proposal) {
        const bool right =
            now.proposal == 0U && now.previous == jobs_before.active && now.origin == TUMBLE_ORIGIN_ACCEPTED;
        return right ? STATE_AFTER : STATE_BAD;
    }
    const bool right = active_is_as_before(&now) && now.proposal == jobs_before.proposal &&
                       previous_is(now.previous, jobs_before.previous);
    return right ? STATE_BEFORE : STATE_BAD;
}

/* What is to come back is never lost on the way. */
static inline state_t look_rollback(void)
{
    const sets_t now = jobs_sets();
    const unsigned target = jobs_before.previous;
    if (!rest_is_as_before(&now)) {
        return STATE_BAD;
    }
    if (now.active == target) {
        const unsigned next = (target == jobs_before.factory) ? 0U : jobs_before.factory;
        const bool right = now.proposal == 0U && now.previous == next && now.origin == TUMBLE_ORIGIN_ROLLED_BACK;
        return right ? STATE_AFTER : STATE_BAD;
    }
    const bool staged = now.proposal == target && now.proposal_origin == TUMBLE_ORIGIN_ROLLED_BACK;
    if (!active_is_as_before(&now) || !previous_is(now.previous, target)) {
        return STATE_BAD;
    }
    return staged ? STATE_BETWEEN : (now.proposal == 0U && now.previous == target) ? STATE_BEFORE : STATE_BAD;
}

static inline state_t look_factory(void)
{
    const sets_t now = jobs_sets();
    const bool slots = jobs_before.origin != 0U;
    if (now.proposal != jobs_before.proposal || (slots && !active_is_as_before(&now))) {
        return STATE_BAD;
    }
    return (now.factory == NEW) ? STATE_AFTER : (now.factory == 0U) ? STATE_BEFORE : STATE_BAD;
}

static const scenario_t store_scenarios[] = {
    {"the first commit", with_factory, jobs_boot, job_commit, look_commit},
    {"the first commit, no factory set", with_nothing, jobs_boot, job_commit, look_commit},
    {"the second commit", with_one, jobs_boot, job_commit, look_commit},
    {"a commit over an older set", with_two, jobs_boot, job_commit, look_commit},
    {"a commit, no factory set", with_two_alone, jobs_boot, job_commit, look_commit},
    {"a commit beside a proposal", with_held, jobs_boot, job_commit, look_commit},
    {"a commit after an accept cut short", with_stale, jobs_boot, job_commit, look_commit},
    {"a commit after a rollback", with_rolled_back, jobs_boot, job_commit, look_commit},
    {"a hold", with_two, jobs_boot, job_hold, look_hold},
    {"a hold in place of another", with_held, jobs_boot, job_hold, look_hold},
    {"a hold after an accept cut short", with_stale, jobs_boot, job_hold, look_hold},
    {"an accept", with_held, jobs_boot, job_accept, look_accept},
    {"an accept of the first set", with_held_first, jobs_boot, job_accept, look_accept},
    {"a discard", with_held, jobs_boot, job_discard, look_discard},
    {"a rollback", with_two, jobs_boot, job_rollback, look_rollback},
    {"a rollback with three behind it", with_three, jobs_boot, job_rollback, look_rollback},
    {"a rollback to the factory set", with_one, jobs_boot, job_rollback, look_rollback},
    {"a second rollback", with_rolled_back, jobs_boot, job_rollback, look_rollback},
    {"the factory set", with_nothing, jobs_boot, job_factory, look_factory},
    {"the factory set, written late", with_two_alone, jobs_boot, job_factory, look_factory},
    {"the factory set behind a torn one", with_torn_factory, jobs_boot, job_factory, look_factory},
};

#endif
