#include "bench/config_prepare.h"

#include "bench/config_file.h"
#include "bench/gain_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static bool is_toml(const char *path)
{
    const char *const end = strrchr(path, '.');
    return end != NULL && strcmp(end, ".toml") == 0;
}

static void complain(const char *program, const char *name, const bench_mistake_t *mistake)
{
    if (is_toml(name)) {
        (void)fprintf(stderr, "%s: %s: looks like a stand file; a scenario file is wanted (docs/real-bus.md)\n",
                      program, name);
    } else if (mistake->line > 0U) {
        (void)fprintf(stderr, "%s: %s:%u: %s\n", program, name, mistake->line, mistake->what);
    } else {
        (void)fprintf(stderr, "%s: %s: %s\n", program, name, mistake->what);
    }
}

static bool read_scenario(bench_config_t *config, const char *path, const char *program)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    const char *const name = is_stdin ? "standard input" : path;
    FILE *const file = is_stdin ? stdin : fopen(path, "r");
    bench_mistake_t mistake = {0};
    if (file == NULL) {
        (void)fprintf(stderr, "%s: %s: %s\n", program, name, strerror(errno));
        return false;
    }
    const bool good = bench_config_read(config, file, &mistake);
    if (!good) {
        complain(program, name, &mistake);
    }
    if (!is_stdin) {
        (void)fclose(file);
    }
    return good;
}

static bool read_gains(bench_config_t *config, const char *path, const char *program)
{
    const char *const wrong = (path != NULL) ? bench_gain_file_read(path, &config->gains) : NULL;
    if (wrong != NULL) {
        (void)fprintf(stderr, "%s: %s: %s\n", program, path, wrong);
    }
    return wrong == NULL;
}

/* `config` has its defaults. */
static bool prepare(bench_config_t *config, const char *path, const char *gain_record, const char *program)
{
    if (path != NULL && !read_scenario(config, path, program)) {
        return false;
    }
    if (!read_gains(config, gain_record, program)) {
        return false;
    }
    const char *wrong = bench_config_complete(config);
    wrong = (wrong != NULL) ? wrong : bench_config_refused(config);
    if (wrong != NULL) {
        (void)fprintf(stderr, "%s: %s: %s\n", program, (path != NULL) ? path : "the defaults", wrong);
    }
    return wrong == NULL;
}

bool bench_config_prepare(bench_config_t *config, const char *path, const char *gain_record, const char *program)
{
    bench_config_defaults(config);
    return prepare(config, path, gain_record, program);
}

bool bench_config_prepare_stand(bench_config_t *config, const char *path, const char *program)
{
    bench_config_defaults(config);
    config->present.navcomp = false;
    const bool good = prepare(config, path, NULL, program);
    config->present.navcomp = false; /* whatever the file says */
    return good;
}
