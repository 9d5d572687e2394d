/* What is under way: a scan of all places, or a job, action by action. A scan follows every job, so that the store
 * answers what the memory really holds, also where the job failed.
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
#include "sets/store_job.h"

#include "core/bytes.h"
#include "core/count.h"
#include "core/one_copy.h"
#include "sets/nv_writer.h"
#include "sets/record.h"

#include <stddef.h>
#include <string.h>

#define SCAN_PLACES (TUMBLE_FACTORY_PLACES + 3U) /* factory set, both slots, proposal */
#define SCAN_DONE SCAN_PLACES
#define MARK_CRC 4U
#define SET_MAGIC 0x54455354U /* "TSET" */

static const uint8_t done[MARK_CRC] = {0x44, 0x4F, 0x4E, 0x45}; /* DONE */

uint8_t tumble_store_active(const tumble_store_t *store)
{
    const tumble_store_place_t *a = &store->places[TUMBLE_REGION_SLOT_A];
    const tumble_store_place_t *b = &store->places[TUMBLE_REGION_SLOT_B];
    if (a->valid && (!b->valid || (a->stamp.sequence > b->stamp.sequence))) {
        return (uint8_t)TUMBLE_REGION_SLOT_A;
    }
    if (b->valid) {
        return (uint8_t)TUMBLE_REGION_SLOT_B;
    }
    return store->places[TUMBLE_REGION_FACTORY].valid ? (uint8_t)TUMBLE_REGION_FACTORY : NO_REGION;
}

static bool was_rolled_back(const tumble_store_place_t *place)
{
    return place->stamp.origin == (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK;
}

uint8_t tumble_store_previous(const tumble_store_t *store)
{
    const uint8_t active = tumble_store_active(store);
    if (!tumble_store_is_slot(active)) {
        return NO_REGION;
    }
    const tumble_store_place_t *place = &store->places[active];
    const uint8_t other = tumble_store_other_slot(active);
    if (store->places[other].valid && !was_rolled_back(place)) {
        return other;
    }
    const bool is_factory_copy = was_rolled_back(place) && (place->stamp.restores == 0U);
    return (store->places[TUMBLE_REGION_FACTORY].valid && !is_factory_copy) ? (uint8_t)TUMBLE_REGION_FACTORY
                                                                            : NO_REGION;
}

bool tumble_store_is_stale(const tumble_store_t *store)
{
    const tumble_store_place_t *proposal = &store->places[TUMBLE_REGION_PROPOSAL];
    const uint8_t active = tumble_store_active(store);
    return proposal->valid && tumble_store_is_slot(active) && (store->places[active].stamp.from_crc == proposal->crc);
}

static uint32_t factory_offset(uint32_t place)
{
    return place * TUMBLE_FACTORY_PITCH;
}

uint32_t tumble_store_place(const tumble_store_t *store, uint8_t region)
{
    const uint32_t within = (region == (uint8_t)TUMBLE_REGION_FACTORY) ? factory_offset(store->factory_place) : 0U;
    return (region * store->slots.writer.nv->sector_bytes) + within;
}

/* See the edge case above. */
void tumble_store_set_mark(uint8_t bytes[TUMBLE_SET_PLACE_BYTES])
{
    uint8_t *mark = &bytes[TUMBLE_SET_BYTES];
    (void)memset(mark, 0xFF, TUMBLE_SET_MARK_BYTES);
    (void)memcpy(mark, done, sizeof done);
    tumble_put_u32(&mark[MARK_CRC], tumble_set_crc(bytes));
}

bool tumble_store_is_marked(const uint8_t bytes[TUMBLE_SET_PLACE_BYTES])
{
    const uint8_t *mark = &bytes[TUMBLE_SET_BYTES];
    return (memcmp(mark, done, sizeof done) == 0) && (tumble_get_u32(&mark[MARK_CRC]) == tumble_set_crc(bytes));
}

static bool is_valid(const uint8_t bytes[TUMBLE_SET_PLACE_BYTES])
{
    return tumble_store_is_marked(bytes) && (tumble_set_check(bytes) == TUMBLE_OK);
}

/* Its checksum and its mark are right, so nothing has decayed. */
static bool is_whole(const uint8_t bytes[TUMBLE_SET_PLACE_BYTES])
{
    return (tumble_get_u32(bytes) == SET_MAGIC) && tumble_store_is_marked(bytes) &&
           tumble_record_is_sealed(bytes, TUMBLE_SET_BYTES - sizeof(uint32_t), 0);
}

void tumble_store_begin_scan(tumble_store_t *store)
{
    (void)memset(store->places, 0, sizeof store->places);
    store->factory_place = TUMBLE_FACTORY_PLACES;
    store->scanned = 0;
    store->slots.failed_reads = 0;
    store->unread = false;
}

/* The first valid factory set counts. While there is none, the first blank place is where it would go. */
static void note_place(tumble_store_t *store, bool valid, bool blank, bool newer)
{
    const bool is_factory = store->scanned < TUMBLE_FACTORY_PLACES;
    const uint32_t region = is_factory ? 0U : (store->scanned - TUMBLE_FACTORY_PLACES + 1U);
    tumble_store_place_t *place = &store->places[region];
    if (is_factory && !place->valid && (valid || (blank && (store->factory_place == TUMBLE_FACTORY_PLACES)))) {
        store->factory_place = store->scanned;
    }
    if (valid && !place->valid) {
        place->valid = true;
        place->crc = tumble_set_crc(store->bytes);
        tumble_set_get_stamp(store->bytes, &place->stamp);
    }
    place->newer = place->newer || newer;
    if (!store->booted && !valid && !blank && !newer) {
        tumble_count(&store->counters.torn_at_boot);
    }
}

/* What a job left behind when power was lost: a proposal that is active already, and after a rollback the set that was
 * to be given up. */
TUMBLE_ONE_COPY static void clear_leftovers(tumble_store_t *store)
{
    static const uint8_t clear_proposal[] = {SLOT_ERASE | IN_PROPOSAL, SLOT_END};
    static const uint8_t clear_other[] = {SLOT_ERASE | IN_OTHER, SLOT_END};
    static const uint8_t clear_both[] = {SLOT_ERASE | IN_PROPOSAL, SLOT_ERASE | IN_OTHER, SLOT_END};
    const uint8_t active = tumble_store_active(store);
    const bool slot = tumble_store_is_slot(active);
    const bool rejected =
        slot && was_rolled_back(&store->places[active]) && store->places[tumble_store_other_slot(active)].valid;
    store->target = active;
    if (tumble_store_is_stale(store)) {
        tumble_slots_begin(&store->slots, rejected ? clear_both : clear_proposal);
    } else if (rejected) {
        tumble_slots_begin(&store->slots, clear_other);
    } else {
        tumble_slots_begin(&store->slots, NULL);
    }
}

static void end_scan(tumble_store_t *store)
{
    const uint8_t active = tumble_store_active(store);
    const uint32_t sequence = tumble_store_is_slot(active) ? store->places[active].stamp.sequence : 0U;
    if (store->booted && (sequence > store->sequence)) {
        tumble_count(&store->counters.commits);
    }
    store->sequence = sequence;
    store->highest = (sequence > store->highest) ? sequence : store->highest;
    if (!store->booted) {
        store->booted = true;
        clear_leftovers(store);
    }
}

static tumble_status_t scan(tumble_store_t *store)
{
    const uint32_t place = store->scanned;
    const uint32_t offset = (place < TUMBLE_FACTORY_PLACES)
                                ? factory_offset(place)
                                : ((place - TUMBLE_FACTORY_PLACES + 1U) * store->slots.writer.nv->sector_bytes);
    const tumble_status_t status = tumble_slots_read(&store->slots, offset, store->bytes, &store->counters.nv_errors);
    if (status == TUMBLE_E_PORT_BUSY) {
        return status;
    }
    const bool read = (status == TUMBLE_OK);
    store->unread = store->unread || !read;
    const bool valid = read && is_valid(store->bytes);
    note_place(store, valid, read && tumble_nv_is_blank(store->bytes, TUMBLE_SET_PLACE_BYTES),
               read && !valid && is_whole(store->bytes));
    store->scanned++;
    if (store->scanned == SCAN_DONE) {
        end_scan(store);
    }
    return tumble_store_busy(store) ? TUMBLE_E_PORT_BUSY : store->outcome;
}

static uint8_t region_of(const tumble_store_t *store, uint8_t where)
{
    const uint8_t regions[] = {(uint8_t)TUMBLE_REGION_FACTORY, store->target, tumble_store_other_slot(store->target),
                               (uint8_t)TUMBLE_REGION_PROPOSAL, store->source};
    return regions[where];
}

static void put_stamp(tumble_store_t *store)
{
    tumble_set_stamp(store->bytes, &store->stamp);
    tumble_store_set_mark(store->bytes);
}

/* A held proposal is stamped "accepted"; the copy that a rollback has staged stays stamped "rolled back". */
static tumble_status_t load(tumble_store_t *store, uint8_t region)
{
    const tumble_status_t status =
        tumble_nv_read(store->slots.writer.nv, tumble_store_place(store, region), store->bytes, TUMBLE_SET_PLACE_BYTES);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (!is_valid(store->bytes)) {
        return TUMBLE_E_CRC;
    }
    tumble_set_add_flags(store->bytes, store->flags);
    put_stamp(store);
    return TUMBLE_OK;
}

static tumble_status_t write_on(tumble_store_t *store, uint8_t region)
{
    const tumble_status_t status = tumble_slots_step(&store->slots, tumble_store_place(store, region), store->bytes);
    if ((status == TUMBLE_E_NV) && store->slots.writer.failed_to_hold) {
        tumble_count(&store->counters.verify);
    }
    return status;
}

static tumble_status_t act(tumble_store_t *store)
{
    const uint8_t what = *store->slots.plan & 0xF0U;
    const uint8_t region = region_of(store, *store->slots.plan & 0x0FU);
    if (what < SLOT_OWN) {
        return write_on(store, region);
    }
    if (what == PLAN_LOAD) {
        const tumble_status_t status = load(store, region);
        return (status == TUMBLE_OK) ? tumble_slots_pass(&store->slots) : status;
    }
    store->stamp.from_crc = tumble_set_crc(store->bytes);
    put_stamp(store);
    return tumble_slots_pass(&store->slots);
}

static void end_job(tumble_store_t *store, tumble_status_t outcome)
{
    if ((outcome == TUMBLE_E_NV) && !(store->slots.begun && store->slots.writer.failed_to_hold)) {
        tumble_count(&store->counters.nv_errors);
    }
    store->outcome = outcome;
    tumble_slots_begin(&store->slots, NULL);
    tumble_store_begin_scan(store);
}

bool tumble_store_busy(const tumble_store_t *store)
{
    return (store->slots.writer.nv != NULL) && ((store->scanned < SCAN_DONE) || (store->slots.plan != NULL));
}

TUMBLE_ONE_COPY tumble_status_t tumble_store_step(tumble_store_t *store)
{
    if (!tumble_store_busy(store)) {
        return store->outcome;
    }
    if (store->scanned < SCAN_DONE) {
        return scan(store);
    }
    const tumble_status_t status = act(store);
    if (status != TUMBLE_E_PORT_BUSY) {
        end_job(store, status);
    }
    return TUMBLE_E_PORT_BUSY;
}
