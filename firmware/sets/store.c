/* The store: four regions of sets, of which one is active. What is under way is a scan of all places, or a job, action by
 * action. A scan follows every job, so that the store answers what the memory really holds, also where the job failed.
 *
 * A commit swaps the slots. The set in force is never touched; the mark, written last, puts the new one in force:
 *
 *                   slot A             slot B                     in force after a loss of power here
 *
 *     before        set 7, marked      set 6, marked              7
 *     erase B       set 7, marked      any bytes                  7
 *     look          set 7, marked      blank, or the job fails    7
 *     record        set 7, marked      set 8, no mark             7: a record without its mark is not valid
 *     read back     set 7, marked      set 8, no mark             7
 *     mark          set 7, marked      set 8, a part of a mark    7, or 8 if the mark is whole
 *     after         set 7, marked      set 8, marked              8: the higher sequence
 *
 * There is one edge case: a mark that an erase has left standing must not make another record valid. The mark therefore
 * repeats the CRC of its record, and is valid for that record alone.
 */
#include "core/bytes.h"
#include "core/count.h"
#include "core/one_copy.h"
#include "sets/memory.h"
#include "sets/record.h"

#include <string.h>

#define FACTORY ((uint8_t)TUMBLE_REGION_FACTORY)
#define SLOT_A ((uint8_t)TUMBLE_REGION_SLOT_A)
#define SLOT_B ((uint8_t)TUMBLE_REGION_SLOT_B)
#define PROPOSAL ((uint8_t)TUMBLE_REGION_PROPOSAL)
#define NO_REGION 0xFFU
#define REGIONS 4U

/* Places of a job. */
#define IN_FACTORY 0x00U
#define IN_TARGET 0x01U /* the slot that is not active */
#define IN_OTHER 0x02U  /* the slot that was active when the job began */
#define IN_PROPOSAL 0x03U
#define IN_SOURCE 0x04U /* what a rollback brings back */

#define MARK_CRC 4U
#define SET_MAGIC 0x54455354U /* "TSET" */

static_assert((TUMBLE_FACTORY_PLACES * TUMBLE_FACTORY_PITCH) <= TUMBLE_STORE_MIN_SECTOR, "a region is one sector");

static const uint8_t done[MARK_CRC] = {0x44, 0x4F, 0x4E, 0x45}; /* DONE */

/* The regions. */

static bool is_slot(uint8_t region)
{
    return (region == SLOT_A) || (region == SLOT_B);
}

static uint8_t other_slot(uint8_t region)
{
    return (region == SLOT_A) ? SLOT_B : SLOT_A;
}

static uint8_t cell_of(const tumble_store_t *store, uint8_t region)
{
    return (region == FACTORY) ? store->factory : (uint8_t)(region * TUMBLE_FACTORY_PLACES);
}

static bool is_there(const tumble_store_place_t *place)
{
    return place->stamp.origin != 0U;
}

/* NO_REGION: there is none. */
static uint8_t active_region(const tumble_store_t *store)
{
    const tumble_store_place_t *a = &store->places[SLOT_A];
    const tumble_store_place_t *b = &store->places[SLOT_B];
    if (is_there(a) && (!is_there(b) || (a->stamp.sequence > b->stamp.sequence))) {
        return SLOT_A;
    }
    if (is_there(b)) {
        return SLOT_B;
    }
    return is_there(&store->places[FACTORY]) ? FACTORY : NO_REGION;
}

static bool was_rolled_back(const tumble_store_place_t *place)
{
    return place->stamp.origin == (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK;
}

/* What a rollback would bring back. */
static uint8_t previous_region(const tumble_store_t *store)
{
    const uint8_t active = active_region(store);
    if (!is_slot(active)) {
        return NO_REGION;
    }
    const tumble_store_place_t *place = &store->places[active];
    const uint8_t other = other_slot(active);
    if (is_there(&store->places[other]) && !was_rolled_back(place)) {
        return other;
    }
    const bool is_factory_copy = was_rolled_back(place) && (place->stamp.restores == 0U);
    return (is_there(&store->places[FACTORY]) && !is_factory_copy) ? FACTORY : NO_REGION;
}

/* Is the proposal active already, and has only not been cleared yet? */
static bool is_stale(const tumble_store_t *store)
{
    const tumble_store_place_t *proposal = &store->places[PROPOSAL];
    const uint8_t active = active_region(store);
    return is_there(proposal) && is_slot(active) && (store->places[active].stamp.from_crc == proposal->crc);
}

static uint8_t find(const tumble_store_t *store, tumble_which_set_t which)
{
    switch (which) {
    case TUMBLE_SET_ACTIVE:
        return active_region(store);
    case TUMBLE_SET_FACTORY:
        return is_there(&store->places[FACTORY]) ? FACTORY : NO_REGION;
    case TUMBLE_SET_PROPOSAL:
        return (is_there(&store->places[PROPOSAL]) && !is_stale(store)) ? PROPOSAL : NO_REGION;
    case TUMBLE_SET_PREVIOUS:
        return previous_region(store);
    default:
        return NO_REGION;
    }
}

/* Record and mark. */

/* See the edge case above. */
void tumble_store_mark(uint8_t bytes[TUMBLE_SET_PLACE_BYTES])
{
    uint8_t *mark = &bytes[TUMBLE_SET_BYTES];
    (void)memset(mark, 0xFF, TUMBLE_SET_MARK_BYTES);
    (void)memcpy(mark, done, sizeof done);
    tumble_put_u32(&mark[MARK_CRC], tumble_set_crc(bytes));
}

static bool is_marked(const uint8_t bytes[TUMBLE_SET_PLACE_BYTES])
{
    const uint8_t *mark = &bytes[TUMBLE_SET_BYTES];
    return (memcmp(mark, done, sizeof done) == 0) && (tumble_get_u32(&mark[MARK_CRC]) == tumble_set_crc(bytes));
}

/* What was read into the store. */
static bool is_valid(const tumble_store_t *store)
{
    return is_marked(store->bytes) && (store->read_set(store->bytes, NULL) == TUMBLE_OK);
}

/* Its checksum and its mark are right, so nothing has decayed. */
static bool is_whole(const uint8_t bytes[TUMBLE_SET_PLACE_BYTES])
{
    return (tumble_get_u32(bytes) == SET_MAGIC) && is_marked(bytes) &&
           tumble_record_is_sealed(bytes, TUMBLE_SET_BYTES - sizeof(uint32_t), 0);
}

/* The scan. */

static void begin_scan(tumble_store_t *store)
{
    (void)memset(store->places, 0, sizeof store->places);
    store->newer = false;
    store->factory = TUMBLE_FACTORY_PLACES;
    tumble_cells_scan(&store->cells);
}

tumble_status_t tumble_store_init(tumble_store_t *store, const tumble_nv_t *nv)
{
    static const tumble_cells_kind_t kind = {.region = TUMBLE_REGION_FACTORY,
                                             .per_sector = TUMBLE_FACTORY_PLACES,
                                             .count = REGIONS * TUMBLE_FACTORY_PLACES,
                                             .attempts = 3,
                                             .pitch = TUMBLE_FACTORY_PITCH,
                                             .bytes = TUMBLE_SET_PLACE_BYTES,
                                             .record_bytes = TUMBLE_SET_BYTES,
                                             .erased_bytes = TUMBLE_SET_PLACE_BYTES};
    if (store == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    *store = (tumble_store_t){.factory = TUMBLE_FACTORY_PLACES, .read_set = tumble_set_read};
    return tumble_cells_open(&store->cells, &kind, nv);
}

/* The first valid factory set counts. While there is none, the first blank place is where it would go. */
static void note_place(tumble_store_t *store)
{
    const tumble_cells_t *cells = &store->cells;
    const bool valid = cells->was_read && is_valid(store);
    const bool blank = tumble_cells_is_blank(cells, store->bytes);
    const bool newer = cells->was_read && !valid && is_whole(store->bytes);
    const uint8_t region = (uint8_t)(cells->at / TUMBLE_FACTORY_PLACES);
    tumble_store_place_t *place = &store->places[region];
    const bool nowhere = (store->factory == TUMBLE_FACTORY_PLACES);
    if ((region == FACTORY) && !is_there(place) && (valid || (blank && nowhere))) {
        store->factory = cells->at;
    }
    if (valid && !is_there(place)) {
        place->crc = tumble_set_crc(store->bytes);
        tumble_set_get_stamp(store->bytes, &place->stamp);
    }
    store->newer = store->newer || newer;
    tumble_cells_note(&store->cells, valid || blank || newer);
}

/* Where the next job goes: `target` is the slot that it writes. */
static void aim(tumble_store_t *store, uint8_t target)
{
    uint8_t *where = store->cells.where;
    where[IN_FACTORY] = cell_of(store, FACTORY);
    where[IN_TARGET] = cell_of(store, target);
    where[IN_OTHER] = cell_of(store, other_slot(target));
    where[IN_PROPOSAL] = cell_of(store, PROPOSAL);
}

/* What a job left behind when power was lost: a proposal that is active already, and after a rollback the set that was
 * to be given up. */
TUMBLE_ONE_COPY static void clear_leftovers(tumble_store_t *store)
{
    static const uint8_t clear_both[] = {CELL_ERASE | IN_PROPOSAL, CELL_ERASE | IN_OTHER, CELL_END};
    static const uint8_t clear_proposal[] = {CELL_ERASE | IN_PROPOSAL, CELL_END};
    const uint8_t active = active_region(store);
    const bool rejected =
        is_slot(active) && was_rolled_back(&store->places[active]) && is_there(&store->places[other_slot(active)]);
    aim(store, active);
    if (is_stale(store)) {
        tumble_cells_begin(&store->cells, rejected ? clear_both : clear_proposal);
    } else if (rejected) {
        tumble_cells_begin(&store->cells, &clear_both[1]);
    } else {
        /* nothing is left over */
    }
}

static void end_scan(tumble_store_t *store, bool first)
{
    const uint8_t active = active_region(store);
    const uint32_t sequence = is_slot(active) ? store->places[active].stamp.sequence : 0U;
    if (!first && (sequence > store->sequence)) {
        tumble_count(&store->commits);
    }
    store->sequence = sequence;
    store->highest = (sequence > store->highest) ? sequence : store->highest;
    if (first) {
        clear_leftovers(store);
    }
}

/* The factory set has several places in its sector, the other regions the first of theirs. */
static void scan(tumble_store_t *store)
{
    tumble_cells_t *cells = &store->cells;
    const bool first = !cells->booted;
    const bool alone = (cells->at >= (TUMBLE_FACTORY_PLACES - 1U));
    note_place(store);
    tumble_cells_next(cells,
                      alone ? ((cells->at / TUMBLE_FACTORY_PLACES) + 1U) * TUMBLE_FACTORY_PLACES : (cells->at + 1U));
    if (!cells->scans) {
        end_scan(store, first);
    }
}

/* A job. */

/* A record was read to be copied: put the job's stamp on it, and, of a proposal, from which one it is. A held proposal is
 * stamped "accepted"; the copy that a rollback has staged stays stamped "rolled back". */
static tumble_cells_event_t load(tumble_store_t *store)
{
    if (!is_valid(store)) {
        return tumble_cells_fail(&store->cells, TUMBLE_E_CRC);
    }
    if (*store->cells.plan == (CELL_LOAD | IN_PROPOSAL)) {
        store->stamp.from_crc = tumble_set_crc(store->bytes);
    }
    tumble_set_add_flags(store->bytes, store->flags);
    tumble_set_stamp(store->bytes, &store->stamp);
    tumble_store_mark(store->bytes);
    return tumble_cells_pass(&store->cells);
}

static tumble_cells_event_t act(tumble_store_t *store)
{
    const tumble_cells_event_t event = tumble_cells_step(&store->cells, store->bytes);
    return ((event == TUMBLE_CELLS_READ) && !store->cells.scans) ? load(store) : event;
}

bool tumble_store_busy(const tumble_store_t *store)
{
    return tumble_cells_busy(&store->cells);
}

TUMBLE_ONE_COPY tumble_status_t tumble_store_step(tumble_store_t *store)
{
    const tumble_cells_event_t event = act(store);
    if (event == TUMBLE_CELLS_READ) {
        scan(store);
    } else if (event != TUMBLE_CELLS_NOTHING) {
        begin_scan(store);
    } else {
        /* it goes on at the next step */
    }
    return tumble_store_outcome(store);
}

tumble_status_t tumble_store_outcome(const tumble_store_t *store)
{
    return tumble_store_busy(store) ? TUMBLE_E_PORT_BUSY : store->cells.outcome;
}

/* What there is. */

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

bool tumble_store_has(const tumble_store_t *store, tumble_which_set_t which)
{
    return !tumble_store_busy(store) && (find(store, which) != NO_REGION);
}

bool tumble_store_has_newer(const tumble_store_t *store)
{
    return store->newer;
}

uint32_t tumble_store_proposal(const tumble_store_t *store)
{
    return tumble_store_has(store, TUMBLE_SET_PROPOSAL) ? store->places[PROPOSAL].crc : 0U;
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
    tumble_status_t status = tumble_cells_read(&store->cells, cell_of(store, region), store->bytes);
    if (status == TUMBLE_OK) {
        status = is_marked(store->bytes) ? store->read_set(store->bytes, set) : TUMBLE_E_FRAME;
        if (status != TUMBLE_OK) {
            tumble_count(&store->cells.nv_errors);
        }
    }
    if ((status != TUMBLE_OK) && (status != TUMBLE_E_PORT_BUSY)) {
        begin_scan(store);
    }
    return status;
}

/* The jobs. */

/* What every job needs: no other job under way, and, if it makes a set active, a sequence below the last one. */
static tumble_status_t prepare(tumble_store_t *store, uint8_t origin)
{
    const tumble_status_t status = tumble_cells_ready(&store->cells);
    if ((status != TUMBLE_OK) || store->lent) {
        return (status == TUMBLE_E_STATE) ? status : TUMBLE_E_PORT_BUSY;
    }
    store->flags = 0;
    if (store->cells.unread) { /* a place that could not be read may hold the active set: look again first */
        begin_scan(store);
        return TUMBLE_E_NV;
    }
    store->stamp = (tumble_set_stamp_t){.origin = origin};
    aim(store, other_slot(active_region(store)));
    if (origin == (uint8_t)TUMBLE_ORIGIN_FACTORY) {
        return TUMBLE_OK;
    }
    store->stamp.sequence = store->highest + 1U;
    return (store->highest >= TUMBLE_MAX_SEQUENCE) ? TUMBLE_E_STATE : TUMBLE_OK;
}

static tumble_status_t take(tumble_store_t *store, const tumble_set_t *set, const uint8_t *plan)
{
    const tumble_status_t status = tumble_set_encode_as(set, &store->stamp, store->bytes);
    if (status == TUMBLE_OK) {
        tumble_store_mark(store->bytes);
        tumble_cells_begin(&store->cells, plan);
    }
    return status;
}

tumble_status_t tumble_store_commit(tumble_store_t *store, const tumble_set_t *set)
{
    /* From its second action where nothing is left over. */
    static const uint8_t plan[] = {CELL_ERASE | IN_PROPOSAL, CELL_ERASE | IN_TARGET, CELL_BODY | IN_TARGET,
                                   CELL_MARK | IN_TARGET, CELL_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_COMMITTED);
    return (status == TUMBLE_OK) ? take(store, set, is_stale(store) ? plan : &plan[1]) : status;
}

tumble_status_t tumble_store_hold(tumble_store_t *store, const tumble_set_t *set)
{
    static const uint8_t plan[] = {CELL_ERASE | IN_PROPOSAL, CELL_BODY | IN_PROPOSAL, CELL_MARK | IN_PROPOSAL,
                                   CELL_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_HELD);
    return (status == TUMBLE_OK) ? take(store, set, plan) : status;
}

/* A rollback makes a copy of the old set the proposal, and goes on from there. */
static const uint8_t rollback[] = {CELL_LOAD | IN_SOURCE,
                                   CELL_ERASE | IN_PROPOSAL,
                                   CELL_BODY | IN_PROPOSAL,
                                   CELL_MARK | IN_PROPOSAL,
                                   CELL_LOAD | IN_PROPOSAL,
                                   CELL_ERASE | IN_TARGET,
                                   CELL_BODY | IN_TARGET,
                                   CELL_MARK | IN_TARGET,
                                   CELL_ERASE | IN_PROPOSAL,
                                   CELL_ERASE | IN_OTHER,
                                   CELL_END};
#define FROM_PROPOSAL 4U /* of its actions */

/* Go on from the proposal. A copy that a rollback has staged is finished as a rollback. */
static tumble_status_t take_proposal(tumble_store_t *store)
{
    static const uint8_t accept[] = {CELL_LOAD | IN_PROPOSAL, CELL_ERASE | IN_TARGET,   CELL_BODY | IN_TARGET,
                                     CELL_MARK | IN_TARGET,   CELL_ERASE | IN_PROPOSAL, CELL_END};
    const tumble_store_place_t *proposal = &store->places[PROPOSAL];
    const bool staged = was_rolled_back(proposal);
    store->stamp.restores = proposal->stamp.restores;
    store->stamp.origin = staged ? (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK : (uint8_t)TUMBLE_ORIGIN_ACCEPTED;
    tumble_cells_begin(&store->cells, staged ? &rollback[FROM_PROPOSAL] : accept);
    return TUMBLE_OK;
}

tumble_status_t tumble_store_accept(tumble_store_t *store, uint16_t flags)
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
    static const uint8_t plan[] = {CELL_ERASE | IN_PROPOSAL, CELL_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_FACTORY); /* gives out no sequence */
    if (status != TUMBLE_OK) {
        return status;
    }
    if (!tumble_store_has(store, TUMBLE_SET_PROPOSAL)) {
        return TUMBLE_E_STATE;
    }
    tumble_cells_begin(&store->cells, plan);
    return TUMBLE_OK;
}

TUMBLE_ONE_COPY tumble_status_t tumble_store_rollback(tumble_store_t *store)
{
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (tumble_store_has(store, TUMBLE_SET_PROPOSAL)) {
        return was_rolled_back(&store->places[PROPOSAL]) ? take_proposal(store) : TUMBLE_E_STATE;
    }
    const uint8_t previous = previous_region(store);
    if (previous == NO_REGION) {
        return TUMBLE_E_STATE;
    }
    store->cells.where[IN_SOURCE] = cell_of(store, previous);
    store->stamp.restores = store->places[previous].stamp.sequence;
    tumble_cells_begin(&store->cells, rollback);
    return TUMBLE_OK;
}

tumble_status_t tumble_store_write_factory(tumble_store_t *store, const tumble_set_t *set)
{
    static const uint8_t plan[] = {CELL_BLANK | IN_FACTORY, CELL_BODY | IN_FACTORY, CELL_MARK | IN_FACTORY, CELL_END};
    const tumble_status_t status = prepare(store, (uint8_t)TUMBLE_ORIGIN_FACTORY);
    if (status != TUMBLE_OK) {
        return status;
    }
    const bool possible = !is_there(&store->places[FACTORY]) && (store->factory < TUMBLE_FACTORY_PLACES);
    return possible ? take(store, set, plan) : TUMBLE_E_STATE;
}
