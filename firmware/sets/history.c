#include "core/arith.h"
#include "core/bytes.h"
#include "core/coefficient.h"
#include "core/one_copy.h"
#include "sets/memory.h"
#include "sets/record.h"

#include <float.h>
#include <string.h>

#define AT_FIELDS 4U
#define AT_CRC 124U
#define MAX_NUMBER (UINT32_MAX - 1U)

#define FIELD(member, width, count) {(uint16_t)offsetof(tumble_history_entry_t, member), (width), (count)}
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* Places of a job: the other sector, which is erased, and the cell that is written. */
#define IN_OTHER 0x00U
#define IN_TARGET 0x01U

static_assert(TUMBLE_HISTORY_CELLS == 32U, "the valid cells of a sector are the bits of one word");

/* An entry and its bytes. */

static const uint8_t magic[AT_FIELDS] = {0x54, 0x48, 0x53, 0x31}; /* THS1 */
static const tumble_field_t fields[] = {
    FIELD(number, 4, 1),
    FIELD(sequence, 4, 1),
    FIELD(origin, 1, 1),
    FIELD(estimator, 1, 1),
    FIELD(flags, 2, 1),
    FIELD(date_utc_s, 8, 1),
    FIELD(temperature_c, 4, 1),
    FIELD(value, 4, TUMBLE_COEFFICIENTS),
    FIELD(u, 4, TUMBLE_COEFFICIENTS),
};
static const tumble_record_t record = {magic, fields, AT_CRC, sizeof magic, COUNT_OF(fields)};

static bool is_finite(const tumble_history_entry_t *entry)
{
    bool finite = tumble_is_finite((double)entry->temperature_c);
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        finite = finite && tumble_is_finite((double)entry->value[c]) && tumble_is_finite((double)entry->u[c]);
    }
    return finite;
}

void tumble_history_number(uint8_t bytes[TUMBLE_HISTORY_BYTES], uint32_t number)
{
    tumble_put_u32(&bytes[AT_FIELDS], number);
    tumble_record_seal(bytes, AT_CRC, 0);
}

tumble_status_t tumble_history_encode(const tumble_history_entry_t *entry, uint8_t bytes[TUMBLE_HISTORY_BYTES])
{
    if ((entry == NULL) || (bytes == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!is_finite(entry)) {
        return TUMBLE_E_NOT_FINITE;
    }
    tumble_record_fill(&record, entry, bytes);
    tumble_record_seal(bytes, AT_CRC, 0);
    return TUMBLE_OK;
}

tumble_status_t tumble_history_decode(const uint8_t bytes[TUMBLE_HISTORY_BYTES], tumble_history_entry_t *entry)
{
    if ((bytes == NULL) || (entry == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = tumble_record_check(&record, bytes, 0);
    if (status != TUMBLE_OK) {
        return status;
    }
    tumble_history_entry_t read = {0};
    tumble_record_read(&record, bytes, &read);
    if (!is_finite(&read)) {
        return TUMBLE_E_NOT_FINITE;
    }
    *entry = read;
    return TUMBLE_OK;
}

/* Coefficients, or their uncertainties; false: one is too large. */
static bool shorten(const void *twelve, float numbers[TUMBLE_COEFFICIENTS])
{
    bool fit = true;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double number = tumble_coefficient(twelve, c);
        fit = fit && tumble_within(number, (double)FLT_MAX);
        numbers[c] = tumble_to_float(number);
    }
    return fit;
}

tumble_status_t tumble_history_from_set(const tumble_set_t *set, tumble_history_entry_t *entry)
{
    if ((set == NULL) || (entry == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_history_entry_t made = {.sequence = set->sequence,
                                   .date_utc_s = set->date_utc_s,
                                   .origin = set->origin,
                                   .estimator = set->estimator,
                                   .flags = set->flags};
    bool fits = shorten(&set->coefficients, made.value);
    if ((set->flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U) {
        fits = shorten(&set->uncertainty, made.u) && fits;
    }
    if (((set->flags & TUMBLE_SET_HAS_TEMPERATURE) != 0U) && tumble_within(set->temperature_c, (double)FLT_MAX)) {
        made.temperature_c = tumble_to_float(set->temperature_c);
    }
    if (!fits) {
        return TUMBLE_E_NOT_FINITE;
    }
    *entry = made;
    return TUMBLE_OK;
}

/* The log. */

static void forget(tumble_history_t *history)
{
    (void)memset(history->valid, 0, sizeof history->valid);
    (void)memset(history->used, 0, sizeof history->used);
    history->newest = 0;
    history->sequence = 0;
    history->sector = 0;
}

tumble_status_t tumble_history_init(tumble_history_t *history, const tumble_nv_t *nv)
{
    static const tumble_cells_kind_t kind = {.region = TUMBLE_REGION_HISTORY,
                                             .per_sector = TUMBLE_HISTORY_CELLS,
                                             .count = 2U * TUMBLE_HISTORY_CELLS,
                                             .attempts = 1,
                                             .pitch = TUMBLE_HISTORY_BYTES,
                                             .bytes = TUMBLE_HISTORY_BYTES,
                                             .record_bytes = TUMBLE_HISTORY_BYTES,
                                             .erased_bytes = TUMBLE_STORE_MIN_SECTOR};
    if (history == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    forget(history);
    return tumble_cells_open(&history->cells, &kind, nv);
}

bool tumble_history_busy(const tumble_history_t *history)
{
    return tumble_cells_busy(&history->cells);
}

static void note_cell(tumble_history_t *history)
{
    tumble_cells_t *cells = &history->cells;
    tumble_history_entry_t entry;
    if (!tumble_cells_is_blank(cells, history->bytes)) {
        const uint32_t sector = cells->at / TUMBLE_HISTORY_CELLS;
        const uint32_t within = cells->at % TUMBLE_HISTORY_CELLS;
        const bool valid = cells->was_read && (tumble_history_decode(history->bytes, &entry) == TUMBLE_OK);
        tumble_cells_note(cells, valid);
        history->used[sector] = (uint8_t)(within + 1U);
        history->valid[sector] |= (valid ? UINT32_C(1) : 0U) << within;
        if (valid && (entry.number > history->newest)) {
            history->newest = entry.number;
            history->sequence = entry.sequence;
            history->sector = (uint8_t)sector;
        }
    }
    tumble_cells_next(cells, cells->at + 1U);
}

TUMBLE_ONE_COPY tumble_status_t tumble_history_step(tumble_history_t *history)
{
    const tumble_cells_event_t event = tumble_cells_step(&history->cells, history->bytes);
    if (event == TUMBLE_CELLS_READ) {
        note_cell(history);
    } else if (event == TUMBLE_CELLS_FAILED) {
        forget(history);
    } else {
        /* it goes on at the next step, or is done */
    }
    return tumble_history_busy(history) ? TUMBLE_E_PORT_BUSY : history->cells.outcome;
}

/* What a job writes is noted when it begins, as in the checkpoint. */
tumble_status_t tumble_history_append(tumble_history_t *history, const tumble_history_entry_t *entry)
{
    /* From its second action where the sector has room. */
    static const uint8_t plan[] = {CELL_ERASE | IN_OTHER, CELL_BODY | IN_TARGET, CELL_END};
    tumble_cells_t *cells = &history->cells;
    tumble_status_t status = tumble_cells_ready(cells);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (history->newest >= MAX_NUMBER) {
        return TUMBLE_E_STATE;
    }
    status = tumble_history_encode(entry, history->bytes);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (cells->unread) { /* a cell that could not be read may hold the newest entry: look again first */
        forget(history);
        tumble_cells_scan(cells);
        return TUMBLE_E_NV;
    }
    const uint32_t other = (history->sector == 0U) ? 1U : 0U;
    const bool has_room = (history->used[history->sector] < TUMBLE_HISTORY_CELLS);
    if (!has_room) {
        history->valid[other] = 0;
        history->used[other] = 0;
    }
    const uint32_t sector = has_room ? history->sector : other;
    const uint32_t at = (sector * TUMBLE_HISTORY_CELLS) + history->used[sector];
    cells->where[IN_OTHER] = (uint8_t)(other * TUMBLE_HISTORY_CELLS);
    cells->where[IN_TARGET] = (uint8_t)at;
    tumble_cells_begin(cells, has_room ? &plan[1] : plan);
    tumble_history_number(history->bytes, history->newest + 1U);
    history->valid[sector] |= UINT32_C(1) << history->used[sector];
    history->used[sector]++;
    history->newest++;
    history->sequence = entry->sequence;
    history->sector = (uint8_t)sector;
    return TUMBLE_OK;
}

uint8_t tumble_history_count(const tumble_history_t *history)
{
    uint32_t entries = 0;
    for (uint32_t bit = 0; !tumble_history_busy(history) && (bit < TUMBLE_HISTORY_CELLS); bit++) {
        entries += ((history->valid[0] >> bit) & 1U) + ((history->valid[1] >> bit) & 1U);
    }
    return (uint8_t)entries;
}

uint32_t tumble_history_sequence(const tumble_history_t *history)
{
    return history->sequence;
}

/* From the newest backwards through its sector, then from the end of the other. */
static uint8_t cell_of_age(const tumble_history_t *history, uint8_t age)
{
    uint32_t left = age;
    uint32_t sector = history->sector;
    uint32_t at = TUMBLE_HISTORY_CELLS - 1U;
    while ((left > 0U) || (((history->valid[sector] >> at) & 1U) == 0U)) {
        left -= (history->valid[sector] >> at) & 1U;
        sector ^= (at == 0U) ? 1U : 0U;
        at = ((at == 0U) ? TUMBLE_HISTORY_CELLS : at) - 1U;
    }
    return (uint8_t)((sector * TUMBLE_HISTORY_CELLS) + at);
}

tumble_status_t tumble_history_read(tumble_history_t *history, uint8_t age, tumble_history_entry_t *entry)
{
    if (tumble_history_busy(history)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if ((entry == NULL) || (age >= tumble_history_count(history))) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = tumble_cells_read(&history->cells, cell_of_age(history, age), history->bytes);
    return (status == TUMBLE_OK) ? tumble_history_decode(history->bytes, entry) : status;
}
