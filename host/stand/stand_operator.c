#include "stand_operator.h"

#include "navcomp/commands.h"
#include "stand_bridge.h"
#include "world/world.h"

#include <stdio.h>
#include <string.h>

#define STATE_PDO 0x181U
#define STATE_PDO_BYTES 8U
#define REQUEST 0x601U /* to the first SDO server of node 1 */
#define ANSWER 0x581U
#define SECOND 0x200U /* so much lower are both of the second one */
#define DOWNLOADED 0x60U
#define ABORTED 0x80U
#define COMMAND_INDEX 0x2002U
#define ARGUMENT 1U
#define COMMAND 2U
#define PATIENCE_US 300000U /* for one answer */
#define EARLY_US 2000000U   /* that an answer may come before its question */
#define AGAIN_US 1000000U   /* after a refusal, or no answer */

void stand_operator_init(stand_operator_t *operator, stand_operator_kind_t kind)
{
    *operator = (stand_operator_t){.kind = kind,
                                   .starts = kind == STAND_OPERATOR_STARTS,
                                   .below = SECOND,
                                   .act_us = SIM_NEVER,
                                   .patience_us = SIM_NEVER};
}

/* What the state PDO says, as far as it goes. */
static bool read_progress(const bench_world_t *world, const tumble_can_frame_t *frame, tumble_progress_t *progress)
{
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    if (frame->length != STATE_PDO_BYTES || frame->data[0] >= TUMBLE_STATE_COUNT ||
        frame->data[2] >= schedule->position_count) {
        return false;
    }
    *progress = (tumble_progress_t){
        .state = (tumble_state_t)frame->data[0],
        .reason = (tumble_reason_t)frame->data[1],
        .index = frame->data[2],
        .finished = frame->data[3],
        .count = schedule->position_count,
        .mounting = schedule->positions[frame->data[2]].mounting,
        .position = schedule->positions[frame->data[2]].number,
    };
    return true;
}

/* What the firmware in the same process would tell the simulation. */
static void tell_simulation(bench_world_t *world)
{
    const tumble_progress_t *const progress = &world->progress;
    world->angle_error.position = progress->index;
    bench_fault_script_update(world, progress);
    if (progress->state == TUMBLE_STATE_SETTLE || progress->state == TUMBLE_STATE_AVERAGE) {
        world->truth.alpha4_rad[progress->index] = sim_axis_error_rad(world->axis);
    }
}

/* How long he takes; below 0: he does nothing by himself. */
static double time_for(const stand_operator_t *operator, const bench_world_t *world, const bench_question_t *question)
{
    const sim_operator_config_t *const config = &world->config->scenario.operator;
    const bool mends = question->kind == BENCH_QUESTION_FAULT && world->operator.mended < config->mends;
    if (question->kind != BENCH_QUESTION_MOUNTING && !mends) {
        return -1.0;
    }
    if (operator->kind == STAND_OPERATOR_HANDS) {
        return 0.0; /* whoever tells node 1 that it is done cannot see whether it is */
    }
    return mends ? config->mend_s : config->mount_s;
}

static void drop_command(stand_operator_t *operator)
{
    operator->command = 0;
    operator->patience_us = SIM_NEVER;
}

static void act(stand_operator_t *operator, bench_world_t *world);

/* Another question, or none. What a person has begun meanwhile goes on. */
static void ask_operator(stand_operator_t *operator, bench_world_t *world)
{
    if (operator->question.kind != BENCH_QUESTION_NONE && world->clock.now_us < operator->early_us) {
        operator->early_us = 0;
        act(operator, world);
    }
}

static void look(stand_operator_t *operator, bench_world_t *world)
{
    const bench_question_t question = (operator->kind == STAND_OPERATOR_NONE)
                                          ? (bench_question_t){.kind = BENCH_QUESTION_NONE}
                                          : bench_operator_question(&world->progress);
    const bool starting = operator->command == (uint8_t)TUMBLE_COMMAND_START;
    if (operator->starts && world->progress.state == TUMBLE_STATE_IDLE && !starting) {
        operator->act_us = world->clock.now_us;
        return;
    }
    if (starting && world->progress.state != TUMBLE_STATE_IDLE) {
        operator->starts = false;
        drop_command(operator);
    }
    if (question.kind == operator->question.kind && question.mounting == operator->question.mounting &&
        question.reason == operator->question.reason) {
        return;
    }
    if (operator->kind == STAND_OPERATOR_FOLLOWS) {
        bench_operator_follow(world, &operator->question);
        operator->question = question;
        return;
    }
    operator->question = question;
    if (operator->kind == STAND_OPERATOR_ASKS) {
        ask_operator(operator, world);
        return;
    }
    const double time_s = time_for(operator, world, &question);
    operator->act_us = (time_s < 0.0) ? SIM_NEVER : world->clock.now_us + (uint64_t)(time_s * 1e6);
    drop_command(operator);
}

static void request(const stand_operator_t *operator, bench_world_t *world)
{
    const uint8_t subindex = operator->argued ? COMMAND : ARGUMENT;
    const uint8_t value = operator->argued ? operator->command : operator->argument;
    const uint16_t id = (uint16_t)(REQUEST - operator->below);
    const tumble_can_frame_t frame = {id, 8U, {0x2FU, COMMAND_INDEX & 0xFFU, COMMAND_INDEX >> 8, subindex, value}};
    (void)sim_bus_send(&world->bus, STAND_BUS_OPERATOR, &frame);
}

static void give(stand_operator_t *operator, bench_world_t *world, tumble_command_t command, uint8_t argument)
{
    operator->command = (uint8_t)command;
    operator->argument = argument;
    operator->argued = false;
    operator->refused = false;
    operator->act_us = SIM_NEVER;
    operator->patience_us = world->clock.now_us + PATIENCE_US;
    request(operator, world);
}

static void answered(stand_operator_t *operator, bench_world_t *world, const uint8_t *data)
{
    const bool ours = operator->command != 0U && data[1] == (COMMAND_INDEX & 0xFFU) &&
                      data[2] == (COMMAND_INDEX >> 8) && data[3] == (operator->argued ? COMMAND : ARGUMENT);
    if (ours && data[0] == DOWNLOADED && !operator->argued) {
        operator->argued = true;
        operator->patience_us = world->clock.now_us + PATIENCE_US;
        request(operator, world);
    } else if (ours && data[0] == DOWNLOADED) {
        operator->answers++;
        operator->starts = operator->starts && operator->command != (uint8_t)TUMBLE_COMMAND_START;
        operator->question = (bench_question_t){.kind = BENCH_QUESTION_NONE}; /* it may be put again */
        drop_command(operator);
    } else if (ours && data[0] == ABORTED) {
        operator->refusals++;
        operator->refused = true;
        operator->patience_us = world->clock.now_us;
        if (operator->kind == STAND_OPERATOR_ASKS) {
            drop_command(operator);
        }
    }
}

void stand_operator_hear(stand_operator_t *operator, bench_world_t *world, const tumble_can_frame_t *frame)
{
    if (frame->id == STATE_PDO && read_progress(world, frame, &world->progress)) {
        tell_simulation(world);
        look(operator, world);
    } else if (frame->id == ANSWER - operator->below && frame->length == 8U) {
        answered(operator, world, frame->data);
    }
}

static void act(stand_operator_t *operator, bench_world_t *world)
{
    const bench_question_t *const question = &operator->question;
    if (question->kind == BENCH_QUESTION_NONE) {
        give(operator, world, TUMBLE_COMMAND_START, 0);
        return;
    }
    if (question->kind == BENCH_QUESTION_FAULT) {
        world->operator.mended++;
        bench_fault_script_mend(world);
    }
    const bool mounts = question->kind == BENCH_QUESTION_MOUNTING || bench_operator_must_mount(question->reason);
    if (mounts) {
        bench_operator_mount(world, question->mounting);
    }
    if (operator->kind == STAND_OPERATOR_HANDS) {
        operator->act_us = SIM_NEVER;
        return;
    }
    give(operator, world, mounts ? TUMBLE_COMMAND_CONFIRM_MOUNTING : TUMBLE_COMMAND_RESUME,
         mounts ? question->mounting : 0U);
}

bool stand_operator_answer(stand_operator_t *operator, bench_world_t *world, const char *line)
{
    unsigned number = 0;
    char end = '\0';
    if (strcmp(line, "done") == 0) {
        if (operator->kind == STAND_OPERATOR_NONE) {
            return false;
        }
        operator->early_us = world->clock.now_us + EARLY_US;
        ask_operator(operator, world);
    } else if (strcmp(line, "abort") == 0) {
        give(operator, world, TUMBLE_COMMAND_ABORT, 0);
    } else if (sscanf(line, "repeat position %3u%c", &number, &end) == 1 && number <= UINT8_MAX) {
        give(operator, world, TUMBLE_COMMAND_REPEAT_POSITION, (uint8_t)number);
    } else if (sscanf(line, "repeat mounting %3u%c", &number, &end) == 1 && number <= UINT8_MAX) {
        give(operator, world, TUMBLE_COMMAND_REPEAT_MOUNTING, (uint8_t)number);
    } else {
        return false;
    }
    return true;
}

uint64_t stand_operator_next_us(const stand_operator_t *operator)
{
    return (operator->act_us < operator->patience_us) ? operator->act_us : operator->patience_us;
}

void stand_operator_step(stand_operator_t *operator, bench_world_t *world)
{
    if (world->clock.now_us >= operator->act_us) {
        act(operator, world);
    } else if (world->clock.now_us >= operator->patience_us) {
        if (!operator->refused) {
            operator->below = SECOND - operator->below; /* node 1 may have the other one alone */
        }
        give(operator, world, (tumble_command_t)operator->command, operator->argument);
        operator->patience_us = world->clock.now_us + AGAIN_US;
    }
}
