/* The conformance suite on the two CAN controllers of the Zynq UltraScale+, joined by one wire. Results go to the
 * serial port; the exit code is that of a test. */
#include "conformance.h"
#include "nv_memory.h"
#include "port_zcu102.h"
#include "processor.h"
#include "uart.h"

#include <stddef.h>

#ifndef LAYOUT
#error "say where the words of a frame hold what: ZCU102_CAN_SILICON or ZCU102_CAN_EMULATED"
#endif

static zcu102_port_t ports[2];
static uint8_t memory[ZCU102_NV_BYTES];
static tumble_nv_t nv;

static void pass(void *context, uint32_t us)
{
    (void)context;
    const uint64_t end_us = zcu102_now_us() + us;
    while (zcu102_now_us() < end_us) {
        zcu102_sleep_until(end_us);
    }
}

static void report(void *context, const char *check, conformance_verdict_t verdict, const char *why)
{
    static const char *const VERDICTS[] = {"passed   ", "FAILED   ", "skipped  "};
    (void)context;
    zcu102_put(VERDICTS[verdict]);
    zcu102_put(check);
    zcu102_put((why != NULL) ? ": " : "");
    zcu102_put((why != NULL) ? why : "");
    zcu102_put("\r\n");
}

/* One frame more than the queue holds: it must be counted. */
static uint32_t overflow_is_counted(void)
{
    const tumble_can_frame_t frame = {.id = 0x123, .length = 1};
    tumble_can_frame_t got;
    uint32_t received = 0;
    for (uint32_t i = 0; i <= ZCU102_CAN_QUEUE; i++) {
        (void)ports[0].port.can_send(&ports[0], &frame);
        pass(NULL, 300);
    }
    while (ports[1].port.can_receive(&ports[1], &got) == TUMBLE_OK) {
        received++;
    }
    const bool good = (received == ZCU102_CAN_QUEUE) && (ports[1].can.counters.rx_overflow == 1U);
    report(NULL, "an overflow is counted", good ? CONFORMANCE_PASSED : CONFORMANCE_FAILED, good ? NULL : "it is not");
    return good ? 0U : 1U;
}

static const tumble_nv_t *reopen(void *context)
{
    (void)context;
    nv = zcu102_nv_memory(memory);
    return &nv;
}

int main(void)
{
    static const zcu102_can_config_t CONFIGS[2] = {
        {.base = ZCU102_CAN0, .clock_hz = 24000000, .bits_per_second = 500000, .layout = LAYOUT},
        {.base = ZCU102_CAN1, .clock_hz = 24000000, .bits_per_second = 500000, .layout = LAYOUT},
    };
    const conformance_bench_t bench = {.a = &ports[0].port,
                                       .b = &ports[1].port,
                                       .pass = pass,
                                       .burst = ZCU102_CAN_QUEUE,
                                       .send_limit = 0, /* the emulator sends at once */
                                       .transit_us = 300,
                                       .reopen = reopen,
                                       .report = report};
    zcu102_uart_init();
    zcu102_wake_by(ZCU102_CAN0_INTERRUPT);
    uint32_t failed = 0;
    for (uint32_t n = 0; n < 2U; n++) {
        failed += (zcu102_port_init(&ports[n], &CONFIGS[n]) == TUMBLE_OK) ? 0U : 1U;
    }
    ports[0].port.nv = reopen(NULL);
    failed += (failed == 0U) ? (conformance_run(&bench) + overflow_is_counted()) : 0U;
    zcu102_put((failed == 0U) ? "conforms\r\n" : "does not conform\r\n");
    return (failed == 0U) ? 0 : 1;
}
