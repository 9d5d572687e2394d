#include "block_frames_bench.h"

/* Data bytes and the one identifier bit that separates the two frames: everything whose change reaches the decoder. */
#define FRAME_BITS 64
#define ID_BIT 64

static void assert_same_sample(const tumble_block_sample_t *expected, const tumble_block_sample_t *actual)
{
    TEST_ASSERT_EQUAL_INT32_ARRAY(expected->raw.counts, actual->raw.counts, TUMBLE_CHANNELS);
    TEST_ASSERT_EQUAL_UINT16(expected->raw.counter, actual->raw.counter);
    TEST_ASSERT_EQUAL_UINT16(expected->timestamp_ms, actual->timestamp_ms);
    TEST_ASSERT_EQUAL_UINT8(expected->raw.status, actual->raw.status);
    TEST_ASSERT_EQUAL_INT8(expected->temperature_half_c, actual->temperature_half_c);
}

/* The CRC bit by bit, straight from its definition: the oracle for the tables. */
static uint8_t slow_crc8(uint8_t crc, const uint8_t *bytes, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (uint8_t)(((crc & 0x80U) != 0U) ? (((unsigned)crc << 1U) ^ 0x2FU) : ((unsigned)crc << 1U));
        }
    }
    return crc;
}

static void test_crc_check_value_of_the_catalogue(void)
{
    const uint8_t digits[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    TEST_ASSERT_EQUAL_HEX8(0xDF, slow_crc8(0xFF, digits, sizeof digits) ^ 0xFF);
}

static tumble_can_frame_t sealed(uint16_t id, const uint8_t bytes[7])
{
    const uint8_t low = (uint8_t)(id & 0xFFU);
    tumble_can_frame_t frame = {.id = id, .length = 8};
    memcpy(frame.data, bytes, 7);
    frame.data[7] = slow_crc8(slow_crc8(0xFF, &low, 1), bytes, 7) ^ 0xFF;
    return frame;
}

/* After the identifier's byte the CRC has any value; the next byte has any, too. */
static void test_crc_table_agrees_with_the_definition_everywhere(void)
{
    for (uint16_t id = 0; id < 256U; id++) {
        for (unsigned value = 0; value < 256U; value++) {
            const uint8_t bytes[7] = {(uint8_t)value, 0, 0, 0, 0, 0, (uint8_t)(value ^ id)};
            const tumble_can_frame_t frame = sealed(id, bytes);
            TEST_ASSERT_EQUAL_HEX8(frame.data[7], tumble_block_frame_crc(&frame));
        }
    }
}

static void assert_same_frame(const tumble_can_frame_t *expected, const tumble_can_frame_t *actual)
{
    TEST_ASSERT_EQUAL_HEX16(expected->id, actual->id);
    TEST_ASSERT_EQUAL_UINT8(expected->length, actual->length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected->data, actual->data, 8);
}

/* The layout byte by byte, written out by hand: the receiver takes it, and the encoder makes it. */
static void test_golden_layout(void)
{
    const tumble_block_sample_t sample = {
        .raw = {.counts = {0x123456, -2, -8388608},
                .counter = 0xC5,
                .status = TUMBLE_SAMPLE_SATURATED | TUMBLE_SAMPLE_TEMPERATURE},
        .timestamp_ms = 0xABC,
        .temperature_half_c = -41,
    };
    const uint8_t xy_bytes[7] = {0x56, 0x34, 0x12, 0xFE, 0xFF, 0xFF, 0xC5};
    const uint8_t z_bytes[7] = {0x00, 0x00, 0x80, 0x8B, 0xBC, 0x9A, 0xD7};
    const tumble_can_frame_t xy = sealed(0x683, xy_bytes);
    const tumble_can_frame_t z = sealed(0x693, z_bytes);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive(&xy));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_SAMPLE, receive(&z));
    assert_same_sample(&sample, &got);

    sim_block_frames_t frames;
    sim_block_encode(&sample, &frames);
    assert_same_frame(&xy, &frames.xy);
    assert_same_frame(&z, &frames.z);
}

static void test_extremes_survive_the_round_trip(void)
{
    const int32_t extremes[] = {-8388608, -8388607, -1, 0, 1, 255, 256, 65535, 65536, 8388606, 8388607};
    const size_t n = sizeof extremes / sizeof extremes[0];
    for (size_t i = 0; i < (n * n * n); i++) {
        const tumble_block_sample_t sample = {
            .raw = {.counts = {extremes[i % n], extremes[(i / n) % n], extremes[i / (n * n)]},
                    .counter = (uint16_t)i,
                    .status = (uint8_t)(i % 16U)},
            .timestamp_ms = (uint16_t)((i * 4095U) % 4096U),
            .temperature_half_c = (int8_t)((int)(i % 256U) - 128),
        };
        sim_block_frames_t frames;
        sim_block_encode(&sample, &frames);
        TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive(&frames.xy));
        TEST_ASSERT_EQUAL(TUMBLE_BLOCK_SAMPLE, receive(&frames.z));
        assert_same_sample(&sample, &got);
    }
}

static tumble_can_frame_t flip(tumble_can_frame_t frame, int bit)
{
    if (bit == ID_BIT) {
        frame.id ^= (uint16_t)(TUMBLE_BLOCK_ID_XY ^ TUMBLE_BLOCK_ID_Z);
    } else {
        frame.data[bit / 8] ^= (uint8_t)(1U << ((unsigned)bit % 8U));
    }
    return frame;
}

/* Every error of one, two and three bits in a frame, its identifier included, is detected as a wrong CRC. */
static uint32_t assert_bit_errors_are_detected(const tumble_can_frame_t *frame)
{
    uint32_t errors = 0;
    for (int a = 0; a <= FRAME_BITS; a++) {
        const tumble_can_frame_t one = flip(*frame, a);
        TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&one));
        errors++;
        for (int b = a + 1; b <= FRAME_BITS; b++) {
            const tumble_can_frame_t two = flip(one, b);
            TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&two));
            errors++;
            for (int c = b + 1; c <= FRAME_BITS; c++) {
                const tumble_can_frame_t three = flip(two, c);
                TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&three));
                errors++;
            }
        }
    }
    return errors;
}

static void test_every_error_of_up_to_three_bits_is_detected(void)
{
    const sim_block_frames_t frames = frames_of(77);
    const uint32_t errors = assert_bit_errors_are_detected(&frames.xy) + assert_bit_errors_are_detected(&frames.z);
    TEST_ASSERT_EQUAL_UINT32(2U * (65U + 2080U + 43680U), errors);
    TEST_ASSERT_EQUAL_UINT32(errors, receiver.counters.wrong_crc);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.samples);
}

/* Canary for the test above: errors of four bits do get through, as many as the polynomial lets through. */
static void test_some_errors_of_four_bits_are_not_detected(void)
{
    const sim_block_frames_t frames = frames_of(77);
    uint32_t undetected = 0;
    for (int a = 0; a < FRAME_BITS; a++) {
        for (int b = a + 1; b < FRAME_BITS; b++) {
            for (int c = b + 1; c < FRAME_BITS; c++) {
                for (int d = c + 1; d < FRAME_BITS; d++) {
                    const tumble_can_frame_t bad = flip(flip(flip(flip(frames.xy, a), b), c), d);
                    undetected += (bad.data[7] == tumble_block_frame_crc(&bad)) ? 1U : 0U;
                }
            }
        }
    }
    TEST_ASSERT_EQUAL_UINT32(5066, undetected);
}

static void test_a_burst_of_up_to_eight_bits_is_detected(void)
{
    const sim_block_frames_t frames = frames_of(5);
    for (unsigned start = 0; start < 64U; start++) {
        for (unsigned pattern = 1; pattern < 256U; pattern++) {
            tumble_can_frame_t bad = frames.z;
            /* Bits as they travel: the first byte first, in it the highest bit first. */
            for (unsigned i = 0; (i < 8U) && ((start + i) < 64U); i++) {
                const unsigned flipped = (pattern >> i) & 1U;
                bad.data[(start + i) / 8U] ^= (uint8_t)(flipped << (7U - ((start + i) % 8U)));
            }
            if (memcmp(bad.data, frames.z.data, 8) != 0) {
                TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&bad));
            }
        }
    }
}

static void test_wrong_length_is_corrupted_and_counted_apart(void)
{
    sim_block_frames_t frames = frames_of(1);
    for (uint8_t length = 0; length < 16U; length++) {
        if (length != TUMBLE_BLOCK_FRAME_BYTES) {
            frames.xy.length = length;
            TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&frames.xy));
        }
    }
    TEST_ASSERT_EQUAL_UINT32(15, receiver.counters.wrong_length);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.wrong_crc);
}

static void test_other_identifiers_are_not_counted(void)
{
    sim_block_frames_t frames = frames_of(1);
    for (uint16_t id = 0; id <= TUMBLE_CAN_MAX_ID; id++) {
        frames.xy.id = id;
        if ((id != TUMBLE_BLOCK_ID_XY) && (id != TUMBLE_BLOCK_ID_Z)) {
            TEST_ASSERT_EQUAL(TUMBLE_BLOCK_OTHER, receive(&frames.xy));
        }
    }
    const tumble_block_receiver_t untouched = {0};
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &receiver, sizeof receiver);
}

static void test_a_first_half_under_the_other_identifier_is_corrupted(void)
{
    sim_block_frames_t frames = frames_of(9);
    frames.xy.id = TUMBLE_BLOCK_ID_Z;
    frames.z.id = TUMBLE_BLOCK_ID_XY;
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&frames.xy));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&frames.z));
    TEST_ASSERT_EQUAL_UINT32(2, receiver.counters.wrong_crc);
}

static const around_t around_each = {fresh_receiver, NULL};
