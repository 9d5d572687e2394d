/* tumble-stand: a simulated stand as a process on a CAN interface of Linux. */
#include "arguments.h"
#include "event_log.h"
#include "scenario_file.h"
#include "stand.h"

#include <getopt.h>
#include <string.h>

#define FOREVER_S 1e9

static const char HELP[] =
    "usage: tumble-stand INTERFACE [SCENARIO] [options]\n"
    "\n"
    "A simulated rotary stand on a CAN interface, in real time: its drive (node 2,\n"
    "CiA 402), the accelerometer block on it (node 3), and the operator who mounts\n"
    "the block. Who leads them is on the same interface: tumble-node, a board, or\n"
    "any other CANopen master. INTERFACE is one of Linux, such as vcan0 or can0.\n"
    "SCENARIO is a file of keys (tumble bench --keys lists them).\n"
    "\n"
    "Serves until SIGTERM or SIGINT, waits for the table to be at rest, 5 s at\n"
    "most, and prints one JSON document: the truth, the faults that came, the\n"
    "table, counters.\n"
    "\n"
    "  --seed N         whole number from 0 to 2^64 - 1; default 1\n"
    "  --operator WHAT  who mounts the block, and who tells node 1 so:\n"
    "                   by-itself (or mount; the default): puts it on when node 1\n"
    "                   waits for it, and confirms, after operator.mount_s;\n"
    "                   on-confirm: a script or PLC confirms, and in that moment the\n"
    "                   block is on; tells node 1 nothing;\n"
    "                   never (or none): does nothing, and node 1 waits;\n"
    "                   hands: puts it on at once, and tells node 1 nothing;\n"
    "                   start: as by-itself, and gives the command to start, once;\n"
    "                   ask: does what standard input says, a line for each: done,\n"
    "                   abort, repeat position INDEX, repeat mounting NUMBER\n" EVENT_LOG_AND_PARENT_HELP
    "\n"
    "Exit codes: 0 told to end; 2 bad input, or no such interface; 3 fault; 77 this\n"
    "kernel has no CAN.\n";

static bool take_operator(void *to, const char *what)
{
    stand_options_t *const options = to;
    static const struct {
        const char *name;
        stand_operator_kind_t kind;
    } KINDS[] = {{"by-itself", STAND_OPERATOR_MOUNTS}, {"on-confirm", STAND_OPERATOR_FOLLOWS},
                 {"never", STAND_OPERATOR_NONE},       {"hands", STAND_OPERATOR_HANDS},
                 {"start", STAND_OPERATOR_STARTS},     {"ask", STAND_OPERATOR_ASKS},
                 {"mount", STAND_OPERATOR_MOUNTS},     {"none", STAND_OPERATOR_NONE}};
    for (size_t i = 0; i < sizeof KINDS / sizeof KINDS[0]; i++) {
        if (strcmp(what, KINDS[i].name) == 0) {
            options->operator = KINDS[i].kind;
            return true;
        }
    }
    return arguments_refuse("--operator", "must be by-itself, on-confirm, never, hands, start or ask");
}

static const argument_t OPTIONS[] = {
    ARGUMENT_WHOLE("seed", stand_options_t, seed, 0, UINT64_MAX),
    ARGUMENT_TAKE("operator", take_operator),
    ARGUMENT_WITH_PARENT,
    EVENT_LOG_ARGUMENTS,
};

static const arguments_program_t PROGRAM = {"tumble-stand", HELP, OPTIONS, sizeof OPTIONS / sizeof OPTIONS[0]};

/* The firmware is elsewhere, and there is no end of virtual time. What only the firmware's own process can suffer is
 * not to be had here. */
static bool adapt(bench_config_t *config)
{
    config->virtual_limit_s = FOREVER_S;
    for (uint32_t i = 0; i < config->scenario.fault_count; i++) {
        if (config->scenario.faults[i].kind == SIM_FAULT_BUS_OFF) {
            return arguments_refuse("fault bus_off", "is of the firmware's own controller; take down its interface");
        }
    }
    return true;
}

int main(int count, char *arguments[])
{
    static bench_config_t config;
    stand_options_t options = {.seed = 1, .operator = STAND_OPERATOR_MOUNTS};
    const int code = arguments_read(count, arguments, &PROGRAM, &options);
    if (code != ARGUMENTS_WORK) {
        return code;
    }
    if (!arguments_operands(count - optind, arguments + optind, &options.interface, &options.scenario) ||
        !bench_config_prepare_stand(&config, options.scenario) || !adapt(&config)) {
        return BENCH_EXIT_USAGE;
    }
    return stand_run(&config, &options);
}
