#include "navcomp/navcomp_internal.h"

#include "core/bytes.h"

#include <stddef.h>

/* Subindices that are more than a member of a struct. */
#define COMMAND_COMMAND 2U
#define GRAVITY_LIMIT 3U
#define SERVICE_LEVEL 2U
#define CONFIGURATION_ESTIMATE 2U /* an enum, and a byte on the bus */
#define RUN_OF_RESULT 2U
#define RUN_OF_MEAN 3U

/* Reading. An entry's offset is the place of its member in the struct that the object stands for. */

static tumble_abort_t member(const void *structure, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    tumble_dictionary_pack(entry, (const uint8_t *)structure + entry->offset, bytes, size);
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t one_byte(unsigned value, uint8_t *bytes)
{
    bytes[0] = (uint8_t)value;
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t read_progress(const tumble_navcomp_t *navcomp, const tumble_entry_t *entry, uint8_t *bytes,
                                    uint8_t *size)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(navcomp, &progress);
    const bool mean =
        (entry->index == TUMBLE_NAVCOMP_INDEX_RUNNING_MEAN) || (entry->index == TUMBLE_NAVCOMP_INDEX_STANDARD_ERROR);
    if (mean && !progress.has_mean) {
        return TUMBLE_ABORT_NO_DATA;
    }
    return member(&progress, entry, bytes, size);
}

static tumble_abort_t read_result(const tumble_navcomp_t *navcomp, const tumble_entry_t *entry, uint8_t *bytes,
                                  uint8_t *size)
{
    tumble_result_t result;
    if (tumble_navcomp_result(navcomp, &result) != TUMBLE_OK) {
        return TUMBLE_ABORT_NO_DATA;
    }
    if (entry->index != TUMBLE_NAVCOMP_INDEX_GRAVITY_CHECK) {
        return member(result.coefficients, entry, bytes, size);
    }
    return (entry->subindex == GRAVITY_LIMIT) ? member(&navcomp->procedure_config, entry, bytes, size)
                                              : member(result.check, entry, bytes, size);
}

static tumble_abort_t read_configuration(const tumble_navcomp_t *navcomp, const tumble_entry_t *entry, uint8_t *bytes,
                                         uint8_t *size)
{
    if (entry->subindex == CONFIGURATION_ESTIMATE) {
        return one_byte((unsigned)navcomp->procedure_config.estimate, bytes);
    }
    return member(&navcomp->procedure_config, entry, bytes, size);
}

static tumble_abort_t read_counters(const tumble_navcomp_t *navcomp, const tumble_entry_t *entry, uint8_t *bytes,
                                    uint8_t *size)
{
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(navcomp, &counters);
    return member(&counters, entry, bytes, size);
}

static tumble_abort_t read_service(const tumble_navcomp_t *navcomp, uint8_t subindex, uint8_t *bytes)
{
    if (subindex == SERVICE_LEVEL) {
        return one_byte(tumble_service_is_open(navcomp) ? 1U : 0U, bytes);
    }
    tumble_put_u16(bytes, tumble_service_left_s(navcomp));
    return TUMBLE_ABORT_NONE;
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
static tumble_abort_t read_run(const tumble_navcomp_t *navcomp, uint8_t subindex, uint8_t *bytes)
{
    bool is_there = true;
    if (subindex == RUN_OF_RESULT) {
        is_there = has_result(navcomp);
    } else if (subindex == RUN_OF_MEAN) {
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
    tumble_abort_t refusal;
    switch (entry->index) {
    case TUMBLE_NAVCOMP_INDEX_STATE:
    case TUMBLE_NAVCOMP_INDEX_REASON:
    case TUMBLE_NAVCOMP_INDEX_PROGRESS:
    case TUMBLE_NAVCOMP_INDEX_FAILURE:
    case TUMBLE_NAVCOMP_INDEX_RUNNING_MEAN:
    case TUMBLE_NAVCOMP_INDEX_STANDARD_ERROR:
        refusal = read_progress(navcomp, entry, bytes, size);
        break;
    case TUMBLE_NAVCOMP_INDEX_K:
    case TUMBLE_NAVCOMP_INDEX_U0:
    case TUMBLE_NAVCOMP_INDEX_GRAVITY_CHECK:
        refusal = read_result(navcomp, entry, bytes, size);
        break;
    case TUMBLE_NAVCOMP_INDEX_CONFIGURATION:
        refusal = read_configuration(navcomp, entry, bytes, size);
        break;
    case TUMBLE_NAVCOMP_INDEX_SERVICE_LEVEL:
        refusal = read_service(navcomp, entry->subindex, bytes);
        break;
    case TUMBLE_NAVCOMP_INDEX_RUN_NUMBER:
        tumble_put_u32(bytes, tumble_service_runs(navcomp));
        refusal = TUMBLE_ABORT_NONE;
        break;
    case TUMBLE_NAVCOMP_INDEX_RUN:
        refusal = read_run(navcomp, entry->subindex, bytes);
        break;
    case TUMBLE_NAVCOMP_INDEX_BUS_COUNTERS:
    case TUMBLE_NAVCOMP_INDEX_NODE_COUNTERS:
    case TUMBLE_NAVCOMP_INDEX_BLOCK_COUNTERS:
    case TUMBLE_NAVCOMP_INDEX_AVERAGING_COUNTERS:
    case TUMBLE_NAVCOMP_INDEX_PROCEDURE_COUNTERS:
    case TUMBLE_NAVCOMP_INDEX_STOP_COUNTERS:
        refusal = read_counters(navcomp, entry, bytes, size);
        break;
    default: /* Refuse an object that has come into the table without a case here: it is not the counters. */
        refusal = TUMBLE_ABORT_GENERAL;
        break;
    }
    return refusal;
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
    if (entry->subindex == CONFIGURATION_ESTIMATE) {
        config->estimate = (tumble_estimate_t)bytes[0];
    } else {
        tumble_dictionary_unpack(entry, (uint8_t *)config + entry->offset, bytes, size);
    }
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    tumble_navcomp_t *navcomp = context;
    if ((entry->index == TUMBLE_NAVCOMP_INDEX_COMMAND) && (entry->subindex == COMMAND_COMMAND)) {
        return write_command(navcomp, bytes[0]);
    }
    if (entry->index == TUMBLE_NAVCOMP_INDEX_SERVICE_LEVEL) {
        return refusal_of(tumble_service_unlock(navcomp, tumble_get_u32(bytes)));
    }
    if (entry->index == TUMBLE_NAVCOMP_INDEX_CONFIGURATION) {
        return write_configuration(navcomp, entry, bytes, size);
    }
    return TUMBLE_ABORT_NONE; /* variables of the dictionary: the arguments, and what the drive's PDOs write */
}

const tumble_object_hooks_t tumble_navcomp_object_hooks = {.read = read, .write = write};
