#include "node_options.h"

#include "arguments.h"

#include <signal.h>
#include <stddef.h>
#include <sys/prctl.h>
#include <unistd.h>

const char node_options_help[] =
    "usage: tumble-node INTERFACE [SCENARIO] [options]\n"
    "\n"
    "The navigation computer on a CAN interface, in real time: node 1, NMT master,\n"
    "leads the drive (node 2) and averages the accelerometer block (node 3).\n"
    "INTERFACE is one of Linux, such as can0 or vcan0. SCENARIO is a file as of\n"
    "tumble-bench (tumble-bench --keys lists the keys); without it, the paper's\n"
    "stand. Of it count:\n"
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
    "                   (docs/gain-record.md)\n"
    "  --nv FILE        non-volatile memory, 64 kB; made if it is not there, in a\n"
    "                   folder that is; else nothing is kept\n"
    "  --progress       one JSON line on standard error for every step of the\n"
    "                   procedure\n"
    "  --progress-fd N  the same on an open file descriptor\n"
    "  --with-parent    end, as by SIGTERM, when the process that started this one\n"
    "                   has ended\n"
    "  --version        print the version\n"
    "  -h, --help       print this\n"
    "\n"
    "Exit codes: 0 passed, or told to end between two calibrations; 1 the gravity\n"
    "check failed; 2 bad input, or no such interface; 3 fault; 77 this kernel has\n"
    "no CAN; 130 told to end during a calibration.\n";

enum { START = 1, PATIENCE, OUT, GAINS, NV, PROGRESS, PROGRESS_FD, WITH_PARENT };

static const struct option OPTIONS[] = {
    {"start", no_argument, NULL, START},
    {"patience", required_argument, NULL, PATIENCE},
    {"out", required_argument, NULL, OUT},
    {"gain-record", required_argument, NULL, GAINS},
    {"nv", required_argument, NULL, NV},
    {"progress", no_argument, NULL, PROGRESS},
    {"progress-fd", required_argument, NULL, PROGRESS_FD},
    {"with-parent", no_argument, NULL, WITH_PARENT},
    {"help", no_argument, NULL, BENCH_HELP},
    {"version", no_argument, NULL, BENCH_VERSION},
    {0},
};

static bool take_text(const char *option, const char **text)
{
    *text = optarg;
    return *optarg != '\0' || arguments_refuse(option, "must not be empty");
}

static bool take(void *to, int option)
{
    node_options_t *const options = to;
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
    default:
        return false;
    }
}

bool node_options_read(node_options_t *options, int count, char *arguments[])
{
    *options = (node_options_t){.progress_fd = -1};
    if (!arguments_options(count, arguments, OPTIONS, take, options, &options->asks)) {
        return false;
    }
    if (options->asks != BENCH_ASKS_WORK) {
        return true;
    }
    if (!options->start && (options->out != NULL || options->patience_s > 0.0)) {
        return arguments_refuse("--out and --patience", "need --start");
    }
    return arguments_operands(count - optind, arguments + optind, &options->interface, &options->scenario);
}
