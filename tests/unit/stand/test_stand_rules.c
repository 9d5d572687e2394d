/* Every kind of stand keeps what tumble/stand.h promises. */
#include "drive_bench.h"
#include "played_positioner.h"
#include "stand/operator/operator.h"
#include "stand_rules.h"

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
    stand_rules_check(&drive);
}

/* A person, who takes a tenth of a second for every answer. */

static const tumble_operator_config_t head_config = {.tolerance_deg = 0.1, .timeout_ms = 1000};
static tumble_operator_t head;
static uint64_t head_ms;
static unsigned asked_ms;
static bool leaves;

static void begin_person(void)
{
    const tumble_stand_setup_t setup = {.profile = &head_config};
    head = (tumble_operator_t){.homed = false};
    asked_ms = 0;
    leaves = false;
    ASSERT_STATUS(TUMBLE_OK, tumble_operator_kind.init(&head, &setup));
}

static void pass_person(void)
{
    head_ms++;
    tumble_operator_kind.step(&head, head_ms * 1000U);
    asked_ms = (head.report.asks && !leaves) ? asked_ms + 1U : 0U;
    if (asked_ms == 100U) {
        asked_ms = 0;
        ASSERT_STATUS(TUMBLE_OK, tumble_operator_kind.confirm(&head, head.report.asked_deg));
    }
}

static double person_angle_deg(void)
{
    return tumble_operator_kind.angle_deg(&head);
}

static void lose_person(void)
{
    leaves = true;
}

static void find_person(void)
{
    leaves = false;
}

static void test_a_person_keeps_the_rules(void)
{
    const played_stand_t person = {
        .stand = {&tumble_operator_kind, &head},
        .begin = begin_person,
        .pass = pass_person,
        .angle_deg = person_angle_deg,
        .lose = lose_person,
        .find = find_person,
        .most_ms = 500,
        .fault_ms = 1500,
    };
    stand_rules_check(&person);
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

static void test_a_positioner_keeps_the_rules(void)
{
    const played_stand_t positioner = {
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
    stand_rules_check(&positioner);
    TEST_ASSERT_NULL_MESSAGE(controller.wrong, controller.wrong);
}

static const around_t around_each = {NULL, NULL};
