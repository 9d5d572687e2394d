/* store_campaign.h - all scenarios, granules and sector sizes, in a short and a long version. Needs no Unity. */
#ifndef STORE_CAMPAIGN_H
#define STORE_CAMPAIGN_H

#include "core/crc32.h"
#include "store_logs.h"

#include <stdio.h>

/* The same function by a table, in place of the core's, which is small rather than fast: most of the time goes here. */
uint32_t tumble_crc32(uint32_t crc, const void *bytes, size_t size)
{
    static uint32_t table[256];
    const uint8_t *byte = bytes;
    for (uint32_t i = 0; table[255] == 0U && i < 256U; i++) {
        table[i] = i;
        for (int bit = 0; bit < 8; bit++) {
            table[i] = (table[i] >> 1) ^ ((table[i] & 1U) != 0U ? 0xEDB88320U : 0U);
        }
    }
    crc = ~crc;
    for (size_t i = 0; i < size; i++) {
        crc = (crc >> 8) ^ table[(crc ^ byte[i]) & 0xFFU];
    }
    return ~crc;
}

#define COUNT_SCENARIOS(list) (sizeof(list) / sizeof((list)[0]))

static const done_t every_way[] = {DONE_NOTHING,     DONE_ALL,       DONE_QUARTER,    DONE_HALF,      DONE_BUT_LAST,
                                   DONE_SECOND_HALF, DONE_SOME_BITS, DONE_SOME_BYTES, DONE_ANY_VALUES};
static const done_t some_ways[] = {DONE_NOTHING, DONE_ALL, DONE_SOME_BITS};

static const uint32_t power_granules[] = {1, 4, 8, 16, 32};
static const uint32_t power_sectors[] = {4096, 8192};

static void run_scenarios(campaign_t *campaign, const scenario_t *scenarios, size_t count, bool all_twice)
{
    const fault_list_t all = {every_way, 9};
    const fault_list_t some = {some_ways, 3};
    for (size_t g = 0; g < 5U; g++) {
        for (size_t s = 0; s < 2U; s++) {
            campaign->granule = power_granules[g];
            campaign->sector = power_sectors[s];
            for (size_t i = 0; i < count && campaign->bad == 0U; i++) {
                power_scenario(campaign, &scenarios[i], &all, all_twice);
                if (!all_twice && g == 2U && s == 0U) {
                    power_scenario(campaign, &scenarios[i], &some, true);
                }
            }
        }
    }
}

/* Prints the cases of each part. `all_twice`: every pair of faults in every geometry; else a choice of pairs in one. `part`: of
 * its name alone; null: all. */
static campaign_t run_campaign(bool all_twice, const char *part)
{
    static const struct {
        const char *name;
        const scenario_t *scenarios;
        size_t count;
        bool over_temperature;
    } parts[] = {{"store", store_scenarios, COUNT_SCENARIOS(store_scenarios), false},
                 {"thermal", store_scenarios, COUNT_SCENARIOS(store_scenarios), true},
                 {"history", history_scenarios, COUNT_SCENARIOS(history_scenarios), false},
                 {"checkpoint", checkpoint_scenarios, COUNT_SCENARIOS(checkpoint_scenarios), false}};
    campaign_t campaign = {.sectors = TUMBLE_REGION_COUNT};
    for (size_t p = 0; p < COUNT_SCENARIOS(parts); p++) {
        if (part != NULL && strcmp(part, parts[p].name) != 0) {
            continue;
        }
        const unsigned long before = campaign.cases;
        jobs_over_temperature = parts[p].over_temperature;
        run_scenarios(&campaign, parts[p].scenarios, parts[p].count, all_twice);
        (void)printf("%s: %lu cases, %lu bad\n", parts[p].name, campaign.cases - before, campaign.bad);
    }
    return campaign;
}

#endif
