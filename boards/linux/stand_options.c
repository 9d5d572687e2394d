#include "stand_options.h"

#include "event_log.h"
#include "signals.h"

#include <getopt.h>
#include <stddef.h>
#include <string.h>

const char stand_options_help[] =
    "usage: tumble-stand INTERFACE [SCENARIO] [options]\n"
    "\n"
    "A simulated rotary stand on a CAN interface, in real time: its drive (node 2,\n"
    "CiA 402), the accelerometer block on it (node 3), and the operator who mounts\n"
    "the block. Who leads them is on the same interface: tumble-node, a board, or\n"
    "any other CANopen master. INTERFACE is one of Linux, such as vcan0 or can0.\n"
    "SCENARIO is a file as of tumble-bench (tumble-bench --keys lists the keys).\n"
    "\n"
    "Serves until SIGTERM or SIGINT, waits for the table to be at rest, 5 s at\n"
    "most, and prints one JSON document: the truth, the faults that came, the\n"
    "table, counters.\n"
    "\n"
    "  --seed N         whole number from 0 to 2^64 - 1; default 1\n"
    "  --operator WHAT  none: does nothing; mount: answers node 1 when it waits for\n"
    "                   a mounting; start: gives the command to start as well,\n"
    "                   once; ask: does what standard input says, a line for each:\n"
    "                   done, abort, repeat position INDEX, repeat mounting NUMBER;\n"
    "                   hands: mounts and mends at once and tells node 1 nothing:\n"
    "                   a script or PLC does; default: mount\n"
    "  --log FORM       tell every event on standard error, a line for each: text or\n"
    "                   json (docs/logs.md)\n"
    "  --log-level WHAT error, warning, notice or info: this and what is worse;\n"
    "                   default: info\n"
    "  --with-parent    end, as by SIGTERM, when the process that started this one\n"
    "                   has ended\n"
    "  --version        print the version\n"
    "  -h, --help       print this\n"
    "\n"
    "Exit codes: 0 told to end; 2 bad input, or no such interface; 3 fault; 77 this\n"
    "kernel has no CAN.\n";

static bool take_operator(void *to, const char *what)
{
    stand_options_t *const options = to;
    static const char *const KINDS[] = {"none", "mount", "start", "ask", "hands"}; /* as stand_operator_kind_t */
    for (unsigned kind = 0; kind < sizeof KINDS / sizeof KINDS[0]; kind++) {
        if (strcmp(what, KINDS[kind]) == 0) {
            options->operator = (stand_operator_kind_t)kind;
            return true;
        }
    }
    return arguments_refuse("--operator", "must be none, mount, start, ask or hands");
}

static const argument_t OPTIONS[] = {
    ARGUMENT_WHOLE("seed", stand_options_t, seed, 0, UINT64_MAX),
    ARGUMENT_TAKE("operator", take_operator),
    ARGUMENT_CALL("with-parent", signals_with_parent),
    EVENT_LOG_ARGUMENTS,
};

bool stand_options_read(stand_options_t *options, int count, char *arguments[])
{
    *options = (stand_options_t){.seed = 1, .operator = STAND_OPERATOR_MOUNTS};
    if (!arguments_read(count, arguments, OPTIONS, sizeof OPTIONS / sizeof OPTIONS[0], options, &options->asks)) {
        return false;
    }
    return options->asks != BENCH_ASKS_WORK ||
           arguments_operands(count - optind, arguments + optind, &options->interface, &options->scenario);
}
