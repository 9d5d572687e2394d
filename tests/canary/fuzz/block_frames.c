/* Planted: a gap in the sample counter is counted one too large where the counter wraps. */
#include "sample/block_frames.h"

tumble_block_event_t __real_tumble_block_receive(tumble_block_receiver_t *receiver, const tumble_can_frame_t *frame,
                                                 tumble_block_sample_t *sample);
tumble_block_event_t __wrap_tumble_block_receive(tumble_block_receiver_t *receiver, const tumble_can_frame_t *frame,
                                                 tumble_block_sample_t *sample);

tumble_block_event_t __wrap_tumble_block_receive(tumble_block_receiver_t *receiver, const tumble_can_frame_t *frame,
                                                 tumble_block_sample_t *sample)
{
    const uint32_t lost_before = receiver->counters.lost;
    const uint8_t counter_before = (uint8_t)(receiver->counter & 0xFFU);
    const tumble_block_event_t event = __real_tumble_block_receive(receiver, frame, sample);
    const uint8_t counter = (uint8_t)(receiver->counter & 0xFFU);
    if ((receiver->counters.lost != lost_before) && (counter < counter_before)) {
        receiver->counters.lost++;
    }
    return event;
}
