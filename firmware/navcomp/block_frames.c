#include "navcomp/block_frames.h"

#include "canopen/bytes.h"

enum { PENDING_XY = 1, PENDING_Z = 2, HAS_COUNTER = 4 };

enum { XY_COUNTER = 6, Z_COUNTER = 3, Z_TIMESTAMP = 4, Z_TEMPERATURE = 6, CRC = 7 };

/* One nibble at a time: a table of 16 bytes instead of 256, at two look-ups a byte. */
static uint8_t crc_nibble(uint8_t crc, uint8_t nibble)
{
    static const uint8_t crc_of_nibble[16] = {0x00U, 0x2FU, 0x5EU, 0x71U, 0xBCU, 0x93U, 0xE2U, 0xCDU,
                                              0x57U, 0x78U, 0x09U, 0x26U, 0xEBU, 0xC4U, 0xB5U, 0x9AU};
    return (uint8_t)((unsigned)(crc << 4U) ^ crc_of_nibble[(crc >> 4U) ^ nibble]);
}

uint8_t tumble_block_crc8(uint8_t crc, const uint8_t *bytes, size_t length)
{
    uint8_t result = crc;
    for (size_t i = 0; i < length; i++) {
        result = crc_nibble(result, bytes[i] >> 4U);
        result = crc_nibble(result, bytes[i] & 0x0FU);
    }
    return result;
}

uint8_t tumble_block_frame_crc(const tumble_can_frame_t *frame)
{
    const uint8_t identifier = (uint8_t)(frame->id & 0xFFU);
    const uint8_t crc = tumble_block_crc8(TUMBLE_BLOCK_CRC_INIT, &identifier, 1);
    return (uint8_t)(tumble_block_crc8(crc, frame->data, CRC) ^ TUMBLE_BLOCK_CRC_XOR);
}

static void put_int24(uint8_t bytes[3], int32_t value)
{
    const uint32_t bits = (uint32_t)value;
    bytes[0] = (uint8_t)(bits & 0xFFU);
    bytes[1] = (uint8_t)((bits >> 8U) & 0xFFU);
    bytes[2] = (uint8_t)((bits >> 16U) & 0xFFU);
}

static int32_t get_int24(const uint8_t bytes[3])
{
    const int32_t value = (int32_t)((uint32_t)bytes[0] | ((uint32_t)bytes[1] << 8U) | ((uint32_t)bytes[2] << 16U));
    return (value > TUMBLE_BLOCK_MAX_COUNTS) ? (value - 0x1000000) : value;
}

/* What the second half carries of the sample counter. Always odd, so seven bits of the counter remain. */
static uint8_t frame_counter(uint8_t sample_counter)
{
    return (uint8_t)((2U * sample_counter) + 1U);
}

static bool can_be_sent(const tumble_block_sample_t *sample)
{
    bool in_range = (sample->timestamp_ms < TUMBLE_TIMESTAMP_PERIOD_MS) && (sample->status < 16U);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const int32_t counts = sample->raw.counts[i];
        in_range = in_range && (counts >= TUMBLE_BLOCK_MIN_COUNTS) && (counts <= TUMBLE_BLOCK_MAX_COUNTS);
    }
    return in_range;
}

tumble_status_t tumble_block_encode(const tumble_block_sample_t *sample, tumble_can_frame_t *xy, tumble_can_frame_t *z)
{
    if ((sample == NULL) || (xy == NULL) || (z == NULL) || !can_be_sent(sample)) {
        return TUMBLE_E_ARGUMENT;
    }
    const uint8_t counter = (uint8_t)(sample->raw.counter & 0xFFU);
    const uint16_t time_and_status = (uint16_t)(sample->timestamp_ms | (unsigned)(sample->status << 12U));
    *xy = (tumble_can_frame_t){.id = TUMBLE_BLOCK_ID_XY, .length = TUMBLE_BLOCK_FRAME_BYTES};
    put_int24(&xy->data[0], sample->raw.counts[0]);
    put_int24(&xy->data[3], sample->raw.counts[1]);
    xy->data[XY_COUNTER] = counter;
    xy->data[CRC] = tumble_block_frame_crc(xy);

    *z = (tumble_can_frame_t){.id = TUMBLE_BLOCK_ID_Z, .length = TUMBLE_BLOCK_FRAME_BYTES};
    put_int24(&z->data[0], sample->raw.counts[2]);
    z->data[Z_COUNTER] = frame_counter(counter);
    tumble_put_u16(&z->data[Z_TIMESTAMP], time_and_status);
    z->data[Z_TEMPERATURE] = (uint8_t)sample->temperature_half_c;
    z->data[CRC] = tumble_block_frame_crc(z);
    return TUMBLE_OK;
}

void tumble_block_receiver_init(tumble_block_receiver_t *receiver)
{
    *receiver = (tumble_block_receiver_t){0};
}

void tumble_block_receiver_restart(tumble_block_receiver_t *receiver)
{
    receiver->flags = 0;
}

static void count(uint32_t *counter, uint32_t by)
{
    *counter = (by <= (UINT32_MAX - *counter)) ? (*counter + by) : UINT32_MAX;
}

static bool has(const tumble_block_receiver_t *receiver, unsigned flag)
{
    return (receiver->flags & flag) != 0U;
}

/* Replace whatever half is pending (0: by none). */
static void pend(tumble_block_receiver_t *receiver, unsigned flag, uint8_t counter)
{
    receiver->flags = (uint8_t)((receiver->flags & HAS_COUNTER) | flag);
    receiver->pending_counter = counter;
}

static uint8_t last_counter(const tumble_block_receiver_t *receiver)
{
    return (uint8_t)(receiver->counter & 0xFFU);
}

static tumble_block_event_t repeated(tumble_block_receiver_t *receiver)
{
    count(&receiver->counters.repeated, 1U);
    return TUMBLE_BLOCK_REPEATED;
}

static tumble_block_event_t reordered(tumble_block_receiver_t *receiver)
{
    count(&receiver->counters.reordered, 1U);
    return TUMBLE_BLOCK_REORDERED;
}

static tumble_block_event_t corrupted(uint32_t *cause)
{
    count(cause, 1U);
    return TUMBLE_BLOCK_CORRUPTED;
}

static tumble_block_event_t receive_xy(tumble_block_receiver_t *receiver, const uint8_t *data)
{
    const uint8_t counter = data[XY_COUNTER];
    if (has(receiver, HAS_COUNTER) && (counter == last_counter(receiver))) {
        return repeated(receiver);
    }
    if (has(receiver, PENDING_XY) && (counter == receiver->pending_counter)) {
        return repeated(receiver);
    }
    if (has(receiver, PENDING_Z) && (frame_counter(counter) == receiver->pending_counter)) {
        pend(receiver, 0, 0);
        return reordered(receiver);
    }
    if (has(receiver, PENDING_XY | PENDING_Z)) {
        count(&receiver->counters.lone_halves, 1U);
    }
    pend(receiver, PENDING_XY, counter);
    receiver->x_counts = get_int24(&data[0]);
    receiver->y_counts = get_int24(&data[3]);
    return TUMBLE_BLOCK_HALF;
}

/* Both halves are there: follow the sample counter. A step backwards by up to 128 is an old sample. */
static tumble_block_event_t complete(tumble_block_receiver_t *receiver, const uint8_t *data,
                                     tumble_block_sample_t *sample)
{
    const uint8_t counter = receiver->pending_counter;
    const uint8_t advance = (uint8_t)(counter - last_counter(receiver));
    pend(receiver, 0, 0);
    if (!has(receiver, HAS_COUNTER)) {
        receiver->counter = counter;
        receiver->flags = HAS_COUNTER;
    } else if (advance > (uint8_t)INT8_MAX) {
        return reordered(receiver);
    } else {
        receiver->counter = (uint16_t)(receiver->counter + advance);
        count(&receiver->counters.lost, (uint32_t)advance - 1U);
    }
    const uint16_t time_and_status = tumble_get_u16(&data[Z_TIMESTAMP]);
    *sample = (tumble_block_sample_t){
        .raw = {.counts = {receiver->x_counts, receiver->y_counts, get_int24(&data[0])}, .counter = receiver->counter},
        .timestamp_ms = time_and_status & (TUMBLE_TIMESTAMP_PERIOD_MS - 1U),
        .status = (uint8_t)(time_and_status >> 12U),
        .temperature_half_c = tumble_get_i8(&data[Z_TEMPERATURE]),
    };
    count(&receiver->counters.samples, 1U);
    return TUMBLE_BLOCK_SAMPLE;
}

static tumble_block_event_t receive_z(tumble_block_receiver_t *receiver, const uint8_t *data,
                                      tumble_block_sample_t *sample)
{
    const uint8_t counter = data[Z_COUNTER];
    if (has(receiver, PENDING_XY) && (counter == frame_counter(receiver->pending_counter))) {
        return complete(receiver, data, sample);
    }
    if (has(receiver, HAS_COUNTER) && (counter == frame_counter(last_counter(receiver)))) {
        return repeated(receiver);
    }
    if (has(receiver, PENDING_XY) || ((counter & 1U) == 0U)) {
        pend(receiver, 0, 0);
        return corrupted(&receiver->counters.wrong_pair);
    }
    if (has(receiver, PENDING_Z)) {
        count(&receiver->counters.lone_halves, 1U);
    }
    pend(receiver, PENDING_Z, counter);
    return TUMBLE_BLOCK_HALF;
}

tumble_block_event_t tumble_block_receive(tumble_block_receiver_t *receiver, const tumble_can_frame_t *frame,
                                          tumble_block_sample_t *sample)
{
    if ((frame->id != TUMBLE_BLOCK_ID_XY) && (frame->id != TUMBLE_BLOCK_ID_Z)) {
        return TUMBLE_BLOCK_OTHER;
    }
    if (frame->length != TUMBLE_BLOCK_FRAME_BYTES) {
        return corrupted(&receiver->counters.wrong_length);
    }
    if (frame->data[CRC] != tumble_block_frame_crc(frame)) {
        return corrupted(&receiver->counters.wrong_crc);
    }
    return (frame->id == TUMBLE_BLOCK_ID_XY) ? receive_xy(receiver, frame->data)
                                             : receive_z(receiver, frame->data, sample);
}
