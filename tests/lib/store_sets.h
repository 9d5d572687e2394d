/* store_sets.h - sets of coefficients that can be told apart, and a store driven to its end. Needs no Unity. */
#ifndef STORE_SETS_H
#define STORE_SETS_H

#include "flash.h"
#include "sets/record.h"

/* Every field filled in, every one of them by `tag`. */
static inline tumble_set_t set_of(unsigned tag)
{
    tumble_set_t set = {.sequence = 77, .restores = 78, .from_crc = 79, .origin = 99, .estimator = (uint8_t)(tag % 4U)};
    set.flags = TUMBLE_SET_FLAGS;
    memcpy(set.block_serial, "BLOCK-0001", 10);
    set.block_serial[9] = (uint8_t)('A' + tag % 26U);
    set.date_utc_s = 1790000000U + 86400U * (uint64_t)tag;
    set.temperature_c = 20.0 + tag / 8.0;
    set.gravity_m_s2 = 9.81 + tag / 1024.0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            set.coefficients.k_v_per_g[i][j] = (i == j) ? 1.0 + tag / 64.0 : (i - j) / 512.0 - tag / 4096.0;
            set.uncertainty.k_v_per_g[i][j] = 1e-5 * (1.0 + i + 3.0 * j + tag);
        }
        set.coefficients.u0_v[i] = -0.01 * (i + 1) + tag / 8192.0;
        set.uncertainty.u0_v[i] = 1e-6 * (i + 1.0 + tag);
    }
    set.max_abs_fit_g = 1e-4 + tag / 65536.0;
    set.max_abs_check_g = 2e-4 + tag / 65536.0;
    set.limit_g = 3e-4 + tag / 65536.0;
    set.closure_v = 1e-5 * (1.0 + tag);
    set.samples = 900U + tag;
    set.fit_positions = 18;
    set.check_positions = (uint8_t)tag;
    set.temperature_min_half_c = (int8_t)((int)(tag % 100U) - 60);
    set.temperature_max_half_c = (int8_t)(set.temperature_min_half_c + (int)(tag % 7U));
    set.schedule_crc = 0x140E4A73U + tag;
    set.stand_crc = 0xCAFE0000U + tag;
    set.reasons = tag;
    return set;
}

/* The bytes of a set, but for what the store writes itself. */
static inline void set_bytes(const tumble_set_t *set, uint8_t bytes[TUMBLE_SET_BYTES])
{
    const tumble_set_stamp_t none = {.origin = TUMBLE_ORIGIN_FACTORY};
    (void)tumble_set_encode_as(set, &none, bytes);
}

static inline bool set_is(const tumble_set_t *set, unsigned tag)
{
    static uint8_t expected[256][TUMBLE_SET_BYTES]; /* made once: the CRC of a set is what takes the time */
    uint8_t bytes[TUMBLE_SET_BYTES];
    if (tag > 255U || set->reasons != tag) {
        return false;
    }
    if (expected[tag][0] == 0U) {
        const tumble_set_t made = set_of(tag);
        set_bytes(&made, expected[tag]);
    }
    set_bytes(set, bytes);
    return memcmp(bytes, expected[tag], sizeof bytes) == 0;
}

/* The polynomials of a set of version 2, of which every number is by `tag` as well. */
static inline tumble_thermal_t thermal_of(unsigned tag)
{
    const tumble_set_t set = set_of(tag);
    tumble_thermal_t thermal = {set.temperature_c, -20.0 - tag, 50.0, {set.coefficients}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            thermal.power[1].k_v_per_g[i][j] = (i + 2.0 * j - tag) / 65536.0;
            thermal.power[2].k_v_per_g[i][j] = (j - i + tag / 8.0) / 1048576.0;
        }
        thermal.power[1].u0_v[i] = (i - 2.0 * tag) / 131072.0;
        thermal.power[2].u0_v[i] = ((double)tag - i) / 2097152.0;
    }
    return thermal;
}

/* The bytes of a set of version 2, likewise. */
static inline void thermal_bytes(const tumble_set_t *set, const tumble_thermal_t *thermal,
                                 uint8_t bytes[TUMBLE_SET_BYTES])
{
    tumble_set_t unstamped = *set;
    unstamped.sequence = 0;
    unstamped.restores = 0;
    unstamped.from_crc = 0;
    unstamped.origin = TUMBLE_ORIGIN_FACTORY;
    (void)tumble_set_encode_thermal(&unstamped, thermal, bytes);
}

/* One of version 2, slopes and all. */
static inline bool thermal_is(const tumble_set_t *set, const tumble_thermal_t *thermal, unsigned tag)
{
    static uint8_t expected[256][TUMBLE_SET_BYTES];
    uint8_t bytes[TUMBLE_SET_BYTES];
    if (tag > 255U || set->reasons != tag || (set->flags & TUMBLE_SET_HAS_SLOPES) == 0U) {
        return false;
    }
    if (expected[tag][0] == 0U) {
        const tumble_set_t made = set_of(tag);
        const tumble_thermal_t of_tag = thermal_of(tag);
        thermal_bytes(&made, &of_tag, expected[tag]);
    }
    thermal_bytes(set, thermal, bytes);
    return memcmp(bytes, expected[tag], sizeof bytes) == 0;
}

#define STEPS_AT_MOST 20000

/* Step until nothing is under way; false: it never ends. */
static inline bool store_settles(tumble_store_t *store)
{
    int steps = 0;
    while (tumble_store_step(store) == TUMBLE_E_PORT_BUSY && steps < STEPS_AT_MOST) {
        steps++;
    }
    return steps < STEPS_AT_MOST;
}

#endif
