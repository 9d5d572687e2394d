/* person.h - the operator: mounts the block, turns a dividing head, mends faults, and tells the firmware.
 *
 * A question is put when the firmware begins to wait for a person. Either somebody outside answers it, or the simulated
 * operator does, after the time that the scenario gives him.
 */
#ifndef TUMBLE_BENCH_PERSON_H
#define TUMBLE_BENCH_PERSON_H

#include "procedure/procedure.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct bench_world bench_world_t;

typedef enum {
    BENCH_QUESTION_NONE = 0,
    BENCH_QUESTION_MOUNTING, /* put the block on the table as `mounting` says */
    BENCH_QUESTION_ANGLE,    /* turn the dividing head to `angle_deg` */
    BENCH_QUESTION_FAULT     /* mend it and go on, or give up */
} bench_question_kind_t;

typedef struct {
    bench_question_kind_t kind;
    uint8_t mounting;
    double angle_deg;
    tumble_reason_t reason;
} bench_question_t;

typedef enum {
    BENCH_ANSWER_DONE = 0, /* mounted, turned, or mended: go on */
    BENCH_ANSWER_ABORT,
    BENCH_ANSWER_REPEAT_POSITION, /* argument: index in the schedule */
    BENCH_ANSWER_REPEAT_MOUNTING, /* argument: number of the mounting */
    BENCH_ANSWER_LEAVE            /* do nothing: the run ends where it is */
} bench_answer_t;

typedef struct {
    bench_question_t question;              /* open at the moment */
    uint64_t act_us;                        /* when the simulated operator answers; SIM_NEVER: never */
    bool outside;                           /* somebody outside has been asked, and has not answered */
    uint32_t mended;                        /* faults mended so far */
    bool erred;                             /* the wrong mounting has been made */
    uint32_t mounted[TUMBLE_MAX_MOUNTINGS]; /* how often each was put on the table */
} bench_person_t;

void bench_person_init(bench_world_t *world);

/* The firmware may have begun to wait, or ended it: after every step. */
void bench_person_look(bench_world_t *world);

/* The simulated operator's time has come. */
void bench_person_on_alarm(bench_world_t *world);

/* Answer the open question: do it, and tell the firmware. */
tumble_status_t bench_person_answer(bench_world_t *world, bench_answer_t answer, uint8_t argument);

/* Will anybody act on the open question? */
bool bench_person_is_awaited(const bench_world_t *world);

#endif
