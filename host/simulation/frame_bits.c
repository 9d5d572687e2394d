#include "simulation/frame_bits.h"

#define HEADER_BITS 19 /* start of frame, 11 bits of identifier, RTR, IDE, r0, 4 bits of length: all up to the data */
#define CRC_BITS 15
#define TRAILER_BITS 10 /* CRC delimiter, acknowledge slot and delimiter, 7 bits end of frame */

#define AFTER_START 0U /* state after one 0, the start of frame */

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

/* Send the low `count` bits, highest first, from *state. Returns the stuff bits. */
static uint32_t send_bits(uint32_t *state, uint32_t bits, uint32_t count)
{
    uint32_t last = *state & 1U;
    uint32_t run = (*state >> 1) + 1U;
    uint32_t stuffed = 0;
    for (uint32_t left = count; left > 0U; left--) {
        const uint32_t bit = bits >> (left - 1U) & 1U;
        run = (bit == last) ? run + 1U : 1U;
        last = bit;
        if (run == 5U) {
            stuffed++;
            last ^= 1U;
            run = 1;
        }
    }
    *state = last | (run - 1U) << 1;
    return stuffed;
}

static void init_stuffing(sim_wire_t *wire, uint32_t state, uint32_t byte)
{
    uint32_t next = state;
    wire->stuffed[state << 8 | byte] = (uint8_t)send_bits(&next, byte, 8);
    wire->next[state << 8 | byte] = (uint16_t)(next << 8);
}

/* Start of frame, RTR, IDE and r0 are dominant (0). */
static uint32_t header_of(uint32_t id, uint32_t length)
{
    return id << 7 | length;
}

/* Zeros before the header change nothing: the CRC starts at 0. */
static uint32_t header_crc(const sim_wire_t *wire, uint32_t header, uint32_t length)
{
    return (uint32_t)wire->crc[length + 2U][header >> 16] ^ wire->crc[length + 1U][header >> 8 & 0xFFU] ^
           wire->crc[length][header & 0xFFU];
}

static void init_headers(sim_wire_t *wire)
{
    for (uint32_t id = 0; id <= TUMBLE_CAN_MAX_ID; id++) {
        const uint32_t header = header_of(id, TUMBLE_CAN_MAX_BYTES);
        uint32_t state = AFTER_START;
        sim_wire_header_t *const full = &wire->full[id];
        full->crc = (uint16_t)header_crc(wire, header, TUMBLE_CAN_MAX_BYTES);
        full->stuffed = (uint8_t)send_bits(&state, header >> 1, HEADER_BITS - 2);
        full->state = (uint16_t)(state << 8);
    }
}

void sim_wire_init(sim_wire_t *wire)
{
    init_crc(wire);
    for (uint32_t state = 0; state < 8U; state++) {
        for (uint32_t byte = 0; byte < 256U; byte++) {
            init_stuffing(wire, state, byte);
        }
    }
    init_headers(wire);
}

/* The data bytes as one number, the first one highest. */
static uint64_t data_of(const tumble_can_frame_t *frame)
{
    const uint8_t *const d = frame->data;
    const uint64_t all = (uint64_t)d[0] << 56 | (uint64_t)d[1] << 48 | (uint64_t)d[2] << 40 | (uint64_t)d[3] << 32 |
                         (uint64_t)d[4] << 24 | (uint64_t)d[5] << 16 | (uint64_t)d[6] << 8 | (uint64_t)d[7];
    return (frame->length == 0U) ? 0U : all >> (8U * (TUMBLE_CAN_MAX_BYTES - frame->length));
}

static inline uint32_t data_crc(const sim_wire_t *wire, uint64_t data, uint32_t length)
{
    uint32_t crc = 0;
    for (uint32_t i = 0; i < length; i++) {
        crc ^= wire->crc[i][data >> 8U * i & 0xFFU];
    }
    return crc;
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
static uint32_t stuff_bits_of(const sim_wire_t *wire, const tumble_can_frame_t *frame)
{
    const uint32_t length = frame->length;
    const uint32_t header = header_of(frame->id, length);
    const uint64_t data = data_of(frame);
    const uint32_t crc = header_crc(wire, header, length) ^ data_crc(wire, data, length);
    uint32_t state = ((header >> 17 & 1U) != 0U) ? 1U << 8 /* one 1 */ : 2U << 8 /* two 0s */;
    const uint32_t first = (header & 0x1FFFFU) << CRC_BITS | first_after_header(data, crc, length);
    const uint32_t stuffed = send_bytes(wire, &state, first, 4);
    return stuffed + send_bytes(wire, &state, data << CRC_BITS | crc, length);
}

/* The same for eight bytes of data: all of the header is known beforehand but for its last bit, which is 0; that one,
 * 64 bits of data and 15 of CRC are ten bytes. */
static uint32_t stuff_bits_of_full(const sim_wire_t *wire, const tumble_can_frame_t *frame)
{
    const sim_wire_header_t *const header = &wire->full[frame->id];
    const uint64_t data = data_of(frame);
    const uint32_t crc = header->crc ^ data_crc(wire, data, TUMBLE_CAN_MAX_BYTES);
    uint32_t state = header->state;
    const uint32_t stuffed = header->stuffed + send_bytes(wire, &state, data >> 49, 2);
    return stuffed + send_bytes(wire, &state, data << CRC_BITS | crc, 8);
}

uint32_t sim_frame_stuff_bits(const sim_wire_t *wire, const tumble_can_frame_t *frame)
{
    return (frame->length == TUMBLE_CAN_MAX_BYTES) ? stuff_bits_of_full(wire, frame) : stuff_bits_of(wire, frame);
}

uint32_t sim_frame_bits(const sim_wire_t *wire, const tumble_can_frame_t *frame)
{
    return HEADER_BITS + 8U * frame->length + CRC_BITS + TRAILER_BITS + SIM_INTERFRAME_BITS +
           sim_frame_stuff_bits(wire, frame);
}
