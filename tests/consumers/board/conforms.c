/* conforms.c - the suite of tests/conformance on the ports of this board. Exit 1: a check has failed. */
#include "port.h"

#include <conformance.h>
#include <stdio.h>

static void report(void *context, const char *check, conformance_verdict_t verdict, const char *why)
{
    static const char *const VERDICTS[] = {"passed", "FAILED", "skipped"};
    (void)context;
    printf("%-8s %s%s%s\n", VERDICTS[verdict], check, (why != NULL) ? ": " : "", (why != NULL) ? why : "");
}

static const tumble_nv_t *reopen(void *context)
{
    (void)context;
    return &board_memory;
}

int main(void)
{
    const conformance_bench_t bench = {.a = &mine_ports[0],
                                       .b = &mine_ports[1],
                                       .pass = mine_pass,
                                       .burst = MINE_QUEUE,
                                       .send_limit = MINE_QUEUE + 1U,
                                       .transit_us = 1,
                                       .reopen = reopen,
                                       .report = report};
    return (conformance_run(&bench) == 0U) ? 0 : 1;
}
