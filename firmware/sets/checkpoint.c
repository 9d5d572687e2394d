#include "sets/checkpoint.h"

#include "core/arith.h"
#include "core/crc32.h"
#include "sets/record.h"

#include <stddef.h>
#include <string.h>

enum { PHASE_IDLE = 0, PHASE_SCANNING, PHASE_CLEARING, PHASE_ERASING_FIRST, PHASE_ERASING_SECOND, PHASE_BEGINNING,
       PHASE_WRITING };

#define CELLS_PER_SECTOR (TUMBLE_STORE_MIN_SECTOR / TUMBLE_CHECKPOINT_BYTES)
#define AT_FINGERPRINT 8U
#define AT_INDEX 2U
#define AT_AVERAGE 4U
#define AT_CRC 60U

#define FIELD(member, width, count) {(uint16_t)offsetof(tumble_average_t, member), (width), (count)}
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

static_assert(TUMBLE_CHECKPOINT_CELLS <= UINT8_MAX, "a cell is one byte");
static_assert(TUMBLE_CHECKPOINT_CELLS > TUMBLE_MAX_POSITIONS, "every position must find a cell");

static const uint8_t run_head[AT_FINGERPRINT] = {0x54, 0x52, 0x55, 0x4E, 1, 0, TUMBLE_CHECKPOINT_BYTES, 0}; /* TRUN */
static const uint8_t entry_head[AT_INDEX] = {0x54, 0x50};                                                     /* TP */
static const tumble_field_t fields[] = {FIELD(samples, 4, 1), FIELD(sum_counts, 8, TUMBLE_CHANNELS),
                                        FIELD(scatter_counts, 4, TUMBLE_CHANNELS)};

static void count(uint32_t *counter)
{
    *counter += (*counter < UINT32_MAX) ? 1U : 0U;
}

static uint32_t offset_of(const tumble_checkpoint_t *checkpoint, uint32_t at)
{
    return (((uint32_t)TUMBLE_REGION_CHECKPOINT + (at / CELLS_PER_SECTOR)) * checkpoint->writer.nv->sector_bytes) +
           ((at % CELLS_PER_SECTOR) * TUMBLE_CHECKPOINT_BYTES);
}

/* Every entry is bound to its run: the CRC goes on from that of the fingerprint. */
static uint32_t crc_of_run(uint32_t fingerprint)
{
    uint8_t bytes[4];
    tumble_record_put_u32(bytes, fingerprint);
    return tumble_crc32(0, bytes, sizeof bytes);
}

static tumble_status_t check_average(uint8_t index, const tumble_average_t *average)
{
    bool finite = true;
    bool in_range = (index < TUMBLE_MAX_POSITIONS) && (average->samples > 0U) &&
                    ((int64_t)average->samples <= TUMBLE_MAX_SAMPLES);
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
    (void)memset(bytes, 0, TUMBLE_CHECKPOINT_BYTES);
    (void)memcpy(bytes, entry_head, sizeof entry_head);
    bytes[AT_INDEX] = index;
    tumble_record_encode(fields, COUNT_OF(fields), (const uint8_t *)average, &bytes[AT_AVERAGE]);
    tumble_record_seal(bytes, AT_CRC, crc_of_run(checkpoint->fingerprint));
}

static tumble_status_t get_entry(const tumble_checkpoint_t *checkpoint, tumble_average_t *average)
{
    const uint8_t *bytes = checkpoint->bytes;
    if ((memcmp(bytes, entry_head, sizeof entry_head) != 0) ||
        !tumble_record_is_sealed(bytes, AT_CRC, crc_of_run(checkpoint->fingerprint))) {
        return TUMBLE_E_CRC;
    }
    tumble_record_decode(fields, COUNT_OF(fields), &bytes[AT_AVERAGE], (uint8_t *)average);
    return check_average(bytes[AT_INDEX], average);
}

static void forget(tumble_checkpoint_t *checkpoint)
{
    (void)memset(checkpoint->place, 0, sizeof checkpoint->place);
    checkpoint->kept = false;
    checkpoint->next = 1;
}

static void begin_scan(tumble_checkpoint_t *checkpoint)
{
    forget(checkpoint);
    checkpoint->scanned = 0;
    checkpoint->phase = PHASE_SCANNING;
}

tumble_status_t tumble_checkpoint_init(tumble_checkpoint_t *checkpoint, const tumble_nv_t *nv)
{
    if (checkpoint == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    *checkpoint = (tumble_checkpoint_t){.outcome = TUMBLE_E_STATE};
    const tumble_status_t status = tumble_nv_writer_open(&checkpoint->writer, nv);
    if (status == TUMBLE_OK) {
        checkpoint->outcome = TUMBLE_OK;
        begin_scan(checkpoint);
    }
    return status;
}

bool tumble_checkpoint_busy(const tumble_checkpoint_t *checkpoint)
{
    return checkpoint->phase != (uint8_t)PHASE_IDLE;
}

static void note_header(tumble_checkpoint_t *checkpoint)
{
    checkpoint->kept = (memcmp(checkpoint->bytes, run_head, sizeof run_head) == 0) &&
                       tumble_record_is_sealed(checkpoint->bytes, AT_CRC, 0);
    checkpoint->fingerprint = tumble_record_get_u32(&checkpoint->bytes[AT_FINGERPRINT]);
}

static void note_entry(tumble_checkpoint_t *checkpoint, bool was_read)
{
    tumble_average_t average;
    if (was_read && tumble_nv_is_blank(checkpoint->bytes, TUMBLE_CHECKPOINT_BYTES)) {
        return;
    }
    checkpoint->next = checkpoint->scanned + 1U;
    if (was_read && (get_entry(checkpoint, &average) == TUMBLE_OK)) {
        checkpoint->place[checkpoint->bytes[AT_INDEX]] = checkpoint->scanned;
    } else if (!checkpoint->booted) {
        count(&checkpoint->torn);
    } else {
        /* an attempt that failed, and was counted as such */
    }
}

static void scan(tumble_checkpoint_t *checkpoint)
{
    const uint32_t offset = offset_of(checkpoint, checkpoint->scanned);
    const tumble_status_t status =
        tumble_nv_read(checkpoint->writer.nv, offset, checkpoint->bytes, TUMBLE_CHECKPOINT_BYTES);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status != TUMBLE_OK) {
        count(&checkpoint->nv_errors);
    }
    if (checkpoint->scanned > 0U) {
        note_entry(checkpoint, status == TUMBLE_OK);
    } else if (status == TUMBLE_OK) {
        note_header(checkpoint);
    } else {
        /* without its header nothing is kept */
    }
    checkpoint->scanned++;
    if (!checkpoint->kept || (checkpoint->scanned == TUMBLE_CHECKPOINT_CELLS)) {
        checkpoint->booted = true;
        checkpoint->phase = PHASE_IDLE;
    }
}

static void begin_erase(tumble_checkpoint_t *checkpoint, uint32_t at, uint8_t phase)
{
    tumble_nv_begin_erase(&checkpoint->writer, offset_of(checkpoint, at), TUMBLE_STORE_MIN_SECTOR);
    checkpoint->phase = phase;
}

static void begin_program(tumble_checkpoint_t *checkpoint, uint32_t at, uint8_t phase)
{
    tumble_nv_begin_program(&checkpoint->writer, offset_of(checkpoint, at), checkpoint->bytes,
                            TUMBLE_CHECKPOINT_BYTES);
    checkpoint->phase = phase;
}

static void begin_header(tumble_checkpoint_t *checkpoint)
{
    uint8_t *bytes = checkpoint->bytes;
    (void)memset(bytes, 0, TUMBLE_CHECKPOINT_BYTES);
    (void)memcpy(bytes, run_head, sizeof run_head);
    tumble_record_put_u32(&bytes[AT_FINGERPRINT], checkpoint->fingerprint);
    tumble_record_seal(bytes, AT_CRC, 0);
    begin_program(checkpoint, 0, PHASE_BEGINNING);
}

/* What has been written is there. The header comes last: before it nothing counts. */
static void go_on(tumble_checkpoint_t *checkpoint)
{
    const uint8_t phase = checkpoint->phase;
    if (phase == (uint8_t)PHASE_ERASING_FIRST) {
        begin_erase(checkpoint, CELLS_PER_SECTOR, PHASE_ERASING_SECOND);
        return;
    }
    if (phase == (uint8_t)PHASE_ERASING_SECOND) {
        begin_header(checkpoint);
        return;
    }
    if (phase == (uint8_t)PHASE_BEGINNING) {
        checkpoint->kept = true;
    }
    if (phase == (uint8_t)PHASE_WRITING) {
        checkpoint->place[checkpoint->bytes[AT_INDEX]] = checkpoint->next;
        checkpoint->next++;
    }
    checkpoint->outcome = TUMBLE_OK;
    checkpoint->phase = PHASE_IDLE;
}

tumble_status_t tumble_checkpoint_step(tumble_checkpoint_t *checkpoint)
{
    if (checkpoint->phase == (uint8_t)PHASE_SCANNING) {
        scan(checkpoint);
    } else if (checkpoint->phase != (uint8_t)PHASE_IDLE) {
        const tumble_status_t status = tumble_nv_writer_step(&checkpoint->writer);
        if (status == TUMBLE_OK) {
            go_on(checkpoint);
        } else if (status == TUMBLE_E_NV) {
            count(checkpoint->writer.failed_to_hold ? &checkpoint->verify : &checkpoint->nv_errors);
            checkpoint->outcome = status;
            begin_scan(checkpoint);
        } else {
            /* it goes on at the next step */
        }
    } else {
        /* nothing is under way */
    }
    return tumble_checkpoint_busy(checkpoint) ? TUMBLE_E_PORT_BUSY : checkpoint->outcome;
}

static tumble_status_t ready(const tumble_checkpoint_t *checkpoint)
{
    if (tumble_checkpoint_busy(checkpoint)) {
        return TUMBLE_E_PORT_BUSY;
    }
    return (checkpoint->writer.nv != NULL) ? TUMBLE_OK : TUMBLE_E_STATE;
}

tumble_status_t tumble_checkpoint_begin(tumble_checkpoint_t *checkpoint, uint32_t fingerprint)
{
    const tumble_status_t status = ready(checkpoint);
    if (status == TUMBLE_OK) {
        forget(checkpoint);
        checkpoint->fingerprint = fingerprint;
        begin_erase(checkpoint, 0, PHASE_ERASING_FIRST);
    }
    return status;
}

tumble_status_t tumble_checkpoint_clear(tumble_checkpoint_t *checkpoint)
{
    const tumble_status_t status = ready(checkpoint);
    if (status == TUMBLE_OK) {
        forget(checkpoint);
        begin_erase(checkpoint, 0, PHASE_CLEARING);
    }
    return status;
}

tumble_status_t tumble_checkpoint_append(tumble_checkpoint_t *checkpoint, uint8_t index,
                                         const tumble_average_t *average)
{
    tumble_status_t status = ready(checkpoint);
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
    begin_program(checkpoint, checkpoint->next, PHASE_WRITING);
    return TUMBLE_OK;
}

bool tumble_checkpoint_matches(const tumble_checkpoint_t *checkpoint, uint32_t fingerprint)
{
    return !tumble_checkpoint_busy(checkpoint) && checkpoint->kept && (checkpoint->fingerprint == fingerprint);
}

bool tumble_checkpoint_has(const tumble_checkpoint_t *checkpoint, uint8_t index)
{
    return !tumble_checkpoint_busy(checkpoint) && (index < TUMBLE_MAX_POSITIONS) && (checkpoint->place[index] != 0U);
}

tumble_status_t tumble_checkpoint_read(tumble_checkpoint_t *checkpoint, uint8_t index, tumble_average_t *average)
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
    const tumble_status_t status = tumble_nv_read(checkpoint->writer.nv, offset_of(checkpoint, checkpoint->place[index]),
                                                  checkpoint->bytes, TUMBLE_CHECKPOINT_BYTES);
    if (status != TUMBLE_OK) {
        return status;
    }
    tumble_average_t read = {0};
    if ((get_entry(checkpoint, &read) != TUMBLE_OK) || (checkpoint->bytes[AT_INDEX] != index)) {
        return TUMBLE_E_CRC;
    }
    *average = read;
    return TUMBLE_OK;
}
