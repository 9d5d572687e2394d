#include "nv_memory.h"

#include "nv/nv_rules.h"

#include <stdbool.h>
#include <string.h>

static tumble_nv_t over(uint8_t *memory);

static tumble_status_t erase(void *context, uint32_t offset)
{
    uint8_t *memory = context;
    const tumble_nv_t nv = over(memory);
    if (!nv_is_sector(&nv, offset)) {
        return TUMBLE_E_NV;
    }
    (void)memset(&memory[offset], (int)NV_ERASED, ZCU102_NV_SECTOR);
    return TUMBLE_OK;
}

static tumble_status_t program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    uint8_t *memory = context;
    const tumble_nv_t nv = over(memory);
    if (!nv_are_granules(&nv, offset, size) || !nv_is_blank(&memory[offset], size)) {
        return TUMBLE_E_NV;
    }
    (void)memcpy(&memory[offset], bytes, size);
    return TUMBLE_OK;
}

static tumble_status_t read(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    const uint8_t *memory = context;
    const tumble_nv_t nv = over(context);
    if (!nv_are_there(&nv, offset, size)) {
        return TUMBLE_E_NV;
    }
    (void)memcpy(bytes, &memory[offset], size);
    return TUMBLE_OK;
}

static tumble_nv_t over(uint8_t *memory)
{
    return (tumble_nv_t){.context = memory,
                         .size_bytes = ZCU102_NV_BYTES,
                         .sector_bytes = ZCU102_NV_SECTOR,
                         .granule_bytes = ZCU102_NV_GRANULE,
                         .erase = erase,
                         .program = program,
                         .read = read};
}

tumble_nv_t zcu102_nv_memory(uint8_t *memory)
{
    bool untouched = true;
    for (uint32_t i = 0; untouched && (i < ZCU102_NV_BYTES); i++) {
        untouched = memory[i] == 0U;
    }
    if (untouched) {
        (void)memset(memory, (int)NV_ERASED, ZCU102_NV_BYTES);
    }
    return over(memory);
}
