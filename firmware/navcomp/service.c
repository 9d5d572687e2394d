#include "navcomp/service.h"

#include "navcomp/navcomp_internal.h"

#define US_PER_S 1000000U
#define LEVEL_SERVICE 1U

static_assert(TUMBLE_SERVICE_S < 4000U, "its microseconds fit 32 bits");

bool tumble_service_is_open(const tumble_navcomp_t *navcomp)
{
    return navcomp->service_until_us != 0U;
}

uint16_t tumble_service_left_s(const tumble_navcomp_t *navcomp)
{
    const uint64_t until_us = navcomp->service_until_us;
    const uint32_t left_us = (until_us > navcomp->stepped_us) ? (uint32_t)(until_us - navcomp->stepped_us) : 0U;
    return (uint16_t)((left_us + (US_PER_S - 1U)) / US_PER_S);
}

uint32_t tumble_service_runs(const tumble_navcomp_t *navcomp)
{
    return navcomp->run_number;
}

static void show(tumble_navcomp_t *navcomp)
{
    tumble_pdo_trigger(&navcomp->node.pdos, TUMBLE_SERVICE_PDO);
    navcomp->due_us = 0; /* what is to be told waits for a step */
}

static void open(tumble_navcomp_t *navcomp)
{
    if (!tumble_service_is_open(navcomp)) {
        tumble_emcy_tell(&navcomp->node.emcy, TUMBLE_EMCY_SERVICE_LEVEL, TUMBLE_ERROR_MANUFACTURER, LEVEL_SERVICE);
        show(navcomp);
    }
    navcomp->service_until_us = navcomp->stepped_us + ((uint64_t)TUMBLE_SERVICE_S * US_PER_S);
}

static void close(tumble_navcomp_t *navcomp)
{
    if (tumble_service_is_open(navcomp)) {
        navcomp->service_until_us = 0;
        tumble_emcy_clear(&navcomp->node.emcy, TUMBLE_ERROR_MANUFACTURER);
        show(navcomp);
    }
}

tumble_status_t tumble_service_unlock(tumble_navcomp_t *navcomp, uint32_t key)
{
    if (key == 0U) {
        close(navcomp);
        return TUMBLE_OK;
    }
    if (key != TUMBLE_SERVICE_KEY) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_run_is_on(navcomp)) {
        return TUMBLE_E_STATE;
    }
    open(navcomp);
    return TUMBLE_OK;
}

void tumble_service_run_began(tumble_navcomp_t *navcomp)
{
    close(navcomp);
    tumble_count(&navcomp->run_number);
    show(navcomp);
}
