#include "procedure/procedure_internal.h"

/* Before the first one: nothing is measured. */
static tumble_status_t begin(tumble_procedure_t *procedure)
{
    if (procedure->begun) {
        return TUMBLE_OK;
    }
    const tumble_status_t status = tumble_averaging_init(&procedure->averaging, procedure->config->averaging);
    procedure->begun = (status == TUMBLE_OK);
    return status;
}

tumble_status_t tumble_procedure_restore(tumble_procedure_t *procedure, uint8_t index, const tumble_average_t *average)
{
    if (procedure->state != TUMBLE_STATE_IDLE) {
        return TUMBLE_E_STATE;
    }
    if (index >= procedure->config->schedule->position_count) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_status_t status = begin(procedure);
    if (status == TUMBLE_OK) {
        status = tumble_averaging_restore(&procedure->averaging, procedure->config->averaging, index, average);
    }
    if (status != TUMBLE_OK) {
        return status;
    }
    if ((tumble_check_direction(procedure, index) != TUMBLE_REASON_NONE) ||
        (tumble_check_closure(procedure, index) != TUMBLE_REASON_NONE)) {
        tumble_forget_position(procedure, index);
        return TUMBLE_E_ARGUMENT;
    }
    procedure->restored = true;
    return TUMBLE_OK;
}
