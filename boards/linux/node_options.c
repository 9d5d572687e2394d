#define _GNU_SOURCE /* getopt_long */

#include "node_options.h"

#include "arguments.h"

#include <getopt.h>
#include <signal.h>
#include <stddef.h>
#include <sys/prctl.h>
#include <unistd.h>

const char node_options_help[] =
    "usage: tumble-node INTERFACE [SCENARIO] [options]\n"
    "\n"
    "The navigation computer on a CAN interface, in real time: node 1, NMT master, leads the drive (node\n"
    "2) and averages the accelerometer block (node 3). INTERFACE is one of Linux, such as can0 or vcan0.\n"
    "SCENARIO is a file as of tumble-bench (tumble-bench --keys lists the keys); what it says of drive\n"
    "profile, procedure, averaging, schedule and firmware counts, what it says of the simulation does\n"
    "not.\n"
    "\n"
    "Serves until SIGTERM or SIGINT; calibrations are begun by SDO (object 2002h), and each that has\n"
    "ended is one line of JSON on standard output. With --start it begins one at once and ends with it. A\n"
    "mounting is confirmed by SDO, too. A signal stops the table first.\n"
    "\n"
    "  --start          begin a calibration at once, and end with it\n"
    "  --patience S     with --start: wait so many seconds after a fault for a command to go on, or until\n"
    "                   SIGUSR1; else 0\n"
    "  --out DIR        with --start: write run.csv, bus.log and bench.json into a new or empty folder\n"
    "  --gain-record F  gain record for procedure.estimator = optimal (docs/gain-record.md)\n"
    "  --nv FILE        non-volatile memory, 64 kB; made if it is not there; else nothing is kept\n"
    "  --progress       one JSON line on standard error for every step of the procedure\n"
    "  --progress-fd N  the same on an open file descriptor\n"
    "  --with-parent    end, as by SIGTERM, when the process that started this one has ended\n"
    "  --help           print this\n"
    "\n"
    "Exit codes: 0 passed, or told to end between two calibrations; 1 the gravity check failed; 2 bad\n"
    "input, or no such interface; 3 fault; 77 this kernel has no CAN; 130 told to end during a\n"
    "calibration.\n";

enum { START = 1, PATIENCE, OUT, GAINS, NV, PROGRESS, PROGRESS_FD, WITH_PARENT, HELP };

static const struct option OPTIONS[] = {
    {"start", no_argument, NULL, START},          {"patience", required_argument, NULL, PATIENCE},
    {"out", required_argument, NULL, OUT},        {"progress", no_argument, NULL, PROGRESS},
    {"help", no_argument, NULL, HELP},            {"progress-fd", required_argument, NULL, PROGRESS_FD},
    {"with-parent", no_argument, NULL, WITH_PARENT}, {"gain-record", required_argument, NULL, GAINS},
    {"nv", required_argument, NULL, NV},
    {0},
};

static bool take_text(const char *option, const char **text)
{
    *text = optarg;
    return *optarg != '\0' || arguments_refuse(option, "must not be empty");
}

static bool take(node_options_t *options, int option)
{
    uint64_t fd = 0;
    switch (option) {
    case START:
        options->start = true;
        return true;
    case PATIENCE:
        return arguments_number("--patience", optarg, 0.0, 1e6, &options->patience_s);
    case OUT:
        return take_text("--out", &options->out);
    case GAINS:
        return take_text("--gain-record", &options->gains);
    case NV:
        return take_text("--nv", &options->nv);
    case PROGRESS:
        options->progress_fd = STDERR_FILENO;
        return true;
    case PROGRESS_FD:
        if (!arguments_whole("--progress-fd", optarg, 0, 1023, &fd)) {
            return false;
        }
        options->progress_fd = (int)fd;
        return true;
    case WITH_PARENT:
        return prctl(PR_SET_PDEATHSIG, SIGTERM) == 0;
    case HELP:
        options->help = true;
        return true;
    default:
        return false; /* getopt_long has said what is wrong */
    }
}

bool node_options_read(node_options_t *options, int count, char *arguments[])
{
    int option;
    *options = (node_options_t){.progress_fd = -1};
    while ((option = getopt_long(count, arguments, "", OPTIONS, NULL)) != -1) {
        if (!take(options, option)) {
            return false;
        }
    }
    if (options->help) {
        return true;
    }
    if (!options->start && (options->out != NULL || options->patience_s > 0.0)) {
        return arguments_refuse("--out and --patience", "need --start");
    }
    return arguments_operands(count - optind, arguments + optind, &options->interface, &options->scenario);
}
