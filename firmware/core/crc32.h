/* crc32.h - CRC-32 of IEEE 802.3 (polynomial 0x04C11DB7, reflected, start and final exclusive or 0xFFFFFFFF): Hamming
 * distance 5 or more up to 256 bytes, and one altered bit, byte or word is never missed at any length.
 */
#ifndef TUMBLE_CORE_CRC32_H
#define TUMBLE_CORE_CRC32_H

#include <stddef.h>
#include <stdint.h>

/* The CRC of `size` more bytes: `crc` is that of the bytes before them, 0 at the beginning. The CRC of "123456789" is
 * 0xCBF43926. Bitwise: small rather than fast. */
uint32_t tumble_crc32(uint32_t crc, const void *bytes, size_t size);

#endif
