/* keeper_sdo.h - an outsider's SDO client for a navigation computer with a keeper (keeper_bench.h). One a program. */
#ifndef TUMBLE_TESTS_KEEPER_SDO_H
#define TUMBLE_TESTS_KEEPER_SDO_H

#include "keeper_bench.h"

#include "navcomp/keeper.h"
#include "navcomp/keeper_objects.h"
#include "navcomp_sdo.h"

#define SAVE 0x65766173U
#define LOAD 0x64616F6CU

extern tumble_stand_memory_t stand_memory;

/* A fresh memory, and the computer on the bus for a second. */
void keeper_sdo_power_on(void);

float read_f32(uint16_t index, uint8_t subindex);
uint32_t write_f32(uint16_t index, uint8_t subindex, float value);

/* A write whose answer waits for the memory: the abort code, or 0. */
uint32_t write_and_wait(uint16_t index, uint32_t signature);

#endif
