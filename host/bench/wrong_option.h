/* wrong_option.h - options by getopt_long, and what it does not take, in the words of all our programs. */
#ifndef TUMBLE_BENCH_WRONG_OPTION_H
#define TUMBLE_BENCH_WRONG_OPTION_H

#include <getopt.h>
#include <stdbool.h>

#define BENCH_HELP 'h' /* the value of --help, and -h; those of the other long options are below 32 */
#define BENCH_VERSION 31

/* What a command line asks for. */
typedef enum { BENCH_ASKS_WORK, BENCH_ASKS_HELP, BENCH_ASKS_VERSION } bench_asks_t;

/* One option into `options`; its value is in optarg. Returns false when that was not right, which has been said. */
typedef bool (*bench_take_t)(void *options, int option);

/* All options of a command line, each by `take` but --help and --version, which are told by `asks`, the last of them;
 * then optind is at the operands. Returns false once one is not right, which has been said in one line on standard
 * error. */
bool bench_read_options(const char *program, int count, char *arguments[], const struct option known[],
                        bench_take_t take, void *options, bench_asks_t *asks);

/* Print to standard output what is asked for: `help`, or the program and its version. False: it cannot be written. */
bool bench_tell(const char *program, bench_asks_t asks, const char *help);

#endif
