#include "bench/options.h"

#include "bench/config_keys.h"

#include <getopt.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char bench_options_help[] =
    "usage: tumble-bench [SCENARIO] [options]\n"
    "\n"
    "Calibrates a simulated accelerometer block on a simulated stand with the real\n"
    "firmware, in virtual time. SCENARIO is a file of key = value lines (--keys\n"
    "lists them), - for standard input; without it the paper's stand. Prints one\n"
    "JSON document, or with --runs one JSON line per run.\n"
    "\n"
    "  --seed N         whole number from 0 to 2^64 - 1; default 1. The same seed\n"
    "                   gives the same bytes\n"
    "  --out DIR        write run.csv, bus.log and bench.json into a folder that is\n"
    "                   new or empty\n"
    "  --gain-record F  the gains of procedure.estimator = optimal\n"
    "                   (docs/gain-record.md)\n"
    "  --progress       one JSON line on standard error for every step of the\n"
    "                   procedure\n"
    "  --progress-fd N  the same on an open file descriptor; when it can't be\n"
    "                   written any more, the run is given up\n"
    "  --interactive    ask for mountings and mended faults: questions go to the\n"
    "                   progress lines, answers come as lines on standard input:\n"
    "                   done, abort, leave, repeat position INDEX, repeat mounting\n"
    "                   NUMBER\n"
    "  --pace X         X virtual seconds per second; default: as fast as it goes\n"
    "  --listen PATH    let others take part in the bus through a local socket\n"
    "                   (host/bench/guests.h); --pace is then 1\n"
    "  --guests N       with --listen: wait for N of them before time begins;\n"
    "                   default 0\n"
    "  --operator WHAT  with --listen: by-itself (the default): mounts and confirms\n"
    "                   after operator.mount_s; on-confirm: a guest confirms, and in\n"
    "                   that moment the block is on; never: nobody mounts\n"
    "\n"
    "  --runs N         N runs with seeds from --seed upwards\n"
    "  --jobs N         on so many processes, 1 to 64; default: all processors\n"
    "  --means          with the means of all positions in every line\n"
    "  --summary        instead of the lines one document with statistics and speed\n"
    "\n"
    "  --campaign N     N hostile lives with seeds from --seed upwards: the firmware\n"
    "                   with its memory under random faults, commands, forged frames\n"
    "                   and losses of power; takes no SCENARIO (host/bench/hostile.h)\n"
    "  -v               tell the events that are enough for a violation\n"
    "\n"
    "  --keys           print the keys of a scenario file\n"
    "  --version        print the version\n"
    "  -h, --help       print this\n"
    "\n"
    "Exit codes: 0 passed, 1 the gravity check failed, 2 bad input or output that\n"
    "cannot be written, 3 fault or a violated invariant, 130 interrupted; of a\n"
    "campaign the worst.\n";

static bool take_pace(void *to, const char *text)
{
    bench_options_t *const options = to;
    char *end = NULL;
    options->pace = strtod(text, &end);
    return (end != text && *end == '\0' && options->pace >= 1e-3 && options->pace <= 1e6) ||
           arguments_refuse("--pace", "must be a number from 0.001 to 1000000");
}

static bool take_operator(void *to, const char *what)
{
    bench_options_t *const options = to;
    const int found = bench_choice(what, "by-itself|on-confirm|never"); /* as bench_operator_t */
    options->operator = (found < 0) ? BENCH_OPERATOR_BY_ITSELF : (bench_operator_t)found;
    return found >= 0 || arguments_refuse("--operator", "must be by-itself, on-confirm or never");
}

#define MOST_RUNS 1000000000U

static const argument_t OPTIONS[] = {
    ARGUMENT_WHOLE("seed", bench_options_t, seed, 0, UINT64_MAX),
    ARGUMENT_TEXT("out", bench_options_t, out),
    ARGUMENT_TEXT("gain-record", bench_options_t, gain_record),
    ARGUMENT_CONSTANT("progress", bench_options_t, progress_fd, STDERR_FILENO),
    ARGUMENT_WHOLE("progress-fd", bench_options_t, progress_fd, 0, 1023),
    ARGUMENT_FLAG("interactive", bench_options_t, interactive),
    ARGUMENT_TAKE("pace", take_pace),
    ARGUMENT_TEXT("listen", bench_options_t, listen),
    ARGUMENT_WHOLE("guests", bench_options_t, guests, 0, 4),
    ARGUMENT_TAKE("operator", take_operator),
    ARGUMENT_WHOLE("runs", bench_options_t, runs, 1, MOST_RUNS),
    ARGUMENT_WHOLE("jobs", bench_options_t, jobs, 1, BENCH_MAX_JOBS),
    ARGUMENT_FLAG("means", bench_options_t, means),
    ARGUMENT_FLAG("summary", bench_options_t, summary),
    ARGUMENT_WHOLE("campaign", bench_options_t, lives, 1, MOST_RUNS),
    ARGUMENT_LETTER('v', bench_options_t, verbose),
    ARGUMENT_FLAG("keys", bench_options_t, keys),
};

static bool check_lives(const bench_options_t *options)
{
    if (options->lives == 0U) {
        return !options->verbose || arguments_refuse("-v", "needs --campaign");
    }
    if (options->runs > 0U || options->scenario != NULL || options->out != NULL || options->listen != NULL ||
        options->gain_record != NULL || options->interactive || options->pace > 0.0 || options->progress_fd >= 0 ||
        options->means || options->summary) {
        return arguments_refuse("--campaign", "takes --seed, --jobs and -v, and nothing else");
    }
    return options->seed <= UINT64_MAX - options->lives ||
           arguments_refuse("--campaign", "the seeds would go beyond 2^64 - 1");
}

/* What does not go together. */
static bool check(const bench_options_t *options)
{
    const bool single = options->out != NULL || options->listen != NULL || options->interactive ||
                        options->pace > 0.0 || options->progress_fd >= 0;
    if (options->runs > 0U && single) {
        return arguments_refuse("--runs",
                                "cannot be combined with --out, --progress, --interactive, --pace or --listen");
    }
    if (options->runs > 0U && options->seed > UINT64_MAX - options->runs) {
        return arguments_refuse("--runs", "the seeds would go beyond 2^64 - 1");
    }
    if (options->lives > 0U) {
        return true; /* by itself: check_lives */
    }
    if (options->runs == 0U && (options->means || options->summary || options->jobs > 0U)) {
        return arguments_refuse("--means, --summary and --jobs", "need --runs");
    }
    if (options->guests > 0U && options->listen == NULL) {
        return arguments_refuse("--guests", "needs --listen");
    }
    if (options->operator != BENCH_OPERATOR_BY_ITSELF && (options->interactive || options->listen == NULL)) {
        return arguments_refuse("--operator", "needs --listen, and no --interactive");
    }
    if (options->interactive && options->scenario != NULL && strcmp(options->scenario, "-") == 0) {
        return arguments_refuse("--interactive", "needs standard input for the answers, not for the scenario");
    }
    return true;
}

static bool take_operands(bench_options_t *options, int count, char *const operands[])
{
    if (count > 1 || (count == 1 && *operands[0] == '\0')) {
        return arguments_refuse(operands[count - 1], "only one scenario file can be given");
    }
    options->scenario = (count == 1) ? operands[0] : NULL;
    return true;
}

bool bench_options_read(bench_options_t *options, int count, char *arguments[])
{
    *options = (bench_options_t){.seed = 1, .progress_fd = -1};
    if (!arguments_read(count, arguments, OPTIONS, sizeof OPTIONS / sizeof OPTIONS[0], options, &options->asks)) {
        return false;
    }
    if (options->asks != BENCH_ASKS_WORK) {
        return true;
    }
    if (!take_operands(options, count - optind, arguments + optind)) {
        return false;
    }
    if (options->listen != NULL && options->pace == 0.0) {
        options->pace = 1.0;
    }
    return check_lives(options) && check(options);
}
