/* tumble-stand: a simulated stand as a process on a CAN interface of Linux. */
#include "report.h"
#include "scenario_file.h"
#include "stand.h"

#include <stdio.h>

#define FOREVER_S 1e9

/* The firmware is elsewhere, and there is no end of virtual time. What only the firmware's own process can suffer is
 * not to be had here. */
static bool adapt(bench_config_t *config)
{
    config->virtual_limit_s = FOREVER_S;
    for (uint32_t i = 0; i < config->scenario.fault_count; i++) {
        if (config->scenario.faults[i].kind == SIM_FAULT_BUS_OFF) {
            (void)fputs("tumble-stand: fault bus_off: is of the firmware's own controller; take down its interface\n",
                        stderr);
            return false;
        }
    }
    return true;
}

int main(int count, char *arguments[])
{
    static bench_config_t config;
    stand_options_t options;
    if (!stand_options_read(&options, count, arguments)) {
        return BENCH_EXIT_USAGE;
    }
    if (options.asks != BENCH_ASKS_WORK) {
        return bench_tell("tumble-stand", options.asks, stand_options_help) ? BENCH_EXIT_PASS : BENCH_EXIT_FAULT;
    }
    if (!bench_config_prepare_stand(&config, options.scenario) || !adapt(&config)) {
        return BENCH_EXIT_USAGE;
    }
    return stand_run(&config, &options);
}
