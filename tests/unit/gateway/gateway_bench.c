#include "gateway_bench.h"

bench_t bench;

void bench_tear_down(void)
{
    TEST_ASSERT_FALSE(bench.fake.overflowed);
}

void give(uint16_t index, uint8_t subindex, uint8_t size, uint64_t bits)
{
    uint8_t bytes[8];
    tumble_put_u64(bytes, bits);
    played_sdo_give(&bench.sdo, index, subindex, bytes, size);
}

void give_f64(uint16_t index, uint8_t subindex, double number)
{
    uint8_t bytes[8];
    tumble_put_f64(bytes, number);
    give(index, subindex, 8, tumble_get_u64(bytes));
}

static void send(const tumble_can_frame_t *frame)
{
    fake_port_give(&bench.fake, frame);
}

static uint32_t may_read(uint16_t index, uint8_t subindex)
{
    const bool is_k = index == 0x2020U && subindex == 1U;
    if (index == 0x1201U) {
        bench.looks++;
        return bench.sdo.has_one_server ? 0x06020000U : 0U;
    }
    bench.reads++;
    if (bench.event_at > 0U && --bench.event_at == 0U) {
        bench.event();
    }
    if (bench.tear_at > 0U && --bench.tear_at == 0U) {
        bench.k_xx += 1.0;
    }
    if (is_k && bench.k_xx > 0.0) {
        give_f64(index, subindex, bench.k_xx);
    }
    if (is_k && bench.busy_at > 0U && --bench.busy_at == 0U) {
        return BUSY_NOW;
    }
    const uint32_t refusal = bench.abort_next;
    bench.abort_next = 0;
    return refusal;
}

played_object_t *last_write(void)
{
    return &bench.writes[(bench.written + COUNT_OF(bench.writes) - 1U) % COUNT_OF(bench.writes)];
}

static uint32_t may_write(uint16_t index, uint8_t subindex)
{
    bench.written++;
    *last_write() = (played_object_t){.index = index, .subindex = subindex};
    return bench.refuse;
}

static bool on_write(void)
{
    *last_write() = bench.sdo.written;
    if (bench.on_write != NULL) {
        bench.on_write();
    }
    return true;
}

void bench_set_up(void)
{
    bench = (bench_t){
        .sdo = {.node = NODE, .send = send, .may_read = may_read, .may_write = may_write, .on_write = on_write}};
    give(0x1201, 1, 4, TUMBLE_SDO_SECOND_REQUEST_ID + NODE);
    give(0x2000, 0, 1, 5);
    fake_port_init(&bench.fake);
    bench.gateway.settings = (gateway_settings_t){.allow_commands = true, .unlock_us = UINT64_C(1000000000)};
    gateway_poller_init(&bench.gateway.poller, &bench.fake.port, NODE, PERIOD_US, bench.gateway.counters);
}

bool serve(void)
{
    tumble_can_frame_t frame;
    if (!fake_port_take(&bench.fake, &frame)) {
        return false;
    }
    TEST_ASSERT_TRUE(played_sdo_receive(&bench.sdo, &frame));
    return true;
}

void exchange(unsigned times)
{
    for (unsigned i = 0; i < times; i++) {
        gateway_poller_step(&bench.gateway.poller);
        (void)serve();
    }
}

void settle(void)
{
    int steps = 0;
    do {
        gateway_poller_step(&bench.gateway.poller);
        TEST_ASSERT_LESS_THAN_INT(STEPS_OF_A_POLL, ++steps);
    } while (serve());
}

void until_there_is_a_snapshot(void)
{
    while (bench.gateway.poller.published.number == 0U) {
        exchange(1);
    }
}

void unlock(gateway_session_t *session)
{
    const uint16_t keys[2] = {GATEWAY_KEY_1, GATEWAY_KEY_2};
    TEST_ASSERT_EQUAL(GATEWAY_OK, gateway_session_write(session, &bench.gateway, 0, 2, keys, bench.fake.now_us));
}

void carry_out(gateway_command_t *command)
{
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, command));
    settle();
}

void pass(uint64_t us)
{
    const uint64_t end_us = bench.fake.now_us + us;
    settle();
    while (gateway_poller_next_us(&bench.gateway.poller) <= end_us) {
        const uint64_t next_us = gateway_poller_next_us(&bench.gateway.poller);
        bench.fake.now_us = (next_us > bench.fake.now_us) ? next_us : bench.fake.now_us;
        settle();
    }
    bench.fake.now_us = end_us;
}

uint32_t count(int which)
{
    return bench.gateway.counters[which];
}
