/* campaign_report.h - the lines and the summary of a campaign (campaign.h). */
#ifndef TUMBLE_BENCH_CAMPAIGN_REPORT_H
#define TUMBLE_BENCH_CAMPAIGN_REPORT_H

#include "bench/options.h"
#include "bench/record.h"

#include <stdint.h>
#include <stdio.h>

typedef struct {
    uint64_t runs;
    uint64_t known;
    uint64_t passed;
    uint64_t failed; /* gravity check */
    uint64_t faulty;
    uint64_t reasons[TUMBLE_REASON_COUNT];
    uint64_t frames;
    uint64_t virtual_us;
    double sum[TUMBLE_COEFFICIENTS]; /* of estimate less truth */
    double square_sum[TUMBLE_COEFFICIENTS];
    double wall_s;
    double cpu_s;
} bench_statistics_t;

void bench_statistics_add(bench_statistics_t *statistics, const bench_record_t *record);
void bench_campaign_line(const bench_record_t *record, bool with_means, FILE *out);
void bench_campaign_summary(const bench_statistics_t *statistics, const bench_options_t *options, FILE *out);

#endif
