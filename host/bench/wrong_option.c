#define _GNU_SOURCE /* getopt_long */

#include "bench/wrong_option.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

#define FIRST_LETTER 32

void bench_wrong_option(const char *program, int answer, char *const arguments[])
{
    const char letter[] = {'-', (char)optopt, '\0'};
    const char *const given = arguments[optind - 1];
    const int name = (int)strcspn(given, "=");
    if (answer == ':') {
        (void)fprintf(stderr, "%s: %.*s: needs a value\n", program, name, given);
    } else if (optopt >= FIRST_LETTER && optopt != 'h') {
        (void)fprintf(stderr, "%s: %s: no such option; see --help\n", program, letter);
    } else {
        (void)fprintf(stderr, "%s: %.*s: %s\n", program, name, given,
                      (optopt == 0) ? "no such option; see --help" : "takes no value");
    }
}
