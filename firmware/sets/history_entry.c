#include "sets/history_entry.h"

#include "core/arith.h"
#include "core/bytes.h"
#include "core/coefficient.h"
#include "sets/record.h"

#include <float.h>
#include <stddef.h>

#define AT_FIELDS 4U
#define AT_CRC 124U

#define FIELD(member, width, count) {(uint16_t)offsetof(tumble_history_entry_t, member), (width), (count)}
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

static const uint8_t magic[AT_FIELDS] = {0x54, 0x48, 0x53, 0x31}; /* THS1 */
static const tumble_field_t fields[] = {
    FIELD(number, 4, 1),
    FIELD(sequence, 4, 1),
    FIELD(origin, 1, 1),
    FIELD(estimator, 1, 1),
    FIELD(flags, 2, 1),
    FIELD(date_utc_s, 8, 1),
    FIELD(temperature_c, 4, 1),
    FIELD(value, 4, TUMBLE_COEFFICIENTS),
    FIELD(u, 4, TUMBLE_COEFFICIENTS),
};

static const tumble_record_t record = {magic, fields, AT_CRC, sizeof magic, COUNT_OF(fields)};

static bool is_finite(const tumble_history_entry_t *entry)
{
    bool finite = tumble_is_finite((double)entry->temperature_c);
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        finite = finite && tumble_is_finite((double)entry->value[c]) && tumble_is_finite((double)entry->u[c]);
    }
    return finite;
}

void tumble_history_number(uint8_t bytes[TUMBLE_HISTORY_BYTES], uint32_t number)
{
    tumble_put_u32(&bytes[AT_FIELDS], number);
    tumble_record_seal(bytes, AT_CRC, 0);
}

tumble_status_t tumble_history_encode(const tumble_history_entry_t *entry, uint8_t bytes[TUMBLE_HISTORY_BYTES])
{
    if ((entry == NULL) || (bytes == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!is_finite(entry)) {
        return TUMBLE_E_NOT_FINITE;
    }
    tumble_record_fill(&record, entry, bytes);
    tumble_record_seal(bytes, AT_CRC, 0);
    return TUMBLE_OK;
}

tumble_status_t tumble_history_decode(const uint8_t bytes[TUMBLE_HISTORY_BYTES], tumble_history_entry_t *entry)
{
    if ((bytes == NULL) || (entry == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = tumble_record_check(&record, bytes, 0);
    if (status != TUMBLE_OK) {
        return status;
    }
    tumble_history_entry_t read = {0};
    tumble_record_read(&record, bytes, &read);
    if (!is_finite(&read)) {
        return TUMBLE_E_NOT_FINITE;
    }
    *entry = read;
    return TUMBLE_OK;
}

/* Coefficients, or their uncertainties; false: one is too large. */
static bool shorten(const void *twelve, float numbers[TUMBLE_COEFFICIENTS])
{
    bool fit = true;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double number = tumble_coefficient(twelve, c);
        fit = fit && tumble_within(number, (double)FLT_MAX);
        numbers[c] = tumble_to_float(number);
    }
    return fit;
}

tumble_status_t tumble_history_from_set(const tumble_set_t *set, tumble_history_entry_t *entry)
{
    if ((set == NULL) || (entry == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_history_entry_t made = {.sequence = set->sequence,
                                   .date_utc_s = set->date_utc_s,
                                   .origin = set->origin,
                                   .estimator = set->estimator,
                                   .flags = set->flags};
    bool fits = shorten(&set->coefficients, made.value);
    if ((set->flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U) {
        fits = shorten(&set->uncertainty, made.u) && fits;
    }
    if (((set->flags & TUMBLE_SET_HAS_TEMPERATURE) != 0U) && tumble_within(set->temperature_c, (double)FLT_MAX)) {
        made.temperature_c = tumble_to_float(set->temperature_c);
    }
    if (!fits) {
        return TUMBLE_E_NOT_FINITE;
    }
    *entry = made;
    return TUMBLE_OK;
}
