/* Every kind of stand keeps what tumble/stand.h promises. */
#include "drive_bench.h"
#include "played_positioner.h"
#include "stand/operator/operator.h"
#include "stand_rules.h"

static void assert_keeps_rules(const played_stand_t *stand)
{
    const char *broken = stand_rules_broken(stand);
    TEST_ASSERT_NULL_MESSAGE(broken, broken);
}

/* A drive. */

static void begin_drive(void)
{
    bring_up(&common);
}

static void pass_drive(void)
{
    run_ms(1);
}

/* A dead one has no power; that a drive which only fails to hear us stops by itself is its own duty (1016h). */
static bool drive_turns(void)
{
    return played.moving && !played.dead;
}

static double drive_angle_deg(void)
{
    return bench.stand.kind->angle_deg(bench.stand.self);
}

static void lose_drive(void)
{
    played.dead = true;
}

static void find_drive(void)
{
    scripted_drive_boot(&played, &port);
}

static void test_a_drive_keeps_the_rules(void)
{
    const played_stand_t drive = {
        .stand = {&tumble_drive402_kind, &bench.drive},
        .begin = begin_drive,
        .pass = pass_drive,
        .turns = drive_turns,
        .angle_deg = drive_angle_deg,
        .lose = lose_drive,
        .find = find_drive,
        .most_ms = 5000,
        .fault_ms = 4000,
    };
    assert_keeps_rules(&drive);
}

/* A person, who takes a tenth of a second for every answer. */

static const tumble_operator_config_t head_config = {.tolerance_deg = 0.1, .timeout_ms = 1000};
static tumble_operator_t head;
static uint64_t head_ms;
static unsigned asked_ms;
static bool leaves;

static void begin_operator(void)
{
    const tumble_stand_setup_t setup = {.profile = &head_config};
    head = (tumble_operator_t){.homed = false};
    asked_ms = 0;
    leaves = false;
    ASSERT_STATUS(TUMBLE_OK, tumble_operator_kind.init(&head, &setup));
}

static void pass_operator(void)
{
    head_ms++;
    tumble_operator_kind.step(&head, head_ms * 1000U);
    asked_ms = (head.report.asks && !leaves) ? asked_ms + 1U : 0U;
    if (asked_ms == 100U) {
        asked_ms = 0;
        ASSERT_STATUS(TUMBLE_OK, tumble_operator_kind.confirm(&head, head.report.asked_deg));
    }
}

static double operator_angle_deg(void)
{
    return tumble_operator_kind.angle_deg(&head);
}

static void lose_operator(void)
{
    leaves = true;
}

static void find_operator(void)
{
    leaves = false;
}

static void test_a_person_keeps_the_rules(void)
{
    const played_stand_t operator = {
        .stand = {&tumble_operator_kind, &head},
        .begin = begin_operator,
        .pass = pass_operator,
        .angle_deg = operator_angle_deg,
        .lose = lose_operator,
        .find = find_operator,
        .most_ms = 500,
        .fault_ms = 1500,
    };
    assert_keeps_rules(&operator);
}

/* A controller with registers. */

static played_positioner_t controller;
static tumble_positioner_profile_t registers;
static tumble_positioner_t axis;

static void begin_positioner(void)
{
    const tumble_stand_setup_t setup = {.profile = &registers, .cable_min_deg = -30.0, .cable_max_deg = 400.0};
    played_positioner_init(&controller);
    registers = played_positioner_profile(&controller);
    axis = (tumble_positioner_t){.known = false};
    ASSERT_STATUS(TUMBLE_OK, tumble_positioner_kind.init(&axis, &setup));
}

static void pass_positioner(void)
{
    played_positioner_step(&controller);
    tumble_positioner_kind.step(&axis, controller.now_ms * 1000U);
}

static bool positioner_turns(void)
{
    return controller.moving;
}

static double positioner_angle_deg(void)
{
    return played_positioner_angle_deg(&controller);
}

static void lose_positioner(void)
{
    controller.dead = true;
}

static void find_positioner(void)
{
    controller.dead = false;
}

static const played_stand_t positioner = {
    .stand = {&tumble_positioner_kind, &axis},
    .begin = begin_positioner,
    .pass = pass_positioner,
    .turns = positioner_turns,
    .angle_deg = positioner_angle_deg,
    .lose = lose_positioner,
    .find = find_positioner,
    .most_ms = 5000,
    .fault_ms = 500,
};

static void test_a_positioner_keeps_the_rules(void)
{
    assert_keeps_rules(&positioner);
    TEST_ASSERT_NULL_MESSAGE(controller.wrong, controller.wrong);
}

/* Each rule can be broken: the positioner with one function that does something else. */

static tumble_stand_state_t always_in_position(const void *self)
{
    const tumble_stand_state_t state = tumble_positioner_kind.state(self);
    return (state == TUMBLE_STAND_MOVING) ? TUMBLE_STAND_IN_POSITION : state;
}

static tumble_stand_state_t never_ready(const void *self)
{
    (void)self;
    return TUMBLE_STAND_OFFLINE;
}

static tumble_stand_state_t stopped_too_early(const void *self)
{
    const tumble_positioner_t *one = self;
    const bool stopping = (one->rung != (uint8_t)TUMBLE_RUNG_NONE) && (one->state == (uint8_t)TUMBLE_STAND_MOVING);
    return stopping ? TUMBLE_STAND_STOPPED : tumble_positioner_kind.state(self);
}

static tumble_stand_fault_t no_fault(const void *self)
{
    (void)self;
    return TUMBLE_STAND_FAULT_NONE;
}

static double off_by_one_deg(const void *self)
{
    return tumble_positioner_kind.angle_deg(self) + 1.0;
}

static tumble_status_t move_anywhere(void *self, double angle_deg)
{
    const tumble_status_t status = tumble_positioner_kind.move(self, angle_deg);
    return (status == TUMBLE_E_ARGUMENT) ? TUMBLE_OK : status;
}

static tumble_status_t move_without_home(void *self, double angle_deg)
{
    const tumble_status_t status = tumble_positioner_kind.move(self, angle_deg);
    const bool ready = tumble_positioner_kind.state(self) == TUMBLE_STAND_READY;
    return ready ? TUMBLE_OK : status;
}

static void does_not_stop(void *self)
{
    (void)self;
}

static void clears_by_stop(void *self)
{
    tumble_positioner_t *one = self;
    tumble_positioner_kind.stop(self);
    one->state = (one->state == (uint8_t)TUMBLE_STAND_FAULT) ? (uint8_t)TUMBLE_STAND_STOPPED : one->state;
    one->fault = (uint8_t)TUMBLE_STAND_FAULT_NONE;
}

static tumble_status_t clears_nothing(void *self)
{
    (void)self;
    return TUMBLE_E_STAND_STATE;
}

static tumble_status_t clears_what_is_not(void *self)
{
    (void)tumble_positioner_kind.clear_fault(self);
    return TUMBLE_OK;
}

static uint64_t always_at_once(const void *self)
{
    (void)self;
    return 0;
}

static void assert_breaks(const tumble_stand_kind_t *kind, const char *rule)
{
    played_stand_t spoilt = positioner;
    spoilt.stand.kind = kind;
    const char *broken = stand_rules_broken(&spoilt);
    TEST_ASSERT_NOT_NULL_MESSAGE(broken, rule);
    TEST_ASSERT_EQUAL_STRING(rule, broken);
}

#define ASSERT_BREAKS(member, function, rule)                                                                          \
    do {                                                                                                               \
        tumble_stand_kind_t kind = tumble_positioner_kind;                                                             \
        kind.member = (function);                                                                                      \
        assert_breaks(&kind, rule);                                                                                    \
    } while (false)

static void test_each_rule_can_be_broken(void)
{
    ASSERT_BREAKS(state, never_ready, "with contact it becomes ready by itself");
    ASSERT_BREAKS(move, move_without_home, "before homing a move is refused");
    ASSERT_BREAKS(state, always_in_position, "from the moment that move returns, the old position does not count");
    ASSERT_BREAKS(angle_deg, off_by_one_deg, "after homing it is at home");
    ASSERT_BREAKS(move, move_anywhere, "what is no angle is refused");
    ASSERT_BREAKS(stop, does_not_stop, "a stop ends at rest, with the position known");
    ASSERT_BREAKS(state, stopped_too_early, "a table that turns has not stopped");
    ASSERT_BREAKS(clear_fault, clears_what_is_not, "without a fault there is none to clear");
    ASSERT_BREAKS(fault, no_fault, "there is a fault if and only if the state is FAULT");
    ASSERT_BREAKS(stop, clears_by_stop, "stop does not clear a fault");
    ASSERT_BREAKS(clear_fault, clears_nothing, "a fault can be cleared, in seconds at most");
    ASSERT_BREAKS(next_us, always_at_once, "at rest its next step is not due at once");
}
