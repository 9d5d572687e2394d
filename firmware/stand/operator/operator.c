#include "stand/operator/operator.h"

#include "core/arith.h"

#include <stddef.h>

#define US_PER_MS 1000U

static tumble_status_t operator_init(void *self, const tumble_stand_setup_t *setup)
{
    tumble_operator_t *operator = self;
    const tumble_operator_config_t *config = setup->profile;
    if ((config == NULL) || !(config->tolerance_deg >= 0.0) || !tumble_is_finite(config->tolerance_deg) ||
        (config->timeout_ms == 0U)) {
        return TUMBLE_E_ARGUMENT;
    }
    *operator = (tumble_operator_t){.config = config, .state = (uint8_t)TUMBLE_STAND_READY};
    return TUMBLE_OK;
}

static uint64_t deadline_us(const tumble_operator_t *operator)
{
    return operator->asked_us + ((uint64_t)operator->config->timeout_ms * US_PER_MS);
}

static void leave_request(tumble_operator_t *operator, tumble_stand_state_t state)
{
    operator->report.asks = false;
    operator->state = (uint8_t)state;
}

/* Nobody has said at what angle it is: take the higher one, so that the next angle is reached from below. */
static void withdraw_request(tumble_operator_t *operator, tumble_stand_state_t state)
{
    if (operator->report.asks) {
        operator->angle_deg = tumble_exceeds(operator->report.asked_deg, operator->angle_deg)
                                  ? operator->report.asked_deg
                                  : operator->angle_deg;
    }
    leave_request(operator, state);
}

static void operator_step(void *self, uint64_t now_us)
{
    tumble_operator_t *operator = self;
    if (operator->restart_timer) {
        operator->restart_timer = false;
        operator->asked_us = now_us;
    }
    if (operator->report.asks && (now_us >= deadline_us(operator))) {
        withdraw_request(operator, TUMBLE_STAND_FAULT);
    }
}

static uint64_t operator_next_us(const void *self)
{
    const tumble_operator_t *operator = self;
    if (!operator->report.asks) {
        return UINT64_MAX;
    }
    return operator->restart_timer ? 0U : deadline_us(operator);
}

static tumble_status_t confirm(void *self, double angle_deg)
{
    tumble_operator_t *operator = self;
    if (!tumble_within(angle_deg - operator->report.asked_deg, operator->config->tolerance_deg)) {
        return TUMBLE_E_ARGUMENT;
    }
    operator->homed = true;
    operator->angle_deg = angle_deg;
    leave_request(operator, TUMBLE_STAND_IN_POSITION);
    return TUMBLE_OK;
}

static tumble_status_t ask(tumble_operator_t *operator, double angle_deg, tumble_stand_state_t state)
{
    if (operator->report.asks || (operator->state == (uint8_t)TUMBLE_STAND_FAULT)) {
        return TUMBLE_E_STAND_STATE;
    }
    operator->report.asks = true;
    operator->report.asked_deg = angle_deg;
    operator->state = (uint8_t)state;
    operator->restart_timer = true;
    return TUMBLE_OK;
}

static tumble_status_t operator_home(void *self)
{
    return ask(self, 0.0, TUMBLE_STAND_HOMING);
}

static tumble_status_t operator_move(void *self, double angle_deg)
{
    tumble_operator_t *operator = self;
    if (!tumble_is_finite(angle_deg)) {
        return TUMBLE_E_ARGUMENT;
    }
    return operator->homed ? ask(operator, angle_deg, TUMBLE_STAND_MOVING) : TUMBLE_E_STAND_STATE;
}

static void rest(tumble_operator_t *operator)
{
    withdraw_request(operator, operator->homed ? TUMBLE_STAND_STOPPED : TUMBLE_STAND_READY);
}

static void operator_stop(void *self)
{
    tumble_operator_t *operator = self;
    if (operator->state != (uint8_t)TUMBLE_STAND_FAULT) {
        rest(operator);
    }
}

static tumble_status_t operator_clear_fault(void *self)
{
    tumble_operator_t *operator = self;
    if (operator->state != (uint8_t)TUMBLE_STAND_FAULT) {
        return TUMBLE_E_STAND_STATE;
    }
    rest(operator);
    return TUMBLE_OK;
}

static tumble_stand_state_t operator_state(const void *self)
{
    const tumble_operator_t *operator = self;
    return (tumble_stand_state_t)operator->state;
}

static tumble_stand_fault_t operator_fault(const void *self)
{
    return (operator_state(self) == TUMBLE_STAND_FAULT) ? TUMBLE_STAND_FAULT_TIMEOUT : TUMBLE_STAND_FAULT_NONE;
}

static double operator_angle_deg(const void *self)
{
    const tumble_operator_t *operator = self;
    return operator->angle_deg;
}

const tumble_stand_kind_t tumble_operator_kind = {
    .bytes = (uint16_t)sizeof(tumble_operator_t),
    .report_at = (uint16_t)offsetof(tumble_operator_t, report),
    TUMBLE_STAND_FUNCTIONS(operator),
    .confirm = confirm,
};
