#include "stand/operator/operator.h"

#include "core/arith.h"

#include <stddef.h>

#define US_PER_MS 1000U

static tumble_status_t operator_init(void *self, const tumble_stand_setup_t *setup)
{
    tumble_operator_t *person = self;
    const tumble_operator_config_t *config = setup->profile;
    if ((config == NULL) || !(config->tolerance_deg >= 0.0) || !tumble_is_finite(config->tolerance_deg) ||
        (config->timeout_ms == 0U)) {
        return TUMBLE_E_ARGUMENT;
    }
    *person = (tumble_operator_t){.config = config, .state = (uint8_t)TUMBLE_STAND_READY};
    return TUMBLE_OK;
}

static uint64_t deadline_us(const tumble_operator_t *person)
{
    return person->asked_us + ((uint64_t)person->config->timeout_ms * US_PER_MS);
}

static void leave_request(tumble_operator_t *person, tumble_stand_state_t state)
{
    person->report.asks = false;
    person->state = (uint8_t)state;
}

/* Nobody has said at what angle it is: take the higher one, so that the next angle is reached from below. */
static void withdraw_request(tumble_operator_t *person, tumble_stand_state_t state)
{
    if (person->report.asks) {
        person->angle_deg =
            tumble_exceeds(person->report.asked_deg, person->angle_deg) ? person->report.asked_deg : person->angle_deg;
    }
    leave_request(person, state);
}

static void operator_step(void *self, uint64_t now_us)
{
    tumble_operator_t *person = self;
    if (person->restart_timer) {
        person->restart_timer = false;
        person->asked_us = now_us;
    }
    if (person->report.asks && (now_us >= deadline_us(person))) {
        withdraw_request(person, TUMBLE_STAND_FAULT);
    }
}

static uint64_t operator_next_us(const void *self)
{
    const tumble_operator_t *person = self;
    if (!person->report.asks) {
        return UINT64_MAX;
    }
    return person->restart_timer ? 0U : deadline_us(person);
}

static tumble_status_t confirm(void *self, double angle_deg)
{
    tumble_operator_t *person = self;
    if (!tumble_within(angle_deg - person->report.asked_deg, person->config->tolerance_deg)) {
        return TUMBLE_E_ARGUMENT;
    }
    person->homed = true;
    person->angle_deg = angle_deg;
    leave_request(person, TUMBLE_STAND_IN_POSITION);
    return TUMBLE_OK;
}

static tumble_status_t ask(tumble_operator_t *person, double angle_deg, tumble_stand_state_t state)
{
    if (person->report.asks || (person->state == (uint8_t)TUMBLE_STAND_FAULT)) {
        return TUMBLE_E_STAND_STATE;
    }
    person->report.asks = true;
    person->report.asked_deg = angle_deg;
    person->state = (uint8_t)state;
    person->restart_timer = true;
    return TUMBLE_OK;
}

static tumble_status_t operator_home(void *self)
{
    return ask(self, 0.0, TUMBLE_STAND_HOMING);
}

static tumble_status_t operator_move(void *self, double angle_deg)
{
    tumble_operator_t *person = self;
    if (!tumble_is_finite(angle_deg)) {
        return TUMBLE_E_ARGUMENT;
    }
    return person->homed ? ask(person, angle_deg, TUMBLE_STAND_MOVING) : TUMBLE_E_STAND_STATE;
}

static void rest(tumble_operator_t *person)
{
    withdraw_request(person, person->homed ? TUMBLE_STAND_STOPPED : TUMBLE_STAND_READY);
}

static void operator_stop(void *self)
{
    tumble_operator_t *person = self;
    if (person->state != (uint8_t)TUMBLE_STAND_FAULT) {
        rest(person);
    }
}

static tumble_status_t operator_clear_fault(void *self)
{
    tumble_operator_t *person = self;
    if (person->state != (uint8_t)TUMBLE_STAND_FAULT) {
        return TUMBLE_E_STAND_STATE;
    }
    rest(person);
    return TUMBLE_OK;
}

static tumble_stand_state_t operator_state(const void *self)
{
    const tumble_operator_t *person = self;
    return (tumble_stand_state_t)person->state;
}

static tumble_stand_fault_t operator_fault(const void *self)
{
    return (operator_state(self) == TUMBLE_STAND_FAULT) ? TUMBLE_STAND_FAULT_TIMEOUT : TUMBLE_STAND_FAULT_NONE;
}

static double operator_angle_deg(const void *self)
{
    const tumble_operator_t *person = self;
    return person->angle_deg;
}

const tumble_stand_kind_t tumble_operator_kind = {
    .bytes = (uint16_t)sizeof(tumble_operator_t),
    .report_at = (uint16_t)offsetof(tumble_operator_t, report),
    TUMBLE_STAND_FUNCTIONS(operator),
    .confirm = confirm,
};
