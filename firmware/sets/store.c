#include "sets/store_job.h"

#include "core/count.h"
#include "core/one_copy.h"
#include "sets/nv_writer.h"

#include <stddef.h>

tumble_status_t tumble_store_init(tumble_store_t *store, const tumble_nv_t *nv)
{
    static const tumble_slot_kind_t kind = {TUMBLE_SET_BYTES, TUMBLE_SET_PLACE_BYTES};
    if (store == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    *store = (tumble_store_t){.slots.kind = &kind, .outcome = TUMBLE_E_STATE};
    const tumble_status_t status = tumble_nv_writer_open(&store->slots.writer, nv);
    if (status == TUMBLE_OK) {
        store->outcome = TUMBLE_OK;
        tumble_store_begin_scan(store);
    }
    return status;
}

tumble_status_t tumble_store_outcome(const tumble_store_t *store)
{
    return tumble_store_busy(store) ? TUMBLE_E_PORT_BUSY : store->outcome;
}

const tumble_store_counters_t *tumble_store_counters(const tumble_store_t *store)
{
    return &store->counters;
}

uint32_t tumble_store_sequence(const tumble_store_t *store)
{
    return store->sequence;
}

void tumble_store_number_above(tumble_store_t *store, uint32_t sequence)
{
    if ((sequence > store->highest) && (sequence < TUMBLE_MAX_SEQUENCE)) {
        store->highest = sequence;
    }
}

static uint8_t find(const tumble_store_t *store, tumble_which_set_t which)
{
    switch (which) {
    case TUMBLE_SET_ACTIVE:
        return tumble_store_active(store);
    case TUMBLE_SET_FACTORY:
        return store->places[TUMBLE_REGION_FACTORY].valid ? (uint8_t)TUMBLE_REGION_FACTORY : NO_REGION;
    case TUMBLE_SET_PROPOSAL:
        return (store->places[TUMBLE_REGION_PROPOSAL].valid && !tumble_store_is_stale(store))
                   ? (uint8_t)TUMBLE_REGION_PROPOSAL
                   : NO_REGION;
    case TUMBLE_SET_PREVIOUS:
        return tumble_store_previous(store);
    default:
        return NO_REGION;
    }
}

bool tumble_store_has(const tumble_store_t *store, tumble_which_set_t which)
{
    return !tumble_store_busy(store) && (find(store, which) != NO_REGION);
}

bool tumble_store_has_newer(const tumble_store_t *store)
{
    bool newer = false;
    for (uint32_t region = 0; region < (sizeof store->places / sizeof store->places[0]); region++) {
        newer = newer || store->places[region].newer;
    }
    return newer;
}

uint32_t tumble_store_proposal(const tumble_store_t *store)
{
    return tumble_store_has(store, TUMBLE_SET_PROPOSAL) ? store->places[TUMBLE_REGION_PROPOSAL].crc : 0U;
}

tumble_status_t tumble_store_read(tumble_store_t *store, tumble_which_set_t which, tumble_set_t *set)
{
    if ((set == NULL) || ((unsigned)which > (unsigned)TUMBLE_SET_PREVIOUS)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_store_busy(store) || store->lent) {
        return TUMBLE_E_PORT_BUSY;
    }
    const uint8_t region = find(store, which);
    if (region == NO_REGION) {
        return TUMBLE_E_STATE;
    }
    tumble_status_t status =
        tumble_slots_read(&store->slots, tumble_store_place(store, region), store->bytes, &store->counters.nv_errors);
    if (status == TUMBLE_OK) {
        status = tumble_store_is_marked(store->bytes) ? tumble_set_decode(store->bytes, set) : TUMBLE_E_FRAME;
        if (status != TUMBLE_OK) {
            tumble_count(&store->counters.nv_errors);
        }
    }
    if ((status != TUMBLE_OK) && (status != TUMBLE_E_PORT_BUSY)) {
        tumble_store_begin_scan(store);
    }
    return status;
}

/* The slot that is not active; the first one where none is. */
static uint8_t spare_slot(const tumble_store_t *store)
{
    const uint8_t active = tumble_store_active(store);
    return (active == (uint8_t)TUMBLE_REGION_SLOT_A) ? (uint8_t)TUMBLE_REGION_SLOT_B : (uint8_t)TUMBLE_REGION_SLOT_A;
}

/* What every job needs: no other job under way, and, if it makes a set active, a sequence below the last one. */
static tumble_status_t prepare(tumble_store_t *store, uint8_t origin)
{
    if (store->slots.writer.nv == NULL) {
        return TUMBLE_E_STATE;
    }
    if (tumble_store_busy(store) || store->lent) {
        return TUMBLE_E_PORT_BUSY;
    }
    store->flags = 0;
    if (store->unread) { /* a place that could not be read may hold the active set: look again first */
        tumble_store_begin_scan(store);
        return TUMBLE_E_NV;
    }
    if (origin == (uint8_t)TUMBLE_ORIGIN_FACTORY) {
        store->stamp = (tumble_set_stamp_t){.origin = origin};
        return TUMBLE_OK;
    }
    store->stamp = (tumble_set_stamp_t){.sequence = store->highest + 1U, .origin = origin};
    store->target = spare_slot(store);
    return (store->highest >= TUMBLE_MAX_SEQUENCE) ? TUMBLE_E_STATE : TUMBLE_OK;
}

static tumble_status_t take(tumble_store_t *store, const tumble_set_t *set, const uint8_t *plan)
{
    const tumble_status_t status = tumble_set_encode_as(set, &store->stamp, store->bytes);
    if (status == TUMBLE_OK) {
        tumble_store_set_mark(store->bytes);
        tumble_slots_begin(&store->slots, plan);
    }
    return status;
}

tumble_status_t tumble_store_commit(tumble_store_t *store, const tumble_set_t *set)
{
    /* From its second action where nothing is left over. */
    static const uint8_t plan[] = {SLOT_ERASE | IN_PROPOSAL, SLOT_ERASE | IN_TARGET, SLOT_BODY | IN_TARGET,
                                   SLOT_MARK | IN_TARGET, SLOT_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_COMMITTED);
    return (status == TUMBLE_OK) ? take(store, set, tumble_store_is_stale(store) ? plan : &plan[1]) : status;
}

tumble_status_t tumble_store_hold(tumble_store_t *store, const tumble_set_t *set)
{
    static const uint8_t plan[] = {SLOT_ERASE | IN_PROPOSAL, SLOT_BODY | IN_PROPOSAL, SLOT_MARK | IN_PROPOSAL,
                                   SLOT_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_HELD);
    return (status == TUMBLE_OK) ? take(store, set, plan) : status;
}

/* Go on from the proposal. A copy that a rollback has staged is finished as a rollback. */
static tumble_status_t take_proposal(tumble_store_t *store)
{
    static const uint8_t accept[] = {PLAN_LOAD | IN_PROPOSAL, SLOT_ERASE | IN_TARGET,   SLOT_BODY | IN_TARGET,
                                     SLOT_MARK | IN_TARGET,   SLOT_ERASE | IN_PROPOSAL, SLOT_END};
    static const uint8_t end_rollback[] = {PLAN_LOAD | IN_PROPOSAL,
                                           SLOT_ERASE | IN_TARGET,
                                           SLOT_BODY | IN_TARGET,
                                           SLOT_MARK | IN_TARGET,
                                           SLOT_ERASE | IN_PROPOSAL,
                                           SLOT_ERASE | IN_OTHER,
                                           SLOT_END};
    const tumble_store_place_t *proposal = &store->places[TUMBLE_REGION_PROPOSAL];
    const bool staged = proposal->stamp.origin == (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK;
    store->stamp.from_crc = proposal->crc;
    store->stamp.restores = proposal->stamp.restores;
    store->stamp.origin = staged ? (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK : (uint8_t)TUMBLE_ORIGIN_ACCEPTED;
    tumble_slots_begin(&store->slots, staged ? end_rollback : accept);
    return TUMBLE_OK;
}

tumble_status_t tumble_store_accept(tumble_store_t *store)
{
    return tumble_store_accept_as(store, 0);
}

tumble_status_t tumble_store_accept_as(tumble_store_t *store, uint16_t flags)
{
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_ACCEPTED);
    if (status != TUMBLE_OK) {
        return status;
    }
    store->flags = flags;
    return tumble_store_has(store, TUMBLE_SET_PROPOSAL) ? take_proposal(store) : TUMBLE_E_STATE;
}

tumble_status_t tumble_store_discard(tumble_store_t *store)
{
    static const uint8_t plan[] = {SLOT_ERASE | IN_PROPOSAL, SLOT_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_FACTORY); /* gives out no sequence */
    if (status != TUMBLE_OK) {
        return status;
    }
    if (!tumble_store_has(store, TUMBLE_SET_PROPOSAL)) {
        return TUMBLE_E_STATE;
    }
    tumble_slots_begin(&store->slots, plan);
    return TUMBLE_OK;
}

TUMBLE_ONE_COPY tumble_status_t tumble_store_rollback(tumble_store_t *store)
{
    static const uint8_t plan[] = {PLAN_LOAD | IN_SOURCE,
                                   SLOT_ERASE | IN_PROPOSAL,
                                   SLOT_BODY | IN_PROPOSAL,
                                   SLOT_MARK | IN_PROPOSAL,
                                   PLAN_STAMP,
                                   SLOT_ERASE | IN_TARGET,
                                   SLOT_BODY | IN_TARGET,
                                   SLOT_MARK | IN_TARGET,
                                   SLOT_ERASE | IN_PROPOSAL,
                                   SLOT_ERASE | IN_OTHER,
                                   SLOT_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (tumble_store_has(store, TUMBLE_SET_PROPOSAL)) {
        const bool staged = store->places[TUMBLE_REGION_PROPOSAL].stamp.origin == (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK;
        return staged ? take_proposal(store) : TUMBLE_E_STATE;
    }
    const uint8_t previous = tumble_store_previous(store);
    if (previous == NO_REGION) {
        return TUMBLE_E_STATE;
    }
    store->source = previous;
    store->stamp.restores = store->places[previous].stamp.sequence;
    tumble_slots_begin(&store->slots, plan);
    return TUMBLE_OK;
}

tumble_status_t tumble_store_write_factory(tumble_store_t *store, const tumble_set_t *set)
{
    static const uint8_t plan[] = {SLOT_BLANK | IN_FACTORY, SLOT_BODY | IN_FACTORY, SLOT_MARK | IN_FACTORY, SLOT_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_FACTORY);
    if (status != TUMBLE_OK) {
        return status;
    }
    const bool possible = !store->places[TUMBLE_REGION_FACTORY].valid && (store->factory_place < TUMBLE_FACTORY_PLACES);
    return possible ? take(store, set, plan) : TUMBLE_E_STATE;
}
