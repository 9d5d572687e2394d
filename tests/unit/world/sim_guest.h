/* sim_guest.h - somebody who interferes on the simulated bus, and looks at the table all the while. One a program. */
#ifndef TUMBLE_TESTS_UNIT_SIM_GUEST_H
#define TUMBLE_TESTS_UNIT_SIM_GUEST_H

#include "core/bytes.h"
#include "sim_bench.h"

#define WAITS "firmware.starts = no\n"
#define SECOND 1000000U

extern const bench_watcher_t NOBODY;

extern double least_deg;
extern double most_deg;
extern uint32_t answer; /* the last SDO answer of node 1: its abort code; 0: written */

extern const bench_watcher_t LISTENER;

void begin(const char *lines, const bench_watcher_t *watcher);
double table_deg(void);

/* So long, looking at the table all the while. */
void pass(uint64_t time_us);

void guest_send(uint16_t id, uint8_t length, const uint8_t *data);

/* By SDO, expedited, so many bytes, or four: to node 1 the answer is known afterwards. */
void write_bytes(uint8_t node, uint16_t index, uint8_t subindex, uint32_t value, uint8_t size);
void write_u32(uint8_t node, uint16_t index, uint8_t subindex, uint32_t value);

tumble_status_t command(tumble_command_t wanted, double angle_deg);
tumble_navcomp_progress_t progress(void);
tumble_navcomp_counters_t counters(void);
void begin_homing(const char *lines, const bench_watcher_t *watcher, uint64_t time_us); /* and let so long pass */
void start_turning(const char *lines);

#endif
