#include "sample/block_frames.h"

#include "core/bytes.h"
#include "core/count.h"

#include <stddef.h>

/* A sample is two frames. The second carries seven bits of the first one's counter, so halves of different samples do
 * not pair:
 *
 *     683h  x y  7   \  a sample,            683h  x y  7      (the 693h of 7 is lost)
 *     693h  z   15   /  for 15 = 2 * 7 + 1
 *     683h  x y  8   \                       683h  x y  8      the half before has no partner: lone_halves
 *     693h  z   17   /  a sample             693h  z   17      a sample; 7 was never handed on: lost
 *
 * The counter has eight bits and is widened to sixteen. A step forward of n, 1 to 127, means n - 1 lost samples; a step
 * of 128 to 255 is an old sample that came late. Eight bits cannot tell a longer silence from that: a timeout must end
 * it.
 */
enum { PENDING_XY = 1, PENDING_Z = 2, HAS_COUNTER = 4 };

enum { XY_COUNTER = 6, Z_COUNTER = 3, Z_TIMESTAMP = 4, Z_TEMPERATURE = 6, CRC = 7 };

#define CRC_INIT 0xFFU
#define CRC_XOR 0xFFU

#if (TUMBLE_BLOCK_CRC_BITS != 4) && (TUMBLE_BLOCK_CRC_BITS != 8)
#error "the CRC takes 4 or 8 bits at one time"
#endif

uint8_t tumble_block_frame_crc(const tumble_can_frame_t *frame)
{
#if TUMBLE_BLOCK_CRC_BITS == 4
    static const uint8_t crc_of_nibble[16] = {0x00U, 0x2FU, 0x5EU, 0x71U, 0xBCU, 0x93U, 0xE2U, 0xCDU,
                                              0x57U, 0x78U, 0x09U, 0x26U, 0xEBU, 0xC4U, 0xB5U, 0x9AU};
#else
    /* clang-format off */
    static const uint8_t crc_of_byte[256] = {
        0x00U, 0x2FU, 0x5EU, 0x71U, 0xBCU, 0x93U, 0xE2U, 0xCDU, 0x57U, 0x78U, 0x09U, 0x26U, 0xEBU, 0xC4U, 0xB5U, 0x9AU,
        0xAEU, 0x81U, 0xF0U, 0xDFU, 0x12U, 0x3DU, 0x4CU, 0x63U, 0xF9U, 0xD6U, 0xA7U, 0x88U, 0x45U, 0x6AU, 0x1BU, 0x34U,
        0x73U, 0x5CU, 0x2DU, 0x02U, 0xCFU, 0xE0U, 0x91U, 0xBEU, 0x24U, 0x0BU, 0x7AU, 0x55U, 0x98U, 0xB7U, 0xC6U, 0xE9U,
        0xDDU, 0xF2U, 0x83U, 0xACU, 0x61U, 0x4EU, 0x3FU, 0x10U, 0x8AU, 0xA5U, 0xD4U, 0xFBU, 0x36U, 0x19U, 0x68U, 0x47U,
        0xE6U, 0xC9U, 0xB8U, 0x97U, 0x5AU, 0x75U, 0x04U, 0x2BU, 0xB1U, 0x9EU, 0xEFU, 0xC0U, 0x0DU, 0x22U, 0x53U, 0x7CU,
        0x48U, 0x67U, 0x16U, 0x39U, 0xF4U, 0xDBU, 0xAAU, 0x85U, 0x1FU, 0x30U, 0x41U, 0x6EU, 0xA3U, 0x8CU, 0xFDU, 0xD2U,
        0x95U, 0xBAU, 0xCBU, 0xE4U, 0x29U, 0x06U, 0x77U, 0x58U, 0xC2U, 0xEDU, 0x9CU, 0xB3U, 0x7EU, 0x51U, 0x20U, 0x0FU,
        0x3BU, 0x14U, 0x65U, 0x4AU, 0x87U, 0xA8U, 0xD9U, 0xF6U, 0x6CU, 0x43U, 0x32U, 0x1DU, 0xD0U, 0xFFU, 0x8EU, 0xA1U,
        0xE3U, 0xCCU, 0xBDU, 0x92U, 0x5FU, 0x70U, 0x01U, 0x2EU, 0xB4U, 0x9BU, 0xEAU, 0xC5U, 0x08U, 0x27U, 0x56U, 0x79U,
        0x4DU, 0x62U, 0x13U, 0x3CU, 0xF1U, 0xDEU, 0xAFU, 0x80U, 0x1AU, 0x35U, 0x44U, 0x6BU, 0xA6U, 0x89U, 0xF8U, 0xD7U,
        0x90U, 0xBFU, 0xCEU, 0xE1U, 0x2CU, 0x03U, 0x72U, 0x5DU, 0xC7U, 0xE8U, 0x99U, 0xB6U, 0x7BU, 0x54U, 0x25U, 0x0AU,
        0x3EU, 0x11U, 0x60U, 0x4FU, 0x82U, 0xADU, 0xDCU, 0xF3U, 0x69U, 0x46U, 0x37U, 0x18U, 0xD5U, 0xFAU, 0x8BU, 0xA4U,
        0x05U, 0x2AU, 0x5BU, 0x74U, 0xB9U, 0x96U, 0xE7U, 0xC8U, 0x52U, 0x7DU, 0x0CU, 0x23U, 0xEEU, 0xC1U, 0xB0U, 0x9FU,
        0xABU, 0x84U, 0xF5U, 0xDAU, 0x17U, 0x38U, 0x49U, 0x66U, 0xFCU, 0xD3U, 0xA2U, 0x8DU, 0x40U, 0x6FU, 0x1EU, 0x31U,
        0x76U, 0x59U, 0x28U, 0x07U, 0xCAU, 0xE5U, 0x94U, 0xBBU, 0x21U, 0x0EU, 0x7FU, 0x50U, 0x9DU, 0xB2U, 0xC3U, 0xECU,
        0xD8U, 0xF7U, 0x86U, 0xA9U, 0x64U, 0x4BU, 0x3AU, 0x15U, 0x8FU, 0xA0U, 0xD1U, 0xFEU, 0x33U, 0x1CU, 0x6DU, 0x42U,
    };
    /* clang-format on */
#endif
    uint8_t crc = CRC_INIT;
    uint8_t byte = (uint8_t)(frame->id & 0xFFU);
    for (size_t i = 0; i <= CRC; i++) {
#if TUMBLE_BLOCK_CRC_BITS == 4
        crc = (uint8_t)((unsigned)(crc << 4U) ^ crc_of_nibble[(crc >> 4U) ^ (byte >> 4U)]);
        crc = (uint8_t)((unsigned)(crc << 4U) ^ crc_of_nibble[(crc >> 4U) ^ (byte & 0x0FU)]);
#else
        crc = crc_of_byte[crc ^ byte];
#endif
        byte = frame->data[i]; /* the last is the CRC itself */
    }
    return crc ^ CRC_XOR;
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

void tumble_block_receiver_restart(tumble_block_receiver_t *receiver)
{
    receiver->flags = 0;
}

static tumble_block_event_t repeated(tumble_block_receiver_t *receiver)
{
    tumble_count(&receiver->counters.repeated);
    return TUMBLE_BLOCK_REPEATED;
}

static tumble_block_event_t reordered(tumble_block_receiver_t *receiver)
{
    tumble_count(&receiver->counters.reordered);
    return TUMBLE_BLOCK_REORDERED;
}

static tumble_block_event_t corrupted(uint32_t *cause)
{
    tumble_count(cause);
    return TUMBLE_BLOCK_CORRUPTED;
}

static tumble_block_event_t receive_xy(tumble_block_receiver_t *receiver, const uint8_t *data)
{
    const uint8_t counter = data[XY_COUNTER];
    const unsigned flags = receiver->flags;
    if (((flags & HAS_COUNTER) != 0U) && (counter == (receiver->counter & 0xFFU))) {
        return repeated(receiver);
    }
    if (((flags & PENDING_XY) != 0U) && (counter == receiver->pending_counter)) {
        return repeated(receiver);
    }
    if (((flags & PENDING_Z) != 0U) && (frame_counter(counter) == receiver->pending_counter)) {
        receiver->flags = (uint8_t)(flags & HAS_COUNTER);
        return reordered(receiver);
    }
    if ((flags & (PENDING_XY | PENDING_Z)) != 0U) {
        tumble_count(&receiver->counters.lone_halves);
    }
    receiver->flags = (uint8_t)((flags & HAS_COUNTER) | PENDING_XY);
    receiver->pending_counter = counter;
    receiver->x_counts = get_int24(&data[0]);
    receiver->y_counts = get_int24(&data[3]);
    return TUMBLE_BLOCK_HALF;
}

/* A second half whose first half is not the pending one. */
static tumble_block_event_t receive_lone_z(tumble_block_receiver_t *receiver, uint8_t counter)
{
    const unsigned flags = receiver->flags;
    if (((flags & HAS_COUNTER) != 0U) && (counter == frame_counter((uint8_t)(receiver->counter & 0xFFU)))) {
        return repeated(receiver);
    }
    if (((flags & PENDING_XY) != 0U) || ((counter & 1U) == 0U)) {
        receiver->flags = (uint8_t)(flags & HAS_COUNTER);
        return corrupted(&receiver->counters.wrong_pair);
    }
    if ((flags & PENDING_Z) != 0U) {
        tumble_count(&receiver->counters.lone_halves);
    }
    receiver->flags = (uint8_t)((flags & HAS_COUNTER) | PENDING_Z);
    receiver->pending_counter = counter;
    return TUMBLE_BLOCK_HALF;
}

static tumble_block_event_t receive_z(tumble_block_receiver_t *receiver, const uint8_t *data,
                                      tumble_block_sample_t *sample)
{
    const uint8_t counter = receiver->pending_counter;
    if (((receiver->flags & PENDING_XY) == 0U) || (data[Z_COUNTER] != frame_counter(counter))) {
        return receive_lone_z(receiver, data[Z_COUNTER]);
    }
    const bool is_first = ((receiver->flags & HAS_COUNTER) == 0U);
    const uint8_t advance = is_first ? 0U : (uint8_t)(counter - (receiver->counter & 0xFFU));
    receiver->flags = HAS_COUNTER;
    if (advance > (uint8_t)INT8_MAX) {
        return reordered(receiver);
    }
    if (advance > 1U) {
        tumble_add_up(&receiver->counters.lost, (uint32_t)advance - 1U);
    }
    receiver->counter = is_first ? counter : (uint16_t)(receiver->counter + advance);
    *sample = (tumble_block_sample_t){
        .raw = {.counts = {receiver->x_counts, receiver->y_counts, get_int24(&data[0])},
                .counter = receiver->counter,
                .status = (uint8_t)(data[Z_TIMESTAMP + 1] >> 4U)},
        .timestamp_ms = (uint16_t)(data[Z_TIMESTAMP] | ((data[Z_TIMESTAMP + 1] & 0x0FU) << 8U)),
        .temperature_half_c = tumble_get_i8(&data[Z_TEMPERATURE]),
    };
    tumble_count(&receiver->counters.samples);
    return TUMBLE_BLOCK_SAMPLE;
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
