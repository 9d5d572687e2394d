/* Calendar, inhibit, and when a run is due. */
#include "navcomp/keeper_internal.h"
#include "navcomp/navcomp_internal.h"

#include <stddef.h>

uint64_t tumble_keeper_utc_s(const tumble_keeper_t *keeper)
{
    return keeper->has_utc ? ((keeper->utc_us + keeper->now_us) / TUMBLE_US_PER_S) : 0U;
}

uint64_t tumble_keeper_age_s(const tumble_keeper_t *keeper)
{
    const uint64_t utc_s = tumble_keeper_utc_s(keeper);
    if ((keeper->active_utc_s != 0U) && (utc_s >= keeper->active_utc_s)) {
        return utc_s - keeper->active_utc_s;
    }
    return (keeper->now_us - keeper->active_us) / TUMBLE_US_PER_S;
}

bool tumble_keeper_is_ahead(const tumble_keeper_t *keeper, uint64_t date_utc_s, uint64_t slack_s)
{
    const uint64_t utc_s = tumble_keeper_utc_s(keeper);
    return (utc_s != 0U) && (date_utc_s > (utc_s + slack_s));
}

uint8_t tumble_keeper_due(const tumble_keeper_t *keeper)
{
    const tumble_keeper_settings_t *settings = &keeper->settings;
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
    due |= (keeper->has_active && tumble_keeper_is_ahead(keeper, keeper->active_utc_s, TUMBLE_KEEPER_CLOCK_SLACK_S))
               ? (unsigned)TUMBLE_DUE_DATE
               : 0U;
    due |= keeper->decayed ? (unsigned)TUMBLE_DUE_DECAYED : 0U;
    return (uint8_t)due;
}

bool tumble_keeper_is_inhibited(const tumble_keeper_t *keeper)
{
    const tumble_keeper_config_t *config = keeper->config;
    return (keeper->now_us < keeper->inhibit_us) || ((config->inhibited != NULL) && config->inhibited(config->context));
}

static bool is_turning(const tumble_navcomp_t *navcomp)
{
    const tumble_stand_state_t state = navcomp->stand.kind->state(navcomp->stand.self);
    return (state == TUMBLE_STAND_MOVING) || (state == TUMBLE_STAND_HOMING);
}

/* A run that waits in FAULT keeps what it has measured: the table rests, and going on is refused. One that began between
 * two looks at a contact that bounces is given up as well. */
void tumble_keeper_obey_inhibit(tumble_keeper_t *keeper)
{
    tumble_navcomp_t *navcomp = keeper->navcomp;
    const bool inhibited = tumble_keeper_is_inhibited(keeper);
    const bool begins = inhibited && !keeper->was_inhibited;
    const bool run = tumble_run_is_on(navcomp) && (tumble_run_state(navcomp) != TUMBLE_STATE_FAULT);
    keeper->was_inhibited = inhibited;
    if (!inhibited || (!run && (!begins || !is_turning(navcomp)))) {
        return;
    }
    tumble_count(&keeper->counters.inhibited);
    if (run) {
        tumble_procedure_give_up(&navcomp->procedure, TUMBLE_REASON_INHIBITED);
    } else {
        navcomp->stand.kind->stop(navcomp->stand.self);
    }
}

void tumble_keeper_pause(tumble_keeper_t *keeper)
{
    keeper->pause_us = keeper->now_us + ((uint64_t)keeper->settings.pause_s * TUMBLE_US_PER_S);
}

/* The table was not seen to stop, or somebody else turns it. */
static bool stand_wants_a_look(const tumble_navcomp_t *navcomp)
{
    const tumble_stand_fault_t fault = navcomp->stand.kind->fault(navcomp->stand.self);
    return (fault == TUMBLE_STAND_FAULT_STOP) || (fault == TUMBLE_STAND_FAULT_FOREIGN);
}

/* What somebody should look at first keeps it from starting: the table, a proposal, a run that could be gone on with. */
void tumble_keeper_start_if_due(tumble_keeper_t *keeper)
{
    const bool wanted = ((keeper->settings.flags & TUMBLE_KEEPER_STARTS) != 0U) && (tumble_keeper_due(keeper) != 0U);
    if (!wanted || tumble_run_is_on(keeper->navcomp) || tumble_keeper_is_inhibited(keeper) ||
        (keeper->now_us < keeper->pause_us) || (keeper->resumable != 0U) || stand_wants_a_look(keeper->navcomp) ||
        tumble_store_has(&keeper->store, TUMBLE_SET_PROPOSAL)) {
        return;
    }
    tumble_keeper_pause(keeper);
    tumble_count(&keeper->counters.self_started);
    (void)tumble_navcomp_obey(keeper->navcomp, TUMBLE_COMMAND_START, 0);
    tumble_keeper_watch(keeper);
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

void tumble_keeper_sample(void *context, const tumble_block_sample_t *sample, bool averaged)
{
    tumble_keeper_t *keeper = context;
    const tumble_block_counters_t *block = &keeper->navcomp->block.counters;
    watch_temperature(keeper, sample->temperature_half_c);
    tumble_at_rest_take(&keeper->at_rest, keeper->navcomp->procedure_config.averaging, sample,
                        block->repeated + block->reordered);
    if (averaged) {
        keeper->warmth_half_c += sample->temperature_half_c;
        keeper->warm_samples++;
    }
}
