/* tumble-node: the navigation computer as a process on a CAN interface of Linux. */
#include "event_log.h"
#include "node.h"
#include "positioner_option.h"
#include "scenario_file.h"

#include <getopt.h>
#include <stdlib.h>
#include <unistd.h>

static const char HELP[] =
    "usage: tumble-node INTERFACE [SCENARIO] [options]\n"
    "\n"
    "The navigation computer on a CAN interface, in real time: node 1, NMT master,\n"
    "leads the drive (node 2) and averages the accelerometer block (node 3).\n"
    "INTERFACE is one of Linux, such as can0 or vcan0. SCENARIO is a file of keys\n"
    "(tumble bench --keys lists them); without it, the paper's stand. Of it count:\n"
    "\n"
    "  profile.*, procedure.*, averaging.*, firmware.*, mounting, position\n"
    "  keeper.*         with --nv, which needs keeper.serial\n"
    "  stand.*, block.noise_v, block.noise_limits\n"
    "                   the errors for which uncertainties are stated\n"
    "  block.scale_v_per_g, block.converter_bits, block.range_v,\n"
    "  block.sample_period_us\n"
    "                   what the block sends\n"
    "  motion.speed_deg_s, motion.acceleration_deg_s2, drive.*\n"
    "                   where the profile leaves something open\n"
    "  operator.tolerance_deg, operator.timeout_ms\n"
    "                   with firmware.stand = operator\n"
    "  limit.virtual_s  with --start\n"
    "\n"
    "All else describes a simulation, block.k and block.u0 above all.\n"
    "\n"
    "Serves until SIGTERM or SIGINT; calibrations are begun by SDO (object 2002h),\n"
    "and each that has ended is one line of JSON on standard output. With --start\n"
    "it begins one at once and ends with it. A mounting is confirmed by SDO, too. A\n"
    "signal stops the table first.\n"
    "\n"
    "  --start          begin a calibration at once, and end with it\n"
    "  --patience S     with --start: wait so many seconds after a fault for a\n"
    "                   command to go on, or until SIGUSR1; else 0\n"
    "  --out DIR        with --start: write run.csv, bus.log and bench.json into a\n"
    "                   new or empty folder\n"
    "  --gain-record F  gain record for procedure.estimator = optimal\n"
    "                   (docs/files.md)\n"
    "  --stand modbus:HOST:PORT[,NAME=NUMBER...]\n"
    "                   the stand is a motor controller with registers, over Modbus\n"
    "                   TCP (docs/porting.md), and not the drive; NAME is unit (1),\n"
    "                   counts_per_deg (10000), window_deg (0.02), home_timeout_ms\n"
    "                   (120000), move_timeout_ms (60000), stop_timeout_ms (2000),\n"
    "                   cycle_ms (20), silence_ms (500), watch_ms (500),\n"
    "                   speed_deg_s (0)\n"
    "  --nv FILE        non-volatile memory, 64 kB; made if it is not there, in a\n"
    "                   folder that is; else nothing is kept\n"
    "  --progress       one JSON line on standard error for every step of the\n"
    "                   procedure; not with --log\n"
    "  --progress-fd N  the same on an open file descriptor\n" EVENT_LOG_AND_PARENT_HELP
    "\n"
    "Exit codes: 0 passed, or told to end between two calibrations; 1 the gravity\n"
    "check failed; 2 bad input, or no such interface; 3 fault; 77 this kernel has\n"
    "no CAN; 130 told to end during a calibration.\n";

static bool take_patience(void *to, const char *text)
{
    node_options_t *const options = to;
    char *end = NULL;
    options->patience_s = strtod(text, &end);
    return (end != text && *end == '\0' && options->patience_s >= 0.0 && options->patience_s <= 1e6) ||
           arguments_refuse("--patience", "must be a number from 0 to 1e+06");
}

static const argument_t OPTIONS[] = {
    ARGUMENT_FLAG("start", node_options_t, start),
    ARGUMENT_TAKE("patience", take_patience),
    ARGUMENT_TEXT("out", node_options_t, out),
    ARGUMENT_TEXT("gain-record", node_options_t, gains),
    ARGUMENT_TAKE("stand", positioner_option_take),
    ARGUMENT_TEXT("nv", node_options_t, nv),
    ARGUMENT_CONSTANT("progress", node_options_t, progress_fd, STDERR_FILENO),
    ARGUMENT_WHOLE("progress-fd", node_options_t, progress_fd, 0, 1023),
    ARGUMENT_WITH_PARENT,
    EVENT_LOG_ARGUMENTS,
};

static const arguments_program_t PROGRAM = {"tumble-node", HELP, OPTIONS, sizeof OPTIONS / sizeof OPTIONS[0]};

/* What no single option can show. */
static bool fit(const node_options_t *options)
{
    if (!options->start && (options->out != NULL || options->patience_s > 0.0)) {
        return arguments_refuse("--out and --patience", "need --start");
    }
    return options->progress_fd != STDERR_FILENO || !event_log_is_on() ||
           arguments_refuse("--progress", "cannot share standard error with --log; --progress-fd has another");
}

int main(int count, char *arguments[])
{
    static bench_config_t config;
    node_options_t options = {.progress_fd = -1};
    const int code = arguments_read(count, arguments, &PROGRAM, &options);
    if (code != ARGUMENTS_WORK) {
        return code;
    }
    if (!fit(&options) ||
        !arguments_operands(count - optind, arguments + optind, &options.interface, &options.scenario) ||
        !bench_config_prepare(&config, options.scenario, options.gains)) {
        return BENCH_EXIT_USAGE;
    }
    if (options.nv != NULL && config.keeping.serial[0] == '\0') {
        return arguments_fail("keeper.serial", "is missing: with --nv the scenario must name the block",
                              BENCH_EXIT_USAGE);
    }
    return node_run(&config, &options);
}
