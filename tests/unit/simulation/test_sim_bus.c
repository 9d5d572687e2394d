/* The bus: order of frames, times to the microsecond, queues, filters, load. */
#include "simulation/bus.h"
#include "simulation/frame_bits.h"
#include "support.h"

enum { NAVCOMP = 0, DRIVE = 1, BLOCK = 2 };
#define MAX_HEARD 128

static sim_clock_t virtual_clock;
static sim_bus_t bus;
static sim_wire_t wire;
static struct {
    uint64_t at_us;
    tumble_can_frame_t frame;
} heard[MAX_HEARD];
static uint32_t heard_count;

static void tap(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    TEST_ASSERT_EQUAL_PTR(&heard_count, context);
    TEST_ASSERT_TRUE(heard_count < MAX_HEARD);
    (void)sender;
    heard[heard_count].at_us = time_us;
    heard[heard_count++].frame = *frame;
}

static void set_up(void)
{
    sim_clock_init(&virtual_clock);
    sim_wire_init(&wire);
    sim_bus_init(&bus, &virtual_clock, &wire, 500000);
    sim_bus_attach(&bus, NAVCOMP, SIM_ACTOR_NAVCOMP);
    sim_bus_attach(&bus, DRIVE, SIM_ACTOR_DRIVE);
    sim_bus_attach(&bus, BLOCK, SIM_ACTOR_BLOCK);
    bus.tap = tap;
    bus.tap_context = &heard_count;
    heard_count = 0;
}

static tumble_can_frame_t frame_of(uint16_t id, uint8_t mark)
{
    return (tumble_can_frame_t){.id = id, .length = 8, .data = {mark, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55}};
}

static void send(uint8_t node, uint16_t id, uint8_t mark)
{
    const tumble_can_frame_t frame = frame_of(id, mark);
    ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, node, &frame));
}

/* Run to the end; the nodes themselves do nothing. Returns how often nodes were woken. */
static uint32_t run(void)
{
    sim_actor_t actor;
    uint32_t woken = 0;
    while (sim_clock_next(&virtual_clock, SIM_NEVER - 1U, &actor)) {
        if (actor == SIM_ACTOR_BUS) {
            sim_bus_on_alarm(&bus);
        } else if (actor == SIM_ACTOR_DELAY) {
            sim_bus_on_delay(&bus);
        } else {
            woken++;
        }
    }
    return woken;
}

static void test_lowest_identifier_wins_among_frames_of_one_moment(void)
{
    send(BLOCK, 0x683, 1); /* handed in first */
    send(DRIVE, 0x182, 2);
    send(NAVCOMP, 0x202, 3);
    send(NAVCOMP, 0x080, 4); /* behind 0x202 in its node's queue: a queue keeps its order */
    (void)run();
    static const uint16_t EXPECTED[] = {0x182, 0x202, 0x080, 0x683};
    TEST_ASSERT_EQUAL_UINT32(4, heard_count);
    for (size_t i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_HEX16(EXPECTED[i], heard[i].frame.id);
    }
}

/* A frame that comes while another is on the wire waits for its end, whatever its priority. */
static void test_a_frame_on_the_wire_is_not_interrupted(void)
{
    sim_actor_t actor;
    send(BLOCK, 0x683, 0);
    TEST_ASSERT_TRUE(sim_clock_next(&virtual_clock, SIM_NEVER - 1U, &actor));
    sim_bus_on_alarm(&bus);
    send(DRIVE, 0x182, 0);
    send(NAVCOMP, 0x000, 0);
    (void)run();
    TEST_ASSERT_EQUAL_HEX16(0x683, heard[0].frame.id);
    TEST_ASSERT_EQUAL_HEX16(0x000, heard[1].frame.id);
    TEST_ASSERT_EQUAL_HEX16(0x182, heard[2].frame.id);
}

/* 500 kbit/s: 2 us a bit. A frame is received 3 bits before the next may begin. */
static void test_times_to_the_bit(void)
{
    const tumble_can_frame_t first = frame_of(0x182, 0x55);
    const tumble_can_frame_t second = frame_of(0x683, 0xFF);
    sim_clock_set(&virtual_clock, SIM_ACTOR_OPERATOR, 1000);
    sim_actor_t actor;
    TEST_ASSERT_TRUE(sim_clock_next(&virtual_clock, SIM_NEVER - 1U, &actor));
    send(DRIVE, 0x182, 0x55);
    send(BLOCK, 0x683, 0xFF);
    (void)run();
    const uint32_t first_bits = sim_frame_bits(&wire, &first);
    const uint32_t second_bits = sim_frame_bits(&wire, &second);
    TEST_ASSERT_EQUAL_UINT64(1000U + 2U * (first_bits - 3U), heard[0].at_us);
    TEST_ASSERT_EQUAL_UINT64(1000U + 2U * (first_bits + second_bits - 3U), heard[1].at_us);
    TEST_ASSERT_EQUAL_UINT64(2, bus.load.frames);
    TEST_ASSERT_EQUAL_UINT64(first_bits + second_bits, bus.load.bits);
    TEST_ASSERT_EQUAL_UINT64(2U * (first_bits + second_bits), bus.load.busy_us);
}

static void test_interframe_space_separates_frames(void)
{
    sim_actor_t actor;
    send(DRIVE, 0x182, 0x55);
    TEST_ASSERT_TRUE(sim_clock_next(&virtual_clock, SIM_NEVER - 1U, &actor)); /* begins */
    sim_bus_on_alarm(&bus);
    TEST_ASSERT_TRUE(sim_clock_next(&virtual_clock, SIM_NEVER - 1U, &actor)); /* ends */
    sim_bus_on_alarm(&bus);
    const uint64_t received_us = virtual_clock.now_us;
    const tumble_can_frame_t answer = frame_of(0x202, 0);
    send(NAVCOMP, 0x202, 0); /* at once */
    send(BLOCK, 0x181, 0);
    (void)run();
    TEST_ASSERT_EQUAL_HEX16(0x181, heard[1].frame.id); /* both were there when the space was over */
    const tumble_can_frame_t other = frame_of(0x181, 0);
    TEST_ASSERT_EQUAL_UINT64(received_us + 6U + 2U * (sim_frame_bits(&wire, &other) - 3U), heard[1].at_us);
    TEST_ASSERT_EQUAL_UINT64(heard[1].at_us + 6U + 2U * (sim_frame_bits(&wire, &answer) - 3U), heard[2].at_us);
}

static void test_everybody_but_the_sender_receives(void)
{
    tumble_can_frame_t frame;
    send(DRIVE, 0x182, 7);
    TEST_ASSERT_EQUAL_UINT32(2, run());
    ASSERT_STATUS(TUMBLE_E_PORT_EMPTY, sim_bus_receive(&bus, DRIVE, &frame));
    ASSERT_STATUS(TUMBLE_OK, sim_bus_receive(&bus, NAVCOMP, &frame));
    TEST_ASSERT_EQUAL_HEX16(0x182, frame.id);
    TEST_ASSERT_EQUAL_UINT8(7, frame.data[0]);
    ASSERT_STATUS(TUMBLE_E_PORT_EMPTY, sim_bus_receive(&bus, NAVCOMP, &frame));
    ASSERT_STATUS(TUMBLE_OK, sim_bus_receive(&bus, BLOCK, &frame));
}

static void test_an_acceptance_filter_keeps_frames_out(void)
{
    tumble_can_frame_t frame;
    sim_bus_set_deaf(&bus, DRIVE, 0x680, 0x6FF);
    send(BLOCK, 0x683, 1);
    send(BLOCK, 0x693, 2);
    send(BLOCK, 0x703, 3);
    (void)run();
    ASSERT_STATUS(TUMBLE_OK, sim_bus_receive(&bus, DRIVE, &frame));
    TEST_ASSERT_EQUAL_HEX16(0x703, frame.id);
    TEST_ASSERT_EQUAL_UINT32(3, bus.nodes[NAVCOMP].counters.received);
}

static void test_full_queues_are_refused_or_counted(void)
{
    tumble_can_frame_t frame = frame_of(0x182, 0);
    for (int n = 0; n < SIM_BUS_TX_DEPTH; n++) {
        send(DRIVE, 0x182, (uint8_t)n);
    }
    ASSERT_STATUS(TUMBLE_E_PORT_BUSY, sim_bus_send(&bus, DRIVE, &frame));
    TEST_ASSERT_EQUAL_UINT32(1, bus.nodes[DRIVE].counters.tx_overflow);
    bus.tap = NULL;
    (void)run();
    for (int n = 0; n < 2 * SIM_BUS_RX_DEPTH; n++) {
        send(DRIVE, 0x182, (uint8_t)(SIM_BUS_TX_DEPTH + n));
        (void)run();
    }
    TEST_ASSERT_EQUAL_UINT32(SIM_BUS_TX_DEPTH + SIM_BUS_RX_DEPTH, bus.nodes[NAVCOMP].counters.rx_overflow);
    for (int n = 0; n < SIM_BUS_RX_DEPTH; n++) { /* the oldest are kept, in order */
        ASSERT_STATUS(TUMBLE_OK, sim_bus_receive(&bus, NAVCOMP, &frame));
        TEST_ASSERT_EQUAL_UINT8(n, frame.data[0]);
    }
    ASSERT_STATUS(TUMBLE_E_PORT_EMPTY, sim_bus_receive(&bus, NAVCOMP, &frame));
}

static void test_a_node_that_is_down_neither_sends_nor_hears(void)
{
    tumble_can_frame_t frame = frame_of(0x182, 0);
    send(DRIVE, 0x182, 1);
    sim_bus_set_down(&bus, DRIVE, true);
    ASSERT_STATUS(TUMBLE_E_PORT_DOWN, sim_bus_send(&bus, DRIVE, &frame));
    ASSERT_STATUS(TUMBLE_E_PORT_DOWN, sim_bus_receive(&bus, DRIVE, &frame));
    send(NAVCOMP, 0x202, 2);
    (void)run();
    TEST_ASSERT_EQUAL_UINT32(1, heard_count);
    TEST_ASSERT_EQUAL_HEX16(0x202, heard[0].frame.id);
    sim_bus_set_down(&bus, DRIVE, false);
    ASSERT_STATUS(TUMBLE_E_PORT_EMPTY, sim_bus_receive(&bus, DRIVE, &frame));
    ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, DRIVE, &frame));
}

static void test_what_is_no_classic_frame_is_refused(void)
{
    tumble_can_frame_t frame = frame_of(0x800, 0);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, sim_bus_send(&bus, DRIVE, &frame));
    frame.id = 0x7FF;
    frame.length = 9;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, sim_bus_send(&bus, DRIVE, &frame));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, sim_bus_send(&bus, 3, &frame));
}

static void test_alarms_of_one_moment_go_off_in_the_actors_order(void)
{
    sim_actor_t actor;
    sim_clock_set(&virtual_clock, SIM_ACTOR_BUS, 50);
    sim_clock_set(&virtual_clock, SIM_ACTOR_NAVCOMP, 50);
    sim_clock_set(&virtual_clock, SIM_ACTOR_BLOCK, 50);
    sim_clock_set(&virtual_clock, SIM_ACTOR_DRIVE, 49);
    static const sim_actor_t EXPECTED[] = {SIM_ACTOR_DRIVE, SIM_ACTOR_BLOCK, SIM_ACTOR_NAVCOMP, SIM_ACTOR_BUS};
    for (size_t i = 0; i < 4; i++) {
        TEST_ASSERT_TRUE(sim_clock_next(&virtual_clock, 50, &actor));
        TEST_ASSERT_EQUAL_INT(EXPECTED[i], actor);
    }
    TEST_ASSERT_FALSE(sim_clock_next(&virtual_clock, SIM_NEVER, &actor));
    sim_clock_set(&virtual_clock, SIM_ACTOR_BUS, 61);
    TEST_ASSERT_FALSE(sim_clock_next(&virtual_clock, 60, &actor));
    TEST_ASSERT_EQUAL_UINT64(50, virtual_clock.now_us);
    sim_clock_set(&virtual_clock, SIM_ACTOR_BUS, 10); /* the past is now */
    TEST_ASSERT_TRUE(sim_clock_next(&virtual_clock, 60, &actor));
    TEST_ASSERT_EQUAL_UINT64(50, virtual_clock.now_us);
}

/* What goes wrong with frames: every kind does what it says, to the frames that it says, and is seen by everybody. */

static sim_bus_fault_t fault_of(sim_frame_fault_t kind, uint32_t count)
{
    sim_bus_fault_t fault = {.kind = kind, .match = 0x683, .mask = 0x7FF, .count = count, .probability = 1.0};
    sim_random_open(&fault.random, 3, SIM_CAUSE_BUS_FAULT, 0);
    return fault;
}

/* Frames 0, 1, ... with their number in the first byte, each sent when the bus is quiet again. */
static void send_numbered(uint16_t id, uint8_t first, uint8_t count)
{
    for (uint8_t n = first; n < first + count; n++) {
        const tumble_can_frame_t frame = {.id = id, .length = 8, .data = {n, 1, 2, 3, 4, 5, 6, 7}};
        ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, BLOCK, &frame));
        (void)run();
    }
}

static void assert_order(const uint8_t *numbers, uint32_t count)
{
    TEST_ASSERT_EQUAL_UINT32(count, heard_count);
    for (uint32_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL_UINT8(numbers[i], heard[i].frame.data[0]);
    }
    TEST_ASSERT_EQUAL_UINT32(count, bus.nodes[NAVCOMP].counters.received);
}

static sim_bus_fault_t begin_fault(sim_frame_fault_t kind, uint32_t count)
{
    const sim_bus_fault_t fault = fault_of(kind, count);
    sim_bus_begin_fault(&bus, 0, &fault);
    return fault;
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
    sim_bus_fault_t fault = begin_fault(SIM_FRAME_DROP, UINT32_MAX);
    send_numbered(0x693, 0, 3);
    TEST_ASSERT_EQUAL_UINT32(3, heard_count);
    fault.mask = 0x7EF; /* both halves of a sample */
    sim_bus_begin_fault(&bus, 0, &fault);
    send_numbered(0x693, 0, 3);
    send_numbered(0x683, 0, 3);
    TEST_ASSERT_EQUAL_UINT32(3, heard_count);
    sim_bus_end_fault(&bus, 0);
    send_numbered(0x683, 0, 3);
    TEST_ASSERT_EQUAL_UINT32(6, heard_count);
}

static void test_a_corrupted_frame_has_one_wrong_bit(void)
{
    (void)begin_fault(SIM_FRAME_CORRUPT, UINT32_MAX);
    send_numbered(0x683, 0, 100);
    uint8_t touched = 0;
    for (uint32_t i = 0; i < 100; i++) {
        int wrong = 0;
        for (uint8_t b = 0; b < 8; b++) {
            const uint8_t sent = (b == 0U) ? (uint8_t)i : b;
            wrong += __builtin_popcount((unsigned)(heard[i].frame.data[b] ^ sent));
            touched = (uint8_t)(touched | ((heard[i].frame.data[b] != sent) ? 1U << b : 0U));
        }
        TEST_ASSERT_EQUAL_INT(1, wrong);
        TEST_ASSERT_EQUAL_UINT8(8, heard[i].frame.length);
    }
    TEST_ASSERT_EQUAL_HEX8(0xFF, touched); /* sooner or later every byte */
}

static void test_a_truncated_frame_lacks_its_last_byte(void)
{
    (void)begin_fault(SIM_FRAME_TRUNCATE, 1);
    send_numbered(0x683, 0, 2);
    TEST_ASSERT_EQUAL_UINT8(7, heard[0].frame.length);
    TEST_ASSERT_EQUAL_UINT8(8, heard[1].frame.length);
}

static void test_a_delayed_frame_comes_later(void)
{
    sim_bus_fault_t fault = fault_of(SIM_FRAME_DELAY, 1);
    fault.delay_us = 5000;
    sim_bus_begin_fault(&bus, 0, &fault);
    for (uint8_t n = 0; n < 3; n++) {
        const tumble_can_frame_t frame = {.id = 0x683, .length = 1, .data = {n}};
        ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, BLOCK, &frame));
    }
    (void)run();
    static const uint8_t ORDER[] = {1, 2, 0};
    assert_order(ORDER, 3);
    TEST_ASSERT_TRUE(heard[2].at_us > 5000U && heard[2].at_us < 5200U);
}

static void test_a_duplicated_frame_comes_twice(void)
{
    (void)begin_fault(SIM_FRAME_DUPLICATE, 1);
    send_numbered(0x683, 0, 2);
    static const uint8_t ORDER[] = {0, 0, 1};
    assert_order(ORDER, 3);
}

static void test_a_reordered_frame_comes_behind_the_next_that_matches(void)
{
    (void)begin_fault(SIM_FRAME_REORDER, 1);
    send_numbered(0x683, 0, 1);
    TEST_ASSERT_EQUAL_UINT32(0, heard_count);
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
    (void)run();
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
            while (sim_bus_receive(&bus, NAVCOMP, &frame) == TUMBLE_OK) {
            }
        }
        received[round] = bus.nodes[NAVCOMP].counters.received;
    }
    TEST_ASSERT_UINT32_WITHIN(38, 900, received[0]);
    TEST_ASSERT_EQUAL_UINT32(received[0], received[1]);
}
