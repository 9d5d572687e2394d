#include "keeper_sdo.h"

tumble_stand_memory_t stand_memory;

void keeper_sdo_power_on(void)
{
    memset(&stand_memory, 0, sizeof stand_memory);
    keeper_prepare();
    keeper_config.stand_view = tumble_stand_view;
    keeper_config.stand_memory = &stand_memory;
    power_on_for(1.0);
}

float read_f32(uint16_t index, uint8_t subindex)
{
    const uint32_t bits = read_number(index, subindex, 4);
    uint8_t bytes[4];
    tumble_put_u32(bytes, bits);
    return tumble_get_f32(bytes);
}

uint32_t write_f32(uint16_t index, uint8_t subindex, float value)
{
    uint8_t bytes[4];
    tumble_put_f32(bytes, value);
    return sdo_write(index, subindex, bytes, 4);
}

uint32_t write_and_wait(uint16_t index, uint32_t signature)
{
    uint8_t request[8] = {0x23, (uint8_t)(index & 0xFFU), (uint8_t)(index >> 8), 1};
    tumble_can_frame_t frame;
    tumble_put_u32(&request[4], signature);
    frame = fake_frame((uint16_t)(0x601U - sdo_server), 8, request);
    fake_port_give(&bench.fake, &frame);
    for (int steps = 0; steps < 2000; steps++) {
        tumble_navcomp_step(&bench.navcomp);
        while (fake_port_take(&bench.fake, &frame)) {
            if (frame.id == 0x581U - sdo_server) {
                TEST_ASSERT_EQUAL_HEX8((frame.data[0] == 0x80U) ? 0x80 : 0x60, frame.data[0]);
                return tumble_get_u32(&frame.data[4]);
            }
        }
        bench.fake.now_us += 1000;
    }
    TEST_FAIL_MESSAGE("no answer");
    return 1;
}
