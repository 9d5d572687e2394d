/* wrong_option.h - what getopt_long does not take, in the words of all our programs. */
#ifndef TUMBLE_BENCH_WRONG_OPTION_H
#define TUMBLE_BENCH_WRONG_OPTION_H

/* What a program asks of getopt_long: -h is --help, and what is wrong is told by us. */
#define BENCH_SHORT_OPTIONS ":h"

/* One line on standard error, after getopt_long with BENCH_SHORT_OPTIONS and opterr = 0 has answered ':' or '?'. The
 * values of long options are below 32, but for that of --help: 'h'. */
void bench_wrong_option(const char *program, int answer, char *const arguments[]);

#endif
