/* report_counters.h - the counters of a run, as one object of a JSON document. */
#ifndef TUMBLE_BENCH_REPORT_COUNTERS_H
#define TUMBLE_BENCH_REPORT_COUNTERS_H

#include "bench/json.h"
#include "bench/world.h"

/* Members of it: of the firmware, of the simulated bus. */
void bench_report_firmware_counters(const bench_world_t *world, bench_json_t *json);
void bench_report_bus_counters(const sim_bus_t *bus, bench_json_t *json);

/* "counters": {name: integer}. */
void bench_report_counters(const bench_world_t *world, bench_json_t *json);

#endif
