/* keeper_memory.h - the memory and the settings that a keeper begins with. */
#ifndef TUMBLE_TESTS_KEEPER_MEMORY_H
#define TUMBLE_TESTS_KEEPER_MEMORY_H

#include "navcomp/keeper.h"
#include "nv_memory.h"
#include "support.h"

#define MEMORY_SECTOR 4096U

static inline void memory_forbids(void)
{
    TEST_FAIL_MESSAGE("a call that the memory forbids, such as programming twice");
}

/* Blank. */
static inline void memory_init(nv_memory_t *memory)
{
    nv_make(memory, NV_MAX_SECTORS, 8, MEMORY_SECTOR);
    memory->on_violation = memory_forbids;
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
