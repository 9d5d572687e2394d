/* arguments.h - options and their values, read strictly; what is wrong goes to standard error as one line. */
#ifndef TUMBLE_LINUX_ARGUMENTS_H
#define TUMBLE_LINUX_ARGUMENTS_H

#include "bench/wrong_option.h"

#include <stdbool.h>
#include <stdint.h>

/* bench_read_options by the name that the program was called by. */
bool arguments_options(int count, char *arguments[], const struct option known[], bench_take_t take, void *options,
                       bench_asks_t *asks);

/* A whole number from `low` to `high`, in decimal digits. */
bool arguments_whole(const char *option, const char *text, uint64_t low, uint64_t high, uint64_t *value);

/* A finite number from `low` to `high`. */
bool arguments_number(const char *option, const char *text, double low, double high, double *value);

/* The operands: the interface, and at most one scenario file. */
bool arguments_operands(int count, char *const operands[], const char **interface, const char **scenario);

/* One line: the program, the option, what is wrong with it. Returns false. */
bool arguments_refuse(const char *option, const char *what);

#endif
