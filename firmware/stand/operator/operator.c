#include "stand/operator/operator.h"

#include "core/arith.h"

#include <stddef.h>

#define US_PER_MS 1000U

tumble_status_t tumble_operator_init(tumble_operator_t *person, const tumble_operator_config_t *config)
{
    if ((person == NULL) || (config == NULL) || !(config->tolerance_deg >= 0.0) ||
        !tumble_is_finite(config->tolerance_deg) || (config->timeout_ms == 0U)) {
        return TUMBLE_E_ARGUMENT;
    }
    *person = (tumble_operator_t){.config = config, .state = (uint8_t)TUMBLE_STAND_READY};
    return TUMBLE_OK;
}

static bool is_asked(const tumble_operator_t *person)
{
    return (person->state == (uint8_t)TUMBLE_STAND_HOMING) || (person->state == (uint8_t)TUMBLE_STAND_MOVING);
}

static uint64_t deadline_us(const tumble_operator_t *person)
{
    return person->asked_us + ((uint64_t)person->config->timeout_ms * US_PER_MS);
}

void tumble_operator_step(tumble_operator_t *person, uint64_t now_us)
{
    if (person->restart_timer) {
        person->restart_timer = false;
        person->asked_us = now_us;
    }
    if (is_asked(person) && (now_us >= deadline_us(person))) {
        person->state = (uint8_t)TUMBLE_STAND_FAULT;
    }
}

uint64_t tumble_operator_next_us(const tumble_operator_t *person)
{
    if (!is_asked(person)) {
        return UINT64_MAX;
    }
    return person->restart_timer ? 0U : deadline_us(person);
}

bool tumble_operator_request(const tumble_operator_t *person, double *angle_deg)
{
    if (is_asked(person)) {
        *angle_deg = person->request_deg;
    }
    return is_asked(person);
}

tumble_status_t tumble_operator_confirm(tumble_operator_t *person, double angle_deg)
{
    if (!is_asked(person)) {
        return TUMBLE_E_STATE;
    }
    if (!tumble_within(angle_deg - person->request_deg, person->config->tolerance_deg)) {
        return TUMBLE_E_ARGUMENT;
    }
    person->homed = true;
    person->angle_deg = angle_deg;
    person->state = (uint8_t)TUMBLE_STAND_IN_POSITION;
    return TUMBLE_OK;
}

static tumble_status_t ask(tumble_operator_t *person, double angle_deg, tumble_stand_state_t state)
{
    if (is_asked(person) || (person->state == (uint8_t)TUMBLE_STAND_FAULT)) {
        return TUMBLE_E_STAND_STATE;
    }
    person->request_deg = angle_deg;
    person->state = (uint8_t)state;
    person->restart_timer = true;
    return TUMBLE_OK;
}

static tumble_status_t home(void *self)
{
    return ask(self, 0.0, TUMBLE_STAND_HOMING);
}

static tumble_status_t move(void *self, double angle_deg)
{
    tumble_operator_t *person = self;
    if (!tumble_is_finite(angle_deg)) {
        return TUMBLE_E_ARGUMENT;
    }
    return person->homed ? ask(person, angle_deg, TUMBLE_STAND_MOVING) : TUMBLE_E_STAND_STATE;
}

static void rest(tumble_operator_t *person)
{
    person->state = (uint8_t)(person->homed ? TUMBLE_STAND_STOPPED : TUMBLE_STAND_READY);
}

/* The request is withdrawn, at what angle nobody knows: take the higher one, so that the next angle is reached from
 * below. */
static void stop(void *self)
{
    tumble_operator_t *person = self;
    if (is_asked(person) && (person->request_deg > person->angle_deg)) {
        person->angle_deg = person->request_deg;
    }
    if (person->state != (uint8_t)TUMBLE_STAND_FAULT) {
        rest(person);
    }
}

static tumble_status_t clear_fault(void *self)
{
    tumble_operator_t *person = self;
    if (person->state != (uint8_t)TUMBLE_STAND_FAULT) {
        return TUMBLE_E_STAND_STATE;
    }
    rest(person);
    return TUMBLE_OK;
}

static tumble_stand_state_t state(void *self)
{
    const tumble_operator_t *person = self;
    return (tumble_stand_state_t)person->state;
}

static tumble_stand_fault_t fault(void *self)
{
    return (state(self) == TUMBLE_STAND_FAULT) ? TUMBLE_STAND_FAULT_TIMEOUT : TUMBLE_STAND_FAULT_NONE;
}

static uint16_t fault_code(void *self)
{
    (void)self;
    return 0;
}

static double angle(void *self)
{
    const tumble_operator_t *person = self;
    return person->angle_deg;
}

tumble_stand_t tumble_operator_stand(tumble_operator_t *person)
{
    return (tumble_stand_t){
        .self = person,
        .home = home,
        .move = move,
        .stop = stop,
        .clear_fault = clear_fault,
        .state = state,
        .fault = fault,
        .fault_code = fault_code,
        .angle_deg = angle,
    };
}

const tumble_operator_calls_t tumble_operator_calls = {
    .init = tumble_operator_init,
    .step = tumble_operator_step,
    .next_us = tumble_operator_next_us,
    .request = tumble_operator_request,
    .confirm = tumble_operator_confirm,
    .stand = tumble_operator_stand,
};
