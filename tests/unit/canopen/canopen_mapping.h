/* canopen_mapping.h - writing PDO parameters of the fixture's node as SDO would, for the tests of PDOs. */
#ifndef TUMBLE_TESTS_CANOPEN_MAPPING_H
#define TUMBLE_TESTS_CANOPEN_MAPPING_H

#include "canopen_fixture.h"

static inline void write32(uint16_t index, uint8_t sub, uint32_t value, uint32_t wanted)
{
    uint8_t bytes[4];
    uint8_t size = (((index & 0x0200U) == 0U) && (sub >= 2U)) ? ((sub == 2U) ? 1U : 2U) : ((sub == 0U) ? 1U : 4U);

    tumble_put_u32(bytes, value);
    TEST_ASSERT_EQUAL_HEX32(wanted, tumble_node_write(&at.node, index, sub, bytes, size));
}

#define accepted(index, sub, value) write32(index, sub, value, TUMBLE_ABORT_NONE)

static inline uint32_t read32(uint16_t index, uint8_t sub)
{
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    uint8_t size;
    uint32_t value = 0;

    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, tumble_node_read(&at.node, index, sub, bytes, &size));
    for (uint8_t i = 0; i < size; i++) {
        value |= (uint32_t)bytes[i] << (8U * i);
    }
    return value;
}

/* Receive PDO 1: 2005h (u16) and 2003h (i32) on 0x205. */
static inline void map_receive(void)
{
    accepted(0x1400, 1, 0x80000205U);
    accepted(0x1600, 0, 0);
    accepted(0x1600, 1, 0x20050010U);
    accepted(0x1600, 2, 0x20030020U);
    accepted(0x1600, 0, 2);
    accepted(0x1400, 1, 0x205);
}

/* Transmit PDO 1: 2005h and 2003h on 0x185. */
static inline void map_transmit(uint16_t inhibit_100us, uint16_t event_ms)
{
    accepted(0x1800, 1, 0xC0000185U);
    accepted(0x1800, 2, 254);
    accepted(0x1800, 3, inhibit_100us);
    accepted(0x1800, 5, event_ms);
    accepted(0x1A00, 0, 0);
    accepted(0x1A00, 1, 0x20050010U);
    accepted(0x1A00, 2, 0x20030020U);
    accepted(0x1A00, 0, 2);
    accepted(0x1800, 1, 0x40000185U);
}

#endif
