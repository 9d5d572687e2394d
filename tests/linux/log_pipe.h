/* log_pipe.h - a log (event_log.h) whose reader is the test, and whose time stands still. */
#ifndef TUMBLE_TESTS_LOG_PIPE_H
#define TUMBLE_TESTS_LOG_PIPE_H

#include <stddef.h>

#define LOG_PIPE_TIME "2026-11-23T11:55:01.123Z" /* when every line is written */

/* A log that has just begun, of "tumble-node", into a pipe. `form`, `level`: as --log and --log-level; null: not given. */
void log_pipe_open(const char *form, const char *level);
void log_pipe_close(void);

/* The end that the log writes to, and the one that is read. */
int log_pipe_in(void);
int log_pipe_out(void);

/* All that has come since the last call; a text, until the next one. */
const char *log_pipe_read(void);

/* So many events "state" at level info, whose messages are their numbers from 0 on. */
void log_pipe_tell(unsigned times);

/* Lines in a text. */
unsigned log_pipe_lines(const char *text);

/* So much time passes. */
void log_pipe_pass_ms(unsigned ms);

#endif
