"""A block that is bolted on once, on a simulated stand that is inclined: against the numpy geometry, and on the bus."""

import json
import math
import re
import subprocess
import sys
from dataclasses import replace

import gain_record
import numpy as np
import pytest
from c_compiler import compiled
from conftest import EXAMPLES
from documents import valid

from tumble import World, client, solve as solve_run
from tumble.model.geometry import STEP, Geometry, built_in
from tumble.model.inclined import as_seen, solve
from tumble.schedule import Schedule
from tumble.stand import PAPER_STAND
from tumble.world import in_process

K = np.array([[-2.02, 0.03, -0.01], [0.02, -1.97, 0.04], [-0.03, 0.01, -2.01]])
U0 = np.array([0.05, -0.08, 0.02])
NAMES = ("inclined", "inclined_closed")
QUIET = {"block.noise_v": 0.0, "motion.swing_deg": 0.0, "procedure.gravity_limit_g": 1.0,
         "procedure.estimator": "inclined"}  # fmt: skip


def inclined_force(schedule, alpha1, alpha2, alpha3, seat_h, seat_n, beta, tau, delta=0.0):
    """Of the numpy geometry, in which the inclinations are the schedule's own, and their zeros the angles'."""
    mountings = tuple(
        replace(one, tilt_deg=math.degrees(angle - alpha1)) for one, angle in zip(schedule.mountings, beta)
    )
    geometry = Geometry(Schedule(mountings, schedule.positions))
    delta = delta + np.asarray(tau)[geometry.mounting_index]
    return geometry.force(alpha1=alpha1, alpha2=alpha2, alpha3=alpha3, delta=delta, seat_h=seat_h, seat_n=seat_n)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """A function of seed, inclination, sag across and along: the errors of a simulated stand, and its forces."""
    parts = ("truth", "geometry", "scenario", "random", "maths")
    program = compiled(tmp_path_factory.mktemp("inclined") / "forces", "-Wall", "-Wextra", "-Werror", "-Ihost",
                       "-Ifirmware/include", "-Ifirmware", "tests/integration/inclined_harness.c",
                       *(f"host/simulation/{part}.c" for part in parts), "firmware/core/schedules.c",
                       "firmware/core/schedule_paper.c", "-lm")

    def forces(*words):
        done = subprocess.run([program, *map(repr, words)], text=True, capture_output=True, check=True)
        rows = [np.array(line.split(), float) for line in done.stdout.splitlines()]
        return rows[0], np.array(rows[1:5]).T, np.array(rows[5:])

    return forces


@pytest.mark.parametrize("seed", [1, 2, 3, 40])
def test_simulated_forces_are_those_of_the_numpy_geometry(simulated, seed):
    schedule = built_in("inclined_closed")
    for inclination in (0.0, 5e-3, 5e-2):
        (alpha1, alpha2), (alpha3, seat_h, seat_n, beta, tau), force = simulated(seed, inclination, 0.0, 0.0)
        assert all(len(set(shared.tolist())) == 1 for shared in (alpha3, seat_h, seat_n))  # of one bolting
        assert len(set(tau.tolist())) == (4 if inclination else 1)
        expected = inclined_force(schedule, alpha1, alpha2, alpha3, seat_h, seat_n, beta, tau)
        assert np.abs(force - expected).max() < 1e-12


def test_sagging_forces_are_those_of_the_numpy_geometry(simulated):
    """Along the axis the block leans by the force along it; across it, it droops as the axis does."""
    schedule = built_in("inclined_closed")
    for across, along in ((3e-3, 0.0), (0.0, -2e-3), (1e-3, 2e-3)):
        (alpha1, alpha2), (alpha3, seat_h, seat_n, beta, tau), force = simulated(9, 5e-2, across, along)
        leaning = seat_h + along * np.sin(beta)
        drooping = beta + across * np.cos(beta)
        expected = inclined_force(schedule, alpha1, alpha2, alpha3, leaning, seat_n, drooping, tau)
        assert np.abs(force - expected).max() < 1e-12


def worst_norm_error(schedule, force, seed=1, attitudes=20000):
    """Of the length of the specific force, g, over all attitudes, for the coefficients that these forces give."""
    k, u0, _ = solve(schedule, force @ K.T + U0)
    along = np.random.default_rng(seed).normal(size=(attitudes, 3))
    along /= np.linalg.norm(along, axis=1)[:, None]
    felt = np.linalg.solve(k, (along @ K.T + U0 - u0).T)
    return np.abs(np.linalg.norm(felt, axis=0) - 1.0).max()


@pytest.mark.parametrize(
    ("across", "along", "error_g"), [(1e-5, 0.0, 0.0), (0.0, 1e-5, 3.33e-6), (1e-5, 1e-5, 3.33e-6)]
)
def test_what_a_sag_of_the_block_against_the_axis_costs(simulated, across, along, error_g):
    """10 urad per g: nothing across the axis; along it 3.3 ug. Without any, rounding alone."""
    inclined = built_in("inclined")
    for seed in (1, 2):
        *_, force = simulated(seed, 0.0, across, along)
        assert worst_norm_error(inclined, force[:27]) == pytest.approx(error_g, rel=0.02, abs=2e-12)
        *_, force = simulated(seed, 5e-3, 0.0, 0.0)
        assert worst_norm_error(inclined, force[:27]) < 2e-12


def outputs(schedule, truth):
    """What the block puts out on the stand that a document tells."""
    force = inclined_force(
        schedule,
        truth["alpha1_rad"],
        truth["alpha2_rad"],
        *(np.array(truth[name]) for name in ("alpha3_rad", "theta_h_rad", "theta_n_rad", "beta_rad", "tau_rad")),
        np.array(truth["alpha4_rad"]),
    )
    return force @ np.array(truth["K"]).T + np.array(truth["U0"])


@pytest.mark.parametrize("name", NAMES)
def test_the_means_of_a_run_are_what_its_truth_says(name):
    """To half a count of the converter, on a stand as bad as one can be: inclinations off by 20 mrad."""
    errors = {"stand.inclination_rad": 2e-2, "stand.axis_tilt_rad": 1e-2, "stand.seat_rad": 1e-3,
              "stand.platform_rad": 1e-3}  # fmt: skip
    schedule = built_in(name)
    world = World(7, schedule=name, samples=10, **QUIET, **errors).run()
    means = np.array([mean["u_v"] for mean in world.document["means"]])
    assert (world.state, len(means)) == ("DONE", 9 * len(schedule.mountings))
    assert np.abs(means - outputs(schedule, world.truth)).max() < 0.51 * 20.0 / 2**24
    seen = solve(schedule, means)[2]
    beta, tau = np.array(world.truth["beta_rad"]), np.array(world.truth["tau_rad"])
    assert np.abs(seen.beta - beta).max() < 1e-4 and np.abs(seen.tau - (tau - tau[0])).max() < 1e-4
    nominal = np.deg2rad([one.tilt_deg for one in schedule.mountings])
    assert np.abs(beta - nominal).max() > 5e-3  # it is no nominal stand


PAPER = (EXAMPLES / "paper_stand.toml").read_text()
STANDS = [  # what the stand file says besides
    (),
    ("inclination_rad = 5e-3",),
    ("inclination_rad = 5e-3", "noise_v = [1e-4, 3.3e-4, 7.7e-4]"),  # weights per channel, to the last bit
    ("seat_rad = 1e-3", "noise_v = [0.0, 3e-4, 3e-4]", 'limits = "sigma3"'),
    ("noise_v = [3e-4, 1e-3, 6e-4]", 'limits = "uniform"'),
]


def stand_file(folder, *lines):
    """The paper's stand with other lines."""
    text = PAPER
    for line in lines:
        key = line.partition(" =")[0]
        text = re.sub(rf"^{key} = .*", line, text, flags=re.MULTILINE) if f"\n{key} = " in text else text.replace(
            "[stand]", f"[stand]\n{line}", 1)  # fmt: skip
    (folder / "stand.toml").write_text(text)
    return folder / "stand.toml"


@pytest.mark.parametrize("lines", STANDS)
@pytest.mark.parametrize("name", NAMES)
def test_the_result_of_a_bench_run_is_confirmed_and_says_the_true_inclinations(name, lines, tumble, tmp_path):
    """Firmware, core and numpy agree on K, U0 and what they state of them; within five uncertainties of the truth."""
    words = ("--schedule", name, "--estimator", "inclined", "--stand", stand_file(tmp_path, *lines))
    told = ("--set", "stand.inclination_rad=5e-3") if not any("inclination" in line for line in lines) else ()
    done = tumble("bench", *words, *told, "--seed", "4", "--limit", "1e-3", "--json", "--out", tmp_path / "run")
    assert done.returncode in (0, 1), done.stderr
    result = valid(done.stdout, "result")
    truth, found = result["truth"], result["inclinations"]
    beta, tau = np.rad2deg(truth["beta_rad"]), np.rad2deg(truth["tau_rad"])
    u_deg = np.array([one["u_deg"] for one in found])
    assert np.abs(beta - [one["deg"] for one in found]).max() < 5 * u_deg.max()
    assert np.abs(tau - tau[0] - [one["zero_deg"] for one in found]).max() < 5 * u_deg.max()
    schedule = built_in(name)
    assert np.abs(beta - [one.tilt_deg for one in schedule.mountings]).max() > 0.02
    scenario = (tmp_path / "run/inputs/scenario.txt").read_text()
    assert len(re.findall(r"^mounting = .* 1$", scenario, re.MULTILINE)) == len(schedule.mountings)
    again = tumble("bench", *words, *told, "--seed", "4", "--limit", "1e-3", "--out", tmp_path / "again",
                   "--scenario", tmp_path / "run/inputs/scenario.txt")  # fmt: skip
    assert again.returncode == done.returncode
    assert (tmp_path / "again/run.csv").read_bytes() == (tmp_path / "run/run.csv").read_bytes()


SEEN = [f"Inclinations seen: {name}" for n in range(1, 7) for name in (f"Inclination {n}", f"u_inclination {n}")]
LEVEL = ["Inclinations seen: level", "Inclinations seen: u_level"]
ANGLES_SEEN = ("alpha1", "alpha2_plus_alpha3", "alpha3_difference", "alpha4")
STAND_SEEN = [f"Stand seen: {name}" for name in (*ANGLES_SEEN, "noise")]


@pytest.mark.parametrize("name", ["inclined", "inclined_closed", "paper"])
def test_a_node_says_the_inclinations_of_its_run_as_solve_does(name, tmp_path):
    """2141h against the run's result on the host; of the angles that 2140h tells of other schedules it tells none."""
    pytest.importorskip("can", reason="python-can is not installed")
    pytest.importorskip("canopen", reason="python-canopen is not installed")
    from tumble.testing.virtual_bus import time_of

    stand = stand_file(tmp_path, "inclination_rad = 5e-3", "axis_tilt_rad = 1e-2")
    keys = {"keeper.serial": "B-17", "procedure.estimator": "refined" if name == "paper" else "inclined",
            "procedure.gravity_limit_g": 1e-2, "firmware.starts": False}  # fmt: skip
    world = World(4, schedule=name, stand=stand, samples=50, memory=True, operator="on-confirm", **keys)
    with world.bus() as bus, time_of(bus), client.connect(bus) as node:
        assert node.read(SEEN[0]) is None
        node.start()
        while node.wait(until=("WAIT_MOUNTING", "DONE"), timeout=600) != "DONE":
            node.confirm()
        node.result()
        seen = [node.read(one) for one in (*SEEN, *LEVEL)]
        told = [node.read(one) is not None for one in STAND_SEEN]
    if name == "paper":
        assert set(seen) == {None} and told[:3] == [True] * 3
        return
    in_process.write(world._border, tmp_path)
    run = str(tmp_path / "run.csv")
    result = json.loads(solve_run(run, stand=str(stand), schedule=name, estimator="inclined").to_json())
    count = len(result["inclinations"])
    deg, u_deg = ([one[key] for one in result["inclinations"]] for key in ("deg", "u_deg"))
    assert seen[0 : 2 * count : 2] == pytest.approx(deg, abs=1e-10)
    assert seen[1 : 2 * count : 2] == pytest.approx(u_deg, rel=1e-6)
    assert seen[2 * count : 12] == [None] * (12 - 2 * count)
    assert seen[12] == pytest.approx(result["level_rad"], abs=1e-12)
    assert seen[13] == pytest.approx(result["u_level_rad"], rel=1e-6)
    assert told == [False] * 4 + [True]


@pytest.mark.parametrize("lines", [(), ("noise_v = [1e-4, 3.3e-4, 7.7e-4]", "seat_rad = 1e-3", "drift_v = 1e-5")])
@pytest.mark.parametrize("name", NAMES)
def test_optimal_takes_a_record_on_board_where_inclinations_are_declared(name, lines, tumble, tmp_path):
    """Declared to 10 mrad: firmware, core and numpy agree, and a solve of the folder with weights of its own."""
    stand = stand_file(tmp_path, "inclination_rad = 1e-2", *lines)
    words = ("--schedule", name, "--estimator", "optimal", "--stand", stand, "--limit", "1e-3", "--json")
    done = tumble("bench", *words, "--seed", "4", "--out", tmp_path / "run")
    assert done.returncode in (0, 1), done.stderr
    result = valid(done.stdout, "result")
    record = gain_record.from_bytes((tmp_path / "run/inputs/gains.bin").read_bytes())
    assert (record.inclinations, record.sigma_inclination) == (len(built_in(name).mountings), 1e-2)
    beta = np.array([one["deg"] for one in result["inclinations"]])
    nominal = [one.tilt_deg for one in built_in(name).mountings]
    assert np.abs(beta - np.rad2deg(result["truth"]["beta_rad"])).max() < 0.01
    assert np.abs(beta - nominal).max() > 0.2
    again = tumble("solve", tmp_path / "run/run.csv", *words)
    assert again.returncode == done.returncode, again.stderr
    solved = valid(again.stdout, "result")
    apart = np.array(solved["K"]) - result["K"]
    assert np.abs(apart / result["u_K"]).max() < 0.05


@pytest.mark.parametrize("command", [("bench",), ("plan", "optimize")])
def test_optimal_is_refused_on_board_where_inclinations_are_not_declared(command, tumble, tmp_path):
    words = ("--schedule", "inclined", "--stand", stand_file(tmp_path))
    done = tumble(*command, *words, *(("--estimator", "optimal") if command == ("bench",) else ()), cwd=tmp_path)
    said = ("a gain record needs inclination_rad, how well the stand is inclined: declare it, or take inclined on"
            " board; solve and plan validate have optimal without")  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"tumble: {said}\n")


def test_a_person_inclines_the_stand_and_bolts_the_block_on_once(tmp_path):
    words = ("--schedule", "inclined", "--estimator", "inclined", "--interactive")
    done = subprocess.run([sys.executable, "-m", "tumble", "bench", *words, "--out", str(tmp_path / "run")], text=True,
                          input="\n" * 3, capture_output=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    questions = r"^(?:Mount the block as mounting \d|The block stays bolted on as it is\. Incline)"
    asked = re.findall(questions, done.stderr, re.MULTILINE)
    assert asked == ["Mount the block as mounting 1", *["The block stays bolted on as it is. Incline"] * 2]


def answered(world, *answers):
    """Let it go on from question to question. Returns the mountings that were asked for."""
    asked = []
    for words in answers:
        while world.question is None:
            assert world.advance(1.0)
        asked.append(world.question["mounting"])
        world.answer(words)
    return asked


def test_an_inclination_that_is_repeated_is_set_anew_and_the_block_stays_bolted_on():
    errors = {"stand.inclination_rad": 5e-3, "stand.seat_rad": 1e-3}
    world = World(5, schedule="inclined", samples=10, operator="asked", **QUIET, **errors)
    before = world.truth
    asked = answered(world, "done", "done", "repeat mounting 2", "done", "done")
    assert asked == [1, 2, 3, 2, 3]
    world.run()
    after = world.truth
    assert world.state == "DONE"
    for name in ("alpha3_rad", "theta_h_rad", "theta_n_rad"):
        assert before[name] == after[name] and len(set(after[name])) == 1
    for name in ("beta_rad", "tau_rad"):
        assert [one == other for one, other in zip(before[name], after[name])] == [True, False, True]
    means = np.array([mean["u_v"] for mean in world.document["means"]])
    assert np.abs(means - outputs(built_in("inclined"), after)).max() < 0.51 * 20.0 / 2**24


@pytest.mark.parametrize("inclination", [1, 2, 3])
def test_after_a_loss_of_power_the_run_goes_on_at_its_inclination(inclination):
    """Nobody has touched the stand, and somebody says so: what was measured there is kept, and the rest is measured at
    the same inclination. The others are asked for once."""
    keys = {"keeper.serial": "B-17", "stand.inclination_rad": 5e-3, "stand.seat_rad": 1e-3}
    world = World(5, schedule="inclined", samples=10, memory=True, operator="asked", **QUIET, **keys)
    answered(world, *["done"] * inclination)
    for _ in range(4):
        assert world.advance(until="AVERAGE") and world.advance(until="MOVE")
    set_up = world.truth
    world.cut_power()
    assert world.advance(0.5)
    world.restore_power()
    assert world.advance(0.5) and world.state == "IDLE"
    world.send(0x601, bytes.fromhex("2F02200207000000"))  # RESUME
    assert world.advance(until="WAIT_MOUNTING") and world.question["mounting"] == inclination
    world.send(0x601, bytes.fromhex(f"2F022001{inclination:02X}000000"))
    assert world.advance(0.1)
    world.send(0x601, bytes.fromhex("2F02200203000000"))  # CONFIRM_MOUNTING
    assert world.advance(until="AVERAGE")
    assert answered(world, *["done"] * (3 - inclination)) == list(range(inclination + 1, 4))
    world.run()
    before = 9 * (inclination - 1) + 3  # the fourth was not in memory yet
    assert (world.state, world.reason) == ("DONE", "NONE")
    assert world.document["counters"]["positions_kept"] == 27 - before
    assert set_up["theta_h_rad"] == world.truth["theta_h_rad"]
    assert set_up["beta_rad"][:inclination] == world.truth["beta_rad"][:inclination]
    means = np.array([mean["u_v"] for mean in world.document["means"]])
    assert np.abs(means - outputs(built_in("inclined"), world.truth)).max() < 0.51 * 20.0 / 2**24


@pytest.mark.parametrize("name, mounted, inclined", [("inclined", 1, 2), ("inclined_closed", 1, 3), ("paper", 2, 0)])
def test_a_simulated_operator_takes_the_time_of_what_he_does(name, mounted, inclined):
    def seconds(**keys):
        at_once = {"operator.mount_s": 0.0, "operator.incline_s": 0.0}
        world = World(5, schedule=name, samples=10, **{**QUIET, **at_once, **keys})
        while world.state != "DONE":
            world.advance(1.0)
        return world.now_s

    keys = {"procedure.estimator": "refined"} if name == "paper" else {}
    at_once = seconds(**keys)
    assert seconds(**keys, **{"operator.mount_s": 20.0}) == pytest.approx(at_once + 20.0 * mounted, abs=1.0)
    assert seconds(**keys, **{"operator.incline_s": 20.0}) == pytest.approx(at_once + 20.0 * inclined, abs=1.0)


def test_a_plain_schedule_tells_no_inclinations_and_has_none():
    plain = World(3).truth
    assert "beta_rad" not in plain and "tau_rad" not in plain
    assert World(3, **{"stand.inclination_rad": 1e-2}).truth == plain


# What nobody measures, an order of magnitude larger than it needs to be.
UNKNOWN = {"stand.inclination_rad": 1e-2, "stand.axis_tilt_rad": 1e-2, "stand.level_rad": 1e-3,
           "stand.remount_rad": 1e-3, "stand.seat_rad": 1e-3}  # fmt: skip


def shown(schedule, means):
    """All that a run shows: K row by row, U0, the inclinations, and the zeros of the angle but for the first."""
    k, u0, seen = solve(schedule, means)
    return np.concatenate([k.reshape(*k.shape[:-2], 9), u0, seen.beta, seen.tau[..., 1:]], axis=-1)


def true_of(truth):
    """The same of its truth, K in the frame of the table at the first inclination: yaw, seat and zero of the angle turn
    the block against it."""
    yaw, lean = truth["alpha3_rad"][0], truth["theta_h_rad"][0]
    zero = truth["alpha2_rad"] + truth["theta_n_rad"][0] + truth["tau_rad"][0]
    about_v = [[math.cos(yaw), math.sin(yaw), 0.0], [-math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]]
    about_h = [[1.0, 0.0, 0.0], [0.0, math.cos(lean), math.sin(lean)], [0.0, -math.sin(lean), math.cos(lean)]]
    about_n = [[math.cos(zero), 0.0, math.sin(zero)], [0.0, 1.0, 0.0], [-math.sin(zero), 0.0, math.cos(zero)]]
    k = np.array(truth["K"]) @ about_v @ about_h @ about_n
    tau = np.array(truth["tau_rad"])
    return np.concatenate([k.ravel(), truth["U0"], truth["beta_rad"], tau[1:] - tau[0]])


def uncertainties(schedule, means, stand):
    """Standard uncertainties of what a run shows, by noise and set angles: complex steps of each mean."""
    k, _, seen = solve(schedule, means)
    stepped = np.tile(means.astype(complex), (means.size, 1, 1))
    stepped.reshape(means.size, -1)[np.arange(means.size), np.arange(means.size)] += 1j * STEP
    gains = np.imag(shown(schedule, stepped)).T.reshape(-1, *means.shape) / STEP
    turned = Geometry(as_seen(schedule, seen)).force_by(delta=1.0) @ k.T
    by_noise = (stand.mean_sigma(stand.samples) ** 2 * gains**2).sum(axis=(1, 2))
    by_angles = ((gains * turned).sum(axis=2) ** 2).sum(axis=1) * stand.sigma("angle") ** 2
    return np.sqrt(by_noise + by_angles)


@pytest.mark.parametrize("runs", [30, pytest.param(1000, marks=pytest.mark.full)])
def test_errors_of_optimal_on_board_are_as_large_as_the_firmware_says(runs, tmp_path):
    """By a record, inclinations off by 10 mrad, in the frame of the block, with all that the stand declares. The
    uncertainties of a record are at the K that it was made for, so the block has that K."""
    stand, z = stand_file(tmp_path, "inclination_rad = 1e-2", "seat_rad = 1e-4", "angle_rad = 2e-4"), []
    declared = np.full((3, 3), 0.04) + 1.96 * np.eye(3)
    text = re.sub(r"^K = \[\n.*?^\]$", f"K = {declared.tolist()}", stand.read_text(), flags=re.DOTALL | re.MULTILINE)
    stand.write_text(text)
    for seed in range(1, runs + 1):
        world = World(seed, stand=stand, schedule="inclined", **{"procedure.estimator": "optimal"}).run()
        document, truth = world.document, world.truth
        assert (world.state, world.reason, truth["K"]) == ("DONE", "NONE", declared.tolist())
        u = np.array([*np.ravel(document["u_K"]), *document["u_U0"]])
        z.append((np.array([*np.ravel(document["K"]), *document["U0"]]) - [*np.ravel(truth["K"]), *truth["U0"]]) / u)
    z = np.array(z)
    print(f"z of {runs} runs: rms {np.sqrt((z**2).mean()):.3f}")
    assert np.sqrt((z**2).mean()) == pytest.approx(1.0, abs=0.12 if runs < 100 else 0.05)
    assert np.abs(np.sqrt((z**2).mean(axis=0)) - 1.0).max() < 3.9 / math.sqrt(2 * runs)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("runs", [40, pytest.param(1000, marks=pytest.mark.full)])
def test_errors_of_bench_runs_are_as_large_as_noise_and_set_angles_make_them(name, runs):
    """K, U0, inclinations and zeros, found by the firmware or in numpy: z = error / u is of rms 1, each and all."""
    schedule, z = built_in(name), []
    for seed in range(1, runs + 1):
        world = World(seed, schedule=name, **{"procedure.estimator": "inclined"}, **UNKNOWN).run()
        document = world.document
        means = np.array([mean["u_v"] for mean in document["means"]])
        found = shown(schedule, means)
        assert (world.state, world.reason) == ("DONE", "NONE")
        assert np.abs(found[:12] - [*np.ravel(document["K"]), *document["U0"]]).max() < 1e-12 * 2.0
        z.append((found - true_of(world.truth)) / uncertainties(schedule, means, PAPER_STAND))
    z = np.array(z)
    assert np.sqrt((z**2).mean()) == pytest.approx(1.0, abs=0.1 if runs < 100 else 0.05)
    assert np.abs(np.sqrt((z**2).mean(axis=0)) - 1.0).max() < 3.9 / math.sqrt(2 * runs)
