/* The navigation computer's object dictionary as an outsider sees it: by SDO, and in the state PDO. */
#include "navcomp_sdo.h"

static const tumble_progress_t *run_of(const bench_t *of)
{
    static tumble_navcomp_progress_t progress;
    progress = bench_progress(of);
    return &progress.run;
}

static void test_identity(void)
{
    uint8_t bytes[64] = {0};
    uint8_t size = 0;
    bench_power_on(&bench);
    TEST_ASSERT_EQUAL_HEX32(0, sdo_read(0x1008, 0, bytes, &size));
    TEST_ASSERT_EQUAL_STRING_LEN("Tumble navigation computer", bytes, size);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_ABORT_NO_OBJECT, refusal_of(0x3000, 0));
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_ABORT_NO_SUBINDEX, refusal_of(0x2003, 99));
}

static void test_heartbeat_times_show_the_configuration(void)
{
    bench.config.heartbeat_ms = 70;
    bench.config.heartbeat_timeout_ms = 333;
    bench_power_on(&bench);
    ASSERT_READS({0x1017, 0, 2, 70}, {0x1016, 1, 4, 0x0002014D}, {0x1016, 2, 4, 0x0003014D});
}

static void test_an_outsider_runs_a_calibration_by_sdo(void)
{
    const uint8_t mounting[] = {1, 2};
    bench.never_confirm = true; /* the scripted operator has the day off */
    power_on_for(1.0);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_STATE_IDLE, read_number(0x2000, 0, 1));
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    for (size_t i = 0; i < sizeof mounting; i++) {
        TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_run(&bench, TUMBLE_STATE_WAIT_MOUNTING, 60.0));
        TEST_ASSERT_EQUAL_UINT32(TUMBLE_STATE_WAIT_MOUNTING, read_number(0x2000, 0, 1));
        TEST_ASSERT_EQUAL_UINT32(mounting[i], read_number(0x2003, 4, 1));
        bench.block.mounting = &tumble_schedule_paper.mountings[i];
        TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2002, 1, &mounting[i], 1));
        TEST_ASSERT_EQUAL_UINT32(mounting[i], read_number(0x2002, 1, 1));
        TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_CONFIRM_MOUNTING));
    }
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    tumble_result_t result;
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_result(&bench.navcomp, &result));
    assert_told(result.coefficients->k_v_per_g, result.coefficients->u0_v, 0x2020, 0x2021);
    TEST_ASSERT_TRUE(result.check->max_abs_fit_g == read_f64(0x2022, 1));
    TEST_ASSERT_TRUE(read_f64(0x2022, 2) == 0.0);
    TEST_ASSERT_TRUE(read_f64(0x2022, 3) == 3e-4);
    ASSERT_READS({0x2022, 4, 1, 18}, {0x2022, 5, 1, 0}, {0x2022, 6, 1, 1});
}

/* Whoever asks the operator reads it here: is the block to be mounted, or does it stay and the stand is inclined? */
static void test_the_wire_tells_whether_to_mount_or_to_incline(void)
{
    static tumble_mounting_t mountings[2];
    static tumble_schedule_t bolted_once;
    const tumble_angle_t tilt = {1.0, 0.01745240643728351, 0.99984769515639124};
    memcpy(mountings, tumble_schedule_paper.mountings, sizeof mountings);
    bolted_once = tumble_schedule_paper;
    bolted_once.mountings = mountings;
    mountings[1].tilt = tilt;
    for (uint8_t bolting = 0; bolting < 2U; bolting++) {
        mountings[0].bolting = bolting;
        mountings[1].bolting = bolting;
        bench.never_confirm = true;
        power_on_for(1.0);
        TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2003, 13, 1));
        TEST_ASSERT_TRUE(read_f64(0x2003, 14) == 0.0);
        bench.navcomp.procedure_config.schedule = &bolted_once;
        bench.navcomp.procedure_config.estimate = TUMBLE_ESTIMATE_LEAST_SQUARES;
        TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
        TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_run(&bench, TUMBLE_STATE_WAIT_MOUNTING, 60.0));
        TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2003, 13, 1));
        TEST_ASSERT_TRUE(read_f64(0x2003, 14) == 0.0);
        TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2002, 1, &mountings[0].number, 1));
        TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_CONFIRM_MOUNTING));
        TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_run(&bench, TUMBLE_STATE_WAIT_MOUNTING, 600.0));
        TEST_ASSERT_EQUAL_UINT32(2, read_number(0x2003, 4, 1));
        TEST_ASSERT_EQUAL_UINT32(bolting, read_number(0x2003, 13, 1));
        TEST_ASSERT_TRUE(read_f64(0x2003, 14) == 1.0);
        bench_begin();
    }
}

static void test_commands_are_refused_with_the_right_code(void)
{
    power_on_for(1.0);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, command(TUMBLE_COMMAND_RESUME));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, command(200));
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_NONE));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_WRITE_ONLY, refusal_of(0x2002, 2));
    TEST_ASSERT_EQUAL_UINT32(2, read_number(0x2031, 4, 4)); /* commands refused */
}

static void test_what_there_is_not_yet_is_refused(void)
{
    power_on_for(1.0);
    for (uint8_t sub = 1; sub <= 3U; sub++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2010, sub));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2011, sub));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2020, sub));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2021, sub));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2022, sub));
    }
}

static void test_progress_and_the_running_mean(void)
{
    bench_start(&bench);
    while ((run_of(&bench)->index != 7U) || (run_of(&bench)->samples != 5U)) {
        bench_event(&bench);
    }
    const tumble_navcomp_progress_t progress = bench_progress(&bench);
    ASSERT_READS({0x2000, 0, 1, TUMBLE_STATE_AVERAGE}, {0x2001, 0, 1, 0}, {0x2003, 1, 1, 7}, {0x2003, 2, 1, 18},
                 {0x2003, 3, 1, 7}, {0x2003, 4, 1, 1}, {0x2003, 5, 1, 8}, {0x2003, 6, 1, 0}, {0x2003, 7, 4, 5},
                 {0x2003, 8, 4, BENCH_SAMPLES});
    TEST_ASSERT_TRUE(read_f64(0x2003, 9) == 315.0);
    TEST_ASSERT_TRUE(read_f64(0x2003, 10) == progress.angle_deg);
    TEST_ASSERT_EQUAL_UINT32(50, read_number(0x2003, 11, 1));
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_TRUE(progress.mean_v[i] == read_f64(0x2010, (uint8_t)(i + 1)));
        TEST_ASSERT_TRUE(progress.standard_error_v[i] == read_f64(0x2011, (uint8_t)(i + 1)));
        TEST_ASSERT_TRUE(progress.standard_error_v[i] > 0.0);
    }
}

static void test_a_failure_shows_state_reason_and_code(void)
{
    bench_start(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_MOVE, bench_run(&bench, TUMBLE_STATE_MOVE, 60.0));
    scripted_drive_fail(&bench.drive, &bench.fake, 0x7121);
    bench_pass(&bench, 0.1);
    ASSERT_READS({0x2000, 0, 1, TUMBLE_STATE_FAULT}, {0x2001, 0, 1, TUMBLE_REASON_DRIVE_FAULT},
                 {0x2004, 1, 1, TUMBLE_STATE_MOVE}, {0x2004, 2, 1, run_of(&bench)->status}, {0x2004, 3, 2, 0x7121});
}

static void test_counters(void)
{
    bench_start(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    const tumble_navcomp_counters_t counters = bench_counters(&bench);
    TEST_ASSERT_TRUE(read_number(0x2030, 1, 4) >= counters.link.sent);
    TEST_ASSERT_TRUE(read_number(0x2030, 2, 4) >= counters.link.received);
    TEST_ASSERT_EQUAL_UINT32(2, read_number(0x2031, 6, 4)); /* boot-ups */
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x2031, 7, 4)); /* starts */
    ASSERT_READS({0x2032, 1, 4, counters.block.samples}, {0x2033, 5, 4, 0}, {0x2034, 4, 4, 18U * BENCH_SAMPLES},
                 {0x2034, 5, 4, 18});
}

/* Written between runs only, and then in force. */
static void test_the_configuration_can_be_written_between_runs(void)
{
    power_on_for(1.0);
    ASSERT_READS({0x2050, 1, 4, BENCH_SAMPLES}, {0x2050, 2, 1, TUMBLE_ESTIMATE_REFINED}, {0x2050, 3, 2, 100},
                 {0x2050, 4, 1, 1});
    TEST_ASSERT_TRUE(read_f64(0x2050, 5) == 3e-4);
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2050, 1, 7));
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2050, 2, TUMBLE_ESTIMATE_LEAST_SQUARES));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2050, 3, (const uint8_t[]){60, 0}, 2));
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2050, 4, 5));
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 1e-3));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write_byte(0x2050, 2, 3));
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_u32(0x2050, 1, 100));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    for (int p = 0; p < 18; p++) {
        TEST_ASSERT_EQUAL_UINT32(7, bench.recorded[p]);
    }
    TEST_ASSERT_TRUE(read_f64(0x2022, 3) == 1e-3);
    TEST_ASSERT_TRUE(read_f64(0x2050, 5) == 1e-3);
    ASSERT_READS({0x2050, 2, 1, TUMBLE_ESTIMATE_LEAST_SQUARES}, {0x2050, 3, 2, 60}, {0x2050, 4, 1, 5});
    TEST_ASSERT_TRUE(bench.procedure.samples == BENCH_SAMPLES); /* the caller's own is const */
}

/* All objects of the table can be read, or are refused with a code that says why. */
static void test_every_object_answers(void)
{
    bench_start(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    TEST_ASSERT_TRUE(count_answers(&tumble_navcomp_table) > 100U);
}

static void test_the_state_pdo_follows_the_procedure(void)
{
    uint32_t seen = 0;
    uint32_t states = 0;
    tumble_can_frame_t frame;
    bench_start(&bench);
    while (run_of(&bench)->state != TUMBLE_STATE_DONE) {
        bench_inspect(&bench);
        tumble_navcomp_step(&bench.navcomp);
        while (fake_port_take(&bench.fake, &frame)) {
            if (frame.id == 0x181U) {
                TEST_ASSERT_EQUAL_UINT8(8, frame.length);
                TEST_ASSERT_EQUAL_UINT8(run_of(&bench)->state, frame.data[0]);
                TEST_ASSERT_EQUAL_UINT8(run_of(&bench)->reason, frame.data[1]);
                TEST_ASSERT_EQUAL_UINT8(run_of(&bench)->index, frame.data[2]);
                TEST_ASSERT_EQUAL_UINT8(run_of(&bench)->finished, frame.data[3]);
                TEST_ASSERT_EQUAL_UINT32(run_of(&bench)->samples, tumble_get_u32(&frame.data[4]));
                states |= UINT32_C(1) << frame.data[0];
                seen++;
            }
            bench_hear(&bench, &frame);
        }
        bench_event(&bench);
    }
    TEST_ASSERT_TRUE(seen > 18U);
    TEST_ASSERT_TRUE((states & (UINT32_C(1) << TUMBLE_STATE_MOVE)) != 0U);
    TEST_ASSERT_TRUE((states & (UINT32_C(1) << TUMBLE_STATE_AVERAGE)) != 0U);
}

static const around_t around_each = {bench_begin, NULL};
