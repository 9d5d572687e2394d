#include "flash.h"

static uint32_t nv_draw(nv_memory_t *memory)
{
    memory->random = memory->random * 1664525U + 1013904223U;
    return memory->random >> 8;
}

static uint8_t nv_mix(nv_memory_t *memory, done_t done, uint32_t i, uint32_t size, uint8_t old, uint8_t new)
{
    const uint8_t bits = (uint8_t)nv_draw(memory);
    switch (done) {
    case DONE_NOTHING:
        return old;
    case DONE_QUARTER:
        return (i < size / 4U) ? new : old;
    case DONE_HALF:
        return (i < size / 2U) ? new : old;
    case DONE_BUT_LAST:
        return (i + 1U < size) ? new : old;
    case DONE_SECOND_HALF:
        return (i >= size / 2U) ? new : old;
    case DONE_SOME_BITS:
        return (uint8_t)(old ^ ((old ^ new) & bits));
    case DONE_SOME_BYTES:
        return ((bits & 1U) != 0U) ? new : old;
    case DONE_ANY_VALUES:
        return bits;
    default:
        return new;
    }
}

/* The caller must do right. Returns whether he did. */
static bool nv_allows(nv_memory_t *memory, bool right)
{
    memory->violations += right ? 0U : 1U;
    if (!right && memory->on_violation != NULL) {
        memory->on_violation();
    }
    return right;
}

/* Put a call off, and see that the same call comes again. */
static bool nv_is_busy(nv_memory_t *memory, uint32_t offset)
{
    memory->calls++;
    if (memory->busy_each == 0U) {
        return memory->busy_every != 0U && memory->calls % memory->busy_every == 0U;
    }
    if (memory->busy_left == 0U) {
        memory->busy_left = memory->busy_each + 1U;
        memory->busy_offset = offset;
    }
    (void)nv_allows(memory, memory->busy_offset == offset);
    memory->busy_left--;
    return memory->busy_left > 0U;
}

static void nv_fill(uint8_t *to, const uint8_t *bytes, uint32_t size)
{
    if (bytes == NULL) {
        memset(to, 0xFF, size);
    } else {
        memcpy(to, bytes, size);
    }
}

static tumble_status_t nv_change(nv_memory_t *memory, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    const uint32_t at = memory->fault.at;
    const bool hit = memory->operations >= at && memory->operations - at <= memory->more;
    memory->operations++;
    if (!hit) {
        nv_fill(&memory->bytes[offset], bytes, size);
        return TUMBLE_OK;
    }
    for (uint32_t i = 0; i < size; i++) {
        uint8_t *byte = &memory->bytes[offset + i];
        *byte = nv_mix(memory, memory->fault.done, i, size, *byte, (bytes == NULL) ? 0xFF : bytes[i]);
    }
    memory->is_off = memory->fault.then == THEN_CUT;
    return (memory->fault.then != THEN_SILENT) ? TUMBLE_E_NV : TUMBLE_OK;
}

static tumble_status_t nv_erase(void *context, uint32_t offset)
{
    nv_memory_t *memory = context;
    const bool right = offset % memory->nv.sector_bytes == 0U && offset < memory->nv.size_bytes;
    if (!nv_allows(memory, right && offset != 0U) || memory->is_off) { /* the factory set is never erased */
        return TUMBLE_E_NV;
    }
    return nv_is_busy(memory, offset) ? TUMBLE_E_PORT_BUSY : nv_change(memory, offset, NULL, memory->nv.sector_bytes);
}

bool nv_all_blank(const uint8_t *bytes, uint32_t size)
{
    uint8_t all = 0xFF;
    for (uint32_t i = 0; i < size; i++) {
        all &= bytes[i];
    }
    return all == 0xFFU;
}

tumble_status_t nv_program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    nv_memory_t *memory = context;
    const tumble_nv_t *nv = &memory->nv;
    if (memory->is_off) {
        return TUMBLE_E_NV;
    }
    const bool right = size > 0U && offset % nv->granule_bytes == 0U && size % nv->granule_bytes == 0U &&
                       offset + size <= nv->size_bytes &&
                       offset / nv->sector_bytes == (offset + size - 1U) / nv->sector_bytes;
    if (!nv_allows(memory, right && nv_all_blank(&memory->bytes[offset], size))) {
        return TUMBLE_E_NV;
    }
    return nv_is_busy(memory, offset) ? TUMBLE_E_PORT_BUSY : nv_change(memory, offset, bytes, size);
}

tumble_status_t nv_read(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    nv_memory_t *memory = context;
    const bool right = offset + size <= memory->nv.size_bytes;
    if (!nv_allows(memory, right) || memory->is_off) {
        return TUMBLE_E_NV;
    }
    if (nv_is_busy(memory, offset)) {
        return TUMBLE_E_PORT_BUSY;
    }
    const uint32_t read = memory->reads++;
    const bool fails = read >= memory->read_fails_at && read - memory->read_fails_at < memory->read_fails;
    memcpy(bytes, &memory->bytes[offset], size);
    return fails ? TUMBLE_E_NV : TUMBLE_OK;
}

void nv_arm(nv_memory_t *memory, nv_fault_t fault)
{
    memory->fault = fault;
    memory->more = 0;
    memory->operations = 0;
    memory->is_off = false;
    memory->busy_left = 0;
}

const nv_fault_t nv_no_fault = {NV_NEVER, DONE_ALL, THEN_SILENT};

void nv_refuse(nv_memory_t *memory, uint32_t times)
{
    nv_arm(memory, (nv_fault_t){0, DONE_NOTHING, THEN_ERROR});
    memory->more = times - 1U;
}

void nv_make(nv_memory_t *memory, uint32_t sectors, uint32_t granule, uint32_t sector)
{
    memset(memory, 0, sizeof *memory);
    memset(memory->bytes, 0xFF, sizeof memory->bytes);
    memory->nv = (tumble_nv_t){memory, sectors * sector, sector, granule, nv_erase, nv_program, nv_read};
    memory->random = 1;
    memory->read_fails_at = NV_NEVER;
    memory->read_fails = NV_NEVER;
    nv_arm(memory, nv_no_fault);
}
