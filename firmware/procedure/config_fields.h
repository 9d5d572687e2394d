/* config_fields.h - every number of tumble_averaging_config_t (tumble/core.h) and of tumble_procedure_config_t
 * (procedure.h), a row each: what is to be known of a field besides its meaning is here, once.
 *
 *     X(type, member, standard, signs, result, part, key, low, high, about)
 *
 * type      F64, F32, U32, U16, U8, I32, I8, BOOL, ENUM, or ENUM8: an enum in a byte
 * standard  its value in navcomp/standard.h
 * signs     what a run accepts: ANY, POSITIVE, NOT_NEGATIVE, NOT_ZERO (numbers are finite as well). Relations between
 *           fields are in procedure_checks.c; the averaging has its own checks (core/averaging.c)
 * result    RESULT: it decides what comes out of a run, so one that was interrupted does not go on with another value;
 *           or NO_RESULT
 * part      of a commissioning record. Within a part fields follow in the order of the table; parts 1 to 4 come before
 *           lists and schedule, the others behind. A new field opens a part of its own, the next number: in a record
 *           that was made before it reads as 0
 * key       in a scenario file; NULL: it follows from others there
 * low, high what a scenario file may say, both included; where 0 leaves a number open, it is allowed there
 * about     unit and meaning, for `tumble bench --keys`; of an enum its words
 *
 * Nothing of a table is left where nobody expands it. tools/objects/generate refuses a member without a row. No field
 * changes while a run is on.
 */
#ifndef TUMBLE_PROCEDURE_CONFIG_FIELDS_H
#define TUMBLE_PROCEDURE_CONFIG_FIELDS_H

/* clang-format off */
#define TUMBLE_AVERAGING_FIELDS(X)                                                                                     \
    /* 24 bits */                                                                                                      \
    X(I32, saturation_counts, 8388607, ANY, RESULT, 1, NULL, 1, INT32_MAX, "counts; refused at or beyond")             \
    /* for fewer samples the ratio below would be too strict */                                                        \
    X(U32, min_samples, 50U, ANY, RESULT, 1, "averaging.min_samples", 0, TUMBLE_MAX_SAMPLES,                           \
      "fewest samples; 0: all, with an error budget 16")                                                               \
    X(U16, max_lost, 5U, ANY, RESULT, 1, "averaging.max_lost", 0, UINT16_MAX, "samples per position")                  \
    X(U16, stuck_run, 20U, ANY, RESULT, 1, "averaging.stuck_run", 0, UINT16_MAX, "equal values in a row; 0: off")      \
    /* 0.3 mV, and rounding to a count */                                                                              \
    X(F32, noise_counts, 251.6584F, ANY, RESULT, 1, "averaging.noise_counts", 0, 1e9,                                  \
      "declared noise; 0: the block's")                                                                                \
    /* 1 + 6 / sqrt(2 (samples - 1)): six standard deviations of a scatter */                                          \
    X(F32, stillness_ratio, 1.6060915F, ANY, RESULT, 1, "averaging.stillness_ratio", 0, 1e9,                           \
      "scatter over it; 0: from the samples")

/* "averaged|refined|...": what a person may choose. */
#define TUMBLE_ESTIMATE_CHOICE(number, name, ...) "|" #name
#define TUMBLE_ESTIMATE_CHOICES (&(TUMBLE_ESTIMATOR_LIST(TUMBLE_ESTIMATE_CHOICE, TUMBLE_ESTIMATE_CHOICE))[1])

#define TUMBLE_PROCEDURE_FIELDS(X)                                                                                     \
    X(ENUM, estimate, TUMBLE_ESTIMATE_REFINED, ANY, RESULT, 1, "procedure.estimator", 0, 0,                            \
      TUMBLE_ESTIMATE_CHOICES)                                                                                         \
    X(U32, samples, 50U, ANY, RESULT, 1, "procedure.samples", 1, TUMBLE_MAX_SAMPLES,                                   \
      "samples per position, the most of them")                                                                        \
    X(F64, error_budget_v, 0.0, NOT_NEGATIVE, RESULT, 1, "procedure.error_budget_v", 0, 1e9,                           \
      "V; fewer samples if the standard errors of the means are under it; 0: always all")                              \
    /* +-10 V in 24 bits */                                                                                            \
    X(F64, v_per_count, 20.0 / 16777216.0, NOT_ZERO, RESULT, 1, NULL, -1e9, 1e9, "V")                                  \
    X(F64, nominal_scale_v_per_g, -2.0, NOT_ZERO, RESULT, 1, "procedure.nominal_scale_v_per_g", -1e9, 1e9,             \
      "V/g; 0: block.scale_v_per_g")                                                                                   \
    X(F64, gravity_limit_g, 3e-4, POSITIVE, RESULT, 1, "procedure.gravity_limit_g", 0, 1e9,                            \
      "g; limit of the gravity check")                                                                                 \
    /* 23 standard deviations of it with angles good to 4e-5 rad and the means' noise */                               \
    X(F64, closure_limit_g, 2e-3, POSITIVE, RESULT, 1, "procedure.closure_limit_g", 0, 1e9,                            \
      "g; 0: from noise and alpha4, at least 2e-3")                                                                    \
    X(F64, position_tolerance_deg, 0.05, POSITIVE, NO_RESULT, 1, "procedure.position_tolerance_deg", 0, 360, "deg")    \
    X(F64, approach_deg, 5.0, NOT_NEGATIVE, RESULT, 1, "procedure.approach_deg", 0, 360, "deg")                        \
    X(F64, cable_min_deg, -30.0, ANY, NO_RESULT, 1, "procedure.cable_min_deg", -1e5, 1e5, "deg")                       \
    X(F64, cable_max_deg, 400.0, ANY, NO_RESULT, 1, "procedure.cable_max_deg", -1e5, 1e5, "deg")                       \
    X(U16, settle_ms, 500U, ANY, RESULT, 1, "procedure.settle_ms", 0, UINT16_MAX, "ms")                                \
    X(U16, max_corrupted, 5U, ANY, NO_RESULT, 1, "procedure.max_corrupted", 0, UINT16_MAX, "frames per position")      \
    X(U8, retries, 2U, ANY, NO_RESULT, 1, "procedure.retries", 0, UINT8_MAX, "per position")                           \
    X(I8, warm_up_band_half_c, 2, NOT_NEGATIVE, NO_RESULT, 1, "procedure.warm_up_band_half_c", INT8_MIN, INT8_MAX,     \
      "half degrees")                                                                                                  \
    X(U16, warm_up_samples, 50U, ANY, NO_RESULT, 1, "procedure.warm_up_samples", 0, UINT16_MAX,                        \
      "in a row; 0: no warm-up")                                                                                       \
    X(U32, preflight_timeout_ms, 10000U, POSITIVE, NO_RESULT, 1, "procedure.preflight_timeout_ms", 0, UINT32_MAX,      \
      "ms")                                                                                                            \
    X(U32, warm_up_timeout_ms, 600000U, POSITIVE, NO_RESULT, 1, "procedure.warm_up_timeout_ms", 0, UINT32_MAX, "ms")   \
    X(U32, mounting_timeout_ms, 600000U, POSITIVE, NO_RESULT, 1, "procedure.mounting_timeout_ms", 0, UINT32_MAX, "ms") \
    X(U32, home_timeout_ms, 60000U, POSITIVE, NO_RESULT, 1, "procedure.home_timeout_ms", 0, UINT32_MAX, "ms")          \
    X(U32, move_timeout_ms, 30000U, POSITIVE, NO_RESULT, 1, "procedure.move_timeout_ms", 0, UINT32_MAX, "ms")          \
    X(U32, settle_timeout_ms, 5000U, POSITIVE, NO_RESULT, 1, "procedure.settle_timeout_ms", 0, UINT32_MAX, "ms")       \
    /* 10 s, and twice what 50 samples take at 100 a second */                                                         \
    X(U32, average_timeout_ms, 11000U, POSITIVE, NO_RESULT, 1, "procedure.average_timeout_ms", 0, UINT32_MAX,          \
      "ms; 0: from the samples")                                                                                       \
    /* 100 samples */                                                                                                  \
    X(U32, sample_timeout_ms, 1000U, POSITIVE, NO_RESULT, 1, "procedure.sample_timeout_ms", 0, UINT32_MAX,             \
      "ms; 0: 100 samples")                                                                                             \
    X(U32, motion_margin_ms, 2000U, ANY, NO_RESULT, 6, "procedure.motion_margin_ms", 0, 3600000,                    \
      "ms; a motion may last so much longer than way / speed; 0: 2000")                                                \
    X(F64, channel_scale_v_per_g[0], 0.0, ANY, NO_RESULT, 7, NULL, -1e9, 1e9, "V/g; 0: nominal_scale_v_per_g")         \
    X(F64, channel_scale_v_per_g[1], 0.0, ANY, NO_RESULT, 7, NULL, -1e9, 1e9, "V/g; likewise")                         \
    X(F64, channel_scale_v_per_g[2], 0.0, ANY, NO_RESULT, 7, NULL, -1e9, 1e9, "V/g; likewise")
/* clang-format on */

#endif
