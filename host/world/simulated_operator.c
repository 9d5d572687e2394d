#include "world/world.h"

void bench_operator_init(bench_world_t *world)
{
    world->operator = (bench_operator_t){.act_us = SIM_NEVER};
}

bench_question_t bench_operator_question(const tumble_progress_t *progress)
{
    if (progress->state == TUMBLE_STATE_WAIT_MOUNTING) {
        return (bench_question_t){.kind = BENCH_QUESTION_MOUNTING, .mounting = progress->mounting};
    }
    if (progress->state == TUMBLE_STATE_FAULT) {
        return (bench_question_t){
            .kind = BENCH_QUESTION_FAULT, .mounting = progress->mounting, .reason = progress->reason};
    }
    return (bench_question_t){.kind = BENCH_QUESTION_NONE};
}

bool bench_operator_must_mount(tumble_reason_t reason)
{
    return reason == TUMBLE_REASON_MOUNTING_NOT_CONFIRMED || reason == TUMBLE_REASON_WRONG_MOUNTING ||
           reason == TUMBLE_REASON_SWAPPED_CHANNELS;
}

/* What the firmware waits for, if anything. */
static bench_question_t question_of(const bench_world_t *world)
{
    bench_question_t question = bench_operator_question(&world->progress);
    if (question.kind == BENCH_QUESTION_NONE && tumble_navcomp_request(&world->navcomp, &question.angle_deg)) {
        question.kind = BENCH_QUESTION_ANGLE;
        question.mounting = world->progress.mounting;
    }
    return question;
}

static bool is_same(const bench_question_t *a, const bench_question_t *b)
{
    return a->kind == b->kind && a->mounting == b->mounting && a->angle_deg == b->angle_deg && a->reason == b->reason;
}

static uint8_t mounting_index(const tumble_schedule_t *schedule, uint8_t number)
{
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        if (schedule->mountings[m].number == number) {
            return m;
        }
    }
    return 0;
}

/* How long the simulated operator takes, below 0: he does nothing. */
static double time_for(const bench_world_t *world, const bench_question_t *question)
{
    const sim_operator_config_t *const config = &world->config->scenario.operator;
    const uint8_t index = mounting_index(&world->config->scenario.schedule, question->mounting);
    switch (question->kind) {
    case BENCH_QUESTION_MOUNTING:
        return bench_world_inclines(world, index) ? config->incline_s : config->mount_s;
    case BENCH_QUESTION_ANGLE:
        return config->turn_s;
    case BENCH_QUESTION_FAULT:
        return (world->operator.mended < config->mends) ? config->mend_s : -1.0;
    default:
        return -1.0;
    }
}

void bench_operator_update(bench_world_t *world)
{
    bench_operator_t *const operator = &world->operator;
    const bench_watcher_t *const watcher = world->watcher;
    const bench_question_t question = question_of(world);
    if (is_same(&question, &operator->question)) {
        return;
    }
    operator->question = question;
    operator->act_us = SIM_NEVER;
    operator->outside = question.kind != BENCH_QUESTION_NONE && watcher->on_question != NULL &&
                        watcher->on_question(watcher->context, &question);
    const double time_s = operator->outside ? -1.0 : time_for(world, &question);
    if (time_s >= 0.0) {
        operator->act_us = world->clock.now_us + (uint64_t)(time_s * 1e6);
    }
    sim_clock_set(&world->clock, SIM_ACTOR_OPERATOR, operator->act_us);
}

void bench_operator_on_alarm(bench_world_t *world)
{
    (void)bench_operator_answer(world, WORLD_ANSWER_DONE, 0);
}

void bench_operator_mount(bench_world_t *world, uint8_t asked)
{
    const sim_operator_config_t *const config = &world->config->scenario.operator;
    uint8_t number = asked;
    if (asked == config->wrong_mounting && !world->operator.erred) {
        world->operator.erred = true;
        number = config->mounted_instead;
    }
    bench_world_mount(world, mounting_index(&world->config->scenario.schedule, number));
}

/* The mounting was confirmed: whoever repeats another one, gives up or waits too long has not done so. */
static bool goes_on(tumble_state_t state)
{
    return state != TUMBLE_STATE_WAIT_MOUNTING && state != TUMBLE_STATE_FAULT && state != TUMBLE_STATE_ABORT &&
           state != TUMBLE_STATE_IDLE;
}

void bench_operator_follow(bench_world_t *world, const bench_question_t *asked)
{
    const tumble_state_t state = world->progress.state;
    const bool fault = asked->kind == BENCH_QUESTION_FAULT;
    if (fault && (state == TUMBLE_STATE_WAIT_MOUNTING || goes_on(state)) &&
        world->operator.mended < world->config->scenario.operator.mends) {
        world->operator.mended++;
        bench_fault_script_mend(world);
    }
    const bool mounts = asked->kind == BENCH_QUESTION_MOUNTING || (fault && bench_operator_must_mount(asked->reason));
    if (mounts && goes_on(state)) {
        bench_operator_mount(world, asked->mounting);
    }
}

static tumble_status_t confirm_mounting(bench_world_t *world, uint8_t number)
{
    bench_operator_mount(world, number);
    return tumble_navcomp_command(&world->navcomp, TUMBLE_COMMAND_CONFIRM_MOUNTING, number);
}

static tumble_status_t mend(bench_world_t *world, const bench_question_t *question)
{
    world->operator.mended++;
    bench_fault_script_mend(world);
    if (bench_operator_must_mount(question->reason)) {
        return confirm_mounting(world, question->mounting);
    }
    return tumble_navcomp_command(&world->navcomp, TUMBLE_COMMAND_RESUME, 0);
}

static tumble_status_t turn_by_hand(bench_world_t *world, double angle_deg)
{
    static const sim_axis_dynamics_t HAND = {360.0, 3600.0, 3600.0}; /* he has taken his time before */
    sim_axis_move(world->axis, world->clock.now_us, angle_deg, &HAND);
    return tumble_navcomp_confirm_angle(&world->navcomp, angle_deg);
}

static tumble_status_t do_it(bench_world_t *world, const bench_question_t *question)
{
    switch (question->kind) {
    case BENCH_QUESTION_MOUNTING:
        return confirm_mounting(world, question->mounting);
    case BENCH_QUESTION_ANGLE:
        return turn_by_hand(world, question->angle_deg);
    case BENCH_QUESTION_FAULT:
        return mend(world, question);
    default:
        return TUMBLE_E_STATE;
    }
}

/* What was done may have been accepted or not. Accepted, it may fail again at once, in the same place: that is another
 * question then. */
static tumble_status_t go_on(bench_world_t *world, tumble_status_t status)
{
    if (status == TUMBLE_OK) {
        world->operator.question = (bench_question_t){.kind = BENCH_QUESTION_NONE};
        world->mark = BENCH_LOOK_AGAIN;
    }
    sim_clock_set(&world->clock, SIM_ACTOR_NAVCOMP, world->clock.now_us);
    return status;
}

tumble_status_t bench_operator_answer(bench_world_t *world, world_answer_t answer, uint8_t argument)
{
    const bench_question_t question = world->operator.question;
    world->operator.act_us = SIM_NEVER;
    world->operator.outside = false;
    switch (answer) {
    case WORLD_ANSWER_DONE:
        return go_on(world, do_it(world, &question));
    case WORLD_ANSWER_REPEAT_POSITION:
        return go_on(world, tumble_navcomp_command(&world->navcomp, TUMBLE_COMMAND_REPEAT_POSITION, argument));
    case WORLD_ANSWER_REPEAT_MOUNTING:
        return go_on(world, tumble_navcomp_command(&world->navcomp, TUMBLE_COMMAND_REPEAT_MOUNTING, argument));
    case WORLD_ANSWER_ABORT:
        bench_world_abort(world);
        return TUMBLE_OK;
    default:
        return TUMBLE_OK;
    }
}

bool bench_operator_is_awaited(const bench_world_t *world)
{
    return world->operator.act_us != SIM_NEVER || world->operator.outside;
}
