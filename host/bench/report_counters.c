#include "bench/report_counters.h"

#include <stddef.h>

typedef struct {
    const char *name;
    size_t offset; /* of a uint32_t */
} counter_t;

#define OF(member) offsetof(tumble_navcomp_counters_t, member)

static const counter_t COUNTERS[] = {
    {"frames_sent", OF(link.sent)},
    {"frames_received", OF(link.received)},
    {"frames_busy", OF(link.busy)},
    {"frames_down", OF(link.down)},
    {"frames_invalid", OF(link.invalid)},
    {"frames_ignored", OF(events.frames_ignored)},
    {"commands_refused", OF(events.commands_refused)},
    {"heartbeats_lost", OF(events.heartbeats_lost)},
    {"boot_ups", OF(events.boot_ups)},
    {"starts", OF(events.starts)},
    {"emergencies", OF(events.emergencies)},
    {"samples_received", OF(block.samples)},
    {"samples_lost", OF(block.lost)},
    {"frames_repeated", OF(block.repeated)},
    {"frames_reordered", OF(block.reordered)},
    {"frames_wrong_length", OF(block.wrong_length)},
    {"frames_wrong_crc", OF(block.wrong_crc)},
    {"frames_wrong_pair", OF(block.wrong_pair)},
    {"lone_halves", OF(block.lone_halves)},
    {"averaging_saturated", OF(averaging.saturated)},
    {"averaging_deviating", OF(averaging.deviating)},
    {"averaging_repeated", OF(averaging.repeated)},
    {"averaging_reordered", OF(averaging.reordered)},
    {"averaging_lost", OF(averaging.lost)},
    {"procedure_samples", OF(procedure.samples)},
    {"procedure_corrupted", OF(procedure.corrupted)},
    {"samples_averaged", OF(procedure.averaged)},
    {"positions_kept", OF(procedure.positions)},
    {"positions_refused", OF(procedure.refused)},
    {"retries", OF(procedure.retries)},
    {"timeouts", OF(procedure.timeouts)},
    {"moves", OF(procedure.moves)},
    {"unwinds", OF(procedure.unwinds)},
    {"homings", OF(procedure.homings)},
    {"faults", OF(procedure.faults)},
    {"resumes", OF(procedure.resumes)},
};

void bench_report_bus_counters(const sim_bus_t *bus, bench_json_t *json)
{
    uint64_t overflow = 0;
    for (int n = 0; n < SIM_BUS_NODES; n++) {
        overflow += (uint64_t)bus->nodes[n].counters.rx_overflow + bus->nodes[n].counters.tx_overflow;
    }
    bench_json_whole(json, "bus_frames", bus->load.frames);
    bench_json_whole(json, "bus_bits", bus->load.bits);
    bench_json_whole(json, "bus_busy_us", bus->load.busy_us);
    bench_json_whole(json, "bus_overflow", overflow);
}

void bench_report_firmware_counters(const bench_world_t *world, bench_json_t *json)
{
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(&world->navcomp, &counters);
    for (size_t i = 0; i < sizeof COUNTERS / sizeof COUNTERS[0]; i++) {
        const char *const at = (const char *)&counters + COUNTERS[i].offset;
        bench_json_whole(json, COUNTERS[i].name, *(const uint32_t *)(const void *)at);
    }
    bench_json_whole(json, "firmware_steps", world->steps);
}

void bench_report_counters(const bench_world_t *world, bench_json_t *json)
{
    bench_json_open(json, "counters", '{');
    bench_report_firmware_counters(world, json);
    bench_report_bus_counters(&world->bus, json);
    bench_json_close(json, '}');
}
