#include "navcomp/keeper_parts.h"

#include "core/arith.h"
#include "core/bytes.h"
#include "core/one_copy.h"
#include "navcomp/keeper_objects.h"
#include "navcomp/uncertainty.h"
#include "sets/record.h"

#include <stddef.h>

#define SIGNATURE_SAVE 0x65766173U /* "save" */
#define SIGNATURE_LOAD 0x64616F6CU /* "load" */

/* The four sets lie one behind the other in each kind of object, in the order of tumble_which_set_t. */
#define WHICH_BITS 3U

/* The readable side. */

static uint32_t up_to_32_bits(uint64_t value)
{
    return (value < UINT32_MAX) ? (uint32_t)value : UINT32_MAX;
}

static uint16_t inhibit_left_s(const tumble_keeper_t *keeper)
{
    const uint64_t left_us = (keeper->inhibit_us > keeper->now_us) ? (keeper->inhibit_us - keeper->now_us) : 0U;
    const uint64_t left_s = tumble_keeper_whole_s(left_us + (TUMBLE_US_PER_S - 1U));
    return (uint16_t)((left_s < UINT16_MAX) ? left_s : UINT16_MAX); /* a moment more, if told since the last step */
}

static uint32_t due_in_s(const tumble_keeper_t *keeper)
{
    const uint64_t age_s = tumble_keeper_age_s(keeper);
    const uint64_t interval_s = keeper->settings.interval_s;
    return (keeper->has_active && (age_s < interval_s)) ? (uint32_t)(interval_s - age_s) : 0U;
}

TUMBLE_ONE_COPY void tumble_keeper_state(const tumble_keeper_t *keeper, tumble_sets_state_t *state)
{
    state->utc_s = tumble_keeper_utc_s(keeper);
    state->counter = keeper->sequence;
    state->age_s = keeper->has_active ? up_to_32_bits(tumble_keeper_age_s(keeper)) : 0U;
    state->due_in_s = due_in_s(keeper);
    state->inhibit_s = inhibit_left_s(keeper);
    state->objections = (uint16_t)keeper->objections;
    state->more_objections = (uint16_t)(keeper->objections >> TUMBLE_OBJECTION_MORE);
    state->verdict = keeper->verdict;
    state->status = keeper->status;
    state->due = tumble_keeper_due(keeper);
    state->resumable = tumble_keeper_is_idle(keeper) ? keeper->resumable : 0U;
    state->inhibited = tumble_keeper_is_inhibited(keeper);
    state->busy = tumble_keeper_has_work(keeper);
    state->has_proposal = tumble_store_has(&keeper->store, TUMBLE_SET_PROPOSAL);
    state->has_factory = tumble_store_has(&keeper->store, TUMBLE_SET_FACTORY);
}

tumble_status_t tumble_keeper_uncertainty(const tumble_keeper_t *keeper, const tumble_uncertainty_t **uncertainty)
{
    if (keeper->run_was_on || (keeper->task == (uint8_t)TASK_UNCERTAINTY)) {
        return TUMBLE_E_PORT_BUSY;
    }
    *uncertainty = &keeper->set.uncertainty;
    return ((keeper->set.flags & TUMBLE_SET_HAS_UNCERTAINTY) != 0U) ? TUMBLE_OK : TUMBLE_E_STATE;
}

tumble_status_t tumble_keeper_whole_model(const tumble_keeper_t *keeper, const tumble_whole_work_t **found)
{
    if (keeper->run_was_on || tumble_keeper_is_assessing(keeper)) {
        return TUMBLE_E_PORT_BUSY;
    }
    *found = keeper->config->sets.whole_work;
    return ((*found != NULL) && (*found)->known) ? TUMBLE_OK : TUMBLE_E_STATE;
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
        if (counts) { /* one without a date or an uncertainty is refused */
            (void)tumble_trend_add(&sums, entry.date_utc_s, (double)entry.value[coefficient],
                                   (double)entry.u[coefficient]);
        }
    }
    return tumble_trend_fit(&sums, trend);
}

/* The objects. */

/* The SDO abort code for what a read of the memory returned. */
static tumble_abort_t refusal_of(tumble_status_t status)
{
    tumble_abort_t refusal = TUMBLE_ABORT_HARDWARE;
    if (status == TUMBLE_OK) {
        refusal = TUMBLE_ABORT_NONE;
    } else if (status == TUMBLE_E_PORT_BUSY) {
        refusal = TUMBLE_ABORT_DEVICE_STATE;
    } else if ((status == TUMBLE_E_STATE) || (status == TUMBLE_E_TOO_FEW) || (status == TUMBLE_E_ARGUMENT)) {
        refusal = TUMBLE_ABORT_NO_DATA;
    } else {
        /* it failed */
    }
    return refusal;
}

/* The sets. */

static tumble_abort_t read_set(tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    tumble_set_t set;
    const tumble_abort_t refusal =
        refusal_of(tumble_store_read(&keeper->store, (tumble_which_set_t)(entry->index & WHICH_BITS), &set));
    if (refusal != TUMBLE_ABORT_NONE) {
        return refusal;
    }
    return tumble_set_knows(&set, entry->offset) ? tumble_show_member(&set, entry, bytes, size) : TUMBLE_ABORT_NO_DATA;
}

/* The present result. Its uncertainties, and how it fits, were computed once, when the run ended. */

static tumble_abort_t read_result(const tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes,
                                  uint8_t *size)
{
    tumble_result_t result;
    const tumble_uncertainty_t *uncertainty = NULL;
    const tumble_whole_work_t *fit = NULL;
    if (tumble_navcomp_result(keeper->navcomp, &result) != TUMBLE_OK) {
        return TUMBLE_ABORT_NO_DATA;
    }
    const bool of_fit = (entry->source == (unsigned)TUMBLE_KEEPER_SOURCE_FIT);
    const tumble_abort_t refusal =
        refusal_of(of_fit ? tumble_keeper_whole_model(keeper, &fit) : tumble_keeper_uncertainty(keeper, &uncertainty));
    if (refusal != TUMBLE_ABORT_NONE) {
        return refusal;
    }
    return of_fit ? tumble_show_member(fit, entry, bytes, size) : tumble_show_member(uncertainty, entry, bytes, size);
}

static tumble_abort_t read_noise(const tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes,
                                 uint8_t *size)
{
    const tumble_noise_t *noise = NULL;
    const tumble_uncertainty_t *uncertainty = NULL;
    const tumble_status_t status = tumble_navcomp_noise(keeper->navcomp, &noise);
    if (status == TUMBLE_OK) {
        return tumble_show_member(noise, entry, bytes, size);
    }
    const bool comes =
        (status == TUMBLE_E_PORT_BUSY) && (tumble_keeper_uncertainty(keeper, &uncertainty) == TUMBLE_E_PORT_BUSY);
    return comes ? TUMBLE_ABORT_DEVICE_STATE : TUMBLE_ABORT_NO_DATA;
}

/* `known`: flags of the pairs of a quantity and its uncertainty; null: of none. */
static tumble_abort_t member_of_view(const void *view, const bool *known, const tumble_entry_t *entry, uint8_t *bytes,
                                     uint8_t *size)
{
    const bool is_there = (known != NULL) && known[(entry->subindex - 1U) / 2U];
    return is_there ? tumble_show_member(view, entry, bytes, size) : TUMBLE_ABORT_NO_DATA;
}

static tumble_abort_t read_stand(const tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes,
                                 uint8_t *size)
{
    const tumble_keeper_config_t *config = keeper->config;
    const tumble_stand_view_t *view =
        (config->stand_view != NULL) ? config->stand_view(keeper->navcomp, config->stand_memory) : NULL;
    return member_of_view(view, (view != NULL) ? view->known : NULL, entry, bytes, size);
}

static tumble_abort_t read_inclinations(const tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes,
                                        uint8_t *size)
{
    const tumble_keeper_config_t *config = keeper->config;
    const tumble_inclinations_view_t *view =
        (config->inclinations_view != NULL) ? config->inclinations_view(keeper->navcomp, config->inclinations_memory)
                                            : NULL;
    return member_of_view(view, (view != NULL) ? view->known : NULL, entry, bytes, size);
}

/* False: there is no such position. */
static bool look_up(const tumble_keeper_t *keeper, tumble_position_view_t *view)
{
    const tumble_schedule_t *schedule = keeper->navcomp->procedure_config.schedule;
    *view = (tumble_position_view_t){.index = keeper->shown_position, .count = schedule->position_count};
    if (view->index >= view->count) {
        return false;
    }
    const tumble_position_t *position = &schedule->positions[view->index];
    view->mounting = position->mounting;
    view->number = position->number;
    view->use = (uint8_t)position->use;
    view->angle_deg = position->angle.deg;
    return true;
}

static bool look_up_mean(const tumble_keeper_t *keeper, tumble_position_view_t *view)
{
    const tumble_averaging_t *averaging = tumble_procedure_averages(&keeper->navcomp->procedure);
    const double v_per_count = keeper->navcomp->procedure_config.v_per_count;
    if (tumble_averaging_mean(averaging, view->index, view->mean_v, view->standard_error_v) != TUMBLE_OK) {
        return false;
    }
    view->samples = averaging->averages[view->index].samples;
    for (int c = 0; c < TUMBLE_CHANNELS; c++) {
        view->mean_v[c] *= v_per_count;
        view->standard_error_v[c] *= tumble_abs(v_per_count);
    }
    return true;
}

static tumble_abort_t read_position(const tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes,
                                    uint8_t *size)
{
    tumble_position_view_t view;
    const bool always = (entry->source == (unsigned)TUMBLE_KEEPER_SOURCE_SHOWN_POSITION) ||
                        (entry->source == (unsigned)TUMBLE_KEEPER_SOURCE_POSITIONS);
    bool there = look_up(keeper, &view);
    if (entry->source == (unsigned)TUMBLE_KEEPER_SOURCE_POSITION) {
        there = there && look_up_mean(keeper, &view);
    }
    return (there || always) ? tumble_show_member(&view, entry, bytes, size) : TUMBLE_ABORT_NO_DATA;
}

static tumble_abort_t read_at_rest(const tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes,
                                   uint8_t *size)
{
    tumble_at_rest_view_t view;
    const double v_per_count = keeper->navcomp->procedure_config.v_per_count;
    const bool told = (tumble_at_rest_view(&keeper->at_rest, v_per_count, &view) == TUMBLE_OK);
    return (told || (entry->source == (unsigned)TUMBLE_KEEPER_SOURCE_AT_REST_COUNT))
               ? tumble_show_member(&view, entry, bytes, size)
               : TUMBLE_ABORT_NO_DATA;
}

/* What was. */

static tumble_abort_t read_history(tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    tumble_history_entry_t seen;
    const tumble_abort_t refusal = refusal_of(tumble_history_read(&keeper->history, keeper->shown_entry, &seen));
    if (refusal != TUMBLE_ABORT_NONE) {
        return refusal;
    }
    const bool uncertain = (entry->source == (unsigned)TUMBLE_KEEPER_SOURCE_HISTORY_U);
    const bool warm = (entry->offset == offsetof(tumble_history_entry_t, temperature_c));
    if ((uncertain && ((seen.flags & TUMBLE_SET_HAS_UNCERTAINTY) == 0U)) ||
        (warm && ((seen.flags & TUMBLE_SET_HAS_TEMPERATURE) == 0U))) {
        return TUMBLE_ABORT_NO_DATA;
    }
    return tumble_show_member(&seen, entry, bytes, size);
}

static tumble_abort_t read_trend(tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes)
{
    tumble_trend_t trend;
    const tumble_abort_t refusal = refusal_of(tumble_keeper_trend(keeper, (uint8_t)(entry->subindex - 1U), &trend));
    if (refusal == TUMBLE_ABORT_NONE) {
        tumble_put_f64(bytes,
                       (entry->source == (unsigned)TUMBLE_KEEPER_SOURCE_TREND) ? trend.per_month : trend.u_per_month);
    }
    return refusal;
}

/* What is told, and what may be changed. */

static tumble_abort_t read_state(const tumble_keeper_t *keeper, const tumble_entry_t *entry, uint8_t *bytes,
                                 uint8_t *size)
{
    tumble_sets_state_t state;
    tumble_keeper_state(keeper, &state);
    return tumble_show_member(&state, entry, bytes, size);
}

static tumble_abort_t read(void *context, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    const tumble_navcomp_t *navcomp = context;
    tumble_keeper_t *keeper = navcomp->config->keeper;
    switch ((tumble_keeper_source_t)entry->source) {
    case TUMBLE_KEEPER_SOURCE_SAVE:
    case TUMBLE_KEEPER_SOURCE_LOAD:
        tumble_put_u32(bytes, tumble_parameters_room(&keeper->parameters) ? 1U : 0U);
        return TUMBLE_ABORT_NONE;
    case TUMBLE_KEEPER_SOURCE_UNCERTAINTY:
    case TUMBLE_KEEPER_SOURCE_FIT:
        return read_result(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_NOISE:
        return read_noise(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_SET:
        return read_set(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_STATE:
    case TUMBLE_KEEPER_SOURCE_CALENDAR:
    case TUMBLE_KEEPER_SOURCE_INHIBIT:
        return read_state(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_SETTINGS:
        return tumble_show_member(&keeper->settings, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_COUNTERS:
        return tumble_show_member(&keeper->counters, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_STORES:
        return tumble_show_member(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_STAND:
        return read_stand(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_INCLINATIONS:
        return read_inclinations(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_SHOWN_POSITION:
    case TUMBLE_KEEPER_SOURCE_POSITION:
    case TUMBLE_KEEPER_SOURCE_POSITIONS:
    case TUMBLE_KEEPER_SOURCE_SCHEDULE:
        return read_position(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_AT_REST_COUNT:
    case TUMBLE_KEEPER_SOURCE_AT_REST:
        return read_at_rest(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_SHOWN_ENTRY:
        bytes[0] = keeper->shown_entry;
        return TUMBLE_ABORT_NONE;
    case TUMBLE_KEEPER_SOURCE_ENTRIES:
        bytes[0] = tumble_history_count(&keeper->history);
        return TUMBLE_ABORT_NONE;
    case TUMBLE_KEEPER_SOURCE_HISTORY:
    case TUMBLE_KEEPER_SOURCE_HISTORY_U:
        return read_history(keeper, entry, bytes, size);
    case TUMBLE_KEEPER_SOURCE_TREND:
    case TUMBLE_KEEPER_SOURCE_TREND_U:
        return read_trend(keeper, entry, bytes);
    case TUMBLE_KEEPER_SOURCE_PARAMETERS:
        return tumble_show_member(&keeper->parameters.view, entry, bytes, size);
    default: /* a source that has come into the table without a case here */
        return TUMBLE_ABORT_GENERAL;
    }
}

/* Writing. Types, lengths and limits have been checked. */

/* The settings are taken or refused as a whole. */
static tumble_abort_t write_setting(tumble_keeper_t *keeper, const tumble_entry_t *entry, const uint8_t *bytes,
                                    uint8_t size)
{
    tumble_sets_settings_t settings;
    settings = keeper->settings;
    tumble_dictionary_unpack(entry, (uint8_t *)&settings + entry->offset, bytes, size);
    const tumble_status_t status = tumble_keeper_change(keeper, &settings);
    if (status == TUMBLE_E_STATE) {
        return TUMBLE_ABORT_DEVICE_STATE;
    }
    return (status == TUMBLE_OK) ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_VALUE;
}

static tumble_abort_t write_calendar(tumble_keeper_t *keeper, uint64_t utc_s)
{
    return (tumble_keeper_set_utc(keeper, utc_s) == TUMBLE_OK) ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_VALUE;
}

static tumble_abort_t write_at_rest(tumble_keeper_t *keeper, uint16_t wanted)
{
    if (tumble_run_is_on(keeper->navcomp)) {
        return TUMBLE_ABORT_DEVICE_STATE;
    }
    return (tumble_at_rest_begin(&keeper->at_rest, wanted) == TUMBLE_OK) ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_VALUE;
}

static tumble_abort_t write_parameters(tumble_keeper_t *keeper, const tumble_entry_t *entry, uint32_t signature)
{
    const bool save = (entry->source == (unsigned)TUMBLE_KEEPER_SOURCE_SAVE);
    tumble_abort_t refusal;
    if (signature != (save ? SIGNATURE_SAVE : SIGNATURE_LOAD)) {
        refusal = TUMBLE_ABORT_STORE;
    } else if (!tumble_parameters_room(&keeper->parameters)) {
        refusal = TUMBLE_ABORT_HARDWARE;
    } else if (tumble_keeper_busy(keeper) || tumble_run_is_on(keeper->navcomp)) {
        refusal = TUMBLE_ABORT_DEVICE_STATE;
    } else {
        keeper->rules_written = save ? tumble_keeper_rules(keeper) : tumble_keeper_rules_of_board(keeper);
        refusal = save ? tumble_parameters_save(&keeper->parameters) : tumble_parameters_forget(&keeper->parameters);
    }
    return refusal;
}

static tumble_abort_t write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    const tumble_navcomp_t *navcomp = context;
    tumble_keeper_t *keeper = navcomp->config->keeper;
    switch ((tumble_keeper_source_t)entry->source) {
    case TUMBLE_KEEPER_SOURCE_SAVE:
    case TUMBLE_KEEPER_SOURCE_LOAD:
        return write_parameters(keeper, entry, tumble_get_u32(bytes));
    case TUMBLE_KEEPER_SOURCE_CALENDAR:
        return write_calendar(keeper, tumble_get_u64(bytes));
    case TUMBLE_KEEPER_SOURCE_INHIBIT:
        tumble_keeper_inhibit(keeper, tumble_get_u16(bytes));
        return TUMBLE_ABORT_NONE;
    case TUMBLE_KEEPER_SOURCE_SHOWN_POSITION:
        keeper->shown_position = bytes[0];
        return TUMBLE_ABORT_NONE;
    case TUMBLE_KEEPER_SOURCE_AT_REST_COUNT: /* of these the one wanted */
        return write_at_rest(keeper, tumble_get_u16(bytes));
    case TUMBLE_KEEPER_SOURCE_SHOWN_ENTRY:
        keeper->shown_entry = bytes[0];
        return TUMBLE_ABORT_NONE;
    default: /* nothing else can be written */
        return write_setting(keeper, entry, bytes, size);
    }
}

const tumble_object_hooks_t tumble_keeper_object_hooks = {.read = read, .write = write};

const tumble_node_extension_t tumble_keeper_extension = {
    .objects = {.table = &tumble_keeper_table, .hooks = &tumble_keeper_object_hooks},
    .transmit = tumble_keeper_transmit,
    .first_transmit = TUMBLE_KEEPER_FIRST_TRANSMIT,
    .transmit_count = TUMBLE_KEEPER_TRANSMIT,
};
