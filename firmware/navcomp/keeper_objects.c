/* Written by tools/objects/generate from tools/objects/keeper.toml: change it there. */
#include "navcomp/keeper_objects.h"

#include "canopen/table_checks.h"
#include "navcomp/keeper.h"
#include "sample/at_rest.h"

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

TUMBLE_IS_ARRAY("2023h:1", tumble_uncertainty_t, k_v_per_g, k_v_per_g[0][0], 8U, 9U);
TUMBLE_IS_ARRAY("2024h:1", tumble_uncertainty_t, u0_v, u0_v[0], 8U, 3U);
TUMBLE_HAS_SIZE("2025h:1", tumble_whole_work_t, chi_squared, 8U);
TUMBLE_FOLLOWS("2025h:2", tumble_whole_work_t, chi_squared, limit, 8U);
TUMBLE_FOLLOWS("2025h:3", tumble_whole_work_t, limit, misfit, 8U);
TUMBLE_HAS_SIZE("2025h:4", tumble_whole_work_t, freedom, 1U);
TUMBLE_HAS_SIZE("2026h:1", tumble_noise_t, noise_v[0], 8U);
TUMBLE_FOLLOWS("2026h:2", tumble_noise_t, noise_v[0], noise_v[1], 8U);
TUMBLE_FOLLOWS("2026h:3", tumble_noise_t, noise_v[1], noise_v[2], 8U);
TUMBLE_FOLLOWS("2026h:4", tumble_noise_t, noise_v[2], declared_v, 8U);
TUMBLE_HAS_SIZE("2026h:5", tumble_noise_t, above, 1U);
TUMBLE_FOLLOWS("2026h:6", tumble_noise_t, above, undithered, 1U);
TUMBLE_HAS_SIZE("2100h:1", tumble_set_t, sequence, 4U);
TUMBLE_FOLLOWS("2100h:2", tumble_set_t, sequence, restores, 4U);
TUMBLE_HAS_SIZE("2100h:3", tumble_set_t, origin, 1U);
TUMBLE_FOLLOWS("2100h:4", tumble_set_t, origin, estimator, 1U);
TUMBLE_HAS_SIZE("2100h:5", tumble_set_t, flags, 2U);
TUMBLE_HAS_SIZE("2100h:6", tumble_set_t, block_serial, 24U);
TUMBLE_HAS_SIZE("2100h:7", tumble_set_t, date_utc_s, 8U);
TUMBLE_HAS_SIZE("2100h:8", tumble_set_t, temperature_c, 8U);
TUMBLE_FOLLOWS("2100h:9", tumble_set_t, temperature_c, gravity_m_s2, 8U);
TUMBLE_HAS_SIZE("2100h:10", tumble_set_t, samples, 4U);
TUMBLE_HAS_SIZE("2100h:11", tumble_set_t, schedule_crc, 4U);
TUMBLE_FOLLOWS("2100h:12", tumble_set_t, schedule_crc, stand_crc, 4U);
TUMBLE_FOLLOWS("2100h:13", tumble_set_t, stand_crc, reasons, 4U);
TUMBLE_FOLLOWS("2100h:14", tumble_set_t, reasons, record_crc, 4U);
TUMBLE_HAS_SIZE("2100h:15", tumble_set_t, temperature_min_half_c, 1U);
TUMBLE_FOLLOWS("2100h:16", tumble_set_t, temperature_min_half_c, temperature_max_half_c, 1U);
TUMBLE_IS_ARRAY("2104h:1", tumble_set_t, coefficients.k_v_per_g, coefficients.k_v_per_g[0][0], 8U, 9U);
TUMBLE_IS_ARRAY("2108h:1", tumble_set_t, coefficients.u0_v, coefficients.u0_v[0], 8U, 3U);
TUMBLE_IS_ARRAY("210Ch:1", tumble_set_t, uncertainty.k_v_per_g, uncertainty.k_v_per_g[0][0], 8U, 9U);
TUMBLE_IS_ARRAY("2110h:1", tumble_set_t, uncertainty.u0_v, uncertainty.u0_v[0], 8U, 3U);
TUMBLE_HAS_SIZE("2114h:1", tumble_set_t, max_abs_fit_g, 8U);
TUMBLE_FOLLOWS("2114h:2", tumble_set_t, max_abs_fit_g, max_abs_check_g, 8U);
TUMBLE_FOLLOWS("2114h:3", tumble_set_t, max_abs_check_g, limit_g, 8U);
TUMBLE_FOLLOWS("2114h:4", tumble_set_t, limit_g, closure_v, 8U);
TUMBLE_HAS_SIZE("2114h:5", tumble_set_t, fit_positions, 1U);
TUMBLE_FOLLOWS("2114h:6", tumble_set_t, fit_positions, check_positions, 1U);
TUMBLE_HAS_SIZE("2120h:1", tumble_sets_state_t, utc_s, 8U);
TUMBLE_HAS_SIZE("2120h:2", tumble_sets_state_t, counter, 4U);
TUMBLE_FOLLOWS("2120h:3", tumble_sets_state_t, counter, age_s, 4U);
TUMBLE_FOLLOWS("2120h:4", tumble_sets_state_t, age_s, due_in_s, 4U);
TUMBLE_HAS_SIZE("2120h:5", tumble_sets_state_t, inhibit_s, 2U);
TUMBLE_FOLLOWS("2120h:6", tumble_sets_state_t, inhibit_s, objections, 2U);
TUMBLE_HAS_SIZE("2120h:7", tumble_sets_state_t, verdict, 1U);
TUMBLE_FOLLOWS("2120h:8", tumble_sets_state_t, verdict, status, 1U);
TUMBLE_FOLLOWS("2120h:9", tumble_sets_state_t, status, due, 1U);
TUMBLE_FOLLOWS("2120h:10", tumble_sets_state_t, due, resumable, 1U);
TUMBLE_HAS_SIZE("2120h:11", tumble_sets_state_t, inhibited, 1U);
TUMBLE_FOLLOWS("2120h:12", tumble_sets_state_t, inhibited, busy, 1U);
TUMBLE_FOLLOWS("2120h:13", tumble_sets_state_t, busy, has_proposal, 1U);
TUMBLE_FOLLOWS("2120h:14", tumble_sets_state_t, has_proposal, has_factory, 1U);
TUMBLE_HAS_SIZE("2120h:15", tumble_sets_state_t, more_objections, 2U);
TUMBLE_HAS_SIZE("2121h:1", tumble_sets_state_t, utc_s, 8U);
TUMBLE_HAS_SIZE("2121h:2", tumble_sets_state_t, inhibit_s, 2U);
TUMBLE_HAS_SIZE("2122h:1", tumble_sets_settings_t, gravity_m_s2, 8U);
TUMBLE_HAS_SIZE("2122h:2", tumble_sets_settings_t, interval_s, 4U);
TUMBLE_HAS_SIZE("2122h:3", tumble_sets_settings_t, pause_s, 4U);
TUMBLE_HAS_SIZE("2122h:4", tumble_sets_settings_t, temperature_samples, 2U);
TUMBLE_HAS_SIZE("2122h:5", tumble_sets_settings_t, temperature_half_c, 1U);
TUMBLE_HAS_SIZE("2122h:6", tumble_sets_settings_t, flags, 1U);
TUMBLE_HAS_SIZE("2123h:1", tumble_sets_settings_t, limits.coverage, 4U);
TUMBLE_HAS_SIZE("2123h:2", tumble_sets_settings_t, limits.flags, 1U);
TUMBLE_IS_ARRAY("2124h:1", tumble_sets_settings_t, limits.uncertainty, limits.uncertainty[0], 4U, 12U);
TUMBLE_IS_ARRAY("2125h:1", tumble_sets_settings_t, limits.drift_per_month, limits.drift_per_month[0], 4U, 12U);
TUMBLE_IS_ARRAY("2126h:1", tumble_sets_settings_t, limits.drift_per_kelvin, limits.drift_per_kelvin[0], 4U, 12U);
TUMBLE_HAS_SIZE("2130h:1", tumble_sets_counters_t, judged, 4U);
TUMBLE_FOLLOWS("2130h:2", tumble_sets_counters_t, judged, committed, 4U);
TUMBLE_FOLLOWS("2130h:3", tumble_sets_counters_t, committed, held, 4U);
TUMBLE_FOLLOWS("2130h:4", tumble_sets_counters_t, held, repeated, 4U);
TUMBLE_FOLLOWS("2130h:5", tumble_sets_counters_t, repeated, accepted, 4U);
TUMBLE_FOLLOWS("2130h:6", tumble_sets_counters_t, accepted, discarded, 4U);
TUMBLE_FOLLOWS("2130h:7", tumble_sets_counters_t, discarded, rolled_back, 4U);
TUMBLE_FOLLOWS("2130h:8", tumble_sets_counters_t, rolled_back, failures, 4U);
TUMBLE_FOLLOWS("2130h:9", tumble_sets_counters_t, failures, checkpoints, 4U);
TUMBLE_FOLLOWS("2130h:10", tumble_sets_counters_t, checkpoints, resumed, 4U);
TUMBLE_FOLLOWS("2130h:11", tumble_sets_counters_t, resumed, not_resumed, 4U);
TUMBLE_FOLLOWS("2130h:12", tumble_sets_counters_t, not_resumed, inhibited, 4U);
TUMBLE_FOLLOWS("2130h:13", tumble_sets_counters_t, inhibited, self_started, 4U);
TUMBLE_FOLLOWS("2130h:14", tumble_sets_counters_t, self_started, refused, 4U);
TUMBLE_HAS_SIZE("2131h:1", tumble_keeper_t, store.commits, 4U);
TUMBLE_FOLLOWS("2131h:2", tumble_keeper_t, store.commits, store.cells.verify, 4U);
TUMBLE_FOLLOWS("2131h:3", tumble_keeper_t, store.cells.verify, store.cells.nv_errors, 4U);
TUMBLE_FOLLOWS("2131h:4", tumble_keeper_t, store.cells.nv_errors, store.cells.torn, 4U);
TUMBLE_HAS_SIZE("2131h:5", tumble_keeper_t, history.cells.verify, 4U);
TUMBLE_FOLLOWS("2131h:6", tumble_keeper_t, history.cells.verify, history.cells.nv_errors, 4U);
TUMBLE_FOLLOWS("2131h:7", tumble_keeper_t, history.cells.nv_errors, history.cells.torn, 4U);
TUMBLE_HAS_SIZE("2131h:8", tumble_keeper_t, checkpoint.cells.verify, 4U);
TUMBLE_FOLLOWS("2131h:9", tumble_keeper_t, checkpoint.cells.verify, checkpoint.cells.nv_errors, 4U);
TUMBLE_FOLLOWS("2131h:10", tumble_keeper_t, checkpoint.cells.nv_errors, checkpoint.cells.torn, 4U);
TUMBLE_IS_ARRAY("2140h:1", tumble_stand_view_t, number, number[0], 8U, 10U);
TUMBLE_IS_ARRAY("2141h:1", tumble_inclinations_view_t, number, number[0], 8U, 14U);
TUMBLE_HAS_SIZE("2150h:1", tumble_position_view_t, index, 1U);
TUMBLE_HAS_SIZE("2150h:2", tumble_position_view_t, samples, 4U);
TUMBLE_HAS_SIZE("2150h:3", tumble_position_view_t, mean_v[0], 8U);
TUMBLE_FOLLOWS("2150h:4", tumble_position_view_t, mean_v[0], mean_v[1], 8U);
TUMBLE_FOLLOWS("2150h:5", tumble_position_view_t, mean_v[1], mean_v[2], 8U);
TUMBLE_FOLLOWS("2150h:6", tumble_position_view_t, mean_v[2], standard_error_v[0], 8U);
TUMBLE_FOLLOWS("2150h:7", tumble_position_view_t, standard_error_v[0], standard_error_v[1], 8U);
TUMBLE_FOLLOWS("2150h:8", tumble_position_view_t, standard_error_v[1], standard_error_v[2], 8U);
TUMBLE_HAS_SIZE("2151h:1", tumble_position_view_t, count, 1U);
TUMBLE_HAS_SIZE("2151h:2", tumble_position_view_t, mounting, 1U);
TUMBLE_FOLLOWS("2151h:3", tumble_position_view_t, mounting, number, 1U);
TUMBLE_FOLLOWS("2151h:4", tumble_position_view_t, number, use, 1U);
TUMBLE_HAS_SIZE("2151h:5", tumble_position_view_t, angle_deg, 8U);
TUMBLE_HAS_SIZE("2152h:1", tumble_at_rest_view_t, wanted, 2U);
TUMBLE_HAS_SIZE("2152h:2", tumble_at_rest_view_t, taken, 2U);
TUMBLE_HAS_SIZE("2152h:3", tumble_at_rest_view_t, mean_v[0], 8U);
TUMBLE_FOLLOWS("2152h:4", tumble_at_rest_view_t, mean_v[0], mean_v[1], 8U);
TUMBLE_FOLLOWS("2152h:5", tumble_at_rest_view_t, mean_v[1], mean_v[2], 8U);
TUMBLE_FOLLOWS("2152h:6", tumble_at_rest_view_t, mean_v[2], deviation_v[0], 8U);
TUMBLE_FOLLOWS("2152h:7", tumble_at_rest_view_t, deviation_v[0], deviation_v[1], 8U);
TUMBLE_FOLLOWS("2152h:8", tumble_at_rest_view_t, deviation_v[1], deviation_v[2], 8U);
TUMBLE_HAS_SIZE("2152h:9", tumble_at_rest_view_t, spoilt, 2U);
TUMBLE_HAS_SIZE("2160h:3", tumble_history_entry_t, sequence, 4U);
TUMBLE_HAS_SIZE("2160h:4", tumble_history_entry_t, date_utc_s, 8U);
TUMBLE_HAS_SIZE("2160h:5", tumble_history_entry_t, temperature_c, 4U);
TUMBLE_HAS_SIZE("2160h:6", tumble_history_entry_t, origin, 1U);
TUMBLE_FOLLOWS("2160h:7", tumble_history_entry_t, origin, estimator, 1U);
TUMBLE_IS_ARRAY("2161h:1", tumble_history_entry_t, value, value[0], 4U, 12U);
TUMBLE_IS_ARRAY("2162h:1", tumble_history_entry_t, u, u[0], 4U, 12U);
TUMBLE_IS_ARRAY("2163h:1", tumble_trend_view_t, per_month, per_month[0], 8U, 12U);
TUMBLE_IS_ARRAY("2164h:1", tumble_trend_view_t, u_per_month, u_per_month[0], 8U, 12U);
TUMBLE_HAS_SIZE("2170h:1", tumble_parameters_view_t, sequence, 4U);
TUMBLE_FOLLOWS("2170h:2", tumble_parameters_view_t, sequence, refused, 4U);
TUMBLE_FOLLOWS("2170h:3", tumble_parameters_view_t, refused, applied, 4U);

static const tumble_entry_t entries[] = {
    /* Store parameters */
    {0x1010U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 0U, 0U, 0U, 0U, TUMBLE_KEEPER_SOURCE_SAVE},
    /* Restore default parameters */
    {0x1011U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 0U, 0U, 0U, 0U, TUMBLE_KEEPER_SOURCE_LOAD},
    /* u_K */
    {0x2023U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 8U, offsetof(tumble_uncertainty_t, k_v_per_g[0][0]), TUMBLE_KEEPER_SOURCE_UNCERTAINTY},
    /* u_U0 */
    {0x2024U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 2U, offsetof(tumble_uncertainty_t, u0_v[0]), TUMBLE_KEEPER_SOURCE_UNCERTAINTY},
    /* Fit */
    {0x2025U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 2U, offsetof(tumble_whole_work_t, chi_squared), TUMBLE_KEEPER_SOURCE_FIT},
    {0x2025U, 4U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, offsetof(tumble_whole_work_t, freedom), TUMBLE_KEEPER_SOURCE_FIT},
    /* Noise */
    {0x2026U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 3U, offsetof(tumble_noise_t, noise_v[0]), TUMBLE_KEEPER_SOURCE_NOISE},
    {0x2026U, 5U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 1U, offsetof(tumble_noise_t, above), TUMBLE_KEEPER_SOURCE_NOISE},
    /* Active set, and 3 more */
    {0x2100U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 3U, 1U, offsetof(tumble_set_t, sequence), TUMBLE_KEEPER_SOURCE_SET},
    {0x2100U, 3U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 3U, 1U, offsetof(tumble_set_t, origin), TUMBLE_KEEPER_SOURCE_SET},
    {0x2100U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 2U, 0U, 3U, 0U, offsetof(tumble_set_t, flags), TUMBLE_KEEPER_SOURCE_SET},
    {0x2100U, 6U, TUMBLE_TYPE_VISIBLE_STRING, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 24U, 0U, 3U, 0U, offsetof(tumble_set_t, block_serial), TUMBLE_KEEPER_SOURCE_SET},
    {0x2100U, 7U, TUMBLE_TYPE_UNSIGNED64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 3U, 0U, offsetof(tumble_set_t, date_utc_s), TUMBLE_KEEPER_SOURCE_SET},
    {0x2100U, 8U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 3U, 1U, offsetof(tumble_set_t, temperature_c), TUMBLE_KEEPER_SOURCE_SET},
    {0x2100U, 10U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 3U, 0U, offsetof(tumble_set_t, samples), TUMBLE_KEEPER_SOURCE_SET},
    {0x2100U, 11U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 3U, 3U, offsetof(tumble_set_t, schedule_crc), TUMBLE_KEEPER_SOURCE_SET},
    {0x2100U, 15U, TUMBLE_TYPE_INTEGER8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 3U, 1U, offsetof(tumble_set_t, temperature_min_half_c), TUMBLE_KEEPER_SOURCE_SET},
    /* Active set: K, and 3 more */
    {0x2104U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 3U, 8U, offsetof(tumble_set_t, coefficients.k_v_per_g[0][0]), TUMBLE_KEEPER_SOURCE_SET},
    /* Active set: U0, and 3 more */
    {0x2108U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 3U, 2U, offsetof(tumble_set_t, coefficients.u0_v[0]), TUMBLE_KEEPER_SOURCE_SET},
    /* Active set: u_K, and 3 more */
    {0x210CU, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 3U, 8U, offsetof(tumble_set_t, uncertainty.k_v_per_g[0][0]), TUMBLE_KEEPER_SOURCE_SET},
    /* Active set: u_U0, and 3 more */
    {0x2110U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 3U, 2U, offsetof(tumble_set_t, uncertainty.u0_v[0]), TUMBLE_KEEPER_SOURCE_SET},
    /* Active set: verification, and 3 more */
    {0x2114U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 3U, 3U, offsetof(tumble_set_t, max_abs_fit_g), TUMBLE_KEEPER_SOURCE_SET},
    {0x2114U, 5U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 3U, 1U, offsetof(tumble_set_t, fit_positions), TUMBLE_KEEPER_SOURCE_SET},
    /* Keeper */
    {0x2120U, 1U, TUMBLE_TYPE_UNSIGNED64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 0U, offsetof(tumble_sets_state_t, utc_s), TUMBLE_KEEPER_SOURCE_STATE},
    {0x2120U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 4U, 0U, 0U, 2U, offsetof(tumble_sets_state_t, counter), TUMBLE_KEEPER_SOURCE_STATE},
    {0x2120U, 5U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 2U, 0U, 0U, 1U, offsetof(tumble_sets_state_t, inhibit_s), TUMBLE_KEEPER_SOURCE_STATE},
    {0x2120U, 7U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_MAP_TRANSMIT, 1U, 0U, 0U, 3U, offsetof(tumble_sets_state_t, verdict), TUMBLE_KEEPER_SOURCE_STATE},
    {0x2120U, 11U, TUMBLE_TYPE_BOOLEAN, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 3U, offsetof(tumble_sets_state_t, inhibited), TUMBLE_KEEPER_SOURCE_STATE},
    {0x2120U, 15U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 2U, 0U, 0U, 0U, offsetof(tumble_sets_state_t, more_objections), TUMBLE_KEEPER_SOURCE_STATE},
    /* Host */
    {0x2121U, 1U, TUMBLE_TYPE_UNSIGNED64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 8U, 0U, 0U, 0U, offsetof(tumble_sets_state_t, utc_s), TUMBLE_KEEPER_SOURCE_CALENDAR},
    {0x2121U, 2U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 0U, 0U, offsetof(tumble_sets_state_t, inhibit_s), TUMBLE_KEEPER_SOURCE_INHIBIT},
    /* Recalibration */
    {0x2122U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 8U, 0U, 0U, 0U, offsetof(tumble_sets_settings_t, gravity_m_s2), TUMBLE_KEEPER_SOURCE_SETTINGS},
    {0x2122U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 0U, 0U, 0U, offsetof(tumble_sets_settings_t, interval_s), TUMBLE_KEEPER_SOURCE_SETTINGS},
    {0x2122U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 4U, 8U, 0U, 0U, offsetof(tumble_sets_settings_t, pause_s), TUMBLE_KEEPER_SOURCE_SETTINGS},
    {0x2122U, 4U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 7U, 0U, 0U, offsetof(tumble_sets_settings_t, temperature_samples), TUMBLE_KEEPER_SOURCE_SETTINGS},
    {0x2122U, 5U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 0U, 0U, 0U, offsetof(tumble_sets_settings_t, temperature_half_c), TUMBLE_KEEPER_SOURCE_SETTINGS},
    {0x2122U, 6U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 1U, 1U, 0U, 0U, offsetof(tumble_sets_settings_t, flags), TUMBLE_KEEPER_SOURCE_SETTINGS},
    /* Commit rules */
    {0x2123U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 6U, 0U, 0U, offsetof(tumble_sets_settings_t, limits.coverage), TUMBLE_KEEPER_SOURCE_SETTINGS},
    {0x2123U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 1U, 2U, 0U, 0U, offsetof(tumble_sets_settings_t, limits.flags), TUMBLE_KEEPER_SOURCE_SETTINGS},
    /* Uncertainty limits */
    {0x2124U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 5U, 0U, 11U, offsetof(tumble_sets_settings_t, limits.uncertainty[0]), TUMBLE_KEEPER_SOURCE_SETTINGS},
    /* Drift limits per month */
    {0x2125U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 1U, 0U, 11U, offsetof(tumble_sets_settings_t, limits.drift_per_month[0]), TUMBLE_KEEPER_SOURCE_SETTINGS},
    /* Drift limits per kelvin */
    {0x2126U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_SERVICE, 4U, 1U, 0U, 11U, offsetof(tumble_sets_settings_t, limits.drift_per_kelvin[0]), TUMBLE_KEEPER_SOURCE_SETTINGS},
    /* Keeper counters */
    {0x2130U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 13U, offsetof(tumble_sets_counters_t, judged), TUMBLE_KEEPER_SOURCE_COUNTERS},
    /* Store counters */
    {0x2131U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 3U, offsetof(tumble_keeper_t, store.commits), TUMBLE_KEEPER_SOURCE_STORES},
    {0x2131U, 5U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 2U, offsetof(tumble_keeper_t, history.cells.verify), TUMBLE_KEEPER_SOURCE_STORES},
    {0x2131U, 8U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 2U, offsetof(tumble_keeper_t, checkpoint.cells.verify), TUMBLE_KEEPER_SOURCE_STORES},
    /* Stand seen */
    {0x2140U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 9U, offsetof(tumble_stand_view_t, number[0]), TUMBLE_KEEPER_SOURCE_STAND},
    /* Inclinations seen */
    {0x2141U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 13U, offsetof(tumble_inclinations_view_t, number[0]), TUMBLE_KEEPER_SOURCE_INCLINATIONS},
    /* Position */
    {0x2150U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 3U, 0U, 0U, offsetof(tumble_position_view_t, index), TUMBLE_KEEPER_SOURCE_SHOWN_POSITION},
    {0x2150U, 2U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(tumble_position_view_t, samples), TUMBLE_KEEPER_SOURCE_POSITION},
    {0x2150U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 5U, offsetof(tumble_position_view_t, mean_v[0]), TUMBLE_KEEPER_SOURCE_POSITION},
    /* Schedule */
    {0x2151U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, offsetof(tumble_position_view_t, count), TUMBLE_KEEPER_SOURCE_POSITIONS},
    {0x2151U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 2U, offsetof(tumble_position_view_t, mounting), TUMBLE_KEEPER_SOURCE_SCHEDULE},
    {0x2151U, 5U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 0U, offsetof(tumble_position_view_t, angle_deg), TUMBLE_KEEPER_SOURCE_SCHEDULE},
    /* Measurement at rest */
    {0x2152U, 1U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 2U, 0U, 0U, 0U, offsetof(tumble_at_rest_view_t, wanted), TUMBLE_KEEPER_SOURCE_AT_REST_COUNT},
    {0x2152U, 2U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 2U, 0U, 0U, 0U, offsetof(tumble_at_rest_view_t, taken), TUMBLE_KEEPER_SOURCE_AT_REST_COUNT},
    {0x2152U, 3U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 5U, offsetof(tumble_at_rest_view_t, mean_v[0]), TUMBLE_KEEPER_SOURCE_AT_REST},
    {0x2152U, 9U, TUMBLE_TYPE_UNSIGNED16, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 2U, 0U, 0U, 0U, offsetof(tumble_at_rest_view_t, spoilt), TUMBLE_KEEPER_SOURCE_AT_REST_COUNT},
    /* History */
    {0x2160U, 1U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE, 1U, 4U, 0U, 0U, 0U, TUMBLE_KEEPER_SOURCE_SHOWN_ENTRY},
    {0x2160U, 2U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 0U, 0U, TUMBLE_KEEPER_SOURCE_ENTRIES},
    {0x2160U, 3U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(tumble_history_entry_t, sequence), TUMBLE_KEEPER_SOURCE_HISTORY},
    {0x2160U, 4U, TUMBLE_TYPE_UNSIGNED64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 0U, offsetof(tumble_history_entry_t, date_utc_s), TUMBLE_KEEPER_SOURCE_HISTORY},
    {0x2160U, 5U, TUMBLE_TYPE_REAL32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 0U, offsetof(tumble_history_entry_t, temperature_c), TUMBLE_KEEPER_SOURCE_HISTORY},
    {0x2160U, 6U, TUMBLE_TYPE_UNSIGNED8, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 1U, 0U, 0U, 1U, offsetof(tumble_history_entry_t, origin), TUMBLE_KEEPER_SOURCE_HISTORY},
    /* History values */
    {0x2161U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 11U, offsetof(tumble_history_entry_t, value[0]), TUMBLE_KEEPER_SOURCE_HISTORY},
    /* History uncertainties */
    {0x2162U, 1U, TUMBLE_TYPE_REAL32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 11U, offsetof(tumble_history_entry_t, u[0]), TUMBLE_KEEPER_SOURCE_HISTORY_U},
    /* Trend */
    {0x2163U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 11U, offsetof(tumble_trend_view_t, per_month[0]), TUMBLE_KEEPER_SOURCE_TREND},
    /* Trend uncertainties */
    {0x2164U, 1U, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 8U, 0U, 0U, 11U, offsetof(tumble_trend_view_t, u_per_month[0]), TUMBLE_KEEPER_SOURCE_TREND_U},
    /* Parameters */
    {0x2170U, 1U, TUMBLE_TYPE_UNSIGNED32, TUMBLE_HOME_COMPUTED,
     TUMBLE_ACCESS_READ, 4U, 0U, 0U, 2U, offsetof(tumble_parameters_view_t, sequence), TUMBLE_KEEPER_SOURCE_PARAMETERS},
};

const tumble_object_table_t tumble_keeper_table = {
    .entries = entries,
    .limits = limits,
    .constants = NULL,
    .count = sizeof entries / sizeof entries[0],
};

const tumble_pdo_setup_t tumble_keeper_transmit[TUMBLE_KEEPER_TRANSMIT] = {
    {.cob_id = 0x680U, .type = 255U, .count = 4U, .inhibit_100us = 200U, .event_ms = 1000U,
     .map = {0x21200220U, 0x21200610U, 0x21200708U, 0x21200908U, 0U, 0U, 0U, 0U}},
};

const tumble_saved_t tumble_keeper_saved[TUMBLE_KEEPER_SAVED] = {
    {0x2050U, 5U}, /* Configuration */
    {0x2122U, 6U}, /* Recalibration */
    {0x2123U, 2U}, /* Commit rules */
    {0x2124U, 12U}, /* Uncertainty limits */
    {0x2125U, 12U}, /* Drift limits per month */
    {0x2126U, 12U}, /* Drift limits per kelvin */
};
