#define _POSIX_C_SOURCE 200809L

#include "node.h"

#include "arguments.h"
#include "computer.h"
#include "folder.h"
#include "outlet.h"
#include "positioner_option.h"
#include "report.h"
#include "world/report.h"

#include <errno.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#define US_PER_MS 1000U

typedef struct {
    const node_options_t *options;
    /* The bench's record of a run, so that its reports serve here as well: of it only the configuration, the firmware,
     * its progress and the time are in use, no simulation. */
    bench_world_t world;
    computer_t computer;
    bench_folder_t folder;
    node_log_t log;
    outlet_t documents;      /* to standard output */
    outlet_t progress;       /* not open: nobody wants to know */
    tumble_progress_t fault; /* the first that the run has not got over; TUMBLE_REASON_NONE: there is none */
    bool in_first_fault;     /* it is the one in which the run waits now */
    uint32_t faulted_run;    /* its number */
    uint64_t faulted_us;     /* since when it is in FAULT; SIM_NEVER: it is not */
    uint64_t ending_us;      /* since when it waits for the table to rest; SIM_NEVER: not yet */
    uint32_t refused;        /* commands, as last counted */
    bool reported;           /* the run that has ended */
    bool left;               /* nobody will give a command after a fault */
} node_t;

/* What the firmware tells. */

/* All frames of a step have its time, as they have for the firmware. */
static void on_frame(void *context, const tumble_can_frame_t *frame)
{
    node_t *const node = context;
    node_log_frame(&node->log, frame);
    if (node->options->out != NULL) {
        bench_folder_frame(&node->folder, node->computer.epoch_us + node->world.clock.now_us, frame);
    }
}

static void on_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    node_t *const node = context;
    if (node->options->out != NULL) {
        bench_folder_sample(&node->folder, node->world.clock.now_us, taken, sample);
    }
    if (node->progress.stream != NULL && bench_is_tenth(&node->world, taken.ordinal)) {
        bench_progress_average(&node->world, taken.ordinal, &(bench_json_t){.out = node->progress.stream});
    }
}

static void put_document(const void *context, FILE *out)
{
    const node_t *const node = context;
    node_report(&node->world, &node->computer, &node->fault, out);
}

/* A run as it goes. */

static bool is_of_a_run(tumble_state_t state)
{
    return state != TUMBLE_STATE_IDLE && state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT;
}

/* Whoever stands at the bench reads what is wanted of him; he answers by SDO. */
static void ask(const node_t *node, const tumble_progress_t *progress)
{
    const bench_question_t question = bench_operator_question(progress);
    if (question.kind != BENCH_QUESTION_NONE) {
        bench_progress_question(&node->world, &question, &(bench_json_t){.out = node->progress.stream});
    }
}

/* Has the run got over its fault: come further than it had come, ended well, or given way to another? */
static bool is_over(const node_t *node, const tumble_progress_t *now)
{
    const tumble_progress_t *const fault = &node->fault;
    return now->state == TUMBLE_STATE_DONE || now->finished > fault->finished ||
           (now->state == TUMBLE_STATE_AVERAGE && fault->failed_in != TUMBLE_STATE_AVERAGE) ||
           tumble_service_runs(&node->world.navcomp) != node->faulted_run;
}

/* What stopped the run first outlives what follows from it: further faults of a run that was told to go on too early, and
 * the ABORT that ends it. While the run waits in that fault, the firmware may still learn more of it. */
static void note_cause(node_t *node, const tumble_progress_t *now)
{
    if (now->state != TUMBLE_STATE_FAULT) {
        node->in_first_fault = false;
        node->fault.reason = is_over(node, now) ? TUMBLE_REASON_NONE : node->fault.reason;
    } else if (node->fault.reason == TUMBLE_REASON_NONE || node->in_first_fault) {
        node->in_first_fault = true;
        node->fault = *now;
        node->faulted_run = tumble_service_runs(&node->world.navcomp);
    }
}

static void note_state(node_t *node)
{
    bench_world_t *const world = &node->world;
    const tumble_progress_t before = world->progress;
    tumble_procedure_progress(tumble_navcomp_procedure(&world->navcomp), &world->progress);
    const tumble_progress_t *const now = &world->progress;
    note_cause(node, now);
    if (!run_log_is_news(now, &before)) {
        return;
    }
    run_log_state(now, &node->fault, !node->options->start || node->options->patience_s > 0.0);
    node->faulted_us = (now->state == TUMBLE_STATE_FAULT) ? world->clock.now_us : SIM_NEVER;
    if (is_of_a_run(now->state)) {
        node->reported = false;
    }
    if (node->progress.stream != NULL) {
        bench_progress_state(world, &(bench_json_t){.out = node->progress.stream});
        ask(node, now);
    }
}

static uint32_t count_refused(const node_t *node)
{
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(&node->world.navcomp, &counters);
    return counters.events.commands_refused;
}

/* Who gave it by SDO may be a person who waits for what becomes of it. */
static void note_refusals(node_t *node)
{
    const uint32_t refused = count_refused(node);
    if (refused != node->refused) {
        node_log_refused(&node->log, &node->world.progress, tumble_stand_report(&node->world.navcomp.stand)->rung);
        if (node->progress.stream != NULL) {
            bench_progress_refused("the navigation computer does not take this command now",
                                   &(bench_json_t){.out = node->progress.stream});
        }
    }
    node->refused = refused;
}

/* Stop the table, on our own account: that there was no run to be given up is nobody's refused command. */
static void give_up(node_t *node)
{
    note_refusals(node);
    (void)tumble_navcomp_command(&node->world.navcomp, TUMBLE_COMMAND_ABORT, 0);
    node->refused = count_refused(node);
}

static void end_with(node_t *node, world_end_t end)
{
    if (node->world.wanted_end == WORLD_RUNNING) {
        node->world.wanted_end = end;
        node->ending_us = node->world.clock.now_us;
    }
}

/* With --start a run is all there is. */
static void look_for_end(node_t *node)
{
    const bench_world_t *const world = &node->world;
    const uint64_t patience_us = node->left ? 0U : (uint64_t)(node->options->patience_s * 1e6);
    const tumble_state_t state = world->progress.state;
    if (state == TUMBLE_STATE_DONE) {
        end_with(node, WORLD_DONE);
    } else if (state == TUMBLE_STATE_ABORT ||
               (state == TUMBLE_STATE_FAULT && world->clock.now_us - node->faulted_us >= patience_us)) {
        end_with(node, WORLD_FAULT);
    } else if (world->clock.now_us > world->limit_us) {
        give_up(node);
        end_with(node, WORLD_TOO_LONG);
    }
}

/* Served: one line for each run that has ended. */
static void report_ended(node_t *node)
{
    bench_world_t *const world = &node->world;
    const tumble_state_t state = world->progress.state;
    if (node->reported || (state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT)) {
        return;
    }
    node->reported = true;
    can_socket_count_drops(&node->computer.bus.can);
    world->end = (state == TUMBLE_STATE_DONE) ? WORLD_DONE : WORLD_FAULT;
    put_document(node, node->documents.stream);
    world->end = WORLD_RUNNING;
}

/* At rest, as far as its drive can tell; one that is silent, or a bus that is down, can tell nothing. */
static bool may_still_turn(const bench_world_t *world)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&world->navcomp, &progress);
    return progress.stand == TUMBLE_STAND_MOVING || progress.stand == TUMBLE_STAND_HOMING;
}

/* The result is on its way into the memory. */
static bool is_storing(const node_t *node)
{
    tumble_sets_state_t state = {0};
    if (computer_keeper(&node->computer) != NULL) {
        tumble_keeper_state(computer_keeper(&node->computer), &state);
    }
    return state.busy || state.verdict == TUMBLE_VERDICT_WORKING;
}

static bool has_ended(node_t *node)
{
    bench_world_t *const world = &node->world;
    const uint64_t patience_us = (uint64_t)world->config->profile.stop_timeout_ms * US_PER_MS;
    if (world->wanted_end == WORLD_RUNNING ||
        ((may_still_turn(world) || is_storing(node)) && world->clock.now_us - node->ending_us < patience_us)) {
        return false;
    }
    world->end = world->wanted_end;
    return true;
}

static void take_signal(node_t *node, int signal)
{
    if (signal == SIGUSR1) {
        node->left = true;
    } else if (signal != 0) {
        const bool running = is_of_a_run(node->world.progress.state);
        give_up(node);
        end_with(node, running ? WORLD_INTERRUPTED : WORLD_LEFT);
    }
}

/* Lines that wait for their reader go, as far as they can; that some were left out is told once. */
static void retry_outputs(node_t *node)
{
    outlet_retry(&node->documents);
    outlet_retry(&node->progress);
    node_log_unread(&node->log.unread_documents, node->documents.lost, "standard output");
    node_log_unread(&node->log.unread_progress, node->progress.lost, "progress");
}

static void step(node_t *node)
{
    computer_step(&node->computer, &node->world.clock.now_us);
    node->world.steps++;
    note_refusals(node);
    note_state(node);
    node_log_update(&node->log, &node->world.navcomp, computer_keeper(&node->computer), &node->computer.bus.can);
}

static void go(node_t *node)
{
    do {
        step(node);
        if (node->options->start) {
            look_for_end(node);
        } else {
            report_ended(node);
        }
        retry_outputs(node);
        take_signal(node, computer_wait(&node->computer));
    } while (!has_ended(node));
    if (node->progress.stream != NULL) {
        bench_progress_end(&node->world, &(bench_json_t){.out = node->progress.stream});
    }
}

/* Getting ready. */

/* First the bus: nobody else is kept waiting for the file if there is none. */
static int open_computer(node_t *node)
{
    computer_t *const computer = &node->computer;
    const char *const interface = node->options->interface;
    const can_socket_status_t status = computer_open_bus(computer, interface);
    computer->bus.on_frame = on_frame;
    computer->bus.context = node;
    if (status != CAN_SOCKET_OK) {
        return arguments_fail_bus(interface, status);
    }
    const char *const path = node->options->nv;
    const char *const wrong = (path != NULL) ? computer_open_memory(computer, path) : NULL;
    return (wrong == NULL) ? BENCH_EXIT_PASS : arguments_fail(path, wrong, BENCH_EXIT_USAGE);
}

static tumble_status_t init_firmware(bench_world_t *world, node_t *node)
{
    const bench_config_t *const config = world->config;
    world->hooks = (tumble_navcomp_hooks_t){node, on_sample};
    world->navcomp_config = bench_navcomp_config(config, &node->computer.port, &world->hooks, &world->stand);
    world->navcomp_config.second_client = &world->second_client;
    if (!positioner_option_use(&world->navcomp_config)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = computer_init(&node->computer, &world->navcomp, &world->navcomp_config,
                                                 config->keeping.serial, &config->keeping.settings);
    return (status == TUMBLE_OK && node->options->start)
               ? tumble_navcomp_command(&world->navcomp, TUMBLE_COMMAND_START, 0)
               : status;
}

static const char *open_outputs(node_t *node, const char **subject)
{
    const node_options_t *const options = node->options;
    if (options->progress_fd >= 0) {
        *subject = "--progress-fd";
        if (!outlet_open(&node->progress, options->progress_fd)) {
            return "is not an open file descriptor";
        }
    }
    if (options->out == NULL) {
        return NULL;
    }
    *subject = options->out;
    return bench_folder_open(&node->folder, options->out, node->computer.bus.can.name);
}

/* A result is waited for: whoever reads the documents may be slow, and a signal ends it. */
static int end_outputs(node_t *node, int code)
{
    const bool is_told = node->world.end == WORLD_LEFT || node->world.end == WORLD_INTERRUPTED;
    (void)outlet_end(&node->progress, true);
    return outlet_end(&node->documents, is_told) ? code : arguments_fail_output();
}

static int finish(node_t *node)
{
    int code = bench_exit_code(&node->world);
    const char *const folder = node->options->out;
    const char *const wrong =
        (folder != NULL) ? bench_folder_close(&node->folder, &node->world, put_document, node) : NULL;
    if (wrong != NULL) {
        code = node_log_unwritten(folder, wrong);
    } else if (node->options->start || node->world.end == WORLD_INTERRUPTED) {
        put_document(node, node->documents.stream);
    }
    node_log_end(&node->world, code, &node->fault);
    return end_outputs(node, code);
}

int node_run(const bench_config_t *config, const node_options_t *options)
{
    static node_t node;
    const char *subject = "";
    node = (node_t){.options = options, .faulted_us = SIM_NEVER, .ending_us = SIM_NEVER, .reported = true};
    node.world.config = config;
    node.world.limit_us = (uint64_t)(config->virtual_limit_s * 1e6);
    if (!outlet_open(&node.documents, STDOUT_FILENO)) {
        return arguments_fail_output();
    }
    const int opened = open_computer(&node);
    if (opened != BENCH_EXIT_PASS) {
        return opened;
    }
    const tumble_status_t status = init_firmware(&node.world, &node);
    if (status != TUMBLE_OK) {
        return arguments_fail("the firmware refuses its configuration", tumble_status_sentence(status),
                              BENCH_EXIT_USAGE);
    }
    if (!computer_open_events(&node.computer)) {
        return arguments_fail("waiting for events", strerror(errno), BENCH_EXIT_FAULT);
    }
    const char *const wrong = open_outputs(&node, &subject);
    if (wrong != NULL) {
        return arguments_fail(subject, wrong, BENCH_EXIT_USAGE);
    }
    node_log_ready(options);
    go(&node);
    positioner_option_close();
    computer_close(&node.computer);
    return finish(&node);
}
