/* One of our nodes on stdin and stdout: `canopen_harness drive|block|navcomp|navcomp_without_sets`.
 *
 * Lines in both directions: a CAN frame is ID#BYTES, hexadecimal ("705#00"). The node's clock stands still but for the
 * command that lets time pass, so that nothing depends on the speed of this machine. Further lines in:
 *     !pass MS                         let so many milliseconds pass, from event to event; answers "=passed"
 *     !emcy CODE BITS                  raise an emergency
 *     !clear BITS                      clear it
 *     !trigger N                       send transmit PDO N (0 is the first)
 *     !start N                         NMT start command to node N
 *     !busy N                          the port has no room for the next N frames
 *     !read NODE INDEX SUB CAPACITY    SDO client: read; answers "=STATUS ABORT BYTES"
 *     !write NODE INDEX SUB BYTES      SDO client: write; answers "=STATUS ABORT -"
 * MS, NODE, SUB, N and CAPACITY are decimal, the rest hexadecimal. Ends with its input; exit code 2 for bad usage.
 */
#include "navcomp/keeper.h"
#include "simulation/block_objects.h"
#include "simulation/drive_objects.h"
#include "stand/operator/operator.h"
#include "tumble/core.h"
#include "tumble/navcomp.h"

#include "flash.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    tumble_node_t *node;
    tumble_node_t own; /* drive, block */
    union {
        tumble_drive_objects_t drive;
        tumble_block_objects_t block;
    } variables;
    tumble_navcomp_t navcomp;
    tumble_keeper_t keeper;
    nv_memory_t memory;
    bool is_navcomp;
    uint64_t now_us;
    tumble_can_frame_t inbox[256];
    unsigned received;
    unsigned taken;
    unsigned busy;
    bool reading; /* an SDO transfer of the client is to be reported: a read, */
    bool writing; /* or a write */
    uint8_t data[255];
} harness_t;

static harness_t harness;

static uint64_t now_us(void *context)
{
    (void)context;
    return harness.now_us;
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    (void)context;
    if (harness.busy > 0U) {
        harness.busy--;
        return TUMBLE_E_PORT_BUSY;
    }
    printf("%03X#", frame->id);
    for (uint8_t i = 0; i < frame->length; i++) {
        printf("%02X", frame->data[i]);
    }
    printf("\n");
    return TUMBLE_OK;
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    (void)context;
    if (harness.taken == harness.received) {
        return TUMBLE_E_PORT_EMPTY;
    }
    *frame = harness.inbox[harness.taken % 256U];
    harness.taken++;
    return TUMBLE_OK;
}

static tumble_port_t port = {.now_us = now_us, .can_send = can_send, .can_receive = can_receive};

static void reset(void *context, bool application)
{
    tumble_object_table_t const *table = harness.own.config->table;

    (void)context;
    if (application && (table == &tumble_drive_table)) {
        harness.variables.drive = tumble_drive_objects_initial;
    } else if (application) {
        harness.variables.block = tumble_block_objects_initial;
    }
}

static const tumble_node_events_t events = {.reset = reset};

static bool start_plain(const char *name)
{
    static tumble_node_config_t config = {.events = &events};
    tumble_node_binding_t binding = {.port = &port, .variables = &harness.variables};

    if (strcmp(name, "drive") == 0) {
        harness.variables.drive = tumble_drive_objects_initial;
        config.table = &tumble_drive_table;
        config.defaults = &tumble_drive_defaults;
        config.node = TUMBLE_DRIVE_NODE;
    } else if (strcmp(name, "block") == 0) {
        harness.variables.block = tumble_block_objects_initial;
        config.table = &tumble_block_table;
        config.defaults = &tumble_block_defaults;
        config.node = TUMBLE_BLOCK_NODE;
    } else {
        return false;
    }
    harness.node = &harness.own;
    return tumble_node_init(&harness.own, &config, &binding) == TUMBLE_OK;
}

static void prepare_keeper(void)
{
    static tumble_sets_settings_t settings = {
        .limits = {.coverage = 3.0F}, .pause_s = TUMBLE_SETS_MIN_PAUSE_S, .temperature_samples = 1};
    static const tumble_keeper_config_t config = {.sets = {.serial = "HARNESS", .settings = &settings}};

    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        settings.limits.uncertainty[c] = 1e-3F;
    }
    nv_make(&harness.memory, NV_MAX_SECTORS, 8, TUMBLE_STORE_MIN_SECTOR);
    harness.keeper.config = &config;
}

/* A computer whose operator turns the head by hand: what it does by itself on the bus is little. */
static bool start_navcomp(const char *name)
{
    static const tumble_averaging_config_t averaging = {
        .saturation_counts = 8388607, .min_samples = 2, .max_lost = 2, .stillness_ratio = 5.0F};
    static const tumble_procedure_config_t procedure = {.schedule = &tumble_schedule_paper,
                                                        .averaging = &averaging,
                                                        .samples = 1000,
                                                        .v_per_count = 1e-6,
                                                        .nominal_scale_v_per_g = -2.0,
                                                        .gravity_limit_g = 3e-4,
                                                        .closure_limit_g = 1e-3,
                                                        .position_tolerance_deg = 0.1,
                                                        .cable_min_deg = -20.0,
                                                        .cable_max_deg = 380.0,
                                                        .settle_ms = 500,
                                                        .retries = 1,
                                                        .preflight_timeout_ms = 60000,
                                                        .warm_up_timeout_ms = 60000,
                                                        .mounting_timeout_ms = 60000,
                                                        .home_timeout_ms = 60000,
                                                        .move_timeout_ms = 60000,
                                                        .settle_timeout_ms = 5000,
                                                        .average_timeout_ms = 60000,
                                                        .sample_timeout_ms = 60000};
    static tumble_operator_t head;
    static tumble_second_client_t second_client;
    static const tumble_operator_config_t operator = {.tolerance_deg = 0.1, .timeout_ms = 60000};
    static tumble_navcomp_config_t config = {.port = &port,
                                             .procedure = &procedure,
                                             .stand = &tumble_operator_kind,
                                             .stand_profile = &operator,
                                             .stand_memory = &head,
                                             .stand_bytes = sizeof head,
                                             .second_client = &second_client,
                                             .block_period_us = 1000000,
                                             .heartbeat_ms = 100,
                                             .heartbeat_timeout_ms = 500,
                                             .node = TUMBLE_NAVCOMP_NODE,
                                             .block_node = 3};

    if (strcmp(name, "navcomp") == 0) {
        prepare_keeper();
        port.nv = &harness.memory.nv;
        config.keeping = &tumble_keeper_calls;
        config.keeper = &harness.keeper;
    }
    harness.is_navcomp = (config.keeper != NULL) || (strcmp(name, "navcomp_without_sets") == 0);
    harness.node = &harness.navcomp.node;
    return harness.is_navcomp && (tumble_navcomp_init(&harness.navcomp, &config) == TUMBLE_OK);
}

static uint8_t parse_bytes(const char *text, uint8_t *bytes, size_t most)
{
    uint8_t length = 0;
    unsigned byte;

    while ((length < most) && (sscanf(text + ((size_t)2 * length), "%2x", &byte) == 1)) {
        bytes[length] = (uint8_t)byte;
        length++;
    }
    return length;
}

static void take_frame(const char *line)
{
    tumble_can_frame_t *frame = &harness.inbox[harness.received % 256U];
    const char *bytes = strchr(line, '#');

    if (bytes != NULL) {
        *frame = (tumble_can_frame_t){.id = (uint16_t)strtoul(line, NULL, 16)};
        frame->length = parse_bytes(bytes + 1, frame->data, sizeof frame->data);
        harness.received++;
    }
}

static void start_transfer(const char *line)
{
    unsigned node;
    unsigned index;
    unsigned sub;
    unsigned capacity;
    char text[2 * sizeof harness.data + 1];
    tumble_sdo_client_t *client = &harness.node->client;
    tumble_status_t status = TUMBLE_E_ARGUMENT;

    if (sscanf(line, "!read %u %x %u %u", &node, &index, &sub, &capacity) == 4) {
        status = tumble_sdo_client_read_into(client, (uint8_t)node, (uint16_t)index, (uint8_t)sub, harness.data,
                                             (uint8_t)capacity);
        harness.reading = status == TUMBLE_OK;
    } else if (sscanf(line, "!write %u %x %u %510s", &node, &index, &sub, text) == 4) {
        uint8_t size = parse_bytes(text, harness.data, sizeof harness.data);

        status = tumble_sdo_client_write_from(client, (uint8_t)node, (uint16_t)index, (uint8_t)sub, harness.data, size);
        harness.writing = status == TUMBLE_OK;
    }
    if (status != TUMBLE_OK) {
        printf("=%s 0 -\n", tumble_status_name(status));
    }
}

static void report_transfer(void)
{
    const tumble_sdo_client_t *client = &harness.node->client;
    tumble_status_t status = tumble_sdo_client_result(client);
    uint8_t size;
    const uint8_t *data = tumble_sdo_client_data(client, &size);

    if ((!harness.reading && !harness.writing) || (status == TUMBLE_E_SDO_BUSY)) {
        return;
    }
    printf("=%s %08X -", tumble_status_name(status), (unsigned)client->abort);
    for (uint8_t i = 0; harness.reading && (status == TUMBLE_OK) && (i < size); i++) {
        printf("%02X", data[i]);
    }
    printf("\n");
    harness.reading = false;
    harness.writing = false;
}

static void take_line(const char *line)
{
    unsigned a = 0;
    unsigned b = 0;

    if (line[0] != '!') {
        take_frame(line);
    } else if (sscanf(line, "!emcy %x %x", &a, &b) == 2) {
        tumble_emcy_raise(&harness.node->emcy, (uint16_t)a, (uint8_t)b, (const uint8_t *)"\1\2\3\4\5");
    } else if (sscanf(line, "!clear %x", &a) == 1) {
        tumble_emcy_clear(&harness.node->emcy, (uint8_t)a);
    } else if (sscanf(line, "!trigger %u", &a) == 1) {
        tumble_pdo_trigger(&harness.node->pdos, (uint8_t)a);
    } else if (sscanf(line, "!start %u", &a) == 1) {
        (void)tumble_nmt_command(&harness.node->nmt, (uint8_t)a, TUMBLE_NMT_START);
    } else if (sscanf(line, "!busy %u", &a) == 1) {
        harness.busy = a;
    } else {
        start_transfer(line);
    }
}

/* One step; returns when the next is due. */
static uint64_t step(void)
{
    tumble_can_frame_t frame;
    uint64_t next_us;

    if (harness.is_navcomp) {
        tumble_navcomp_step(&harness.navcomp);
        next_us = tumble_navcomp_next_deadline_us(&harness.navcomp);
    } else {
        while (tumble_link_receive(&harness.own.link, &frame) == TUMBLE_OK) {
            (void)tumble_node_receive(&harness.own, &frame, harness.now_us);
        }
        tumble_node_step(&harness.own, harness.now_us);
        next_us = tumble_node_next_us(&harness.own);
    }
    return next_us;
}

/* Step until nothing more is due now; a node that is never at rest is a fault. Returns when the next step is due. */
static uint64_t settle(void)
{
    uint64_t next_us = step();

    for (int i = 0; next_us <= harness.now_us; i++) {
        if (i == 1000) {
            fprintf(stderr, "canopen_harness: the node does not come to rest\n");
            exit(1);
        }
        next_us = step();
    }
    return next_us;
}

static void pass(uint64_t us)
{
    uint64_t end_us = harness.now_us + us;
    uint64_t next_us = settle();

    while (next_us <= end_us) {
        harness.now_us = next_us;
        next_us = settle();
    }
    harness.now_us = end_us;
    printf("=passed\n");
}

int main(int count, char **arguments)
{
    const char *name = (count == 2) ? arguments[1] : "";
    char line[1024];
    unsigned ms;

    harness.now_us = 1000000;
    if (!start_plain(name) && !start_navcomp(name)) {
        fprintf(stderr, "usage: canopen_harness drive|block|navcomp|navcomp_without_sets\n");
        return 2;
    }
    do {
        (void)settle();
        report_transfer();
        (void)fflush(stdout);
        if (fgets(line, sizeof line, stdin) == NULL) {
            return 0;
        }
        if (sscanf(line, "!pass %u", &ms) == 1) {
            pass((uint64_t)ms * 1000U);
        } else {
            take_line(line);
        }
    } while (true);
}
