/* stand_answers.h - what a person at the stand says, on standard input, a line for each answer. */
#ifndef TUMBLE_LINUX_STAND_ANSWERS_H
#define TUMBLE_LINUX_STAND_ANSWERS_H

#include "stand_operator.h"

#include <stdbool.h>
#include <stdint.h>

#define STAND_ANSWER_BYTES 200U

typedef struct {
    char line[STAND_ANSWER_BYTES]; /* as far as it has come */
    uint32_t size;
} stand_answers_t;

/* Hand on the answers that have come, without waiting; what is none is told on standard error. False: there will be no
 * more. */
bool stand_answers_take(stand_answers_t *answers, int fd, stand_operator_t *operator, bench_world_t *world);

#endif
