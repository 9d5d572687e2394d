/* navcomp_bench.h - a navigation computer on a fake port, with a scripted drive and a scripted block around it.
 *
 * Time jumps from event to event, so a whole calibration takes milliseconds.
 */
#ifndef TUMBLE_TESTS_NAVCOMP_BENCH_H
#define TUMBLE_TESTS_NAVCOMP_BENCH_H

#include "fake_port.h"
#include "navcomp/navcomp.h"
#include "scripted_config.h"
#include "suite.h"

#include <string.h>

#define BENCH_SAMPLES 12U
#ifndef BENCH_LOG
#define BENCH_LOG 200000U
#endif
#define BENCH_COMMAND 0xFFFFU /* identifier of a log entry that is a command: its number and argument */

typedef struct {
    uint64_t time_us;
    uint32_t event; /* of the run: entries of one event waited together */
    tumble_can_frame_t frame;
} bench_entry_t;

typedef struct {
    fake_port_t fake;
    scripted_drive_t drive;
    scripted_block_t block;
    tumble_averaging_config_t averaging;
    tumble_procedure_config_t procedure;
    tumble_navcomp_hooks_t hooks;
    tumble_navcomp_config_t config;
    tumble_navcomp_t navcomp;
    bench_entry_t log[BENCH_LOG]; /* what the firmware received */
    size_t logged;
    uint32_t events;
    int64_t recorded_sum[TUMBLE_MAX_POSITIONS][TUMBLE_CHANNELS]; /* by on_sample_averaged */
    uint32_t recorded[TUMBLE_MAX_POSITIONS];
    uint64_t last_averaged_us[TUMBLE_MAX_POSITIONS];
    bool keep_mounting; /* the operator confirms, but leaves the block as it is */
    bool never_confirm;
    /* A test's own hand in what travels; null: nothing. False: the frame is lost. */
    bool (*spoil)(tumble_can_frame_t *frame);
} bench_t;

static inline void bench_record(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    bench_t *bench = context;
    if (taken.ordinal == 1U) {
        bench->recorded[taken.index] = 0;
        memset(bench->recorded_sum[taken.index], 0, sizeof bench->recorded_sum[taken.index]);
    }
    bench->recorded[taken.index]++;
    TEST_ASSERT_EQUAL_UINT32(taken.ordinal, bench->recorded[taken.index]);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        bench->recorded_sum[taken.index][i] += sample->raw.counts[i];
    }
}

static inline void bench_configure(bench_t *bench)
{
    bench->averaging = scripted_averaging;
    bench->procedure = scripted_procedure;
    bench->procedure.averaging = &bench->averaging;
    bench->procedure.samples = BENCH_SAMPLES;
    bench->hooks = (tumble_navcomp_hooks_t){.context = bench, .on_sample_averaged = bench_record};
    bench->config = scripted_navcomp;
    bench->config.port = &bench->fake.port;
    bench->config.procedure = &bench->procedure;
    bench->config.hooks = &bench->hooks;
}

/* Everything but the navcomp itself, which `bench_power_on` starts: a test may change the configuration in between. */
static inline void bench_init(bench_t *bench)
{
    memset(bench, 0, sizeof *bench);
    fake_port_init(&bench->fake);
    scripted_drive_init(&bench->drive, &bench->fake);
    scripted_block_init(&bench->block, &bench->fake, &tumble_schedule_paper.mountings[0]);
    bench_configure(bench);
}

static inline void bench_power_on(bench_t *bench)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_init(&bench->navcomp, &bench->config));
}

static inline tumble_navcomp_progress_t bench_progress(const bench_t *bench)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&bench->navcomp, &progress);
    return progress;
}

static inline tumble_navcomp_counters_t bench_counters(const bench_t *bench)
{
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(&bench->navcomp, &counters);
    return counters;
}

static inline void bench_log(bench_t *bench, const tumble_can_frame_t *frame)
{
    TEST_ASSERT_TRUE(bench->logged < BENCH_LOG);
    bench->log[bench->logged++] = (bench_entry_t){bench->fake.now_us, bench->events, *frame};
}

/* Give a command, and log it. */
static inline tumble_status_t bench_command(bench_t *bench, tumble_command_t command, uint8_t argument)
{
    const tumble_can_frame_t entry = {.id = BENCH_COMMAND, .data = {(uint8_t)command, argument}};
    bench_log(bench, &entry);
    return tumble_navcomp_command(&bench->navcomp, command, argument);
}

/* Spoil and log what waits for the firmware. */
static inline void bench_inspect(bench_t *bench)
{
    fake_queue_t *queue = &bench->fake.to_firmware;
    const size_t waiting = queue->count;
    for (size_t i = 0; i < waiting; i++) {
        tumble_can_frame_t frame;
        (void)fake_queue_get(queue, &frame);
        if ((bench->spoil != NULL) && !bench->spoil(&frame)) {
            continue;
        }
        (void)fake_queue_put(queue, &frame);
        bench_log(bench, &frame);
    }
}

static inline void bench_operate(bench_t *bench)
{
    const tumble_navcomp_progress_t progress = bench_progress(bench);
    if ((progress.run.state == TUMBLE_STATE_WAIT_MOUNTING) && !bench->never_confirm) {
        if (!bench->keep_mounting) {
            bench->block.mounting = &tumble_schedule_paper.mountings[progress.run.mounting - 1U];
        }
        TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(bench, TUMBLE_COMMAND_CONFIRM_MOUNTING, progress.run.mounting));
    }
}

static inline uint64_t bench_earliest(uint64_t a_us, uint64_t b_us)
{
    return (a_us < b_us) ? a_us : b_us;
}

/* One event: the firmware steps, the others hear and answer, time goes on when nothing is left to be done now. */
static inline void bench_event(bench_t *bench)
{
    tumble_can_frame_t frame;
    bench->events++;
    bench_inspect(bench);
    tumble_navcomp_step(&bench->navcomp);
    while (fake_port_take(&bench->fake, &frame)) {
        scripted_drive_hear(&bench->drive, &bench->fake, &frame);
        scripted_block_hear(&bench->block, &bench->fake, &frame);
    }
    scripted_drive_step(&bench->drive, &bench->fake);
    scripted_block_step(&bench->block, &bench->fake, scripted_drive_angle_deg(&bench->drive));
    bench_operate(bench);
    TEST_ASSERT_FALSE(bench->fake.overflowed);
    if (bench->fake.to_firmware.count == 0U) {
        uint64_t next_us = tumble_navcomp_next_deadline_us(&bench->navcomp);
        next_us = bench_earliest(next_us, scripted_drive_next_us(&bench->drive));
        next_us = bench_earliest(next_us, scripted_block_next_us(&bench->block));
        bench->fake.now_us = (next_us > bench->fake.now_us) ? next_us : bench->fake.now_us;
    }
}

/* Until that state, or so many seconds are over; returns the state reached. */
static inline tumble_state_t bench_run(bench_t *bench, tumble_state_t until, double seconds)
{
    const uint64_t end_us = bench->fake.now_us + (uint64_t)(seconds * 1e6);
    uint64_t events = 0;
    tumble_state_t state = bench_progress(bench).run.state;
    while ((state != until) && (state != TUMBLE_STATE_FAULT) && (state != TUMBLE_STATE_ABORT) &&
           (bench->fake.now_us < end_us)) {
        bench_event(bench);
        state = bench_progress(bench).run.state;
        events++;
        TEST_ASSERT_TRUE_MESSAGE(events < 10000000U, "time stands still");
    }
    return state;
}

static inline void bench_pass(bench_t *bench, double seconds)
{
    const uint64_t end_us = bench->fake.now_us + (uint64_t)(seconds * 1e6);
    while (bench->fake.now_us < end_us) {
        bench_event(bench);
    }
}

/* Power on and start; the run is under way. */
static inline void bench_start(bench_t *bench)
{
    bench_power_on(bench);
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_command(bench, TUMBLE_COMMAND_START, 0));
}

#endif
