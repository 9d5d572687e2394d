#include "progress.h"

#include "json.h"
#include "report.h"

static bench_json_t begin(const char *event, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "event", event);
    return json;
}

/* A line is for somebody who waits for it. */
static void end(bench_json_t *json)
{
    bench_json_close(json, '}');
    (void)fputc('\n', json->out);
    (void)fflush(json->out);
}

static void put_time(bench_json_t *json, const bench_world_t *world)
{
    bench_json_number(json, "virtual_s", (double)world->clock.now_us * 1e-6);
}

/* Where the table stands, as long as that is known: it has homed, and the axis has no fault. */
static void put_angle(bench_json_t *json, const bench_world_t *world)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&world->navcomp, &progress);
    const bool moving = progress.stand == TUMBLE_STAND_MOVING;
    if (moving || progress.stand == TUMBLE_STAND_IN_POSITION || progress.stand == TUMBLE_STAND_STOPPED) {
        bench_json_number(json, "angle_deg", progress.angle_deg);
    } else {
        bench_json_null(json, "angle_deg");
    }
}

static void put_place(bench_json_t *json, const tumble_progress_t *progress)
{
    bench_json_text(json, "state", tumble_state_name(progress->state));
    bench_json_whole(json, "mounting", progress->mounting);
    bench_json_whole(json, "position", progress->position);
    bench_json_whole(json, "index", progress->index);
    bench_json_whole(json, "count", progress->count);
    bench_json_whole(json, "finished", progress->finished);
    bench_json_whole(json, "attempt", progress->attempt);
    bench_json_text(json, "reason", tumble_reason_name(progress->reason));
}

void bench_progress_state(const bench_world_t *world, const tumble_progress_t *progress, FILE *out)
{
    bench_json_t json = begin("state", out);
    put_time(&json, world);
    put_place(&json, progress);
    put_angle(&json, world);
    end(&json);
}

void bench_progress_average(const bench_world_t *world, tumble_taken_t taken, FILE *out)
{
    const uint32_t wanted = world->config->procedure.samples;
    const uint32_t tenth = (wanted < 10U) ? 1U : wanted / 10U;
    tumble_navcomp_progress_t progress;
    if (taken.ordinal % tenth != 0U) {
        return;
    }
    tumble_navcomp_progress(&world->navcomp, &progress);
    bench_json_t json = begin("average", out);
    put_time(&json, world);
    put_place(&json, &progress.run);
    put_angle(&json, world);
    bench_json_whole(&json, "samples", taken.ordinal);
    bench_json_whole(&json, "wanted", wanted);
    if (progress.has_mean) {
        bench_json_vector(&json, "mean_v", progress.mean_v, TUMBLE_CHANNELS);
        bench_json_vector(&json, "standard_error_v", progress.standard_error_v, TUMBLE_CHANNELS);
    } else {
        bench_json_null(&json, "mean_v");
        bench_json_null(&json, "standard_error_v");
    }
    end(&json);
}

void bench_progress_question(const bench_world_t *world, const bench_question_t *question, FILE *out)
{
    static const char *const KINDS[] = {"none", "mounting", "angle", "fault"};
    bench_json_t json = begin("question", out);
    put_time(&json, world);
    bench_json_text(&json, "kind", KINDS[question->kind]);
    bench_json_whole(&json, "mounting", question->mounting);
    if (question->kind == BENCH_QUESTION_ANGLE) {
        bench_json_number(&json, "angle_deg", question->angle_deg);
    } else if (question->kind == BENCH_QUESTION_FAULT) {
        bench_json_text(&json, "reason", tumble_reason_name(question->reason));
        bench_json_text(&json, "sentence", tumble_reason_sentence(question->reason));
    }
    end(&json);
}

void bench_progress_refused(const char *what, FILE *out)
{
    bench_json_t json = begin("refused", out);
    bench_json_text(&json, "what", what);
    end(&json);
}

void bench_progress_end(const bench_world_t *world, FILE *out)
{
    bench_json_t json = begin("end", out);
    put_time(&json, world);
    bench_json_text(&json, "end", bench_end_name(world->end));
    bench_json_whole(&json, "exit", (uint64_t)bench_exit_code(world));
    end(&json);
}
