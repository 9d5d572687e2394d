#include "core/arith.h"
#include "core/bytes.h"
#include "core/one_copy.h"
#include "sets/record.h"

#include <stddef.h>

/* Places in the bytes; docs/embedding.md has them all. */
#define AT_SEQUENCE 8U
#define AT_ORIGIN 12U
#define AT_SERIAL 16U
#define AT_TEMPERATURE 48U
#define AT_GRAVITY 56U
#define AT_CHECK 256U
#define AT_CLOSURE 280U
#define AT_RESTORES 308U
#define AT_FROM_CRC 312U

#define FIELD(member, width, count) {(uint16_t)offsetof(tumble_set_t, member), (width), (count)}
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* "TSET", schema, size */
static const uint8_t head[TUMBLE_SET_AT_FIELDS] = {
    0x54, 0x53, 0x45, 0x54, TUMBLE_SET_SCHEMA, 0, TUMBLE_SET_BYTES & 0xFFU, TUMBLE_SET_BYTES >> 8};

static const tumble_field_t fields[] = {
    FIELD(sequence, 4, 1),
    FIELD(origin, 1, 1),
    FIELD(estimator, 1, 1),
    FIELD(flags, 2, 1),
    FIELD(block_serial, 1, 24),
    FIELD(date_utc_s, 8, 1),
    FIELD(temperature_c, 8, 1),
    FIELD(gravity_m_s2, 8, 1),
    FIELD(coefficients.k_v_per_g, 8, 9),
    FIELD(coefficients.u0_v, 8, 3),
    FIELD(uncertainty.k_v_per_g, 8, 9),
    FIELD(uncertainty.u0_v, 8, 3),
    FIELD(max_abs_fit_g, 8, 1),
    FIELD(max_abs_check_g, 8, 1),
    FIELD(limit_g, 8, 1),
    FIELD(closure_v, 8, 1),
    FIELD(samples, 4, 1),
    FIELD(fit_positions, 1, 1),
    FIELD(check_positions, 1, 1),
    FIELD(temperature_min_half_c, 1, 1),
    FIELD(temperature_max_half_c, 1, 1),
    FIELD(schedule_crc, 4, 1),
    FIELD(stand_crc, 4, 1),
    FIELD(reasons, 4, 1),
    FIELD(restores, 4, 1),
    FIELD(from_crc, 4, 1),
};
static const tumble_record_t record = {head, fields, TUMBLE_SET_AT_CRC, sizeof head, COUNT_OF(fields)};

/* What is known by which flag, and what the doubles in it must be. */
typedef enum { ANY_SIGN, NOT_NEGATIVE, POSITIVE } range_t;
typedef struct {
    uint16_t flag;   /* 0: always known */
    uint16_t offset; /* of the first in tumble_set_t, where they lie one behind the other as in the bytes */
    uint16_t at;
    uint8_t bytes; /* fewer than a double has: there is none */
    range_t range;
} numbers_t;

#define DOUBLES(count) ((count) * sizeof(double))
#define MEMBER(member) ((uint16_t)offsetof(tumble_set_t, member))

static_assert((sizeof(tumble_coefficients_t) == DOUBLES(12U)) && (sizeof(tumble_uncertainty_t) == DOUBLES(12U)) &&
                  ((MEMBER(max_abs_fit_g) + DOUBLES(1U)) == MEMBER(max_abs_check_g)) &&
                  ((MEMBER(max_abs_check_g) + DOUBLES(1U)) == MEMBER(limit_g)) &&
                  ((MEMBER(temperature_min_half_c) + 1U) == MEMBER(temperature_max_half_c)),
              "what is known together lies together");

static const numbers_t numbers[] = {
    {0, MEMBER(coefficients), TUMBLE_SET_AT_K, DOUBLES(12U), ANY_SIGN},
    {TUMBLE_SET_HAS_UNCERTAINTY, MEMBER(uncertainty), TUMBLE_SET_AT_U, DOUBLES(12U), NOT_NEGATIVE},
    {TUMBLE_SET_HAS_TEMPERATURE, MEMBER(temperature_c), AT_TEMPERATURE, DOUBLES(1U), ANY_SIGN},
    {TUMBLE_SET_HAS_GRAVITY, MEMBER(gravity_m_s2), AT_GRAVITY, DOUBLES(1U), POSITIVE},
    {TUMBLE_SET_HAS_CHECK, MEMBER(max_abs_fit_g), AT_CHECK, DOUBLES(3U), NOT_NEGATIVE},
    {TUMBLE_SET_HAS_CLOSURE, MEMBER(closure_v), AT_CLOSURE, DOUBLES(1U), NOT_NEGATIVE},
    {TUMBLE_SET_HAS_TEMPERATURE_RANGE, MEMBER(temperature_min_half_c), TUMBLE_SET_AT_RANGE, 2, ANY_SIGN},
};

static bool is_known(const numbers_t *row, uint32_t flags)
{
    return (row->flag == 0U) || ((flags & row->flag) != 0U);
}

bool tumble_set_knows(const tumble_set_t *set, uint16_t offset)
{
    bool known = true;
    for (uint32_t i = 0; i < COUNT_OF(numbers); i++) {
        const numbers_t *row = &numbers[i];
        if ((offset >= row->offset) && (offset < (row->offset + (uint32_t)row->bytes))) {
            known = is_known(row, set->flags);
        }
    }
    return known;
}

static bool are_zero(const uint8_t *bytes, uint32_t size)
{
    uint32_t any = 0;
    for (uint32_t i = 0; i < size; i++) {
        any |= bytes[i];
    }
    return any == 0U;
}

static tumble_status_t check_number(const uint8_t *bytes, range_t range)
{
    const double x = tumble_get_f64(bytes);
    if (!tumble_is_finite(x)) {
        return TUMBLE_E_NOT_FINITE;
    }
    const bool too_low =
        (range == POSITIVE) ? !tumble_is_positive(x) : ((range == NOT_NEGATIVE) && tumble_is_positive(-x));
    return too_low ? TUMBLE_E_ARGUMENT : TUMBLE_OK;
}

static tumble_status_t check_numbers(const uint8_t *bytes, uint32_t flags)
{
    tumble_status_t status = TUMBLE_OK;
    for (uint32_t i = 0; i < COUNT_OF(numbers); i++) {
        const numbers_t *row = &numbers[i];
        const uint32_t count = is_known(row, flags) ? (row->bytes / (uint32_t)sizeof(double)) : 0U;
        for (uint32_t n = 0; (n < count) && (status == TUMBLE_OK); n++) {
            status = check_number(&bytes[row->at + (n * sizeof(double))], row->range);
        }
    }
    return status;
}

/* What is unknown is 0. */
static bool the_rest_is_zero(const uint8_t *bytes, uint32_t flags)
{
    bool zero = true;
    for (uint32_t i = 0; i < COUNT_OF(numbers); i++) {
        zero = zero && (is_known(&numbers[i], flags) || are_zero(&bytes[numbers[i].at], numbers[i].bytes));
    }
    return zero;
}

static bool serial_ends_in_zeros(const uint8_t *serial)
{
    uint32_t length = 0;
    while ((length < TUMBLE_SET_SERIAL_BYTES) && (serial[length] != 0U)) {
        length++;
    }
    return are_zero(&serial[length], TUMBLE_SET_SERIAL_BYTES - length);
}

static uint32_t flags_in(const uint8_t *bytes)
{
    return tumble_get_u32(&bytes[AT_ORIGIN]) >> 16; /* origin, estimator, then the flags */
}

static tumble_status_t check_fields(const uint8_t *bytes)
{
    const uint32_t flags = flags_in(bytes);
    const uint8_t origin = bytes[AT_ORIGIN];
    if (((flags & ~TUMBLE_SET_FLAGS) != 0U) || (origin < (uint8_t)TUMBLE_ORIGIN_FACTORY) ||
        (origin > (uint8_t)TUMBLE_ORIGIN_HELD) || !serial_ends_in_zeros(&bytes[AT_SERIAL])) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!the_rest_is_zero(bytes, flags)) {
        return TUMBLE_E_FRAME;
    }
    const bool in_order = tumble_get_i8(&bytes[TUMBLE_SET_AT_RANGE]) <= tumble_get_i8(&bytes[TUMBLE_SET_AT_RANGE + 1U]);
    return in_order ? check_numbers(bytes, flags) : TUMBLE_E_ARGUMENT;
}

tumble_status_t tumble_set_read_fields(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set)
{
    const tumble_status_t status = check_fields(bytes);
    if ((status == TUMBLE_OK) && (set != NULL)) {
        *set = (tumble_set_t){0};
        tumble_record_read(&record, bytes, set);
        set->record_crc = tumble_set_crc(bytes);
    }
    return status;
}

tumble_status_t tumble_set_read(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set)
{
    const tumble_status_t status = tumble_record_check(&record, bytes, 0);
    return (status == TUMBLE_OK) ? tumble_set_read_fields(bytes, set) : status;
}

TUMBLE_ONE_COPY void tumble_set_stamp(uint8_t bytes[TUMBLE_SET_BYTES], const tumble_set_stamp_t *stamp)
{
    tumble_put_u32(&bytes[AT_SEQUENCE], stamp->sequence);
    bytes[AT_ORIGIN] = stamp->origin;
    tumble_put_u32(&bytes[AT_RESTORES], stamp->restores);
    tumble_put_u32(&bytes[AT_FROM_CRC], stamp->from_crc);
    tumble_record_seal(bytes, TUMBLE_SET_AT_CRC, 0);
}

void tumble_set_get_stamp(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_stamp_t *stamp)
{
    stamp->sequence = tumble_get_u32(&bytes[AT_SEQUENCE]);
    stamp->restores = tumble_get_u32(&bytes[AT_RESTORES]);
    stamp->from_crc = tumble_get_u32(&bytes[AT_FROM_CRC]);
    stamp->origin = bytes[AT_ORIGIN];
}

void tumble_set_add_flags(uint8_t bytes[TUMBLE_SET_BYTES], uint16_t flags)
{
    const uint32_t word = tumble_get_u32(&bytes[AT_ORIGIN]);
    tumble_put_u32(&bytes[AT_ORIGIN], word | ((uint32_t)flags << 16));
}

uint32_t tumble_set_crc(const uint8_t bytes[TUMBLE_SET_BYTES])
{
    return tumble_get_u32(&bytes[TUMBLE_SET_AT_CRC]);
}

static void put_fields(const tumble_set_t *set, uint8_t *bytes)
{
    tumble_record_fill(&record, set, bytes);
    for (uint32_t i = 0; i < COUNT_OF(numbers); i++) {
        if (!is_known(&numbers[i], set->flags)) {
            (void)memset(&bytes[numbers[i].at], 0, numbers[i].bytes);
        }
    }
}

tumble_status_t tumble_set_encode_as(const tumble_set_t *set, const tumble_set_stamp_t *stamp,
                                     uint8_t bytes[TUMBLE_SET_BYTES])
{
    if (set == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    put_fields(set, bytes);
    tumble_set_stamp(bytes, stamp);
    return check_fields(bytes);
}

tumble_status_t tumble_set_encode(const tumble_set_t *set, uint8_t bytes[TUMBLE_SET_BYTES])
{
    if ((set == NULL) || (bytes == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_set_stamp_t stamp = {set->sequence, set->restores, set->from_crc, set->origin};
    return tumble_set_encode_as(set, &stamp, bytes);
}

tumble_status_t tumble_set_decode(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set)
{
    return ((bytes == NULL) || (set == NULL)) ? TUMBLE_E_ARGUMENT : tumble_set_read(bytes, set);
}
