/* The operator at a dividing head: asked, confirming, late, stopped. */
#include "stand/operator/operator.h"
#include "support.h"

static const tumble_operator_config_t config = {.tolerance_deg = 0.1, .timeout_ms = 1000};
static tumble_operator_t operator;
static const tumble_stand_t stand = {&tumble_operator_kind, &operator};

static tumble_status_t init(const tumble_operator_config_t *profile)
{
    const tumble_stand_setup_t setup = {.profile = profile};
    return stand.kind->init(&operator, &setup);
}

/* As navcomp: only what is asked for can be confirmed. */
static tumble_status_t confirm(double angle_deg)
{
    return operator.report.asks ? stand.kind->confirm(&operator, angle_deg) : TUMBLE_E_STATE;
}

static void set_up(void)
{
    ASSERT_STATUS(TUMBLE_OK, init(&config));
}

static void assert_state(tumble_stand_state_t state)
{
    TEST_ASSERT_EQUAL_INT(state, stand.kind->state(&operator));
}

static void assert_request(double expected_deg)
{
    TEST_ASSERT_TRUE(operator.report.asks);
    ASSERT_SAME_DOUBLE(expected_deg, operator.report.asked_deg);
}

static void home(void)
{
    ASSERT_STATUS(TUMBLE_OK, stand.kind->home(&operator));
    ASSERT_STATUS(TUMBLE_OK, confirm(0.0));
}

static void test_asks_for_home_then_for_angles(void)
{
    assert_state(TUMBLE_STAND_READY);
    TEST_ASSERT_FALSE(operator.report.asks);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->move(&operator, 45.0)); /* zero is not known yet */
    ASSERT_STATUS(TUMBLE_OK, stand.kind->home(&operator));
    assert_state(TUMBLE_STAND_HOMING);
    assert_request(0.0);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->home(&operator));
    ASSERT_STATUS(TUMBLE_OK, confirm(0.05));
    assert_state(TUMBLE_STAND_IN_POSITION);
    ASSERT_SAME_DOUBLE(0.05, stand.kind->angle_deg(&operator));
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&operator, 45.0));
    assert_state(TUMBLE_STAND_MOVING);
    assert_request(45.0);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->move(&operator, 90.0));
    ASSERT_STATUS(TUMBLE_OK, confirm(44.95));
    assert_state(TUMBLE_STAND_IN_POSITION);
    ASSERT_SAME_DOUBLE(44.95, stand.kind->angle_deg(&operator));
    ASSERT_STATUS(TUMBLE_E_STATE, confirm(44.95));
}

static void test_another_angle_is_not_confirmed(void)
{
    home();
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, stand.kind->move(&operator, (double)NAN));
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&operator, 45.0));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, confirm(45.2));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, confirm((double)NAN));
    assert_state(TUMBLE_STAND_MOVING);
    ASSERT_STATUS(TUMBLE_OK, confirm(45.05));
}

static void test_nobody_confirms(void)
{
    home();
    tumble_operator_kind.step(&operator, 5000000);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, tumble_operator_kind.next_us(&operator));
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&operator, 45.0));
    TEST_ASSERT_EQUAL_UINT64(0, tumble_operator_kind.next_us(&operator));
    tumble_operator_kind.step(&operator, 6000000);
    TEST_ASSERT_EQUAL_UINT64(7000000, tumble_operator_kind.next_us(&operator));
    tumble_operator_kind.step(&operator, 6999999);
    assert_state(TUMBLE_STAND_MOVING);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, stand.kind->fault(&operator));
    tumble_operator_kind.step(&operator, 7000000);
    assert_state(TUMBLE_STAND_FAULT);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_TIMEOUT, stand.kind->fault(&operator));
    TEST_ASSERT_EQUAL_UINT16(0, operator.report.fault_code);
    ASSERT_STATUS(TUMBLE_E_STATE, confirm(45.0));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->move(&operator, 45.0));
    stand.kind->stop(&operator);
    assert_state(TUMBLE_STAND_FAULT);
    ASSERT_STATUS(TUMBLE_OK, stand.kind->clear_fault(&operator));
    assert_state(TUMBLE_STAND_STOPPED);
    ASSERT_SAME_DOUBLE(45.0, stand.kind->angle_deg(&operator)); /* it may have been turned all the same */
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.kind->clear_fault(&operator));
}

static void test_stop_withdraws_the_request(void)
{
    ASSERT_STATUS(TUMBLE_OK, stand.kind->home(&operator));
    stand.kind->stop(&operator);
    assert_state(TUMBLE_STAND_READY);
    home();
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&operator, 45.0));
    stand.kind->stop(&operator);
    assert_state(TUMBLE_STAND_STOPPED);
    ASSERT_SAME_DOUBLE(45.0, stand.kind->angle_deg(&operator)); /* somewhere up to there: the higher one counts */
    ASSERT_STATUS(TUMBLE_OK, stand.kind->move(&operator, 20.0));
    stand.kind->stop(&operator);
    ASSERT_SAME_DOUBLE(45.0, stand.kind->angle_deg(&operator));
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
