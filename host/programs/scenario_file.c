#include "scenario_file.h"

#include "arguments.h"
#include "world/config_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define MAX_LINE 1024

/* Of the largest record: rows of 3 x 36 doubles for twelve coefficients, two errors of the stand, six yaws and
 * seats. */
#define MAX_BYTES (240U + (24U * TUMBLE_MAX_POSITIONS * (14U + (3U * TUMBLE_MAX_YAWS))))

static bool is_toml(const char *path)
{
    const char *const end = strrchr(path, '.');
    return end != NULL && strcmp(end, ".toml") == 0;
}

static bool complain(bench_mistake_t *mistake, const char *what)
{
    (void)snprintf(mistake->what, sizeof mistake->what, "%s", what);
    return false;
}

static bool read_lines(bench_config_t *config, FILE *file, bench_mistake_t *mistake)
{
    bench_seen_t seen = {{false}};
    char line[MAX_LINE];
    for (mistake->line = 1; fgets(line, sizeof line, file) != NULL; mistake->line++) {
        if (strchr(line, '\n') == NULL && feof(file) == 0) {
            return complain(mistake, "longer than 1022 characters, or no text");
        }
        if (!bench_config_take(config, line, &seen, mistake)) {
            return false;
        }
    }
    if (ferror(file) != 0) {
        return complain(mistake, "cannot be read further");
    }
    return bench_config_check(config, &seen, mistake);
}

static bool read_scenario(bench_config_t *config, const char *path)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    const char *const name = is_stdin ? "standard input" : path;
    FILE *const file = is_stdin ? stdin : fopen(path, "r");
    bench_mistake_t mistake = {0};
    if (file == NULL) {
        return arguments_refuse(name, strerror(errno));
    }
    const bool good = read_lines(config, file, &mistake);
    if (!is_stdin) {
        (void)fclose(file);
    }
    if (!good && is_toml(name)) {
        return arguments_refuse(name, "looks like a stand file; a scenario file is wanted (docs/gateway.md)");
    }
    return good || arguments_refuse_line(name, mistake.line, mistake.what);
}

/* Into memory of its own (one record a process). What the bytes are is judged by the firmware. Null, or what went wrong. */
static const char *read_record(const char *path, tumble_optimal_source_t *source)
{
    static _Alignas(double) uint8_t memory[MAX_BYTES + 1U];
    FILE *const file = fopen(path, "rb");
    if (file == NULL) {
        return strerror(errno);
    }
    errno = 0;
    const size_t size = fread(memory, 1, sizeof memory, file);
    const int trouble = (ferror(file) != 0) ? errno : 0;
    (void)fclose(file);
    if (trouble != 0) {
        return strerror(trouble);
    }
    if (size > MAX_BYTES) {
        return "larger than any gain record";
    }
    source->record = memory;
    source->record_bytes = size;
    return NULL;
}

/* `config` has its defaults. */
static bool prepare(bench_config_t *config, const char *path, const char *gain_record)
{
    if (path != NULL && !read_scenario(config, path)) {
        return false;
    }
    const char *wrong = (gain_record != NULL) ? read_record(gain_record, &config->gains) : NULL;
    if (wrong != NULL) {
        return arguments_refuse(gain_record, wrong);
    }
    wrong = bench_config_complete(config);
    wrong = (wrong != NULL) ? wrong : bench_config_refused(config);
    return wrong == NULL || arguments_refuse((path != NULL) ? path : "the defaults", wrong);
}

bool bench_config_prepare(bench_config_t *config, const char *path, const char *gain_record)
{
    bench_config_defaults(config);
    return prepare(config, path, gain_record);
}

bool bench_config_prepare_stand(bench_config_t *config, const char *path)
{
    bench_config_defaults(config);
    config->present.navcomp = false;
    const bool good = prepare(config, path, NULL);
    config->present.navcomp = false; /* whatever the file says */
    return good;
}
