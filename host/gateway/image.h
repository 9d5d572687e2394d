/* image.h - numbers in Modbus registers: big-endian, the high word first, packed by shifts. */
#ifndef TUMBLE_GATEWAY_IMAGE_H
#define TUMBLE_GATEWAY_IMAGE_H

#include "registers.h"

#include <stdbool.h>
#include <stdint.h>

void gateway_put_u32(uint16_t *at, uint32_t value);
void gateway_put_u64(uint16_t *at, uint64_t value);
void gateway_put_f32(uint16_t *at, float value);

/* Put the value of an object, `size` little-endian bytes as SDO brings them, into its registers of `words`
 * (GATEWAY_INPUT_END of them, all 0 before) and set its bit of validity. False: the bytes are not as many as the object
 * has, or the number is not finite or beyond what its registers can say; nothing is changed then. */
bool gateway_image_put(uint16_t *words, const gateway_value_t *value, const uint8_t *bytes, uint8_t size);

#endif
