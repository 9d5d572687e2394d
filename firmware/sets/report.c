/* Settings, and the readable side of the sets. */
#include "sets/parts.h"

#include "core/arith.h"
#include "core/one_copy.h"

#include <stddef.h>

#define MIN_GRAVITY_M_S2 9.7
#define MAX_GRAVITY_M_S2 9.9

static uint32_t up_to_32_bits(uint64_t value)
{
    return (value < UINT32_MAX) ? (uint32_t)value : UINT32_MAX;
}

/* Settings. */

bool tumble_sets_settings_valid(const tumble_sets_settings_t *settings)
{
    const double gravity = settings->gravity_m_s2;
    const bool somewhere = tumble_is_finite(gravity) && !tumble_exceeds(MIN_GRAVITY_M_S2, gravity) &&
                           !tumble_exceeds(gravity, MAX_GRAVITY_M_S2);
    return tumble_commit_limits_valid(&settings->limits) && (tumble_within(gravity, 0.0) || somewhere) &&
           (settings->pause_s >= TUMBLE_SETS_MIN_PAUSE_S) && (settings->temperature_samples != 0U) &&
           ((settings->flags & ~(unsigned)TUMBLE_SETS_STARTS) == 0U);
}

const tumble_sets_settings_t *tumble_sets_settings(const tumble_sets_t *sets)
{
    return &sets->settings;
}

tumble_status_t tumble_sets_change(tumble_sets_t *sets, const tumble_sets_settings_t *settings)
{
    if ((settings == NULL) || !tumble_sets_settings_valid(settings)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (sets->run->on) {
        return TUMBLE_E_STATE;
    }
    sets->settings = *settings;
    return TUMBLE_OK;
}

tumble_status_t tumble_sets_configure(tumble_sets_t *sets, const tumble_sets_settings_t *settings)
{
    const bool others = tumble_sets_rules_are_other(sets);
    const tumble_status_t status = tumble_sets_change(sets, settings);
    sets->rules = others ? sets->rules : tumble_sets_rules(sets);
    return status;
}

/* What the host tells. */

static uint64_t clock_us(const tumble_sets_t *sets)
{
    const tumble_port_t *port = sets->owner->port;
    return port->now_us(port->context);
}

tumble_status_t tumble_sets_set_utc(tumble_sets_t *sets, uint64_t utc_s)
{
    if (utc_s > TUMBLE_SETS_MAX_UTC_S) {
        return TUMBLE_E_ARGUMENT;
    }
    sets->has_utc = (utc_s != 0U);
    sets->utc_us = (utc_s * TUMBLE_US_PER_S) - clock_us(sets); /* modulo 2^64, as is adding the clock again */
    return TUMBLE_OK;
}

void tumble_sets_inhibit(tumble_sets_t *sets, uint16_t seconds)
{
    sets->inhibit_us = (seconds != 0U) ? (clock_us(sets) + ((uint64_t)seconds * TUMBLE_US_PER_S)) : 0U;
}

/* Reading. */

static uint16_t inhibit_left_s(const tumble_sets_t *sets)
{
    const uint64_t left_us = (sets->inhibit_us > sets->now_us) ? (sets->inhibit_us - sets->now_us) : 0U;
    const uint64_t left_s = tumble_sets_whole_s(left_us + (TUMBLE_US_PER_S - 1U));
    return (uint16_t)((left_s < UINT16_MAX) ? left_s : UINT16_MAX); /* a moment more, if told since the last step */
}

static uint32_t due_in_s(const tumble_sets_t *sets)
{
    const uint64_t age_s = tumble_sets_age_s(sets);
    const uint64_t interval_s = sets->settings.interval_s;
    return (sets->has_active && (age_s < interval_s)) ? (uint32_t)(interval_s - age_s) : 0U;
}

TUMBLE_ONE_COPY void tumble_sets_state(const tumble_sets_t *sets, tumble_sets_state_t *state)
{
    state->utc_s = tumble_sets_utc_s(sets);
    state->counter = sets->sequence;
    state->age_s = sets->has_active ? up_to_32_bits(tumble_sets_age_s(sets)) : 0U;
    state->due_in_s = due_in_s(sets);
    state->inhibit_s = inhibit_left_s(sets);
    state->objections = (uint16_t)sets->objections;
    state->more_objections = (uint16_t)(sets->objections >> TUMBLE_OBJECTION_MORE);
    state->verdict = sets->verdict;
    state->status = sets->status;
    state->due = tumble_sets_due(sets);
    state->resumable = sets->run->idle ? sets->resumable : 0U;
    state->inhibited = tumble_sets_is_inhibited(sets);
    state->busy = tumble_sets_has_work(sets);
    state->has_proposal = tumble_store_has(&sets->store, TUMBLE_SET_PROPOSAL);
    state->has_factory = tumble_store_has(&sets->store, TUMBLE_SET_FACTORY);
}

tumble_status_t tumble_sets_uncertainty(const tumble_sets_t *sets, const tumble_uncertainty_t **uncertainty)
{
    if (sets->run_was_on || (sets->task == (uint8_t)TASK_UNCERTAINTY)) {
        return TUMBLE_E_PORT_BUSY;
    }
    *uncertainty = &sets->set.uncertainty;
    return ((sets->set.flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U) ? TUMBLE_OK : TUMBLE_E_STATE;
}

tumble_status_t tumble_sets_whole_model(const tumble_sets_t *sets, const tumble_whole_work_t **found)
{
    if (sets->run_was_on || tumble_sets_is_assessing(sets)) {
        return TUMBLE_E_PORT_BUSY;
    }
    *found = sets->config->whole_work;
    return ((*found != NULL) && (*found)->known) ? TUMBLE_OK : TUMBLE_E_STATE;
}

uint32_t tumble_sets_counter(const tumble_sets_t *sets)
{
    return sets->sequence;
}

const tumble_sets_counters_t *tumble_sets_counters(const tumble_sets_t *sets)
{
    return &sets->counters;
}

/* From the newest entry backwards. A set that a rollback brought back is a copy of an older one, and the set before it
 * was given up. Neither says anything about drift. */
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

tumble_status_t tumble_sets_trend(tumble_sets_t *sets, uint8_t coefficient, tumble_trend_t *trend)
{
    tumble_trend_sums_t sums = {0};
    if ((trend == NULL) || (coefficient >= TUMBLE_COEFFICIENTS)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_history_busy(&sets->history)) {
        return TUMBLE_E_PORT_BUSY;
    }
    const uint8_t count = tumble_history_count(&sets->history);
    uint8_t given_up = 0;
    bool other_block = false;
    for (uint8_t age = 0; (age < count) && !other_block; age++) {
        tumble_history_entry_t entry;
        const tumble_status_t status = tumble_history_read(&sets->history, age, &entry);
        if (status != TUMBLE_OK) {
            return status;
        }
        const bool counts = is_of_the_trend(&entry, &given_up);
        other_block = counts && ((entry.flags & TUMBLE_HISTORY_OTHER_BLOCK) != 0U); /* what comes next */
        if (counts) { /* one without a date or an uncertainty is refused */
            (void)tumble_trend_add(&sums, entry.date_utc_s, (double)entry.value[coefficient],
                                   (double)entry.u[coefficient]);
        }
    }
    return tumble_trend_fit(&sums, trend);
}
