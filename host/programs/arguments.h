/* arguments.h - the command line of a program: a table of its options, read by getopt_long.
 *
 * A row says into which member of a struct an option's value goes:
 *
 *     static const argument_t OPTIONS[] = {
 *         ARGUMENT_FLAG("start", options_t, start),
 *         ARGUMENT_WHOLE("node", options_t, node, 1, 127),
 *         ARGUMENT_TEXT("out", options_t, out),
 *         ARGUMENT_TAKE("tcp", take_tcp),
 *     };
 *
 * --help, -h and --version need no row. What is wrong goes to standard error as one line, by the name that the program
 * was called by.
 */
#ifndef TUMBLE_PROGRAMS_ARGUMENTS_H
#define TUMBLE_PROGRAMS_ARGUMENTS_H

#include "can_socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Exit codes of the product. */
enum {
    BENCH_EXIT_PASS = 0,
    BENCH_EXIT_LIMITS = 1,
    BENCH_EXIT_USAGE = 2,
    BENCH_EXIT_FAULT = 3,
    BENCH_EXIT_SKIPPED = 77, /* what it needs is not there */
    BENCH_EXIT_INTERRUPTED = 130
};

#define ARGUMENTS_WORK (-1) /* in place of an exit code: go on */

typedef enum {
    ARGUMENT_IS_CONSTANT, /* has no value: the member becomes `low`, a bool true */
    ARGUMENT_IS_WHOLE,    /* a whole number from `low` to `high`, times `unit`, into 1 to 8 bytes */
    ARGUMENT_IS_TEXT,     /* a text of at least `low` characters, 0 or 1 */
    ARGUMENT_IS_TAKEN,    /* by `take` */
    ARGUMENT_IS_CALL      /* has no value: `take` gets null */
} argument_kind_t;

/* Puts a value where it belongs. False when that is not right, which it has said. */
typedef bool (*argument_take_t)(void *options, const char *value);

typedef struct {
    const char *name;
    argument_kind_t kind;
    uint8_t size;
    size_t at;
    uint64_t low;
    uint64_t high;
    uint64_t unit;
    argument_take_t take;
} argument_t;

#define ARGUMENT_AT(type, member) .at = offsetof(type, member), .size = sizeof(((type *)0)->member)
#define ARGUMENT_CONSTANT(text, type, member, value) {.name = (text), ARGUMENT_AT(type, member), .low = (value)}
#define ARGUMENT_FLAG(text, type, member) ARGUMENT_CONSTANT(text, type, member, true)
#define ARGUMENT_ANY_TEXT(text, type, member) {.name = (text), .kind = ARGUMENT_IS_TEXT, ARGUMENT_AT(type, member)}
#define ARGUMENT_TEXT(text, type, member)                                                                              \
    {.name = (text), .kind = ARGUMENT_IS_TEXT, ARGUMENT_AT(type, member), .low = 1}
#define ARGUMENT_UNITS(text, type, member, least, most, factor)                                                        \
    {.name = (text),                                                                                                   \
     .kind = ARGUMENT_IS_WHOLE,                                                                                        \
     ARGUMENT_AT(type, member),                                                                                        \
     .low = (least),                                                                                                   \
     .high = (most),                                                                                                   \
     .unit = (factor)}
#define ARGUMENT_WHOLE(text, type, member, least, most) ARGUMENT_UNITS(text, type, member, least, most, 1)
#define ARGUMENT_TAKE(text, function) {.name = (text), .kind = ARGUMENT_IS_TAKEN, .take = (function)}
#define ARGUMENT_CALL(text, function) {.name = (text), .kind = ARGUMENT_IS_CALL, .take = (function)}

/* --with-parent: SIGTERM comes when the process that started this one has ended. */
#define ARGUMENT_WITH_PARENT ARGUMENT_CALL("with-parent", arguments_take_with_parent)
bool arguments_take_with_parent(void *options, const char *none);

/* What a program is called, says of itself and takes. */
typedef struct {
    const char *name;
    const char *help;
    const argument_t *known;
    size_t known_count;
} arguments_program_t;

/* Read all options into a struct; then optind is at the operands. Returns ARGUMENTS_WORK, or the exit code of a program that
 * has nothing else to do: --help and --version (the last of them) have been printed, or what is wrong has been said. */
int arguments_read(int count, char *arguments[], const arguments_program_t *program, void *options);

/* A whole number from `low` to `high`, in decimal digits. */
bool arguments_whole(const char *option, const char *text, uint64_t low, uint64_t high, uint64_t *value);

/* Cut HOST:PORT in two. An address with colons of its own stands in brackets, which are cut off. False: it has another
 * form, and nothing is said; the port is whatever stands behind the last colon. */
bool arguments_cut_address(char *text, const char **host, const char **port);

/* Put a whole number into a member of 1, 2, 4 or 8 bytes. */
void arguments_store(uint64_t value, size_t size, void *member);

/* The operands: the interface, and at most one scenario file. */
bool arguments_operands(int count, char *const operands[], const char **interface, const char **scenario);

/* One line: the program, the option, what is wrong with it. Returns false. */
bool arguments_refuse(const char *option, const char *what);

/* The same of a line of a file; 0: of the whole file. */
bool arguments_refuse_line(const char *file, size_t line, const char *what);

/* The same of whatever ends the program; of an interface that cannot be opened; of standard output that cannot be written.
 * Returns the exit code. */
int arguments_fail(const char *subject, const char *what, int code);
int arguments_fail_bus(const char *interface, can_socket_status_t status);
int arguments_fail_output(void);

#endif
