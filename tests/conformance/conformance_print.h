/* conformance_print.h - the suite's report for programs with a standard output, and what they return. */
#ifndef TUMBLE_TESTS_CONFORMANCE_PRINT_H
#define TUMBLE_TESTS_CONFORMANCE_PRINT_H

#include "conformance.h"

#include <stdio.h>

static inline void conformance_print(void *context, const char *check, conformance_verdict_t verdict, const char *why)
{
    static const char *const VERDICTS[] = {"passed", "FAILED", "skipped"};
    (void)context;
    (void)printf("%-8s %s%s%s\n", VERDICTS[verdict], check, (why != NULL) ? ": " : "", (why != NULL) ? why : "");
}

#endif
