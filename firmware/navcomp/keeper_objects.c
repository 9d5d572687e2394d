/* Written by tools/objects/generate from tools/objects/keeper.toml: change it there. */
#include "navcomp/keeper_objects.h"

#include "canopen/table.h"
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

TUMBLE_IS_ARRAY("2023h:1", tumble_uncertainty_t, 8U, k_v_per_g, k_v_per_g[0][0], 9U);
TUMBLE_IS_ARRAY("2024h:1", tumble_uncertainty_t, 8U, u0_v, u0_v[0], 3U);
TUMBLE_IN_LINE_3("2025h:1", tumble_whole_work_t, 8U, chi_squared, limit, misfit);
TUMBLE_HAS_SIZE("2025h:4", tumble_whole_work_t, 1U, freedom);
TUMBLE_IN_LINE_4("2026h:1", tumble_noise_t, 8U, noise_v[0], noise_v[1], noise_v[2], declared_v);
TUMBLE_IN_LINE_2("2026h:5", tumble_noise_t, 1U, above, undithered);
TUMBLE_IN_LINE_2("2100h:1", tumble_set_t, 4U, sequence, restores);
TUMBLE_IN_LINE_2("2100h:3", tumble_set_t, 1U, origin, estimator);
TUMBLE_HAS_SIZE("2100h:5", tumble_set_t, 2U, flags);
TUMBLE_HAS_SIZE("2100h:6", tumble_set_t, 24U, block_serial);
TUMBLE_HAS_SIZE("2100h:7", tumble_set_t, 8U, date_utc_s);
TUMBLE_IN_LINE_2("2100h:8", tumble_set_t, 8U, temperature_c, gravity_m_s2);
TUMBLE_HAS_SIZE("2100h:10", tumble_set_t, 4U, samples);
TUMBLE_IN_LINE_4("2100h:11", tumble_set_t, 4U, schedule_crc, stand_crc, reasons, record_crc);
TUMBLE_IN_LINE_2("2100h:15", tumble_set_t, 1U, temperature_min_half_c, temperature_max_half_c);
TUMBLE_IS_ARRAY("2104h:1", tumble_set_t, 8U, coefficients.k_v_per_g, coefficients.k_v_per_g[0][0], 9U);
TUMBLE_IS_ARRAY("2108h:1", tumble_set_t, 8U, coefficients.u0_v, coefficients.u0_v[0], 3U);
TUMBLE_IS_ARRAY("210Ch:1", tumble_set_t, 8U, uncertainty.k_v_per_g, uncertainty.k_v_per_g[0][0], 9U);
TUMBLE_IS_ARRAY("2110h:1", tumble_set_t, 8U, uncertainty.u0_v, uncertainty.u0_v[0], 3U);
TUMBLE_IN_LINE_4("2114h:1", tumble_set_t, 8U, max_abs_fit_g, max_abs_check_g, limit_g, closure_v);
TUMBLE_IN_LINE_2("2114h:5", tumble_set_t, 1U, fit_positions, check_positions);
TUMBLE_HAS_SIZE("2120h:1", tumble_sets_state_t, 8U, utc_s);
TUMBLE_IN_LINE_3("2120h:2", tumble_sets_state_t, 4U, counter, age_s, due_in_s);
TUMBLE_IN_LINE_2("2120h:5", tumble_sets_state_t, 2U, inhibit_s, objections);
TUMBLE_IN_LINE_4("2120h:7", tumble_sets_state_t, 1U, verdict, status, due, resumable);
TUMBLE_IN_LINE_4("2120h:11", tumble_sets_state_t, 1U, inhibited, busy, has_proposal, has_factory);
TUMBLE_HAS_SIZE("2120h:15", tumble_sets_state_t, 2U, more_objections);
TUMBLE_HAS_SIZE("2121h:1", tumble_sets_state_t, 8U, utc_s);
TUMBLE_HAS_SIZE("2121h:2", tumble_sets_state_t, 2U, inhibit_s);
TUMBLE_HAS_SIZE("2122h:1", tumble_sets_settings_t, 8U, gravity_m_s2);
TUMBLE_HAS_SIZE("2122h:2", tumble_sets_settings_t, 4U, interval_s);
TUMBLE_HAS_SIZE("2122h:3", tumble_sets_settings_t, 4U, pause_s);
TUMBLE_HAS_SIZE("2122h:4", tumble_sets_settings_t, 2U, temperature_samples);
TUMBLE_HAS_SIZE("2122h:5", tumble_sets_settings_t, 1U, temperature_half_c);
TUMBLE_HAS_SIZE("2122h:6", tumble_sets_settings_t, 1U, flags);
TUMBLE_HAS_SIZE("2123h:1", tumble_sets_settings_t, 4U, limits.coverage);
TUMBLE_HAS_SIZE("2123h:2", tumble_sets_settings_t, 1U, limits.flags);
TUMBLE_IS_ARRAY("2124h:1", tumble_sets_settings_t, 4U, limits.uncertainty, limits.uncertainty[0], 12U);
TUMBLE_IS_ARRAY("2125h:1", tumble_sets_settings_t, 4U, limits.drift_per_month, limits.drift_per_month[0], 12U);
TUMBLE_IS_ARRAY("2126h:1", tumble_sets_settings_t, 4U, limits.drift_per_kelvin, limits.drift_per_kelvin[0], 12U);
TUMBLE_IN_LINE_4("2130h:1", tumble_sets_counters_t, 4U, judged, committed, held, repeated);
TUMBLE_IN_LINE_4("2130h:4", tumble_sets_counters_t, 4U, repeated, accepted, discarded, rolled_back);
TUMBLE_IN_LINE_4("2130h:7", tumble_sets_counters_t, 4U, rolled_back, failures, checkpoints, resumed);
TUMBLE_IN_LINE_4("2130h:10", tumble_sets_counters_t, 4U, resumed, not_resumed, inhibited, self_started);
TUMBLE_IN_LINE_2("2130h:13", tumble_sets_counters_t, 4U, self_started, refused);
TUMBLE_IN_LINE_4("2131h:1", tumble_keeper_t, 4U,
                 store.commits, store.cells.verify, store.cells.nv_errors, store.cells.torn);
TUMBLE_IN_LINE_3("2131h:5", tumble_keeper_t, 4U, history.cells.verify, history.cells.nv_errors, history.cells.torn);
TUMBLE_IN_LINE_3("2131h:8", tumble_keeper_t, 4U,
                 checkpoint.cells.verify, checkpoint.cells.nv_errors, checkpoint.cells.torn);
TUMBLE_IS_ARRAY("2140h:1", tumble_stand_view_t, 8U, number, number[0], 10U);
TUMBLE_IS_ARRAY("2141h:1", tumble_inclinations_view_t, 8U, number, number[0], 14U);
TUMBLE_HAS_SIZE("2150h:1", tumble_position_view_t, 1U, index);
TUMBLE_HAS_SIZE("2150h:2", tumble_position_view_t, 4U, samples);
TUMBLE_IN_LINE_4("2150h:3", tumble_position_view_t, 8U, mean_v[0], mean_v[1], mean_v[2], standard_error_v[0]);
TUMBLE_IN_LINE_3("2150h:6", tumble_position_view_t, 8U, standard_error_v[0], standard_error_v[1], standard_error_v[2]);
TUMBLE_HAS_SIZE("2151h:1", tumble_position_view_t, 1U, count);
TUMBLE_IN_LINE_3("2151h:2", tumble_position_view_t, 1U, mounting, number, use);
TUMBLE_HAS_SIZE("2151h:5", tumble_position_view_t, 8U, angle_deg);
TUMBLE_HAS_SIZE("2152h:1", tumble_at_rest_view_t, 2U, wanted);
TUMBLE_HAS_SIZE("2152h:2", tumble_at_rest_view_t, 2U, taken);
TUMBLE_IN_LINE_4("2152h:3", tumble_at_rest_view_t, 8U, mean_v[0], mean_v[1], mean_v[2], deviation_v[0]);
TUMBLE_IN_LINE_3("2152h:6", tumble_at_rest_view_t, 8U, deviation_v[0], deviation_v[1], deviation_v[2]);
TUMBLE_HAS_SIZE("2152h:9", tumble_at_rest_view_t, 2U, spoilt);
TUMBLE_HAS_SIZE("2160h:3", tumble_history_entry_t, 4U, sequence);
TUMBLE_HAS_SIZE("2160h:4", tumble_history_entry_t, 8U, date_utc_s);
TUMBLE_HAS_SIZE("2160h:5", tumble_history_entry_t, 4U, temperature_c);
TUMBLE_IN_LINE_2("2160h:6", tumble_history_entry_t, 1U, origin, estimator);
TUMBLE_IS_ARRAY("2161h:1", tumble_history_entry_t, 4U, value, value[0], 12U);
TUMBLE_IS_ARRAY("2162h:1", tumble_history_entry_t, 4U, u, u[0], 12U);
TUMBLE_IS_ARRAY("2163h:1", tumble_trend_view_t, 8U, per_month, per_month[0], 12U);
TUMBLE_IS_ARRAY("2164h:1", tumble_trend_view_t, 8U, u_per_month, u_per_month[0], 12U);
TUMBLE_IN_LINE_3("2170h:1", tumble_parameters_view_t, 4U, sequence, refused, applied);

static const tumble_entry_t entries[] = {
    TUMBLE_ROW(0x1010, 1, UNSIGNED32, COMPUTED, RW | SERVICE, 4, 0, 0, 0, 0, TUMBLE_KEEPER_SOURCE_SAVE), /* Store parameters */
    TUMBLE_ROW(0x1011, 1, UNSIGNED32, COMPUTED, RW | SERVICE, 4, 0, 0, 0, 0, TUMBLE_KEEPER_SOURCE_LOAD), /* Restore default parameters */
    TUMBLE_ROW(0x2023, 1, REAL64, COMPUTED, RO, 8, 0, 0, 8, offsetof(tumble_uncertainty_t, k_v_per_g[0][0]), TUMBLE_KEEPER_SOURCE_UNCERTAINTY), /* u_K */
    TUMBLE_ROW(0x2024, 1, REAL64, COMPUTED, RO, 8, 0, 0, 2, offsetof(tumble_uncertainty_t, u0_v[0]), TUMBLE_KEEPER_SOURCE_UNCERTAINTY), /* u_U0 */
    TUMBLE_ROW(0x2025, 1, REAL64, COMPUTED, RO, 8, 0, 0, 2, offsetof(tumble_whole_work_t, chi_squared), TUMBLE_KEEPER_SOURCE_FIT), /* Fit */
    TUMBLE_ROW(0x2025, 4, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 0, offsetof(tumble_whole_work_t, freedom), TUMBLE_KEEPER_SOURCE_FIT),
    TUMBLE_ROW(0x2026, 1, REAL64, COMPUTED, RO, 8, 0, 0, 3, offsetof(tumble_noise_t, noise_v[0]), TUMBLE_KEEPER_SOURCE_NOISE), /* Noise */
    TUMBLE_ROW(0x2026, 5, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 1, offsetof(tumble_noise_t, above), TUMBLE_KEEPER_SOURCE_NOISE),
    TUMBLE_ROW(0x2100, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 3, 1, offsetof(tumble_set_t, sequence), TUMBLE_KEEPER_SOURCE_SET), /* Active set, and 3 more */
    TUMBLE_ROW(0x2100, 3, UNSIGNED8, COMPUTED, RO, 1, 0, 3, 1, offsetof(tumble_set_t, origin), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2100, 5, UNSIGNED16, COMPUTED, RO, 2, 0, 3, 0, offsetof(tumble_set_t, flags), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2100, 6, VISIBLE_STRING, COMPUTED, RO, 24, 0, 3, 0, offsetof(tumble_set_t, block_serial), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2100, 7, UNSIGNED64, COMPUTED, RO, 8, 0, 3, 0, offsetof(tumble_set_t, date_utc_s), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2100, 8, REAL64, COMPUTED, RO, 8, 0, 3, 1, offsetof(tumble_set_t, temperature_c), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2100, 10, UNSIGNED32, COMPUTED, RO, 4, 0, 3, 0, offsetof(tumble_set_t, samples), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2100, 11, UNSIGNED32, COMPUTED, RO, 4, 0, 3, 3, offsetof(tumble_set_t, schedule_crc), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2100, 15, INTEGER8, COMPUTED, RO, 1, 0, 3, 1, offsetof(tumble_set_t, temperature_min_half_c), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2104, 1, REAL64, COMPUTED, RO, 8, 0, 3, 8, offsetof(tumble_set_t, coefficients.k_v_per_g[0][0]), TUMBLE_KEEPER_SOURCE_SET), /* Active set: K, and 3 more */
    TUMBLE_ROW(0x2108, 1, REAL64, COMPUTED, RO, 8, 0, 3, 2, offsetof(tumble_set_t, coefficients.u0_v[0]), TUMBLE_KEEPER_SOURCE_SET), /* Active set: U0, and 3 more */
    TUMBLE_ROW(0x210C, 1, REAL64, COMPUTED, RO, 8, 0, 3, 8, offsetof(tumble_set_t, uncertainty.k_v_per_g[0][0]), TUMBLE_KEEPER_SOURCE_SET), /* Active set: u_K, and 3 more */
    TUMBLE_ROW(0x2110, 1, REAL64, COMPUTED, RO, 8, 0, 3, 2, offsetof(tumble_set_t, uncertainty.u0_v[0]), TUMBLE_KEEPER_SOURCE_SET), /* Active set: u_U0, and 3 more */
    TUMBLE_ROW(0x2114, 1, REAL64, COMPUTED, RO, 8, 0, 3, 3, offsetof(tumble_set_t, max_abs_fit_g), TUMBLE_KEEPER_SOURCE_SET), /* Active set: verification, and 3 more */
    TUMBLE_ROW(0x2114, 5, UNSIGNED8, COMPUTED, RO, 1, 0, 3, 1, offsetof(tumble_set_t, fit_positions), TUMBLE_KEEPER_SOURCE_SET),
    TUMBLE_ROW(0x2120, 1, UNSIGNED64, COMPUTED, RO, 8, 0, 0, 0, offsetof(tumble_sets_state_t, utc_s), TUMBLE_KEEPER_SOURCE_STATE), /* Keeper */
    TUMBLE_ROW(0x2120, 2, UNSIGNED32, COMPUTED, RO | TPDO, 4, 0, 0, 2, offsetof(tumble_sets_state_t, counter), TUMBLE_KEEPER_SOURCE_STATE),
    TUMBLE_ROW(0x2120, 5, UNSIGNED16, COMPUTED, RO | TPDO, 2, 0, 0, 1, offsetof(tumble_sets_state_t, inhibit_s), TUMBLE_KEEPER_SOURCE_STATE),
    TUMBLE_ROW(0x2120, 7, UNSIGNED8, COMPUTED, RO | TPDO, 1, 0, 0, 3, offsetof(tumble_sets_state_t, verdict), TUMBLE_KEEPER_SOURCE_STATE),
    TUMBLE_ROW(0x2120, 11, BOOLEAN, COMPUTED, RO, 1, 0, 0, 3, offsetof(tumble_sets_state_t, inhibited), TUMBLE_KEEPER_SOURCE_STATE),
    TUMBLE_ROW(0x2120, 15, UNSIGNED16, COMPUTED, RO, 2, 0, 0, 0, offsetof(tumble_sets_state_t, more_objections), TUMBLE_KEEPER_SOURCE_STATE),
    TUMBLE_ROW(0x2121, 1, UNSIGNED64, COMPUTED, RW, 8, 0, 0, 0, offsetof(tumble_sets_state_t, utc_s), TUMBLE_KEEPER_SOURCE_CALENDAR), /* Host */
    TUMBLE_ROW(0x2121, 2, UNSIGNED16, COMPUTED, RW, 2, 0, 0, 0, offsetof(tumble_sets_state_t, inhibit_s), TUMBLE_KEEPER_SOURCE_INHIBIT),
    TUMBLE_ROW(0x2122, 1, REAL64, COMPUTED, RW, 8, 0, 0, 0, offsetof(tumble_sets_settings_t, gravity_m_s2), TUMBLE_KEEPER_SOURCE_SETTINGS), /* Recalibration */
    TUMBLE_ROW(0x2122, 2, UNSIGNED32, COMPUTED, RW, 4, 0, 0, 0, offsetof(tumble_sets_settings_t, interval_s), TUMBLE_KEEPER_SOURCE_SETTINGS),
    TUMBLE_ROW(0x2122, 3, UNSIGNED32, COMPUTED, RW, 4, 8, 0, 0, offsetof(tumble_sets_settings_t, pause_s), TUMBLE_KEEPER_SOURCE_SETTINGS),
    TUMBLE_ROW(0x2122, 4, UNSIGNED16, COMPUTED, RW, 2, 7, 0, 0, offsetof(tumble_sets_settings_t, temperature_samples), TUMBLE_KEEPER_SOURCE_SETTINGS),
    TUMBLE_ROW(0x2122, 5, UNSIGNED8, COMPUTED, RW, 1, 0, 0, 0, offsetof(tumble_sets_settings_t, temperature_half_c), TUMBLE_KEEPER_SOURCE_SETTINGS),
    TUMBLE_ROW(0x2122, 6, UNSIGNED8, COMPUTED, RW | SERVICE, 1, 1, 0, 0, offsetof(tumble_sets_settings_t, flags), TUMBLE_KEEPER_SOURCE_SETTINGS),
    TUMBLE_ROW(0x2123, 1, REAL32, COMPUTED, RW | SERVICE, 4, 6, 0, 0, offsetof(tumble_sets_settings_t, limits.coverage), TUMBLE_KEEPER_SOURCE_SETTINGS), /* Commit rules */
    TUMBLE_ROW(0x2123, 2, UNSIGNED8, COMPUTED, RW | SERVICE, 1, 2, 0, 0, offsetof(tumble_sets_settings_t, limits.flags), TUMBLE_KEEPER_SOURCE_SETTINGS),
    TUMBLE_ROW(0x2124, 1, REAL32, COMPUTED, RW | SERVICE, 4, 5, 0, 11, offsetof(tumble_sets_settings_t, limits.uncertainty[0]), TUMBLE_KEEPER_SOURCE_SETTINGS), /* Uncertainty limits */
    TUMBLE_ROW(0x2125, 1, REAL32, COMPUTED, RW | SERVICE, 4, 1, 0, 11, offsetof(tumble_sets_settings_t, limits.drift_per_month[0]), TUMBLE_KEEPER_SOURCE_SETTINGS), /* Drift limits per month */
    TUMBLE_ROW(0x2126, 1, REAL32, COMPUTED, RW | SERVICE, 4, 1, 0, 11, offsetof(tumble_sets_settings_t, limits.drift_per_kelvin[0]), TUMBLE_KEEPER_SOURCE_SETTINGS), /* Drift limits per kelvin */
    TUMBLE_ROW(0x2130, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 13, offsetof(tumble_sets_counters_t, judged), TUMBLE_KEEPER_SOURCE_COUNTERS), /* Keeper counters */
    TUMBLE_ROW(0x2131, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 3, offsetof(tumble_keeper_t, store.commits), TUMBLE_KEEPER_SOURCE_STORES), /* Store counters */
    TUMBLE_ROW(0x2131, 5, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 2, offsetof(tumble_keeper_t, history.cells.verify), TUMBLE_KEEPER_SOURCE_STORES),
    TUMBLE_ROW(0x2131, 8, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 2, offsetof(tumble_keeper_t, checkpoint.cells.verify), TUMBLE_KEEPER_SOURCE_STORES),
    TUMBLE_ROW(0x2140, 1, REAL64, COMPUTED, RO, 8, 0, 0, 9, offsetof(tumble_stand_view_t, number[0]), TUMBLE_KEEPER_SOURCE_STAND), /* Stand seen */
    TUMBLE_ROW(0x2141, 1, REAL64, COMPUTED, RO, 8, 0, 0, 13, offsetof(tumble_inclinations_view_t, number[0]), TUMBLE_KEEPER_SOURCE_INCLINATIONS), /* Inclinations seen */
    TUMBLE_ROW(0x2150, 1, UNSIGNED8, COMPUTED, RW, 1, 3, 0, 0, offsetof(tumble_position_view_t, index), TUMBLE_KEEPER_SOURCE_SHOWN_POSITION), /* Position */
    TUMBLE_ROW(0x2150, 2, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 0, offsetof(tumble_position_view_t, samples), TUMBLE_KEEPER_SOURCE_POSITION),
    TUMBLE_ROW(0x2150, 3, REAL64, COMPUTED, RO, 8, 0, 0, 5, offsetof(tumble_position_view_t, mean_v[0]), TUMBLE_KEEPER_SOURCE_POSITION),
    TUMBLE_ROW(0x2151, 1, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 0, offsetof(tumble_position_view_t, count), TUMBLE_KEEPER_SOURCE_POSITIONS), /* Schedule */
    TUMBLE_ROW(0x2151, 2, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 2, offsetof(tumble_position_view_t, mounting), TUMBLE_KEEPER_SOURCE_SCHEDULE),
    TUMBLE_ROW(0x2151, 5, REAL64, COMPUTED, RO, 8, 0, 0, 0, offsetof(tumble_position_view_t, angle_deg), TUMBLE_KEEPER_SOURCE_SCHEDULE),
    TUMBLE_ROW(0x2152, 1, UNSIGNED16, COMPUTED, RW, 2, 0, 0, 0, offsetof(tumble_at_rest_view_t, wanted), TUMBLE_KEEPER_SOURCE_AT_REST_COUNT), /* Measurement at rest */
    TUMBLE_ROW(0x2152, 2, UNSIGNED16, COMPUTED, RO, 2, 0, 0, 0, offsetof(tumble_at_rest_view_t, taken), TUMBLE_KEEPER_SOURCE_AT_REST_COUNT),
    TUMBLE_ROW(0x2152, 3, REAL64, COMPUTED, RO, 8, 0, 0, 5, offsetof(tumble_at_rest_view_t, mean_v[0]), TUMBLE_KEEPER_SOURCE_AT_REST),
    TUMBLE_ROW(0x2152, 9, UNSIGNED16, COMPUTED, RO, 2, 0, 0, 0, offsetof(tumble_at_rest_view_t, spoilt), TUMBLE_KEEPER_SOURCE_AT_REST_COUNT),
    TUMBLE_ROW(0x2160, 1, UNSIGNED8, COMPUTED, RW, 1, 4, 0, 0, 0, TUMBLE_KEEPER_SOURCE_SHOWN_ENTRY), /* History */
    TUMBLE_ROW(0x2160, 2, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 0, 0, TUMBLE_KEEPER_SOURCE_ENTRIES),
    TUMBLE_ROW(0x2160, 3, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 0, offsetof(tumble_history_entry_t, sequence), TUMBLE_KEEPER_SOURCE_HISTORY),
    TUMBLE_ROW(0x2160, 4, UNSIGNED64, COMPUTED, RO, 8, 0, 0, 0, offsetof(tumble_history_entry_t, date_utc_s), TUMBLE_KEEPER_SOURCE_HISTORY),
    TUMBLE_ROW(0x2160, 5, REAL32, COMPUTED, RO, 4, 0, 0, 0, offsetof(tumble_history_entry_t, temperature_c), TUMBLE_KEEPER_SOURCE_HISTORY),
    TUMBLE_ROW(0x2160, 6, UNSIGNED8, COMPUTED, RO, 1, 0, 0, 1, offsetof(tumble_history_entry_t, origin), TUMBLE_KEEPER_SOURCE_HISTORY),
    TUMBLE_ROW(0x2161, 1, REAL32, COMPUTED, RO, 4, 0, 0, 11, offsetof(tumble_history_entry_t, value[0]), TUMBLE_KEEPER_SOURCE_HISTORY), /* History values */
    TUMBLE_ROW(0x2162, 1, REAL32, COMPUTED, RO, 4, 0, 0, 11, offsetof(tumble_history_entry_t, u[0]), TUMBLE_KEEPER_SOURCE_HISTORY_U), /* History uncertainties */
    TUMBLE_ROW(0x2163, 1, REAL64, COMPUTED, RO, 8, 0, 0, 11, offsetof(tumble_trend_view_t, per_month[0]), TUMBLE_KEEPER_SOURCE_TREND), /* Trend */
    TUMBLE_ROW(0x2164, 1, REAL64, COMPUTED, RO, 8, 0, 0, 11, offsetof(tumble_trend_view_t, u_per_month[0]), TUMBLE_KEEPER_SOURCE_TREND_U), /* Trend uncertainties */
    TUMBLE_ROW(0x2170, 1, UNSIGNED32, COMPUTED, RO, 4, 0, 0, 2, offsetof(tumble_parameters_view_t, sequence), TUMBLE_KEEPER_SOURCE_PARAMETERS), /* Parameters */
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
