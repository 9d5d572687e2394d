#include "sets/slots.h"

#include "core/count.h"
#include "sets/nv_writer.h"

#include <stddef.h>

#define READ_ATTEMPTS 3U /* before a place counts as lost */

/* One or two failures in a row count as "busy". Otherwise a memory that fails now and then would lose what it holds. */
tumble_status_t tumble_slots_read(tumble_slots_t *slots, uint32_t offset, uint8_t *bytes, uint32_t *errors)
{
    const tumble_status_t status = tumble_nv_read(slots->writer.nv, offset, bytes, slots->kind->bytes);
    if (status == TUMBLE_E_PORT_BUSY) {
        return status;
    }
    if (status == TUMBLE_E_NV) {
        tumble_count(errors);
        slots->failed_reads++;
        if (slots->failed_reads < READ_ATTEMPTS) {
            return TUMBLE_E_PORT_BUSY;
        }
    }
    slots->failed_reads = 0;
    return status;
}

void tumble_slots_begin(tumble_slots_t *slots, const uint8_t *plan)
{
    slots->plan = plan;
    slots->begun = false;
}

static void begin_writing(tumble_slots_t *slots, uint32_t offset, const uint8_t *bytes)
{
    const uint32_t record = slots->kind->record_bytes;
    switch (*slots->plan & 0xF0U) {
    case SLOT_ERASE:
        tumble_nv_begin_erase(&slots->writer, offset, slots->kind->bytes);
        break;
    case SLOT_BODY:
        tumble_nv_begin_program(&slots->writer, offset, bytes, record);
        break;
    case SLOT_MARK:
        tumble_nv_begin_program(&slots->writer, offset + record, &bytes[record], slots->kind->bytes - record);
        break;
    default:
        tumble_nv_begin_blank(&slots->writer, offset, slots->kind->bytes);
        break;
    }
    slots->begun = true;
}

tumble_status_t tumble_slots_pass(tumble_slots_t *slots)
{
    tumble_slots_begin(slots, &slots->plan[1]);
    return (*slots->plan == SLOT_END) ? TUMBLE_OK : TUMBLE_E_PORT_BUSY;
}

tumble_status_t tumble_slots_step(tumble_slots_t *slots, uint32_t offset, const uint8_t *bytes)
{
    if (!slots->begun) {
        begin_writing(slots, offset, bytes);
    }
    const tumble_status_t status = tumble_nv_writer_step(&slots->writer);
    return (status == TUMBLE_OK) ? tumble_slots_pass(slots) : status;
}
