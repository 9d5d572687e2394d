#include "simulation/frame_bits.h"

#define HEADER_BITS 19 /* start of frame, 11 bits of identifier, RTR, IDE, r0, 4 bits of length: all up to the data */
#define CRC_BITS 15
#define TRAILER_BITS 10 /* CRC delimiter, acknowledge slot and delimiter, 7 bits end of frame */

#define CRC_POLYNOMIAL 0x4599U
#define CRC_TOP 0x4000U
#define CRC_MASK 0x7FFFU

static uint32_t shifted(uint32_t crc)
{
    return ((crc << 1) ^ (((crc & CRC_TOP) != 0U) ? CRC_POLYNOMIAL : 0U)) & CRC_MASK;
}

static void init_crc(sim_wire_t *wire)
{
    for (uint32_t byte = 0; byte < 256U; byte++) {
        uint32_t crc = byte << (CRC_BITS - 8);
        for (int following = 0; following < SIM_HEADER_BYTES + TUMBLE_CAN_MAX_BYTES; following++) {
            for (int bit = 0; bit < 8; bit++) {
                crc = shifted(crc);
            }
            wire->crc[following][byte] = (uint16_t)crc;
        }
    }
}

/* Send a byte, highest bit first, from a state. */
static void init_stuffing(sim_wire_t *wire, uint32_t state, uint32_t byte)
{
    uint32_t last = state & 1U;
    uint32_t run = (state >> 1) + 1U;
    uint32_t stuffed = 0;
    for (int i = 7; i >= 0; i--) {
        const uint32_t bit = byte >> i & 1U;
        run = (bit == last) ? run + 1U : 1U;
        last = bit;
        if (run == 5U) {
            stuffed++;
            last ^= 1U;
            run = 1;
        }
    }
    wire->next[state << 8 | byte] = (uint16_t)((last | (run - 1U) << 1) << 8);
    wire->stuffed[state << 8 | byte] = (uint8_t)stuffed;
}

void sim_wire_init(sim_wire_t *wire)
{
    init_crc(wire);
    for (uint32_t state = 0; state < 8U; state++) {
        for (uint32_t byte = 0; byte < 256U; byte++) {
            init_stuffing(wire, state, byte);
        }
    }
}

/* Start of frame, RTR, IDE and r0 are dominant (0). */
static uint32_t header_of(const tumble_can_frame_t *frame)
{
    return ((uint32_t)frame->id << 7) | frame->length;
}

/* The data bytes as one number, the first one highest. */
static uint64_t data_of(const tumble_can_frame_t *frame)
{
    const uint8_t *const d = frame->data;
    const uint64_t all = (uint64_t)d[0] << 56 | (uint64_t)d[1] << 48 | (uint64_t)d[2] << 40 | (uint64_t)d[3] << 32 |
                         (uint64_t)d[4] << 24 | (uint64_t)d[5] << 16 | (uint64_t)d[6] << 8 | (uint64_t)d[7];
    return (frame->length == 0U) ? 0U : all >> (8U * (TUMBLE_CAN_MAX_BYTES - frame->length));
}

static inline uint32_t crc_of(const sim_wire_t *wire, uint32_t header, uint64_t data, uint32_t length)
{
    /* Zeros before the header change nothing: the CRC starts at 0. */
    uint32_t crc = (uint32_t)wire->crc[length + 2U][header >> 16] ^ wire->crc[length + 1U][header >> 8 & 0xFFU] ^
                   wire->crc[length][header & 0xFFU];
    for (uint32_t i = 0; i < length; i++) {
        crc ^= wire->crc[i][data >> 8U * i & 0xFFU];
    }
    return crc;
}

uint16_t sim_frame_crc15(const sim_wire_t *wire, const tumble_can_frame_t *frame)
{
    return (uint16_t)crc_of(wire, header_of(frame), data_of(frame), frame->length);
}

/* Send the low `count` bytes of `bits`, the highest first, from *state (x 256). Returns the stuff bits. */
static inline uint32_t send_bytes(const sim_wire_t *wire, uint32_t *state, uint64_t bits, uint32_t count)
{
    uint32_t stuffed = 0;
    for (uint32_t shift = 8U * count; shift > 0U; shift -= 8U) {
        const uint32_t at = *state + (uint32_t)(bits >> (shift - 8U) & 0xFFU);
        stuffed += wire->stuffed[at];
        *state = wire->next[at];
    }
    return stuffed;
}

/* The 15 bits that follow the header: data first, then CRC. */
static uint32_t first_after_header(uint64_t data, uint32_t crc, uint32_t length)
{
    if (length >= 2U) {
        return (uint32_t)(data >> (8U * length - CRC_BITS));
    }
    return (length == 1U) ? (uint32_t)data << 7 | crc >> 8 : crc;
}

/* After start of frame (0) and the first bit of the identifier, whole bytes are left to send: 17 bits of header, data,
 * 15 bits of CRC; four bytes, then as many as there are data. */
static inline uint32_t stuff_bits_of(const sim_wire_t *wire, const tumble_can_frame_t *frame, uint32_t length)
{
    const uint32_t header = header_of(frame);
    const uint64_t data = data_of(frame);
    const uint32_t crc = crc_of(wire, header, data, length);
    uint32_t state = ((header >> 17 & 1U) != 0U) ? 1U << 8 /* one 1 */ : 2U << 8 /* two 0s */;
    const uint32_t first = (header & 0x1FFFFU) << CRC_BITS | first_after_header(data, crc, length);
    const uint32_t stuffed = send_bytes(wire, &state, first, 4);
    return stuffed + send_bytes(wire, &state, data << CRC_BITS | crc, length);
}

uint32_t sim_frame_stuff_bits(const sim_wire_t *wire, const tumble_can_frame_t *frame)
{
    if (frame->length == TUMBLE_CAN_MAX_BYTES) { /* nearly all frames: unrolled */
        return stuff_bits_of(wire, frame, TUMBLE_CAN_MAX_BYTES);
    }
    return stuff_bits_of(wire, frame, frame->length);
}

uint32_t sim_frame_bits(const sim_wire_t *wire, const tumble_can_frame_t *frame)
{
    return HEADER_BITS + 8U * frame->length + CRC_BITS + TRAILER_BITS + SIM_INTERFRAME_BITS +
           sim_frame_stuff_bits(wire, frame);
}
