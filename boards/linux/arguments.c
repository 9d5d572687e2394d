#define _GNU_SOURCE /* program_invocation_short_name */

#include "arguments.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

bool arguments_refuse(const char *option, const char *what)
{
    (void)fprintf(stderr, "%s: %s: %s\n", program_invocation_short_name, option, what);
    return false;
}

bool arguments_options(int count, char *arguments[], const struct option known[], bench_take_t take, void *options,
                       bench_asks_t *asks)
{
    return bench_read_options(program_invocation_short_name, count, arguments, known, take, options, asks);
}

bool arguments_whole(const char *option, const char *text, uint64_t low, uint64_t high, uint64_t *value)
{
    char *end = NULL;
    errno = 0;
    *value = strtoull(text, &end, 10);
    if (*text < '0' || *text > '9' || *end != '\0' || errno != 0 || *value < low || *value > high) {
        char what[100];
        (void)snprintf(what, sizeof what, "must be a whole number from %llu to %llu", (unsigned long long)low,
                       (unsigned long long)high);
        return arguments_refuse(option, what);
    }
    return true;
}

bool arguments_number(const char *option, const char *text, double low, double high, double *value)
{
    char *end = NULL;
    *value = strtod(text, &end);
    if (end == text || *end != '\0' || !(*value >= low && *value <= high)) {
        char what[100];
        (void)snprintf(what, sizeof what, "must be a number from %g to %g", low, high);
        return arguments_refuse(option, what);
    }
    return true;
}

bool arguments_operands(int count, char *const operands[], const char **interface, const char **scenario)
{
    if (count < 1 || count > 2) {
        return arguments_refuse("arguments", "the CAN interface, and at most one scenario file; see --help");
    }
    *interface = operands[0];
    *scenario = (count == 2) ? operands[1] : NULL;
    return true;
}
