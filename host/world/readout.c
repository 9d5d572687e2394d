#include "world/readout.h"

#include "canopen/abort.h"

#include <stddef.h>
#include <stdio.h>

const char *bench_step_name(uint8_t step)
{
#define NAME(number, name, what) [number] = #name,
    static const char *const NAMES[] = {TUMBLE_STAND_STEP_LIST(NAME)};
#undef NAME
    const bool known = step < sizeof NAMES / sizeof NAMES[0] && NAMES[step] != NULL;
    return known ? NAMES[step] : "UNKNOWN";
}

void bench_refusal_sentence(const tumble_stand_refusal_t *refusal, char *text, size_t size)
{
#define WHAT(number, name, what) [number] = (what),
    static const char *const WHATS[] = {TUMBLE_STAND_STEP_LIST(WHAT)};
#undef WHAT
    const bool known = refusal->step < sizeof WHATS / sizeof WHATS[0] && WHATS[refusal->step] != NULL;
    (void)snprintf(text, size, "drive object %04Xh:%u, abort %04X %04Xh (%s), in %s", (unsigned)refusal->index,
                   (unsigned)refusal->subindex, (unsigned)(refusal->abort >> 16U), (unsigned)(refusal->abort & 0xFFFFU),
                   tumble_abort_sentence(refusal->abort), known ? WHATS[refusal->step] : "a step unknown here");
}

const char *bench_end_name(world_end_t end)
{
    static const char *const NAMES[] = {"running", "done", "fault", "interrupted", "too long", "left"};
    return NAMES[end];
}

bool bench_mean(const bench_world_t *world, uint8_t index, double mean_v[TUMBLE_CHANNELS],
                double error_v[TUMBLE_CHANNELS])
{
    const tumble_averaging_t *const averages = tumble_procedure_averages(tumble_navcomp_procedure(&world->navcomp));
    const double step_v = world->config->procedure.v_per_count;
    if (tumble_averaging_mean(averages, index, mean_v, error_v) != TUMBLE_OK) {
        return false;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        mean_v[i] *= step_v;
        error_v[i] *= step_v;
    }
    return true;
}

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

enum { FIRMWARE_COUNTERS = sizeof COUNTERS / sizeof COUNTERS[0], BUS_COUNTERS = 4 };

const char *bench_bus_counter(const sim_bus_t *bus, size_t row, uint64_t *value)
{
    static const char *const NAMES[BUS_COUNTERS] = {"bus_frames", "bus_bits", "bus_busy_us", "bus_overflow"};
    uint64_t overflow = 0;
    for (int n = 0; n < SIM_BUS_NODES; n++) {
        overflow += (uint64_t)bus->nodes[n].counters.rx_overflow + bus->nodes[n].counters.tx_overflow;
    }
    const uint64_t values[BUS_COUNTERS] = {bus->load.frames, bus->load.bits, bus->load.busy_us, overflow};
    *value = (row < BUS_COUNTERS) ? values[row] : 0U;
    return (row < BUS_COUNTERS) ? NAMES[row] : NULL;
}

const char *bench_firmware_counter(const bench_world_t *world, size_t row, uint64_t *value)
{
    if (row >= FIRMWARE_COUNTERS) {
        *value = world->steps;
        return (row == FIRMWARE_COUNTERS) ? "firmware_steps" : NULL;
    }
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(&world->navcomp, &counters);
    *value = *(const uint32_t *)(const void *)((const char *)&counters + COUNTERS[row].offset);
    return COUNTERS[row].name;
}

const char *bench_counter(const bench_world_t *world, size_t row, uint64_t *value)
{
    const char *const name = bench_firmware_counter(world, row, value);
    return (name != NULL) ? name : bench_bus_counter(&world->bus, row - FIRMWARE_COUNTERS - 1U, value);
}

bool bench_inclines(const tumble_schedule_t *schedule)
{
    bool inclines = false;
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        inclines = inclines || schedule->mountings[m].bolting > 0U;
    }
    return inclines;
}

bench_travel_t bench_travel(const bench_world_t *world)
{
    bench_travel_t travel = {.at_rest = bench_world_is_at_rest(world)};
    sim_axis_extent(world->axis, world->clock.now_us, &travel.lowest_deg, &travel.highest_deg);
    return travel;
}
