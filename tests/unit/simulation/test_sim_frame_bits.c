/* Length of a frame on the wire: known values, and an encoder that writes out every bit. */
#include "simulation/frame_bits.h"
#include "support.h"

static sim_wire_t wire;

static void set_up(void)
{
    sim_wire_init(&wire);
}

typedef struct {
    uint8_t bits[160];
    int count;
} line_t;

static void put(line_t *line, uint32_t value, int bits)
{
    for (int i = bits - 1; i >= 0; i--) {
        line->bits[line->count++] = (uint8_t)(value >> i & 1U);
    }
}

/* The CRC register of ISO 11898-1, bit by bit. */
static uint16_t crc_of(const line_t *line)
{
    uint32_t crc = 0;
    for (int i = 0; i < line->count; i++) {
        const uint32_t next = line->bits[i] ^ (crc >> 14 & 1U);
        crc = (crc << 1) & 0x7FFFU;
        crc ^= (next != 0U) ? 0x4599U : 0U;
    }
    return (uint16_t)crc;
}

static uint32_t stuff_bits_of(const line_t *line)
{
    uint32_t stuffed = 0;
    int run = 0;
    int last = -1;
    for (int i = 0; i < line->count; i++) {
        run = (line->bits[i] == last) ? run + 1 : 1;
        last = line->bits[i];
        if (run == 5) {
            stuffed++;
            last = 1 - last;
            run = 1;
        }
    }
    return stuffed;
}

/* Start of frame, identifier, RTR, IDE, r0, length, data, CRC. */
static line_t write_out(const tumble_can_frame_t *frame)
{
    line_t line = {.count = 0};
    put(&line, 0, 1);
    put(&line, frame->id, 11);
    put(&line, 0, 3);
    put(&line, frame->length, 4);
    for (int i = 0; i < frame->length; i++) {
        put(&line, frame->data[i], 8);
    }
    put(&line, crc_of(&line), 15);
    return line;
}

static void assert_as_written_out(const tumble_can_frame_t *frame)
{
    const line_t line = write_out(frame);
    const uint32_t stuffed = stuff_bits_of(&line);
    TEST_ASSERT_EQUAL_UINT32(stuffed, sim_frame_stuff_bits(&wire, frame));
    /* CRC delimiter, acknowledge slot and delimiter, 7 bits end of frame, 3 bits interframe space. */
    TEST_ASSERT_EQUAL_UINT32((uint32_t)line.count + stuffed + 1U + 2U + 7U + 3U, sim_frame_bits(&wire, frame));
}

/* 47 bits of overhead with the interframe space, 8 per byte: 111 for eight bytes, before stuffing. */
static void test_length_without_stuffing_is_the_known_one(void)
{
    tumble_can_frame_t frame = {.id = 0x555, .length = 0};
    for (uint8_t length = 0; length <= 8; length++) {
        frame.length = length;
        frame.data[(length > 0U) ? length - 1 : 0] = 0x55;
        TEST_ASSERT_EQUAL_UINT32(47U + 8U * length,
                                 sim_frame_bits(&wire, &frame) - sim_frame_stuff_bits(&wire, &frame));
    }
}

/* No frame has more stuff bits than (bits from start of frame to CRC - 1) / 4: 24 for eight bytes. */
static void test_all_lengths_and_patterns_against_the_written_out_frame(void)
{
    dice_t dice = {4};
    for (int n = 0; n < 200000; n++) {
        tumble_can_frame_t frame = {.id = (uint16_t)dice_below(&dice, 0x800), .length = (uint8_t)dice_below(&dice, 9)};
        static const uint8_t PATTERNS[] = {0x00, 0xFF, 0x0F, 0xF0, 0x78, 0x87, 0xC3, 0x3C, 0x1E, 0xE1};
        const uint32_t kind = dice_below(&dice, 3);
        for (int i = 0; i < 8; i++) {
            frame.data[i] = (kind == 0U) ? (uint8_t)dice_below(&dice, 256)
                                         : PATTERNS[dice_below(&dice, (kind == 1U) ? 2 : COUNT_OF(PATTERNS))];
        }
        assert_as_written_out(&frame);
        TEST_ASSERT_TRUE(sim_frame_stuff_bits(&wire, &frame) <= (34U + 8U * frame.length - 1U) / 4U);
    }
}

/* Identifier 0, no data: 34 bits of 0, the CRC included; a stuff bit of 1 after every five. */
static void test_the_all_zero_frame(void)
{
    const tumble_can_frame_t frame = {.id = 0, .length = 0};
    assert_as_written_out(&frame);
    TEST_ASSERT_EQUAL_UINT32(6, sim_frame_stuff_bits(&wire, &frame));
}
