/* A run with two clients of the navigation computer at the same time, on a bus that has the time of every bit: the
 * gateway's poller at its fastest, and a script that reads 20 times a second. Neither loses a read.
 *
 * TWO_CLIENTS_READS sets how many reads the script makes (docs/gateway.md has the figures of 10,000).
 */
#include "poller.h"
#include "sim_bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NODE 1U
#define USUAL_READS 300U
#define MOST_READS 20000U
#define POLL_US 50000U /* the least that tumble-gateway takes */
#define READ_US 50000U
#define NO_DATA 0x08000024U
#define NAME "Tumble navigation computer"
#define INBOX 64U

/* One guest on the simulated bus. */
typedef struct {
    tumble_port_t port;
    uint8_t number;
    tumble_can_frame_t inbox[INBOX];
    unsigned put;
    unsigned taken;
} guest_t;

typedef struct {
    guest_t guest;
    tumble_link_t link;
    tumble_sdo_client_t client;
    uint64_t due_us;
    uint64_t begun_us;
    uint32_t reads; /* begun */
    uint32_t lost;  /* not answered, or by something else */
    uint32_t starts;
    uint32_t longest_us[MOST_READS]; /* how long each took */
    uint32_t done;
    uint8_t text[TUMBLE_MAX_OBJECT_BYTES];
    uint8_t step; /* of a command: 0 none, 1 argument, 2 command */
    bool busy;
} script_t;

static script_t script;
static guest_t gateway;
static gateway_poller_t poller;
static uint32_t counters[GATEWAY_COUNTERS];

static uint64_t now_us(void *context)
{
    (void)context;
    return world.clock.now_us;
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    return sim_bus_send(&world.bus, ((guest_t *)context)->number, frame);
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    guest_t *guest = context;
    if (guest->taken == guest->put) {
        return TUMBLE_E_PORT_EMPTY;
    }
    *frame = guest->inbox[guest->taken++ % INBOX];
    return TUMBLE_OK;
}

static void join(guest_t *guest, uint8_t number)
{
    *guest = (guest_t){.number = (uint8_t)(BENCH_BUS_GUEST + number)};
    guest->port = (tumble_port_t){.context = guest, .now_us = now_us, .can_send = can_send, .can_receive = can_receive};
}

static void hear(guest_t *guest, uint8_t sender, const tumble_can_frame_t *frame)
{
    if (sender != guest->number) {
        TEST_ASSERT_TRUE(guest->put - guest->taken < INBOX);
        guest->inbox[guest->put++ % INBOX] = *frame;
    }
}

static void on_frame(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    (void)context;
    (void)time_us;
    hear(&gateway, sender, frame);
    hear(&script.guest, sender, frame);
}

/* The script: it reads, whatever the state, and starts another run when there is none. */

static const struct {
    uint16_t index;
    uint8_t subindex;
} wanted[] = {{0x2000, 0}, {0x2003, 7}, {0x2010, 1}, {0x1008, 0}, {0x2034, 9}, {0x2020, 5}, {0x2007, 0}};

static bool is_text(void)
{
    return wanted[(script.reads - 1U) % COUNT_OF(wanted)].index == 0x1008U;
}

static void take_answer(void)
{
    const bool none = script.client.result == TUMBLE_E_SDO_ABORTED && script.client.abort == NO_DATA;
    const bool right =
        !is_text() || (script.client.done == strlen(NAME) && memcmp(script.text, NAME, strlen(NAME)) == 0);
    script.lost += (none || (script.client.result == TUMBLE_OK && right)) ? 0U : 1U;
    script.longest_us[script.done++] = (uint32_t)(world.clock.now_us - script.begun_us);
}

static bool must_start(void)
{
    return world.progress.state == TUMBLE_STATE_IDLE || world.progress.state == TUMBLE_STATE_DONE;
}

static void begin(void)
{
    script.begun_us = world.clock.now_us;
    script.busy = true;
    if (script.step == 2U || (script.step == 0U && must_start())) {
        script.step = (script.step == 2U) ? 3U : 1U;
        const uint32_t value = (script.step == 1U) ? 0U : (uint32_t)TUMBLE_COMMAND_START;
        (void)tumble_sdo_client_write(&script.client, NODE, 0x2002, (script.step == 1U) ? 1U : 2U, value, 1);
        return;
    }
    const unsigned next = script.reads % COUNT_OF(wanted);
    script.reads++;
    script.due_us += READ_US;
    (void)tumble_sdo_client_read_into(&script.client, NODE, wanted[next].index, wanted[next].subindex, script.text,
                                      sizeof script.text);
}

static void end(void)
{
    script.busy = false;
    if (script.step == 1U || script.step == 3U) {
        script.lost += (script.client.result == TUMBLE_OK) ? 0U : 1U;
        script.starts += (script.step == 3U) ? 1U : 0U;
        script.step = (script.step == 1U) ? 2U : 4U;
    } else {
        take_answer();
        script.step = (script.step == 4U && must_start()) ? 4U : 0U; /* it has not begun yet */
    }
}

static void step_script(void)
{
    tumble_can_frame_t frame;
    while (tumble_link_receive(&script.link, &frame) == TUMBLE_OK) {
        tumble_sdo_client_receive(&script.client, &frame);
    }
    tumble_sdo_client_step(&script.client, &script.link, world.clock.now_us);
    if (script.busy && tumble_sdo_client_result(&script.client) != TUMBLE_E_SDO_BUSY) {
        end();
    }
    if (!script.busy && (world.clock.now_us >= script.due_us || script.step == 2U)) {
        begin();
        tumble_sdo_client_step(&script.client, &script.link, world.clock.now_us);
    }
}

static uint64_t script_next_us(void)
{
    return script.busy ? tumble_sdo_client_next_us(&script.client) : script.due_us;
}

/* Both until the script has made its reads. */
static void go(uint32_t reads, uint16_t servers)
{
    static const bench_watcher_t watcher = {.on_frame = on_frame};
    TEST_ASSERT_NULL(read_lines("procedure.samples = 20\noperator.mount_s = 1\n"));
    config.starts = false;
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, 7, &watcher));
    memset(&script, 0, sizeof script);
    memset(&counters, 0, sizeof counters);
    join(&gateway, 0);
    join(&script.guest, 1);
    tumble_link_init(&script.link, &script.guest.port);
    tumble_sdo_client_init(&script.client);
    script.due_us = 1000000U; /* the computer is up */
    while (world.clock.now_us < script.due_us) {
        TEST_ASSERT_TRUE(bench_world_advance(&world));
        gateway.taken = gateway.put;
        script.guest.taken = script.guest.put;
    }
    script.due_us = world.clock.now_us;
    gateway_poller_init(&poller, &gateway.port, NODE, POLL_US, counters);
    poller.client.below = servers;
    poller.has_looked = true;
    while (script.done < reads) {
        gateway_poller_step(&poller);
        step_script();
        const uint64_t mine_us = script_next_us();
        const uint64_t its_us = gateway_poller_next_us(&poller);
        const uint64_t next_us = (mine_us < its_us) ? mine_us : its_us;
        if (next_us > world.clock.now_us && next_us < bench_world_next_us(&world)) {
            bench_world_pass(&world, next_us);
        } else {
            TEST_ASSERT_TRUE(bench_world_advance(&world));
        }
    }
}

static int by_size(const void *a, const void *b)
{
    const uint32_t left = *(const uint32_t *)a;
    const uint32_t right = *(const uint32_t *)b;
    return (left > right) - (left < right);
}

static void tell(void)
{
    qsort(script.longest_us, script.done, sizeof script.longest_us[0], by_size);
    printf(
        "two clients: %u reads, %u lost, %u runs begun; 50 %% within %u us, 99 %% %u us, all %u us; %u polls, "
        "%u torn, %u failed, in %.0f s\n",
        script.done, script.lost, script.starts, script.longest_us[script.done / 2U],
        script.longest_us[script.done * 99U / 100U], script.longest_us[script.done - 1U], counters[GATEWAY_COUNT_POLLS],
        counters[GATEWAY_COUNT_POLLS_TORN], counters[GATEWAY_COUNT_POLLS_FAILED], (double)world.clock.now_us * 1e-6);
}

static void test_a_script_beside_the_gateway_loses_no_read(void)
{
    const char *const asked = getenv("TWO_CLIENTS_READS");
    const uint32_t reads = (asked != NULL) ? (uint32_t)strtoul(asked, NULL, 10) : USUAL_READS;
    TEST_ASSERT_TRUE(reads > 0U && reads <= MOST_READS);
    go(reads, TUMBLE_SDO_TO_SECOND);
    tell();
    TEST_ASSERT_EQUAL_UINT32(0, script.lost);
    TEST_ASSERT_EQUAL_UINT32(0, script.client.ignored);
    TEST_ASSERT_EQUAL_UINT32(0, poller.client.ignored);
    TEST_ASSERT_EQUAL_UINT32(0, counters[GATEWAY_COUNT_POLLS_FAILED]);
    TEST_ASSERT_TRUE(script.starts >= 1U && world.progress.reason == TUMBLE_REASON_NONE);
    TEST_ASSERT_TRUE(counters[GATEWAY_COUNT_POLLS_TORN] <= 2U * script.starts); /* by results, not by the script */
    TEST_ASSERT_TRUE(counters[GATEWAY_COUNT_POLLS] > reads / 20U);
}

/* What it is for: with one server for both of them, reads are lost. */
static void test_with_one_server_reads_are_lost(void)
{
    go(USUAL_READS, TUMBLE_SDO_TO_FIRST);
    TEST_ASSERT_TRUE(script.lost > 0U);
}
