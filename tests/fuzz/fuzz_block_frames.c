/* Fuzzing the receiver of the block's frames: any frames in any order.
 *
 * In most frames the harness makes the checksum right, and in some the counter that ties the halves together: behind an
 * unrepaired checksum hardly a byte of the input would be looked at.
 */
#include "fuzz_input.h"
#include "sample/block_frames.h"
#include "simulation/block_encode.h"

const size_t fuzz_header_bytes = 0;
const size_t fuzz_record_bytes = 9; /* what kind of frame, and its bytes */

enum { ANOTHER_LENGTH = 0x0C, AS_IT_IS = 0x30, PAIRED = 0x40 }; /* bits of the first byte */

static tumble_can_frame_t frame_of(input_t *input, uint8_t first_counter)
{
    static const uint16_t ids[] = {TUMBLE_BLOCK_ID_XY, TUMBLE_BLOCK_ID_Z, TUMBLE_BLOCK_ID_XY, 0x684};
    const uint8_t kind = take(input);
    const bool other = (kind & ANOTHER_LENGTH) == ANOTHER_LENGTH;
    tumble_can_frame_t frame = {.id = ids[kind & 3U], .length = other ? (uint8_t)(kind >> 4U) : 8U};
    for (int i = 0; i < TUMBLE_CAN_MAX_BYTES; i++) {
        frame.data[i] = take(input);
    }
    if (((kind & PAIRED) != 0U) && (frame.id == TUMBLE_BLOCK_ID_Z)) {
        frame.data[3] = (uint8_t)((2U * first_counter) + 1U);
    }
    if ((kind & AS_IT_IS) != AS_IT_IS) {
        frame.data[7] = tumble_block_frame_crc(&frame);
    }
    return frame;
}

/* What a frame turned out to be and what was counted must agree, and a sample is what its two frames say. */
static void check(const tumble_block_counters_t *before, const tumble_block_counters_t *after,
                  tumble_block_event_t event)
{
    const uint32_t corrupted = (after->wrong_length - before->wrong_length) + (after->wrong_crc - before->wrong_crc) +
                               (after->wrong_pair - before->wrong_pair);
    require((after->samples - before->samples) == ((event == TUMBLE_BLOCK_SAMPLE) ? 1U : 0U), "samples");
    require((after->repeated - before->repeated) == ((event == TUMBLE_BLOCK_REPEATED) ? 1U : 0U), "repeated");
    require((after->reordered - before->reordered) == ((event == TUMBLE_BLOCK_REORDERED) ? 1U : 0U), "reordered");
    require(corrupted == ((event == TUMBLE_BLOCK_CORRUPTED) ? 1U : 0U), "corrupted");
    require((after->lost - before->lost) <= 126U, "lost");
    require((after->lost == before->lost) || (event == TUMBLE_BLOCK_SAMPLE), "only a sample shows a loss");
    require((after->lone_halves - before->lone_halves) <= ((event == TUMBLE_BLOCK_HALF) ? 1U : 0U), "lone halves");
}

/* Sent again, the sample is the same two frames: nothing of it was lost or made up. */
static void check_sample(const tumble_block_sample_t *sample, const tumble_can_frame_t *xy, const tumble_can_frame_t *z)
{
    sim_block_frames_t again;
    sim_block_encode(sample, &again);
    for (int i = 0; i < TUMBLE_CAN_MAX_BYTES; i++) {
        require(again.xy.data[i] == xy->data[i], "first half");
        require(again.z.data[i] == z->data[i], "second half");
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input_t input = {data, size};
    tumble_block_receiver_t receiver = {0};
    tumble_can_frame_t first = {0};
    uint16_t counter = 0;
    while (input.left >= fuzz_record_bytes) {
        const tumble_can_frame_t frame = frame_of(&input, first.data[6]);
        const tumble_block_counters_t before = receiver.counters;
        tumble_block_sample_t sample;
        const tumble_block_event_t event = tumble_block_receive(&receiver, &frame, &sample);
        check(&before, &receiver.counters, event);
        if ((event == TUMBLE_BLOCK_HALF) && (frame.id == TUMBLE_BLOCK_ID_XY)) {
            first = frame;
        }
        if (event == TUMBLE_BLOCK_SAMPLE) {
            const uint16_t lost = (uint16_t)(receiver.counters.lost - before.lost);
            check_sample(&sample, &first, &frame);
            const uint16_t next = (uint16_t)(counter + 1U + lost);
            require((before.samples == 0U) || (sample.raw.counter == next), "widened counter");
            counter = sample.raw.counter;
        }
    }
    return 0;
}
