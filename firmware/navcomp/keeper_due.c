/* Settings, calendar, inhibit, and when a run is due. Saved rules count as the board's as soon as they are in force or
 * have been written. */
#include "navcomp/keeper_parts.h"

#include "core/arith.h"
#include "core/crc32.h"
#include "core/one_copy.h"

#include <stddef.h>

#define MIN_GRAVITY_M_S2 9.7
#define MAX_GRAVITY_M_S2 9.9

/* Settings. */

bool tumble_keeper_settings_valid(const tumble_sets_settings_t *settings)
{
    const double gravity = settings->gravity_m_s2;
    const bool somewhere = tumble_is_finite(gravity) && !tumble_exceeds(MIN_GRAVITY_M_S2, gravity) &&
                           !tumble_exceeds(gravity, MAX_GRAVITY_M_S2);
    return tumble_commit_limits_valid(&settings->limits) && (tumble_within(gravity, 0.0) || somewhere) &&
           (settings->pause_s >= TUMBLE_SETS_MIN_PAUSE_S) && (settings->temperature_samples != 0U) &&
           ((settings->flags & ~(unsigned)TUMBLE_SETS_STARTS) == 0U);
}

tumble_status_t tumble_keeper_change(tumble_keeper_t *keeper, const tumble_sets_settings_t *settings)
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

tumble_status_t tumble_keeper_configure(tumble_keeper_t *keeper, const tumble_sets_settings_t *settings)
{
    const bool others = tumble_keeper_rules_are_other(keeper);
    const tumble_status_t status = tumble_keeper_change(keeper, settings);
    keeper->rules = others ? keeper->rules : tumble_keeper_rules(keeper);
    return status;
}

/* Rules. */

#define NUMBERS_BYTES (offsetof(tumble_commit_limits_t, flags))

static_assert((offsetof(tumble_commit_limits_t, uncertainty) == 0U) &&
                  (NUMBERS_BYTES == (sizeof(float) * ((3U * TUMBLE_COEFFICIENTS) + 1U))),
              "the numbers of the limits are told by their bytes: nothing may lie between them");

/* Of all that the rules go by. Of this machine alone: it is never kept. */
static uint32_t fingerprint(const tumble_commit_limits_t *limits, const double *gravity_limit_g)
{
    uint32_t crc = tumble_crc32(0, (const uint8_t *)limits, (uint32_t)NUMBERS_BYTES);
    crc = tumble_crc32(crc, &limits->flags, 1U);
    return tumble_crc32(crc, (const uint8_t *)gravity_limit_g, (uint32_t)sizeof *gravity_limit_g);
}

uint32_t tumble_keeper_rules(const tumble_keeper_t *keeper)
{
    return fingerprint(&keeper->settings.limits, &keeper->navcomp->procedure_config.gravity_limit_g);
}

uint32_t tumble_keeper_rules_of_board(const tumble_keeper_t *keeper)
{
    return fingerprint(&keeper->config->sets.settings->limits, &keeper->navcomp->config->procedure->gravity_limit_g);
}

bool tumble_keeper_rules_are_other(const tumble_keeper_t *keeper)
{
    return tumble_keeper_rules(keeper) != keeper->rules;
}

uint16_t tumble_keeper_rules_flag(const tumble_keeper_t *keeper)
{
    const bool other = tumble_keeper_rules_are_other(keeper) || tumble_service_is_open(keeper->navcomp);
    return other ? TUMBLE_SET_OTHER_RULES : 0U;
}

/* The calendar. */

/* Whole seconds. A division of 64 bits would link 700 bytes of library that nothing else here needs, so divide as
 * doubles and correct what they round. */
uint64_t tumble_keeper_whole_s(uint64_t us)
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

uint64_t tumble_keeper_utc_s(const tumble_keeper_t *keeper)
{
    return keeper->has_utc ? tumble_keeper_whole_s(keeper->utc_us + keeper->now_us) : 0U;
}

uint64_t tumble_keeper_age_s(const tumble_keeper_t *keeper)
{
    const uint64_t utc_s = tumble_keeper_utc_s(keeper);
    if ((keeper->active_utc_s != 0U) && (utc_s >= keeper->active_utc_s)) {
        return utc_s - keeper->active_utc_s;
    }
    return tumble_keeper_whole_s(keeper->now_us - keeper->active_us);
}

bool tumble_keeper_is_ahead(const tumble_keeper_t *keeper, uint64_t date_utc_s, uint64_t slack_s)
{
    const uint64_t utc_s = tumble_keeper_utc_s(keeper);
    return (utc_s != 0U) && (date_utc_s > (utc_s + slack_s));
}

uint8_t tumble_keeper_due(const tumble_keeper_t *keeper)
{
    const tumble_sets_settings_t *settings = &keeper->settings;
    unsigned due = 0;
    if (!keeper->has_active) {
        due |= TUMBLE_DUE_NO_SET;
    } else if ((settings->interval_s != 0U) && (tumble_keeper_age_s(keeper) >= settings->interval_s)) {
        due |= TUMBLE_DUE_TIME;
    } else {
        /* not by time */
    }
    if ((settings->temperature_half_c != 0U) && (keeper->off_temperature >= settings->temperature_samples)) {
        due |= TUMBLE_DUE_TEMPERATURE;
    }
    due |= (keeper->has_active && tumble_keeper_is_ahead(keeper, keeper->active_utc_s, TUMBLE_SETS_CLOCK_SLACK_S))
               ? (unsigned)TUMBLE_DUE_DATE
               : 0U;
    due |= keeper->decayed ? (unsigned)TUMBLE_DUE_DECAYED : 0U;
    due |= tumble_store_has_newer(&keeper->store) ? (unsigned)TUMBLE_DUE_NEWER : 0U;
    return (uint8_t)due;
}

bool tumble_keeper_is_inhibited(const tumble_keeper_t *keeper)
{
    const tumble_sets_config_t *config = &keeper->config->sets;
    return (keeper->now_us < keeper->inhibit_us) || ((config->inhibited != NULL) && config->inhibited(config->context));
}

/* A run that waits in FAULT keeps what it has measured: the table rests, and RESUME is refused. A run that began
 * between two readings of a bouncing contact is given up as well. */
void tumble_keeper_hold_off(tumble_keeper_t *keeper, uint64_t now_us)
{
    tumble_navcomp_t *navcomp = keeper->navcomp;
    keeper->now_us = now_us;
    const bool inhibited = tumble_keeper_is_inhibited(keeper);
    const bool begins = inhibited && !keeper->was_inhibited;
    const bool run = tumble_run_is_on(navcomp) && (tumble_run_state(navcomp) != TUMBLE_STATE_FAULT);
    const tumble_stand_state_t stand = tumble_stand_state(&navcomp->stand);
    const bool turning = (stand == TUMBLE_STAND_MOVING) || (stand == TUMBLE_STAND_HOMING);
    keeper->was_inhibited = inhibited;
    if (!inhibited || (!run && (!begins || !turning))) {
        return;
    }
    tumble_count(&keeper->counters.inhibited);
    if (run) {
        tumble_procedure_give_up(&navcomp->procedure, TUMBLE_REASON_INHIBITED);
    } else {
        tumble_stand_stop(&navcomp->stand);
    }
}

void tumble_keeper_pause(tumble_keeper_t *keeper)
{
    keeper->pause_us = keeper->now_us + ((uint64_t)keeper->settings.pause_s * TUMBLE_US_PER_S);
}

/* Do not start by itself while somebody should look first: at the table, which was not seen to stop or which somebody else
 * turns, at a proposal, at a run that can be resumed. */
TUMBLE_ONE_COPY bool tumble_keeper_may_start(tumble_keeper_t *keeper)
{
    const tumble_stand_fault_t fault = tumble_stand_fault(&keeper->navcomp->stand);
    const bool wanted = ((keeper->settings.flags & TUMBLE_SETS_STARTS) != 0U) &&
                        ((tumble_keeper_due(keeper) & ~(unsigned)TUMBLE_DUE_NEWER) != 0U);
    if (!wanted || tumble_run_is_on(keeper->navcomp) || tumble_keeper_is_inhibited(keeper) ||
        (keeper->now_us < keeper->pause_us) || (keeper->resumable != 0U) || (fault == TUMBLE_STAND_FAULT_STOP) ||
        (fault == TUMBLE_STAND_FAULT_FOREIGN) || tumble_store_has(&keeper->store, TUMBLE_SET_PROPOSAL)) {
        return false;
    }
    tumble_keeper_pause(keeper);
    tumble_count(&keeper->counters.self_started);
    return true;
}

static void watch_temperature(tumble_keeper_t *keeper, int8_t half_c)
{
    const int off = (int)half_c - (int)keeper->active_half_c;
    const int limit = (int)keeper->settings.temperature_half_c;
    if (!keeper->has_active_half_c || ((off <= limit) && (off >= -limit))) {
        keeper->off_temperature = 0;
    } else if (keeper->off_temperature < UINT16_MAX) {
        keeper->off_temperature++;
    } else {
        /* long enough */
    }
}

void tumble_keeper_note_temperature(tumble_keeper_t *keeper, int8_t temperature_half_c, bool averaged)
{
    watch_temperature(keeper, temperature_half_c);
    if (averaged) {
        const int above_coldest = (int)temperature_half_c - (int)INT8_MIN;
        const int below_warmest = (int)INT8_MAX - (int)temperature_half_c;
        const tumble_margins_t seen = {(uint8_t)above_coldest, (uint8_t)below_warmest};
        tumble_checkpoint_narrow(&keeper->checkpoint, seen);
        keeper->warmth_half_c += temperature_half_c;
        keeper->warm_samples++;
    }
}

/* What the host tells. */

static uint64_t clock_us(const tumble_keeper_t *keeper)
{
    const tumble_port_t *port = keeper->navcomp->config->port;
    return port->now_us(port->context);
}

tumble_status_t tumble_keeper_set_utc(tumble_keeper_t *keeper, uint64_t utc_s)
{
    if (utc_s > TUMBLE_SETS_MAX_UTC_S) {
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
