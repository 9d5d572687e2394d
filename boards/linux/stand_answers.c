#define _POSIX_C_SOURCE 200809L

#include "stand_answers.h"

#include "event_log.h"

#include <poll.h>
#include <unistd.h>

static bool is_ready(int fd)
{
    struct pollfd asked = {.fd = fd, .events = POLLIN};
    return poll(&asked, 1, 0) > 0;
}

/* A line that is too long is cut off, and so none that is understood. */
static void take(stand_answers_t *answers, char byte, stand_operator_t *operator, bench_world_t *world)
{
    if (byte != '\n') {
        answers->line[answers->size] = byte;
        answers->size += (answers->size < STAND_ANSWER_BYTES - 1U) ? 1U : 0U;
        return;
    }
    answers->line[answers->size] = '\0';
    answers->size = 0;
    if (!stand_operator_answer(operator, world, answers->line)) {
        event_log_always(EVENT_LOG_WARNING, "ignored", EVENT_FIELDS(EVENT_TEXT("line", answers->line)),
                         "ignored, it answers no open question: %s", answers->line);
    }
}

bool stand_answers_take(stand_answers_t *answers, int fd, stand_operator_t *operator, bench_world_t *world)
{
    char bytes[STAND_ANSWER_BYTES];
    while (is_ready(fd)) {
        const ssize_t got = read(fd, bytes, sizeof bytes);
        if (got <= 0) {
            return false;
        }
        for (ssize_t i = 0; i < got; i++) {
            take(answers, bytes[i], operator, world);
        }
    }
    return true;
}
