/* tumble-replay: a recorded bus log goes through the firmware again, in virtual time. */

#include "bench/arguments.h"
#include "bench/config.h"
#include "bench/folder.h"
#include "bench/report.h"
#include "bench/world.h"
#include "commissioning.h"
#include "log.h"
#include "replay/replay.h"

#include <errno.h>
#include <getopt.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char HELP[] =
    "usage: tumble-replay BUS.log [SCENARIO] [options]\n"
    "       tumble-replay --commissioning FILE [SCENARIO]\n"
    "\n"
    "Feeds the recorded frames of everyone but node 1 (candump -L), in order and at\n"
    "their recorded times, to the firmware of node 1, in virtual time, and ignores\n"
    "what it sends: the coefficients come out with the same bits. SCENARIO is the\n"
    "one of the recorded run (inputs/scenario.txt of a run folder); without it the\n"
    "paper's stand. Commands that did not travel over the bus are given where the\n"
    "log shows that they were. Prints one JSON document.\n"
    "\n"
    "  --out DIR        write run.csv, bus.log and bench.json into a folder that is\n"
    "                   new or empty\n"
    "  --recording FILE write the recording for the board zcu102 instead of\n"
    "                   replaying it here\n"
    "  --commissioning FILE\n"
    "                   write the record that tells the board zcu102 what SCENARIO\n"
    "                   says of its stand and block\n"
    "  --gain-record F  the gains of procedure.estimator = optimal\n"
    "                   (inputs/gains.bin of a run folder)\n"
    "  --version        print the version\n"
    "  -h, --help       print this\n"
    "\n"
    "Exit codes: 0 passed, 1 the gravity check failed, 2 bad input, 3 the run does\n"
    "not come to a result.\n";

typedef struct {
    const char *log;
    const char *scenario;
    const char *out;
    const char *recording;
    const char *commissioning;
    const char *gain_record;
    bench_asks_t asks;
} options_t;

typedef struct {
    const options_t *options;
    bench_world_t world; /* of it the configuration, the firmware, its progress and the time are in use */
    bench_folder_t folder;
    replay_t replay;
} replay_run_t;

/* The log, unless a commissioning record is asked for; then the scenario. */
static bool read_operands(options_t *options, int count, char *operands[])
{
    const int logs = (options->commissioning != NULL) ? 0 : 1;
    if (count < logs || count > logs + 1) {
        return arguments_refuse("arguments", "a log, and at most one scenario; see --help");
    }
    options->log = (logs == 1) ? operands[0] : NULL;
    options->scenario = (count > logs) ? operands[logs] : NULL;
    return true;
}

static const argument_t OPTIONS[] = {
    ARGUMENT_ANY_TEXT("out", options_t, out),
    ARGUMENT_ANY_TEXT("recording", options_t, recording),
    ARGUMENT_ANY_TEXT("commissioning", options_t, commissioning),
    ARGUMENT_ANY_TEXT("gain-record", options_t, gain_record),
};

static bool read_options(options_t *options, int count, char *arguments[])
{
    *options = (options_t){0};
    return arguments_read(count, arguments, OPTIONS, sizeof OPTIONS / sizeof OPTIONS[0], options, &options->asks) &&
           (options->asks != BENCH_ASKS_WORK || read_operands(options, count - optind, arguments + optind));
}

static bool read_log(bus_log_t *log, const char *path)
{
    FILE *const file = fopen(path, "r");
    size_t line = 0;
    if (file == NULL) {
        return arguments_refuse(path, strerror(errno));
    }
    const char *const wrong = log_read(log, file, &line);
    (void)fclose(file);
    return wrong == NULL || arguments_refuse_line(path, line, wrong);
}

/* For the board. */

static int write_file(const char *path, const uint8_t *bytes, size_t size)
{
    FILE *const file = (bytes != NULL) ? fopen(path, "wb") : NULL;
    bool good = file != NULL && fwrite(bytes, 1, size, file) == size;
    good = file != NULL && fclose(file) == 0 && good;
    return good ? BENCH_EXIT_PASS : arguments_fail(path, "cannot be written", BENCH_EXIT_USAGE);
}

static int write_commissioning(const char *path, const bench_config_t *config)
{
    static zcu102_commissioned_t commissioned;
    static uint8_t record[ZCU102_COMMISSIONING_BYTES];
    const tumble_navcomp_config_t navcomp = bench_navcomp_config(config, NULL, NULL, NULL);
    if (zcu102_commission(&commissioned, &navcomp) != TUMBLE_OK) {
        return arguments_fail("the board zcu102 cannot do this run",
                              "it needs a drive, with a profile and mountings that fit its record", BENCH_EXIT_USAGE);
    }
    return write_file(path, record, zcu102_commissioning_write(&commissioned, record));
}

static int write_recording(const char *path, const bus_log_t *log, const bench_config_t *config)
{
    size_t size = 0;
    uint8_t *const recording = log_recording(log, config, &size);
    const int code = write_file(path, recording, size);
    free(recording);
    return code;
}

/* Here. */

static void on_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    replay_run_t *const run = context;
    if (run->options->out != NULL) {
        bench_folder_sample(&run->folder, run->replay.now_us, taken, sample);
    }
}

static tumble_status_t init_firmware(replay_run_t *run)
{
    bench_world_t *const world = &run->world;
    const bench_config_t *const config = world->config;
    world->hooks = (tumble_navcomp_hooks_t){run, on_sample};
    world->navcomp_config = bench_navcomp_config(config, &run->replay.port, &world->hooks, &world->stand);
    world->navcomp_config.second_client = &world->second_client;
    return tumble_navcomp_init(&world->navcomp, &world->navcomp_config);
}

static void put_document(const bench_world_t *world, FILE *out)
{
    const replay_run_t *const run =
        (const replay_run_t *)(const void *)((const char *)world - offsetof(replay_run_t, world));
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.replayed/1");
    bench_json_text(&json, "firmware", "host");
    bench_report_firmware(world, &json);
    bench_json_open(&json, "counters", '{');
    bench_report_firmware_counters(world, &json);
    bench_json_whole(&json, "commands_refused_in_replay", run->replay.commands_refused);
    bench_json_close(&json, '}');
    bench_json_number(&json, "virtual_s", (double)world->clock.now_us * 1e-6);
    bench_json_close(&json, '}');
    (void)fputc('\n', out);
}

static int open_folder(replay_run_t *run, const bus_log_t *log)
{
    if (run->options->out == NULL) {
        return BENCH_EXIT_PASS;
    }
    const char *const wrong = bench_folder_open(&run->folder, run->options->out);
    if (wrong != NULL) {
        return arguments_fail(run->options->out, wrong, BENCH_EXIT_USAGE);
    }
    run->folder.document = put_document;
    for (size_t i = 0; i < log->count; i++) {
        bench_folder_frame(&run->folder, log->first_us + log->lines[i].time_us, &log->lines[i].frame);
    }
    return BENCH_EXIT_PASS;
}

static int play(replay_run_t *run)
{
    bench_world_t *const world = &run->world;
    replay_run(&run->replay, &world->navcomp, NULL, NULL);
    world->clock.now_us = run->replay.now_us;
    tumble_procedure_progress(tumble_navcomp_procedure(&world->navcomp), &world->progress);
    world->end = (world->progress.state == TUMBLE_STATE_DONE) ? BENCH_DONE : BENCH_FAULT;
    if (run->options->out != NULL) {
        const char *const wrong = bench_folder_close(&run->folder, world);
        if (wrong != NULL) {
            return arguments_fail(run->options->out, wrong, BENCH_EXIT_FAULT);
        }
    }
    put_document(world, stdout);
    return bench_exit_code(world);
}

static int replay(const options_t *options, const bus_log_t *log, const bench_config_t *config)
{
    static replay_run_t run;
    size_t size = 0;
    run.options = options;
    run.world.config = config;
    uint8_t *const recording = log_recording(log, config, &size);
    if (recording == NULL || replay_open(&run.replay, recording, size) != TUMBLE_OK) {
        free(recording);
        return arguments_fail(options->log, "the log is too long for this machine's memory", BENCH_EXIT_USAGE);
    }
    const tumble_status_t status = init_firmware(&run);
    int code = BENCH_EXIT_USAGE;
    if (status != TUMBLE_OK) {
        (void)arguments_refuse("the firmware refuses its configuration", tumble_status_sentence(status));
    } else if ((code = open_folder(&run, log)) == BENCH_EXIT_PASS) {
        code = play(&run);
    }
    free(recording);
    return code;
}

int main(int count, char *arguments[])
{
    static bench_config_t config;
    options_t options;
    bus_log_t log = {0};
    if (!read_options(&options, count, arguments)) {
        return BENCH_EXIT_USAGE;
    }
    if (options.asks != BENCH_ASKS_WORK) {
        return bench_tell("tumble-replay", options.asks, HELP) ? BENCH_EXIT_PASS : BENCH_EXIT_FAULT;
    }
    if (!bench_config_prepare(&config, options.scenario, options.gain_record)) {
        return BENCH_EXIT_USAGE;
    }
    if (options.commissioning != NULL) {
        return write_commissioning(options.commissioning, &config);
    }
    int code = BENCH_EXIT_USAGE;
    if (read_log(&log, options.log)) {
        code = (options.recording != NULL) ? write_recording(options.recording, &log, &config)
                                           : replay(&options, &log, &config);
    }
    log_free(&log);
    return code;
}
