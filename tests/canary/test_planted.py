"""Planted bugs: with one in a copy of the sources, the unit test that guards against it fails by its own assertion."""
import re
import shutil

import pytest
from conftest import ROOT, configured, planted, run

COPIED = ("boards", "cmake", "firmware", "host", "tests")

# Bug: (file, text, what stands there instead, suite of tests/unit, case that must fail).
PLANTED = {
    # Three that once survived the unit tests; nothing caught the second one.
    "commit rule: the uncertainty of K_xx for all": (
        "firmware/sets/rules.c",
        "const double u_new = uncertainty_of(candidate, c);",
        "const double u_new = uncertainty_of(candidate, 0);",
        "store/test_commit_rules.c", "test_change_by_the_uncertainty_of_the_same_coefficient"),
    "mark: valid for any record": (
        "firmware/sets/store.c",
        "(tumble_get_u32(&mark[MARK_CRC]) == tumble_set_crc(bytes))",
        "true",
        "store/test_store.c", "test_a_mark_is_of_its_own_record_alone"),
    "service level: holds for another session": (
        "host/gateway/session.c",
        "return gateway->service == session && now_us <",
        "return gateway->service != NULL && now_us <",
        "gateway/test_gateway_service.c", "test_it_holds_for_the_session_that_opened_it_last"),
    # Nine of the kinds that unit tests caught.
    "stop ladder: no NMT stop": (
        "firmware/stand/drive402/axis.c",
        "(void)tumble_nmt_command(&drive->node->nmt, drive->drive_node, TUMBLE_NMT_STOP);",
        "",
        "stand/test_drive402_stop.c", "test_the_third_way_is_nmt"),
    "position: a turn is guessed after silence": (
        "firmware/stand/drive402/axis.c",
        "(is_in_reach(drive, size_of(change)) && !is_guess(drive))",
        "is_in_reach(drive, size_of(change))",
        "stand/test_drive402_position.c", "test_a_turn_is_not_guessed_after_silence"),
    "homing: wherever it ends is home": (
        "firmware/stand/drive402/phases.c",
        "is_home(drive, is_offset ? (int32_t)tumble_sdo_client_u32(client) : 0)",
        "true",
        "stand/test_drive402_position.c", "test_a_homing_that_leaves_the_position_elsewhere"),
    "homing: no bound": (
        "firmware/stand/drive402/axis.c",
        "(drive->travel > drive->homing_counts)",
        "false",
        "stand/test_drive402_position.c", "test_homing_turns_no_further_than_the_cable_and_a_turn"),
    "cable: the lead-in may go beyond it": (
        "firmware/procedure/procedure_checks.c",
        "!tumble_exceeds(config->cable_min_deg, angle_deg - config->approach_deg)",
        "!tumble_exceeds(config->cable_min_deg, angle_deg)",
        "procedure/test_procedure_moves.c", "test_always_from_below_and_never_beyond"),
    "record: any CRC": (
        "firmware/sets/record.c",
        "tumble_record_is_sealed(bytes, record->crc_at, crc_before) ? TUMBLE_OK : TUMBLE_E_CRC",
        "TUMBLE_OK",
        "store/test_store.c", "test_what_has_decayed_is_found_out_and_the_next_is_active"),
    "calibration counter: given twice": (
        "firmware/sets/store.c",
        "(sequence > store->highest) ? sequence : store->highest",
        "sequence",
        "store/test_store.c", "test_no_counter_is_given_twice"),
    "objection OLDER: to what is newer": (
        "firmware/sets/rules.c",
        "are_dated(candidate, active) && (candidate->date_utc_s < active->date_utc_s)",
        "are_dated(candidate, active) && (candidate->date_utc_s > active->date_utc_s)",
        "store/test_commit_rules.c", "test_block_and_date"),
    "accumulator: one sample too many": (
        "firmware/core/averaging_sample.c",
        "->samples >= (uint32_t)TUMBLE_MAX_SAMPLES",
        "->samples > (uint32_t)TUMBLE_MAX_SAMPLES",
        "averaging/test_averaging.c", "test_the_last_sample_that_fits_is_taken"),
    "power cut: the mark comes before its record": (
        "firmware/sets/store.c",
        "CELL_ERASE | IN_PROPOSAL, CELL_BODY | IN_PROPOSAL, CELL_MARK | IN_PROPOSAL,",
        "CELL_ERASE | IN_PROPOSAL, CELL_MARK | IN_PROPOSAL, CELL_BODY | IN_PROPOSAL,",
        "store/test_store.c", "test_a_loss_of_power_before_the_mark_leaves_the_record_alone"),
    # Others, one for each step from a sample to a set in force.
    "block frame: its last byte is outside the CRC": (
        "firmware/sample/block_frames.c",
        "i <= CRC",
        "i < CRC",
        "block_frames/test_block_frames.c", "test_every_error_of_up_to_three_bits_is_detected"),
    "settling: goes on when the table moves again": (
        "firmware/procedure/procedure_states.c",
        "!= (uint8_t)TUMBLE_STAND_IN_POSITION) {\n        procedure->settled_ms = 0;",
        "!= (uint8_t)TUMBLE_STAND_IN_POSITION) {",
        "procedure/test_procedure.c", "test_settling_starts_again_when_the_table_moves_again"),
    "schedule: a reflection is a mounting": (
        "firmware/core/schedule.c",
        "return tumble_is_positive(tumble_dot(cross, m[2]));",
        "return true;",
        "schedule/test_schedule_validate.c", "test_every_rotation_of_a_cube_is_accepted_and_no_reflection"),
    "estimator: the last position of nine is left out": (
        "firmware/core/closed_form.c",
        "((u[0] - u[4]) + (u[8] - u[4]))",
        "(2.0 * (u[0] - u[4]))",
        "estimators/test_estimator.c", "test_they_are_the_published_functionals_on_any_data"),
    "uncertainty: a yaw common to all mountings is none": (
        "firmware/core/uncertainty.c",
        "stand->common_yaw ? tumble_square(response->common[ALPHA3]) : response->yaws_squared",
        "response->yaws_squared",
        "uncertainty/test_uncertainty.c", "test_one_yaw_or_two"),
    "gravity check: positions that only check are not judged": (
        "firmware/core/verification.c",
        "tumble_within(check->max_abs_fit_g, limit_g) && tumble_within(check->max_abs_check_g, limit_g)",
        "tumble_within(check->max_abs_fit_g, limit_g)",
        "core/test_verification.c", "test_the_limit_itself_passes"),
    "gain record: of another schedule": (
        "firmware/core/gain_record.c",
        "(record->schedule_crc == tumble_gain_record_schedule_crc(schedule))",
        "true",
        "estimators/test_gain_record.c", "test_a_record_of_another_schedule_is_refused"),
    "SDO: the abort of an earlier request ends this one": (
        "firmware/canopen/sdo_client.c",
        "if ((client->phase == PHASE_FIRST) && !names_object(client, frame)) {",
        "if (false) {",
        "canopen/test_canopen_sdo_client_faults.c", "test_late_answers_are_ignored_and_counted"),
    "heartbeat: a lost node is not remembered": (
        "firmware/canopen/nmt.c",
        "consumer->lost = true;",
        "",
        "canopen/test_canopen_heartbeat.c", "test_the_error_stays_while_another_node_is_silent"),
    "run number: every run has the same": (
        "firmware/navcomp/service.c",
        "tumble_count(&navcomp->run_number);",
        "",
        "navcomp/test_navcomp_service.c", "test_runs_are_numbered"),
    "resume: by a configuration written meanwhile": (
        "firmware/navcomp/keeper_run.c",
        "(keeper->fingerprint != fingerprint_of(keeper)) || tumble_keeper_is_inhibited(keeper)",
        "tumble_keeper_is_inhibited(keeper)",
        "keeper/test_keeper_resume.c", "test_a_configuration_written_meanwhile"),
    "fingerprint: without the calibration counter": (
        "firmware/navcomp/fingerprint.c",
        "(double)tumble_stand_fingerprint(navcomp), (double)sequence};",
        "(double)tumble_stand_fingerprint(navcomp), 0.0};",
        "keeper/test_keeper_resume.c", "test_a_committed_run_is_not_gone_on_with"),
    "simulation: a stop needs no way": (
        "host/simulation/axis.c",
        "sim_motion_stop(&axis->motion, position, velocity, deceleration_deg_s2);",
        "sim_motion_rest(&axis->motion, position);",
        "simulation/test_sim_axis.c", "test_a_stop_leaves_the_table_where_it_is"),
    # The bounds of a motion.
    "motion: its way is not bounded upwards": (
        "firmware/stand/bounds.c",
        "if ((here < bounds->lowest_mdeg) || (here > bounds->highest_mdeg)) {",
        "if (here < bounds->lowest_mdeg) {",
        "stand/test_bounds.c", "test_past_the_goal_and_the_other_way"),
    "motion: its time is not bounded": (
        "firmware/stand/bounds.c",
        "if ((late <= (uint32_t)INT32_MAX) && (late > margin_ms)) {",
        "if (false) {",
        "stand/test_bounds.c", "test_a_homing_that_never_ends"),
    "motion: reports that stand still are progress": (
        "firmware/stand/bounds.c",
        "if (stalls(bounds, motion, here, now, margin_ms)) {",
        "if (false) {",
        "stand/test_bounds.c", "test_reports_that_stand_still_or_flicker"),
    "set-point by SDO: a stranger's is none": (
        "firmware/navcomp/navcomp_events.c",
        " || commands_by_sdo(navcomp, frame);",
        ";",
        "navcomp/test_navcomp_bus.c", "test_a_set_point_of_a_stranger_by_sdo_is_foreign"),
}
SUITES = sorted({suite for *_, suite, _ in PLANTED.values()})


def unity():
    """Where the usual build of the unit tests has it from."""
    cache = (configured("sanitizers", "-DTUMBLE_TESTS=ON") / "CMakeCache.txt").read_text(encoding="utf-8")
    return re.search(r"^TUMBLE_UNITY_DIR:PATH=(.*)$", cache, re.MULTILINE)[1]


@pytest.fixture(scope="module")
def copied(tmp_path_factory, sanitizers):
    """A copy of the sources with a build of the suites that are named, and of no others."""
    tree = tmp_path_factory.mktemp("planted")
    for folder in COPIED:
        shutil.copytree(ROOT / folder, tree / folder, ignore=shutil.ignore_patterns("*.py"))
    for file in ("CMakeLists.txt", "VERSION"):
        shutil.copy(ROOT / file, tree)
    listed = (tree / "tests/unit/CMakeLists.txt").read_text(encoding="utf-8")
    for suite in (tree / "tests/unit").glob("*/test_*.c"):
        if f"{suite.parent.name}/{suite.name}" not in SUITES and suite.name not in listed:
            suite.unlink()
    ready = run("cmake", "-S", tree, "-B", tree / "build", "-G", "Ninja", "-DTUMBLE_TESTS=ON", "-DCMAKE_C_FLAGS=-w",
                f"-DFETCHCONTENT_SOURCE_DIR_UNITY={unity()}")
    assert ready.returncode == 0, ready.stdout
    return tree


def verdicts(tree, folder):
    """What each case of a program says of itself, by suite and name. One that ends the program says nothing."""
    built = run("cmake", "--build", tree / "build", "--target", f"test_{folder}")
    assert built.returncode == 0, built.stdout
    said = re.findall(rf"/({folder}/test_\w+\.c):\d+:(\w+):(PASS|FAIL)\b",
                      run(tree / "build/tests/unit" / f"test_{folder}").stdout)
    return {(suite, case): verdict for suite, case, verdict in said}


def survives(tree, file, text, instead, suite, case):
    """Does the case pass all the same?"""
    with planted(tree, [(file, text, instead)]):
        return verdicts(tree, suite.split("/")[0])[suite, case] == "PASS"


@pytest.mark.parametrize("folder", sorted({suite.split("/")[0] for suite in SUITES}))
def test_without_a_bug_the_tests_pass(copied, folder):
    said = verdicts(copied, folder)
    assert {said[suite, case] for *_, suite, case in PLANTED.values() if suite.startswith(f"{folder}/")} == {"PASS"}


@pytest.mark.parametrize("bug", PLANTED)
def test_a_bug_is_caught(copied, bug):
    assert not survives(copied, *PLANTED[bug])


def test_what_is_no_bug_survives(copied):
    file, text, _, suite, case = PLANTED["mark: valid for any record"]
    assert survives(copied, file, text, f"{text} /* and nothing else */", suite, case)
