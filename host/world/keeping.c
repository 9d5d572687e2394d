#include "world/keeping.h"

#include <string.h>

void bench_keeping_defaults(bench_keeping_t *keeping)
{
    *keeping = (bench_keeping_t){
        .commits = true,
        .settings = {.limits = {.coverage = 3.0F}, .pause_s = 3600, .temperature_samples = 100},
    };
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        keeping->settings.limits.uncertainty[c] = 1e-3F;
        keeping->settings.limits.drift_per_month[c] = 1e-4F;
    }
    bench_keeping_complete(keeping);
}

void bench_keeping_complete(bench_keeping_t *keeping)
{
    tumble_sets_settings_t *const settings = &keeping->settings;
    settings->limits.flags =
        (uint8_t)((keeping->commits ? TUMBLE_COMMIT_BY_ITSELF : 0) | (keeping->first ? TUMBLE_COMMIT_FIRST : 0));
    settings->flags = keeping->starts ? TUMBLE_SETS_STARTS : 0U;
}
