#include "registers.h"

#include "canopen/dictionary.h"
#include "core/bytes.h"

#include <float.h>
#include <math.h>

void gateway_put_u32(uint16_t *at, uint32_t value)
{
    at[0] = (uint16_t)(value >> 16);
    at[1] = (uint16_t)(value & 0xFFFFU);
}

void gateway_put_f32(uint16_t *at, float value)
{
    uint8_t bytes[4];
    tumble_put_f32(bytes, value);
    gateway_put_u32(at, tumble_get_u32(bytes));
}

gateway_value_t gateway_value(size_t place)
{
    const gateway_value_run_t *run = gateway_value_runs;
    size_t ahead = place;
    while (ahead >= run->count) {
        ahead -= run->count;
        run++;
    }
    gateway_value_t value = run->first;
    value.at = (uint16_t)(value.at + ahead * gateway_words_of(&value));
    value.bit = (uint8_t)(value.bit + ahead);
    value.subindex = (uint8_t)(value.subindex + ahead);
    value.scaled_at = (uint16_t)((value.scaled_at > 0U) ? value.scaled_at + 2U * ahead : 0U);
    return value;
}

uint8_t gateway_words_of(const gateway_value_t *value)
{
    return (uint8_t)((value->type == TUMBLE_TYPE_REAL64) ? 2U : (value->size + 1U) / 2U);
}

static void put_real(uint16_t *words, const gateway_value_t *value, double number)
{
    const uint16_t valid = (uint16_t)(1U << value->bit);
    if (fabs(number) <= (double)FLT_MAX) {
        gateway_put_f32(&words[value->at], (float)number);
        words[value->validity] |= valid;
    }
    const double units = (value->scaled_at > 0U) ? nearbyint(number / value->scale) : (double)NAN;
    if (units >= (double)INT32_MIN && units <= (double)INT32_MAX) {
        gateway_put_u32(&words[value->scaled_at], (uint32_t)(int32_t)units);
        words[value->scaled_validity] |= valid;
    }
}

/* What is no number of floating point. */
static void put_words(uint16_t *at, const gateway_value_t *value, const uint8_t *bytes, uint8_t size)
{
    if (value->type == TUMBLE_TYPE_VISIBLE_STRING) {
        for (uint8_t i = 0; i < size; i++) {
            at[i / 2U] = (uint16_t)(at[i / 2U] | (unsigned)bytes[i] << ((i % 2U == 0U) ? 8 : 0));
        }
    } else if (size == 1U) {
        *at = (value->type == TUMBLE_TYPE_INTEGER8) ? (uint16_t)tumble_get_i8(bytes) : bytes[0];
    } else {
        for (uint8_t word = 0; word < size / 2U; word++) {
            at[size / 2U - 1U - word] = tumble_get_u16(&bytes[2U * word]);
        }
    }
}

void gateway_image_put(uint16_t *words, const gateway_value_t *value, const uint8_t *bytes, uint8_t size)
{
    if ((value->type == TUMBLE_TYPE_VISIBLE_STRING) ? size > value->size : size != value->size) {
        return;
    }
    if (value->type == TUMBLE_TYPE_REAL64) {
        put_real(words, value, tumble_get_f64(bytes));
    } else if (value->type == TUMBLE_TYPE_REAL32) {
        put_real(words, value, (double)tumble_get_f32(bytes));
    } else {
        put_words(&words[value->at], value, bytes, size);
        words[value->validity] |= (uint16_t)(1U << value->bit);
    }
}
