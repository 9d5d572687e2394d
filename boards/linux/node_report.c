#include "node.h"

#include "json.h"
#include "report.h"

static void put_interface(const node_t *node, bench_json_t *json)
{
    const can_socket_t *const can = &node->port.can;
    bench_json_whole(json, "frames_foreign", node->port.foreign);
    bench_json_whole(json, "kernel_received", can->counters.received);
    bench_json_whole(json, "kernel_sent", can->counters.sent);
    bench_json_whole(json, "kernel_dropped", can->counters.dropped);
    bench_json_whole(json, "kernel_busy", can->counters.busy);
    bench_json_whole(json, "error_frames", can->counters.errors);
    bench_json_whole(json, "bus_offs", can->counters.bus_offs);
    bench_json_whole(json, "interface_downs", can->counters.downs);
    bench_json_whole(json, "receive_buffer_bytes", can->receive_buffer);
    bench_json_whole(json, "latest_step_us", node->latest_us);
}

static void put_cause(const node_t *node, bench_json_t *json)
{
    const tumble_progress_t *const fault = &node->fault;
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

void node_report(const node_t *node, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.node/1");
    bench_json_text(&json, "interface", node->port.can.name);
    bench_report_firmware(&node->world, &json);
    put_cause(node, &json);
    bench_json_open(&json, "counters", '{');
    bench_report_firmware_counters(&node->world, &json);
    put_interface(node, &json);
    bench_json_close(&json, '}');
    bench_json_number(&json, "virtual_s", (double)node->world.clock.now_us * 1e-6);
    bench_json_close(&json, '}');
    (void)fputc('\n', out);
    (void)fflush(out);
}
