#include "navcomp/navcomp_internal.h"

#include "core/bytes.h"

#include <stddef.h>

/* Reading. */

tumble_abort_t tumble_show_member(const void *structure, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    tumble_dictionary_pack(entry, (const uint8_t *)structure + entry->offset, bytes, size);
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t read_progress(const tumble_navcomp_t *navcomp, const tumble_entry_t *entry, uint8_t *bytes,
                                    uint8_t *size)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(navcomp, &progress);
    if ((entry->source == (unsigned)TUMBLE_NAVCOMP_SOURCE_MEAN) && !progress.has_mean) {
        return TUMBLE_ABORT_NO_DATA;
    }
    return tumble_show_member(&progress, entry, bytes, size);
}

static tumble_abort_t read_result(const tumble_navcomp_t *navcomp, const tumble_entry_t *entry, uint8_t *bytes,
                                  uint8_t *size)
{
    tumble_result_t result;
    if (tumble_navcomp_result(navcomp, &result) != TUMBLE_OK) {
        return TUMBLE_ABORT_NO_DATA;
    }
    const void *structure = result.coefficients;
    if (entry->source == (unsigned)TUMBLE_NAVCOMP_SOURCE_CHECK) {
        structure = result.check;
    } else if (entry->source == (unsigned)TUMBLE_NAVCOMP_SOURCE_LIMIT) {
        structure = &navcomp->procedure_config;
    } else {
        /* the coefficients */
    }
    return tumble_show_member(structure, entry, bytes, size);
}

static tumble_abort_t read_counters(const tumble_navcomp_t *navcomp, const tumble_entry_t *entry, uint8_t *bytes,
                                    uint8_t *size)
{
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(navcomp, &counters);
    return tumble_show_member(&counters, entry, bytes, size);
}

static bool has_result(const tumble_navcomp_t *navcomp)
{
    tumble_result_t result;
    return tumble_navcomp_result(navcomp, &result) == TUMBLE_OK;
}

static bool has_mean(const tumble_navcomp_t *navcomp)
{
    double mean_v[TUMBLE_CHANNELS];
    double standard_error_v[TUMBLE_CHANNELS];
    return tumble_procedure_running(&navcomp->procedure, mean_v, standard_error_v) == TUMBLE_OK;
}

/* The same run all the time, but only of what there is. */
static tumble_abort_t read_run(const tumble_navcomp_t *navcomp, const tumble_entry_t *entry, uint8_t *bytes)
{
    bool is_there = true;
    if (entry->source == (unsigned)TUMBLE_NAVCOMP_SOURCE_RUN_OF_RESULT) {
        is_there = has_result(navcomp);
    } else if (entry->source == (unsigned)TUMBLE_NAVCOMP_SOURCE_RUN_OF_MEAN) {
        is_there = has_mean(navcomp);
    } else {
        /* there is always a state */
    }
    tumble_put_u32(bytes, tumble_service_runs(navcomp));
    return is_there ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_NO_DATA;
}

static tumble_abort_t read(void *context, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    const tumble_navcomp_t *navcomp = context;
    switch ((tumble_navcomp_source_t)entry->source) {
    case TUMBLE_NAVCOMP_SOURCE_PROGRESS:
    case TUMBLE_NAVCOMP_SOURCE_MEAN:
        return read_progress(navcomp, entry, bytes, size);
    case TUMBLE_NAVCOMP_SOURCE_COEFFICIENTS:
    case TUMBLE_NAVCOMP_SOURCE_CHECK:
    case TUMBLE_NAVCOMP_SOURCE_LIMIT:
        return read_result(navcomp, entry, bytes, size);
    case TUMBLE_NAVCOMP_SOURCE_CONFIGURATION:
        return tumble_show_member(&navcomp->procedure_config, entry, bytes, size);
    case TUMBLE_NAVCOMP_SOURCE_ESTIMATOR:
        bytes[0] = (uint8_t)navcomp->procedure_config.estimate;
        return TUMBLE_ABORT_NONE;
    case TUMBLE_NAVCOMP_SOURCE_COUNTERS:
        return read_counters(navcomp, entry, bytes, size);
    case TUMBLE_NAVCOMP_SOURCE_SERVICE_LEVEL:
        bytes[0] = tumble_service_is_open(navcomp) ? 1U : 0U;
        return TUMBLE_ABORT_NONE;
    case TUMBLE_NAVCOMP_SOURCE_SERVICE_LEFT:
        tumble_put_u16(bytes, tumble_service_left_s(navcomp));
        return TUMBLE_ABORT_NONE;
    case TUMBLE_NAVCOMP_SOURCE_RUN:
    case TUMBLE_NAVCOMP_SOURCE_RUN_OF_RESULT:
    case TUMBLE_NAVCOMP_SOURCE_RUN_OF_MEAN:
        return read_run(navcomp, entry, bytes);
    case TUMBLE_NAVCOMP_SOURCE_COMMAND:
    case TUMBLE_NAVCOMP_SOURCE_SERVICE_KEY:
    default: /* written only; or a source that has come into the table without a case here */
        return TUMBLE_ABORT_GENERAL;
    }
}

/* Writing. Types, lengths and limits have been checked. */

static tumble_abort_t refusal_of(tumble_status_t status)
{
    if (status == TUMBLE_E_STATE) {
        return TUMBLE_ABORT_DEVICE_STATE;
    }
    return (status == TUMBLE_OK) ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_VALUE;
}

static tumble_abort_t write_command(tumble_navcomp_t *navcomp, uint8_t command)
{
    return refusal_of(
        tumble_navcomp_command(navcomp, (tumble_command_t)command, tumble_staged(navcomp)->command_argument));
}

/* Between runs only: the means of one run are taken in one way. */
static tumble_abort_t write_configuration(tumble_navcomp_t *navcomp, const tumble_entry_t *entry, const uint8_t *bytes,
                                          uint8_t size)
{
    tumble_procedure_config_t *config = &navcomp->procedure_config;
    if (tumble_run_is_on(navcomp)) {
        return TUMBLE_ABORT_DEVICE_STATE;
    }
    if (entry->source == (unsigned)TUMBLE_NAVCOMP_SOURCE_ESTIMATOR) {
        config->estimate = (tumble_estimate_t)bytes[0];
    } else {
        tumble_dictionary_unpack(entry, (uint8_t *)config + entry->offset, bytes, size);
    }
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    tumble_navcomp_t *navcomp = context;
    if (entry->home != TUMBLE_HOME_COMPUTED) {
        return TUMBLE_ABORT_NONE; /* variables of the dictionary: the arguments, and what the drive's PDOs write */
    }
    switch ((tumble_navcomp_source_t)entry->source) {
    case TUMBLE_NAVCOMP_SOURCE_COMMAND:
        return write_command(navcomp, bytes[0]);
    case TUMBLE_NAVCOMP_SOURCE_SERVICE_KEY:
        return refusal_of(tumble_service_unlock(navcomp, tumble_get_u32(bytes)));
    default: /* nothing else can be written */
        return write_configuration(navcomp, entry, bytes, size);
    }
}

const tumble_object_hooks_t tumble_navcomp_object_hooks = {.read = read, .write = write};
