/* person.h - the operator: mounts the block, turns a dividing head, mends faults, and tells the firmware.
 *
 * A question is put when the firmware begins to wait for a person. Either somebody outside answers it, or the simulated
 * operator does, after the time that the scenario gives him.
 */
#ifndef TUMBLE_WORLD_PERSON_H
#define TUMBLE_WORLD_PERSON_H

#include "world/scene.h"

void bench_person_init(bench_world_t *world);

/* What the state of a run asks of a person: to mount the block, to mend a fault, or nothing. */
bench_question_t bench_person_question(const tumble_progress_t *progress);

/* Is this fault mended by mounting the block anew? */
bool bench_person_must_mount(tumble_reason_t reason);

/* Do what was asked, once the firmware goes on and somebody else has told it to: mount the block, mend the fault, while
 * the scenario lets him. `asked`: the question before; world->progress: what has become of it. */
void bench_person_follow(bench_world_t *world, const bench_question_t *asked);

/* Mount the block as asked, or, the first time, as the scenario has the operator err. */
void bench_person_mount(bench_world_t *world, uint8_t asked);

/* The firmware may have begun to wait, or ended it: after every step. */
void bench_person_look(bench_world_t *world);

/* The simulated operator's time has come. */
void bench_person_on_alarm(bench_world_t *world);

/* Answer the open question: do it, and tell the firmware. */
tumble_status_t bench_person_answer(bench_world_t *world, bench_answer_t answer, uint8_t argument);

/* Will anybody act on the open question? */
bool bench_person_is_awaited(const bench_world_t *world);

#endif
