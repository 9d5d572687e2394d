/* tumble-node: the navigation computer as a process on a CAN interface of Linux. */
#include "node.h"
#include "report.h"
#include "scenario_file.h"

#include <stdio.h>

int main(int count, char *arguments[])
{
    static bench_config_t config;
    node_options_t options;
    if (!node_options_read(&options, count, arguments)) {
        return BENCH_EXIT_USAGE;
    }
    if (options.asks != BENCH_ASKS_WORK) {
        return bench_tell("tumble-node", options.asks, node_options_help) ? BENCH_EXIT_PASS : BENCH_EXIT_FAULT;
    }
    if (!bench_config_prepare(&config, options.scenario, options.gains)) {
        return BENCH_EXIT_USAGE;
    }
    if (options.nv != NULL && config.keeping.serial[0] == '\0') {
        (void)fputs("tumble-node: keeper.serial: is missing: with --nv the scenario must name the block\n", stderr);
        return BENCH_EXIT_USAGE;
    }
    return node_run(&config, &options);
}
