#define _POSIX_C_SOURCE 200809L

#include "stand.h"

#include "arguments.h"
#include "event_log.h"
#include "events.h"
#include "outlet.h"
#include "port_linux.h"
#include "run_log.h"
#include "stand_bridge.h"
#include "world/report.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#define RETRY_US 1000U   /* after the interface had no room */
#define REST_US 5000000U /* for the table to come to rest in the end */
#define LONG_WAIT_US 500000U
#define ANSWER_BYTES 200U

/* What a person at the stand says, on standard input, a line for each answer. */
typedef struct {
    char line[ANSWER_BYTES]; /* as far as it has come */
    uint32_t size;
} stand_answers_t;

typedef struct {
    bench_world_t world;
    bench_watcher_t watcher;
    stand_bridge_t bridge;
    stand_operator_t operator;
    stand_answers_t answers;
    stand_log_t log;
    outlet_t document;
    bool listening; /* to standard input */
    events_t events;
    uint64_t start_us; /* of the monotonic clock: virtual time 0 */
    uint64_t epoch_us; /* UTC at that moment */
    uint64_t ending_us;
    uint64_t latest_us; /* the longest that it came after its time */
    bool sending;       /* frames wait for room */
} stand_t;

static void on_frame(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    stand_t *const stand = context;
    (void)time_us;
    stand_bridge_tell(&stand->bridge, sender, frame);
    const stand_operator_t before = stand->operator;
    stand_operator_hear(&stand->operator, &stand->world, frame);
    stand_log_answer(&before, &stand->operator, frame);
}

static void run_until(stand_t *stand, uint64_t until_us)
{
    bench_world_t *const world = &stand->world;
    while (bench_world_next_us(world) <= until_us && bench_world_advance(world)) {
        stand_bridge_feed(&stand->bridge, world);
    }
    bench_world_pass(world, until_us);
}

/* All that was due by now, in its order: what has come, at the moment when it came. So a process that was held up, and
 * there are such moments on every machine, changes nothing on the simulated bus. */
static void catch_up(stand_t *stand)
{
    const uint64_t now_us = port_linux_clock_us() - stand->start_us;
    const uint64_t due_us = bench_world_next_us(&stand->world);
    struct can_frame raw;
    uint64_t utc_us;
    if (now_us > due_us && now_us - due_us > stand->latest_us) {
        stand->latest_us = now_us - due_us;
    }
    while (stand_bridge_next(&stand->bridge, &raw, &utc_us)) {
        const uint64_t at_us = (utc_us > stand->epoch_us) ? utc_us - stand->epoch_us : 0U;
        run_until(stand, (at_us < now_us) ? at_us : now_us);
        stand_bridge_take(&stand->bridge, &stand->world, &raw);
    }
    run_until(stand, now_us);
    stand_operator_step(&stand->operator, &stand->world);
    stand->sending = stand_bridge_flush(&stand->bridge);
    stand_log_update(&stand->log, &stand->world, &stand->bridge.can);
}

static uint64_t earlier(uint64_t a_us, uint64_t b_us)
{
    return (a_us < b_us) ? a_us : b_us;
}

static uint64_t next_us(const stand_t *stand)
{
    const uint64_t now_us = stand->world.clock.now_us;
    uint64_t due_us = earlier(bench_world_next_us(&stand->world), now_us + LONG_WAIT_US);
    due_us = earlier(due_us, stand_operator_next_us(&stand->operator));
    return stand->sending ? earlier(due_us, now_us + RETRY_US) : due_us;
}

/* Told to end, and the table at rest, or no hope of it. */
static bool has_ended(stand_t *stand)
{
    const uint64_t now_us = stand->world.clock.now_us;
    const int signal = events_signal(&stand->events);
    if ((signal == SIGINT || signal == SIGTERM) && stand->ending_us == SIM_NEVER) {
        stand->ending_us = now_us;
    }
    return stand->ending_us != SIM_NEVER &&
           (bench_world_is_at_rest(&stand->world) || now_us > stand->ending_us + REST_US);
}

static bool is_ready(int fd)
{
    struct pollfd asked = {.fd = fd, .events = POLLIN};
    return poll(&asked, 1, 0) > 0;
}

/* A line that is too long is cut off, and so none that is understood. */
static void take_byte(stand_answers_t *answers, char byte, stand_operator_t *operator, bench_world_t *world)
{
    if (byte != '\n') {
        answers->line[answers->size] = byte;
        answers->size += (answers->size < ANSWER_BYTES - 1U) ? 1U : 0U;
        return;
    }
    answers->line[answers->size] = '\0';
    answers->size = 0;
    if (!stand_operator_answer(operator, world, answers->line)) {
        event_log_always(EVENT_LOG_WARNING, "ignored", EVENT_FIELDS(EVENT_TEXT("line", answers->line)),
                         "ignored, it answers no open question: %s", answers->line);
    }
}

/* Hand on the answers that have come, without waiting. False: there will be no more. */
static bool take_answers(stand_answers_t *answers, int fd, stand_operator_t *operator, bench_world_t *world)
{
    char bytes[ANSWER_BYTES];
    while (is_ready(fd)) {
        const ssize_t got = read(fd, bytes, sizeof bytes);
        if (got <= 0) {
            return false;
        }
        for (ssize_t i = 0; i < got; i++) {
            take_byte(answers, bytes[i], operator, world);
        }
    }
    return true;
}

static void listen_to_operator(stand_t *stand)
{
    if (stand->listening && !take_answers(&stand->answers, STDIN_FILENO, &stand->operator, &stand->world)) {
        stand->listening = false;
        events_forget(&stand->events, STDIN_FILENO);
    }
}

/* The document. */

static void report(const stand_t *stand, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.stand/1");
    bench_json_text(&json, "interface", stand->bridge.can.name);
    bench_json_whole(&json, "seed", stand->world.seed);
    bench_report_truth(&stand->world, &json);
    bench_json_number(&json, "virtual_s", (double)stand->world.clock.now_us * 1e-6);
    bench_report_table(&stand->world, &json);
    bench_json_number(&json, "angle_deg", sim_axis_actual_deg(stand->world.axis, stand->world.clock.now_us));
    bench_json_open(&json, "operator", '{');
    bench_json_whole(&json, "answers", stand->operator.answers);
    bench_json_whole(&json, "refusals", stand->operator.refusals);
    bench_json_close(&json, '}');
    bench_json_open(&json, "counters", '{');
    bench_report_bus_counters(&stand->world, &json);
    link_report(&json, &stand->bridge.can.counters);
    bench_json_whole(&json, "frames_foreign", stand->bridge.foreign);
    bench_json_whole(&json, "frames_unsent", stand->bridge.unsent);
    bench_json_whole(&json, "queue_overflow", stand->bridge.in.overflow + stand->bridge.out.overflow);
    bench_json_whole(&json, "latest_step_us", stand->latest_us);
    bench_json_close(&json, '}');
    bench_json_end(&json);
}

int stand_run(const bench_config_t *config, const stand_options_t *options)
{
    static stand_t stand;
    if (!outlet_open(&stand.document, STDOUT_FILENO)) {
        return arguments_fail_output();
    }
    stand.ending_us = SIM_NEVER;
    stand.watcher = (bench_watcher_t){.context = &stand, .on_frame = on_frame};
    stand_operator_init(&stand.operator, options->operator);
    const can_socket_status_t opened = can_socket_open(&stand.bridge.can, options->interface);
    if (opened != CAN_SOCKET_OK) {
        return arguments_fail_bus(options->interface, opened);
    }
    if (!events_open(&stand.events, stand.bridge.can.fd)) {
        return arguments_fail("waiting for events", strerror(errno), BENCH_EXIT_FAULT);
    }
    const tumble_status_t status = bench_world_init(&stand.world, config, options->seed, &stand.watcher);
    if (status != TUMBLE_OK) {
        return arguments_fail("the scenario cannot be used", tumble_status_sentence(status), BENCH_EXIT_USAGE);
    }
    stand.start_us = port_linux_clock_us();
    stand.epoch_us = port_linux_utc_us();
    stand_log_ready(options);
    stand.listening = options->operator == STAND_OPERATOR_ASKS && events_watch(&stand.events, STDIN_FILENO);
    do {
        catch_up(&stand);
        listen_to_operator(&stand);
        events_wait(&stand.events, stand.start_us + next_us(&stand));
    } while (!has_ended(&stand));
    catch_up(&stand); /* what had come by then */
    can_socket_count_drops(&stand.bridge.can);
    events_close(&stand.events);
    can_socket_close(&stand.bridge.can);
    report(&stand, stand.document.stream);
    stand_log_end(&stand.world, BENCH_EXIT_PASS);
    return outlet_end(&stand.document, true) ? BENCH_EXIT_PASS : arguments_fail_output();
}
