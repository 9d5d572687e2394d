#define _GNU_SOURCE /* getopt_long */

#include "bench/wrong_option.h"

#include "tumble/version.h"

#include <stdio.h>
#include <string.h>

#define FIRST_LETTER 32
#define SHORT_OPTIONS ":h" /* what is wrong is told by us */

/* After getopt_long with SHORT_OPTIONS and opterr = 0 has answered ':' or '?'. */
static void tell_what_is_wrong(const char *program, int answer, char *const arguments[])
{
    const char letter[] = {'-', (char)optopt, '\0'};
    const char *const given = arguments[optind - 1];
    const int name = (int)strcspn(given, "=");
    if (answer == ':') {
        (void)fprintf(stderr, "%s: %.*s: needs a value\n", program, name, given);
    } else if (optopt >= FIRST_LETTER && optopt != BENCH_HELP) {
        (void)fprintf(stderr, "%s: %s: no such option; see --help\n", program, letter);
    } else {
        (void)fprintf(stderr, "%s: %.*s: %s\n", program, name, given,
                      (optopt == 0) ? "no such option; see --help" : "takes no value");
    }
}

bool bench_read_options(const char *program, int count, char *arguments[], const struct option known[],
                        bench_take_t take, void *options, bench_asks_t *asks)
{
    int option;
    opterr = 0;
    *asks = BENCH_ASKS_WORK;
    while ((option = getopt_long(count, arguments, SHORT_OPTIONS, known, NULL)) != -1) {
        if (option == BENCH_HELP || option == BENCH_VERSION) {
            *asks = (option == BENCH_HELP) ? BENCH_ASKS_HELP : BENCH_ASKS_VERSION;
        } else if (option == ':' || option == '?') {
            tell_what_is_wrong(program, option, arguments);
            return false;
        } else if (!take(options, option)) {
            return false;
        }
    }
    return true;
}

bool bench_tell(const char *program, bench_asks_t asks, const char *help)
{
    const bool written = (asks == BENCH_ASKS_HELP) ? fputs(help, stdout) >= 0
                                                   : printf("%s %s\n", program, TUMBLE_VERSION) >= 0;
    return fflush(stdout) == 0 && written;
}
