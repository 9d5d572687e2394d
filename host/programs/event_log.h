/* event_log.h - what tumble-node, tumble-stand and tumble-gateway tell of themselves on standard error, a line for each
 * event.
 *
 * Its forms, and what they are where standard error is the journal of systemd (JOURNAL_STREAM), are those of docs/operations.md.
 *
 * A line is written at once and whole, or not at all: nothing here waits for who reads it, be it a terminal that is
 * stopped, a pipe or a socket that is full. (What a terminal or a socket takes of a line in part is lost, and the next
 * one begins on a line of its own.) What finds no room is left out and counted; so is what is more than EVENT_LOG_BURST
 * lines at a time, with EVENT_LOG_RESERVE more for warnings and notices, unless it is an error or the end. The next line
 * that goes is preceded by one of the event "lost" with that number.
 *
 * There is one log in a process, as there is one standard error. Not re-entrant.
 */
#ifndef TUMBLE_PROGRAMS_EVENT_LOG_H
#define TUMBLE_PROGRAMS_EVENT_LOG_H

#include "arguments.h"

#include <stdbool.h>
#include <stdint.h>

#define EVENT_LOG_BURST 200U      /* lines at a time, below errors, ... */
#define EVENT_LOG_RESERVE 100U    /* ... so many more for what is worse than info, ... */
#define EVENT_LOG_PER_SECOND 20U  /* ... and so many a second from then on */
#define EVENT_LOG_TEXT_BYTES 600U /* a text of a field, or the message, is cut off there */

/* Of syslog. */
typedef enum { EVENT_LOG_ERROR = 3, EVENT_LOG_WARNING = 4, EVENT_LOG_NOTICE = 5, EVENT_LOG_INFO = 6 } event_log_level_t;

/* A member of the line in JSON. A text may be anything: what is no UTF-8, and control characters, become '?'. */
typedef struct {
    const char *name; /* null: the end of a list */
    const char *text; /* null: it is a number */
    uint64_t whole;
} event_field_t;

#define EVENT_TEXT(member, value) {.name = (member), .text = (value)}
#define EVENT_WHOLE(member, value) {.name = (member), .whole = (value)}
#define EVENT_FIELDS(...) ((const event_field_t[]){__VA_ARGS__, {.name = NULL}})

/* Rows of a program's options. --log-level alone means --log text. */
#define EVENT_LOG_ARGUMENTS ARGUMENT_TAKE("log", event_log_take_form), ARGUMENT_TAKE("log-level", event_log_take_level)
bool event_log_take_form(void *options, const char *form);
bool event_log_take_level(void *options, const char *level);

/* What --help says of these, and of the last options of every program on a CAN interface. */
#define EVENT_LOG_AND_PARENT_HELP                                                                                      \
    "  --log FORM       tell every event on standard error, a line for each: text or\n"                                \
    "                   json (docs/operations.md)\n"                                                                   \
    "  --log-level WHAT error, warning, notice or info: this and what is worse;\n"                                     \
    "                   default: info\n"                                                                               \
    "  --with-parent    end, as by SIGTERM, when the process that started this one\n"                                  \
    "                   has ended\n"                                                                                   \
    "  --version        print the version\n"                                                                           \
    "  -h, --help       print this\n"

/* Begin: the name of the program, which must stay, and the descriptor to write to, which is not closed. Before, nothing
 * is written. */
void event_log_start(const char *program, int fd);

/* As it was when the process began. For tests. */
void event_log_reset(void);

/* Does anybody want every event? Else only what event_log_always tells is written, as it ever was. */
bool event_log_is_on(void);

typedef enum {
    EVENT_LOG_ASKED_FOR, /* by --log */
    EVENT_LOG_ALWAYS,    /* written in plain form, too */
    EVENT_LOG_LAST       /* as asked for, however many went before */
} event_log_when_t;

/* An event, with its members for JSON (EVENT_FIELDS, or null), and its sentence. */
void event_log_write(event_log_when_t when, event_log_level_t level, const char *event, const event_field_t *fields,
                     const char *format, ...) __attribute__((format(printf, 5, 6)));

#define event_log_tell(...) event_log_write(EVENT_LOG_ASKED_FOR, __VA_ARGS__)
#define event_log_always(...) event_log_write(EVENT_LOG_ALWAYS, __VA_ARGS__)
#define event_log_end(level, ...) event_log_write(EVENT_LOG_LAST, level, "end", __VA_ARGS__)

#endif
