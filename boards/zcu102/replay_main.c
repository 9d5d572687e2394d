/* A recording (boards/replay/replay.h), loaded into memory from outside, is replayed on this processor: results go to
 * the serial port, as lines of a name and numbers; those of the coefficients are the bits of doubles. Exit code: 0
 * there is a result, 1 there is none, 2 no recording, or a spoilt commissioning record.
 */
#include "configuration.h"
#include "gains.h"
#include "processor.h"
#include "replay/replay.h"
#include "uart.h"

#include <stddef.h>
#include <stdint.h>

/* Where the loader puts it, and what is free for it: QEMU's 128 MB end at 0x8000000. */
#define RECORDING_ADDRESS 0x2000000U
#define RECORDING_BYTES 0x6000000U

static replay_t replay;
static zcu102_commissioned_t commissioned;
static tumble_navcomp_config_t config;
static tumble_navcomp_t navcomp;
static tumble_drive402_t drive;
static tumble_second_client_t second_client;

static void put_line(const char *name, uint64_t value)
{
    zcu102_put(name);
    zcu102_put(" ");
    zcu102_put_whole(value);
    zcu102_put("\r\n");
}

static void put_name(const char *name, const char *value)
{
    zcu102_put(name);
    zcu102_put(" ");
    zcu102_put(value);
    zcu102_put("\r\n");
}

static void put_bits(const char *name, const double *values, uint32_t count)
{
    zcu102_put(name);
    for (uint32_t i = 0; i < count; i++) {
        zcu102_put(" ");
        zcu102_put_bits(values[i]);
    }
    zcu102_put("\r\n");
}

static void put_counters(void)
{
    tumble_navcomp_counters_t c;
    tumble_navcomp_counters(&navcomp, &c);
    put_line("received", c.link.received);
    put_line("samples", c.procedure.samples);
    put_line("averaged", c.procedure.averaged);
    put_line("lost", c.block.lost);
    put_line("retries", c.procedure.retries);
    put_line("commands_refused", replay.commands_refused);
}

static int tell(void)
{
    tumble_progress_t run;
    tumble_result_t result;
    tumble_procedure_progress(tumble_navcomp_procedure(&navcomp), &run);
    put_name("state", tumble_state_name(run.state));
    put_name("reason", tumble_reason_name(run.reason));
    put_counters();
    if (tumble_navcomp_result(&navcomp, &result) != TUMBLE_OK) {
        return 1;
    }
    put_line("pass", result.pass ? 1U : 0U);
    put_bits("K", &result.coefficients->k_v_per_g[0][0], 9);
    put_bits("U0", result.coefficients->u0_v, 3);
    return 0;
}

int main(void)
{
    const uint8_t *const recording = (const uint8_t *)(uintptr_t)RECORDING_ADDRESS;
    zcu102_uart_init();
    tumble_status_t status = replay_open(&replay, recording, RECORDING_BYTES);
    if (status == TUMBLE_OK) {
        status = zcu102_configure(&config, &commissioned);
    }
    if (status == TUMBLE_OK) {
        commissioned.procedure.lent = zcu102_lent();
        config.port = &replay.port;
        config.stand_memory = &drive;
        config.stand_bytes = sizeof drive;
        config.second_client = &second_client;
        status = tumble_navcomp_init(&navcomp, &config);
    }
    if (status != TUMBLE_OK) {
        zcu102_put("refused ");
        zcu102_put(tumble_status_name(status));
        zcu102_put("\r\n");
        return 2;
    }
    replay_run(&replay, &navcomp, NULL, NULL);
    const int code = tell();
    zcu102_put("end\r\n");
    return code;
}
