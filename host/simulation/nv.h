/* nv.h - a simulated flash memory (tumble/port.h) in virtual time.
 *
 * Operations take the time that they are given; until it is over every call answers TUMBLE_E_PORT_BUSY. A granule that
 * is not erased is not programmed: TUMBLE_E_NV. The bytes can be looked at, kept and put back: they are what outlives
 * power.
 */
#ifndef TUMBLE_SIMULATION_NV_H
#define TUMBLE_SIMULATION_NV_H

#include "simulation/clock.h"
#include "tumble/port.h"

#include <stdbool.h>
#include <stdint.h>

#define SIM_NV_SECTOR 4096U
#define SIM_NV_GRANULE 8U
#define SIM_NV_SECTORS 16U
#define SIM_NV_BYTES (SIM_NV_SECTOR * SIM_NV_SECTORS)

typedef struct {
    tumble_nv_t nv; /* what the firmware gets; keeps a pointer to this object */
    const sim_clock_t *clock;
    uint32_t erase_us; /* 0: at once */
    uint32_t program_us;
    uint8_t bytes[SIM_NV_BYTES];
    uint64_t until_us; /* when the operation under way ends */
    uint32_t offset;   /* of it; */
    uint32_t size;     /* 0: nothing under way, and nothing that has ended and was not told */
} sim_nv_t;

/* Erased, all operations at once. */
void sim_nv_init(sim_nv_t *nv, const sim_clock_t *clock);

#endif
