#include "commands.h"

#include "canopen/dictionary.h"
#include "core/bytes.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define COMMAND_ARGUMENT 1U
#define COMMAND_COMMAND 2U
#define COMMAND_ANGLE 3U
#define COMMAND_PROPOSAL 4U

/* The integers: the least, one beyond the greatest, bytes; limits that a double has exactly. */
static const struct {
    uint8_t type;
    uint8_t size;
    double low;
    double end;
} integers[] = {
    {TUMBLE_TYPE_UNSIGNED8, 1, 0.0, 0x1p8},   {TUMBLE_TYPE_INTEGER8, 1, -0x1p7, 0x1p7},
    {TUMBLE_TYPE_UNSIGNED16, 2, 0.0, 0x1p16}, {TUMBLE_TYPE_INTEGER16, 2, -0x1p15, 0x1p15},
    {TUMBLE_TYPE_UNSIGNED32, 4, 0.0, 0x1p32}, {TUMBLE_TYPE_INTEGER32, 4, -0x1p31, 0x1p31},
    {TUMBLE_TYPE_UNSIGNED64, 8, 0.0, 0x1p64}, {TUMBLE_TYPE_INTEGER64, 8, -0x1p63, 0x1p63},
};

static uint8_t integer_bytes(uint8_t type, double number, uint8_t *bytes)
{
    for (size_t i = 0; i < sizeof integers / sizeof integers[0]; i++) {
        if (integers[i].type == type && number >= integers[i].low && number < integers[i].end &&
            trunc(number) == number) {
            tumble_put_u64(bytes, (number < 0.0) ? (uint64_t)(int64_t)number : (uint64_t)number);
            return integers[i].size;
        }
    }
    return 0;
}

uint8_t gateway_number_bytes(uint8_t type, double number, uint8_t *bytes)
{
    const double magnitude = fabs(number);
    const bool is_single = magnitude == 0.0 || (magnitude >= (double)FLT_MIN && magnitude <= (double)FLT_MAX);
    if (type == TUMBLE_TYPE_REAL64 && isfinite(number)) {
        tumble_put_f64(bytes, number);
        return (uint8_t)sizeof(double);
    }
    if (type == TUMBLE_TYPE_REAL32 && is_single) {
        tumble_put_f32(bytes, (float)number);
        return (uint8_t)sizeof(float);
    }
    return integer_bytes(type, number, bytes);
}

static void append(gateway_command_t *command, uint16_t index, uint8_t subindex, uint8_t type, double number)
{
    gateway_write_t *const one = &command->writes[command->count];
    one->index = index;
    one->subindex = subindex;
    one->size = gateway_number_bytes(type, number, one->bytes);
    command->count++;
}

gateway_command_t gateway_command(uint16_t index, uint8_t argument, const double *angle_deg, const uint32_t *proposal,
                                  uint8_t command)
{
    gateway_command_t made = {.group = GATEWAY_GROUP_ALWAYS};
    append(&made, index, COMMAND_ARGUMENT, TUMBLE_TYPE_UNSIGNED8, argument);
    if (angle_deg != NULL) {
        append(&made, index, COMMAND_ANGLE, TUMBLE_TYPE_REAL64, *angle_deg);
    }
    if (proposal != NULL) {
        append(&made, index, COMMAND_PROPOSAL, TUMBLE_TYPE_UNSIGNED32, (double)*proposal);
    }
    append(&made, index, COMMAND_COMMAND, TUMBLE_TYPE_UNSIGNED8, command);
    return made;
}

gateway_target_t gateway_target(uint16_t number)
{
    for (size_t i = 0; i < GATEWAY_TARGET_RUNS; i++) {
        gateway_target_t target = gateway_target_runs[i].first;
        const uint16_t ahead = (uint16_t)(number - target.number);
        if (ahead < gateway_target_runs[i].count) {
            target.number = number;
            target.subindex = (uint8_t)(target.subindex + ahead);
            return target;
        }
    }
    return (gateway_target_t){0};
}

gateway_command_t gateway_setting(gateway_target_t target, uint32_t key, double value)
{
    const gateway_target_t lock = gateway_target(GATEWAY_SERVICE_KEY);
    gateway_command_t made = {.group = target.group};
    if (key != 0U) {
        append(&made, lock.index, lock.subindex, lock.type, (double)key);
    }
    append(&made, target.index, target.subindex, target.type, value);
    made.result = (uint8_t)((made.writes[made.count - 1U].size == 0U) ? GATEWAY_RESULT_UNFIT : GATEWAY_RESULT_NONE);
    return made;
}

/* The queue. */

bool gateway_queue_add(gateway_queue_t *queue, gateway_command_t *command)
{
    if (queue->count == GATEWAY_MAX_SESSIONS) {
        return false;
    }
    command->result = (uint8_t)GATEWAY_RESULT_PENDING;
    command->abort = 0;
    queue->items[queue->count].command = *command;
    queue->items[queue->count].owner = command;
    queue->count++;
    return true;
}

void gateway_queue_end_service(gateway_queue_t *queue)
{
    if (queue->ends_service) {
        queue->ending = gateway_setting(gateway_target(GATEWAY_SERVICE_KEY), 0, 0.0);
        queue->ends_service = !gateway_queue_add(queue, &queue->ending);
    }
}

void gateway_queue_end(gateway_queue_t *queue, gateway_result_t result, uint32_t abort)
{
    gateway_command_t *const owner = queue->items[0].owner;
    queue->ended++;
    if (owner != NULL) {
        owner->ended = queue->ended;
        owner->result = (uint8_t)result;
        owner->abort = abort;
    }
    queue->count--;
    memmove(&queue->items[0], &queue->items[1], queue->count * sizeof queue->items[0]);
}

void gateway_queue_forget(gateway_queue_t *queue, const gateway_command_t *command)
{
    for (uint16_t i = 0; i < queue->count; i++) {
        if (queue->items[i].owner == command) {
            queue->items[i].owner = NULL;
        }
    }
}
