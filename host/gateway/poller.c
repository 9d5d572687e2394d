#include "poller.h"

#include "core/bytes.h"

#include <string.h>

enum { PHASE_REST = 0, PHASE_BEFORE, PHASE_VALUES, PHASE_AFTER, PHASE_SELECTORS };
enum { DOING_NOTHING = 0, DOING_READ, DOING_WRITE, DOING_LOOK };

#define BOOT_UP_ID 0x700U
#define SECOND_SERVER 0x1201U
#define REQUESTS 1U           /* its subindex: their identifier */
#define PROTOCOL_ERRORS 0x05U /* first byte of their abort codes */

void gateway_poller_init(gateway_poller_t *poller, const tumble_port_t *port, uint8_t node, uint64_t period_us,
                         uint32_t *counters)
{
    *poller = (gateway_poller_t){.counters = counters, .period_us = period_us, .node = node};
    tumble_link_init(&poller->link, port);
    tumble_sdo_client_init(&poller->client);
    poller->client.below = TUMBLE_SDO_TO_SECOND;
    poller->next_us = port->now_us(port->context);
    poller->must_be_fresh = true;
}

/* Which of the node's SDO servers. */

/* The one that is used did not answer. */
static void change_server(gateway_poller_t *poller)
{
    poller->has_looked = false;
    poller->client.below = (poller->client.below == TUMBLE_SDO_TO_FIRST) ? TUMBLE_SDO_TO_SECOND : TUMBLE_SDO_TO_FIRST;
}

/* The first one has answered. True: a read has begun that asks it for a second. */
static bool look_for_second(gateway_poller_t *poller)
{
    const bool looks = poller->client.below == TUMBLE_SDO_TO_FIRST && !poller->has_looked;
    if (looks) {
        poller->has_looked = true;
        (void)tumble_sdo_client_read(&poller->client, poller->node, SECOND_SERVER, REQUESTS);
    }
    return looks;
}

/* Of a server that is not there the identifier is marked as invalid. */
static void take_second(gateway_poller_t *poller)
{
    if (tumble_sdo_client_u32(&poller->client) == TUMBLE_SDO_SECOND_REQUEST_ID + poller->client.node) {
        poller->client.below = TUMBLE_SDO_TO_SECOND;
    }
}

/* The last transfer was aborted for its own sake, not that of the object: somebody else uses the same server. */
static bool is_disturbed(const gateway_poller_t *poller)
{
    return poller->client.result == TUMBLE_E_SDO_ABORTED && (poller->client.abort >> 24) == PROTOCOL_ERRORS;
}

/* A poll. */

static void rest(gateway_poller_t *poller, uint64_t next_us)
{
    poller->phase = PHASE_REST;
    poller->place = 0;
    poller->begun_anew = 0;
    poller->next_us = next_us;
}

static void begin_poll(gateway_poller_t *poller, uint64_t now_us)
{
    poller->building = (gateway_snapshot_t){.ended = poller->queue.ended};
    poller->must_be_fresh = poller->must_be_fresh || poller->has_booted;
    poller->has_booted = false;
    poller->is_partial = false;
    poller->stale |= poller->written;
    poller->written = 0;
    poller->phase = PHASE_BEFORE;
    poller->place = 0;
    poller->next_us = now_us + poller->period_us;
}

static void publish(gateway_poller_t *poller, uint64_t now_us)
{
    const uint32_t number = poller->published.number + 1U;
    tumble_count(&poller->counters[GATEWAY_COUNT_POLLS]);
    poller->building.number = (number != 0U) ? number : 1U;
    poller->building.taken_us = now_us;
    poller->published = poller->building;
    memcpy(poller->published_marks, poller->marks, sizeof poller->marks);
    poller->stale = 0;
    poller->must_be_fresh = poller->is_partial || (poller->must_be_fresh && !poller->is_fresh);
    poller->kept = poller->is_fresh ? 0U : (uint16_t)(poller->kept + 1U);
    poller->torn = 0;
    rest(poller, poller->next_us);
}

static void note_torn(gateway_poller_t *poller, uint64_t now_us)
{
    tumble_count(&poller->counters[GATEWAY_COUNT_POLLS_TORN]);
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

static bool marks_are_as_published(const gateway_poller_t *poller)
{
    bool same = true;
    for (size_t i = 0; i < GATEWAY_MARKS; i++) {
        same = same && is_same(&poller->marks[i], &poller->published_marks[i]);
    }
    return same;
}

static void keep_words(gateway_poller_t *poller, uint16_t at, uint8_t words, uint16_t validity, uint8_t bit)
{
    const uint16_t *const from = poller->published.words;
    uint16_t *const to = poller->building.words;
    to[validity] |= (uint16_t)(from[validity] & 1U << bit);
    memcpy(&to[at], &from[at], words * sizeof from[0]);
}

static void keep(gateway_poller_t *poller, const gateway_value_t *value)
{
    keep_words(poller, value->at, gateway_words_of(value), value->validity, value->bit);
    if (value->scaled_at > 0U) {
        keep_words(poller, value->scaled_at, 2, value->scaled_validity, value->bit);
    }
}

static bool is_due(const gateway_poller_t *poller, const gateway_value_t *value)
{
    const bool is_always = value->group == GATEWAY_GROUP_ALWAYS || value->key < GATEWAY_KEYS;
    return is_always || (poller->dirty & 1U << value->group) != 0U;
}

/* On to the next value that is to be read, or past all. */
static void skip_kept(gateway_poller_t *poller)
{
    for (; poller->place < GATEWAY_VALUES; poller->place++) {
        const gateway_value_t value = gateway_value(poller->place);
        if (is_due(poller, &value)) {
            return;
        }
        keep(poller, &value);
    }
    poller->phase = PHASE_AFTER;
    poller->place = 0;
}

static void begin_values(gateway_poller_t *poller)
{
    poller->is_fresh = poller->must_be_fresh || poller->kept >= GATEWAY_KEPT_POLLS || !marks_are_as_published(poller);
    poller->must_be_fresh = poller->is_fresh; /* until it is published */
    poller->dirty = poller->is_fresh ? UINT32_MAX : poller->stale;
    poller->phase = PHASE_VALUES;
    poller->place = 0;
    skip_kept(poller);
}

/* Another than that of the last snapshot: its group is read anew, which is behind it. */
static void take_key(gateway_poller_t *poller, const gateway_value_t *value)
{
    const size_t at = GATEWAY_MARKS + (size_t)value->key;
    poller->marks[at] = mark_read(poller);
    if (!is_same(&poller->marks[at], &poller->published_marks[at])) {
        poller->dirty |= 1U << value->group;
    }
}

/* One object has been read, or refused: into all the registers that are its. */
static void take_value(gateway_poller_t *poller)
{
    const gateway_value_t value = gateway_value(poller->place);
    uint8_t size;
    const uint8_t *const bytes = tumble_sdo_client_data(&poller->client, &size);
    if (value.key < GATEWAY_KEYS) {
        take_key(poller, &value);
    }
    if (poller->client.result == TUMBLE_OK) {
        gateway_image_put(poller->building.words, &value, bytes, size);
    } else {
        tumble_count(&poller->counters[GATEWAY_COUNT_VALUES_REFUSED]);
        poller->is_partial = poller->is_partial || poller->client.abort == (uint32_t)TUMBLE_ABORT_DEVICE_STATE;
    }
    poller->place++;
}

/* Of the mark, or the selector, that the phase is at: its place among gateway_tells. */
static size_t mark_at(const gateway_poller_t *poller)
{
    return (poller->phase == PHASE_SELECTORS) ? GATEWAY_MARKS + (size_t)gateway_selectors[poller->place]
                                              : poller->place;
}

/* On to the selector of a group that was read anew; past all the poll is done. */
static void go_on_with_selectors(gateway_poller_t *poller, uint64_t now_us)
{
    while (poller->place < GATEWAY_GROUPS &&
           (gateway_selectors[poller->place] == GATEWAY_KEYS || (poller->dirty & 1U << poller->place) == 0U)) {
        poller->place++;
    }
    if (poller->place == GATEWAY_GROUPS) {
        publish(poller, now_us);
    }
}

static void go_on_with_marks(gateway_poller_t *poller, uint64_t now_us)
{
    poller->place++;
    if (poller->phase == PHASE_SELECTORS) {
        go_on_with_selectors(poller, now_us);
    } else if (poller->place == GATEWAY_MARKS && poller->phase == PHASE_BEFORE) {
        begin_values(poller);
    } else if (poller->place == GATEWAY_MARKS) {
        poller->phase = PHASE_SELECTORS;
        poller->place = 0;
        go_on_with_selectors(poller, now_us);
    }
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
    const bool is_other = poller->phase != PHASE_BEFORE && !is_same(&mark, &poller->marks[mark_at(poller)]);
    if (is_other || poller->has_booted) {
        note_torn(poller, now_us);
        return;
    }
    if (poller->phase == PHASE_BEFORE) {
        poller->marks[mark_at(poller)] = mark;
    }
    go_on_with_marks(poller, now_us);
}

/* Commands. */

static void end_command(gateway_poller_t *poller, gateway_result_t result, int counter)
{
    tumble_count(&poller->counters[counter]);
    gateway_queue_end(&poller->queue, result, (result == GATEWAY_RESULT_REFUSED) ? poller->client.abort : 0U);
    poller->part = 0;
}

/* What it has changed is wanted soon, and in no mixture with what was read before. */
static void note_sent(gateway_poller_t *poller, uint32_t group, uint64_t now_us)
{
    poller->written |= 1U << group;
    poller->next_us = now_us;
    if (poller->phase != PHASE_REST && poller->begun_anew < GATEWAY_MAX_ANEW) {
        poller->begun_anew++;
        begin_poll(poller, now_us);
    }
}

static void take_written(gateway_poller_t *poller, uint64_t now_us)
{
    const gateway_command_t command = poller->queue.items[0].command;
    poller->part++;
    if (poller->client.result != TUMBLE_OK) {
        poller->written |= is_disturbed(poller) ? 1U << command.group : 0U; /* the node may have taken it */
        end_command(poller, GATEWAY_RESULT_REFUSED, GATEWAY_COUNT_COMMANDS_REFUSED);
    } else if (poller->part == command.count) {
        end_command(poller, GATEWAY_RESULT_ACCEPTED, GATEWAY_COUNT_COMMANDS_SENT);
        note_sent(poller, command.group, now_us);
    }
}

/* Transfers. */

static void read_object(gateway_poller_t *poller, uint16_t index, uint8_t subindex)
{
    (void)tumble_sdo_client_read_into(&poller->client, poller->node, index, subindex, poller->bytes,
                                      (uint8_t)sizeof poller->bytes);
    poller->doing = DOING_READ;
}

static void begin_read(gateway_poller_t *poller)
{
    if (poller->phase == PHASE_VALUES) {
        const gateway_value_t value = gateway_value(poller->place);
        read_object(poller, value.index, value.subindex);
    } else {
        const gateway_object_t *const one = &gateway_tells[mark_at(poller)];
        read_object(poller, one->index, one->subindex);
    }
}

/* The next part of the first command; its bytes stay where they are until it has ended. */
static void begin_write(gateway_poller_t *poller)
{
    const gateway_write_t *const one = &poller->queue.items[0].command.writes[poller->part];
    (void)tumble_sdo_client_write_from(&poller->client, poller->node, one->index, one->subindex, one->bytes, one->size);
    poller->doing = DOING_WRITE;
}

/* After a command a read of the poll that is due comes first, however many commands wait. */
static bool is_reads_turn(const gateway_poller_t *poller, uint8_t done, uint64_t now_us)
{
    const bool is_due = poller->phase != PHASE_REST || now_us >= poller->next_us;
    return done == DOING_WRITE && poller->part == 0U && poller->link_state == GATEWAY_LINK_UP && is_due;
}

/* `done`: what the last transfer was for. False: nothing is due. */
static bool begin_transfer(gateway_poller_t *poller, uint8_t done, uint64_t now_us)
{
    if (poller->link_state == GATEWAY_LINK_UP && poller->part == 0U && look_for_second(poller)) {
        poller->doing = DOING_LOOK;
        return true;
    }
    gateway_queue_end_service(&poller->queue);
    if (poller->queue.count > 0U && !is_reads_turn(poller, done, now_us)) {
        begin_write(poller);
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
    if (poller->doing == DOING_WRITE) {
        end_command(poller, GATEWAY_RESULT_UNANSWERED, GATEWAY_COUNT_COMMANDS_UNANSWERED);
    }
    change_server(poller);
    if (poller->phase != PHASE_REST) {
        tumble_count(&poller->counters[GATEWAY_COUNT_POLLS_FAILED]);
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
    } else if (poller->doing == DOING_WRITE) {
        take_written(poller, now_us);
    } else {
        take_second(poller);
    }
}

/* On to the next transfer if none is under way. False: nothing is to be done now. */
static bool advance(gateway_poller_t *poller, uint64_t now_us)
{
    if (tumble_sdo_client_result(&poller->client) == TUMBLE_E_SDO_BUSY) {
        return false;
    }
    const uint8_t done = poller->doing;
    if (done != DOING_NOTHING) {
        take_end(poller, now_us);
    }
    poller->doing = DOING_NOTHING;
    return begin_transfer(poller, done, now_us);
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
    return (poller->queue.count > 0U || poller->queue.ends_service) ? 0U : poller->next_us;
}
