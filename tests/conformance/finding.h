/* finding.h - what a check of the suite finds (private to it). */
#ifndef TUMBLE_TESTS_FINDING_H
#define TUMBLE_TESTS_FINDING_H

#include "conformance.h"

#include <stddef.h>

/* What is wrong, or why the check cannot be done: null, or a sentence. Both null: all is well. */
typedef struct {
    const char *wrong;
    const char *skipped;
} finding_t;

static const finding_t GOOD = {NULL, NULL};

static inline finding_t wrong(const char *what)
{
    return (finding_t){.wrong = what};
}

static inline finding_t skipped(const char *why)
{
    return (finding_t){.skipped = why};
}

typedef struct {
    const char *name;
    finding_t (*check)(const conformance_bench_t *bench);
} check_t;

/* Returns whether it has failed. */
static inline bool report_finding(const conformance_bench_t *bench, const char *name, finding_t finding)
{
    if (finding.wrong != NULL) {
        bench->report(bench->context, name, CONFORMANCE_FAILED, finding.wrong);
    } else if (finding.skipped != NULL) {
        bench->report(bench->context, name, CONFORMANCE_SKIPPED, finding.skipped);
    } else {
        bench->report(bench->context, name, CONFORMANCE_PASSED, NULL);
    }
    return finding.wrong != NULL;
}

#endif
