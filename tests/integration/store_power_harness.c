/* store_power_harness.c - the campaign of tests/lib/store_campaign.h as a program: `long`, every pair of faults; else the
 * short one, of one part if it is named. Exit 0: none bad; 1, and the first bad case on stderr.
 */
#include "store_campaign.h"

int main(int count, char **arguments)
{
    const bool is_long = count > 1 && strcmp(arguments[1], "long") == 0;
    const campaign_t campaign = run_campaign(is_long, (count > 1 && !is_long) ? arguments[1] : NULL);
    (void)printf("all: %lu cases, %lu bad\n", campaign.cases, campaign.bad);
    if (campaign.bad != 0U) {
        (void)fprintf(stderr, "%s\n", campaign.first);
    }
    return (campaign.bad == 0U && campaign.cases > 0U) ? 0 : 1;
}
