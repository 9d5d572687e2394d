#include "gateway_bench.h"

bench_t bench;

void bench_set_up(void)
{
    bench = (bench_t){0};
    fake_port_init(&bench.fake);
    gateway_poller_init(&bench.poller, &bench.fake.port, NODE, PERIOD_US, &bench.counters);
}

void bench_tear_down(void)
{
    TEST_ASSERT_FALSE(bench.fake.overflowed);
}

static uint16_t response_id(void)
{
    return (uint16_t)((bench.is_second ? TUMBLE_SDO_SECOND_RESPONSE_ID : TUMBLE_SDO_RESPONSE_ID) + NODE);
}

static void answer(uint8_t command, const uint8_t *request, uint32_t value)
{
    tumble_can_frame_t frame = {.id = response_id(), .length = 8};
    frame.data[0] = command;
    memcpy(&frame.data[1], &request[1], 3);
    tumble_put_u32(&frame.data[4], value);
    fake_port_give(&bench.fake, &frame);
}

static bench_object_t *given(uint16_t index, uint8_t subindex)
{
    unsigned i = 0;
    while (i < bench.objects_given && (bench.objects[i].index != index || bench.objects[i].subindex != subindex)) {
        i++;
    }
    return (i < bench.objects_given) ? &bench.objects[i] : NULL;
}

void give(uint16_t index, uint8_t subindex, uint8_t size, uint64_t bits)
{
    bench_object_t *object = given(index, subindex);
    if (object == NULL) {
        TEST_ASSERT_LESS_THAN_UINT(COUNT_OF(bench.objects), bench.objects_given);
        object = &bench.objects[bench.objects_given++];
    }
    *object = (bench_object_t){index, subindex, size, {0}};
    tumble_put_u64(object->bytes, bits);
}

void give_f64(uint16_t index, uint8_t subindex, double number)
{
    uint8_t bytes[8];
    tumble_put_f64(bytes, number);
    give(index, subindex, 8, tumble_get_u64(bytes));
}

static void read_given(const bench_object_t *object, const uint8_t *request)
{
    bench.reads_of[object - bench.objects]++;
    bench.upload = object;
    if (object->size == 0U) {
        answer(TUMBLE_SDO_ABORT, request, NO_DATA);
    } else if (object->size <= 4U) {
        answer(tumble_sdo_expedited(TUMBLE_SDO_UPLOAD_ANSWER, object->size), request, tumble_get_u32(object->bytes));
    } else {
        answer(TUMBLE_SDO_UPLOAD_ANSWER | TUMBLE_SDO_S, request, object->size);
    }
}

static void read(const uint8_t *request)
{
    const uint16_t index = tumble_get_u16(&request[1]);
    const bench_object_t *const object = given(index, request[3]);
    if (index == 0x1201U) {
        bench.looks++;
        answer(bench.has_one_server ? TUMBLE_SDO_ABORT : tumble_sdo_expedited(TUMBLE_SDO_UPLOAD_ANSWER, 4), request,
               bench.has_one_server ? 0x06020000U : TUMBLE_SDO_SECOND_REQUEST_ID + NODE);
        return;
    }
    bench.reads++;
    bench.upload = NULL;
    if (bench.event_at > 0U && --bench.event_at == 0U) {
        bench.event();
    }
    if (bench.tear_at > 0U && --bench.tear_at == 0U) {
        bench.k_xx += 1.0;
    }
    if (index == 0x2020U && request[3] == 1U && bench.busy_at > 0U && --bench.busy_at == 0U) {
        answer(TUMBLE_SDO_ABORT, request, BUSY_NOW);
    } else if (bench.abort_next != 0U) {
        answer(TUMBLE_SDO_ABORT, request, bench.abort_next);
        bench.abort_next = 0;
    } else if (object != NULL) {
        read_given(object, request);
    } else if (index == 0x2020U && request[3] == 1U && bench.k_xx > 0.0) {
        answer(TUMBLE_SDO_UPLOAD_ANSWER | TUMBLE_SDO_S, request, 8);
    } else if (index == 0x2000U) {
        answer(tumble_sdo_expedited(TUMBLE_SDO_UPLOAD_ANSWER, 1), request, 5);
    } else {
        answer(TUMBLE_SDO_ABORT, request, NO_DATA);
    }
}

static void read_segment(const uint8_t *request)
{
    uint8_t bytes[8];
    tumble_can_frame_t frame = {.id = response_id(), .length = 8};
    const bool is_second = (request[0] & TUMBLE_SDO_TOGGLE) != 0U;
    tumble_put_f64(bytes, bench.k_xx);
    if (bench.upload != NULL) {
        memcpy(bytes, bench.upload->bytes, sizeof bytes);
    }
    frame.data[0] = is_second ? (uint8_t)(TUMBLE_SDO_TOGGLE | 6U << 1 | TUMBLE_SDO_C) : 0U;
    memcpy(&frame.data[1], &bytes[is_second ? 7 : 0], is_second ? 1 : 7);
    fake_port_give(&bench.fake, &frame);
}

bench_object_t *last_write(void)
{
    return &bench.writes[(bench.written + COUNT_OF(bench.writes) - 1U) % COUNT_OF(bench.writes)];
}

static void write(const uint8_t *request)
{
    const bool is_expedited = (request[0] & TUMBLE_SDO_E) != 0U;
    const uint8_t size = is_expedited ? (uint8_t)(4U - ((request[0] >> 2) & 3U)) : request[4];
    bench.written++;
    *last_write() = (bench_object_t){tumble_get_u16(&request[1]), request[3], size, {0}};
    if (is_expedited) {
        memcpy(last_write()->bytes, &request[4], 4);
    }
    if (bench.refuse != 0U) {
        answer(TUMBLE_SDO_ABORT, request, bench.refuse);
    } else {
        if (bench.on_write != NULL) {
            bench.on_write();
        }
        answer(TUMBLE_SDO_DOWNLOAD_ANSWER, request, 0);
    }
}

/* Of eight bytes. */
static void write_segment(const uint8_t *request)
{
    const uint8_t acknowledged[8] = {(uint8_t)(TUMBLE_SDO_DOWNLOAD_SEGMENT_ANSWER | (request[0] & TUMBLE_SDO_TOGGLE))};
    const bool is_last = (request[0] & TUMBLE_SDO_C) != 0U;
    memcpy(&last_write()->bytes[is_last ? 7 : 0], &request[1], is_last ? 1 : 7);
    const tumble_can_frame_t frame = fake_frame(response_id(), 8, acknowledged);
    fake_port_give(&bench.fake, &frame);
}

bool serve(void)
{
    tumble_can_frame_t frame;
    if (!fake_port_take(&bench.fake, &frame)) {
        return false;
    }
    bench.is_second = frame.id == TUMBLE_SDO_SECOND_REQUEST_ID + NODE;
    TEST_ASSERT_TRUE(bench.is_second || frame.id == TUMBLE_SDO_REQUEST_ID + NODE);
    if (bench.silent || (bench.is_second && bench.has_one_server)) {
        return true;
    }
    switch (frame.data[0] & TUMBLE_SDO_COMMAND_MASK) {
    case TUMBLE_SDO_UPLOAD_REQUEST:
        read(frame.data);
        break;
    case TUMBLE_SDO_UPLOAD_SEGMENT_REQUEST:
        read_segment(frame.data);
        break;
    case TUMBLE_SDO_DOWNLOAD_REQUEST:
        write(frame.data);
        break;
    case TUMBLE_SDO_DOWNLOAD_SEGMENT_REQUEST:
        write_segment(frame.data);
        break;
    default:
        break;
    }
    return true;
}

void exchange(unsigned times)
{
    for (unsigned i = 0; i < times; i++) {
        gateway_poller_step(&bench.poller);
        (void)serve();
    }
}

void settle(void)
{
    int steps = 0;
    do {
        gateway_poller_step(&bench.poller);
        TEST_ASSERT_LESS_THAN_INT(STEPS_OF_A_POLL, ++steps);
    } while (serve());
}

void carry_out(gateway_command_t *command)
{
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.poller.queue, command));
    settle();
}

void pass(uint64_t us)
{
    const uint64_t end_us = bench.fake.now_us + us;
    settle();
    while (gateway_poller_next_us(&bench.poller) <= end_us) {
        const uint64_t next_us = gateway_poller_next_us(&bench.poller);
        bench.fake.now_us = (next_us > bench.fake.now_us) ? next_us : bench.fake.now_us;
        settle();
    }
    bench.fake.now_us = end_us;
}

uint32_t count(int which)
{
    return bench.counters.count[which];
}
