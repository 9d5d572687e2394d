#define _POSIX_C_SOURCE 200809L

#include "event_log.h"

#include "outlet.h"
#include "world/json.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#define LINE_BYTES 4096 /* what a pipe takes whole or not at all */
#define TIME_BYTES 40
#define US_PER_S UINT64_C(1000000)
#define NS_PER_US 1000
#define NS_PER_MS 1000000

typedef enum { FORM_PLAIN = 0, FORM_TEXT, FORM_JSON } form_t;

typedef struct {
    form_t form;
    event_log_level_t level; /* the least severe that is told; 0: EVENT_LOG_INFO */
    const char *program;     /* null: not begun */
    nowait_t to;
    bool is_journal;
    bool is_torn; /* the last line went in part: its end is still owed */
    uint32_t lost;
    uint64_t room_us; /* of lines that may go now, in the time that each takes to be earned; with the reserve */
    uint64_t seen_us;
} event_log_t;

#define PRICE_US (US_PER_S / EVENT_LOG_PER_SECOND)
#define RESERVE_US (EVENT_LOG_RESERVE * PRICE_US)
#define MOST_US (EVENT_LOG_BURST * PRICE_US + RESERVE_US)

static event_log_t the_log;

static const char *level_name(event_log_level_t level)
{
    static const char *const names[] = {
        [EVENT_LOG_ERROR] = "error",
        [EVENT_LOG_WARNING] = "warning",
        [EVENT_LOG_NOTICE] = "notice",
        [EVENT_LOG_INFO] = "info",
    };
    return names[level];
}

/* Options. */

bool event_log_take_form(void *options, const char *form)
{
    (void)options;
    if (strcmp(form, "text") != 0 && strcmp(form, "json") != 0) {
        return arguments_refuse("--log", "must be text or json");
    }
    the_log.form = (*form == 't') ? FORM_TEXT : FORM_JSON;
    return true;
}

bool event_log_take_level(void *options, const char *name)
{
    (void)options;
    for (event_log_level_t level = EVENT_LOG_ERROR; level <= EVENT_LOG_INFO; level++) {
        if (strcmp(name, level_name(level)) == 0) {
            the_log.level = level;
            the_log.form = (the_log.form == FORM_PLAIN) ? FORM_TEXT : the_log.form;
            return true;
        }
    }
    return arguments_refuse("--log-level", "must be error, warning, notice or info");
}

bool event_log_is_on(void)
{
    return the_log.form != FORM_PLAIN;
}

/* Where it goes. */

/* JOURNAL_STREAM is DEVICE:INODE of what the manager has connected; the descriptor may have become another since. */
static bool leads_to_journal(int fd)
{
    const char *const stream = getenv("JOURNAL_STREAM");
    uintmax_t device = 0;
    uintmax_t inode = 0;
    char end = '\0';
    struct stat status;
    return stream != NULL && sscanf(stream, "%ju:%ju%c", &device, &inode, &end) == 2 && fstat(fd, &status) == 0 &&
           device == (uintmax_t)status.st_dev && inode == (uintmax_t)status.st_ino;
}

static uint64_t monotonic_us(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * US_PER_S + (uint64_t)now.tv_nsec / NS_PER_US;
}

void event_log_start(const char *program, int fd)
{
    nowait_close(&the_log.to);
    nowait_open(&the_log.to, fd);
    the_log.program = program;
    the_log.level = (the_log.level == 0) ? EVENT_LOG_INFO : the_log.level;
    the_log.is_journal = leads_to_journal(fd);
    the_log.room_us = MOST_US;
    the_log.seen_us = monotonic_us();
    the_log.lost = 0;
    the_log.is_torn = false;
}

void event_log_reset(void)
{
    nowait_close(&the_log.to);
    the_log = (event_log_t){0};
}

/* False: it is left out. */
static bool write_line(const char *line, size_t size)
{
    if (!nowait_is_writable(&the_log.to) || (the_log.is_torn && nowait_write(&the_log.to, "\n", 1) != 1)) {
        return false;
    }
    const ssize_t written = nowait_write(&the_log.to, line, size);
    the_log.is_torn = written > 0 && (size_t)written < size;
    return written == (ssize_t)size;
}

/* May one more line go? One is earned in every EVENT_LOG_PER_SECOND-th of a second; of the reserve, none for what only
 * informs. */
static bool has_room(event_log_level_t level)
{
    const uint64_t kept_us = (level == EVENT_LOG_INFO) ? RESERVE_US : 0U;
    const uint64_t now_us = monotonic_us();
    const uint64_t room_us = the_log.room_us + (now_us - the_log.seen_us);
    the_log.room_us = (room_us < MOST_US) ? room_us : MOST_US;
    the_log.seen_us = now_us;
    if (level == EVENT_LOG_ERROR) {
        return true;
    }
    if (the_log.room_us < kept_us + PRICE_US) {
        return false;
    }
    the_log.room_us -= PRICE_US;
    return true;
}

/* A line. */

static bool is_control(const char *character, size_t size)
{
    const unsigned first = (unsigned char)character[0];
    return first < 0x20U || first == 0x7FU || (size == 2U && first == 0xC2U && (unsigned char)character[1] < 0xA0U);
}

/* A text was cut off within the character that begins here, not more than three bytes before its end. */
static bool is_cut_off(const char *text, const char *at)
{
    const size_t before = (size_t)(at - text);
    return (unsigned char)*at >= 0xC0U && before + 3U >= EVENT_LOG_TEXT_BYTES - 1U &&
           before + strlen(at) == EVENT_LOG_TEXT_BYTES - 1U;
}

/* On one line, whatever a name from outside holds, and of whole characters: what is no UTF-8 becomes question marks. */
static void clean(char *text)
{
    char *to = text;
    for (const char *from = text; *from != '\0';) {
        const size_t size = bench_json_character(from);
        if (size == 0U && is_cut_off(text, from)) {
            break;
        }
        if (size == 0U || is_control(from, size)) {
            *to++ = '?';
        } else {
            memmove(to, from, size);
            to += size;
        }
        from += (size > 0U) ? size : 1U;
    }
    *to = '\0';
}

static void put_time(char *text)
{
    struct timespec now = {0};
    struct tm utc = {0};
    char seconds[TIME_BYTES / 2];
    (void)clock_gettime(CLOCK_REALTIME, &now);
    (void)gmtime_r(&now.tv_sec, &utc);
    (void)strftime(seconds, sizeof seconds, "%Y-%m-%dT%H:%M:%S", &utc);
    (void)snprintf(text, TIME_BYTES, "%s.%03ldZ", seconds, now.tv_nsec / NS_PER_MS);
}

static void put_fields(bench_json_t *json, const event_field_t *fields)
{
    for (const event_field_t *field = fields; field != NULL && field->name != NULL; field++) {
        char text[EVENT_LOG_TEXT_BYTES];
        if (field->text == NULL) {
            bench_json_whole(json, field->name, field->whole);
        } else {
            (void)snprintf(text, sizeof text, "%s", field->text);
            clean(text);
            bench_json_text(json, field->name, text);
        }
    }
}

static void put_json(FILE *out, event_log_level_t level, const char *event, const event_field_t *fields,
                     const char *message)
{
    bench_json_t json = {.out = out};
    char when[TIME_BYTES];
    put_time(when);
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.log/1");
    bench_json_text(&json, "time", when);
    bench_json_text(&json, "program", the_log.program);
    bench_json_text(&json, "level", level_name(level));
    bench_json_text(&json, "event", event);
    put_fields(&json, fields);
    bench_json_text(&json, "message", message);
    bench_json_close(&json, '}');
}

static void put_text(FILE *out, event_log_level_t level, const char *message)
{
    char when[TIME_BYTES];
    put_time(when);
    if (the_log.form == FORM_PLAIN) {
        (void)fprintf(out, "%s: %s", the_log.program, message);
    } else if (the_log.is_journal) {
        (void)fputs(message, out);
    } else {
        (void)fprintf(out, "%s %s: %s: %s", when, the_log.program, level_name(level), message);
    }
}

/* False: it is left out. */
static bool tell(event_log_level_t level, const char *event, const event_field_t *fields, const char *message)
{
    char line[LINE_BYTES];
    FILE *const out = fmemopen(line, sizeof line, "w");
    if (out == NULL) {
        return false;
    }
    if (the_log.is_journal) {
        (void)fprintf(out, "<%d>", (int)level);
    }
    if (the_log.form == FORM_JSON) {
        put_json(out, level, event, fields, message);
    } else {
        put_text(out, level, message);
    }
    (void)fputc('\n', out);
    const bool fits = fflush(out) == 0;
    const long size = ftell(out);
    (void)fclose(out);
    return fits && size > 0 && write_line(line, (size_t)size);
}

static bool tell_lost(void)
{
    char message[100];
    (void)snprintf(message, sizeof message, "lines left out before this one: %" PRIu32, the_log.lost);
    return tell(EVENT_LOG_WARNING, "lost", EVENT_FIELDS(EVENT_WHOLE("lines", the_log.lost)), message);
}

void event_log_write(event_log_when_t when, event_log_level_t level, const char *event, const event_field_t *fields,
                     const char *format, ...)
{
    char message[EVENT_LOG_TEXT_BYTES];
    va_list values;
    const bool is_wanted = event_log_is_on() ? level <= the_log.level : when == EVENT_LOG_ALWAYS;
    if (the_log.program == NULL || !is_wanted) {
        return;
    }
    va_start(values, format);
    (void)vsnprintf(message, sizeof message, format, values);
    va_end(values);
    clean(message);
    const bool may = (has_room(level) || when == EVENT_LOG_LAST) && (the_log.lost == 0U || tell_lost());
    the_log.lost = may ? 0U : the_log.lost;
    if (!may || !tell(level, event, fields, message)) {
        the_log.lost += (the_log.lost < UINT32_MAX) ? 1U : 0U;
    }
}
