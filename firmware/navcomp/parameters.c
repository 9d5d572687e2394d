#include "navcomp/parameters.h"

#include "core/bytes.h"
#include "core/one_copy.h"
#include "navcomp/keeper_objects.h"
#include "sets/memory.h"
#include "sets/record.h"

#include <string.h>

#define AT_USED 6U
#define AT_SEQUENCE 8U
#define AT_VALUES 12U
#define AT_CRC 284U
#define AT_MARK 288U
#define MARK_BYTES (TUMBLE_PARAMETERS_BYTES - AT_MARK)
#define FIRST_SUBINDEX 1U

static_assert((AT_VALUES + TUMBLE_KEEPER_SAVED_BYTES) <= AT_CRC, "all that is saved must fit the record");
static_assert((AT_MARK % TUMBLE_NV_MAX_GRANULE) == 0U, "the mark has granules of its own");

static const uint8_t head[AT_USED] = {0x54, 0x50, 0x41, 0x52, 1, 0}; /* TPAR, schema */
static const uint8_t mark[MARK_BYTES] = {
    'T', 'P', 'A', 'R', 'G', 'O', 'O', 'D', 'T', 'P', 'A', 'R', 'G', 'O', 'O', 'D',
    'T', 'P', 'A', 'R', 'G', 'O', 'O', 'D', 'T', 'P', 'A', 'R', 'G', 'O', 'O', 'D',
};

static const tumble_record_t record = {.head = head, .head_bytes = sizeof head, .crc_at = AT_CRC};

bool tumble_parameters_busy(const tumble_parameters_t *parameters)
{
    return tumble_cells_busy(&parameters->cells);
}

bool tumble_parameters_reading(const tumble_parameters_t *parameters)
{
    const bool reads = tumble_parameters_busy(parameters) && parameters->cells.scans;
    return parameters->again || (reads && !parameters->failed);
}

bool tumble_parameters_room(const tumble_parameters_t *parameters)
{
    return parameters->cells.nv != NULL;
}

static bool has_room(const tumble_nv_t *nv)
{
    return (tumble_regions_check(nv) == TUMBLE_OK) &&
           ((nv->size_bytes / nv->sector_bytes) >= (TUMBLE_REGION_PARAMETERS + 2U));
}

void tumble_parameters_init(tumble_parameters_t *parameters, const tumble_nv_t *nv, tumble_node_t *node,
                            tumble_store_t *store)
{
    static const tumble_cells_kind_t kind = {.region = TUMBLE_REGION_PARAMETERS,
                                             .per_sector = 1,
                                             .count = 2,
                                             .attempts = 3,
                                             .bytes = TUMBLE_PARAMETERS_BYTES,
                                             .record_bytes = AT_MARK,
                                             .erased_bytes = TUMBLE_PARAMETERS_BYTES};
    *parameters = (tumble_parameters_t){.node = node, .store = store};
    (void)tumble_cells_open(&parameters->cells, &kind, has_room(nv) ? nv : NULL);
}

void tumble_parameters_restore(tumble_parameters_t *parameters)
{
    parameters->again = tumble_parameters_busy(parameters);
    if (!parameters->again) {
        parameters->view = (tumble_parameters_view_t){0};
        parameters->looked = 0;
        tumble_cells_scan(&parameters->cells);
    }
}

static void rest(tumble_parameters_t *parameters)
{
    if (parameters->again) {
        tumble_parameters_restore(parameters);
    }
}

/* Reading. */

/* The sequence of the record in `bytes`; 0: there is none. */
static uint32_t sequence_of(const uint8_t *bytes)
{
    const bool good = (tumble_record_check(&record, bytes, 0) == TUMBLE_OK) &&
                      (tumble_get_u16(&bytes[AT_USED]) <= (AT_CRC - AT_VALUES)) &&
                      (memcmp(&bytes[AT_MARK], mark, sizeof mark) == 0);
    return good ? tumble_get_u32(&bytes[AT_SEQUENCE]) : 0U;
}

/* The values of one object, up to `end`. Returns where the next one begins. */
static uint32_t apply_object(tumble_parameters_t *parameters, uint32_t at, uint32_t end)
{
    const uint8_t *bytes = parameters->store->bytes;
    const uint16_t index = tumble_get_u16(&bytes[at]);
    const uint8_t count = bytes[at + 2U];
    at += 3U;
    for (uint8_t i = 0; (i < count) && (at < end) && (bytes[at] < (end - at)); i++) {
        const uint8_t size = bytes[at];
        const uint8_t subindex = (uint8_t)(FIRST_SUBINDEX + i);
        if (tumble_node_write(parameters->node, index, subindex, &bytes[at + 1U], size) == TUMBLE_ABORT_NONE) {
            parameters->view.applied++;
        } else {
            parameters->view.refused++;
        }
        at += 1U + (uint32_t)size;
    }
    return at;
}

static void apply(tumble_parameters_t *parameters)
{
    const uint32_t end = AT_VALUES + (uint32_t)tumble_get_u16(&parameters->store->bytes[AT_USED]);
    uint32_t at = AT_VALUES;
    while ((at + 3U) < end) {
        at = apply_object(parameters, at, end);
    }
}

static void end(tumble_parameters_t *parameters, tumble_abort_t answer)
{
    tumble_node_answer(parameters->node, answer);
    rest(parameters);
}

/* Both have been read, and the better one is in the store's bytes if there is one. */
static void end_reading(tumble_parameters_t *parameters, bool good)
{
    if (parameters->failed) {
        parameters->failed = false;
        end(parameters, TUMBLE_ABORT_HARDWARE);
        return;
    }
    if (good) {
        apply(parameters);
        parameters->event = (parameters->view.applied != 0U) ? TUMBLE_PARAMETERS_APPLIED : TUMBLE_PARAMETERS_NOTHING;
    }
    rest(parameters);
}

/* A memory that cannot be read holds nothing. */
static void note_record(tumble_parameters_t *parameters)
{
    tumble_cells_t *cells = &parameters->cells;
    const uint32_t sequence = cells->was_read ? sequence_of(parameters->store->bytes) : 0U;
    parameters->looked++;
    if (parameters->looked > cells->kind->count) {
        tumble_cells_next(cells, cells->kind->count);
        end_reading(parameters, sequence != 0U);
        return;
    }
    if (sequence > parameters->view.sequence) {
        parameters->view.sequence = sequence;
        parameters->slot = cells->at;
    }
    tumble_cells_next(cells, (parameters->looked == cells->kind->count) ? parameters->slot : parameters->looked);
}

/* Writing. */

/* One object's present values. Returns where the next one goes. */
static uint32_t gather_object(tumble_parameters_t *parameters, const tumble_saved_t *saved, uint32_t at)
{
    uint8_t *bytes = parameters->store->bytes;
    tumble_put_u16(&bytes[at], saved->index);
    bytes[at + 2U] = saved->count;
    at += 3U;
    for (uint8_t i = 0; i < saved->count; i++) {
        uint8_t value[TUMBLE_MAX_OBJECT_BYTES];
        uint8_t size = 0;
        (void)tumble_node_read(parameters->node, saved->index, (uint8_t)(FIRST_SUBINDEX + i), value, &size);
        bytes[at] = size;
        (void)memcpy(&bytes[at + 1U], value, size);
        at += 1U + (uint32_t)size;
    }
    return at;
}

static tumble_abort_t begin(tumble_parameters_t *parameters, uint8_t objects)
{
    static const uint8_t plan[] = {CELL_ERASE, CELL_BODY, CELL_MARK, CELL_END};
    uint8_t *bytes = parameters->store->bytes;
    uint32_t at = AT_VALUES;
    if (!tumble_parameters_room(parameters) || parameters->cells.unread) {
        return TUMBLE_ABORT_HARDWARE;
    }
    if (tumble_parameters_busy(parameters)) {
        return TUMBLE_ABORT_DEVICE_STATE;
    }
    parameters->store->lent = true;
    tumble_record_fill(&record, NULL, bytes);
    for (uint8_t i = 0; i < objects; i++) {
        at = gather_object(parameters, &tumble_keeper_saved[i], at);
    }
    tumble_put_u16(&bytes[AT_USED], (uint16_t)(at - AT_VALUES));
    tumble_put_u32(&bytes[AT_SEQUENCE], parameters->view.sequence + 1U);
    tumble_record_seal(bytes, AT_CRC, 0);
    (void)memcpy(&bytes[AT_MARK], mark, sizeof mark);
    parameters->cells.where[0] = parameters->slot ^ 1U;
    tumble_cells_begin(&parameters->cells, plan);
    return TUMBLE_ABORT_LATER;
}

tumble_abort_t tumble_parameters_save(tumble_parameters_t *parameters)
{
    return begin(parameters, TUMBLE_KEEPER_SAVED);
}

tumble_abort_t tumble_parameters_forget(tumble_parameters_t *parameters)
{
    return begin(parameters, 0);
}

static void end_writing(tumble_parameters_t *parameters)
{
    parameters->slot ^= 1U;
    parameters->view.sequence++;
    parameters->event = TUMBLE_PARAMETERS_WRITTEN;
    end(parameters, TUMBLE_ABORT_NONE);
}

TUMBLE_ONE_COPY void tumble_parameters_step(tumble_parameters_t *parameters)
{
    const tumble_cells_event_t event = tumble_cells_step(&parameters->cells, parameters->store->bytes);
    if (event == TUMBLE_CELLS_READ) {
        note_record(parameters);
    } else if (event == TUMBLE_CELLS_DONE) {
        parameters->store->lent = false;
        end_writing(parameters);
    } else if (event == TUMBLE_CELLS_FAILED) {
        parameters->store->lent = false;
        parameters->failed = true;
        parameters->view.sequence = 0;
        parameters->looked = 0;
    } else {
        /* the memory is at work */
    }
}
