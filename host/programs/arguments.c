#define _GNU_SOURCE /* getopt_long, program_invocation_short_name */

#include "arguments.h"

#include "tumble/version.h"

#include <errno.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>

#define MOST 30
#define LONG 256 /* what getopt_long answers for the first long option: above any letter */
#define VERSION (LONG + MOST)

bool arguments_refuse(const char *option, const char *what)
{
    (void)fprintf(stderr, "%s: %s: %s\n", program_invocation_short_name, option, what);
    return false;
}

bool arguments_refuse_line(const char *file, size_t line, const char *what)
{
    if (line == 0U) {
        return arguments_refuse(file, what);
    }
    (void)fprintf(stderr, "%s: %s:%zu: %s\n", program_invocation_short_name, file, line, what);
    return false;
}

int arguments_fail(const char *subject, const char *what, int code)
{
    (void)arguments_refuse(subject, what);
    return code;
}

int arguments_fail_bus(const char *interface, can_socket_status_t status)
{
    const int failed = (status == CAN_SOCKET_NO_INTERFACE) ? BENCH_EXIT_USAGE : BENCH_EXIT_FAULT;
    return arguments_fail(interface, can_socket_sentence(status),
                          (status == CAN_SOCKET_NO_CAN) ? BENCH_EXIT_SKIPPED : failed);
}

int arguments_fail_output(void)
{
    (void)fprintf(stderr, "%s: standard output cannot be written\n", program_invocation_short_name);
    return BENCH_EXIT_FAULT;
}

bool arguments_take_with_parent(void *options, const char *none)
{
    (void)options;
    (void)none;
    return prctl(PR_SET_PDEATHSIG, SIGTERM) == 0;
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

bool arguments_operands(int count, char *const operands[], const char **interface, const char **scenario)
{
    if (count < 1 || count > 2) {
        return arguments_refuse("arguments", "the CAN interface, and at most one scenario file; see --help");
    }
    *interface = operands[0];
    *scenario = (count == 2) ? operands[1] : NULL;
    return true;
}

bool arguments_cut_address(char *text, const char **host, const char **port)
{
    char *const colon = strrchr(text, ':');
    if (colon == NULL || colon == text) {
        return false;
    }
    *colon = '\0';
    const bool in_brackets = text[0] == '[' && colon[-1] == ']';
    if (in_brackets ? colon - text < 3 : strpbrk(text, "[]:") != NULL) {
        return false;
    }
    if (in_brackets) {
        colon[-1] = '\0';
    }
    *host = text + (in_brackets ? 1 : 0);
    *port = colon + 1;
    return true;
}

void arguments_store(uint64_t value, size_t size, void *member)
{
    if (size == sizeof(uint8_t)) {
        *(uint8_t *)member = (uint8_t)value;
    } else if (size == sizeof(uint16_t)) {
        *(uint16_t *)member = (uint16_t)value;
    } else if (size == sizeof(uint32_t)) {
        *(uint32_t *)member = (uint32_t)value;
    } else {
        *(uint64_t *)member = value;
    }
}

static bool take(const argument_t *option, void *options)
{
    char name[32];
    uint64_t value = 0;
    char *const member = (char *)options + option->at;
    (void)snprintf(name, sizeof name, "--%s", option->name);
    switch (option->kind) {
    case ARGUMENT_IS_CONSTANT:
        arguments_store(option->low, option->size, member);
        return true;
    case ARGUMENT_IS_WHOLE:
        if (!arguments_whole(name, optarg, option->low, option->high, &value)) {
            return false;
        }
        arguments_store(value * option->unit, option->size, member);
        return true;
    case ARGUMENT_IS_TEXT:
        *(const char **)(void *)member = optarg;
        return strlen(optarg) >= option->low || arguments_refuse(name, "must not be empty");
    default:
        return option->take(options, optarg);
    }
}

static void prepare(const argument_t known[], size_t count, struct option *longs)
{
    for (size_t i = 0; i < count; i++) {
        const bool has_value = known[i].kind != ARGUMENT_IS_CONSTANT && known[i].kind != ARGUMENT_IS_CALL;
        *longs++ = (struct option){known[i].name, has_value ? required_argument : no_argument, NULL, LONG + (int)i};
    }
    *longs++ = (struct option){"help", no_argument, NULL, 'h'};
    *longs = (struct option){"version", no_argument, NULL, VERSION};
}

/* After getopt_long has answered ':' or '?'. */
static int tell_what_is_wrong(int answer, char *const arguments[])
{
    const char letter[] = {'-', (char)optopt, '\0'};
    char name[100];
    (void)snprintf(name, sizeof name, "%.*s", (int)strcspn(arguments[optind - 1], "="), arguments[optind - 1]);
    if (answer == ':') {
        return arguments_fail(name, "needs a value", BENCH_EXIT_USAGE);
    }
    if (optopt > 0 && optopt < LONG && strncmp(name, "--", 2) != 0) {
        return arguments_fail(letter, "no such option; see --help", BENCH_EXIT_USAGE);
    }
    return arguments_fail(name, (optopt == 0) ? "no such option; see --help" : "takes no value", BENCH_EXIT_USAGE);
}

/* The help, or the program and its version. */
static int tell(const arguments_program_t *program, int asked)
{
    const bool written =
        (asked == 'h') ? fputs(program->help, stdout) >= 0 : printf("%s %s\n", program->name, TUMBLE_VERSION) >= 0;
    return (fflush(stdout) == 0 && written) ? BENCH_EXIT_PASS : BENCH_EXIT_FAULT;
}

int arguments_read(int count, char *arguments[], const arguments_program_t *program, void *options)
{
    struct option longs[MOST + 3] = {0};
    int answer;
    int asked = 0;
    prepare(program->known, program->known_count, longs);
    opterr = 0;
    while ((answer = getopt_long(count, arguments, ":h", longs, NULL)) != -1) { /* the colon: it is silent */
        if (answer == 'h' || answer == VERSION) {
            asked = answer;
        } else if (answer < LONG) {
            return tell_what_is_wrong(answer, arguments);
        } else if (!take(&program->known[answer - LONG], options)) {
            return BENCH_EXIT_USAGE;
        }
    }
    return (asked != 0) ? tell(program, asked) : ARGUMENTS_WORK;
}
