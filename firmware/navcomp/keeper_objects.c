/* Written by tools/objects/generate from tools/objects/keeper.toml: change it there. */
#include "navcomp/keeper_objects.h"

#include "navcomp/keeper.h"
#include "navcomp/keeper_values.h"

#include <assert.h>
#include <stddef.h>

static const tumble_limit_t limits[] = {
    {0.0, 1.0},
    {0.0, 3.0},
    {0.0, 35.0},
    {0.0, 63.0},
    {9.313225746154785e-10, 1.0},
    {1.0, 10.0},
    {1.0, 65535.0},
    {60.0, 4294967295.0},
};

/* How far behind another a member lies. */
#define BYTES_TO(type, from, member) (offsetof(type, member) - offsetof(type, from))

static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[0][0]) == 8U, "2023h:1");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[0][1]) == 8U, "2023h:2");
static_assert(BYTES_TO(tumble_uncertainty_t, k_v_per_g[0][0], k_v_per_g[0][1]) == 8U, "2023h:2");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[0][2]) == 8U, "2023h:3");
static_assert(BYTES_TO(tumble_uncertainty_t, k_v_per_g[0][0], k_v_per_g[0][2]) == 16U, "2023h:3");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[1][0]) == 8U, "2023h:4");
static_assert(BYTES_TO(tumble_uncertainty_t, k_v_per_g[0][0], k_v_per_g[1][0]) == 24U, "2023h:4");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[1][1]) == 8U, "2023h:5");
static_assert(BYTES_TO(tumble_uncertainty_t, k_v_per_g[0][0], k_v_per_g[1][1]) == 32U, "2023h:5");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[1][2]) == 8U, "2023h:6");
static_assert(BYTES_TO(tumble_uncertainty_t, k_v_per_g[0][0], k_v_per_g[1][2]) == 40U, "2023h:6");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[2][0]) == 8U, "2023h:7");
static_assert(BYTES_TO(tumble_uncertainty_t, k_v_per_g[0][0], k_v_per_g[2][0]) == 48U, "2023h:7");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[2][1]) == 8U, "2023h:8");
static_assert(BYTES_TO(tumble_uncertainty_t, k_v_per_g[0][0], k_v_per_g[2][1]) == 56U, "2023h:8");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->k_v_per_g[2][2]) == 8U, "2023h:9");
static_assert(BYTES_TO(tumble_uncertainty_t, k_v_per_g[0][0], k_v_per_g[2][2]) == 64U, "2023h:9");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->u0_v[0]) == 8U, "2024h:1");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->u0_v[1]) == 8U, "2024h:2");
static_assert(BYTES_TO(tumble_uncertainty_t, u0_v[0], u0_v[1]) == 8U, "2024h:2");
static_assert(sizeof(((const tumble_uncertainty_t *)NULL)->u0_v[2]) == 8U, "2024h:3");
static_assert(BYTES_TO(tumble_uncertainty_t, u0_v[0], u0_v[2]) == 16U, "2024h:3");
static_assert(sizeof(((const tumble_set_t *)NULL)->sequence) == 4U, "2100h:1");
static_assert(sizeof(((const tumble_set_t *)NULL)->restores) == 4U, "2100h:2");
static_assert(BYTES_TO(tumble_set_t, sequence, restores) == 4U, "2100h:2");
static_assert(sizeof(((const tumble_set_t *)NULL)->origin) == 1U, "2100h:3");
static_assert(sizeof(((const tumble_set_t *)NULL)->estimator) == 1U, "2100h:4");
static_assert(BYTES_TO(tumble_set_t, origin, estimator) == 1U, "2100h:4");
static_assert(sizeof(((const tumble_set_t *)NULL)->flags) == 2U, "2100h:5");
static_assert(sizeof(((const tumble_set_t *)NULL)->block_serial) == 24U, "2100h:6");
static_assert(sizeof(((const tumble_set_t *)NULL)->date_utc_s) == 8U, "2100h:7");
static_assert(sizeof(((const tumble_set_t *)NULL)->temperature_c) == 8U, "2100h:8");
static_assert(sizeof(((const tumble_set_t *)NULL)->gravity_m_s2) == 8U, "2100h:9");
static_assert(BYTES_TO(tumble_set_t, temperature_c, gravity_m_s2) == 8U, "2100h:9");
static_assert(sizeof(((const tumble_set_t *)NULL)->samples) == 4U, "2100h:10");
static_assert(sizeof(((const tumble_set_t *)NULL)->schedule_crc) == 4U, "2100h:11");
static_assert(sizeof(((const tumble_set_t *)NULL)->stand_crc) == 4U, "2100h:12");
static_assert(BYTES_TO(tumble_set_t, schedule_crc, stand_crc) == 4U, "2100h:12");
static_assert(sizeof(((const tumble_set_t *)NULL)->reasons) == 4U, "2100h:13");
static_assert(BYTES_TO(tumble_set_t, schedule_crc, reasons) == 8U, "2100h:13");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[0][0]) == 8U, "2104h:1");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[0][1]) == 8U, "2104h:2");
static_assert(BYTES_TO(tumble_set_t, coefficients.k_v_per_g[0][0], coefficients.k_v_per_g[0][1]) == 8U, "2104h:2");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[0][2]) == 8U, "2104h:3");
static_assert(BYTES_TO(tumble_set_t, coefficients.k_v_per_g[0][0], coefficients.k_v_per_g[0][2]) == 16U, "2104h:3");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[1][0]) == 8U, "2104h:4");
static_assert(BYTES_TO(tumble_set_t, coefficients.k_v_per_g[0][0], coefficients.k_v_per_g[1][0]) == 24U, "2104h:4");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[1][1]) == 8U, "2104h:5");
static_assert(BYTES_TO(tumble_set_t, coefficients.k_v_per_g[0][0], coefficients.k_v_per_g[1][1]) == 32U, "2104h:5");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[1][2]) == 8U, "2104h:6");
static_assert(BYTES_TO(tumble_set_t, coefficients.k_v_per_g[0][0], coefficients.k_v_per_g[1][2]) == 40U, "2104h:6");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[2][0]) == 8U, "2104h:7");
static_assert(BYTES_TO(tumble_set_t, coefficients.k_v_per_g[0][0], coefficients.k_v_per_g[2][0]) == 48U, "2104h:7");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[2][1]) == 8U, "2104h:8");
static_assert(BYTES_TO(tumble_set_t, coefficients.k_v_per_g[0][0], coefficients.k_v_per_g[2][1]) == 56U, "2104h:8");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.k_v_per_g[2][2]) == 8U, "2104h:9");
static_assert(BYTES_TO(tumble_set_t, coefficients.k_v_per_g[0][0], coefficients.k_v_per_g[2][2]) == 64U, "2104h:9");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.u0_v[0]) == 8U, "2108h:1");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.u0_v[1]) == 8U, "2108h:2");
static_assert(BYTES_TO(tumble_set_t, coefficients.u0_v[0], coefficients.u0_v[1]) == 8U, "2108h:2");
static_assert(sizeof(((const tumble_set_t *)NULL)->coefficients.u0_v[2]) == 8U, "2108h:3");
static_assert(BYTES_TO(tumble_set_t, coefficients.u0_v[0], coefficients.u0_v[2]) == 16U, "2108h:3");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[0][0]) == 8U, "210Ch:1");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[0][1]) == 8U, "210Ch:2");
static_assert(BYTES_TO(tumble_set_t, uncertainty.k_v_per_g[0][0], uncertainty.k_v_per_g[0][1]) == 8U, "210Ch:2");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[0][2]) == 8U, "210Ch:3");
static_assert(BYTES_TO(tumble_set_t, uncertainty.k_v_per_g[0][0], uncertainty.k_v_per_g[0][2]) == 16U, "210Ch:3");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[1][0]) == 8U, "210Ch:4");
static_assert(BYTES_TO(tumble_set_t, uncertainty.k_v_per_g[0][0], uncertainty.k_v_per_g[1][0]) == 24U, "210Ch:4");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[1][1]) == 8U, "210Ch:5");
static_assert(BYTES_TO(tumble_set_t, uncertainty.k_v_per_g[0][0], uncertainty.k_v_per_g[1][1]) == 32U, "210Ch:5");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[1][2]) == 8U, "210Ch:6");
static_assert(BYTES_TO(tumble_set_t, uncertainty.k_v_per_g[0][0], uncertainty.k_v_per_g[1][2]) == 40U, "210Ch:6");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[2][0]) == 8U, "210Ch:7");
static_assert(BYTES_TO(tumble_set_t, uncertainty.k_v_per_g[0][0], uncertainty.k_v_per_g[2][0]) == 48U, "210Ch:7");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[2][1]) == 8U, "210Ch:8");
static_assert(BYTES_TO(tumble_set_t, uncertainty.k_v_per_g[0][0], uncertainty.k_v_per_g[2][1]) == 56U, "210Ch:8");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.k_v_per_g[2][2]) == 8U, "210Ch:9");
static_assert(BYTES_TO(tumble_set_t, uncertainty.k_v_per_g[0][0], uncertainty.k_v_per_g[2][2]) == 64U, "210Ch:9");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.u0_v[0]) == 8U, "2110h:1");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.u0_v[1]) == 8U, "2110h:2");
static_assert(BYTES_TO(tumble_set_t, uncertainty.u0_v[0], uncertainty.u0_v[1]) == 8U, "2110h:2");
static_assert(sizeof(((const tumble_set_t *)NULL)->uncertainty.u0_v[2]) == 8U, "2110h:3");
static_assert(BYTES_TO(tumble_set_t, uncertainty.u0_v[0], uncertainty.u0_v[2]) == 16U, "2110h:3");
static_assert(sizeof(((const tumble_set_t *)NULL)->max_abs_fit_g) == 8U, "2114h:1");
static_assert(sizeof(((const tumble_set_t *)NULL)->max_abs_check_g) == 8U, "2114h:2");
static_assert(BYTES_TO(tumble_set_t, max_abs_fit_g, max_abs_check_g) == 8U, "2114h:2");
static_assert(sizeof(((const tumble_set_t *)NULL)->limit_g) == 8U, "2114h:3");
static_assert(BYTES_TO(tumble_set_t, max_abs_fit_g, limit_g) == 16U, "2114h:3");
static_assert(sizeof(((const tumble_set_t *)NULL)->closure_v) == 8U, "2114h:4");
static_assert(BYTES_TO(tumble_set_t, max_abs_fit_g, closure_v) == 24U, "2114h:4");
static_assert(sizeof(((const tumble_set_t *)NULL)->fit_positions) == 1U, "2114h:5");
static_assert(sizeof(((const tumble_set_t *)NULL)->check_positions) == 1U, "2114h:6");
static_assert(BYTES_TO(tumble_set_t, fit_positions, check_positions) == 1U, "2114h:6");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->utc_s) == 8U, "2120h:1");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->counter) == 4U, "2120h:2");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->age_s) == 4U, "2120h:3");
static_assert(BYTES_TO(tumble_keeper_state_t, counter, age_s) == 4U, "2120h:3");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->due_in_s) == 4U, "2120h:4");
static_assert(BYTES_TO(tumble_keeper_state_t, counter, due_in_s) == 8U, "2120h:4");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->inhibit_s) == 2U, "2120h:5");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->objections) == 2U, "2120h:6");
static_assert(BYTES_TO(tumble_keeper_state_t, inhibit_s, objections) == 2U, "2120h:6");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->verdict) == 1U, "2120h:7");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->status) == 1U, "2120h:8");
static_assert(BYTES_TO(tumble_keeper_state_t, verdict, status) == 1U, "2120h:8");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->due) == 1U, "2120h:9");
static_assert(BYTES_TO(tumble_keeper_state_t, verdict, due) == 2U, "2120h:9");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->resumable) == 1U, "2120h:10");
static_assert(BYTES_TO(tumble_keeper_state_t, verdict, resumable) == 3U, "2120h:10");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->inhibited) == 1U, "2120h:11");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->busy) == 1U, "2120h:12");
static_assert(BYTES_TO(tumble_keeper_state_t, inhibited, busy) == 1U, "2120h:12");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->has_proposal) == 1U, "2120h:13");
static_assert(BYTES_TO(tumble_keeper_state_t, inhibited, has_proposal) == 2U, "2120h:13");
static_assert(sizeof(((const tumble_keeper_state_t *)NULL)->has_factory) == 1U, "2120h:14");
static_assert(BYTES_TO(tumble_keeper_state_t, inhibited, has_factory) == 3U, "2120h:14");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->gravity_m_s2) == 8U, "2122h:1");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->interval_s) == 4U, "2122h:2");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->pause_s) == 4U, "2122h:3");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->temperature_samples) == 2U, "2122h:4");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->temperature_half_c) == 1U, "2122h:5");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->flags) == 1U, "2122h:6");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.coverage) == 4U, "2123h:1");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.flags) == 1U, "2123h:2");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[0]) == 4U, "2124h:1");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[1]) == 4U, "2124h:2");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[1]) == 4U, "2124h:2");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[2]) == 4U, "2124h:3");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[2]) == 8U, "2124h:3");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[3]) == 4U, "2124h:4");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[3]) == 12U, "2124h:4");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[4]) == 4U, "2124h:5");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[4]) == 16U, "2124h:5");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[5]) == 4U, "2124h:6");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[5]) == 20U, "2124h:6");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[6]) == 4U, "2124h:7");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[6]) == 24U, "2124h:7");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[7]) == 4U, "2124h:8");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[7]) == 28U, "2124h:8");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[8]) == 4U, "2124h:9");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[8]) == 32U, "2124h:9");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[9]) == 4U, "2124h:10");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[9]) == 36U, "2124h:10");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[10]) == 4U, "2124h:11");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[10]) == 40U, "2124h:11");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.uncertainty[11]) == 4U, "2124h:12");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.uncertainty[0], limits.uncertainty[11]) == 44U, "2124h:12");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[0]) == 4U, "2125h:1");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[1]) == 4U, "2125h:2");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[1]) == 4U,
              "2125h:2");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[2]) == 4U, "2125h:3");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[2]) == 8U,
              "2125h:3");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[3]) == 4U, "2125h:4");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[3]) == 12U,
              "2125h:4");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[4]) == 4U, "2125h:5");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[4]) == 16U,
              "2125h:5");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[5]) == 4U, "2125h:6");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[5]) == 20U,
              "2125h:6");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[6]) == 4U, "2125h:7");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[6]) == 24U,
              "2125h:7");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[7]) == 4U, "2125h:8");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[7]) == 28U,
              "2125h:8");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[8]) == 4U, "2125h:9");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[8]) == 32U,
              "2125h:9");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[9]) == 4U, "2125h:10");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[9]) == 36U,
              "2125h:10");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[10]) == 4U, "2125h:11");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[10]) == 40U,
              "2125h:11");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_month[11]) == 4U, "2125h:12");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_month[0], limits.drift_per_month[11]) == 44U,
              "2125h:12");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[0]) == 4U, "2126h:1");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[1]) == 4U, "2126h:2");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[1]) == 4U,
              "2126h:2");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[2]) == 4U, "2126h:3");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[2]) == 8U,
              "2126h:3");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[3]) == 4U, "2126h:4");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[3]) == 12U,
              "2126h:4");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[4]) == 4U, "2126h:5");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[4]) == 16U,
              "2126h:5");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[5]) == 4U, "2126h:6");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[5]) == 20U,
              "2126h:6");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[6]) == 4U, "2126h:7");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[6]) == 24U,
              "2126h:7");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[7]) == 4U, "2126h:8");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[7]) == 28U,
              "2126h:8");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[8]) == 4U, "2126h:9");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[8]) == 32U,
              "2126h:9");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[9]) == 4U, "2126h:10");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[9]) == 36U,
              "2126h:10");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[10]) == 4U, "2126h:11");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[10]) == 40U,
              "2126h:11");
static_assert(sizeof(((const tumble_keeper_settings_t *)NULL)->limits.drift_per_kelvin[11]) == 4U, "2126h:12");
static_assert(BYTES_TO(tumble_keeper_settings_t, limits.drift_per_kelvin[0], limits.drift_per_kelvin[11]) == 44U,
              "2126h:12");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->judged) == 4U, "2130h:1");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->committed) == 4U, "2130h:2");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, committed) == 4U, "2130h:2");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->held) == 4U, "2130h:3");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, held) == 8U, "2130h:3");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->repeated) == 4U, "2130h:4");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, repeated) == 12U, "2130h:4");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->accepted) == 4U, "2130h:5");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, accepted) == 16U, "2130h:5");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->discarded) == 4U, "2130h:6");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, discarded) == 20U, "2130h:6");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->rolled_back) == 4U, "2130h:7");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, rolled_back) == 24U, "2130h:7");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->failures) == 4U, "2130h:8");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, failures) == 28U, "2130h:8");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->checkpoints) == 4U, "2130h:9");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, checkpoints) == 32U, "2130h:9");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->resumed) == 4U, "2130h:10");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, resumed) == 36U, "2130h:10");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->not_resumed) == 4U, "2130h:11");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, not_resumed) == 40U, "2130h:11");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->inhibited) == 4U, "2130h:12");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, inhibited) == 44U, "2130h:12");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->self_started) == 4U, "2130h:13");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, self_started) == 48U, "2130h:13");
static_assert(sizeof(((const tumble_keeper_counters_t *)NULL)->refused) == 4U, "2130h:14");
static_assert(BYTES_TO(tumble_keeper_counters_t, judged, refused) == 52U, "2130h:14");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->store.counters.commits) == 4U, "2131h:1");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->store.counters.verify) == 4U, "2131h:2");
static_assert(BYTES_TO(tumble_keeper_t, store.counters.commits, store.counters.verify) == 4U, "2131h:2");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->store.counters.nv_errors) == 4U, "2131h:3");
static_assert(BYTES_TO(tumble_keeper_t, store.counters.commits, store.counters.nv_errors) == 8U, "2131h:3");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->store.counters.torn_at_boot) == 4U, "2131h:4");
static_assert(BYTES_TO(tumble_keeper_t, store.counters.commits, store.counters.torn_at_boot) == 12U, "2131h:4");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->history.verify) == 4U, "2131h:5");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->history.nv_errors) == 4U, "2131h:6");
static_assert(BYTES_TO(tumble_keeper_t, history.verify, history.nv_errors) == 4U, "2131h:6");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->history.torn) == 4U, "2131h:7");
static_assert(BYTES_TO(tumble_keeper_t, history.verify, history.torn) == 8U, "2131h:7");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->checkpoint.verify) == 4U, "2131h:8");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->checkpoint.nv_errors) == 4U, "2131h:9");
static_assert(BYTES_TO(tumble_keeper_t, checkpoint.verify, checkpoint.nv_errors) == 4U, "2131h:9");
static_assert(sizeof(((const tumble_keeper_t *)NULL)->checkpoint.torn) == 4U, "2131h:10");
static_assert(BYTES_TO(tumble_keeper_t, checkpoint.verify, checkpoint.torn) == 8U, "2131h:10");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[0]) == 8U, "2140h:1");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[1]) == 8U, "2140h:2");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[1]) == 8U, "2140h:2");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[2]) == 8U, "2140h:3");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[2]) == 16U, "2140h:3");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[3]) == 8U, "2140h:4");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[3]) == 24U, "2140h:4");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[4]) == 8U, "2140h:5");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[4]) == 32U, "2140h:5");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[5]) == 8U, "2140h:6");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[5]) == 40U, "2140h:6");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[6]) == 8U, "2140h:7");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[6]) == 48U, "2140h:7");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[7]) == 8U, "2140h:8");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[7]) == 56U, "2140h:8");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[8]) == 8U, "2140h:9");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[8]) == 64U, "2140h:9");
static_assert(sizeof(((const tumble_stand_view_t *)NULL)->number[9]) == 8U, "2140h:10");
static_assert(BYTES_TO(tumble_stand_view_t, number[0], number[9]) == 72U, "2140h:10");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->index) == 1U, "2150h:1");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->samples) == 4U, "2150h:2");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->mean_v[0]) == 8U, "2150h:3");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->mean_v[1]) == 8U, "2150h:4");
static_assert(BYTES_TO(tumble_position_view_t, mean_v[0], mean_v[1]) == 8U, "2150h:4");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->mean_v[2]) == 8U, "2150h:5");
static_assert(BYTES_TO(tumble_position_view_t, mean_v[0], mean_v[2]) == 16U, "2150h:5");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->standard_error_v[0]) == 8U, "2150h:6");
static_assert(BYTES_TO(tumble_position_view_t, mean_v[0], standard_error_v[0]) == 24U, "2150h:6");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->standard_error_v[1]) == 8U, "2150h:7");
static_assert(BYTES_TO(tumble_position_view_t, mean_v[0], standard_error_v[1]) == 32U, "2150h:7");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->standard_error_v[2]) == 8U, "2150h:8");
static_assert(BYTES_TO(tumble_position_view_t, mean_v[0], standard_error_v[2]) == 40U, "2150h:8");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->count) == 1U, "2151h:1");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->mounting) == 1U, "2151h:2");
static_assert(BYTES_TO(tumble_position_view_t, count, mounting) == 1U, "2151h:2");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->number) == 1U, "2151h:3");
static_assert(BYTES_TO(tumble_position_view_t, count, number) == 2U, "2151h:3");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->use) == 1U, "2151h:4");
static_assert(BYTES_TO(tumble_position_view_t, count, use) == 3U, "2151h:4");
static_assert(sizeof(((const tumble_position_view_t *)NULL)->angle_deg) == 8U, "2151h:5");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->sequence) == 4U, "2160h:3");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->date_utc_s) == 8U, "2160h:4");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->temperature_c) == 4U, "2160h:5");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->origin) == 1U, "2160h:6");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->estimator) == 1U, "2160h:7");
static_assert(BYTES_TO(tumble_history_entry_t, origin, estimator) == 1U, "2160h:7");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[0]) == 4U, "2161h:1");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[1]) == 4U, "2161h:2");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[1]) == 4U, "2161h:2");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[2]) == 4U, "2161h:3");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[2]) == 8U, "2161h:3");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[3]) == 4U, "2161h:4");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[3]) == 12U, "2161h:4");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[4]) == 4U, "2161h:5");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[4]) == 16U, "2161h:5");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[5]) == 4U, "2161h:6");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[5]) == 20U, "2161h:6");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[6]) == 4U, "2161h:7");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[6]) == 24U, "2161h:7");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[7]) == 4U, "2161h:8");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[7]) == 28U, "2161h:8");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[8]) == 4U, "2161h:9");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[8]) == 32U, "2161h:9");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[9]) == 4U, "2161h:10");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[9]) == 36U, "2161h:10");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[10]) == 4U, "2161h:11");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[10]) == 40U, "2161h:11");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->value[11]) == 4U, "2161h:12");
static_assert(BYTES_TO(tumble_history_entry_t, value[0], value[11]) == 44U, "2161h:12");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[0]) == 4U, "2162h:1");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[1]) == 4U, "2162h:2");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[1]) == 4U, "2162h:2");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[2]) == 4U, "2162h:3");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[2]) == 8U, "2162h:3");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[3]) == 4U, "2162h:4");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[3]) == 12U, "2162h:4");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[4]) == 4U, "2162h:5");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[4]) == 16U, "2162h:5");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[5]) == 4U, "2162h:6");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[5]) == 20U, "2162h:6");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[6]) == 4U, "2162h:7");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[6]) == 24U, "2162h:7");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[7]) == 4U, "2162h:8");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[7]) == 28U, "2162h:8");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[8]) == 4U, "2162h:9");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[8]) == 32U, "2162h:9");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[9]) == 4U, "2162h:10");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[9]) == 36U, "2162h:10");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[10]) == 4U, "2162h:11");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[10]) == 40U, "2162h:11");
static_assert(sizeof(((const tumble_history_entry_t *)NULL)->u[11]) == 4U, "2162h:12");
static_assert(BYTES_TO(tumble_history_entry_t, u[0], u[11]) == 44U, "2162h:12");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[0]) == 8U, "2163h:1");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[1]) == 8U, "2163h:2");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[1]) == 8U, "2163h:2");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[2]) == 8U, "2163h:3");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[2]) == 16U, "2163h:3");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[3]) == 8U, "2163h:4");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[3]) == 24U, "2163h:4");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[4]) == 8U, "2163h:5");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[4]) == 32U, "2163h:5");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[5]) == 8U, "2163h:6");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[5]) == 40U, "2163h:6");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[6]) == 8U, "2163h:7");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[6]) == 48U, "2163h:7");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[7]) == 8U, "2163h:8");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[7]) == 56U, "2163h:8");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[8]) == 8U, "2163h:9");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[8]) == 64U, "2163h:9");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[9]) == 8U, "2163h:10");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[9]) == 72U, "2163h:10");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[10]) == 8U, "2163h:11");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[10]) == 80U, "2163h:11");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->per_month[11]) == 8U, "2163h:12");
static_assert(BYTES_TO(tumble_trend_view_t, per_month[0], per_month[11]) == 88U, "2163h:12");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[0]) == 8U, "2164h:1");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[1]) == 8U, "2164h:2");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[1]) == 8U, "2164h:2");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[2]) == 8U, "2164h:3");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[2]) == 16U, "2164h:3");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[3]) == 8U, "2164h:4");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[3]) == 24U, "2164h:4");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[4]) == 8U, "2164h:5");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[4]) == 32U, "2164h:5");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[5]) == 8U, "2164h:6");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[5]) == 40U, "2164h:6");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[6]) == 8U, "2164h:7");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[6]) == 48U, "2164h:7");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[7]) == 8U, "2164h:8");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[7]) == 56U, "2164h:8");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[8]) == 8U, "2164h:9");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[8]) == 64U, "2164h:9");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[9]) == 8U, "2164h:10");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[9]) == 72U, "2164h:10");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[10]) == 8U, "2164h:11");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[10]) == 80U, "2164h:11");
static_assert(sizeof(((const tumble_trend_view_t *)NULL)->u_per_month[11]) == 8U, "2164h:12");
static_assert(BYTES_TO(tumble_trend_view_t, u_per_month[0], u_per_month[11]) == 88U, "2164h:12");
static_assert(sizeof(((const tumble_parameters_view_t *)NULL)->sequence) == 4U, "2170h:1");
static_assert(sizeof(((const tumble_parameters_view_t *)NULL)->refused) == 4U, "2170h:2");
static_assert(BYTES_TO(tumble_parameters_view_t, sequence, refused) == 4U, "2170h:2");
static_assert(sizeof(((const tumble_parameters_view_t *)NULL)->applied) == 4U, "2170h:3");
static_assert(BYTES_TO(tumble_parameters_view_t, sequence, applied) == 8U, "2170h:3");

static const tumble_entry_t entries[] = {
    /* Store parameters */
    {0x1010U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 0U, 0U, 0U, 0U},
    /* Restore default parameters */
    {0x1011U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 0U, 0U, 0U, 0U},
    /* Transmit PDO 4 parameter */
    {0x1803U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 0U, 0U},
    {0x1803U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 0U},
    {0x1803U, 3U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U, 0U, 0U},
    {0x1803U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 2U, 0U, 0U, 0U, 0U},
    /* Transmit PDO 4 mapping */
    {0x1A03U, 0U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 1U, 0U, 0U, 0U, 0U},
    {0x1A03U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMMUNICATION, 4U, 0U, 0U, 7U, 0U},
    /* u_K */
    {0x2023U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_uncertainty_t, k_v_per_g[0][0]), 8U, 0U},
    /* u_U0 */
    {0x2024U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_uncertainty_t, u0_v[0]), 2U, 0U},
    /* Active set, and 3 more */
    {0x2100U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_set_t, sequence), 1U, 3U},
    {0x2100U, 3U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_set_t, origin), 1U, 3U},
    {0x2100U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 2U, 0U, offsetof(tumble_set_t, flags), 0U, 3U},
    {0x2100U, 6U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 24U, 0U, offsetof(tumble_set_t, block_serial), 0U, 3U},
    {0x2100U, 7U, TUMBLE_TYPE_UNSIGNED64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_set_t, date_utc_s), 0U, 3U},
    {0x2100U, 8U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_set_t, temperature_c), 1U, 3U},
    {0x2100U, 10U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_set_t, samples), 0U, 3U},
    {0x2100U, 11U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_set_t, schedule_crc), 2U, 3U},
    /* Active set: K, and 3 more */
    {0x2104U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_set_t, coefficients.k_v_per_g[0][0]), 8U, 3U},
    /* Active set: U0, and 3 more */
    {0x2108U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_set_t, coefficients.u0_v[0]), 2U, 3U},
    /* Active set: u_K, and 3 more */
    {0x210CU, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_set_t, uncertainty.k_v_per_g[0][0]), 8U, 3U},
    /* Active set: u_U0, and 3 more */
    {0x2110U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_set_t, uncertainty.u0_v[0]), 2U, 3U},
    /* Active set: verification, and 3 more */
    {0x2114U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_set_t, max_abs_fit_g), 3U, 3U},
    {0x2114U, 5U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_set_t, fit_positions), 1U, 3U},
    /* Keeper */
    {0x2120U, 1U, TUMBLE_TYPE_UNSIGNED64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_keeper_state_t, utc_s), 0U, 0U},
    {0x2120U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_keeper_state_t, counter), 2U, 0U},
    {0x2120U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 2U, 0U, offsetof(tumble_keeper_state_t, inhibit_s), 1U, 0U},
    {0x2120U, 7U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_keeper_state_t, verdict), 3U, 0U},
    {0x2120U, 11U, TUMBLE_TYPE_BOOLEAN, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_keeper_state_t, inhibited), 3U, 0U},
    /* Host */
    {0x2121U, 1U, TUMBLE_TYPE_UNSIGNED64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 8U, 0U, 0U, 0U, 0U},
    {0x2121U, 2U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 2U, 0U, 0U, 0U, 0U},
    /* Recalibration */
    {0x2122U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_keeper_settings_t, gravity_m_s2), 0U, 0U},
    {0x2122U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_keeper_settings_t, interval_s), 0U, 0U},
    {0x2122U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 8U, offsetof(tumble_keeper_settings_t, pause_s), 0U, 0U},
    {0x2122U, 4U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 2U, 7U, offsetof(tumble_keeper_settings_t, temperature_samples), 0U, 0U},
    {0x2122U, 5U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_keeper_settings_t, temperature_half_c), 0U, 0U},
    {0x2122U, 6U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 1U, offsetof(tumble_keeper_settings_t, flags), 0U, 0U},
    /* Commit rules */
    {0x2123U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 6U, offsetof(tumble_keeper_settings_t, limits.coverage), 0U, 0U},
    {0x2123U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 2U, offsetof(tumble_keeper_settings_t, limits.flags), 0U, 0U},
    /* Uncertainty limits */
    {0x2124U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 5U, offsetof(tumble_keeper_settings_t, limits.uncertainty[0]), 11U, 0U},
    /* Drift limits per month */
    {0x2125U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 1U, offsetof(tumble_keeper_settings_t, limits.drift_per_month[0]), 11U, 0U},
    /* Drift limits per kelvin */
    {0x2126U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 4U, 1U, offsetof(tumble_keeper_settings_t, limits.drift_per_kelvin[0]), 11U, 0U},
    /* Keeper counters */
    {0x2130U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_keeper_counters_t, judged), 13U, 0U},
    /* Store counters */
    {0x2131U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_keeper_t, store.counters.commits), 3U, 0U},
    {0x2131U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_keeper_t, history.verify), 2U, 0U},
    {0x2131U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_keeper_t, checkpoint.verify), 2U, 0U},
    /* Stand seen */
    {0x2140U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_stand_view_t, number[0]), 9U, 0U},
    /* Position */
    {0x2150U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 3U, offsetof(tumble_position_view_t, index), 0U, 0U},
    {0x2150U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_position_view_t, samples), 0U, 0U},
    {0x2150U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_position_view_t, mean_v[0]), 5U, 0U},
    /* Schedule */
    {0x2151U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_position_view_t, count), 3U, 0U},
    {0x2151U, 5U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_position_view_t, angle_deg), 0U, 0U},
    /* History */
    {0x2160U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE,
     TUMBLE_HOME_COMPUTED, 1U, 4U, 0U, 0U, 0U},
    {0x2160U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ, TUMBLE_HOME_COMPUTED, 1U, 0U, 0U, 0U, 0U},
    {0x2160U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_history_entry_t, sequence), 0U, 0U},
    {0x2160U, 4U, TUMBLE_TYPE_UNSIGNED64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_history_entry_t, date_utc_s), 0U, 0U},
    {0x2160U, 5U, TUMBLE_TYPE_REAL32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_history_entry_t, temperature_c), 0U, 0U},
    {0x2160U, 6U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 1U, 0U, offsetof(tumble_history_entry_t, origin), 1U, 0U},
    /* History values */
    {0x2161U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_history_entry_t, value[0]), 11U, 0U},
    /* History uncertainties */
    {0x2162U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_history_entry_t, u[0]), 11U, 0U},
    /* Trend */
    {0x2163U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_trend_view_t, per_month[0]), 11U, 0U},
    /* Trend uncertainties */
    {0x2164U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 8U, 0U, offsetof(tumble_trend_view_t, u_per_month[0]), 11U, 0U},
    /* Parameters */
    {0x2170U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_ACCESS_READ,
     TUMBLE_HOME_COMPUTED, 4U, 0U, offsetof(tumble_parameters_view_t, sequence), 2U, 0U},
};

const tumble_object_table_t tumble_keeper_table = {
    .entries = entries,
    .limits = limits,
    .constants = NULL,
    .count = sizeof entries / sizeof entries[0],
};

static const tumble_pdo_setup_t receive[] = {
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
};
static_assert((sizeof receive / sizeof receive[0]) <= TUMBLE_MAX_RECEIVE_PDOS, "receive");

static const tumble_pdo_setup_t transmit[] = {
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
    {.cob_id = 0x80000000U, .type = 255U, .count = 0U, .inhibit_100us = 0U, .event_ms = 0U,
     .map = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U}},
    {.cob_id = 0x180U, .type = 255U, .count = 5U, .inhibit_100us = 200U, .event_ms = 1000U,
     .map = {0x20000008U, 0x20010008U, 0x20030108U, 0x20030308U, 0x20030720U, 0U, 0U, 0U}},
    {.cob_id = 0x680U, .type = 255U, .count = 4U, .inhibit_100us = 200U, .event_ms = 1000U,
     .map = {0x21200220U, 0x21200610U, 0x21200708U, 0x21200908U, 0U, 0U, 0U, 0U}},
};
static_assert((sizeof transmit / sizeof transmit[0]) <= TUMBLE_MAX_TRANSMIT_PDOS, "transmit");

const tumble_node_defaults_t tumble_keeper_defaults = {
    .receive = receive,
    .transmit = transmit,
    .receive_count = 2U,
    .transmit_count = 4U,
    .heartbeat_ms = 100U,
    .consumers = {0x000201F4U, 0x000301F4U, 0x00000000U, 0x00000000U},
    .on_error = 1U,
};

const tumble_saved_t tumble_keeper_saved[TUMBLE_KEEPER_SAVED] = {
    {0x2050U, 5U}, /* Configuration */
    {0x2122U, 6U}, /* Recalibration */
    {0x2123U, 2U}, /* Commit rules */
    {0x2124U, 12U}, /* Uncertainty limits */
    {0x2125U, 12U}, /* Drift limits per month */
    {0x2126U, 12U}, /* Drift limits per kelvin */
};
