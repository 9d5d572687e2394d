/* The navigation computer of this board: waits for the start command over CAN, calibrates, tells on its serial port how
 * it goes. Its result and its counters are read over CAN; the log repeats them. */
#include "configuration.h"
#include "gains.h"
#include "nv_memory.h"
#include "port_zcu102.h"
#include "processor.h"
#include "uart.h"

#include "tumble/navcomp.h"

#include <stdbool.h>
#include <stdint.h>

#define EXIT_ON_CONFIGURATION 2

#ifdef ZCU102_EMULATED
#define NV_ADDRESS 0x1900000U /* where the emulator's loader may put what an earlier run has left */
#endif

static zcu102_port_t port;
static zcu102_can_config_t can_config;
static zcu102_commissioned_t commissioned;
static tumble_navcomp_config_t config;
static tumble_navcomp_t navcomp;
static tumble_drive402_t drive;
static tumble_second_client_t second_client;

static void put_pair(const char *name, uint64_t value)
{
    zcu102_put(name);
    zcu102_put_whole(value);
}

static void log_counters(void)
{
    const zcu102_can_counters_t *can = &port.can.counters;
    put_pair("can: sent ", can->sent);
    put_pair(", received ", can->received);
    put_pair(", busy ", can->busy);
    put_pair(", receive overflows ", can->rx_overflow);
    put_pair(", foreign ", can->foreign);
    put_pair(", bus-off ", can->bus_off);
    zcu102_put("\r\n");
}

static void log_result(void)
{
    tumble_result_t result;
    if (tumble_navcomp_result(&navcomp, &result) != TUMBLE_OK) {
        return;
    }
    zcu102_put("coefficients:");
    for (uint32_t i = 0; i < 9U; i++) {
        zcu102_put(" ");
        zcu102_put_bits(result.coefficients->k_v_per_g[i / 3U][i % 3U]);
    }
    for (uint32_t i = 0; i < 3U; i++) {
        zcu102_put(" ");
        zcu102_put_bits(result.coefficients->u0_v[i]);
    }
    zcu102_put(result.pass ? " pass\r\n" : " fail\r\n");
}

static void log_state(const tumble_progress_t *run)
{
    put_pair("", zcu102_now_us() / 1000U);
    zcu102_put(" ms: ");
    zcu102_put(tumble_state_name(run->state));
    put_pair(" mounting ", run->mounting);
    put_pair(" position ", run->position);
    if (run->reason != TUMBLE_REASON_NONE) {
        zcu102_put(" ");
        zcu102_put(tumble_reason_name(run->reason));
    }
    zcu102_put("\r\n");
}

/* A line when a mounting is asked for or a run ends: what happens at every position would keep the bus waiting. */
static void tell(void)
{
    static tumble_state_t told = TUMBLE_STATE_IDLE;
    tumble_progress_t run;
    tumble_procedure_progress(tumble_navcomp_procedure(&navcomp), &run);
    if (run.state == told) {
        return;
    }
    told = run.state;
    const bool ends =
        (run.state == TUMBLE_STATE_DONE) || (run.state == TUMBLE_STATE_FAULT) || (run.state == TUMBLE_STATE_ABORT);
    if (ends || (run.state == TUMBLE_STATE_PREFLIGHT) || (run.state == TUMBLE_STATE_WAIT_MOUNTING)) {
        log_state(&run);
    }
    if (ends) {
        log_result();
        log_counters();
    }
}

#ifdef NV_ADDRESS
/* For whatever of the firmware keeps something. */
static void find_memory(void)
{
    static tumble_nv_t nv;
    nv = zcu102_nv_memory((uint8_t *)(uintptr_t)NV_ADDRESS);
    port.port.nv = &nv;
}
#endif

static tumble_status_t init(void)
{
    tumble_status_t status = zcu102_configure(&config, &commissioned);
    if (status == TUMBLE_OK) {
        can_config = zcu102_can_for(&config);
        status = zcu102_port_init(&port, &can_config);
    }
#ifdef NV_ADDRESS
    find_memory();
#endif
    commissioned.procedure.lent = zcu102_lent();
    config.port = &port.port;
    config.stand_memory = &drive;
    config.stand_bytes = sizeof drive;
    config.second_client = &second_client;
    return (status == TUMBLE_OK) ? tumble_navcomp_init(&navcomp, &config) : status;
}

int main(void)
{
    zcu102_uart_init();
    const tumble_status_t status = init();
    if (status != TUMBLE_OK) {
        zcu102_put(tumble_status_name(status));
        zcu102_put("\r\n");
        return EXIT_ON_CONFIGURATION;
    }
    zcu102_wake_by(ZCU102_CAN0_INTERRUPT);
    zcu102_put("tumble: waiting for the start command\r\n");
    for (;;) {
        tumble_navcomp_step(&navcomp);
        tell();
        zcu102_sleep_until(tumble_navcomp_next_deadline_us(&navcomp));
    }
}
