/* The operator at a dividing head: asked, confirming, late, stopped. */
#include "stand/operator/operator.h"
#include "support.h"

static const tumble_operator_config_t config = {.tolerance_deg = 0.1, .timeout_ms = 1000};
static tumble_operator_t person;
static tumble_stand_t stand;

static void set_up(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_operator_init(&person, &config));
    stand = tumble_operator_stand(&person);
}

static void assert_state(tumble_stand_state_t state)
{
    TEST_ASSERT_EQUAL_INT(state, stand.state(stand.self));
}

static void assert_request(double expected_deg)
{
    double angle_deg = 777.0;
    TEST_ASSERT_TRUE(tumble_operator_request(&person, &angle_deg));
    ASSERT_SAME_DOUBLE(expected_deg, angle_deg);
}

static void home(void)
{
    ASSERT_STATUS(TUMBLE_OK, stand.home(stand.self));
    ASSERT_STATUS(TUMBLE_OK, tumble_operator_confirm(&person, 0.0));
}

static void test_asks_for_home_then_for_angles(void)
{
    double unused = 5.0;
    assert_state(TUMBLE_STAND_READY);
    TEST_ASSERT_FALSE(tumble_operator_request(&person, &unused));
    ASSERT_SAME_DOUBLE(5.0, unused);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.move(stand.self, 45.0)); /* zero is not known yet */
    ASSERT_STATUS(TUMBLE_OK, stand.home(stand.self));
    assert_state(TUMBLE_STAND_HOMING);
    assert_request(0.0);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.home(stand.self));
    ASSERT_STATUS(TUMBLE_OK, tumble_operator_confirm(&person, 0.05));
    assert_state(TUMBLE_STAND_IN_POSITION);
    ASSERT_SAME_DOUBLE(0.05, stand.angle_deg(stand.self));
    ASSERT_STATUS(TUMBLE_OK, stand.move(stand.self, 45.0));
    assert_state(TUMBLE_STAND_MOVING);
    assert_request(45.0);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.move(stand.self, 90.0));
    ASSERT_STATUS(TUMBLE_OK, tumble_operator_confirm(&person, 44.95));
    assert_state(TUMBLE_STAND_IN_POSITION);
    ASSERT_SAME_DOUBLE(44.95, stand.angle_deg(stand.self));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_operator_confirm(&person, 44.95));
}

static void test_another_angle_is_not_confirmed(void)
{
    home();
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, stand.move(stand.self, (double)NAN));
    ASSERT_STATUS(TUMBLE_OK, stand.move(stand.self, 45.0));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_operator_confirm(&person, 45.2));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_operator_confirm(&person, (double)NAN));
    assert_state(TUMBLE_STAND_MOVING);
    ASSERT_STATUS(TUMBLE_OK, tumble_operator_confirm(&person, 45.05));
}

static void test_nobody_confirms(void)
{
    home();
    tumble_operator_step(&person, 5000000);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, tumble_operator_next_us(&person));
    ASSERT_STATUS(TUMBLE_OK, stand.move(stand.self, 45.0));
    TEST_ASSERT_EQUAL_UINT64(0, tumble_operator_next_us(&person));
    tumble_operator_step(&person, 6000000);
    TEST_ASSERT_EQUAL_UINT64(7000000, tumble_operator_next_us(&person));
    tumble_operator_step(&person, 6999999);
    assert_state(TUMBLE_STAND_MOVING);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, stand.fault(stand.self));
    tumble_operator_step(&person, 7000000);
    assert_state(TUMBLE_STAND_FAULT);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_TIMEOUT, stand.fault(stand.self));
    TEST_ASSERT_EQUAL_UINT16(0, stand.fault_code(stand.self));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_operator_confirm(&person, 45.0));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.move(stand.self, 45.0));
    stand.stop(stand.self);
    assert_state(TUMBLE_STAND_FAULT);
    ASSERT_STATUS(TUMBLE_OK, stand.clear_fault(stand.self));
    assert_state(TUMBLE_STAND_STOPPED);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, stand.clear_fault(stand.self));
}

static void test_stop_withdraws_the_request(void)
{
    ASSERT_STATUS(TUMBLE_OK, stand.home(stand.self));
    stand.stop(stand.self);
    assert_state(TUMBLE_STAND_READY);
    home();
    ASSERT_STATUS(TUMBLE_OK, stand.move(stand.self, 45.0));
    stand.stop(stand.self);
    assert_state(TUMBLE_STAND_STOPPED);
    ASSERT_SAME_DOUBLE(45.0, stand.angle_deg(stand.self)); /* somewhere up to there: the higher one counts */
    ASSERT_STATUS(TUMBLE_OK, stand.move(stand.self, 20.0));
    stand.stop(stand.self);
    ASSERT_SAME_DOUBLE(45.0, stand.angle_deg(stand.self));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_operator_confirm(&person, 20.0));
}

static void test_bad_configurations(void)
{
    static const tumble_operator_config_t bad[] = {{-0.1, 1000}, {0.1, 0}};
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_operator_init(NULL, &config));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_operator_init(&person, NULL));
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_operator_init(&person, &bad[i]));
    }
    static const tumble_operator_config_t exact = {0.0, 1};
    ASSERT_STATUS(TUMBLE_OK, tumble_operator_init(&person, &exact));
    tumble_operator_config_t infinite = config;
    infinite.tolerance_deg = (double)INFINITY;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_operator_init(&person, &infinite));
}

static const around_t around_each = {set_up, NULL};
