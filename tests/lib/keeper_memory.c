#include "keeper_memory.h"

nv_memory_t memory;
tumble_keeper_t keeper;
tumble_sets_settings_t settings;
tumble_keeper_config_t keeper_config;

static void memory_forbids(void)
{
    TEST_FAIL_MESSAGE("a call that the memory forbids, such as programming twice");
}

void memory_init(nv_memory_t *m)
{
    nv_make(m, NV_MAX_SECTORS, 8, MEMORY_SECTOR);
    m->on_violation = memory_forbids;
}

tumble_sets_settings_t usual_settings(void)
{
    tumble_sets_settings_t usual = {
        .limits = {.coverage = 3.0F, .flags = TUMBLE_COMMIT_BY_ITSELF | TUMBLE_COMMIT_FIRST},
        .gravity_m_s2 = 9.81,
        .pause_s = TUMBLE_SETS_MIN_PAUSE_S,
        .temperature_samples = 50};
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        usual.limits.uncertainty[c] = 1e-3F;
        usual.limits.drift_per_month[c] = 1e-4F;
    }
    return usual;
}
