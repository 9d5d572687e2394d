/* navcomp_sdo.h - an outsider's SDO client for the navigation computer of navcomp_bench.h. One a program. */
#ifndef TUMBLE_TESTS_NAVCOMP_SDO_H
#define TUMBLE_TESTS_NAVCOMP_SDO_H

#include "canopen/abort.h"
#include "core/bytes.h"
#include "navcomp_bench.h"

/* TUMBLE_SDO_TO_FIRST, or TUMBLE_SDO_TO_SECOND: the server that is asked. */
extern uint16_t sdo_server;

/* One request and its answer; the others on the bus do not hear each other meanwhile. */
void ask(const uint8_t request[8], uint8_t answer[8]);

/* The abort code, or 0 with the value's bytes and their number. */
uint32_t sdo_read(uint16_t index, uint8_t subindex, uint8_t bytes[64], uint8_t *size);

/* The abort code, or 0. */
uint32_t sdo_write(uint16_t index, uint8_t subindex, const uint8_t *bytes, uint8_t size);
uint32_t write_byte(uint16_t index, uint8_t subindex, uint8_t value);
uint32_t write_u32(uint16_t index, uint8_t subindex, uint32_t value);
uint32_t write_f64(uint16_t index, uint8_t subindex, double value);

/* The abort code of a read; 0: none. */
uint32_t refusal_of(uint16_t index, uint8_t subindex);

double read_f64(uint16_t index, uint8_t subindex);
uint64_t read_u64(uint16_t index, uint8_t subindex);
uint32_t read_number(uint16_t index, uint8_t subindex, uint8_t expected_size);

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint32_t value;
} object_value_t;

/* Objects that have these sizes and values. */
void assert_reads(const object_value_t *rows, size_t count);

#define ASSERT_READS(...)                                                                                              \
    assert_reads((const object_value_t[]){__VA_ARGS__},                                                                \
                 sizeof((const object_value_t[]){__VA_ARGS__}) / sizeof(object_value_t))

/* How many of a table's objects can be read. They are of their size, and the others say why not. */
unsigned count_answers(const tumble_object_table_t *table);

/* A matrix and three biases, as these two objects tell them. */
void assert_told(const double k[3][3], const double u0[3], uint16_t k_index, uint16_t u0_index);

/* 2006h:1; the abort code, or 0. */
uint32_t give_key(uint32_t key);

void unlock(void);
uint32_t command(uint8_t number);

#endif
