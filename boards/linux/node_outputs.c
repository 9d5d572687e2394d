#include "node.h"

#include "report.h"

#include <stdio.h>

void node_outputs_retry(node_t *node)
{
    outlet_retry(&node->documents);
    outlet_retry(&node->progress);
    node_log_unread(&node->log.unread_documents, node->documents.lost, "standard output");
    node_log_unread(&node->log.unread_progress, node->progress.lost, "progress");
}

int node_outputs_refuse(void)
{
    (void)fputs("tumble-node: standard output cannot be written\n", stderr);
    return BENCH_EXIT_FAULT;
}

int node_outputs_end(node_t *node, int code)
{
    const bool is_told = node->world.end == WORLD_LEFT || node->world.end == WORLD_INTERRUPTED;
    (void)outlet_end(&node->progress, true);
    return outlet_end(&node->documents, is_told) ? code : node_outputs_refuse();
}
