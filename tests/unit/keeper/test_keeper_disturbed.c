/* The objection "disturbed": somebody else sends as the block, or as the drive, all through a run. Nothing of it goes into a
 * mean, so only the counters know. */
#include "core/bytes.h"
#include "keeper_world.h"
#include "sample/block_frames.h"

#define UTC_S 1800000000U
#define DISTURBED TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_DISTURBED)
#define REPORT_ID 0x182U
#define MOST_WAITING 8U

/* Who sends what, after each frame of the node that it imitates. */
static struct {
    uint8_t counter_off; /* a second block, whose counter is so far off; 0: there is none */
    double garbled_deg;  /* a report that far off behind every one_in-th true one; 0: none */
    uint32_t one_in;
    uint32_t reports;
    uint32_t waiting;
    tumble_can_frame_t frames[MOST_WAITING];
} stranger;

static void queue(const tumble_can_frame_t *frame)
{
    if (stranger.waiting < MOST_WAITING) {
        stranger.frames[stranger.waiting++] = *frame;
    }
}

static void imitate_block(tumble_can_frame_t frame)
{
    if (frame.id == TUMBLE_BLOCK_ID_XY) {
        frame.data[6] = (uint8_t)(frame.data[6] + stranger.counter_off);
    } else {
        frame.data[3] = (uint8_t)(frame.data[3] + (2U * stranger.counter_off));
    }
    frame.data[7] = tumble_block_frame_crc(&frame);
    queue(&frame);
}

static void garble_report(tumble_can_frame_t frame)
{
    const int32_t off = (int32_t)(stranger.garbled_deg * (double)config.scenario.drive.counts_per_turn / 360.0);
    tumble_put_i32(&frame.data[2], (int32_t)tumble_get_u32(&frame.data[2]) + off);
    queue(&frame);
}

static void hear(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    (void)context;
    (void)time_us;
    const bool is_block = (frame->id == TUMBLE_BLOCK_ID_XY) || (frame->id == TUMBLE_BLOCK_ID_Z);
    if (sender == BENCH_BUS_GUEST) {
        return;
    }
    if (is_block && (stranger.counter_off != 0U)) {
        imitate_block(*frame);
    }
    if ((frame->id == REPORT_ID) && (stranger.one_in != 0U) && (world.progress.finished != 0U) &&
        ((++stranger.reports % stranger.one_in) == 0U)) {
        garble_report(*frame);
    }
}

static void advance_to_the_end(void)
{
    while (bench_world_advance(&world)) {
        for (uint32_t i = 0; i < stranger.waiting; i++) {
            (void)sim_bus_send(&world.bus, BENCH_BUS_GUEST, &stranger.frames[i]);
        }
        stranger.waiting = 0;
    }
}

/* A whole run; its objections. */
static uint16_t run(const char *lines)
{
    static char text[512];
    tumble_sets_state_t state;
    tumble_navcomp_counters_t counters;
    char told[120];
    (void)snprintf(text, sizeof text, "stand.limits = sigma1\noperator.mend_s = -1\n%s", lines);
    memory_init(&memory);
    kept_world_prepare(text);
    kept_world_start(7, UTC_S);
    world.bus.tap = hear;
    advance_to_the_end();
    world_settle();
    tumble_navcomp_counters(&world.navcomp, &counters);
    (void)snprintf(
        told, sizeof told, "%u samples, %u lost, %u reordered, %u repeated, %u corrupted; %u reports not believed",
        (unsigned)counters.procedure.samples, (unsigned)counters.block.lost, (unsigned)counters.block.reordered,
        (unsigned)counters.block.repeated, (unsigned)counters.procedure.corrupted, (unsigned)counters.stop.implausible);
    TEST_MESSAGE(told);
    TEST_ASSERT_EQUAL_INT(WORLD_DONE, world.end);
    tumble_keeper_state(&keeper, &state);
    TEST_ASSERT_EQUAL_UINT8((state.objections == 0U) ? TUMBLE_VERDICT_COMMITTED : TUMBLE_VERDICT_HELD, state.verdict);
    return state.objections;
}

/* A second block, whose counter is so far off; reports garbled behind every one_in-th true one: from a twentieth of the
 * samples on it is an objection. That a block is off the bus for a moment when it is put on anew, and counts on, is none. */
static void test_who_disturbs_is_an_objection(void)
{
    static const struct {
        const char *what;
        uint8_t counter_off;
        double garbled_deg;
        uint32_t one_in;
        uint16_t objections;
        const char *lines;
    } cases[] = {
        {"nobody", 0, 0.0, 0, 0, ""},
        {"a second block", 128, 0.0, 0, DISTURBED, ""},
        {"a second block", 200, 0.0, 0, DISTURBED, ""},
        {"garbled reports", 0, 360.0, 1, DISTURBED, ""},
        {"a few of either", 0, 360.0, 50, 0,
         "fault = lost_samples time=20 count=3\nfault = repeated_samples time=40 count=20\n"},
        {"a block that is handled", 0, 0.0, 0, 0, "fault = block_silent at=2.1 phase=mount duration=0.4\n"},
        {"more than one sample in twenty", 0, 0.0, 0, DISTURBED,
         "fault = frame_duplicate id=0x683 mask=0x7FF time=0 probability=0.06 count=1000000\n"},
        {"less than that", 0, 0.0, 0, 0,
         "fault = frame_duplicate id=0x683 mask=0x7FF time=0 probability=0.04 count=1000000\n"},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        memset(&stranger, 0, sizeof stranger);
        stranger.counter_off = cases[i].counter_off;
        stranger.garbled_deg = cases[i].garbled_deg;
        stranger.one_in = cases[i].one_in;
        TEST_ASSERT_EQUAL_HEX16_MESSAGE(cases[i].objections, run(cases[i].lines), cases[i].what);
    }
}
