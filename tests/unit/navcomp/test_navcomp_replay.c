/* A recorded run gives the same bits again, whatever the clock does meanwhile. */
#include "navcomp_bench.h"
#include "support.h"

static bench_t replay; /* the one that hears the record */

static uint32_t shaken; /* a run with disturbances: some frames lost, some with wrong bits */

static bool disturb(tumble_can_frame_t *frame)
{
    const bool block = (frame->id == TUMBLE_BLOCK_ID_XY) || (frame->id == TUMBLE_BLOCK_ID_Z);
    shaken = (shaken * 1664525U) + 1013904223U;
    if (block && ((shaken >> 24U) < 3U)) {
        frame->data[(shaken >> 8U) % 8U] ^= (uint8_t)(1U << ((shaken >> 16U) % 8U));
    }
    return !block || ((shaken >> 24U) != 5U);
}

static void set_up(void)
{
    shaken = 1;
    bench_init(&bench);
    bench.procedure.retries = 200;
    bench.averaging.max_lost = 0;
    bench.spoil = disturb;
    bench_start(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    const tumble_navcomp_counters_t counters = bench_counters(&bench);
    TEST_ASSERT_TRUE(counters.block.wrong_crc > 10U); /* or there would be little to replay */
    TEST_ASSERT_TRUE(counters.block.lost > 10U);
    TEST_ASSERT_TRUE(counters.procedure.retries > 0U);
}

typedef struct {
    const char *what;
    uint64_t offset_us;
    uint32_t percent;     /* of the recorded time that passes */
    uint32_t extra_steps; /* between two entries */
    bool in_batches;      /* frames that waited together do so again; else one by one */
} pace_t;

static void obey(const uint8_t *command)
{
    bench_settle(&replay);
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&replay.navcomp, (tumble_command_t)command[0], command[1]));
}

/* Does the firmware get to see what waits before the next entry comes? */
static bool is_seen(size_t index, const pace_t *pace)
{
    const bool last = (index + 1U) == bench.logged;
    return !pace->in_batches || last || (bench.log[index + 1U].event != bench.log[index].event);
}

static void play(const pace_t *pace)
{
    tumble_can_frame_t sent;
    bench_init(&replay);
    replay.procedure = bench.procedure;
    fake_port_init(&replay.fake); /* without the boot-up messages of its own scripts */
    replay.fake.now_us = pace->offset_us;
    bench_power_on(&replay);
    for (size_t i = 0; i < bench.logged; i++) {
        const bench_entry_t *entry = &bench.log[i];
        replay.fake.now_us = pace->offset_us + ((entry->time_us * pace->percent) / 100U);
        if (entry->frame.id == BENCH_COMMAND) {
            obey(entry->frame.data);
        } else {
            fake_port_give(&replay.fake, &entry->frame);
        }
        for (uint32_t extra = 0; is_seen(i, pace) && (extra <= pace->extra_steps); extra++) {
            bench_settle(&replay);
            replay.fake.now_us += 7U;
        }
        while (fake_port_take(&replay.fake, &sent)) {
            /* nobody listens to a replay */
        }
    }
    bench_settle(&replay);
}

static void assert_same_bits(void)
{
    const tumble_procedure_t *recorded = tumble_navcomp_procedure(&bench.navcomp);
    const tumble_procedure_t *replayed = tumble_navcomp_procedure(&replay.navcomp);
    const tumble_averaging_t *before = tumble_procedure_averages(recorded);
    const tumble_averaging_t *after = tumble_procedure_averages(replayed);
    TEST_ASSERT_EQUAL_STRING("TUMBLE_STATE_DONE", tumble_state_name(bench_progress(&replay).run.state));
    for (int p = 0; p < 18; p++) {
        TEST_ASSERT_EQUAL_UINT32(before->averages[p].samples, after->averages[p].samples);
        TEST_ASSERT_EQUAL_INT64_ARRAY(before->averages[p].sum_counts, after->averages[p].sum_counts, TUMBLE_CHANNELS);
        TEST_ASSERT_EQUAL_MEMORY(before->averages[p].scatter_counts, after->averages[p].scatter_counts,
                                 sizeof before->averages[p].scatter_counts);
        TEST_ASSERT_EQUAL_INT64_ARRAY(bench.recorded_sum[p], replay.recorded_sum[p], TUMBLE_CHANNELS);
    }
    tumble_result_t first;
    tumble_result_t second;
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_procedure_result(recorded, &first));
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_procedure_result(replayed, &second));
    TEST_ASSERT_EQUAL_MEMORY(first.coefficients, second.coefficients, sizeof *first.coefficients);
    TEST_ASSERT_EQUAL_MEMORY(first.check->delta_g_g, second.check->delta_g_g, sizeof first.check->delta_g_g);
}

static void assert_same_counters(void)
{
    const tumble_navcomp_counters_t before = bench_counters(&bench);
    const tumble_navcomp_counters_t after = bench_counters(&replay);
    TEST_ASSERT_EQUAL_UINT32(before.link.received, after.link.received);
    TEST_ASSERT_EQUAL_MEMORY(&before.block, &after.block, sizeof before.block);
    TEST_ASSERT_EQUAL_MEMORY(&before.averaging, &after.averaging, sizeof before.averaging);
    TEST_ASSERT_EQUAL_MEMORY(&before.procedure, &after.procedure, sizeof before.procedure);
}

static void test_the_same_bits_at_any_pace(void)
{
    static const pace_t paces[] = {
        {"the same clock", .percent = 100, .in_batches = true},
        {"frames one by one", .percent = 100},
        {"another epoch", .percent = 100, .offset_us = UINT64_C(1) << 50, .in_batches = true},
        {"many steps between the frames", .percent = 100, .extra_steps = 5},
        {"many steps, a faster clock", .percent = 130, .extra_steps = 1, .in_batches = true},
        {"1 percent", .percent = 1},
        {"10 percent", .percent = 10},
        {"50 percent", .percent = 50},
        {"99 percent", .percent = 99},
        {"101 percent", .percent = 101},
        {"150 percent", .percent = 150},
        {"250 percent", .percent = 250},
        {"400 percent", .percent = 400},
        {"1 percent", .percent = 1, .in_batches = true},
        {"10 percent", .percent = 10, .in_batches = true},
        {"50 percent", .percent = 50, .in_batches = true},
        {"99 percent", .percent = 99, .in_batches = true},
        {"101 percent", .percent = 101, .in_batches = true},
        {"150 percent", .percent = 150, .in_batches = true},
        {"250 percent", .percent = 250, .in_batches = true},
        {"400 percent", .percent = 400, .in_batches = true},
    };
    for (size_t i = 0; i < sizeof paces / sizeof paces[0]; i++) {
        ROW(paces[i].what);
        play(&paces[i]);
        assert_same_bits();
        assert_same_counters();
    }
}

/* Canary: one count more in one averaged sample is not the same bits. */
static void test_a_changed_sample_is_noticed(void)
{
    const tumble_procedure_t *recorded = tumble_navcomp_procedure(&bench.navcomp);
    bool changed = false;
    for (size_t i = bench.logged / 2U; (i < bench.logged) && !changed; i++) {
        tumble_can_frame_t *frame = &bench.log[i].frame;
        if ((frame->id == TUMBLE_BLOCK_ID_XY) && (tumble_block_frame_crc(frame) == frame->data[7])) {
            frame->data[0] ^= 1U;
            frame->data[7] = tumble_block_frame_crc(frame);
            play(&(pace_t){.percent = 100, .in_batches = true});
            changed = memcmp(tumble_procedure_averages(recorded)->averages, replay.navcomp.procedure.averaging.averages,
                             sizeof replay.navcomp.procedure.averaging.averages) != 0;
        }
    }
    TEST_ASSERT_TRUE(changed);
}
