#include "tumble/core.h"

#include <stddef.h>

tumble_status_t tumble_optimal_uncertainty(const void *source, const tumble_judged_run_t *run,
                                           tumble_uncertainty_t *uncertainty)
{
    const tumble_optimal_source_t *from = source;
    const tumble_gain_record_t *record = NULL;
    if ((from == NULL) || (run == NULL) || (run->coefficients == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if ((run->only == 0U) || ((run->only & 1U) != 0U)) {
        const tumble_status_t status =
            tumble_gain_record_open(from->record, from->record_bytes, run->schedule, &record);
        if (status != TUMBLE_OK) {
            return status;
        }
    } else {
        record = from->record;
    }
    tumble_coefficients_t made_for = {0};
    for (int i = 0; i < (TUMBLE_CHANNELS * TUMBLE_CHANNELS); i++) {
        made_for.k_v_per_g[i / TUMBLE_CHANNELS][i % TUMBLE_CHANNELS] =
            record->k_v_per_g[i / TUMBLE_CHANNELS][i % TUMBLE_CHANNELS];
    }
    tumble_judged_run_t judged = *run;
    judged.coefficients = &made_for;
    const tumble_gain_table_t table = {.gains = tumble_gain_record_gains(record),
                                       .fit_positions = record->fit_positions,
                                       .inclination_rad = tumble_gain_record_inclination(record)};
    return tumble_uncertainty_gains(&table, &judged, uncertainty);
}
