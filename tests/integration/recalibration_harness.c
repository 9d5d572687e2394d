/* A navigation computer with a keeper, a drive and a block in virtual time, on stdin and stdout: what an outsider
 * can do to it by SDO, it does as on a bus.
 *
 * Lines in both directions: a CAN frame is ID#BYTES, hexadecimal ("601#4000200000000000"). After each frame that comes
 * in time goes on until the computer has answered it. Further lines in, each answered with "=passed" when it is done:
 *     !pass MS     let so many milliseconds pass
 *     !mount N     somebody mounts the block as mounting N (of the paper's schedule) wants it
 *     !drift NV    the biases of the block move by so many nanovolts
 *     !power       power fails and comes back; the memory keeps what it has
 * Out come the frames of the computer alone: its answers, heartbeats and process data. Ends with its input.
 */
#include "keeper_bench.h"

#include "navcomp/keeper.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define US_PER_MS UINT64_C(1000)
#define PATIENCE_US (UINT64_C(5000) * US_PER_MS)
#define SDO_ANSWER 0x581U

static tumble_stand_memory_t stand_memory;
static bool answered;

static void show(const tumble_can_frame_t *frame)
{
    const unsigned kind = frame->id & 0x780U;
    answered = answered || (frame->id == SDO_ANSWER);
    if ((((frame->id & 0x7FU) != 1U) && (frame->id != 0x6C1U)) || (kind == 0x600U) || (kind == 0U)) {
        return; /* to others */
    }
    printf("%03X#", frame->id);
    for (uint8_t i = 0; i < frame->length; i++) {
        printf("%02X", frame->data[i]);
    }
    printf("\n");
}

/* One event, as bench_event has it, but with somebody else on the bus and nobody at the bench. */
static void event(uint64_t end_us)
{
    tumble_can_frame_t frame;
    tumble_navcomp_step(&bench.navcomp);
    while (fake_port_take(&bench.fake, &frame)) {
        show(&frame);
        bench_hear(&bench, &frame);
    }
    bench_play(&bench);
    bench_go_on(&bench, end_us);
}

static void pass(uint64_t us)
{
    const uint64_t end_us = bench.fake.now_us + us;
    while (bench.fake.now_us < end_us) {
        event(end_us);
    }
}

static void take_frame(const char *line)
{
    const uint64_t end_us = bench.fake.now_us + PATIENCE_US;
    tumble_can_frame_t frame = {.id = (uint16_t)strtoul(line, NULL, 16)};
    const char *bytes = strchr(line, '#');
    unsigned byte;
    while ((bytes != NULL) && (frame.length < 8U) && (sscanf(bytes + 1 + (2 * frame.length), "%2x", &byte) == 1)) {
        frame.data[frame.length++] = (uint8_t)byte;
    }
    fake_port_give(&bench.fake, &frame);
    const bool wants_answer = (frame.id == 0x601U) && (frame.data[0] != 0x80U);
    answered = !wants_answer;
    do {
        event(end_us);
    } while (!answered && (bench.fake.now_us < end_us));
}

static void take_line(const char *line)
{
    int number = 0;
    if (line[0] != '!') {
        take_frame(line);
        return;
    }
    if (sscanf(line, "!pass %d", &number) == 1) {
        pass((uint64_t)number * US_PER_MS);
    } else if (sscanf(line, "!mount %d", &number) == 1) {
        bench.block.mounting = &tumble_schedule_paper.mountings[(number == 2) ? 1 : 0];
    } else if (sscanf(line, "!drift %d", &number) == 1) {
        drift((double)number * 1e-9);
    } else if (strncmp(line, "!power", 6) == 0) {
        keeper_power_cycle();
        pass(1000 * US_PER_MS);
    } else {
        (void)fprintf(stderr, "recalibration_harness: no such line: %s", line);
        exit(2);
    }
    printf("=passed\n");
}

int main(void)
{
    char line[200];
    keeper_prepare();
    settings.limits.flags = 0; /* whoever is outside says what the rules are */
    keeper_config.stand_view = tumble_stand_view;
    keeper_config.stand_memory = &stand_memory;
    bench_power_on(&bench);
    pass(1000 * US_PER_MS);
    (void)fflush(stdout);
    while (fgets(line, sizeof line, stdin) != NULL) {
        take_line(line);
        (void)fflush(stdout);
    }
    return 0;
}
