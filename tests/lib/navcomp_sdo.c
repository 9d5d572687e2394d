#include "navcomp_sdo.h"

#include <stdio.h>

uint16_t sdo_server = TUMBLE_SDO_TO_FIRST;

void ask(const uint8_t request[8], uint8_t answer[8])
{
    tumble_can_frame_t frame = fake_frame((uint16_t)(0x601U - sdo_server), 8, request);
    fake_port_give(&bench.fake, &frame);
    for (int steps = 0; steps < 100; steps++) {
        tumble_navcomp_step(&bench.navcomp);
        while (fake_port_take(&bench.fake, &frame)) {
            if (frame.id == 0x581U - sdo_server) {
                TEST_ASSERT_EQUAL_UINT8(8, frame.length);
                memcpy(answer, frame.data, 8);
                return;
            }
            bench_hear(&bench, &frame);
        }
    }
    TEST_FAIL_MESSAGE("no answer");
}

uint32_t sdo_read(uint16_t index, uint8_t subindex, uint8_t bytes[64], uint8_t *size)
{
    uint8_t request[8] = {0x40};
    uint8_t answer[8];
    tumble_put_u16(&request[1], index);
    request[3] = subindex;
    ask(request, answer);
    if (answer[0] == 0x80U) {
        return tumble_get_u32(&answer[4]);
    }
    if ((answer[0] & 0x02U) != 0U) {
        *size = (uint8_t)(4U - ((answer[0] >> 2U) & 3U));
        memcpy(bytes, &answer[4], *size);
        return 0;
    }
    const uint8_t total = (uint8_t)tumble_get_u32(&answer[4]);
    uint8_t done = 0;
    for (uint8_t toggle = 0; done < total; toggle ^= 0x10U) {
        const uint8_t segment[8] = {(uint8_t)(0x60U | toggle)};
        ask(segment, answer);
        TEST_ASSERT_EQUAL_HEX8(toggle, answer[0] & 0xF0U);
        const uint8_t count = (uint8_t)(7U - ((answer[0] >> 1U) & 7U));
        memcpy(&bytes[done], &answer[1], count);
        done = (uint8_t)(done + count);
    }
    *size = total;
    return 0;
}

uint32_t sdo_write(uint16_t index, uint8_t subindex, const uint8_t *bytes, uint8_t size)
{
    uint8_t request[8] = {(size <= 4U) ? (uint8_t)(0x23U | ((4U - size) << 2U)) : 0x21U};
    uint8_t answer[8];
    tumble_put_u16(&request[1], index);
    request[3] = subindex;
    if (size <= 4U) {
        memcpy(&request[4], bytes, size);
    } else {
        request[4] = size;
    }
    ask(request, answer);
    for (uint8_t done = 0, toggle = 0; (size > 4U) && (done < size) && (answer[0] != 0x80U); toggle ^= 0x10U) {
        const uint8_t count = (uint8_t)(((size - done) < 7) ? (size - done) : 7);
        uint8_t segment[8] = {(uint8_t)(toggle | ((7U - count) << 1U) | (((done + count) == size) ? 1U : 0U))};
        memcpy(&segment[1], &bytes[done], count);
        ask(segment, answer);
        done = (uint8_t)(done + count);
    }
    return (answer[0] == 0x80U) ? tumble_get_u32(&answer[4]) : 0U;
}

uint32_t read_number(uint16_t index, uint8_t subindex, uint8_t expected_size)
{
    uint8_t bytes[64] = {0};
    uint8_t size = 0;
    TEST_ASSERT_EQUAL_HEX32(0, sdo_read(index, subindex, bytes, &size));
    TEST_ASSERT_EQUAL_UINT8(expected_size, size);
    return tumble_get_u32(bytes);
}

void assert_reads(const object_value_t *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        char which[20];
        (void)snprintf(which, sizeof which, "%04Xh:%u", rows[i].index, rows[i].subindex);
        const uint32_t value = read_number(rows[i].index, rows[i].subindex, rows[i].size);
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(rows[i].value, value, which);
    }
}

uint32_t refusal_of(uint16_t index, uint8_t subindex)
{
    uint8_t bytes[64];
    uint8_t size = 0;
    return sdo_read(index, subindex, bytes, &size);
}

uint64_t read_u64(uint16_t index, uint8_t subindex)
{
    uint8_t bytes[64];
    uint8_t size = 0;
    TEST_ASSERT_EQUAL_HEX32(0, sdo_read(index, subindex, bytes, &size));
    TEST_ASSERT_EQUAL_UINT8(8, size);
    return tumble_get_u64(bytes);
}

double read_f64(uint16_t index, uint8_t subindex)
{
    uint8_t bytes[8];
    tumble_put_u64(bytes, read_u64(index, subindex));
    return tumble_get_f64(bytes);
}

uint32_t write_byte(uint16_t index, uint8_t subindex, uint8_t value)
{
    return sdo_write(index, subindex, &value, 1);
}

uint32_t write_u32(uint16_t index, uint8_t subindex, uint32_t value)
{
    uint8_t bytes[4];
    tumble_put_u32(bytes, value);
    return sdo_write(index, subindex, bytes, 4);
}

uint32_t write_f64(uint16_t index, uint8_t subindex, double value)
{
    uint8_t bytes[8];
    tumble_put_f64(bytes, value);
    return sdo_write(index, subindex, bytes, 8);
}

/* True: it could be read. */
static bool answers(const tumble_entry_t *entry, uint16_t index, uint8_t subindex)
{
    uint8_t bytes[64];
    uint8_t size = 0;
    const uint32_t abort = sdo_read(index, subindex, bytes, &size);
    if (abort == 0U) {
        TEST_ASSERT_TRUE((size == entry->size) || (entry->type == TUMBLE_TYPE_VISIBLE_STRING));
    }
    if ((entry->access & TUMBLE_ACCESS_READ) != 0U) {
        char message[64];
        (void)snprintf(message, sizeof message, "%04Xh:%u cannot be read: abort code %08X", index, subindex,
                       (unsigned)abort);
        TEST_ASSERT_TRUE_MESSAGE((abort == 0U) || (abort == TUMBLE_ABORT_NO_DATA), message);
    } else {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_WRITE_ONLY, abort);
        TEST_ASSERT_EQUAL_HEX8(TUMBLE_ACCESS_WRITE, entry->access & 3U);
    }
    return abort == 0U;
}

unsigned count_answers(const tumble_object_table_t *table)
{
    unsigned read = 0;
    for (uint8_t i = 0; i < table->count; i++) {
        const tumble_entry_t *entry = &table->entries[i];
        for (unsigned object = 0; object <= entry->more_objects; object++) {
            for (unsigned sub = 0; sub <= entry->more_subindices; sub++) {
                read += answers(entry, (uint16_t)(entry->index + object), (uint8_t)(entry->subindex + sub)) ? 1U : 0U;
            }
        }
    }
    return read;
}

void assert_told(const double k[3][3], const double u0[3], uint16_t k_index, uint16_t u0_index)
{
    for (int c = 0; c < 9; c++) {
        TEST_ASSERT_TRUE(k[c / 3][c % 3] == read_f64(k_index, (uint8_t)(c + 1)));
    }
    for (int c = 0; c < 3; c++) {
        TEST_ASSERT_TRUE(u0[c] == read_f64(u0_index, (uint8_t)(c + 1)));
    }
}

uint32_t give_key(uint32_t key)
{
    return write_u32(0x2006, 1, key);
}

void unlock(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, give_key(TUMBLE_SERVICE_KEY));
}

uint32_t command(uint8_t number)
{
    return sdo_write(0x2002, 2, &number, 1);
}
