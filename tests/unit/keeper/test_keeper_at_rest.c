/* 2152h, the measurement at rest, as an outsider uses it by SDO. */
#include "keeper_sdo.h"

#define AT_REST 0x2152
#define WANTED 1
#define TAKEN 2
#define MEAN 3
#define DEVIATION 6
#define SPOILT 9

static uint32_t want(uint16_t samples)
{
    uint8_t bytes[2];
    tumble_put_u16(bytes, samples);
    return sdo_write(AT_REST, WANTED, bytes, 2);
}

static void assert_numbers(uint32_t wanted, uint32_t taken, uint32_t spoilt)
{
    ASSERT_READS({AT_REST, WANTED, 2, wanted}, {AT_REST, TAKEN, 2, taken}, {AT_REST, SPOILT, 2, spoilt});
}

static void assert_nothing_told(void)
{
    for (uint8_t sub = MEAN; sub < SPOILT; sub++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(AT_REST, sub));
    }
}

static void assert_ended(void)
{
    assert_numbers(0, 0, 0);
    assert_nothing_told();
}

/* The block's pattern is -1, 0, 1 times the channel's number. */
static void test_what_the_block_puts_out_is_measured(void)
{
    double u_v[3];
    assert_ended();
    TEST_ASSERT_EQUAL_HEX32(0, want(30));
    assert_numbers(30, 0, 0);
    bench_pass(&bench, 0.15);
    TEST_ASSERT_UINT32_WITHIN(2, 15, read_number(AT_REST, TAKEN, 2));
    assert_nothing_told();
    bench_pass(&bench, 1.0);
    assert_numbers(30, 30, 0);
    scripted_block_outputs(&bench.block, scripted_drive_angle_deg(&bench.drive), u_v);
    for (uint8_t i = 0; i < 3U; i++) {
        const double counts = (double)lround(u_v[i] / 1e-6);
        ASSERT_SAME_DOUBLE(counts * 1e-6, read_f64(AT_REST, (uint8_t)(MEAN + i)));
        const double deviation_v = (i + 1) * sqrt(20.0 / 29.0) * 1e-6;
        TEST_ASSERT_DOUBLE_WITHIN(1e-18, deviation_v, read_f64(AT_REST, (uint8_t)(DEVIATION + i)));
    }
}

static void test_what_is_refused(void)
{
    const uint8_t three[3] = {9, 0, 0};
    TEST_ASSERT_EQUAL_HEX32(0, want(1000));
    bench_pass(&bench, 0.1);
    const uint32_t taken = read_number(AT_REST, TAKEN, 2);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, want(1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_SHORT, write_byte(AT_REST, WANTED, 9));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LONG, sdo_write(AT_REST, WANTED, three, 3));
    for (uint8_t sub = TAKEN; sub <= SPOILT; sub++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_READ_ONLY, sdo_write(AT_REST, sub, three, 2));
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX, refusal_of(AT_REST, SPOILT + 1));
    assert_numbers(1000, taken, 0);
    TEST_ASSERT_EQUAL_HEX32(0, want(0));
    assert_ended();
}

static void test_a_run_that_begins_ends_it(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, want(2));
    bench_pass(&bench, 0.1);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    assert_ended();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, want(2));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, want(0));
    bench_pass(&bench, 5.0);
    assert_ended();
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT));
    TEST_ASSERT_EQUAL_HEX32(0, want(2));
    bench_pass(&bench, 0.1);
    assert_numbers(2, 2, 0);
}

static void test_a_run_that_is_gone_on_with_ends_it(void)
{
    start_and_cut(3);
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL_HEX32(0, want(2));
    bench_pass(&bench, 0.1);
    assert_numbers(2, 2, 0);
    obey_for(0.1, TUMBLE_COMMAND_RESUME);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.resumed);
    assert_ended();
}

static void test_a_run_by_itself_ends_it(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, want(2));
    bench_pass(&bench, 0.1);
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2122, 6, TUMBLE_SETS_STARTS));
    assert_starts_after(1.0, 1);
    assert_ended();
}

static void test_a_reset_of_the_node_ends_it(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, want(2));
    bench_pass(&bench, 0.1);
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 1.0);
    assert_ended();
}

static unsigned frames;

/* Every tenth frame of the block is lost: with it, one sample in five. */
static bool lose(tumble_can_frame_t *frame)
{
    const bool mine = (frame->id == TUMBLE_BLOCK_ID_XY) || (frame->id == TUMBLE_BLOCK_ID_Z);
    frames += mine ? 1U : 0U;
    return !mine || ((frames % 10U) != 0U);
}

static bool corrupt(tumble_can_frame_t *frame)
{
    if (!lose(frame)) {
        frame->data[0] ^= 1U;
    }
    return true;
}

static void assert_spoilt(bool (*how)(tumble_can_frame_t *frame))
{
    bench_pass(&bench, 0.1);
    frames = 0;
    bench.spoil = how;
    TEST_ASSERT_EQUAL_HEX32(0, want(21));
    bench_pass(&bench, 1.0);
    bench.spoil = NULL;
    assert_numbers(21, 21, 5);
}

static void test_what_is_lost_or_corrupted_is_counted(void)
{
    assert_spoilt(lose);
    assert_spoilt(corrupt);
}

/* The receiver drops what comes again. */
static void test_frames_that_come_again_are_counted(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, want(50));
    bench_pass(&bench, 0.1);
    tumble_can_frame_t last = {0};
    for (size_t i = 0; i < bench.logged; i++) {
        last = (bench.log[i].frame.id == TUMBLE_BLOCK_ID_Z) ? bench.log[i].frame : last;
    }
    fake_port_give(&bench.fake, &last);
    bench_pass(&bench, 1.0);
    assert_numbers(50, 50, 1);
}

static void test_what_the_block_reports_is_counted(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, want(50));
    const uint32_t before = bench.block.sent;
    bench.block.status = TUMBLE_SAMPLE_TEMPERATURE;
    bench_pass(&bench, 0.1);
    bench.block.status = 0;
    const uint32_t spoilt = bench.block.sent - before;
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(9, spoilt);
    bench_pass(&bench, 1.0);
    assert_numbers(50, 50, spoilt);
}

static const around_t around_each = {keeper_sdo_power_on, NULL};
