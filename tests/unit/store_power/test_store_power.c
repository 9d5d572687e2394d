/* Power cuts, torn, dropped and repeated operations at every erase and program of every job of the store, the history and
 * the checkpoint: once in every geometry and way, twice in one geometry and some ways. The rest of the pairs is in
 * tests/integration/test_store_power.py, and so are the planted bugs that this must find.
 */
#include "store_campaign.h"
#include "support.h"

static void test_a_valid_set_is_always_found_and_never_a_mixed_one(void)
{
    const campaign_t campaign = run_campaign(false, NULL);
    TEST_ASSERT_EQUAL_STRING("", campaign.first);
    TEST_ASSERT_EQUAL_UINT64(0, campaign.bad);
    TEST_ASSERT_GREATER_THAN_UINT64(50000, campaign.cases);
}
