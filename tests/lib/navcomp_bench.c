#include "navcomp_bench.h"

bench_t bench;

static void bench_record(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    bench_t *b = context;
    if (taken.ordinal == 1U) {
        b->recorded[taken.index] = 0;
        memset(b->recorded_sum[taken.index], 0, sizeof b->recorded_sum[taken.index]);
    }
    b->recorded[taken.index]++;
    TEST_ASSERT_EQUAL_UINT32(taken.ordinal, b->recorded[taken.index]);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        b->recorded_sum[taken.index][i] += sample->raw.counts[i];
    }
}

static void bench_configure(bench_t *b)
{
    b->averaging = scripted_averaging;
    b->procedure = scripted_procedure;
    b->procedure.averaging = &b->averaging;
    b->procedure.samples = BENCH_SAMPLES;
    b->hooks = (tumble_navcomp_hooks_t){.context = b, .on_sample_averaged = bench_record};
    b->config = scripted_navcomp;
    b->config.port = &b->fake.port;
    b->config.procedure = &b->procedure;
    b->config.hooks = &b->hooks;
    b->config.stand_memory = &b->axis;
    b->config.stand_bytes = sizeof b->axis;
}

void bench_init(bench_t *b)
{
    memset(b, 0, sizeof *b);
    fake_port_init(&b->fake);
    scripted_drive_init(&b->drive, &b->fake);
    scripted_block_init(&b->block, &b->fake, &tumble_schedule_paper.mountings[0]);
    bench_configure(b);
}

void bench_begin(void)
{
    bench_init(&bench);
}

void bench_power_on(bench_t *b)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_init(&b->navcomp, &b->config));
}

tumble_navcomp_progress_t bench_progress(const bench_t *b)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&b->navcomp, &progress);
    return progress;
}

tumble_navcomp_counters_t bench_counters(const bench_t *b)
{
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(&b->navcomp, &counters);
    return counters;
}

static void bench_log(bench_t *b, const tumble_can_frame_t *frame)
{
    TEST_ASSERT_TRUE(b->logged < BENCH_LOG);
    b->log[b->logged++] = (bench_entry_t){b->fake.now_us, b->events, *frame};
}

tumble_status_t bench_command(bench_t *b, tumble_command_t command, uint8_t argument)
{
    const tumble_can_frame_t entry = {.id = BENCH_COMMAND, .data = {(uint8_t)command, argument}};
    bench_log(b, &entry);
    return tumble_navcomp_command(&b->navcomp, command, argument);
}

void bench_inspect(bench_t *b)
{
    fake_queue_t *queue = &b->fake.to_firmware;
    const size_t waiting = queue->count;
    for (size_t i = 0; i < waiting; i++) {
        tumble_can_frame_t frame;
        (void)fake_queue_get(queue, &frame);
        if ((b->spoil != NULL) && !b->spoil(&frame)) {
            continue;
        }
        (void)fake_queue_put(queue, &frame);
        bench_log(b, &frame);
    }
}

void bench_operate(bench_t *b)
{
    const tumble_navcomp_progress_t progress = bench_progress(b);
    if ((progress.run.state == TUMBLE_STATE_WAIT_MOUNTING) && !b->never_confirm) {
        if (!b->keep_mounting) {
            b->block.mounting = &tumble_schedule_paper.mountings[progress.run.mounting - 1U];
        }
        TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(b, TUMBLE_COMMAND_CONFIRM_MOUNTING, progress.run.mounting));
    }
}

void bench_hear(bench_t *b, const tumble_can_frame_t *frame)
{
    scripted_drive_hear(&b->drive, &b->fake, frame);
    scripted_block_hear(&b->block, &b->fake, frame);
}

void bench_play(bench_t *b)
{
    scripted_drive_step(&b->drive, &b->fake);
    scripted_block_step(&b->block, &b->fake, scripted_drive_angle_deg(&b->drive));
}

static uint64_t bench_earliest(uint64_t a_us, uint64_t b_us)
{
    return (a_us < b_us) ? a_us : b_us;
}

void bench_go_on(bench_t *b, uint64_t end_us)
{
    if (b->fake.to_firmware.count == 0U) {
        uint64_t next_us = tumble_navcomp_next_deadline_us(&b->navcomp);
        next_us = bench_earliest(next_us, scripted_drive_next_us(&b->drive));
        next_us = bench_earliest(next_us, scripted_block_next_us(&b->block));
        next_us = bench_earliest(next_us, end_us);
        b->fake.now_us = (next_us > b->fake.now_us) ? next_us : b->fake.now_us;
    }
}

void bench_event(bench_t *b)
{
    tumble_can_frame_t frame;
    b->events++;
    bench_inspect(b);
    tumble_navcomp_step(&b->navcomp);
    while (fake_port_take(&b->fake, &frame)) {
        bench_hear(b, &frame);
    }
    bench_play(b);
    bench_operate(b);
    TEST_ASSERT_FALSE(b->fake.overflowed);
    bench_go_on(b, UINT64_MAX);
}

tumble_state_t bench_run(bench_t *b, tumble_state_t until, double seconds)
{
    const uint64_t end_us = b->fake.now_us + (uint64_t)(seconds * 1e6);
    uint64_t events = 0;
    tumble_state_t state = bench_progress(b).run.state;
    while ((state != until) && (state != TUMBLE_STATE_FAULT) && (state != TUMBLE_STATE_ABORT) &&
           (b->fake.now_us < end_us)) {
        bench_event(b);
        state = bench_progress(b).run.state;
        events++;
        TEST_ASSERT_TRUE_MESSAGE(events < 10000000U, "time stands still");
    }
    return state;
}

void bench_pass(bench_t *b, double seconds)
{
    const uint64_t end_us = b->fake.now_us + (uint64_t)(seconds * 1e6);
    while (b->fake.now_us < end_us) {
        bench_event(b);
    }
}

void power_on_for(double seconds)
{
    bench_power_on(&bench);
    bench_pass(&bench, seconds);
}

void reset_by_nmt(uint8_t command, double seconds)
{
    const tumble_can_frame_t reset = {.id = TUMBLE_NMT_ID, .length = 2, .data = {command, 1}};
    fake_port_give(&bench.fake, &reset);
    bench_pass(&bench, seconds);
}

void bench_start(bench_t *b)
{
    bench_power_on(b);
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(b, TUMBLE_COMMAND_START, 0));
}

void bench_settle(bench_t *b)
{
    int steps = 0;
    do {
        tumble_navcomp_step(&b->navcomp);
        TEST_ASSERT_TRUE(++steps < 100);
    } while (tumble_navcomp_next_deadline_us(&b->navcomp) <= b->fake.now_us);
}

void assert_right_coefficients(void)
{
    tumble_result_t result;
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_result(&bench.navcomp, &result));
    TEST_ASSERT_TRUE(result.pass);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, bench.block.u0_v[i], result.coefficients->u0_v[i]);
        for (int j = 0; j < 3; j++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, bench.block.k_v_per_g[i][j], result.coefficients->k_v_per_g[i][j]);
        }
    }
}
