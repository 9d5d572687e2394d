/* The board hears whom it must hear. */
#include "configuration.h"
#include "suite.h"

static bool is_heard(uint16_t id)
{
    bool heard = false;
    for (uint8_t n = 0; n < zcu102_can.filter_count; n++) {
        const zcu102_can_filter_t *const filter = &zcu102_can.filters[n];
        heard = heard || ((id & filter->mask) == (filter->id & filter->mask));
    }
    return heard;
}

static void test_the_filters_let_in_what_is_needed_and_little_else(void)
{
    static const uint16_t NEEDED[] = {0x000, 0x082, 0x083, 0x182, 0x582, 0x601, 0x683, 0x693, 0x702, 0x703};
    uint32_t heard = 0;
    for (unsigned i = 0; i < sizeof NEEDED / sizeof NEEDED[0]; i++) {
        TEST_ASSERT_TRUE(is_heard(NEEDED[i]));
    }
    for (uint16_t id = 0; id <= TUMBLE_CAN_MAX_ID; id++) {
        heard += is_heard(id) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(22, heard);
}
