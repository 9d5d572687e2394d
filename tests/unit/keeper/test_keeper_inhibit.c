/* Who may inhibit a run, and the table in the hands of a validator. */
#include "keeper_bench.h"

/* Inhibit. */

static void assert_inhibited_everywhere(void)
{
    static const tumble_command_t refused[] = {
        TUMBLE_COMMAND_START,           TUMBLE_COMMAND_RESUME,          TUMBLE_COMMAND_CONFIRM_MOUNTING,
        TUMBLE_COMMAND_REPEAT_POSITION, TUMBLE_COMMAND_REPEAT_MOUNTING, TUMBLE_COMMAND_HOME_AXIS,
        TUMBLE_COMMAND_TURN_AXIS};
    for (size_t i = 0; i < COUNT_OF(refused); i++) {
        const uint32_t before = keeper.counters.inhibited;
        TEST_ASSERT_EQUAL(TUMBLE_E_STATE, tell(refused[i]));
        TEST_ASSERT_EQUAL_UINT32(before + 1U, keeper.counters.inhibited);
    }
    TEST_ASSERT_TRUE(state_of_keeper().inhibited);
}

static void test_the_host_inhibits_for_a_time(void)
{
    tumble_keeper_inhibit(&keeper, 30);
    TEST_ASSERT_EQUAL_UINT16(30, state_of_keeper().inhibit_s);
    bench_pass(&bench, 29.5);
    assert_inhibited_everywhere();
    TEST_ASSERT_EQUAL_UINT16(1, state_of_keeper().inhibit_s);
    bench_pass(&bench, 0.7); /* the host has died */
    TEST_ASSERT_FALSE(state_of_keeper().inhibited);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT));
    bench.fake.now_us += 1; /* since the last step */
    tumble_keeper_inhibit(&keeper, UINT16_MAX);
    TEST_ASSERT_EQUAL_UINT16(UINT16_MAX, state_of_keeper().inhibit_s);
    tumble_keeper_inhibit(&keeper, 0); /* it ends it itself */
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
}

static void test_the_board_inhibits_as_long_as_it_likes(void)
{
    board_inhibits = true;
    assert_inhibited_everywhere();
    bench_pass(&bench, 600.0);
    assert_inhibited_everywhere();
    board_inhibits = false;
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
}

/* In every state of a run but FAULT: given up, and the table at rest. */
static void test_a_run_under_way_is_given_up(void)
{
    static const tumble_state_t states[] = {TUMBLE_STATE_PREFLIGHT, TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_STATE_HOME,
                                            TUMBLE_STATE_MOVE,      TUMBLE_STATE_SETTLE,        TUMBLE_STATE_AVERAGE};
    for (size_t s = 0; s < COUNT_OF(states); s++) {
        keeper_power_on();
        bench.never_confirm = (states[s] == TUMBLE_STATE_WAIT_MOUNTING);
        ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
        TEST_ASSERT_EQUAL(states[s], bench_run(&bench, states[s], 60.0));
        tumble_keeper_inhibit(&keeper, 60);
        bench_pass(&bench, 1.0);
        const tumble_navcomp_progress_t progress = bench_progress(&bench);
        TEST_ASSERT_EQUAL_STRING("TUMBLE_REASON_INHIBITED", tumble_reason_name(progress.run.reason));
        TEST_ASSERT_EQUAL(TUMBLE_STATE_ABORT, progress.run.state);
        TEST_ASSERT_EQUAL(states[s], progress.run.failed_in);
        TEST_ASSERT_NOT_EQUAL(TUMBLE_STAND_MOVING, progress.stand);
        TEST_ASSERT_NOT_EQUAL(TUMBLE_STAND_HOMING, progress.stand);
        TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.inhibited);
    }
}

/* By the board: noticed within a heartbeat. */
static void test_the_board_ends_a_run(void)
{
    start_to_average(3);
    board_inhibits = true;
    assert_state_after(0.11, TUMBLE_STATE_ABORT);
    TEST_ASSERT_EQUAL(TUMBLE_REASON_INHIBITED, bench_progress(&bench).run.reason);
}

/* A contact that is open just as the command comes, and closed in the steps before and after it. */
static void test_a_contact_that_bounces_inhibits_all_the_same(void)
{
    board_inhibits = true;
    bench_pass(&bench, 1.0);
    board_inhibits = false;
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    board_inhibits = true;
    bench_event(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_ABORT, run_state());
    TEST_ASSERT_EQUAL(TUMBLE_REASON_INHIBITED, bench_progress(&bench).run.reason);
    bench_pass(&bench, 3.0);
    board_inhibits = false;
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_HOME_AXIS));
    board_inhibits = true;
    bench_pass(&bench, 0.1);
    TEST_ASSERT_EQUAL(TUMBLE_STAND_READY, bench_progress(&bench).stand); /* not homed */
}

static unsigned looks;

static bool bounce(void *context)
{
    (void)context;
    looks++;
    return ((looks % 2U) != 0U) || (run_state() != TUMBLE_STATE_IDLE);
}

/* And one that is open at every other look, until a run has begun by itself: it does not go on for long. */
static void test_a_run_that_slipped_through_is_given_up(void)
{
    settings.flags = TUMBLE_SETS_STARTS;
    keeper_config.sets.inhibited = bounce;
    looks = 0;
    keeper_power_cycle_for(600.0);
    TEST_ASSERT_GREATER_THAN_UINT32(0, keeper.counters.self_started);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_ABORT, run_state());
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).procedure.positions);
}

static void test_a_fault_waits_until_the_inhibit_is_over(void)
{
    start_to_average(3);
    bench.block.dead = true;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_run(&bench, TUMBLE_STATE_DONE, 60.0));
    tumble_keeper_inhibit(&keeper, 60);
    assert_state_after(30.0, TUMBLE_STATE_FAULT);
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME));
    bench.block.dead = false;
    bench_pass(&bench, 31.0);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_RESUME));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
}

static void test_inhibited_it_does_not_start_by_itself(void)
{
    settings.flags = TUMBLE_SETS_STARTS;
    board_inhibits = true;
    keeper_power_cycle();
    assert_state_after(100.0, TUMBLE_STATE_IDLE);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_NO_SET, state_of_keeper().due);
    board_inhibits = false;
    bench_pass(&bench, 1.0);
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_IDLE, run_state());
}

static void test_nor_goes_on_after_a_loss_of_power(void)
{
    start_to_average(3);
    settle_and_power_cycle();
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_RESUME));
    tumble_keeper_inhibit(&keeper, 60); /* while the means are put back */
    assert_state_after(1.0, TUMBLE_STATE_IDLE);
    bench_pass(&bench, 60.0);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_RESUME)); /* nothing was lost */
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, (bench_pass(&bench, 0.2), bench_run(&bench, TUMBLE_STATE_DONE, 600.0)));
}

/* The table between runs. */

static void wait_for_stand(tumble_stand_state_t state)
{
    for (int i = 0; (i < 10000) && (bench_progress(&bench).stand != state); i++) {
        bench_event(&bench);
    }
    TEST_ASSERT_EQUAL(state, bench_progress(&bench).stand);
}

static void home_the_table(void)
{
    wait_for_stand(TUMBLE_STAND_READY);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_HOME_AXIS));
    wait_for_stand(TUMBLE_STAND_IN_POSITION);
}

static void test_a_validator_homes_and_turns_the_table(void)
{
    home_the_table();
    static const double angles[] = {90.0, 45.5, 380.0, -20.0};
    for (size_t i = 0; i < COUNT_OF(angles); i++) {
        ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_turn(&bench.navcomp, angles[i]));
        TEST_ASSERT_EQUAL(TUMBLE_STAND_MOVING, bench_progress(&bench).stand);
        wait_for_stand(TUMBLE_STAND_IN_POSITION);
        bench_pass(&bench, 0.1);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, angles[i], bench_progress(&bench).angle_deg);
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, run_state());
    const double beyond[] = {380.001, -20.001, NOT_A_NUMBER, INFINITE};
    for (size_t i = 0; i < COUNT_OF(beyond); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_turn(&bench.navcomp, beyond[i]));
    }
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());        /* a run homes again by itself */
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_turn(&bench.navcomp, 10.0)); /* and in DONE it may turn again */
}

static void test_not_before_it_is_homed_nor_in_a_run(void)
{
    wait_for_stand(TUMBLE_STAND_READY);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_navcomp_turn(&bench.navcomp, 10.0));
    start_to_average(1);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_navcomp_turn(&bench.navcomp, 10.0));
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_HOME_AXIS));
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT));
    wait_for_stand(TUMBLE_STAND_STOPPED);
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_turn(&bench.navcomp, 10.0));
}

static void test_abort_and_inhibit_stop_it(void)
{
    home_the_table();
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_turn(&bench.navcomp, 180.0));
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT)); /* no run to give up, but a table to stop */
    wait_for_stand(TUMBLE_STAND_STOPPED);
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_ABORT)); /* neither */
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_turn(&bench.navcomp, 180.0));
    tumble_keeper_inhibit(&keeper, 60);
    wait_for_stand(TUMBLE_STAND_STOPPED);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.inhibited);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_navcomp_turn(&bench.navcomp, 10.0));
}

static void test_a_validator_is_not_interrupted_at_once(void)
{
    settings.flags = TUMBLE_SETS_STARTS;
    board_inhibits = true;
    keeper_power_cycle();
    wait_for_stand(TUMBLE_STAND_READY);
    board_inhibits = false;
    obey_for(59.0, TUMBLE_COMMAND_HOME_AXIS);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, run_state());
    bench_pass(&bench, 2.0);
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_IDLE, run_state());
}

static const around_t around_each = {keeper_power_on, NULL};
