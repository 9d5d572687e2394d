#define _POSIX_C_SOURCE 200809L

#include "bench/options.h"

#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
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

typedef struct {
    bench_options_t *options;
    int count;
    char *const *arguments;
    int next;
    char *wrong;
} reader_t;

static bool complain(reader_t *reader, const char *option, const char *what)
{
    (void)snprintf(reader->wrong, 200, "%.80s%s%s", option, (*what == '\0') ? "" : ": ", what);
    return false;
}

static const char *value_of(reader_t *reader, const char *option)
{
    if (reader->next >= reader->count) {
        (void)complain(reader, option, "needs a value");
        return NULL;
    }
    return reader->arguments[reader->next++];
}

static bool read_whole(reader_t *reader, const char *option, uint64_t low, uint64_t high, uint64_t *value)
{
    const char *const text = value_of(reader, option);
    char *end = NULL;
    if (text == NULL) {
        return false;
    }
    errno = 0;
    *value = strtoull(text, &end, 10);
    if (*text < '0' || *text > '9' || *end != '\0' || errno != 0 || *value < low || *value > high) {
        char what[100];
        (void)snprintf(what, sizeof what, "must be a whole number from %llu to %llu", (unsigned long long)low,
                       (unsigned long long)high);
        return complain(reader, option, what);
    }
    return true;
}

static bool read_u32(reader_t *reader, const char *option, uint32_t low, uint32_t high, uint32_t *value)
{
    uint64_t whole = 0;
    const bool good = read_whole(reader, option, low, high, &whole);
    *value = (uint32_t)whole;
    return good;
}

static bool read_pace(reader_t *reader, const char *option)
{
    const char *const text = value_of(reader, option);
    char *end = NULL;
    if (text == NULL) {
        return false;
    }
    reader->options->pace = strtod(text, &end);
    if (end == text || *end != '\0' || !(reader->options->pace >= 1e-3 && reader->options->pace <= 1e6)) {
        return complain(reader, option, "must be a number from 0.001 to 1000000");
    }
    return true;
}

static bool read_progress_fd(reader_t *reader, const char *option)
{
    uint32_t fd = 0;
    if (!read_u32(reader, option, 0, 1023, &fd)) {
        return false;
    }
    reader->options->progress_fd = (int)fd;
    return true;
}

static bool read_text(reader_t *reader, const char *option, const char **text)
{
    *text = value_of(reader, option);
    if (*text != NULL && **text == '\0') {
        return complain(reader, option, "must not be empty");
    }
    return *text != NULL;
}

typedef struct {
    const char *name;
    size_t offset;
} flag_t;

static bool read_flag(bench_options_t *options, const char *name)
{
    static const flag_t FLAGS[] = {
        {"--means", offsetof(bench_options_t, means)},
        {"--summary", offsetof(bench_options_t, summary)},
        {"--interactive", offsetof(bench_options_t, interactive)},
        {"--keys", offsetof(bench_options_t, keys)},
        {"-v", offsetof(bench_options_t, verbose)},
        {"--version", offsetof(bench_options_t, version)},
        {"--help", offsetof(bench_options_t, help)},
        {"-h", offsetof(bench_options_t, help)},
    };
    for (size_t i = 0; i < sizeof FLAGS / sizeof FLAGS[0]; i++) {
        if (strcmp(name, FLAGS[i].name) == 0) {
            *(bool *)((char *)options + FLAGS[i].offset) = true;
            return true;
        }
    }
    if (strcmp(name, "--progress") == 0) {
        options->progress_fd = STDERR_FILENO;
        return true;
    }
    return false;
}

static bool read_option(reader_t *reader, const char *name)
{
    bench_options_t *const options = reader->options;
    if (read_flag(options, name)) {
        return true;
    }
    if (strcmp(name, "--seed") == 0) {
        return read_whole(reader, name, 0, UINT64_MAX, &options->seed);
    }
    if (strcmp(name, "--runs") == 0) {
        return read_whole(reader, name, 1, 1000000000U, &options->runs);
    }
    if (strcmp(name, "--campaign") == 0) {
        return read_whole(reader, name, 1, 1000000000U, &options->lives);
    }
    if (strcmp(name, "--jobs") == 0) {
        return read_u32(reader, name, 1, BENCH_MAX_JOBS, &options->jobs);
    }
    if (strcmp(name, "--guests") == 0) {
        return read_u32(reader, name, 0, 4, &options->guests);
    }
    if (strcmp(name, "--progress-fd") == 0) {
        return read_progress_fd(reader, name);
    }
    if (strcmp(name, "--pace") == 0) {
        return read_pace(reader, name);
    }
    if (strcmp(name, "--out") == 0) {
        return read_text(reader, name, &options->out);
    }
    if (strcmp(name, "--listen") == 0) {
        return read_text(reader, name, &options->listen);
    }
    if (strcmp(name, "--gain-record") == 0) {
        return read_text(reader, name, &options->gain_record);
    }
    return complain(reader, name, "no such option; see --help");
}

static bool check_lives(reader_t *reader)
{
    const bench_options_t *const options = reader->options;
    if (options->lives == 0U) {
        return !options->verbose || complain(reader, "-v", "needs --campaign");
    }
    if (options->runs > 0U || options->scenario != NULL || options->out != NULL || options->listen != NULL ||
        options->gain_record != NULL || options->interactive || options->pace > 0.0 || options->progress_fd >= 0 ||
        options->means || options->summary) {
        return complain(reader, "--campaign", "takes --seed, --jobs and -v, and nothing else");
    }
    return options->seed <= UINT64_MAX - options->lives ||
           complain(reader, "--campaign", "the seeds would go beyond 2^64 - 1");
}

/* What does not go together. */
static bool check(reader_t *reader)
{
    const bench_options_t *const options = reader->options;
    const bool single = options->out != NULL || options->listen != NULL || options->interactive ||
                        options->pace > 0.0 || options->progress_fd >= 0;
    if (options->runs > 0U && single) {
        return complain(reader, "--runs",
                        "cannot be combined with --out, --progress, --interactive, --pace or --listen");
    }
    if (options->runs > 0U && options->seed > UINT64_MAX - options->runs) {
        return complain(reader, "--runs", "the seeds would go beyond 2^64 - 1");
    }
    if (options->lives > 0U) {
        return true; /* by itself: check_lives */
    }
    if (options->runs == 0U && (options->means || options->summary || options->jobs > 0U)) {
        return complain(reader, "--means, --summary and --jobs", "need --runs");
    }
    if (options->guests > 0U && options->listen == NULL) {
        return complain(reader, "--guests", "needs --listen");
    }
    if (options->interactive && options->scenario != NULL && strcmp(options->scenario, "-") == 0) {
        return complain(reader, "--interactive", "needs standard input for the answers, not for the scenario");
    }
    return true;
}

bool bench_options_read(bench_options_t *options, int count, char *const arguments[], char wrong[200])
{
    *options = (bench_options_t){.seed = 1, .progress_fd = -1};
    reader_t reader = {.options = options, .count = count, .arguments = arguments, .next = 1, .wrong = wrong};
    while (reader.next < count) {
        const char *const argument = arguments[reader.next++];
        if (strncmp(argument, "--", 2) == 0 || strcmp(argument, "-h") == 0 || strcmp(argument, "-v") == 0) {
            if (!read_option(&reader, argument)) {
                return false;
            }
        } else if (options->scenario != NULL || *argument == '\0') {
            return complain(&reader, argument, "only one scenario file can be given");
        } else if (*argument == '-' && argument[1] != '\0') {
            return complain(&reader, argument, "no such option; see --help");
        } else {
            options->scenario = argument;
        }
    }
    if (options->listen != NULL && options->pace == 0.0) {
        options->pace = 1.0;
    }
    return check_lives(&reader) && check(&reader);
}
