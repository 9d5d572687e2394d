/* arguments.h - values of options, read strictly; what is wrong goes to standard error as one line. */
#ifndef TUMBLE_LINUX_ARGUMENTS_H
#define TUMBLE_LINUX_ARGUMENTS_H

#include <stdbool.h>
#include <stdint.h>

/* A whole number from `low` to `high`, in decimal digits. */
bool arguments_whole(const char *option, const char *text, uint64_t low, uint64_t high, uint64_t *value);

/* A finite number from `low` to `high`. */
bool arguments_number(const char *option, const char *text, double low, double high, double *value);

/* The operands: the interface, and at most one scenario file. */
bool arguments_operands(int count, char *const operands[], const char **interface, const char **scenario);

/* The answer of getopt_long when an option is unknown, lacks its value or has one too many. Returns false. */
bool arguments_wrong(int answer, char *const arguments[]);

/* One line: the program, the option, what is wrong with it. Returns false. */
bool arguments_refuse(const char *option, const char *what);

#endif
