/* store_jobs.h - the jobs of the store under disturbance, and what may be found after it. Needs no Unity. */
#ifndef STORE_JOBS_H
#define STORE_JOBS_H

#include "store_power.h"
#include "store_sets.h"

static tumble_store_t jobs_store;
static bool jobs_over_temperature; /* the store reads both versions, and all sets but SECOND are of version 2 */

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
    const tumble_status_t status = jobs_over_temperature ? tumble_store_init_thermal(&jobs_store, &memory->nv)
                                                         : tumble_store_init(&jobs_store, &memory->nv);
    return status == TUMBLE_OK && store_settles(&jobs_store);
}

static inline bool has_slopes(unsigned tag)
{
    return jobs_over_temperature && tag != SECOND;
}

static inline unsigned tag_of(tumble_which_set_t which, uint8_t *origin)
{
    tumble_set_t set;
    tumble_thermal_t thermal;
    *origin = 0;
    if (!tumble_store_has(&jobs_store, which)) {
        return 0;
    }
    const tumble_status_t status = jobs_over_temperature ? tumble_store_read_thermal(&jobs_store, which, &set, &thermal)
                                                         : tumble_store_read(&jobs_store, which, &set);
    if (status != TUMBLE_OK) {
        return MIXED;
    }
    *origin = set.origin;
    for (unsigned tag = 1; tag < TAGS; tag++) {
        if (has_slopes(tag) ? thermal_is(&set, &thermal, tag) : set_is(&set, tag)) {
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

static inline tumble_status_t put(tumble_which_set_t which, unsigned tag)
{
    const tumble_set_t set = set_of(tag);
    const tumble_thermal_t thermal = thermal_of(tag);
    if (has_slopes(tag)) {
        return ended(tumble_store_write_thermal(&jobs_store, which, &set, &thermal));
    }
    return ended((which == TUMBLE_SET_ACTIVE)     ? tumble_store_commit(&jobs_store, &set)
                 : (which == TUMBLE_SET_PROPOSAL) ? tumble_store_hold(&jobs_store, &set)
                                                  : tumble_store_write_factory(&jobs_store, &set));
}

static inline tumble_status_t job_commit(void)
{
    return put(TUMBLE_SET_ACTIVE, NEW);
}

static inline tumble_status_t job_hold(void)
{
    return put(TUMBLE_SET_PROPOSAL, NEW);
}

static inline tumble_status_t job_factory(void)
{
    return put(TUMBLE_SET_FACTORY, NEW);
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
    (void)put(TUMBLE_SET_ACTIVE, tag);
}

static inline void put_hold(unsigned tag)
{
    (void)put(TUMBLE_SET_PROPOSAL, tag);
}

static inline void prepare_sets(nv_memory_t *memory, const start_t *start)
{
    (void)jobs_boot(memory);
    if (start->factory != 0U) {
        (void)put(TUMBLE_SET_FACTORY, FACTORY);
    }
    for (unsigned i = 0; i < start->commits; i++) {
        put_commit(FIRST + i);
    }
    for (unsigned i = 0; i < start->rollbacks; i++) {
        (void)job_rollback();
    }
    if (start->held != 0U) {
        put_hold(HELD);
    }
    jobs_before = jobs_sets();
}

/* With an accepted proposal that has not been cleared. */
static inline void prepare_stale(nv_memory_t *memory, const start_t *start)
{
    prepare_sets(memory, start);
    nv_arm(memory, (nv_fault_t){3, DONE_NOTHING, THEN_CUT});
    (void)job_accept();
    nv_arm(memory, nv_no_fault);
    jobs_before = (sets_t){HELD, THIRD - 1, 0, FACTORY, TUMBLE_ORIGIN_ACCEPTED, 0};
}

static inline void prepare_torn_factory(nv_memory_t *memory, const start_t *start)
{
    memset(memory->bytes, 0x5A, 200);
    prepare_sets(memory, start);
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

/* Prepared so, and a job that begins with these sets. */
#define FROM(prepare, name, job, ...)                                                                                  \
    {                                                                                                                  \
        name, prepare, jobs_boot, job_##job, look_##job,                                                               \
        {                                                                                                              \
            __VA_ARGS__                                                                                                \
        }                                                                                                              \
    }
#define SETS(name, job, ...) FROM(prepare_sets, name, job, __VA_ARGS__)

static const scenario_t store_scenarios[] = {
    SETS("the first commit", commit, .factory = 1),
    SETS("the first commit, no factory set", commit, .factory = 0),
    SETS("the second commit", commit, .factory = 1, .commits = 1),
    SETS("a commit over an older set", commit, .factory = 1, .commits = 2),
    SETS("a commit, no factory set", commit, .commits = 2),
    SETS("a commit beside a proposal", commit, .factory = 1, .commits = 2, .held = 1),
    FROM(prepare_stale, "a commit after an accept cut short", commit, .factory = 1, .commits = 2, .held = 1),
    SETS("a commit after a rollback", commit, .factory = 1, .commits = 2, .rollbacks = 1),
    SETS("a hold", hold, .factory = 1, .commits = 2),
    SETS("a hold in place of another", hold, .factory = 1, .commits = 2, .held = 1),
    FROM(prepare_stale, "a hold after an accept cut short", hold, .factory = 1, .commits = 2, .held = 1),
    SETS("an accept", accept, .factory = 1, .commits = 2, .held = 1),
    SETS("an accept of the first set", accept, .held = 1),
    SETS("a discard", discard, .factory = 1, .commits = 2, .held = 1),
    SETS("a rollback", rollback, .factory = 1, .commits = 2),
    SETS("a rollback with three behind it", rollback, .factory = 1, .commits = 3),
    SETS("a rollback to the factory set", rollback, .factory = 1, .commits = 1),
    SETS("a second rollback", rollback, .factory = 1, .commits = 2, .rollbacks = 1),
    SETS("the factory set", factory, .factory = 0),
    SETS("the factory set, written late", factory, .commits = 2),
    FROM(prepare_torn_factory, "the factory set behind a torn one", factory, .commits = 1),
};

#endif
