#include "report.h"

#include "run_log.h"
#include "world/report.h"

static void put_interface(const computer_t *computer, bench_json_t *json)
{
    const can_socket_t *const can = &computer->bus.can;
    bench_json_whole(json, "frames_foreign", computer->bus.foreign);
    link_report(json, &can->counters);
    bench_json_whole(json, "receive_buffer_bytes", can->receive_buffer);
    bench_json_whole(json, "latest_step_us", computer->latest_us);
}

/* The run's first fault, whatever followed from it (the reason of a run that was aborted in FAULT is the command); null
 * where there was none, or the run got over it. */
static void put_cause(const tumble_progress_t *fault, bench_json_t *json)
{
    if (fault->reason == TUMBLE_REASON_NONE) {
        bench_json_null(json, "cause");
        return;
    }
    bench_json_open(json, "cause", '{');
    bench_json_text(json, "failed_in", tumble_state_name(fault->failed_in));
    bench_json_text(json, "reason", tumble_reason_name(fault->reason));
    bench_json_whole(json, "reason_number", (uint64_t)fault->reason);
    bench_json_text(json, "reason_sentence", tumble_reason_sentence(fault->reason));
    bench_json_whole(json, "drive_code", fault->drive_code);
    bench_json_close(json, '}');
}

void node_report(const bench_world_t *world, const computer_t *computer, const tumble_progress_t *cause, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.node/1");
    bench_json_text(&json, "interface", computer->bus.can.name);
    bench_report_run(world, &json);
    put_cause(cause, &json);
    bench_json_open(&json, "counters", '{');
    bench_report_counters(world, &json);
    put_interface(computer, &json);
    bench_json_close(&json, '}');
    bench_json_number(&json, "virtual_s", (double)world->clock.now_us * 1e-6);
    bench_json_end(&json);
}
