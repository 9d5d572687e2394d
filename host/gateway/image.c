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

void gateway_put_u64(uint16_t *at, uint64_t value)
{
    gateway_put_u32(at, (uint32_t)(value >> 32));
    gateway_put_u32(at + 2, (uint32_t)(value & 0xFFFFFFFFU));
}

void gateway_put_f32(uint16_t *at, float value)
{
    uint8_t bytes[4];
    tumble_put_f32(bytes, value);
    gateway_put_u32(at, tumble_get_u32(bytes));
}

static uint16_t word_of(const gateway_value_t *value, const uint8_t *bytes)
{
    if (value->type == TUMBLE_TYPE_INTEGER8) {
        return (uint16_t)tumble_get_i8(bytes);
    }
    return (value->size == 1U) ? bytes[0] : tumble_get_u16(bytes);
}

static double number_of(const gateway_value_t *value, const uint8_t *bytes)
{
    return (value->type == TUMBLE_TYPE_REAL32) ? (double)tumble_get_f32(bytes) : tumble_get_f64(bytes);
}

static bool put_float(uint16_t *at, double number)
{
    if (!(fabs(number) <= (double)FLT_MAX)) {
        return false;
    }
    gateway_put_f32(at, (float)number);
    return true;
}

static bool put_scaled(uint16_t *at, double number, double scale)
{
    const double units = nearbyint(number / scale);
    if (!(units >= (double)INT32_MIN && units <= (double)INT32_MAX)) {
        return false;
    }
    gateway_put_u32(at, (uint32_t)(int32_t)units);
    return true;
}

static void put_text(uint16_t *at, const uint8_t *bytes, uint8_t size)
{
    for (uint8_t i = 0; i < size; i++) {
        at[i / 2U] = (uint16_t)(at[i / 2U] | (unsigned)bytes[i] << ((i % 2U == 0U) ? 8 : 0));
    }
}

static bool put(uint16_t *at, const gateway_value_t *value, const uint8_t *bytes, uint8_t size)
{
    switch ((gateway_form_t)value->form) {
    case GATEWAY_FORM_WORD:
        at[0] = word_of(value, bytes);
        return true;
    case GATEWAY_FORM_LONG:
        gateway_put_u32(at, tumble_get_u32(bytes));
        return true;
    case GATEWAY_FORM_QUAD:
        gateway_put_u64(at, tumble_get_u64(bytes));
        return true;
    case GATEWAY_FORM_FLOAT:
        return put_float(at, number_of(value, bytes));
    case GATEWAY_FORM_SCALED:
        return put_scaled(at, number_of(value, bytes), value->scale);
    case GATEWAY_FORM_TEXT:
        put_text(at, bytes, size);
        return true;
    default:
        return false;
    }
}

bool gateway_image_put(uint16_t *words, const gateway_value_t *value, const uint8_t *bytes, uint8_t size)
{
    const bool fits = (value->form == GATEWAY_FORM_TEXT) ? (size <= value->size) : (size == value->size);
    if (!fits || !put(&words[value->at], value, bytes, size)) {
        return false;
    }
    words[value->validity] = (uint16_t)(words[value->validity] | 1U << value->bit);
    return true;
}
