/* Lets another language drive the encoder and the receiver of the block frames: one request a line on stdin, one answer
 * a line on stdout.
 *
 *     encode x y z counter timestamp status temperature   ->   id data id data     (hexadecimal)
 *     receive id data                                     ->   event [x y z counter timestamp status temperature]
 */
#include "sample/block_frames.h"
#include "simulation/block_encode.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define LINE_BYTES 256

static tumble_block_receiver_t receiver;

static void print_frame(const tumble_can_frame_t *frame)
{
    printf("%03X ", (unsigned)frame->id);
    for (int i = 0; i < frame->length; i++) {
        printf("%02X", (unsigned)frame->data[i]);
    }
}

static int encode(const char *line)
{
    tumble_block_sample_t sample = {0};
    int32_t *counts = sample.raw.counts;
    const char *format = "encode %" SCNd32 " %" SCNd32 " %" SCNd32 " %" SCNu16 " %" SCNu16 " %" SCNu8 " %" SCNd8;
    const int fields = sscanf(line, format, &counts[0], &counts[1], &counts[2], &sample.raw.counter,
                              &sample.timestamp_ms, &sample.raw.status, &sample.temperature_half_c);
    sim_block_frames_t frames;
    if (fields != 7) {
        return 1;
    }
    sim_block_encode(&sample, &frames);
    print_frame(&frames.xy);
    printf(" ");
    print_frame(&frames.z);
    printf("\n");
    return 0;
}

static int receive(const char *line)
{
    static const char *const names[] = {"other", "half", "sample", "repeated", "reordered", "corrupted"};
    unsigned id = 0;
    char hex[2 * TUMBLE_CAN_MAX_BYTES + 1] = "";
    if (sscanf(line, "receive %x %16s", &id, hex) < 1) {
        return 1;
    }
    tumble_can_frame_t frame = {.id = (uint16_t)id, .length = (uint8_t)(strlen(hex) / 2U)};
    for (size_t i = 0; i < frame.length; i++) {
        unsigned byte = 0;
        if (sscanf(&hex[2U * i], "%2x", &byte) != 1) {
            return 1;
        }
        frame.data[i] = (uint8_t)byte;
    }
    tumble_block_sample_t sample;
    const tumble_block_event_t event = tumble_block_receive(&receiver, &frame, &sample);
    printf("%s", names[event]);
    if (event == TUMBLE_BLOCK_SAMPLE) {
        printf(" %" PRId32 " %" PRId32 " %" PRId32 " %u %u %u %d", sample.raw.counts[0], sample.raw.counts[1],
               sample.raw.counts[2], (unsigned)sample.raw.counter, (unsigned)sample.timestamp_ms,
               (unsigned)sample.raw.status, (int)sample.temperature_half_c);
    }
    printf("\n");
    return 0;
}

int main(void)
{
    char line[LINE_BYTES];
    while (fgets(line, sizeof line, stdin) != NULL) {
        const int result = (strncmp(line, "encode", 6) == 0) ? encode(line) : receive(line);
        if (result != 0) {
            (void)fprintf(stderr, "malformed request: %s", line);
            return 2;
        }
    }
    return 0;
}
