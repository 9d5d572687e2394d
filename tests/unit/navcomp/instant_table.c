#include "instant_table.h"

static tumble_status_t table_init(void *self, const tumble_stand_setup_t *setup)
{
    (void)setup;
    ((instant_table_t *)self)->state = (uint8_t)TUMBLE_STAND_READY;
    return TUMBLE_OK;
}

static void table_step(void *self, uint64_t now_us)
{
    (void)self;
    (void)now_us;
}

static uint64_t table_next_us(const void *self)
{
    (void)self;
    return UINT64_MAX;
}

static tumble_status_t table_move(void *self, double angle_deg)
{
    instant_table_t *table = self;
    table->angle_deg = angle_deg;
    table->state = (uint8_t)TUMBLE_STAND_IN_POSITION;
    return TUMBLE_OK;
}

static tumble_status_t table_home(void *self)
{
    return table_move(self, 0.0);
}

static void table_stop(void *self)
{
    (void)self;
}

static tumble_status_t table_clear_fault(void *self)
{
    (void)self;
    return TUMBLE_E_STAND_STATE;
}

static tumble_stand_state_t table_state(const void *self)
{
    return (tumble_stand_state_t)((const instant_table_t *)self)->state;
}

static tumble_stand_fault_t table_fault(const void *self)
{
    (void)self;
    return TUMBLE_STAND_FAULT_NONE;
}

static double table_angle_deg(const void *self)
{
    return ((const instant_table_t *)self)->angle_deg;
}

const tumble_stand_kind_t instant_table_kind = {
    .bytes = (uint16_t)sizeof(instant_table_t),
    .report_at = (uint16_t)offsetof(instant_table_t, report),
    TUMBLE_STAND_FUNCTIONS(table),
};
