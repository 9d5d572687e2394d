#include "port.h"

#include <string.h>

#define SECTOR 4096U
#define GRANULE 8U

static uint8_t bytes_of[8U * SECTOR];

static tumble_status_t erase(void *context, uint32_t offset)
{
    (void)context;
    if (((offset % SECTOR) != 0U) || (offset >= sizeof bytes_of)) {
        return TUMBLE_E_NV;
    }
    memset(&bytes_of[offset], 0xFF, SECTOR);
    return TUMBLE_OK;
}

static tumble_status_t program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    (void)context;
    if ((size == 0U) || (((offset | size) % GRANULE) != 0U) || (offset >= sizeof bytes_of) ||
        (size > (SECTOR - (offset % SECTOR)))) {
        return TUMBLE_E_NV;
    }
    for (uint32_t i = 0; i < size; i++) {
        if (bytes_of[offset + i] != 0xFFU) {
            return TUMBLE_E_NV;
        }
    }
    memcpy(&bytes_of[offset], bytes, size);
    return TUMBLE_OK;
}

static tumble_status_t read(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    (void)context;
    if ((offset > sizeof bytes_of) || (size > (sizeof bytes_of - offset))) {
        return TUMBLE_E_NV;
    }
    memcpy(bytes, &bytes_of[offset], size);
    return TUMBLE_OK;
}

const tumble_nv_t mine_memory = {
    .size_bytes = sizeof bytes_of,
    .sector_bytes = SECTOR,
    .granule_bytes = GRANULE,
    .erase = erase,
    .program = program,
    .read = read,
};
