#include "poller.h"

#include "canopen/bytes.h"
#include "image.h"

#include <string.h>

enum { PHASE_REST = 0, PHASE_BEFORE, PHASE_VALUES, PHASE_AFTER };
enum { DOING_NOTHING = 0, DOING_READ, DOING_ARGUMENT, DOING_ANGLE, DOING_COMMAND };

#define BOOT_UP_ID 0x700U
#define PROTOCOL_ERRORS 0x05U /* first byte of their abort codes */
#define COMMAND_ARGUMENT 1U
#define COMMAND_COMMAND 2U
#define COMMAND_ANGLE 3U

void gateway_poller_init(gateway_poller_t *poller, const tumble_port_t *port, uint8_t node, uint64_t period_us,
                         gateway_counters_t *counters)
{
    *poller = (gateway_poller_t){.counters = counters, .period_us = period_us, .node = node};
    tumble_link_init(&poller->link, port);
    tumble_sdo_client_init(&poller->client);
    poller->next_us = port->now_us(port->context);
    poller->must_be_fresh = true;
}

/* A poll. */

static void rest(gateway_poller_t *poller, uint64_t next_us)
{
    poller->phase = PHASE_REST;
    poller->place = 0;
    poller->next_us = next_us;
}

static void begin_poll(gateway_poller_t *poller, uint64_t now_us)
{
    memset(&poller->building, 0, sizeof poller->building);
    poller->must_be_fresh = poller->must_be_fresh || poller->has_booted;
    poller->has_booted = false;
    poller->is_partial = false;
    poller->phase = PHASE_BEFORE;
    poller->place = 0;
    poller->next_us = now_us + poller->period_us;
}

static void publish(gateway_poller_t *poller, uint64_t now_us)
{
    const uint32_t number = poller->published.number + 1U;
    gateway_count(poller->counters, GATEWAY_COUNT_POLLS);
    poller->building.number = (number != 0U) ? number : 1U;
    poller->building.taken_us = now_us;
    poller->published = poller->building;
    memcpy(poller->published_marks, poller->marks, sizeof poller->marks);
    poller->must_be_fresh = poller->is_partial || (poller->must_be_fresh && !poller->is_fresh);
    poller->kept = poller->is_fresh ? 0U : (uint16_t)(poller->kept + 1U);
    poller->torn = 0;
    rest(poller, poller->next_us);
}

static void note_torn(gateway_poller_t *poller, uint64_t now_us)
{
    gateway_count(poller->counters, GATEWAY_COUNT_POLLS_TORN);
    poller->torn++;
    if (poller->torn < GATEWAY_MAX_TORN) {
        begin_poll(poller, now_us);
    } else {
        poller->torn = 0;
        rest(poller, poller->next_us);
    }
}

static gateway_mark_t mark_read(const gateway_poller_t *poller)
{
    gateway_mark_t mark = {.refusal = poller->client.abort};
    if (poller->client.result == TUMBLE_OK) {
        const uint8_t *const bytes = tumble_sdo_client_data(&poller->client, &mark.size);
        mark.size = (mark.size <= GATEWAY_MARK_BYTES) ? mark.size : (uint8_t)GATEWAY_MARK_BYTES;
        memcpy(mark.bytes, bytes, mark.size);
    }
    return mark;
}

static bool is_same(const gateway_mark_t *a, const gateway_mark_t *b)
{
    return a->refusal == b->refusal && a->size == b->size && memcmp(a->bytes, b->bytes, a->size) == 0;
}

static bool is_of_one_object(const gateway_value_t *a, const gateway_value_t *b)
{
    return a->index == b->index && a->subindex == b->subindex;
}

static bool marks_are_as_published(const gateway_poller_t *poller)
{
    bool same = true;
    for (size_t i = 0; i < GATEWAY_MARKS; i++) {
        same = same && is_same(&poller->marks[i], &poller->published_marks[i]);
    }
    return same;
}

static void keep(gateway_poller_t *poller, const gateway_value_t *value)
{
    const uint16_t valid = (uint16_t)(poller->published.words[value->validity] & 1U << value->bit);
    uint16_t *const validity = &poller->building.words[value->validity];
    *validity = (uint16_t)(*validity | valid);
    memcpy(&poller->building.words[value->at], &poller->published.words[value->at],
           value->words * sizeof poller->building.words[0]);
}

/* On to the next value that is to be read, or past all. */
static void skip_kept(gateway_poller_t *poller)
{
    while (!poller->is_fresh && poller->place < GATEWAY_VALUES && gateway_values[poller->place].kept) {
        keep(poller, &gateway_values[poller->place]);
        poller->place++;
    }
    if (poller->place == GATEWAY_VALUES) {
        poller->phase = PHASE_AFTER;
        poller->place = 0;
    }
}

static void begin_values(gateway_poller_t *poller)
{
    poller->is_fresh =
        poller->must_be_fresh || poller->kept >= GATEWAY_KEPT_POLLS || !marks_are_as_published(poller);
    poller->must_be_fresh = poller->is_fresh; /* until it is published */
    poller->phase = PHASE_VALUES;
    poller->place = 0;
    skip_kept(poller);
}

/* One object has been read, or refused: into all the registers that are its. */
static void take_value(gateway_poller_t *poller)
{
    const gateway_value_t *const first = &gateway_values[poller->place];
    uint8_t size;
    const uint8_t *const bytes = tumble_sdo_client_data(&poller->client, &size);
    if (poller->client.result != TUMBLE_OK) {
        gateway_count(poller->counters, GATEWAY_COUNT_VALUES_REFUSED);
        poller->is_partial = poller->is_partial || poller->client.abort == (uint32_t)TUMBLE_ABORT_DEVICE_STATE;
    }
    while (poller->place < GATEWAY_VALUES && is_of_one_object(first, &gateway_values[poller->place])) {
        if (poller->client.result == TUMBLE_OK) {
            (void)gateway_image_put(poller->building.words, &gateway_values[poller->place], bytes, size);
        }
        poller->place++;
    }
}

/* Of the transfer, not of the object: somebody else on the bus uses the same SDO channel. */
static bool is_disturbed(const gateway_poller_t *poller)
{
    return poller->client.result == TUMBLE_E_SDO_ABORTED && (poller->client.abort >> 24) == PROTOCOL_ERRORS;
}

static void take_read(gateway_poller_t *poller, uint64_t now_us)
{
    if (is_disturbed(poller)) {
        note_torn(poller, now_us);
        return;
    }
    if (poller->phase == PHASE_VALUES) {
        take_value(poller);
        skip_kept(poller);
        return;
    }
    const gateway_mark_t mark = mark_read(poller);
    const bool is_other = poller->phase == PHASE_AFTER && !is_same(&mark, &poller->marks[poller->place]);
    if (is_other || poller->has_booted) {
        note_torn(poller, now_us);
        return;
    }
    poller->marks[poller->place++] = mark;
    if (poller->place == GATEWAY_MARKS && poller->phase == PHASE_BEFORE) {
        begin_values(poller);
    } else if (poller->place == GATEWAY_MARKS) {
        publish(poller, now_us);
    }
}

/* Commands. */

static void end_command(gateway_poller_t *poller, gateway_result_t result, int counter)
{
    gateway_command_t *const owner = poller->queue[0].owner;
    gateway_count(poller->counters, counter);
    if (owner != NULL) {
        owner->result = (uint8_t)result;
        owner->abort = (result == GATEWAY_RESULT_REFUSED) ? poller->client.abort : 0U;
    }
    poller->queued--;
    memmove(&poller->queue[0], &poller->queue[1], poller->queued * sizeof poller->queue[0]);
}

static void take_written(gateway_poller_t *poller, uint64_t now_us)
{
    if (poller->client.result != TUMBLE_OK) {
        end_command(poller, GATEWAY_RESULT_REFUSED, GATEWAY_COUNT_COMMANDS_REFUSED);
    } else if (poller->doing == DOING_COMMAND) {
        end_command(poller, GATEWAY_RESULT_ACCEPTED, GATEWAY_COUNT_COMMANDS_SENT);
        poller->next_us = now_us; /* what it has changed is wanted soon */
    }
}

bool gateway_poller_command(gateway_poller_t *poller, gateway_command_t *command)
{
    if (poller->queued == GATEWAY_MAX_SESSIONS) {
        return false;
    }
    command->result = (uint8_t)GATEWAY_RESULT_PENDING;
    command->abort = 0;
    poller->queue[poller->queued++] = (gateway_queued_t){*command, command};
    return true;
}

void gateway_poller_forget(gateway_poller_t *poller, const gateway_command_t *command)
{
    for (uint16_t i = 0; i < poller->queued; i++) {
        if (poller->queue[i].owner == command) {
            poller->queue[i].owner = NULL;
        }
    }
}

static bool is_sending(const gateway_poller_t *poller)
{
    return poller->doing >= DOING_ARGUMENT;
}

/* Transfers. */

static void begin_read(gateway_poller_t *poller)
{
    uint16_t index;
    uint8_t subindex;
    if (poller->phase == PHASE_VALUES) {
        index = gateway_values[poller->place].index;
        subindex = gateway_values[poller->place].subindex;
    } else {
        index = gateway_marks[poller->place].index;
        subindex = gateway_marks[poller->place].subindex;
    }
    (void)tumble_sdo_client_read_into(&poller->client, poller->node, index, subindex, poller->bytes,
                                      (uint8_t)sizeof poller->bytes);
    poller->doing = DOING_READ;
}

/* The next part of the first command; `before` is the one that has been written, if any. */
static void begin_write(gateway_poller_t *poller, uint8_t before)
{
    const gateway_command_t *const command = &poller->queue[0].command;
    if (before != DOING_ARGUMENT && before != DOING_ANGLE) {
        (void)tumble_sdo_client_write(&poller->client, poller->node, command->index, COMMAND_ARGUMENT,
                                      command->argument, 1);
        poller->doing = DOING_ARGUMENT;
    } else if (before == DOING_ARGUMENT && command->has_angle) {
        tumble_put_f64(poller->bytes, command->angle_deg);
        (void)tumble_sdo_client_write_from(&poller->client, poller->node, command->index, COMMAND_ANGLE, poller->bytes,
                                           (uint8_t)sizeof(double));
        poller->doing = DOING_ANGLE;
    } else {
        (void)tumble_sdo_client_write(&poller->client, poller->node, command->index, COMMAND_COMMAND,
                                      command->command, 1);
        poller->doing = DOING_COMMAND;
    }
}

/* `before` is what the last transfer was for, if it went well. False: nothing is due. */
static bool begin_transfer(gateway_poller_t *poller, uint8_t before, uint64_t now_us)
{
    if (poller->queued > 0U) {
        begin_write(poller, before);
        return true;
    }
    if (poller->phase == PHASE_REST && now_us >= poller->next_us) {
        begin_poll(poller, now_us);
    }
    if (poller->phase != PHASE_REST) {
        begin_read(poller);
    }
    return poller->phase != PHASE_REST;
}

static void take_silence(gateway_poller_t *poller, uint64_t now_us)
{
    const bool is_down = poller->link.last == TUMBLE_E_PORT_DOWN;
    poller->must_be_fresh = true;
    poller->link_state = (uint8_t)(is_down ? GATEWAY_LINK_DOWN : GATEWAY_LINK_SILENT);
    if (is_sending(poller)) {
        end_command(poller, GATEWAY_RESULT_UNANSWERED, GATEWAY_COUNT_COMMANDS_UNANSWERED);
    }
    if (poller->phase != PHASE_REST) {
        gateway_count(poller->counters, GATEWAY_COUNT_POLLS_FAILED);
        rest(poller, now_us + poller->period_us);
    }
}

static void take_end(gateway_poller_t *poller, uint64_t now_us)
{
    if (poller->client.result == TUMBLE_E_SDO_TIMEOUT) {
        take_silence(poller, now_us);
        return;
    }
    poller->link_state = (uint8_t)GATEWAY_LINK_UP;
    if (poller->doing == DOING_READ) {
        take_read(poller, now_us);
    } else {
        take_written(poller, now_us);
    }
}

/* On to the next transfer if none is under way. False: nothing is to be done now. */
static bool advance(gateway_poller_t *poller, uint64_t now_us)
{
    if (tumble_sdo_client_result(&poller->client) == TUMBLE_E_SDO_BUSY) {
        return false;
    }
    const uint8_t before = poller->doing;
    const bool in_order = poller->client.result == TUMBLE_OK;
    if (before != DOING_NOTHING) {
        take_end(poller, now_us);
    }
    poller->doing = DOING_NOTHING;
    return begin_transfer(poller, in_order ? before : (uint8_t)DOING_NOTHING, now_us);
}

/* A boot-up message: what it knows may be something else now. */
static void take_frame(gateway_poller_t *poller, const tumble_can_frame_t *frame)
{
    if (frame->id == BOOT_UP_ID + poller->node && frame->length == 1U && frame->data[0] == 0U) {
        poller->has_booted = true;
    }
    tumble_sdo_client_receive(&poller->client, frame);
}

void gateway_poller_step(gateway_poller_t *poller)
{
    const tumble_port_t *const port = poller->link.port;
    tumble_can_frame_t frame;
    tumble_status_t status;
    uint64_t now_us;
    do {
        now_us = port->now_us(port->context);
        do {
            status = tumble_link_receive(&poller->link, &frame);
            if (status == TUMBLE_OK) {
                take_frame(poller, &frame);
            }
        } while (status == TUMBLE_OK || status == TUMBLE_E_FRAME);
        tumble_sdo_client_step(&poller->client, &poller->link, now_us);
    } while (advance(poller, now_us));
}

#define RETRY_US 5000U /* of a frame that the port had no room for */

uint64_t gateway_poller_next_us(const gateway_poller_t *poller)
{
    const tumble_port_t *const port = poller->link.port;
    if (poller->client.request_due) {
        return port->now_us(port->context) + RETRY_US;
    }
    if (poller->doing != DOING_NOTHING) {
        return tumble_sdo_client_next_us(&poller->client);
    }
    return (poller->queued > 0U) ? 0U : poller->next_us;
}
