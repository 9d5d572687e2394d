#include "conformance.h"

#include "finding.h"

#include <stddef.h>
#include <string.h>

#define IDENTIFIERS (TUMBLE_CAN_MAX_ID + 1U)
#define WAITS 100U /* a frame is waited for so many times transit_us */
#define CLOCK_READINGS 10000U
#define PASSING_US 20000U
#define ORDERED 1000U
#define UNUSED 0xA5U /* bytes that a frame does not have */

static uint64_t now_us(const tumble_port_t *port)
{
    return port->now_us(port->context);
}

static tumble_status_t send(const tumble_port_t *port, const tumble_can_frame_t *frame)
{
    return port->can_send(port->context, frame);
}

static tumble_status_t receive(const tumble_port_t *port, tumble_can_frame_t *frame)
{
    return port->can_receive(port->context, frame);
}

/* Frame `number` of a series: bytes that differ from frame to frame and from place to place. */
static tumble_can_frame_t frame_of(uint32_t number, uint16_t id, uint8_t length)
{
    tumble_can_frame_t frame = {.id = id, .length = length};
    (void)memset(frame.data, UNUSED, sizeof frame.data);
    for (uint32_t i = 0; i < length; i++) {
        frame.data[i] = (uint8_t)((number >> (8U * (i % 4U))) ^ (37U * (i + 1U)));
    }
    return frame;
}

static bool are_equal(const tumble_can_frame_t *one, const tumble_can_frame_t *other)
{
    bool equal = (one->id == other->id) && (one->length == other->length);
    for (uint32_t i = 0; equal && (i < one->length); i++) {
        equal = one->data[i] == other->data[i];
    }
    return equal;
}

/* Send, waiting for room as long as it may take. */
static const char *send_patiently(const conformance_bench_t *bench, const tumble_port_t *port,
                                  const tumble_can_frame_t *frame)
{
    for (uint32_t waits = 0; waits < WAITS; waits++) {
        const tumble_status_t status = send(port, frame);
        if (status == TUMBLE_OK) {
            return NULL;
        }
        if (status != TUMBLE_E_PORT_BUSY) {
            return "sending gives neither OK nor BUSY";
        }
        bench->pass(bench->context, bench->transit_us);
    }
    return "the port stays BUSY";
}

/* Take the next frame, waiting for it as long as it may take; it must be this one. */
static const char *expect(const conformance_bench_t *bench, const tumble_port_t *port, const tumble_can_frame_t *wanted)
{
    tumble_can_frame_t got;
    for (uint32_t waits = 0; waits < WAITS; waits++) {
        (void)memset(&got, 0xFF, sizeof got);
        const tumble_status_t status = receive(port, &got);
        if (status == TUMBLE_OK) {
            return are_equal(wanted, &got) ? NULL : "a frame differs from the one that was sent, or came out of order";
        }
        if (status != TUMBLE_E_PORT_EMPTY) {
            return "receiving gives neither OK nor EMPTY";
        }
        bench->pass(bench->context, bench->transit_us);
    }
    return "a frame does not arrive";
}

static const char *expect_nothing(const conformance_bench_t *bench, const tumble_port_t *port)
{
    tumble_can_frame_t got;
    bench->pass(bench->context, 2U * bench->transit_us);
    const tumble_status_t status = receive(port, &got);
    if (status == TUMBLE_OK) {
        return "a frame arrives that nobody sent, or twice, or its own";
    }
    return (status == TUMBLE_E_PORT_EMPTY) ? NULL : "with nothing there, receiving does not give EMPTY";
}

/* One frame from one port to the other, and nothing else anywhere. */
static const char *pass_one(const conformance_bench_t *bench, const tumble_port_t *from, const tumble_port_t *to,
                            const tumble_can_frame_t *frame)
{
    const char *fault = send_patiently(bench, from, frame);
    return (fault != NULL) ? fault : expect(bench, to, frame);
}

/* The checks. */

static finding_t clock_never_goes_back(const conformance_bench_t *bench)
{
    const tumble_port_t *const ports[] = {bench->a, bench->b};
    for (uint32_t p = 0; p < 2U; p++) {
        uint64_t last = now_us(ports[p]);
        for (uint32_t i = 0; i < CLOCK_READINGS; i++) {
            const uint64_t next = now_us(ports[p]);
            if (next < last) {
                return wrong("the clock goes back");
            }
            last = next;
        }
    }
    return GOOD;
}

static finding_t clock_counts_microseconds(const conformance_bench_t *bench)
{
    const uint64_t before = now_us(bench->a);
    bench->pass(bench->context, PASSING_US);
    const uint64_t passed = now_us(bench->a) - before;
    if (passed < PASSING_US) {
        return wrong("the clock is slow");
    }
    return (passed < (10U * (uint64_t)PASSING_US)) ? GOOD : wrong("the clock is fast");
}

static finding_t nothing_there_is_empty(const conformance_bench_t *bench)
{
    const char *fault = expect_nothing(bench, bench->a);
    return wrong((fault != NULL) ? fault : expect_nothing(bench, bench->b));
}

static finding_t every_length(const conformance_bench_t *bench)
{
    for (uint8_t length = 0; length <= TUMBLE_CAN_MAX_BYTES; length++) {
        const tumble_can_frame_t frame = frame_of(0x5A5A5A5AU, 0x155, length);
        const char *fault = pass_one(bench, bench->a, bench->b, &frame);
        if (fault != NULL) {
            return wrong(fault);
        }
    }
    return wrong(expect_nothing(bench, bench->b));
}

static finding_t every_identifier(const conformance_bench_t *bench)
{
    for (uint32_t id = 0; id < IDENTIFIERS; id++) {
        const tumble_can_frame_t frame = frame_of(id, (uint16_t)id, (uint8_t)(id % 9U));
        const char *fault = pass_one(bench, bench->a, bench->b, &frame);
        if (fault != NULL) {
            return wrong(fault);
        }
    }
    return wrong(expect_nothing(bench, bench->b));
}

static finding_t every_byte(const conformance_bench_t *bench)
{
    for (uint32_t value = 0; value < 256U; value++) {
        tumble_can_frame_t frame = {.id = 0x2AA, .length = TUMBLE_CAN_MAX_BYTES};
        for (uint32_t i = 0; i < TUMBLE_CAN_MAX_BYTES; i++) {
            frame.data[i] = (uint8_t)(value + (31U * i));
        }
        const char *fault = pass_one(bench, bench->a, bench->b, &frame);
        if (fault != NULL) {
            return wrong(fault);
        }
    }
    return GOOD;
}

static finding_t both_directions(const conformance_bench_t *bench)
{
    for (uint32_t i = 0; i < 100U; i++) {
        const tumble_can_frame_t there = frame_of(i, 0x100, 8);
        const tumble_can_frame_t back = frame_of(~i, 0x101, 7);
        const char *fault = pass_one(bench, bench->a, bench->b, &there);
        fault = (fault != NULL) ? fault : pass_one(bench, bench->b, bench->a, &back);
        if (fault != NULL) {
            return wrong(fault);
        }
    }
    return GOOD;
}

static finding_t own_frames_are_not_received(const conformance_bench_t *bench)
{
    const tumble_can_frame_t frame = frame_of(1, 0x123, 8);
    const char *fault = pass_one(bench, bench->a, bench->b, &frame);
    return wrong((fault != NULL) ? fault : expect_nothing(bench, bench->a));
}

/* Many frames of one identifier, a few on the way at any time: they come in the order in which they were sent. */
static finding_t order_is_kept(const conformance_bench_t *bench)
{
    const uint32_t ahead = (bench->burst < 8U) ? bench->burst : 8U;
    for (uint32_t i = 0; i < (ORDERED + ahead); i++) {
        const tumble_can_frame_t next = frame_of(i, 0x300, 8);
        const tumble_can_frame_t due = frame_of(i - ahead, 0x300, 8);
        const char *fault = (i < ORDERED) ? send_patiently(bench, bench->a, &next) : NULL;
        if ((fault == NULL) && (i >= ahead)) {
            fault = expect(bench, bench->b, &due);
        }
        if (fault != NULL) {
            return wrong(fault);
        }
    }
    return wrong(expect_nothing(bench, bench->b));
}

/* As many as the board promises to keep, while nobody looks. */
static finding_t burst_is_kept(const conformance_bench_t *bench)
{
    for (uint32_t i = 0; i < bench->burst; i++) {
        const tumble_can_frame_t frame = frame_of(i, 0x0F0, 8);
        const char *fault = send_patiently(bench, bench->a, &frame);
        if (fault != NULL) {
            return wrong(fault);
        }
    }
    bench->pass(bench->context, bench->burst * bench->transit_us);
    for (uint32_t i = 0; i < bench->burst; i++) {
        const tumble_can_frame_t frame = frame_of(i, 0x0F0, 8);
        const char *fault = expect(bench, bench->b, &frame);
        if (fault != NULL) {
            return wrong(fault);
        }
    }
    return wrong(expect_nothing(bench, bench->b));
}

/* A full queue is BUSY, refuses without harm to what waits in it, and has room again later. */
static finding_t full_queue_is_busy(const conformance_bench_t *bench)
{
    uint32_t sent = 0;
    tumble_status_t status = TUMBLE_OK;
    if (bench->send_limit == 0U) {
        return skipped("the queue cannot be filled here");
    }
    while ((status == TUMBLE_OK) && (sent <= bench->send_limit)) {
        const tumble_can_frame_t frame = frame_of(sent, 0x444, 8);
        status = send(bench->a, &frame);
        sent += (status == TUMBLE_OK) ? 1U : 0U;
    }
    if (status != TUMBLE_E_PORT_BUSY) {
        return wrong((status == TUMBLE_OK) ? "the queue never fills" : "a full queue gives something else than BUSY");
    }
    for (uint32_t i = 0; i < sent; i++) {
        const tumble_can_frame_t frame = frame_of(i, 0x444, 8);
        const char *fault = expect(bench, bench->b, &frame);
        if (fault != NULL) {
            return wrong(fault);
        }
    }
    const tumble_can_frame_t last = frame_of(sent, 0x444, 8);
    const char *fault = pass_one(bench, bench->a, bench->b, &last);
    return wrong((fault != NULL) ? fault : expect_nothing(bench, bench->b));
}

static const char *expect_down(const conformance_bench_t *bench)
{
    const tumble_can_frame_t frame = frame_of(7, 0x070, 8);
    tumble_can_frame_t got;
    if (send(bench->a, &frame) != TUMBLE_E_PORT_DOWN) {
        return "off the bus, sending does not give DOWN";
    }
    if (receive(bench->a, &got) != TUMBLE_E_PORT_DOWN) {
        return "off the bus, receiving does not give DOWN";
    }
    return expect_nothing(bench, bench->b);
}

/* Off the bus is DOWN in both directions, nothing gets out, and afterwards the port works again by itself. */
static finding_t off_the_bus_is_down(const conformance_bench_t *bench)
{
    tumble_can_frame_t got;
    if (bench->set_off == NULL) {
        return skipped("the controller cannot be taken off the bus here");
    }
    bench->set_off(bench->context, true);
    const char *fault = expect_down(bench);
    bench->set_off(bench->context, false);
    for (uint32_t waits = 0; (waits < WAITS) && (receive(bench->a, &got) == TUMBLE_E_PORT_DOWN); waits++) {
        bench->pass(bench->context, bench->transit_us);
    }
    const tumble_can_frame_t frame = frame_of(8, 0x071, 8);
    fault = (fault != NULL) ? fault : pass_one(bench, bench->a, bench->b, &frame);
    return wrong((fault != NULL) ? fault : pass_one(bench, bench->b, bench->a, &frame));
}

static const check_t CHECKS[] = {
    {"the clock never goes back", clock_never_goes_back},
    {"the clock counts microseconds", clock_counts_microseconds},
    {"nothing there is EMPTY", nothing_there_is_empty},
    {"lengths 0 to 8", every_length},
    {"all 2048 identifiers", every_identifier},
    {"every byte in every place", every_byte},
    {"both directions", both_directions},
    {"own frames are not received", own_frames_are_not_received},
    {"order is kept", order_is_kept},
    {"a burst is kept", burst_is_kept},
    {"a full queue is BUSY", full_queue_is_busy},
    {"off the bus is DOWN", off_the_bus_is_down},
};

/* What a failed check has left on the way must not fail the next one. */
static void sweep(const conformance_bench_t *bench)
{
    tumble_can_frame_t frame;
    for (uint32_t taken = 0; taken < (2U * WAITS); taken++) {
        const bool none_a = receive(bench->a, &frame) != TUMBLE_OK;
        const bool none_b = receive(bench->b, &frame) != TUMBLE_OK;
        if (none_a && none_b) {
            bench->pass(bench->context, bench->transit_us);
        }
    }
}

uint32_t conformance_run(const conformance_bench_t *bench)
{
    uint32_t failed = 0;
    for (size_t i = 0; i < (sizeof CHECKS / sizeof CHECKS[0]); i++) {
        if (report_finding(bench, CHECKS[i].name, CHECKS[i].check(bench))) {
            failed++;
            sweep(bench);
        }
    }
    return failed + conformance_run_nv(bench);
}
