#include "core/crc32.h"

#define POLYNOMIAL 0xEDB88320U /* 0x04C11DB7, lowest bit first */

uint32_t tumble_crc32(uint32_t crc, const void *bytes, size_t size)
{
    const uint8_t *byte = bytes;
    uint32_t state = ~crc;
    for (size_t i = 0; i < size; i++) {
        state ^= byte[i];
        for (int bit = 0; bit < 8; bit++) {
            state = (state >> 1) ^ (((state & 1U) != 0U) ? POLYNOMIAL : 0U);
        }
    }
    return ~state;
}
