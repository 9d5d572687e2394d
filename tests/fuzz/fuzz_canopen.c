/* Fuzzing a node: any frames, moods of the port, uses of the application's side and jumps of the clock, in any order.
 *
 * The first byte of the input chooses the drive's or the block's dictionary, and whether the keeper's stands behind it:
 * there some writes are answered later. Then come records of an opcode byte and
 * its operands. What is checked beside the sanitizers: the invariants in `check`, `check_frame` and `check_rest`.
 */
#include "canopen/node.h"
#include "core/bytes.h"
#include "fuzz_input.h"
#include "navcomp/keeper_objects.h"
#include "simulation/block_objects.h"
#include "simulation/drive_objects.h"

#include <string.h>

const size_t fuzz_header_bytes = 1;
const size_t fuzz_record_bytes = 11; /* an opcode, and a frame with what kind it is */

typedef struct {
    tumble_node_t node;
    union {
        tumble_drive_objects_t drive;
        tumble_block_objects_t block;
    } variables;
    uint64_t now_us;
    unsigned room;    /* frames that the port still takes in this round */
    unsigned answers; /* of the SDO server in this round */
    bool down;
    uint8_t upload[40]; /* the client's memory, with a border behind the part that it may use */
} world_t;

static uint64_t now_us(void *context)
{
    return ((const world_t *)context)->now_us;
}

/* Whatever the node sends is a frame of one of its services. */
static void check_frame(const world_t *world, const tumble_can_frame_t *frame)
{
    const uint8_t node = world->node.config->node;
    const bool sdo = (frame->id == (TUMBLE_SDO_RESPONSE_ID + node)) ||
                     (frame->id == (TUMBLE_SDO_REQUEST_ID + world->node.client.node));
    const bool service = sdo || (frame->id == TUMBLE_NMT_ID) || (frame->id == (TUMBLE_EMCY_ID + node)) ||
                         (frame->id == (TUMBLE_HEARTBEAT_ID + node));
    bool pdo = false;

    for (size_t i = 0; i < TUMBLE_MAX_TRANSMIT_PDOS; i++) {
        pdo = pdo || ((world->node.pdos.transmit[i].pdo.cob_id & TUMBLE_CAN_MAX_ID) == frame->id);
    }
    require(frame->length <= TUMBLE_CAN_MAX_BYTES, "no frame is longer than eight bytes");
    require(service || pdo, "every frame is of one of the node's services");
    require(service || (world->node.nmt.state == (uint8_t)TUMBLE_NMT_OPERATIONAL), "PDOs live in Operational");
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    world_t *world = context;

    if (world->down) {
        return TUMBLE_E_PORT_DOWN;
    }
    if (world->room == 0U) {
        return TUMBLE_E_PORT_BUSY;
    }
    world->room--;
    world->answers += (frame->id == (TUMBLE_SDO_RESPONSE_ID + world->node.config->node)) ? 1U : 0U;
    check_frame(world, frame);
    return TUMBLE_OK;
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    (void)context;
    (void)frame;
    return TUMBLE_E_PORT_EMPTY;
}

/* Refuses at the whim of the value, so that refusals by hooks happen. */
static tumble_abort_t on_write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    (void)context;
    require(size <= entry->size, "no value is longer than its object");
    return ((size > 0U) && (bytes[0] == 0x5AU)) ? TUMBLE_ABORT_DEVICE_STATE : TUMBLE_ABORT_NONE;
}

static tumble_abort_t on_further_write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    require((entry->access & TUMBLE_ACCESS_EXTENSION) != 0U, "the extension's hooks get its own entries");
    return ((size > 0U) && (bytes[0] < 0x20U)) ? TUMBLE_ABORT_LATER : on_write(context, entry, bytes, size);
}

static const tumble_object_hooks_t hooks = {.write = on_write};
static const tumble_object_hooks_t further_hooks = {.write = on_further_write};
static const tumble_node_extension_t further = {.objects = {.table = &tumble_keeper_table, .hooks = &further_hooks}};
static tumble_node_config_t config = {.hooks = &hooks};

/* One of all rows. */
static const tumble_entry_t *row(uint8_t number)
{
    const uint8_t first = config.table->count;
    const uint8_t place = number % (uint8_t)(first + ((config.extension != NULL) ? further.objects.table->count : 0U));

    return (place < first) ? &config.table->entries[place] : &further.objects.table->entries[place - first];
}

static void power_on(world_t *world, const tumble_port_t *port, bool drive, bool extended)
{
    const tumble_node_binding_t binding = {.port = port, .variables = &world->variables, .context = world};

    memset(world, 0, sizeof *world);
    memset(world->upload, 0xA5, sizeof world->upload);
    config.table = drive ? &tumble_drive_table : &tumble_block_table;
    config.defaults = drive ? &tumble_drive_defaults : &tumble_block_defaults;
    config.extension = extended ? &further : NULL;
    config.node = drive ? TUMBLE_DRIVE_NODE : TUMBLE_BLOCK_NODE;
    if (drive) {
        world->variables.drive = tumble_drive_objects_initial;
    } else {
        world->variables.block = tumble_block_objects_initial;
    }
    require(tumble_node_init(&world->node, &config, &binding) == TUMBLE_OK, "the generated tables are usable");
}

/* A frame: mostly on identifiers that mean something, mostly of an object that exists. */
static tumble_can_frame_t frame_of(input_t *input, const world_t *world)
{
    const uint8_t node = world->node.config->node;
    const uint16_t ids[] = {(uint16_t)(TUMBLE_SDO_REQUEST_ID + node), 0x000, 0x582, 0x701, 0x081, 0x202, 0x333,
                            (uint16_t)((take(input) << 3) & 0x7FF)};
    const uint8_t choice = take(input);
    tumble_can_frame_t frame = {.id = ids[choice % 8U], .length = (choice < 240U) ? 8U : (choice % 9U)};

    for (int i = 0; i < TUMBLE_CAN_MAX_BYTES; i++) {
        frame.data[i] = take(input);
    }
    if ((choice & 0x60U) != 0U) {
        const tumble_entry_t *entry = row(frame.data[1]);

        tumble_put_u16(&frame.data[1], entry->index);
        frame.data[3] = entry->subindex;
    }
    if (frame.id == TUMBLE_NMT_ID) {
        frame.length = 2;
        frame.data[1] = node;
    }
    return frame;
}

/* A frame that begins a segmented transfer, or goes on with it, with the right toggle bit: chance alone hardly gets
 * that far. */
static tumble_can_frame_t next_segment(input_t *input, const world_t *world, bool to_client)
{
    const tumble_sdo_client_t *client = &world->node.client;
    const tumble_sdo_server_t *server = &world->node.server;
    const uint8_t choice = take(input);
    const uint8_t toggle = to_client ? client->toggle : server->toggle;
    const bool download = to_client ? (client->transfer == (uint8_t)TUMBLE_SDO_DOWNLOAD)
                                    : (server->transfer == (uint8_t)TUMBLE_SDO_UPLOAD);
    const uint8_t command = to_client ? (download ? 0x20U : 0x00U) : (download ? 0x60U : 0x00U);
    tumble_can_frame_t frame = {.length = 8, .data = {(uint8_t)(command | toggle | (choice & 0x0FU))}};

    frame.id = (uint16_t)(to_client ? (TUMBLE_SDO_RESPONSE_ID + client->node)
                                    : (TUMBLE_SDO_REQUEST_ID + world->node.config->node));
    if (to_client && (client->phase == 0U)) {
        frame.data[0] = download ? 0x60U : (0x40U | (choice & 0x0FU));
        tumble_put_u16(&frame.data[1], client->index);
        frame.data[3] = client->subindex;
        frame.data[4] = take(input);
    } else if (!to_client && (server->transfer == (uint8_t)TUMBLE_SDO_IDLE)) {
        const tumble_entry_t *entry = row(take(input));

        frame.data[0] = ((choice & 1U) != 0U) ? 0x20U : 0x40U;
        tumble_put_u16(&frame.data[1], entry->index);
        frame.data[3] = entry->subindex;
    } else {
        /* a segment */
    }
    return frame;
}

static void use_client(input_t *input, world_t *world)
{
    static const uint8_t data[40] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    const uint8_t size = take(input) % 33U;
    const uint8_t index = take(input);

    switch (take(input) % 4U) {
    case 0:
        (void)tumble_sdo_client_read_into(&world->node.client, 2, index, 0, world->upload, size);
        break;
    case 1:
        (void)tumble_sdo_client_write_from(&world->node.client, 2, index, 0, data, size);
        break;
    case 2:
        (void)tumble_sdo_client_read(&world->node.client, 2, index, 0);
        break;
    default:
        tumble_sdo_client_cancel(&world->node.client);
        break;
    }
}

/* The application's side: an error is over, and so is what a write began. */
static void use_owner(input_t *input, world_t *world)
{
    const uint8_t bits = take(input);

    tumble_emcy_clear(&world->node.emcy, bits);
    tumble_node_answer(&world->node, ((bits & 1U) != 0U) ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_HARDWARE);
}

/* What holds after every round. */
static void check(const world_t *world)
{
    const tumble_node_t *node = &world->node;

    require(node->emcy.queued <= TUMBLE_EMCY_QUEUE, "emergencies queued");
    require(node->emcy.recorded <= TUMBLE_EMCY_HISTORY, "history");
    require(node->nmt.queued <= TUMBLE_NMT_QUEUE, "commands queued");
    require((node->nmt.state == (uint8_t)TUMBLE_NMT_INITIALISING) || (node->nmt.state == (uint8_t)TUMBLE_NMT_STOPPED) ||
                (node->nmt.state == (uint8_t)TUMBLE_NMT_OPERATIONAL) ||
                (node->nmt.state == (uint8_t)TUMBLE_NMT_PRE_OPERATIONAL),
            "NMT state");
    require(node->server.size <= TUMBLE_MAX_OBJECT_BYTES, "the server's transfer fits its memory");
    require(node->server.done <= TUMBLE_MAX_OBJECT_BYTES, "the server's transfer stays in its memory");
    require((node->client.transfer != (uint8_t)TUMBLE_SDO_UPLOAD) || (node->client.done <= node->client.capacity),
            "the client's transfer stays in its memory");
    for (size_t i = 32; i < sizeof world->upload; i++) {
        require(world->upload[i] == 0xA5U, "an upload stays within its capacity");
    }
}

/* With room and time standing still the node comes to rest: nothing is due now. */
static void check_rest(world_t *world)
{
    world->room = 100;
    world->down = false;
    for (int i = 0; i < 3; i++) {
        tumble_node_step(&world->node, world->now_us);
    }
    require(world->room > 60U, "a few steps send a few frames");
    require(tumble_node_next_us(&world->node) > world->now_us, "nothing is due any more");
}

static void give(input_t *input, world_t *world, unsigned kind)
{
    const tumble_can_frame_t frame = (kind == 5U) ? frame_of(input, world) : next_segment(input, world, kind == 6U);

    (void)tumble_node_receive(&world->node, &frame, world->now_us);
}

static void act(input_t *input, world_t *world)
{
    const uint8_t opcode = take(input);

    world->room = (opcode >> 6) & 3U;
    world->down = (opcode & 0x3FU) == 0x3FU;
    world->answers = 0;
    switch (opcode % 8U) {
    case 0:
        world->now_us += (uint64_t)take(input) * 10000U;
        break;
    case 1:
        use_client(input, world);
        break;
    case 2:
        tumble_emcy_raise(&world->node.emcy, take(input), take(input), NULL);
        break;
    case 3:
        use_owner(input, world);
        break;
    case 4:
        tumble_pdo_trigger(&world->node.pdos, take(input) % 4U);
        (void)tumble_nmt_command(&world->node.nmt, take(input), TUMBLE_NMT_START);
        break;
    default:
        give(input, world, opcode % 8U);
        break;
    }
    tumble_node_step(&world->node, world->now_us);
    require(world->answers <= 1U, "one answer to one request");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static world_t world;
    const tumble_port_t port = {.context = &world, .now_us = now_us, .can_send = can_send, .can_receive = can_receive};
    input_t input = {.data = data, .left = size};

    const uint8_t which = take(&input);

    power_on(&world, &port, (which & 1U) != 0U, (which & 2U) != 0U);
    while (input.left > 0U) {
        input_t record = cut(&input, fuzz_record_bytes);
        act(&record, &world);
        check(&world);
    }
    check_rest(&world);
    return 0;
}
