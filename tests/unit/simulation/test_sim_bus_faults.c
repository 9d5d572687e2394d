/* What goes wrong with frames: every kind does what it says, to the frames that it says, and is seen by everybody. */
#include "simulation/bus.h"
#include "support.h"

enum { SENDER = 0, RECEIVER = 1 };
#define MAX_SEEN 128

static sim_clock_t virtual_clock;
static sim_wire_t wire;
static sim_bus_t bus;
static tumble_can_frame_t seen[MAX_SEEN];
static uint64_t seen_us[MAX_SEEN];
static uint32_t seen_count;

static void tap(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    (void)context;
    (void)sender;
    TEST_ASSERT_TRUE(seen_count < MAX_SEEN);
    seen_us[seen_count] = time_us;
    seen[seen_count++] = *frame;
}

static void set_up(void)
{
    sim_wire_init(&wire);
    sim_clock_init(&virtual_clock);
    sim_bus_init(&bus, &virtual_clock, &wire, 500000);
    sim_bus_attach(&bus, SENDER, SIM_ACTOR_BLOCK);
    sim_bus_attach(&bus, RECEIVER, SIM_ACTOR_NAVCOMP);
    bus.tap = tap;
    seen_count = 0;
}

static sim_bus_fault_t fault_of(sim_frame_fault_t kind, uint32_t count)
{
    sim_bus_fault_t fault = {.kind = kind, .match = 0x683, .mask = 0x7FF, .count = count, .probability = 1.0};
    sim_random_open(&fault.random, 3, SIM_CAUSE_BUS_FAULT, 0);
    return fault;
}

static void run(void)
{
    sim_actor_t actor;
    while (sim_clock_next(&virtual_clock, SIM_NEVER - 1U, &actor)) {
        if (actor == SIM_ACTOR_BUS) {
            sim_bus_on_alarm(&bus);
        } else if (actor == SIM_ACTOR_DELAY) {
            sim_bus_on_delay(&bus);
        }
    }
}

/* Frames 0, 1, ... with their number in the first byte, each sent when the bus is quiet again. */
static void send_numbered(uint16_t id, uint8_t first, uint8_t count)
{
    for (uint8_t n = first; n < first + count; n++) {
        const tumble_can_frame_t frame = {.id = id, .length = 8, .data = {n, 1, 2, 3, 4, 5, 6, 7}};
        ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, SENDER, &frame));
        run();
    }
}

static void assert_order(const uint8_t *numbers, uint32_t count)
{
    TEST_ASSERT_EQUAL_UINT32(count, seen_count);
    for (uint32_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL_UINT8(numbers[i], seen[i].data[0]);
    }
    TEST_ASSERT_EQUAL_UINT32(count, bus.nodes[RECEIVER].counters.received);
}

static void test_dropped_frames_are_gone(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_DROP, 2);
    fault.skip = 1;
    sim_bus_begin_fault(&bus, 0, &fault);
    send_numbered(0x683, 0, 5);
    static const uint8_t LEFT[] = {0, 3, 4};
    assert_order(LEFT, 3);
}

static void test_other_identifiers_are_spared(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_DROP, UINT32_MAX);
    sim_bus_begin_fault(&bus, 0, &fault);
    send_numbered(0x693, 0, 3);
    TEST_ASSERT_EQUAL_UINT32(3, seen_count);
    fault.mask = 0x7EF; /* both halves of a sample */
    sim_bus_begin_fault(&bus, 0, &fault);
    send_numbered(0x693, 0, 3);
    send_numbered(0x683, 0, 3);
    TEST_ASSERT_EQUAL_UINT32(3, seen_count);
    sim_bus_end_fault(&bus, 0);
    send_numbered(0x683, 0, 3);
    TEST_ASSERT_EQUAL_UINT32(6, seen_count);
}

static void test_a_corrupted_frame_has_one_wrong_bit(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_CORRUPT, UINT32_MAX);
    sim_bus_begin_fault(&bus, 0, &fault);
    send_numbered(0x683, 0, 100);
    uint8_t touched = 0;
    for (uint32_t i = 0; i < 100; i++) {
        int wrong = 0;
        for (uint8_t b = 0; b < 8; b++) {
            const uint8_t sent = (b == 0U) ? (uint8_t)i : b;
            wrong += __builtin_popcount((unsigned)(seen[i].data[b] ^ sent));
            touched = (uint8_t)(touched | ((seen[i].data[b] != sent) ? 1U << b : 0U));
        }
        TEST_ASSERT_EQUAL_INT(1, wrong);
        TEST_ASSERT_EQUAL_UINT8(8, seen[i].length);
    }
    TEST_ASSERT_EQUAL_HEX8(0xFF, touched); /* sooner or later every byte */
}

static void test_a_truncated_frame_lacks_its_last_byte(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_TRUNCATE, 1);
    sim_bus_begin_fault(&bus, 0, &fault);
    send_numbered(0x683, 0, 2);
    TEST_ASSERT_EQUAL_UINT8(7, seen[0].length);
    TEST_ASSERT_EQUAL_UINT8(8, seen[1].length);
}

static void test_a_delayed_frame_comes_later(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_DELAY, 1);
    fault.delay_us = 5000;
    sim_bus_begin_fault(&bus, 0, &fault);
    for (uint8_t n = 0; n < 3; n++) {
        const tumble_can_frame_t frame = {.id = 0x683, .length = 1, .data = {n}};
        ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, SENDER, &frame));
    }
    run();
    static const uint8_t ORDER[] = {1, 2, 0};
    assert_order(ORDER, 3);
    TEST_ASSERT_TRUE(seen_us[2] > 5000U && seen_us[2] < 5200U);
}

static void test_a_duplicated_frame_comes_twice(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_DUPLICATE, 1);
    sim_bus_begin_fault(&bus, 0, &fault);
    send_numbered(0x683, 0, 2);
    static const uint8_t ORDER[] = {0, 0, 1};
    assert_order(ORDER, 3);
}

static void test_a_reordered_frame_comes_behind_the_next_that_matches(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_REORDER, 1);
    sim_bus_begin_fault(&bus, 0, &fault);
    send_numbered(0x683, 0, 1);
    TEST_ASSERT_EQUAL_UINT32(0, seen_count);
    send_numbered(0x693, 10, 1); /* does not match: passes */
    send_numbered(0x683, 1, 2);
    static const uint8_t ORDER[] = {10, 1, 0, 2};
    assert_order(ORDER, 4);
}

static void test_a_fault_that_ends_lets_go_what_it_holds(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_REORDER, 1);
    sim_bus_begin_fault(&bus, 2, &fault);
    send_numbered(0x683, 0, 1);
    sim_bus_end_fault(&bus, 2);
    run();
    static const uint8_t ORDER[] = {0};
    assert_order(ORDER, 1);
}

/* A tenth of 1000 frames: 100 within four standard deviations of 9.5; the same seed picks the same ones. */
static void test_probability_picks_its_share_and_repeats(void)
{
    uint32_t received[2];
    for (int round = 0; round < 2; round++) {
        set_up();
        bus.tap = NULL;
        sim_bus_fault_t fault = fault_of(SIM_FRAME_DROP, UINT32_MAX);
        fault.probability = 0.1;
        sim_bus_begin_fault(&bus, 0, &fault);
        for (int n = 0; n < 100; n++) {
            send_numbered(0x683, 0, 10);
            tumble_can_frame_t frame;
            while (sim_bus_receive(&bus, RECEIVER, &frame) == TUMBLE_OK) {
            }
        }
        received[round] = bus.nodes[RECEIVER].counters.received;
    }
    TEST_ASSERT_UINT32_WITHIN(38, 900, received[0]);
    TEST_ASSERT_EQUAL_UINT32(received[0], received[1]);
}
