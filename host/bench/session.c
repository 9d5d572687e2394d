#define _POSIX_C_SOURCE 200809L

#include "bench/session.h"

#include "bench/config_keys.h"
#include "bench/folder.h"
#include "bench/guests.h"
#include "bench/interrupt.h"
#include "bench/pace.h"
#include "bench/person.h"
#include "bench/progress.h"
#include "bench/report.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAX_ANSWER 200

typedef struct {
    const bench_options_t *options;
    bench_world_t world;
    bench_watcher_t watcher;
    bench_folder_t folder;
    bench_guests_t guests;
    bench_pace_t pace;
    FILE *progress; /* null: nobody wants to know */
    uint64_t angle_told_us;
    bool left;  /* all guests have, and the run was told to end */
    bool asked; /* a question waits for an answer from standard input */
} session_t;

/* What the world tells. */

static void on_change(void *context, const tumble_progress_t *progress)
{
    session_t *const session = context;
    if (session->options->operator == BENCH_OPERATOR_ON_CONFIRM) {
        bench_person_follow(&session->world, &session->world.person.question);
    }
    if (session->progress != NULL) {
        bench_progress_state(&session->world, progress, session->progress);
    }
}

static void on_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    session_t *const session = context;
    if (session->options->out != NULL) {
        bench_folder_sample(&session->folder, session->world.clock.now_us, taken, sample);
    }
    if (session->progress != NULL) {
        bench_progress_average(&session->world, taken, session->progress);
    }
}

static void on_frame(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    session_t *const session = context;
    if (session->options->out != NULL) {
        bench_folder_frame(&session->folder, time_us, frame);
    }
    if (session->options->listen != NULL) {
        bench_guests_tell(&session->guests, sender, frame);
    }
    if (session->progress != NULL) {
        bench_progress_angle(&session->world, &session->angle_told_us, session->progress);
    }
}

static bool on_question(void *context, const bench_question_t *question)
{
    session_t *const session = context;
    if (session->progress != NULL) {
        bench_progress_question(&session->world, question, session->progress);
    }
    session->asked = session->options->interactive;
    return session->asked || session->options->operator != BENCH_OPERATOR_BY_ITSELF;
}

/* Answers from standard input. */

static bool parse_answer(char *line, bench_answer_t *answer, uint8_t *argument)
{
    bench_words_t words;
    int64_t number = 0;
    line[strcspn(line, "\r\n")] = '\0';
    if (!bench_cut_words(line, &words) || words.count == 0U) {
        return false;
    }
    switch (bench_choice(words.word[0], "done|abort|leave|repeat")) {
    case 0:
        *answer = BENCH_ANSWER_DONE;
        return words.count == 1U;
    case 1:
        *answer = BENCH_ANSWER_ABORT;
        return words.count == 1U;
    case 2:
        *answer = BENCH_ANSWER_LEAVE;
        return words.count == 1U;
    case 3:
        if (words.count != 3U || !bench_whole(words.word[2], 0, 255, &number)) {
            return false;
        }
        *argument = (uint8_t)number;
        *answer =
            (strcmp(words.word[1], "mounting") == 0) ? BENCH_ANSWER_REPEAT_MOUNTING : BENCH_ANSWER_REPEAT_POSITION;
        return bench_choice(words.word[1], "position|mounting") >= 0;
    default:
        return false;
    }
}

static void refuse(const session_t *session, const char *what)
{
    if (session->progress != NULL) {
        bench_progress_refused(what, session->progress);
    }
}

/* Until an answer is accepted. Nobody there to answer is an abort. */
static void wait_for_answer(session_t *session)
{
    char line[MAX_ANSWER];
    while (session->asked && !bench_interrupted()) {
        bench_answer_t answer = BENCH_ANSWER_ABORT;
        uint8_t argument = 0;
        if (fgets(line, sizeof line, stdin) != NULL && !parse_answer(line, &answer, &argument)) {
            refuse(session, "an answer is done, abort, leave, repeat position INDEX or repeat mounting NUMBER");
            continue;
        }
        if (bench_interrupted()) {
            return;
        }
        session->asked = false;
        const tumble_status_t status = bench_person_answer(&session->world, answer, argument);
        if (status != TUMBLE_OK) {
            session->asked = true;
            refuse(session, tumble_status_sentence(status));
        }
    }
}

/* The run itself. */

static void end_without_guests(session_t *session)
{
    const bench_config_t *const config = session->world.config;
    const bool served = session->options->listen != NULL && !(config->present.navcomp && config->starts);
    if (served && !session->left && bench_guests_have_left(&session->guests)) {
        session->left = true;
        bench_world_end(&session->world, BENCH_LEFT);
    }
}

/* The program that started this one has gone, and nobody waits for the end. */
static bool is_left_alone(const session_t *session)
{
    return session->options->progress_fd > STDERR_FILENO && ferror(session->progress) != 0;
}

static void go(session_t *session)
{
    bench_world_t *const world = &session->world;
    bool stopping = false;
    bool running = true;
    while (running) {
        if ((bench_interrupted() || is_left_alone(session)) && !stopping) {
            stopping = true;
            bench_world_end(world, BENCH_INTERRUPTED);
        }
        if (session->options->pace > 0.0 && !stopping) {
            bench_pace_wait(&session->pace, world, (session->options->listen != NULL) ? &session->guests : NULL);
            end_without_guests(session);
        }
        running = bench_world_advance(world);
        if (session->asked && !stopping) {
            wait_for_answer(session);
            bench_pace_start(&session->pace, world, session->options->pace);
        }
    }
    if (session->progress != NULL) {
        bench_progress_end(world, session->progress);
    }
}

static const char *open_all(session_t *session, const char **subject)
{
    const bench_options_t *const options = session->options;
    const char *wrong = NULL;
    if (options->progress_fd >= 0) {
        *subject = "--progress-fd";
        session->progress = fdopen(options->progress_fd, "w");
        wrong = (session->progress == NULL) ? "is not an open file descriptor" : NULL;
    }
    if (wrong == NULL && options->out != NULL) {
        *subject = options->out;
        wrong = bench_folder_open(&session->folder, options->out);
    }
    if (wrong == NULL && options->listen != NULL) {
        *subject = options->listen;
        wrong = bench_guests_open(&session->guests, options->listen, options->guests);
        if (wrong != NULL && options->out != NULL) {
            bench_folder_discard(&session->folder);
        }
    }
    return wrong;
}

static int finish(session_t *session, FILE *out)
{
    const bench_options_t *const options = session->options;
    if (options->listen != NULL) {
        bench_guests_close(&session->guests);
    }
    if (options->out != NULL) {
        const char *const wrong = bench_folder_close(&session->folder, &session->world);
        if (wrong != NULL) {
            return arguments_fail(options->out, wrong, BENCH_EXIT_USAGE);
        }
    }
    bench_report_document(&session->world, out);
    return bench_exit_code(&session->world);
}

int bench_session(const bench_config_t *config, const bench_options_t *options, FILE *out)
{
    static session_t session;
    const char *subject = "";
    session = (session_t){.options = options};
    session.watcher = (bench_watcher_t){.context = &session,
                                        .on_change = on_change,
                                        .on_sample = on_sample,
                                        .on_frame = on_frame,
                                        .on_question = on_question};
    const tumble_status_t status = bench_world_init(&session.world, config, options->seed, &session.watcher);
    if (status != TUMBLE_OK) {
        return arguments_fail("the firmware refuses its configuration", tumble_status_sentence(status),
                              BENCH_EXIT_USAGE);
    }
    const char *const wrong = open_all(&session, &subject);
    if (wrong != NULL) {
        return arguments_fail(subject, wrong, BENCH_EXIT_USAGE);
    }
    bench_pace_start(&session.pace, &session.world, options->pace);
    go(&session);
    return finish(&session, out);
}
