/* Settings, and the readable side of the keeper. */
#include "navcomp/keeper_internal.h"
#include "navcomp/navcomp_internal.h"

#include <stddef.h>

#define MIN_GRAVITY_M_S2 9.7
#define MAX_GRAVITY_M_S2 9.9

static uint32_t up_to_32_bits(uint64_t value)
{
    return (value < UINT32_MAX) ? (uint32_t)value : UINT32_MAX;
}

/* Settings. */

bool tumble_keeper_settings_valid(const tumble_keeper_settings_t *settings)
{
    const double gravity = settings->gravity_m_s2;
    const bool somewhere = (gravity >= MIN_GRAVITY_M_S2) && (gravity <= MAX_GRAVITY_M_S2);
    return tumble_commit_limits_valid(&settings->limits) && ((gravity == 0.0) || somewhere) &&
           (settings->pause_s >= TUMBLE_KEEPER_MIN_PAUSE_S) && (settings->temperature_samples != 0U) &&
           ((settings->flags & ~(unsigned)TUMBLE_KEEPER_STARTS) == 0U);
}

const tumble_keeper_settings_t *tumble_keeper_settings(const tumble_keeper_t *keeper)
{
    return &keeper->settings;
}

tumble_status_t tumble_keeper_change(tumble_keeper_t *keeper, const tumble_keeper_settings_t *settings)
{
    if ((settings == NULL) || !tumble_keeper_settings_valid(settings)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_run_is_on(keeper->navcomp)) {
        return TUMBLE_E_STATE;
    }
    keeper->settings = *settings;
    return TUMBLE_OK;
}

tumble_status_t tumble_keeper_configure(tumble_keeper_t *keeper, const tumble_keeper_settings_t *settings)
{
    const bool others = tumble_keeper_rules_are_other(keeper);
    const tumble_status_t status = tumble_keeper_change(keeper, settings);
    keeper->rules = others ? keeper->rules : tumble_keeper_rules(keeper);
    return status;
}

/* What the host tells. */

static uint64_t clock_us(const tumble_keeper_t *keeper)
{
    const tumble_port_t *port = keeper->navcomp->config->port;
    return port->now_us(port->context);
}

tumble_status_t tumble_keeper_set_utc(tumble_keeper_t *keeper, uint64_t utc_s)
{
    if (utc_s > TUMBLE_KEEPER_MAX_UTC_S) {
        return TUMBLE_E_ARGUMENT;
    }
    keeper->has_utc = (utc_s != 0U);
    keeper->utc_us = (utc_s * TUMBLE_US_PER_S) - clock_us(keeper); /* modulo 2^64, as is adding the clock again */
    return TUMBLE_OK;
}

void tumble_keeper_inhibit(tumble_keeper_t *keeper, uint16_t seconds)
{
    keeper->inhibit_us = (seconds != 0U) ? (clock_us(keeper) + ((uint64_t)seconds * TUMBLE_US_PER_S)) : 0U;
    keeper->navcomp->due_us = 0; /* what it ends waits for a step */
}

/* Reading. */

static uint16_t inhibit_left_s(const tumble_keeper_t *keeper)
{
    const uint64_t left_us = (keeper->inhibit_us > keeper->now_us) ? (keeper->inhibit_us - keeper->now_us) : 0U;
    const uint64_t left_s = (left_us + (TUMBLE_US_PER_S - 1U)) / TUMBLE_US_PER_S;
    return (uint16_t)((left_s < UINT16_MAX) ? left_s : UINT16_MAX); /* a moment more, if told since the last step */
}

static uint32_t due_in_s(const tumble_keeper_t *keeper)
{
    const uint64_t age_s = tumble_keeper_age_s(keeper);
    const uint64_t interval_s = keeper->settings.interval_s;
    return (keeper->has_active && (age_s < interval_s)) ? (uint32_t)(interval_s - age_s) : 0U;
}

void tumble_keeper_state(const tumble_keeper_t *keeper, tumble_keeper_state_t *state)
{
    *state = (tumble_keeper_state_t){
        .utc_s = tumble_keeper_utc_s(keeper),
        .counter = keeper->sequence,
        .age_s = keeper->has_active ? up_to_32_bits(tumble_keeper_age_s(keeper)) : 0U,
        .due_in_s = due_in_s(keeper),
        .inhibit_s = inhibit_left_s(keeper),
        .objections = keeper->objections,
        .verdict = keeper->verdict,
        .status = keeper->status,
        .due = tumble_keeper_due(keeper),
        .resumable = (tumble_run_state(keeper->navcomp) == TUMBLE_STATE_IDLE) ? keeper->resumable : 0U,
        .inhibited = tumble_keeper_is_inhibited(keeper),
        .busy = tumble_keeper_has_work(keeper),
        .has_proposal = tumble_store_has(&keeper->store, TUMBLE_SET_PROPOSAL),
        .has_factory = tumble_store_has(&keeper->store, TUMBLE_SET_FACTORY),
    };
}

tumble_status_t tumble_keeper_set(tumble_keeper_t *keeper, tumble_which_set_t which, tumble_set_t *set)
{
    return tumble_store_read(&keeper->store, which, set);
}

uint32_t tumble_keeper_counter(const tumble_keeper_t *keeper)
{
    return keeper->sequence;
}

const tumble_keeper_counters_t *tumble_keeper_counters(const tumble_keeper_t *keeper)
{
    return &keeper->counters;
}

tumble_history_t *tumble_keeper_history(tumble_keeper_t *keeper)
{
    return &keeper->history;
}

/* From the newest entry backwards: a set that was brought back is a copy of an older one, and the one before it was
 * given up for it. Neither tells of a drift. */
static bool is_of_the_trend(const tumble_history_entry_t *entry, uint8_t *given_up)
{
    if (entry->origin == (uint8_t)TUMBLE_ORIGIN_DECAYED) {
        return false; /* an event, no set */
    }
    const bool was_given_up = (*given_up != 0U);
    const bool copy = (entry->origin == (uint8_t)TUMBLE_ORIGIN_ROLLED_BACK);
    *given_up = (uint8_t)(*given_up + (copy ? 1U : 0U) - (was_given_up ? 1U : 0U));
    return !was_given_up && !copy;
}

tumble_status_t tumble_keeper_trend(tumble_keeper_t *keeper, uint8_t coefficient, tumble_trend_t *trend)
{
    tumble_trend_sums_t sums = {0};
    if ((trend == NULL) || (coefficient >= TUMBLE_COEFFICIENTS)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_history_busy(&keeper->history)) {
        return TUMBLE_E_PORT_BUSY;
    }
    const uint8_t count = tumble_history_count(&keeper->history);
    uint8_t given_up = 0;
    bool other_block = false;
    for (uint8_t age = 0; (age < count) && !other_block; age++) {
        tumble_history_entry_t entry;
        const tumble_status_t status = tumble_history_read(&keeper->history, age, &entry);
        if (status != TUMBLE_OK) {
            return status;
        }
        const bool counts = is_of_the_trend(&entry, &given_up);
        other_block = counts && ((entry.flags & TUMBLE_HISTORY_OTHER_BLOCK) != 0U); /* what comes next */
        if (counts && (entry.date_utc_s != 0U) && (entry.u[coefficient] > 0.0F)) {
            (void)tumble_trend_add(&sums, entry.date_utc_s, (double)entry.value[coefficient],
                                   (double)entry.u[coefficient]);
        }
    }
    return tumble_trend_fit(&sums, trend);
}
