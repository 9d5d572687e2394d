/* memory.c - does the memory of examples/embed_board.c do what tumble/port.h says? Exit 1: a check has failed. */
#include "conformance.h"
#include "embed_board.h"

#include <stdio.h>

static void pass(void *context, uint32_t us) /* wait so long, if your memory takes its time */
{
    (void)context;
    (void)us;
}

static void report(void *context, const char *check, conformance_verdict_t verdict, const char *why)
{
    (void)context;
    printf("%s %s%s%s\n", (const char *[]){"passed ", "FAILED ", "skipped"}[verdict], check, why ? ": " : "",
           why ? why : "");
}

int main(void)
{
    const tumble_port_t port = {.nv = &board_memory};
    const conformance_bench_t bench = {.a = &port, .pass = pass, .report = report};
    return (conformance_run_nv(&bench) == 0U) ? 0 : 1;
}
