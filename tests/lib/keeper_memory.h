/* keeper_memory.h - a non-volatile memory of the test's own, and settings that a keeper begins with. */
#ifndef TUMBLE_TESTS_KEEPER_MEMORY_H
#define TUMBLE_TESTS_KEEPER_MEMORY_H

#include "navcomp/keeper.h"
#include "support.h"

#include <string.h>

#define MEMORY_SECTOR 4096U
#define MEMORY_SECTORS 10U
#define MEMORY_GRANULE 8U
#define NEVER_FAILS UINT32_MAX

typedef struct {
    tumble_nv_t nv;
    uint8_t bytes[MEMORY_SECTOR * MEMORY_SECTORS];
    uint32_t changes;  /* erases and programs so far */
    uint32_t fails_at; /* this change fails, ... */
    uint32_t fails;    /* ... and so do the ones after it, so many in all */
    uint32_t answers;  /* calls so far; every `busy_every`th answers busy, 0: none */
    uint32_t busy_every;
    bool reads_fail;
} memory_t;

static inline bool memory_is_busy(memory_t *m)
{
    m->answers++;
    return (m->busy_every != 0U) && ((m->answers % m->busy_every) == 0U);
}

static inline bool memory_refuses(memory_t *m)
{
    const uint32_t change = m->changes++;
    return (change >= m->fails_at) && ((change - m->fails_at) < m->fails);
}

static inline tumble_status_t memory_erase(void *context, uint32_t offset)
{
    memory_t *m = context;
    if (memory_is_busy(m)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if (memory_refuses(m)) {
        return TUMBLE_E_NV;
    }
    memset(&m->bytes[offset], 0xFF, MEMORY_SECTOR);
    return TUMBLE_OK;
}

static inline tumble_status_t memory_program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    memory_t *m = context;
    if (memory_is_busy(m)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if (memory_refuses(m)) {
        return TUMBLE_E_NV;
    }
    for (uint32_t i = 0; i < size; i++) {
        TEST_ASSERT_EQUAL_HEX8_MESSAGE(0xFF, m->bytes[offset + i], "programmed twice");
        m->bytes[offset + i] = bytes[i];
    }
    return TUMBLE_OK;
}

static inline tumble_status_t memory_read(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    memory_t *m = context;
    if (memory_is_busy(m)) {
        return TUMBLE_E_PORT_BUSY;
    }
    memcpy(bytes, &m->bytes[offset], size);
    return m->reads_fail ? TUMBLE_E_NV : TUMBLE_OK;
}

/* Blank. */
static inline void memory_init(memory_t *m)
{
    memset(m, 0, sizeof *m);
    memset(m->bytes, 0xFF, sizeof m->bytes);
    m->fails_at = NEVER_FAILS;
    m->fails = UINT32_MAX;
    m->nv = (tumble_nv_t){m, sizeof m->bytes, MEMORY_SECTOR, MEMORY_GRANULE, memory_erase, memory_program, memory_read};
}

static inline tumble_keeper_settings_t usual_settings(void)
{
    tumble_keeper_settings_t usual = {.limits = {.coverage = 3.0F, .flags = TUMBLE_COMMIT_BY_ITSELF | TUMBLE_COMMIT_FIRST},
                                      .gravity_m_s2 = 9.81,
                                      .pause_s = TUMBLE_KEEPER_MIN_PAUSE_S,
                                      .temperature_samples = 50};
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        usual.limits.uncertainty[c] = 1e-3F;
        usual.limits.drift_per_month[c] = 1e-4F;
    }
    return usual;
}

#endif
