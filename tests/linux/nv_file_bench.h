/* nv_file_bench.h - a file that holds a memory, and a system that writes it as wrongly as it is told to. */
#ifndef TUMBLE_TESTS_NV_FILE_BENCH_H
#define TUMBLE_TESTS_NV_FILE_BENCH_H

#include "nv_file.h"
#include "suite.h"

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

extern char folder[40];
extern char path[100]; /* in `folder`, unless a test puts it elsewhere */
extern nv_file_t file;

/* What the system does wrong. */
extern int killed_after;      /* bytes of the next write; -1: nobody is killed */
extern int full_after;        /* bytes, then there is no room */
extern uint32_t most_at_once; /* 0: as many as asked for */
extern int interruptions;
extern int sync_error;
extern long sync_ms;
extern pthread_mutex_t medium; /* held: it does not answer */

/* Round each case: `path` is in a folder that nobody else has, there is no file, and nothing goes wrong. */
void set_up(void);
void tear_down(void);

void open_it(void);
void close_it(void);
void pause_us(void *context, uint32_t us);
tumble_status_t erase(uint32_t offset);
tumble_status_t program(uint32_t offset, const uint8_t *bytes, uint32_t size);

void write_file(const void *bytes, size_t size);

/* The whole file, and one byte more if there is one. Returns how many. */
size_t read_file(uint8_t bytes[NV_FILE_BYTES + 1U]);

#endif
