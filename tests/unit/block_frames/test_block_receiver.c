#include "block_frames_bench.h"

static tumble_block_event_t receive_xy(uint16_t counter)
{
    const sim_block_frames_t frames = frames_of(counter);
    return receive(&frames.xy);
}

static tumble_block_event_t receive_z(uint16_t counter)
{
    const sim_block_frames_t frames = frames_of(counter);
    return receive(&frames.z);
}

static void receive_sample(uint16_t counter)
{
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_xy(counter));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_SAMPLE, receive_z(counter));
}

/* Halves of two different samples never make one, for every pair of counters. */
static void test_halves_of_different_samples_never_pair(void)
{
    for (uint16_t a = 0; a < 256U; a++) {
        for (uint16_t b = 0; b < 256U; b++) {
            fresh_receiver();
            TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_xy(a));
            const bool same = ((a - b) % 128) == 0; /* seven bits of the counter travel in the second half */
            TEST_ASSERT_EQUAL(same ? TUMBLE_BLOCK_SAMPLE : TUMBLE_BLOCK_CORRUPTED, receive_z(b));
            TEST_ASSERT_EQUAL_UINT32(same ? 0 : 1, receiver.counters.wrong_pair);
        }
    }
}

static void test_a_mixed_pair_spoils_neither_the_sample_before_nor_the_one_after(void)
{
    receive_sample(10);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_xy(11));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive_z(12));
    receive_sample(13);
    TEST_ASSERT_EQUAL_UINT16(13, got.raw.counter);
    TEST_ASSERT_EQUAL_UINT32(2, receiver.counters.samples);
    TEST_ASSERT_EQUAL_UINT32(2, receiver.counters.lost);
}

static void test_an_even_frame_counter_is_corrupted_even_with_a_right_crc(void)
{
    sim_block_frames_t frames = frames_of(4);
    frames.z.data[3] = 8;
    frames.z.data[7] = tumble_block_frame_crc(&frames.z);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&frames.z));
    TEST_ASSERT_EQUAL_UINT32(1, receiver.counters.wrong_pair);
}

static void test_loss_of_halves_is_counted(void)
{
    receive_sample(0);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_xy(1)); /* its second half is lost */
    receive_sample(2);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_z(3)); /* its first half was lost */
    receive_sample(4);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_z(5));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_z(6));
    receive_sample(7);
    TEST_ASSERT_EQUAL_UINT32(4, receiver.counters.lone_halves);
    TEST_ASSERT_EQUAL_UINT32(4, receiver.counters.lost);
    TEST_ASSERT_EQUAL_UINT32(4, receiver.counters.samples);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.reordered);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.wrong_pair);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.wrong_crc);
}

static void test_loss_of_any_length_up_to_126_samples_widens_right(void)
{
    uint16_t counter = 0;
    uint32_t lost = 0;
    receive_sample(counter);
    for (uint16_t advance = 1; advance < 128U; advance++) {
        counter = (uint16_t)(counter + advance);
        lost += advance - 1U;
        receive_sample(counter);
        TEST_ASSERT_EQUAL_UINT16(counter, got.raw.counter);
        TEST_ASSERT_EQUAL_UINT32(lost, receiver.counters.lost);
    }
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.reordered);
}

static void test_every_step_back_is_reordering(void)
{
    for (uint16_t back = 1; back <= 128U; back++) {
        fresh_receiver();
        receive_sample(1000);
        TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_xy((uint16_t)(1000U - back)));
        const tumble_block_event_t event = receive_z((uint16_t)(1000U - back));
        TEST_ASSERT_EQUAL(TUMBLE_BLOCK_REORDERED, event);
        TEST_ASSERT_EQUAL_UINT32(1, receiver.counters.reordered);
        receive_sample(1001);
        TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.lost);
    }
}

static void test_repetition_of_halves_and_of_samples(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_xy(20));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_REPEATED, receive_xy(20));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_SAMPLE, receive_z(20));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_REPEATED, receive_z(20));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_REPEATED, receive_xy(20));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_REPEATED, receive_z(20));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_xy(21));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_REPEATED, receive_z(20)); /* late copy between the halves of the next */
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_SAMPLE, receive_z(21));
    TEST_ASSERT_EQUAL_UINT32(5, receiver.counters.repeated);
    TEST_ASSERT_EQUAL_UINT32(2, receiver.counters.samples);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.lost);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.lone_halves);
}

static void test_swapped_halves_are_reordered_not_taken(void)
{
    receive_sample(30);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_z(31));
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_REORDERED, receive_xy(31));
    receive_sample(32);
    TEST_ASSERT_EQUAL_UINT32(1, receiver.counters.reordered);
    TEST_ASSERT_EQUAL_UINT32(1, receiver.counters.lost);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.lone_halves);
}

static void test_the_widened_counter_wraps_at_16_bits(void)
{
    uint16_t expected = 0;
    for (uint32_t i = 0; i < 70000U; i++) {
        receive_sample((uint16_t)i);
        TEST_ASSERT_EQUAL_UINT16(expected, got.raw.counter);
        expected++;
    }
    TEST_ASSERT_EQUAL_UINT32(70000, receiver.counters.samples);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.lost);
}

static void test_the_first_counter_may_be_anything(void)
{
    for (uint16_t first = 0; first < 256U; first++) {
        fresh_receiver();
        receive_sample(first);
        TEST_ASSERT_EQUAL_UINT16(first, got.raw.counter);
        TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.lost);
    }
}

static void test_the_timestamp_takes_all_values_and_wraps(void)
{
    for (uint16_t i = 0; i < 2U * TUMBLE_TIMESTAMP_PERIOD_MS; i++) {
        tumble_block_sample_t sample = sample_of(i);
        sample.timestamp_ms = i % TUMBLE_TIMESTAMP_PERIOD_MS;
        sample.raw.status = (uint8_t)(i / 512U);
        sim_block_frames_t frames;
        sim_block_encode(&sample, &frames);
        (void)receive(&frames.xy);
        TEST_ASSERT_EQUAL(TUMBLE_BLOCK_SAMPLE, receive(&frames.z));
        TEST_ASSERT_EQUAL_UINT16(sample.timestamp_ms, got.timestamp_ms);
        TEST_ASSERT_EQUAL_UINT8(sample.raw.status, got.raw.status);
    }
}

static void test_a_restart_of_the_block_is_no_reordering(void)
{
    receive_sample(200);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_xy(201));
    tumble_block_receiver_restart(&receiver);
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_HALF, receive_z(201)); /* its first half belongs to the time before */
    receive_sample(150);
    TEST_ASSERT_EQUAL_UINT16(150, got.raw.counter);
    TEST_ASSERT_EQUAL_UINT32(0, receiver.counters.reordered);
    TEST_ASSERT_EQUAL_UINT32(2, receiver.counters.samples);
}

static void test_counters_stop_at_their_end(void)
{
    receiver.counters.wrong_crc = UINT32_MAX;
    sim_block_frames_t frames = frames_of(1);
    frames.xy.data[0] ^= 1U;
    TEST_ASSERT_EQUAL(TUMBLE_BLOCK_CORRUPTED, receive(&frames.xy));
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, receiver.counters.wrong_crc);
}

static const around_t around_each = {fresh_receiver, NULL};
