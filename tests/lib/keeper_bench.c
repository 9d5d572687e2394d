#include "keeper_bench.h"

tumble_stand_record_t declared_stand;
tumble_declared_t declared;
bool board_inhibits;

static bool ask_board(void *context)
{
    return *(const bool *)context;
}

void keeper_prepare(void)
{
    bench_init(&bench);
    memory_init(&memory);
    bench.fake.port.nv = &memory.nv;
    board_inhibits = false;
    settings = usual_settings();
    declared_stand = (tumble_stand_record_t){.axis_tilt_rad = 2e-5,
                                             .level_rad = 2e-5,
                                             .remount_rad = 4e-5,
                                             .angle_rad = 4e-5,
                                             .noise_v = 1e-5,
                                             .samples = 1};
    declared = (tumble_declared_t){&declared_stand, NULL, NULL};
    keeper_config = (tumble_keeper_config_t){
        .sets = {.serial = "TB-0001", .settings = &settings, .inhibited = ask_board, .context = &board_inhibits},
        .uncertainty = tumble_navcomp_uncertainty,
        .norm = tumble_navcomp_norm};
    memset(&keeper, 0x5A, sizeof keeper);
    keeper.config = &keeper_config;
    bench.config.keeping = &tumble_keeper_calls;
    bench.config.keeper = &keeper;
    bench.config.declared = &declared;
}

void keeper_power_cycle(void)
{
    const uint64_t now_us = bench.fake.now_us + 1000000U;
    const scripted_block_t block = bench.block;
    fake_port_init(&bench.fake);
    bench.fake.port.nv = &memory.nv;
    bench.fake.now_us = now_us;
    scripted_drive_init(&bench.drive, &bench.fake);
    scripted_block_init(&bench.block, &bench.fake, block.mounting);
    memcpy(bench.block.k_v_per_g, block.k_v_per_g, sizeof block.k_v_per_g);
    memcpy(bench.block.u0_v, block.u0_v, sizeof block.u0_v);
    bench.block.temperature_half_c = block.temperature_half_c;
    bench.logged = 0;
    memset(&keeper, 0xA5, sizeof keeper);
    keeper.config = &keeper_config;
    bench_power_on(&bench);
}

void keeper_power_on(void)
{
    keeper_prepare();
    bench_power_on(&bench);
}

tumble_sets_state_t state_of_keeper(void)
{
    tumble_sets_state_t state;
    tumble_keeper_state(&keeper, &state);
    return state;
}

tumble_state_t run_state(void)
{
    return bench_progress(&bench).run.state;
}

tumble_status_t tell(tumble_command_t command)
{
    return bench_command(&bench, command, 0);
}

tumble_status_t accept_proposal(void)
{
    return tumble_navcomp_accept(&bench.navcomp, tumble_store_proposal(&keeper.store));
}

void drift(double by_v)
{
    for (int i = 0; i < 3; i++) {
        bench.block.u0_v[i] += by_v;
    }
}

void assert_verdict(tumble_verdict_t verdict)
{
    TEST_ASSERT_EQUAL_UINT8(verdict, state_of_keeper().verdict);
}

void settle_to(tumble_verdict_t verdict)
{
    settle_memory();
    assert_verdict(verdict);
}

void assert_objects(uint16_t objections)
{
    TEST_ASSERT_EQUAL_HEX16(objections, state_of_keeper().objections);
}

void obey_for(double seconds, tumble_command_t command)
{
    ASSERT_STATUS(TUMBLE_OK, tell(command));
    bench_pass(&bench, seconds);
}

void decide(tumble_command_t command)
{
    ASSERT_STATUS(TUMBLE_OK, (command == TUMBLE_COMMAND_ACCEPT) ? accept_proposal() : tell(command));
    settle_memory();
}

void assert_state_after(double seconds, tumble_state_t state)
{
    bench_pass(&bench, seconds);
    TEST_ASSERT_EQUAL(state, run_state());
}

void assert_starts_after(double seconds, uint32_t self_started)
{
    bench_pass(&bench, seconds);
    TEST_ASSERT_EQUAL_UINT32(self_started, keeper.counters.self_started);
}

void assert_resumable(uint8_t positions)
{
    TEST_ASSERT_EQUAL_UINT8(positions, state_of_keeper().resumable);
}

void assert_resumable_after_power(uint8_t positions)
{
    keeper_power_cycle();
    assert_resumable(positions);
}

void keeper_power_cycle_for(double seconds)
{
    keeper_power_cycle();
    bench_pass(&bench, seconds);
}

void resume_to_commit(void)
{
    resume_to_end();
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
}

void settle_memory(void)
{
    for (int i = 0; i < 2000; i++) {
        bench_event(&bench);
        if (!state_of_keeper().busy && (keeper.wants == 0U) && (keeper.task == 0U) && !keeper.stale) {
            return;
        }
    }
    TEST_FAIL_MESSAGE("the memory never rests");
}

void run_to_done(void)
{
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
}

tumble_verdict_t run_and_judge(void)
{
    bench.logged = 0;
    run_to_done();
    settle_memory();
    return (tumble_verdict_t)state_of_keeper().verdict;
}

void assert_verdict_after(double drift_v, tumble_verdict_t verdict)
{
    drift(drift_v);
    TEST_ASSERT_EQUAL(verdict, run_and_judge());
}

void hold_one(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
}

tumble_set_t set_of(tumble_which_set_t which)
{
    tumble_set_t set;
    ASSERT_STATUS(TUMBLE_OK, tumble_store_read(&keeper.store, which, &set));
    return set;
}

void run_to_average(uint8_t index)
{
    for (int i = 0; i < 2000000; i++) {
        const tumble_progress_t run = bench_progress(&bench).run;
        if ((run.state == TUMBLE_STATE_AVERAGE) && (run.index == index) && (run.samples > 3U)) {
            return;
        }
        TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_FAULT, run.state);
        TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_DONE, run.state);
        bench_event(&bench);
    }
    TEST_FAIL_MESSAGE("the position is never reached");
}

void start_to_average(uint8_t index)
{
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    run_to_average(index);
}

void settle_and_power_cycle(void)
{
    settle_memory();
    keeper_power_cycle();
}

void start_and_cut(uint8_t index)
{
    start_to_average(index);
    settle_and_power_cycle();
}

void end_and_settle(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    settle_memory();
}

void resume_to_end(void)
{
    obey_for(0.1, TUMBLE_COMMAND_RESUME);
    end_and_settle();
}

void assert_goes_on(uint8_t kept)
{
    assert_resumable_after_power(kept);
    resume_to_commit();
    TEST_ASSERT_EQUAL_UINT32(POSITIONS - kept, bench_counters(&bench).procedure.positions);
}
