/* Calendar, inhibit, and when a run is due. */
#include "sets/parts.h"

#include "core/arith.h"
#include "core/one_copy.h"

#include <stddef.h>

/* Whole seconds. A division of 64 bits would link 700 bytes of library that nothing else here needs, so divide as
 * doubles and correct what they round. */
uint64_t tumble_sets_whole_s(uint64_t us)
{
    const uint64_t seconds = tumble_whole((double)us / (double)TUMBLE_US_PER_S);
    const uint64_t rest_us = us - (seconds * TUMBLE_US_PER_S); /* wraps where a second was rounded up */
    uint64_t whole_s = seconds;
    if (rest_us >= (2U * TUMBLE_US_PER_S)) {
        whole_s--;
    } else if (rest_us >= TUMBLE_US_PER_S) {
        whole_s++;
    } else {
        /* nothing was rounded */
    }
    return whole_s;
}

uint64_t tumble_sets_utc_s(const tumble_sets_t *sets)
{
    return sets->has_utc ? tumble_sets_whole_s(sets->utc_us + sets->now_us) : 0U;
}

uint64_t tumble_sets_age_s(const tumble_sets_t *sets)
{
    const uint64_t utc_s = tumble_sets_utc_s(sets);
    if ((sets->active_utc_s != 0U) && (utc_s >= sets->active_utc_s)) {
        return utc_s - sets->active_utc_s;
    }
    return tumble_sets_whole_s(sets->now_us - sets->active_us);
}

bool tumble_sets_is_ahead(const tumble_sets_t *sets, uint64_t date_utc_s, uint64_t slack_s)
{
    const uint64_t utc_s = tumble_sets_utc_s(sets);
    return (utc_s != 0U) && (date_utc_s > (utc_s + slack_s));
}

uint8_t tumble_sets_due(const tumble_sets_t *sets)
{
    const tumble_sets_settings_t *settings = &sets->settings;
    unsigned due = 0;
    if (!sets->has_active) {
        due |= TUMBLE_DUE_NO_SET;
    } else if ((settings->interval_s != 0U) && (tumble_sets_age_s(sets) >= settings->interval_s)) {
        due |= TUMBLE_DUE_TIME;
    } else {
        /* not by time */
    }
    if ((settings->temperature_half_c != 0U) && (sets->off_temperature >= settings->temperature_samples)) {
        due |= TUMBLE_DUE_TEMPERATURE;
    }
    due |= (sets->has_active && tumble_sets_is_ahead(sets, sets->active_utc_s, TUMBLE_SETS_CLOCK_SLACK_S))
               ? (unsigned)TUMBLE_DUE_DATE
               : 0U;
    due |= sets->decayed ? (unsigned)TUMBLE_DUE_DECAYED : 0U;
    due |= tumble_store_has_newer(&sets->store) ? (unsigned)TUMBLE_DUE_NEWER : 0U;
    return (uint8_t)due;
}

bool tumble_sets_is_inhibited(const tumble_sets_t *sets)
{
    const tumble_sets_config_t *config = sets->config;
    return (sets->now_us < sets->inhibit_us) || ((config->inhibited != NULL) && config->inhibited(config->context));
}

/* A run that waits in FAULT keeps what it has measured: the table rests, and RESUME is refused. A run that began
 * between two readings of a bouncing contact is given up as well. */
tumble_sets_wish_t tumble_sets_hold_off(tumble_sets_t *sets, uint64_t now_us)
{
    const tumble_sets_run_t *at_hand = sets->run;
    sets->now_us = now_us;
    const bool inhibited = tumble_sets_is_inhibited(sets);
    const bool begins = inhibited && !sets->was_inhibited;
    const bool run = at_hand->on && !at_hand->waits;
    sets->was_inhibited = inhibited;
    if (!inhibited || (!run && (!begins || !at_hand->turning))) {
        return TUMBLE_SETS_NOTHING;
    }
    tumble_count(&sets->counters.inhibited);
    return run ? TUMBLE_SETS_GIVE_UP : TUMBLE_SETS_STOP;
}

void tumble_sets_pause(tumble_sets_t *sets)
{
    sets->pause_us = sets->now_us + ((uint64_t)sets->settings.pause_s * TUMBLE_US_PER_S);
}

/* Do not start by itself while somebody should look first: at the table, at a proposal, at a run that can be
 * resumed. */
TUMBLE_ONE_COPY bool tumble_sets_start(tumble_sets_t *sets)
{
    const tumble_sets_run_t *at_hand = sets->run;
    const bool wanted = ((sets->settings.flags & TUMBLE_SETS_STARTS) != 0U) &&
                        ((tumble_sets_due(sets) & ~(unsigned)TUMBLE_DUE_NEWER) != 0U);
    if (!wanted || at_hand->on || tumble_sets_is_inhibited(sets) || (sets->now_us < sets->pause_us) ||
        (sets->resumable != 0U) || at_hand->to_be_looked_at || tumble_store_has(&sets->store, TUMBLE_SET_PROPOSAL)) {
        return false;
    }
    tumble_sets_pause(sets);
    tumble_count(&sets->counters.self_started);
    return true;
}

static void watch_temperature(tumble_sets_t *sets, int8_t half_c)
{
    const int off = (int)half_c - (int)sets->active_half_c;
    const int limit = (int)sets->settings.temperature_half_c;
    if (!sets->has_active_half_c || ((off <= limit) && (off >= -limit))) {
        sets->off_temperature = 0;
    } else if (sets->off_temperature < UINT16_MAX) {
        sets->off_temperature++;
    } else {
        /* long enough */
    }
}

void tumble_sets_sample(tumble_sets_t *sets, int8_t temperature_half_c, bool averaged)
{
    watch_temperature(sets, temperature_half_c);
    if (averaged) {
        const int above_coldest = (int)temperature_half_c - (int)INT8_MIN;
        const int below_warmest = (int)INT8_MAX - (int)temperature_half_c;
        const tumble_margins_t seen = {(uint8_t)above_coldest, (uint8_t)below_warmest};
        tumble_checkpoint_narrow(&sets->checkpoint, seen);
        sets->warmth_half_c += temperature_half_c;
        sets->warm_samples++;
    }
}
