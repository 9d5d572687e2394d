/* The suite passes on the simulated bus, and finds every way in which a port can lie. */
#include "conformance_print.h"
#include "inprocess.h"
#include "suite.h"

#include <string.h>

static inprocess_t inprocess;
static conformance_bench_t bench;
static uint32_t verdicts[3];
static char failed[400]; /* names of the checks that failed, each behind a comma */

static void keep(void *context, const char *check, conformance_verdict_t verdict, const char *why)
{
    conformance_print(context, check, verdict, why);
    verdicts[verdict]++;
    if (verdict == CONFORMANCE_FAILED) {
        (void)strncat(failed, ",", sizeof failed - strlen(failed) - 1U);
        (void)strncat(failed, check, sizeof failed - strlen(failed) - 1U);
    }
    TEST_ASSERT_TRUE((verdict == CONFORMANCE_PASSED) == (why == NULL));
}

static void set_up(void)
{
    memset(verdicts, 0, sizeof verdicts);
    memset(failed, 0, sizeof failed);
    inprocess_init(&inprocess);
    bench = inprocess_bench(&inprocess);
    bench.report = keep;
}

static void test_the_simulated_bus_conforms(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, conformance_run(&bench));
    TEST_ASSERT_EQUAL_UINT32(22, verdicts[CONFORMANCE_PASSED]);
    TEST_ASSERT_EQUAL_UINT32(0, verdicts[CONFORMANCE_SKIPPED]);
}

static void test_what_a_board_cannot_do_is_skipped_not_passed(void)
{
    bench.send_limit = 0;
    bench.set_off = NULL;
    bench.reopen = NULL;
    inprocess.nv.erase_us = 0;
    TEST_ASSERT_EQUAL_UINT32(0, conformance_run(&bench));
    TEST_ASSERT_EQUAL_UINT32(18, verdicts[CONFORMANCE_PASSED]);
    TEST_ASSERT_EQUAL_UINT32(4, verdicts[CONFORMANCE_SKIPPED]);
}

/* Ports with one defect each. `calls` counts what the defect goes by. */

static const tumble_port_t *honest[2];
static tumble_port_t lying[2];
static uint32_t calls;
static tumble_can_frame_t kept;

typedef struct {
    uint32_t number;
} side_t;

static side_t sides[2] = {{0}, {1}};

static const tumble_port_t *port_of(const void *context)
{
    return honest[((const side_t *)context)->number];
}

static uint64_t now_us(void *context)
{
    return port_of(context)->now_us(port_of(context)->context);
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    return port_of(context)->can_send(port_of(context)->context, frame);
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    return port_of(context)->can_receive(port_of(context)->context, frame);
}

static uint64_t clock_that_goes_back(void *context)
{
    calls++;
    return now_us(context) + 5U - (calls % 5000U == 0U ? 1U : 0U);
}

static uint64_t clock_in_milliseconds(void *context)
{
    return now_us(context) / 1000U;
}

static uint64_t clock_in_nanoseconds(void *context)
{
    return now_us(context) * 1000U;
}

static tumble_status_t sends_nothing(void *context, const tumble_can_frame_t *frame)
{
    (void)context;
    (void)frame;
    return TUMBLE_OK;
}

static tumble_status_t loses_one_in_a_hundred(void *context, const tumble_can_frame_t *frame)
{
    calls++;
    return (calls % 100U == 0U) ? TUMBLE_OK : can_send(context, frame);
}

static tumble_status_t sends_twice_now_and_then(void *context, const tumble_can_frame_t *frame)
{
    calls++;
    if (calls % 500U == 0U) {
        (void)can_send(context, frame);
    }
    return can_send(context, frame);
}

static tumble_status_t confuses_the_highest_identifier(void *context, const tumble_can_frame_t *frame)
{
    tumble_can_frame_t other = *frame;
    other.id = (frame->id == TUMBLE_CAN_MAX_ID) ? 0x3FFU : frame->id;
    return can_send(context, &other);
}

static tumble_status_t spoils_the_last_byte(void *context, const tumble_can_frame_t *frame)
{
    tumble_can_frame_t other = *frame;
    other.data[7] &= 0x7FU;
    return can_send(context, &other);
}

static tumble_status_t sends_eight_bytes_always(void *context, const tumble_can_frame_t *frame)
{
    tumble_can_frame_t other = *frame;
    other.length = 8;
    return can_send(context, &other);
}

static tumble_status_t calls_a_full_queue_down(void *context, const tumble_can_frame_t *frame)
{
    const tumble_status_t status = can_send(context, frame);
    return (status == TUMBLE_E_PORT_BUSY) ? TUMBLE_E_PORT_DOWN : status;
}

static tumble_status_t never_busy(void *context, const tumble_can_frame_t *frame)
{
    const tumble_status_t status = can_send(context, frame);
    return (status == TUMBLE_E_PORT_BUSY) ? TUMBLE_OK : status;
}

static tumble_status_t never_down(void *context, const tumble_can_frame_t *frame)
{
    const tumble_status_t status = can_send(context, frame);
    return (status == TUMBLE_E_PORT_DOWN) ? TUMBLE_OK : status;
}

static tumble_status_t down_is_empty(void *context, tumble_can_frame_t *frame)
{
    const tumble_status_t status = can_receive(context, frame);
    return (status == TUMBLE_E_PORT_DOWN) ? TUMBLE_E_PORT_EMPTY : status;
}

static tumble_status_t empty_is_busy(void *context, tumble_can_frame_t *frame)
{
    const tumble_status_t status = can_receive(context, frame);
    return (status == TUMBLE_E_PORT_EMPTY) ? TUMBLE_E_PORT_BUSY : status;
}

static tumble_status_t newest_first(void *context, tumble_can_frame_t *frame)
{
    tumble_can_frame_t second;
    if (kept.length != 0U) {
        *frame = kept;
        kept.length = 0;
        return TUMBLE_OK;
    }
    const tumble_status_t status = can_receive(context, frame);
    if ((status == TUMBLE_OK) && (frame->length != 0U) && (can_receive(context, &second) == TUMBLE_OK)) {
        kept = *frame;
        *frame = second;
    }
    return status;
}

/* What `a` sends comes back to it. */
static tumble_status_t echoes(void *context, const tumble_can_frame_t *frame)
{
    if (((const side_t *)context)->number == 0U) {
        kept = *frame;
    }
    return can_send(context, frame);
}

static tumble_status_t hears_the_echo(void *context, tumble_can_frame_t *frame)
{
    if ((((const side_t *)context)->number == 0U) && (kept.id == 0x123U)) {
        *frame = kept;
        kept.id = 0;
        return TUMBLE_OK;
    }
    return can_receive(context, frame);
}

/* Of frames that wait together, the fortieth is gone. */
static tumble_status_t loses_the_fortieth(void *context, tumble_can_frame_t *frame)
{
    const tumble_status_t status = can_receive(context, frame);
    calls = (status == TUMBLE_OK) ? (calls + 1U) : 0U;
    return (calls == 40U) ? can_receive(context, frame) : status;
}

typedef struct {
    const char *defect;
    tumble_port_t port;
    const char *finds; /* the check that must fail, whatever else does */
} canary_t;

static const canary_t CANARIES[] = {
    {"clock goes back", {NULL, clock_that_goes_back, can_send, can_receive, NULL}, "the clock never goes back"},
    {"milliseconds", {NULL, clock_in_milliseconds, can_send, can_receive, NULL}, "the clock counts microseconds"},
    {"nanoseconds", {NULL, clock_in_nanoseconds, can_send, can_receive, NULL}, "the clock counts microseconds"},
    {"sends nothing", {NULL, now_us, sends_nothing, can_receive, NULL}, "lengths 0 to 8"},
    {"loses frames", {NULL, now_us, loses_one_in_a_hundred, can_receive, NULL}, "order is kept"},
    {"sends twice", {NULL, now_us, sends_twice_now_and_then, can_receive, NULL}, "all 2048 identifiers"},
    {"wrong identifier", {NULL, now_us, confuses_the_highest_identifier, can_receive, NULL}, "all 2048 identifiers"},
    {"wrong byte", {NULL, now_us, spoils_the_last_byte, can_receive, NULL}, "every byte in every place"},
    {"wrong length", {NULL, now_us, sends_eight_bytes_always, can_receive, NULL}, "lengths 0 to 8"},
    {"full is down", {NULL, now_us, calls_a_full_queue_down, can_receive, NULL}, "a full queue is BUSY"},
    {"full is fine", {NULL, now_us, never_busy, can_receive, NULL}, "a full queue is BUSY"},
    {"down is fine", {NULL, now_us, never_down, can_receive, NULL}, "off the bus is DOWN"},
    {"down is empty", {NULL, now_us, can_send, down_is_empty, NULL}, "off the bus is DOWN"},
    {"empty is busy", {NULL, now_us, can_send, empty_is_busy, NULL}, "nothing there is EMPTY"},
    {"newest first", {NULL, now_us, can_send, newest_first, NULL}, "order is kept"},
    {"own frames", {NULL, now_us, echoes, hears_the_echo, NULL}, "own frames are not received"},
    {"small queue", {NULL, now_us, can_send, loses_the_fortieth, NULL}, "a burst is kept"},
};

static void test_every_defect_is_found(void)
{
    for (size_t i = 0; i < (sizeof CANARIES / sizeof CANARIES[0]); i++) {
        set_up();
        calls = 0;
        kept = (tumble_can_frame_t){0};
        for (uint32_t n = 0; n < 2U; n++) {
            honest[n] = &inprocess.ports[n];
            lying[n] = CANARIES[i].port;
            lying[n].context = &sides[n];
        }
        bench.a = &lying[0];
        bench.b = &lying[1];
        (void)printf("-- %s\n", CANARIES[i].defect);
        TEST_ASSERT_TRUE_MESSAGE(conformance_run(&bench) > 0U, CANARIES[i].defect);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(failed, CANARIES[i].finds), CANARIES[i].defect);
    }
}
