/* Sets over temperature: the record of version 2, and how the store writes and reads it. In its bytes it is one of version 1
 * but for twelve doubles and their uncertainties, in whose place there are 48 floats. So it is read by making one of version
 * 1 of it, and written the other way round.
 */
#include "core/arith.h"
#include "core/bytes.h"
#include "core/coefficient.h"
#include "sets/record.h"

#include <string.h>

#define NUMBERS (TUMBLE_COEFFICIENTS * TUMBLE_THERMAL_POWERS) /* of the polynomials; behind them the uncertainties */
#define HALF_DEGREES 2.0
#define LOWEST_HALF_C (-128) /* that a sample can tell */
#define STEPS 255            /* from there to the highest */
#define LOWEST_C ((double)LOWEST_HALF_C / HALF_DEGREES)
#define HIGHEST_C ((double)(LOWEST_HALF_C + STEPS) / HALF_DEGREES)
#define ALWAYS (TUMBLE_SET_HAS_SLOPES | TUMBLE_SET_HAS_TEMPERATURE_RANGE)
#define DIFFERENCE (TUMBLE_SET_HAS_SLOPES | TUMBLE_SET_HAS_TEMPERATURE) /* T0 is the temperature of no run */

static const uint8_t head[TUMBLE_SET_AT_FIELDS] = {
    0x54, 0x53, 0x45, 0x54, TUMBLE_SET_SCHEMA_THERMAL, 0, TUMBLE_SET_BYTES & 0xFFU, TUMBLE_SET_BYTES >> 8};

static_assert((TUMBLE_SET_AT_K + (sizeof(float) * (NUMBERS + TUMBLE_COEFFICIENTS))) ==
                  (TUMBLE_SET_AT_U + (sizeof(double) * TUMBLE_COEFFICIENTS)),
              "the floats fill the place of the doubles");

/* Number n of the polynomials, or one of the uncertainties behind them. */
static double number_in(const uint8_t *bytes, int n)
{
    return (double)tumble_get_f32(&bytes[TUMBLE_SET_AT_K + ((uint32_t)n * sizeof(float))]);
}

static double number_of(const tumble_thermal_t *thermal, int n)
{
    return tumble_coefficient(&thermal->power[n / TUMBLE_COEFFICIENTS], n % TUMBLE_COEFFICIENTS);
}

/* Reading. */

static bool has_slopes(const uint8_t *bytes)
{
    return memcmp(bytes, head, sizeof head) == 0;
}

static void to_version_1(const uint8_t *bytes, uint32_t flags, uint8_t *plain)
{
    (void)memcpy(plain, bytes, TUMBLE_SET_BYTES);
    plain[sizeof(uint32_t)] = TUMBLE_SET_SCHEMA;
    tumble_put_u16(&plain[TUMBLE_SET_AT_FLAGS], (uint16_t)(flags ^ DIFFERENCE));
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const uint32_t at = (uint32_t)c * sizeof(double);
        tumble_put_f64(&plain[TUMBLE_SET_AT_K + at], number_in(bytes, c));
        tumble_put_f64(&plain[TUMBLE_SET_AT_U + at], number_in(bytes, NUMBERS + c));
    }
}

static tumble_status_t check_slopes(const uint8_t *bytes)
{
    bool finite = true;
    for (int n = TUMBLE_COEFFICIENTS; n < NUMBERS; n++) {
        finite = finite && tumble_is_finite(number_in(bytes, n));
    }
    return finite ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
}

tumble_status_t tumble_thermal_read_set(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set)
{
    if (!has_slopes(bytes)) {
        return tumble_set_read(bytes, set);
    }
    if (!tumble_record_is_sealed(bytes, TUMBLE_SET_AT_CRC, 0)) {
        return TUMBLE_E_CRC;
    }
    const uint32_t flags = tumble_get_u16(&bytes[TUMBLE_SET_AT_FLAGS]);
    const bool in_order = (flags & (ALWAYS | TUMBLE_SET_HAS_TEMPERATURE)) == ALWAYS;
    tumble_status_t status = in_order ? check_slopes(bytes) : TUMBLE_E_ARGUMENT;
    if (status == TUMBLE_OK) {
        uint8_t plain[TUMBLE_SET_BYTES];
        to_version_1(bytes, flags, plain);
        status = tumble_set_read_fields(plain, set);
    }
    if ((status == TUMBLE_OK) && (set != NULL)) {
        set->flags = (uint16_t)flags;
    }
    return status;
}

void tumble_thermal_from_record(const uint8_t bytes[TUMBLE_SET_BYTES], const tumble_set_t *set,
                                tumble_thermal_t *thermal)
{
    *thermal = (tumble_thermal_t){
        .reference_c = set->temperature_c,
        .lowest_c = LOWEST_C,
        .highest_c = HIGHEST_C,
        .power = {set->coefficients},
    };
    if (has_slopes(bytes)) {
        thermal->lowest_c = (double)set->temperature_min_half_c / HALF_DEGREES;
        thermal->highest_c = (double)set->temperature_max_half_c / HALF_DEGREES;
        for (int m = 1; m < TUMBLE_THERMAL_POWERS; m++) {
            for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
                tumble_put_coefficient(&thermal->power[m], c, number_in(bytes, (m * TUMBLE_COEFFICIENTS) + c));
            }
        }
    }
}

tumble_status_t tumble_set_decode_thermal(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set,
                                          tumble_thermal_t *thermal)
{
    if ((bytes == NULL) || (set == NULL) || (thermal == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = tumble_thermal_read_set(bytes, set);
    if (status == TUMBLE_OK) {
        tumble_thermal_from_record(bytes, set, thermal);
    }
    return status;
}

/* Writing. */

/* Half degrees to there from an end of what a sample can tell, rounded down; 0 to STEPS. */
static int steps_of(double kelvin)
{
    const double steps = kelvin * HALF_DEGREES;
    return tumble_exceeds(steps, (double)STEPS) ? STEPS : (int)tumble_whole(steps);
}

/* The set as version 1 has it. */
static tumble_status_t plain_set(const tumble_set_t *set, const tumble_thermal_t *thermal, tumble_set_t *plain)
{
    bool finite = tumble_is_finite(thermal->reference_c + thermal->lowest_c + thermal->highest_c);
    for (int n = 0; n < NUMBERS; n++) {
        finite = finite && tumble_is_finite((double)tumble_to_float(number_of(thermal, n)));
    }
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const bool known = (set->flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U;
        finite =
            finite && (!known || tumble_is_finite((double)tumble_to_float(tumble_coefficient(&set->uncertainty, c))));
    }
    if (!finite) {
        return TUMBLE_E_NOT_FINITE;
    }
    const int from_lowest = steps_of(thermal->highest_c - LOWEST_C);
    const int from_highest = steps_of(HIGHEST_C - thermal->lowest_c);
    const bool is_range =
        !tumble_exceeds(LOWEST_C, thermal->highest_c) && !tumble_exceeds(thermal->lowest_c, HIGHEST_C);
    *plain = *set;
    plain->coefficients = thermal->power[0];
    plain->temperature_c = thermal->reference_c;
    plain->temperature_min_half_c = (int8_t)((LOWEST_HALF_C + STEPS) - from_highest);
    plain->temperature_max_half_c = (int8_t)(LOWEST_HALF_C + from_lowest);
    plain->flags = (uint16_t)((set->flags | ALWAYS | DIFFERENCE) ^ TUMBLE_SET_HAS_SLOPES);
    return is_range ? TUMBLE_OK : TUMBLE_E_ARGUMENT;
}

/* All but stamp and seal. */
static void to_version_2(const tumble_set_t *plain, const tumble_thermal_t *thermal, uint8_t *bytes)
{
    const bool known = (plain->flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U;
    (void)memcpy(bytes, head, sizeof head);
    tumble_put_u16(&bytes[TUMBLE_SET_AT_FLAGS], (uint16_t)(plain->flags ^ DIFFERENCE));
    for (int n = 0; n < (NUMBERS + TUMBLE_COEFFICIENTS); n++) {
        double number = 0.0;
        if (n < NUMBERS) {
            number = number_of(thermal, n);
        } else if (known) {
            number = tumble_coefficient(&plain->uncertainty, n - NUMBERS);
        } else {
            /* 0 */
        }
        tumble_put_f32(&bytes[TUMBLE_SET_AT_K + ((uint32_t)n * sizeof(float))], tumble_to_float(number));
    }
}

tumble_status_t tumble_set_encode_thermal(const tumble_set_t *set, const tumble_thermal_t *thermal,
                                          uint8_t bytes[TUMBLE_SET_BYTES])
{
    if ((set == NULL) || (thermal == NULL) || (bytes == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_set_t plain;
    tumble_status_t status = plain_set(set, thermal, &plain);
    if (status == TUMBLE_OK) {
        status = tumble_set_encode(&plain, bytes);
        to_version_2(&plain, thermal, bytes);
        tumble_record_seal(bytes, TUMBLE_SET_AT_CRC, 0);
    }
    return status;
}

/* The store. */

tumble_status_t tumble_store_init_thermal(tumble_store_t *store, const tumble_nv_t *nv)
{
    const tumble_status_t status = tumble_store_init(store, nv);
    if (store != NULL) {
        store->read_set = tumble_thermal_read_set;
    }
    return status;
}

tumble_status_t tumble_store_read_thermal(tumble_store_t *store, tumble_which_set_t which, tumble_set_t *set,
                                          tumble_thermal_t *thermal)
{
    if (thermal == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = tumble_store_read(store, which, set);
    if (status == TUMBLE_OK) {
        tumble_thermal_from_record(store->bytes, set, thermal);
    }
    return status;
}

static tumble_status_t begin(tumble_store_t *store, tumble_which_set_t which, const tumble_set_t *plain)
{
    switch (which) {
    case TUMBLE_SET_ACTIVE:
        return tumble_store_commit(store, plain);
    case TUMBLE_SET_PROPOSAL:
        return tumble_store_hold(store, plain);
    case TUMBLE_SET_FACTORY:
        return tumble_store_write_factory(store, plain);
    default:
        return TUMBLE_E_ARGUMENT;
    }
}

/* A job that has begun has written nothing yet: its record waits in the store. */
tumble_status_t tumble_thermal_put(tumble_store_t *store, const tumble_set_t *set, const tumble_thermal_t *thermal)
{
    tumble_set_t plain;
    tumble_status_t status = plain_set(set, thermal, &plain);
    if (status == TUMBLE_OK) {
        status = tumble_set_encode_as(&plain, &store->stamp, store->bytes);
        to_version_2(&plain, thermal, store->bytes);
        tumble_set_stamp(store->bytes, &store->stamp);
        tumble_store_mark(store->bytes);
    }
    return status;
}

tumble_status_t tumble_store_write_thermal(tumble_store_t *store, tumble_which_set_t which, const tumble_set_t *set,
                                           const tumble_thermal_t *thermal)
{
    if ((set == NULL) || (thermal == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_set_t plain;
    tumble_status_t status = plain_set(set, thermal, &plain);
    if (status == TUMBLE_OK) {
        status = begin(store, which, &plain);
    }
    return (status == TUMBLE_OK) ? tumble_thermal_put(store, &plain, thermal) : status;
}
