/* The operator at a dividing head: asked, confirming, late, stopped. */
#include "stand/operator/operator.h"
#include "support.h"

static const tumble_operator_config_t config = {.tolerance_deg = 0.1, .timeout_ms = 1000};
static tumble_operator_t person;
static const tumble_stand_t stand = {&tumble_operator_kind, &person};

static tumble_status_t init(const tumble_operator_config_t *profile)
{
    const tumble_stand_setup_t setup = {.profile = profile};
    return stand.kind->init(&person, &setup);
}

/* As navcomp: only what is asked for can be confirmed. */
static tumble_status_t confirm(double angle_deg)
{
    return person.report.asks ? stand.kind->confirm(&person, angle_deg) : TUMBLE_E_STATE;
}

static void set_up(void)
{
    ASSERT_STATUS(TUMBLE_OK, init(&config));
}

static void assert_state(tumble_stand_state_t state)
{
    TEST_ASSERT_EQUAL_INT(state, stand.kind->state(&person));
}

static void assert_request(double expected_deg)
{
    TEST_ASSERT_TRUE(person.report.asks);
    ASSERT_SAME_DOUBLE(expected_deg, person.report.asked_deg);
}

static void home(void)
{
    ASSERT_STATUS(TUMBLE_OK, stand.kind->home(&person));
    ASSERT_STATUS(TUMBLE_OK, confirm(0.0));
}

static void test_asks_for_home_then_for_angles(void)
{
    assert_state(TUMBLE_STAND_READY);
    TEST_ASSERT_FALSE(person.report.asks);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->move(&person, 45.0)); /* zero is not known yet */
    ASSERT_STATUS(TUMBLE_OK, stand.kind->home(&person));
    assert_state(TUMBLE_STAND_HOMING);
    assert_request(0.0);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->home(&person));
    ASSERT_STATUS(TUMBLE_OK, confirm(0.05));
    assert_state(TUMBLE_STAND_IN_POSITION);
    ASSERT_SAME_DOUBLE(0.05, stand.kind->angle_deg(&person));
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&person, 45.0));
    assert_state(TUMBLE_STAND_MOVING);
    assert_request(45.0);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->move(&person, 90.0));
    ASSERT_STATUS(TUMBLE_OK, confirm(44.95));
    assert_state(TUMBLE_STAND_IN_POSITION);
    ASSERT_SAME_DOUBLE(44.95, stand.kind->angle_deg(&person));
    ASSERT_STATUS(TUMBLE_E_STATE, confirm(44.95));
}

static void test_another_angle_is_not_confirmed(void)
{
    home();
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, stand.kind->move(&person, (double)NAN));
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&person, 45.0));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, confirm(45.2));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, confirm((double)NAN));
    assert_state(TUMBLE_STAND_MOVING);
    ASSERT_STATUS(TUMBLE_OK, confirm(45.05));
}

static void test_nobody_confirms(void)
{
    home();
    tumble_operator_kind.step(&person, 5000000);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, tumble_operator_kind.next_us(&person));
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&person, 45.0));
    TEST_ASSERT_EQUAL_UINT64(0, tumble_operator_kind.next_us(&person));
    tumble_operator_kind.step(&person, 6000000);
    TEST_ASSERT_EQUAL_UINT64(7000000, tumble_operator_kind.next_us(&person));
    tumble_operator_kind.step(&person, 6999999);
    assert_state(TUMBLE_STAND_MOVING);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, stand.kind->fault(&person));
    tumble_operator_kind.step(&person, 7000000);
    assert_state(TUMBLE_STAND_FAULT);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_TIMEOUT, stand.kind->fault(&person));
    TEST_ASSERT_EQUAL_UINT16(0, person.report.fault_code);
    ASSERT_STATUS(TUMBLE_E_STATE, confirm(45.0));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->move(&person, 45.0));
    stand.kind->stop(&person);
    assert_state(TUMBLE_STAND_FAULT);
    ASSERT_STATUS(TUMBLE_OK, stand.kind->clear_fault(&person));
    assert_state(TUMBLE_STAND_STOPPED);
    ASSERT_SAME_DOUBLE(45.0, stand.kind->angle_deg(&person)); /* it may have been turned all the same */
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->clear_fault(&person));
}

static void test_stop_withdraws_the_request(void)
{
    ASSERT_STATUS(TUMBLE_OK, stand.kind->home(&person));
    stand.kind->stop(&person);
    assert_state(TUMBLE_STAND_READY);
    home();
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&person, 45.0));
    stand.kind->stop(&person);
    assert_state(TUMBLE_STAND_STOPPED);
    ASSERT_SAME_DOUBLE(45.0, stand.kind->angle_deg(&person)); /* somewhere up to there: the higher one counts */
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&person, 20.0));
    stand.kind->stop(&person);
    ASSERT_SAME_DOUBLE(45.0, stand.kind->angle_deg(&person));
    ASSERT_STATUS(TUMBLE_E_STATE, confirm(20.0));
}

static void test_bad_configurations(void)
{
    static const tumble_operator_config_t bad[] = {{-0.1, 1000}, {0.1, 0}};
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, init(NULL));
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, init(&bad[i]));
    }
    static const tumble_operator_config_t exact = {0.0, 1};
    ASSERT_STATUS(TUMBLE_OK, init(&exact));
    tumble_operator_config_t infinite = config;
    infinite.tolerance_deg = (double)INFINITY;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, init(&infinite));
}
