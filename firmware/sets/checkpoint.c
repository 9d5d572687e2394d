#include "core/arith.h"
#include "core/bytes.h"
#include "core/crc32.h"
#include "core/one_copy.h"
#include "sets/memory.h"
#include "sets/record.h"

#include <string.h>

/* Places of a job: the two sectors, the first of which begins with the header, and the cell of an entry. */
#define IN_FIRST 0x00U
#define IN_SECOND 0x01U
#define IN_TARGET 0x02U

#define CELLS_PER_SECTOR (TUMBLE_STORE_MIN_SECTOR / TUMBLE_CHECKPOINT_BYTES)
#define RUN_HEAD_BYTES 8U
#define AT_INDEX 2U
#define AT_MARGINS 44U
#define AT_CRC 60U

#define FIELD(member, width, count) {(uint16_t)offsetof(tumble_average_t, member), (width), (count)}
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

static_assert(TUMBLE_CHECKPOINT_CELLS <= UINT8_MAX, "a cell is one byte");
static_assert(TUMBLE_CHECKPOINT_CELLS > TUMBLE_MAX_POSITIONS, "every position must find a cell");

static const uint8_t run_head[RUN_HEAD_BYTES] = {0x54, 0x52, 0x55, 0x4E, 1, 0, TUMBLE_CHECKPOINT_BYTES, 0}; /* TRUN */
static const uint8_t entry_head[AT_INDEX] = {0x54, 0x50};                                                   /* TP */
static const tumble_field_t run_fields[] = {{(uint16_t)offsetof(tumble_checkpoint_t, fingerprint), 4, 1}};
static const tumble_field_t entry_fields[] = {
    {TUMBLE_FIELD_NONE, 1, 2},
    FIELD(samples, 4, 1),
    FIELD(sum_counts, 8, TUMBLE_CHANNELS),
    FIELD(scatter_counts, 4, TUMBLE_CHANNELS)}; /* the first of the two bytes is the index */
static const tumble_record_t run_record = {run_head, run_fields, AT_CRC, sizeof run_head, COUNT_OF(run_fields)};
static const tumble_record_t entry_record = {entry_head, entry_fields, AT_CRC, sizeof entry_head,
                                             COUNT_OF(entry_fields)};

/* Every entry is bound to its run: the CRC goes on from that of the fingerprint. */
static uint32_t crc_of_run(uint32_t fingerprint)
{
    uint8_t bytes[4];
    tumble_put_u32(bytes, fingerprint);
    return tumble_crc32(0, bytes, sizeof bytes);
}

static tumble_status_t check_average(uint8_t index, const tumble_average_t *average)
{
    bool finite = true;
    bool in_range =
        (index < TUMBLE_MAX_POSITIONS) && (average->samples > 0U) && ((int64_t)average->samples <= TUMBLE_MAX_SAMPLES);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double scatter = (double)average->scatter_counts[i];
        finite = finite && tumble_is_finite(scatter);
        in_range = in_range && !tumble_is_positive(-scatter);
    }
    if (!finite) {
        return TUMBLE_E_NOT_FINITE;
    }
    return in_range ? TUMBLE_OK : TUMBLE_E_ARGUMENT;
}

static void put_entry(const tumble_checkpoint_t *checkpoint, uint8_t index, const tumble_average_t *average,
                      uint8_t *bytes)
{
    tumble_record_fill(&entry_record, average, bytes);
    bytes[AT_INDEX] = index;
    bytes[AT_MARGINS] = checkpoint->margins.cold;
    bytes[AT_MARGINS + 1U] = checkpoint->margins.warm;
    tumble_record_seal(bytes, AT_CRC, crc_of_run(checkpoint->fingerprint));
}

static tumble_status_t get_entry(const tumble_checkpoint_t *checkpoint, tumble_average_t *average)
{
    const uint8_t *bytes = checkpoint->bytes;
    if (tumble_record_check(&entry_record, bytes, crc_of_run(checkpoint->fingerprint)) != TUMBLE_OK) {
        return TUMBLE_E_CRC;
    }
    tumble_record_read(&entry_record, bytes, average);
    return check_average(bytes[AT_INDEX], average);
}

static void forget(tumble_checkpoint_t *checkpoint)
{
    (void)memset(checkpoint->place, 0, sizeof checkpoint->place);
    checkpoint->kept = false;
    checkpoint->next = 1;
}

tumble_status_t tumble_checkpoint_init(tumble_checkpoint_t *checkpoint, const tumble_nv_t *nv)
{
    static const tumble_cells_kind_t kind = {.region = TUMBLE_REGION_CHECKPOINT,
                                             .per_sector = CELLS_PER_SECTOR,
                                             .count = TUMBLE_CHECKPOINT_CELLS,
                                             .attempts = 1,
                                             .pitch = TUMBLE_CHECKPOINT_BYTES,
                                             .bytes = TUMBLE_CHECKPOINT_BYTES,
                                             .record_bytes = TUMBLE_CHECKPOINT_BYTES,
                                             .erased_bytes = TUMBLE_STORE_MIN_SECTOR};
    if (checkpoint == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    forget(checkpoint);
    checkpoint->margins = (tumble_margins_t){0, 0};
    return tumble_cells_open(&checkpoint->cells, &kind, nv);
}

bool tumble_checkpoint_busy(const tumble_checkpoint_t *checkpoint)
{
    return tumble_cells_busy(&checkpoint->cells);
}

/* The first cell was read. */
static void note_header(tumble_checkpoint_t *checkpoint)
{
    checkpoint->kept = (tumble_record_check(&run_record, checkpoint->bytes, 0) == TUMBLE_OK);
    tumble_record_read(&run_record, checkpoint->bytes, checkpoint);
}

static void note_entry(tumble_checkpoint_t *checkpoint)
{
    tumble_cells_t *cells = &checkpoint->cells;
    tumble_average_t average;
    if (tumble_cells_is_blank(cells, checkpoint->bytes)) {
        return;
    }
    const bool valid = cells->was_read && (get_entry(checkpoint, &average) == TUMBLE_OK);
    checkpoint->next = cells->at + 1U;
    if (valid) {
        checkpoint->place[checkpoint->bytes[AT_INDEX]] = cells->at;
    }
    tumble_cells_note(cells, valid);
}

/* Without its header nothing is kept. */
static void note_cell(tumble_checkpoint_t *checkpoint)
{
    tumble_cells_t *cells = &checkpoint->cells;
    if (cells->at > 0U) {
        note_entry(checkpoint);
    } else if (cells->was_read) {
        note_header(checkpoint);
    } else {
        /* there is none */
    }
    tumble_cells_next(cells, checkpoint->kept ? (cells->at + 1U) : TUMBLE_CHECKPOINT_CELLS);
}

TUMBLE_ONE_COPY tumble_status_t tumble_checkpoint_step(tumble_checkpoint_t *checkpoint)
{
    const tumble_cells_event_t event = tumble_cells_step(&checkpoint->cells, checkpoint->bytes);
    if (event == TUMBLE_CELLS_READ) {
        note_cell(checkpoint);
    } else if (event == TUMBLE_CELLS_FAILED) {
        forget(checkpoint);
    } else {
        /* it goes on at the next step, or is done */
    }
    return tumble_checkpoint_busy(checkpoint) ? TUMBLE_E_PORT_BUSY : checkpoint->cells.outcome;
}

/* What a job writes is noted when it begins: nobody is told of it while busy, and where a job fails, a scan follows. */

/* The header comes last: before it nothing counts. */
static tumble_status_t erase(tumble_checkpoint_t *checkpoint, const uint8_t *plan)
{
    tumble_cells_t *cells = &checkpoint->cells;
    const tumble_status_t status = tumble_cells_ready(cells);
    if (status == TUMBLE_OK) {
        forget(checkpoint);
        cells->where[IN_FIRST] = 0;
        cells->where[IN_SECOND] = CELLS_PER_SECTOR;
        tumble_cells_begin(cells, plan);
    }
    return status;
}

tumble_status_t tumble_checkpoint_begin(tumble_checkpoint_t *checkpoint, uint32_t fingerprint)
{
    static const uint8_t plan[] = {CELL_ERASE | IN_FIRST, CELL_ERASE | IN_SECOND, CELL_BODY | IN_FIRST, CELL_END};
    const tumble_status_t status = erase(checkpoint, plan);
    if (status == TUMBLE_OK) {
        checkpoint->fingerprint = fingerprint;
        checkpoint->kept = true;
        tumble_record_fill(&run_record, checkpoint, checkpoint->bytes);
        tumble_record_seal(checkpoint->bytes, AT_CRC, 0);
    }
    return status;
}

tumble_status_t tumble_checkpoint_clear(tumble_checkpoint_t *checkpoint)
{
    static const uint8_t plan[] = {CELL_ERASE | IN_FIRST, CELL_END};
    return erase(checkpoint, plan);
}

tumble_status_t tumble_checkpoint_append(tumble_checkpoint_t *checkpoint, uint8_t index,
                                         const tumble_average_t *average)
{
    static const uint8_t plan[] = {CELL_BODY | IN_TARGET, CELL_END};
    tumble_status_t status = tumble_cells_ready(&checkpoint->cells);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (average == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!checkpoint->kept) {
        return TUMBLE_E_STATE;
    }
    status = check_average(index, average);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (checkpoint->next >= TUMBLE_CHECKPOINT_CELLS) {
        return TUMBLE_E_FULL;
    }
    put_entry(checkpoint, index, average, checkpoint->bytes);
    checkpoint->cells.where[IN_TARGET] = checkpoint->next;
    tumble_cells_begin(&checkpoint->cells, plan);
    checkpoint->place[index] = checkpoint->next;
    checkpoint->next++;
    return TUMBLE_OK;
}

void tumble_checkpoint_narrow(tumble_checkpoint_t *checkpoint, tumble_margins_t seen)
{
    tumble_margins_t *const margins = &checkpoint->margins;
    margins->cold = (seen.cold < margins->cold) ? seen.cold : margins->cold;
    margins->warm = (seen.warm < margins->warm) ? seen.warm : margins->warm;
}

/* At an end of what a sample can tell a block may have been colder or warmer still: then the range is not known. The end
 * of the cold is two values wide, for a block whose values are as many below 0 as above ends at -63.5 degrees C. */
void tumble_margins_range(const tumble_margins_t *margins, tumble_set_t *set)
{
    const int min_half_c = (int)margins->cold + (int)INT8_MIN;
    const int max_half_c = (int)INT8_MAX - (int)margins->warm;
    if ((min_half_c > -(int)INT8_MAX) && (max_half_c < (int)INT8_MAX) && (min_half_c <= max_half_c)) {
        set->temperature_min_half_c = (int8_t)min_half_c;
        set->temperature_max_half_c = (int8_t)max_half_c;
        set->flags |= TUMBLE_SET_HAS_TEMPERATURE_RANGE;
    }
}

bool tumble_checkpoint_matches(const tumble_checkpoint_t *checkpoint, uint32_t fingerprint)
{
    return !tumble_checkpoint_busy(checkpoint) && checkpoint->kept && (checkpoint->fingerprint == fingerprint);
}

bool tumble_checkpoint_has(const tumble_checkpoint_t *checkpoint, uint8_t index)
{
    return !tumble_checkpoint_busy(checkpoint) && (index < TUMBLE_MAX_POSITIONS) && (checkpoint->place[index] != 0U);
}

TUMBLE_ONE_COPY tumble_status_t tumble_checkpoint_read(tumble_checkpoint_t *checkpoint, uint8_t index,
                                                       tumble_average_t *average)
{
    if (tumble_checkpoint_busy(checkpoint)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if (average == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!tumble_checkpoint_has(checkpoint, index)) {
        return TUMBLE_E_MISSING_POSITION;
    }
    const tumble_status_t status = tumble_cells_read(&checkpoint->cells, checkpoint->place[index], checkpoint->bytes);
    if (status != TUMBLE_OK) {
        return status;
    }
    tumble_average_t read = {0};
    if ((get_entry(checkpoint, &read) != TUMBLE_OK) || (checkpoint->bytes[AT_INDEX] != index)) {
        return TUMBLE_E_CRC;
    }
    *average = read;
    const tumble_margins_t margins = {checkpoint->bytes[AT_MARGINS], checkpoint->bytes[AT_MARGINS + 1U]};
    tumble_checkpoint_narrow(checkpoint, margins);
    return TUMBLE_OK;
}
