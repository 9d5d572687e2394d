/* The driver of the CAN controller, against a model of it: conformance, and what no emulator can be brought to do. */
#include "can.h"
#include "conformance_print.h"
#include "controller.h"
#include "suite.h"

#include <string.h>

static uint64_t time_us;

typedef struct {
    zcu102_can_config_t config;
    zcu102_can_t can;
    tumble_port_t port;
} side_t;

static side_t sides[2];
static bool held_off; /* the first controller is killed again and again */

static uint64_t now_us(void *context)
{
    (void)context;
    return time_us;
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    return zcu102_can_send(&((side_t *)context)->can, frame, time_us);
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    return zcu102_can_receive(&((side_t *)context)->can, frame, time_us);
}

/* About 220 us a frame. */
static void pass(void *context, uint32_t us)
{
    (void)context;
    time_us += us;
    controllers_run(1U + us / 220U);
    if (held_off) {
        controller_kill(0);
    }
}

static void set_off(void *context, bool off)
{
    (void)context;
    held_off = off;
    if (off) {
        controller_kill(0);
    }
}

static void init(zcu102_can_layout_t layout)
{
    controllers_init();
    time_us = 1000;
    held_off = false;
    for (uint32_t n = 0; n < 2U; n++) {
        side_t *side = &sides[n];
        side->config = (zcu102_can_config_t){.base = (n == 0U) ? ZCU102_CAN0 : ZCU102_CAN1,
                                             .clock_hz = 100000000,
                                             .bits_per_second = 500000,
                                             .layout = layout};
        side->port =
            (tumble_port_t){.context = side, .now_us = now_us, .can_send = can_send, .can_receive = can_receive};
        TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_can_init(&side->can, &side->config));
    }
}

static void set_up(void)
{
    init(ZCU102_CAN_SILICON);
}

static void tear_down(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, controllers[0].misuse);
    TEST_ASSERT_EQUAL_UINT32(0, controllers[1].misuse);
}

static void conform(void)
{
    const conformance_bench_t bench = {.a = &sides[0].port,
                                       .b = &sides[1].port,
                                       .pass = pass,
                                       .burst = ZCU102_CAN_QUEUE,
                                       .send_limit = ZCU102_CAN_QUEUE,
                                       .transit_us = 300,
                                       .set_off = set_off,
                                       .report = conformance_print};
    TEST_ASSERT_EQUAL_UINT32(0, conformance_run(&bench));
}

static void test_the_driver_conforms(void)
{
    conform();
    init(ZCU102_CAN_EMULATED);
    conform();
}

static tumble_can_frame_t frame_of(uint16_t id, uint8_t first)
{
    return (tumble_can_frame_t){.id = id, .length = 8, .data = {first, 2, 3, 4, 5, 6, 7, 8}};
}

/* Every register as it has to be, for 100 MHz and 500 kbit/s: 25 x (1 + 6 + 1). */
static void test_the_registers(void)
{
    TEST_ASSERT_EQUAL_HEX32(0x2, controllers[0].reg[0x00 / 4]);
    TEST_ASSERT_EQUAL_HEX32(0x0, controllers[0].reg[0x04 / 4]);
    TEST_ASSERT_EQUAL_UINT32(24, controllers[0].reg[0x08 / 4]);
    TEST_ASSERT_EQUAL_HEX32(5, controllers[0].reg[0x0C / 4]); /* jump 1, segment2 1, segment1 6 */
    TEST_ASSERT_EQUAL_HEX32((1U << 9) | (1U << 7) | (1U << 6), controllers[0].reg[0x20 / 4]);
}

static void test_the_words_of_a_frame(void)
{
    const tumble_can_frame_t frame = {
        .id = 0x683, .length = 5, .data = {0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88}};
    TEST_ASSERT_EQUAL(TUMBLE_OK, can_send(&sides[0], &frame));
    TEST_ASSERT_EQUAL_HEX32(0x683U << 21, controllers[0].tx[0].word[0]);
    TEST_ASSERT_EQUAL_HEX32(5U << 28, controllers[0].tx[0].word[1]);
    TEST_ASSERT_EQUAL_HEX32(0x11223344, controllers[0].tx[0].word[2]);
    TEST_ASSERT_EQUAL_HEX32(0x55000000, controllers[0].tx[0].word[3]); /* what is beyond the length does not go out */
}

static void test_a_full_transmit_queue_is_busy_and_counted(void)
{
    const tumble_can_frame_t frame = frame_of(0x123, 1);
    for (uint32_t i = 0; i < ZCU102_CAN_QUEUE; i++) {
        TEST_ASSERT_EQUAL(TUMBLE_OK, can_send(&sides[0], &frame));
    }
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_BUSY, can_send(&sides[0], &frame));
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_BUSY, can_send(&sides[0], &frame));
    TEST_ASSERT_EQUAL_UINT32(2, sides[0].can.counters.busy);
    TEST_ASSERT_EQUAL_UINT32(ZCU102_CAN_QUEUE, sides[0].can.counters.sent);
    controllers_run(1);
    TEST_ASSERT_EQUAL(TUMBLE_OK, can_send(&sides[0], &frame));
}

static void test_an_overflow_of_the_receive_queue_is_counted(void)
{
    tumble_can_frame_t got;
    for (uint32_t i = 0; i < (ZCU102_CAN_QUEUE + 10U); i++) {
        const tumble_can_frame_t frame = frame_of(0x123, (uint8_t)i);
        TEST_ASSERT_EQUAL(TUMBLE_OK, can_send(&sides[0], &frame));
        controllers_run(1);
    }
    for (uint32_t i = 0; i < ZCU102_CAN_QUEUE; i++) {
        TEST_ASSERT_EQUAL(TUMBLE_OK, can_receive(&sides[1], &got));
        TEST_ASSERT_EQUAL_UINT8(i, got.data[0]); /* the newest are lost */
    }
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_EMPTY, can_receive(&sides[1], &got));
    TEST_ASSERT_EQUAL_UINT32(1, sides[1].can.counters.rx_overflow);
    TEST_ASSERT_EQUAL_UINT32(ZCU102_CAN_QUEUE, sides[1].can.counters.received);
}

/* 128 x 11 bits of 2 us are 2816 us. */
static void test_bus_off_is_left_after_the_time_the_standard_wants(void)
{
    const tumble_can_frame_t frame = frame_of(0x123, 1);
    tumble_can_frame_t got;
    controller_kill(0);
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_DOWN, can_receive(&sides[0], &got));
    TEST_ASSERT_EQUAL_HEX32(0, controllers[0].reg[0] & 2U); /* reset, and off */
    time_us += 2815U;
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_DOWN, can_send(&sides[0], &frame));
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_DOWN, can_receive(&sides[0], &got));
    time_us += 1U;
    TEST_ASSERT_EQUAL(TUMBLE_OK, can_send(&sides[0], &frame));
    controllers_run(1);
    TEST_ASSERT_EQUAL(TUMBLE_OK, can_receive(&sides[1], &got));
    TEST_ASSERT_EQUAL_UINT32(1, sides[0].can.counters.bus_off);
    test_the_registers();
}

static void test_bus_off_again_and_again_is_counted(void)
{
    tumble_can_frame_t got;
    for (uint32_t times = 1; times <= 5U; times++) {
        controller_kill(0);
        TEST_ASSERT_EQUAL(TUMBLE_E_PORT_DOWN, can_receive(&sides[0], &got));
        time_us += 3000U;
        TEST_ASSERT_EQUAL(TUMBLE_E_PORT_EMPTY, can_receive(&sides[0], &got));
        TEST_ASSERT_EQUAL_UINT32(times, sides[0].can.counters.bus_off);
    }
}

static void test_foreign_frames_do_not_pass_the_filter(void)
{
    tumble_can_frame_t got;
    const controller_frame_t extended = {{(0x123U << 21) | (1U << 20) | (1U << 19), 8U << 28, 0, 0}};
    const controller_frame_t remote = {{(0x123U << 21) | (1U << 20), 0, 0, 0}};
    const controller_frame_t standard = {{0x123U << 21, 1U << 28, 0x5A000000, 0}};
    controllers_hear(&extended);
    controllers_hear(&remote);
    controllers_hear(&standard);
    TEST_ASSERT_EQUAL(TUMBLE_OK, can_receive(&sides[0], &got));
    TEST_ASSERT_EQUAL_HEX8(0x5A, got.data[0]);
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_EMPTY, can_receive(&sides[0], &got));
    TEST_ASSERT_EQUAL_UINT32(0, sides[0].can.counters.foreign);
}

/* Should one get into the queue nevertheless, it is dropped, counted, and does not hide what stands behind it. */
static void test_foreign_frames_in_the_queue_are_dropped(void)
{
    tumble_can_frame_t got;
    const controller_frame_t extended = {{(0x123U << 21) | (1U << 19), 8U << 28, 0, 0}};
    const controller_frame_t too_long = {{0x124U << 21, 15U << 28, 0x01020304, 0x05060708}};
    controllers[0].rx[0] = extended;
    controllers[0].rx[1] = too_long;
    controllers[0].rx_count = 2;
    controllers[0].reg[0x1C / 4] |= 1U << 7;
    TEST_ASSERT_EQUAL(TUMBLE_OK, can_receive(&sides[0], &got));
    TEST_ASSERT_EQUAL_HEX16(0x124, got.id);
    TEST_ASSERT_EQUAL_UINT8(8, got.length); /* a length beyond 8 means 8 on the wire */
    TEST_ASSERT_EQUAL_UINT32(1, sides[0].can.counters.foreign);
}

static void test_acceptance_filters(void)
{
    static const zcu102_can_filter_t FILTERS[] = {{0x100, 0x7FF}, {0x680, 0x7EF}};
    tumble_can_frame_t got;
    uint32_t passed = 0;
    sides[1].config.filters = FILTERS;
    sides[1].config.filter_count = 2;
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_can_init(&sides[1].can, &sides[1].config));
    for (uint16_t id = 0; id <= TUMBLE_CAN_MAX_ID; id++) {
        const tumble_can_frame_t frame = frame_of(id, 0);
        TEST_ASSERT_EQUAL(TUMBLE_OK, can_send(&sides[0], &frame));
        controllers_run(1);
        while (can_receive(&sides[1], &got) == TUMBLE_OK) {
            TEST_ASSERT_TRUE(got.id == id && (id == 0x100U || id == 0x680U || id == 0x690U));
            passed++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(3, passed);
}

static void test_what_is_refused(void)
{
    const tumble_can_frame_t long_one = {.id = 1, .length = 9};
    const tumble_can_frame_t extended = {.id = 0x800, .length = 0};
    zcu102_can_config_t config = sides[0].config;
    zcu102_can_t can;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, can_send(&sides[0], &long_one));
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, can_send(&sides[0], &extended));
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_can_init(NULL, &config));
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_can_init(&can, NULL));
    config.filter_count = ZCU102_CAN_FILTERS + 1U;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_can_init(&can, &config));
    config.filter_count = 0;
    config.clock_hz = 1000000;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_can_init(&can, &config));
}
