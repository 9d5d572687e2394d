/* procedure_refusal.c - what goes wrong in a run, and whether trying again may help. */
#include "procedure/procedure_internal.h"

#include <stddef.h>

outcome_t tumble_fail(tumble_procedure_t *procedure, tumble_reason_t reason)
{
    procedure->reason = reason;
    return OUTCOME_FAULT;
}

tumble_reason_t tumble_stand_reason(const tumble_procedure_t *procedure)
{
    static const uint8_t reasons[TUMBLE_STAND_FAULT_SCALE + 1] = {
        [TUMBLE_STAND_FAULT_NONE] = TUMBLE_REASON_DRIVE_FAULT,
        [TUMBLE_STAND_FAULT_DRIVE] = TUMBLE_REASON_DRIVE_FAULT,
        [TUMBLE_STAND_FAULT_STALL] = TUMBLE_REASON_STALL,
        [TUMBLE_STAND_FAULT_HEARTBEAT] = TUMBLE_REASON_STAND_HEARTBEAT,
        [TUMBLE_STAND_FAULT_HOMING] = TUMBLE_REASON_HOMING,
        [TUMBLE_STAND_FAULT_PROTOCOL] = TUMBLE_REASON_STAND_PROTOCOL,
        [TUMBLE_STAND_FAULT_POWER] = TUMBLE_REASON_DRIVE_POWER,
        [TUMBLE_STAND_FAULT_TIMEOUT] = TUMBLE_REASON_TARGET_NOT_REACHED,
        [TUMBLE_STAND_FAULT_STOP] = TUMBLE_REASON_STOP_NOT_CONFIRMED,
        [TUMBLE_STAND_FAULT_POSITION] = TUMBLE_REASON_SLIP,
        [TUMBLE_STAND_FAULT_FOREIGN] = TUMBLE_REASON_FOREIGN_COMMAND,
        [TUMBLE_STAND_FAULT_RUNAWAY] = TUMBLE_REASON_RUNAWAY,
        [TUMBLE_STAND_FAULT_SCALE] = TUMBLE_REASON_SCALE,
    };
    const unsigned fault = (unsigned)tumble_stand_fault(&procedure->stand);
    return (fault < sizeof reasons) ? (tumble_reason_t)reasons[fault] : TUMBLE_REASON_DRIVE_FAULT;
}

/* What a refusal of a position means, and whether measuring it again may help. The last row stands for any other. */
typedef struct {
    uint8_t status;
    uint8_t reason;
    bool mendable;
} refusal_row_t;

#define REFUSAL(status, reason, mendable) {(uint8_t)TUMBLE_E_##status, (uint8_t)TUMBLE_REASON_##reason, (mendable)}

outcome_t tumble_refuse_position(tumble_procedure_t *procedure, tumble_status_t status)
{
    static const refusal_row_t refusals[] = {
        REFUSAL(LOST, SAMPLES_LOST, true),     REFUSAL(TOO_FEW, SAMPLES_LOST, true),
        REFUSAL(CRC, SAMPLES_CORRUPTED, true), REFUSAL(NOT_STILL, NOT_STILL, true),
        REFUSAL(DEVIATION, NOT_STILL, true),   REFUSAL(SATURATED, SATURATED, false),
        REFUSAL(UNCERTAIN, UNCERTAIN, true),   REFUSAL(STUCK, STUCK, false),
    };
    const size_t last = (sizeof refusals / sizeof refusals[0]) - 1U;
    size_t row = 0;
    while ((row < last) && (refusals[row].status != (uint8_t)status)) {
        row++;
    }
    procedure->status = status;
    tumble_count(&procedure->counters.refused);
    if (refusals[row].mendable && (procedure->attempt < procedure->config->retries)) {
        procedure->attempt++;
        tumble_count(&procedure->counters.retries);
        return OUTCOME_OTHER;
    }
    return tumble_fail(procedure, (tumble_reason_t)refusals[row].reason);
}
