#define _POSIX_C_SOURCE 200809L

#include "folder.h"

#include "world/report.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define CANNOT_WRITE "cannot be written"

static const char *const FILES[] = {"run.csv", "bus.log", "bench.json"};
#define FILE_COUNT (sizeof FILES / sizeof FILES[0])

/* Path of a file in the folder, or of what it is called until it is complete. */
static bool name_file(const bench_folder_t *folder, const char *file, bool part, char path[PATH_MAX])
{
    const int length = snprintf(path, PATH_MAX, "%s/%s%s", folder->path, file, part ? ".part" : "");
    return length > 0 && length < PATH_MAX;
}

static FILE *begin_file(const bench_folder_t *folder, const char *file)
{
    char path[PATH_MAX];
    return name_file(folder, file, true, path) ? fopen(path, "w") : NULL;
}

static bool is_empty(const char *path)
{
    DIR *const directory = opendir(path);
    bool empty = directory != NULL;
    const struct dirent *entry;
    while (empty && (entry = readdir(directory)) != NULL) {
        empty = strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0;
    }
    if (directory != NULL) {
        (void)closedir(directory);
    }
    return empty;
}

static void forget(bench_folder_t *folder)
{
    for (int i = 0; i < TUMBLE_MAX_POSITIONS; i++) {
        free(folder->positions[i].samples);
        folder->positions[i] = (bench_recorded_t){0};
    }
}

/* Leave nothing behind. */
static void discard(bench_folder_t *folder)
{
    if (folder->log != NULL) {
        (void)fclose(folder->log);
        folder->log = NULL;
    }
    for (size_t i = 0; i < FILE_COUNT; i++) {
        char path[PATH_MAX];
        if (name_file(folder, FILES[i], true, path)) {
            (void)unlink(path);
        }
        if (name_file(folder, FILES[i], false, path)) {
            (void)unlink(path);
        }
    }
    if (folder->created) {
        (void)rmdir(folder->path);
    }
    forget(folder);
}

const char *bench_folder_open(bench_folder_t *folder, const char *path, const char *interface)
{
    memset(folder, 0, sizeof *folder);
    folder->path = path;
    folder->interface = interface;
    folder->created = mkdir(path, 0777) == 0;
    if (!folder->created && errno != EEXIST) {
        return strerror(errno);
    }
    if (!folder->created && !is_empty(path)) {
        return "is there already and is not an empty folder; remove it or choose another --out";
    }
    folder->log = begin_file(folder, "bus.log");
    if (folder->log == NULL) {
        discard(folder);
        return CANNOT_WRITE;
    }
    return NULL;
}

void bench_folder_frame(bench_folder_t *folder, uint64_t time_us, const tumble_can_frame_t *frame)
{
    static const char DIGITS[] = "0123456789ABCDEF";
    char data[2 * TUMBLE_CAN_MAX_BYTES + 1];
    for (size_t i = 0; i < frame->length; i++) {
        data[2U * i] = DIGITS[frame->data[i] >> 4];
        data[2U * i + 1U] = DIGITS[frame->data[i] & 0xFU];
    }
    data[2U * frame->length] = '\0';
    if (fprintf(folder->log, "(%010" PRIu64 ".%06" PRIu64 ") %s %03X#%s\n", time_us / 1000000U, time_us % 1000000U,
                folder->interface, (unsigned)frame->id, data) < 0) {
        folder->failed = true;
    }
}

/* Of all times that a timestamp can mean, the one nearest to the last one and what has passed here since. */
static uint64_t unwrapped_ms(const bench_folder_t *folder, uint64_t now_us, uint16_t timestamp_ms)
{
    const uint64_t period_ms = TUMBLE_TIMESTAMP_PERIOD_MS;
    if (!folder->timed) {
        return timestamp_ms;
    }
    const uint64_t most_ms = folder->block_ms + (now_us - folder->heard_us) / 1000U + period_ms / 2U;
    const uint64_t back_ms = (most_ms + period_ms - timestamp_ms) % period_ms;
    return (back_ms <= most_ms) ? most_ms - back_ms : timestamp_ms;
}

/* Ordinal 1: the position begins again, and what was recorded of it is void. */
void bench_folder_sample(bench_folder_t *folder, uint64_t now_us, tumble_taken_t taken,
                         const tumble_block_sample_t *sample)
{
    folder->block_ms = unwrapped_ms(folder, now_us, sample->timestamp_ms);
    folder->heard_us = now_us;
    folder->timed = true;
    bench_recorded_t *const recorded = &folder->positions[taken.index];
    if (taken.ordinal == 1U) {
        recorded->count = 0;
    }
    if (recorded->count == recorded->room) {
        const uint32_t room = (recorded->room == 0U) ? 64U : 2U * recorded->room;
        bench_timed_sample_t *const larger = realloc(recorded->samples, room * sizeof *larger);
        if (larger == NULL) {
            folder->failed = true;
            return;
        }
        recorded->samples = larger;
        recorded->room = room;
    }
    recorded->samples[recorded->count++] = (bench_timed_sample_t){*sample, folder->block_ms};
}

static void write_rows(const bench_recorded_t *recorded, const tumble_position_t *position, double v_per_count,
                       FILE *out)
{
    for (uint32_t n = 0; n < recorded->count; n++) {
        const tumble_block_sample_t *const sample = &recorded->samples[n].sample;
        const int32_t *const c = sample->raw.counts;
        (void)fprintf(out, "%d,%d,%.17g,%.17g,%.17g,%" PRId32 ",%" PRId32 ",%" PRId32 ",%d,%d,%.1f,%.3f\n",
                      position->mounting, position->number, c[0] * v_per_count, c[1] * v_per_count, c[2] * v_per_count,
                      c[0], c[1], c[2], sample->raw.counter, sample->timestamp_ms, sample->temperature_half_c / 2.0,
                      1e-3 * (double)recorded->samples[n].block_ms);
    }
}

/* Only what is in a mean that was kept. */
static void write_run(const bench_folder_t *folder, const bench_world_t *world, FILE *out)
{
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    (void)fputs("mounting,position,ux,uy,uz,cx,cy,cz,counter,timestamp,temperature,time_s\n", out);
    for (uint8_t i = 0; i < schedule->position_count; i++) {
        double mean_v[TUMBLE_CHANNELS];
        double error_v[TUMBLE_CHANNELS];
        if (bench_mean(world, i, mean_v, error_v)) {
            write_rows(&folder->positions[i], &schedule->positions[i], world->config->procedure.v_per_count, out);
        }
    }
}

static bool finish(FILE *file)
{
    const bool good = ferror(file) == 0;
    return fclose(file) == 0 && good;
}

static bool name_all(const bench_folder_t *folder)
{
    bool good = true;
    for (size_t i = 0; good && i < FILE_COUNT; i++) {
        char part[PATH_MAX];
        char whole[PATH_MAX];
        good = name_file(folder, FILES[i], true, part) && name_file(folder, FILES[i], false, whole) &&
               rename(part, whole) == 0;
    }
    return good;
}

const char *bench_folder_close(bench_folder_t *folder, const bench_world_t *world,
                               void (*document)(const void *context, FILE *out), const void *context)
{
    bool good = !folder->failed && finish(folder->log);
    folder->log = NULL;
    FILE *const run = begin_file(folder, "run.csv");
    if (run != NULL) {
        write_run(folder, world, run);
    }
    FILE *const json = begin_file(folder, "bench.json");
    if (json != NULL) {
        document(context, json);
    }
    good = run != NULL && finish(run) && good;
    good = json != NULL && finish(json) && good;
    if (!good || !name_all(folder)) {
        discard(folder);
        return CANNOT_WRITE;
    }
    forget(folder);
    return NULL;
}
