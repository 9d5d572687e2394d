#include "positioner_bench.h"

#define HOME_MS 500U

positioner_bench_t at;

tumble_status_t positioner_init(const tumble_positioner_profile_t *profile)
{
    const tumble_stand_setup_t setup = {.profile = profile, .cable_min_deg = -30.0, .cable_max_deg = 400.0};
    return tumble_positioner_kind.init(&at.axis, &setup);
}

void positioner_begin(void)
{
    memset(&at, 0, sizeof at);
    at.stand = (tumble_stand_t){&tumble_positioner_kind, &at.axis};
    played_positioner_init(&at.controller);
    at.profile = played_positioner_profile(&at.controller);
    ASSERT_STATUS(TUMBLE_OK, positioner_init(&at.profile));
}

void positioner_end(void)
{
    TEST_ASSERT_NULL_MESSAGE(at.controller.wrong, at.controller.wrong);
}

void positioner_run_ms(unsigned ms)
{
    for (unsigned i = 0; i < ms; i++) {
        played_positioner_step(&at.controller);
        const uint64_t now_us = at.controller.now_ms * 1000U;
        for (int steps = 0; tumble_positioner_kind.next_us(&at.axis) <= now_us; steps++) {
            tumble_positioner_kind.step(&at.axis, now_us);
            TEST_ASSERT_TRUE_MESSAGE(steps < 3, "it asks for steps without end");
        }
    }
}

void positioner_run_to(tumble_stand_state_t state, unsigned most_ms)
{
    for (unsigned ms = 0; (ms < most_ms) && (tumble_positioner_kind.state(&at.axis) != state); ms++) {
        positioner_run_ms(1);
    }
    TEST_ASSERT_EQUAL_INT(state, tumble_positioner_kind.state(&at.axis));
}

void positioner_assert_fault(tumble_stand_fault_t fault)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT, tumble_positioner_kind.state(&at.axis));
    TEST_ASSERT_EQUAL_INT(fault, tumble_positioner_kind.fault(&at.axis));
}

void positioner_go_home(void)
{
    positioner_run_to(TUMBLE_STAND_READY, 100);
    ASSERT_STATUS(TUMBLE_OK, tumble_positioner_kind.home(&at.axis));
    positioner_run_to(TUMBLE_STAND_IN_POSITION, HOME_MS);
}

void positioner_start_move(double angle_deg)
{
    positioner_go_home();
    ASSERT_STATUS(TUMBLE_OK, tumble_positioner_kind.move(&at.axis, angle_deg));
    positioner_run_ms(100);
    TEST_ASSERT_TRUE(at.controller.moving);
}

void positioner_clear(tumble_stand_state_t state)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_positioner_kind.clear_fault(&at.axis));
    positioner_run_to(state, 200);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, tumble_positioner_kind.fault(&at.axis));
}
