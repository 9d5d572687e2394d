"""python-canopen drives whole recalibrations, knowing nothing but the EDS file and the names in docs/canopen.md."""

import functools
import struct

import pytest
from c_compiler import compiled, firmware_sources
from canopen_bridge import FLAGS, PipeBus, canopen
from recalibration import Computer, entries_of, refusal_of, signature

pytestmark = pytest.mark.real_time

LOOSE = 1e-3  # a limit that the bench's block keeps
DEVICE_STATE, STORE, VALUE = 0x08000022, 0x08000020, 0x06090030


@functools.cache
def build(folder):
    """tests/integration/recalibration_harness.c with the firmware, once."""
    includes = ["-Itests/integration/plain_unity", "-Ihost", "-Itests/lib", "-DUNITY_INCLUDE_DOUBLE"]
    own = ["tests/integration/recalibration_harness.c", "host/simulation/block_encode.c"]
    own += [f"tests/lib/{name}.c" for name in ("keeper_bench", "keeper_memory", "navcomp_bench", "flash",
                                               "scripted_block", "scripted_config", "scripted_drive")]
    return compiled(folder / "recalibration_harness", *FLAGS, *includes, *own, *firmware_sources())


class Bench:
    """The computer, and the hands that mount its block, age it and cut its power."""

    def __init__(self, program):
        self.bus = PipeBus(program, "bench")
        self.network = canopen.Network(self.bus)
        self.network.NOTIFIER_CYCLE = 0.005
        self.network.connect()
        self.computer = Computer(self.network, self.bus.let_pass, lambda number: self.tell(f"!mount {number}"))

    def tell(self, line):
        self.bus.tell(line)
        assert self.bus.results.get(timeout=60) == ["passed"]

    def drift(self, nanovolts):
        self.tell(f"!drift {nanovolts}")

    def power_cycle(self):
        self.tell("!power")

    def broadcast(self):
        """(counter, objections, verdict, due) of the last transmit PDO 4."""
        last = next(line for line in reversed(self.bus.log) if line.startswith("681#"))
        return struct.unpack("<IHBB", bytes.fromhex(last[4:]))

    def close(self):
        self.network.disconnect()
        self.bus.shutdown()


@pytest.fixture
def bench(tmp_path_factory):
    opened = Bench(build(tmp_path_factory.getbasetemp() / "recalibration"))
    yield opened
    opened.close()


def test_a_life_from_the_first_set_to_a_rollback(bench):
    computer = bench.computer
    computer["Host"]["Calendar"].raw = 1_800_000_000
    computer["Recalibration"]["Gravity"].raw = 9.81
    computer.set_rules(LOOSE, 1e-4)

    assert computer.counter() == 0
    computer.calibrate()
    first = computer.coefficients()
    assert computer.counter() == 1 and computer.objections() == set()
    assert computer.coefficients("Active set: ") == first
    assert computer["Active set"]["Block serial"].raw == "TB-0001"
    assert 0 <= computer["Active set"]["Date"].raw - 1_800_000_000 < 3600
    assert computer["Active set"]["Gravity"].raw == 9.81
    stated = [entry.raw for name in ("u_K", "u_U0") for entry in entries_of(computer[name])]
    stored = [entry.raw for name in ("u_K", "u_U0") for entry in entries_of(computer[f"Active set: {name}"])]
    assert stored == stated and min(stated) > 0

    bench.drift(2_000_000)  # 1e-3 g, ten times what a month may do
    computer.calibrate()
    proposed = computer.coefficients()
    assert computer.counter() == 1 and computer.objections() == {"CHANGE"}
    assert computer["Keeper"]["Proposal present"].raw
    assert computer.coefficients("Proposal: ") == proposed and computer.coefficients("Active set: ") == first
    assert computer["Proposal"]["Reasons"].raw == computer["Keeper"]["Objections"].raw

    computer.accept()
    computer.settle()
    assert computer.counter() == 2 and not computer["Keeper"]["Proposal present"].raw
    assert computer.coefficients("Active set: ") == proposed
    bench.bus.let_pass(100)
    assert bench.broadcast()[0] == 2
    assert refusal_of(computer.command, "ACCEPT") == DEVICE_STATE
    assert refusal_of(computer.command, "DISCARD") == DEVICE_STATE

    computer.command("ROLLBACK")
    computer.settle()
    assert computer.counter() == 3 and computer.coefficients("Active set: ") == first
    assert computer["Active set"]["Restores"].raw == 1
    bench.bus.let_pass(100)
    assert bench.broadcast()[0] == 3

    computer["Recalibration"]["Interval"].raw = 86_400
    computer.save()
    bench.power_cycle()
    assert computer.counter() == 3 and computer.coefficients("Active set: ") == first
    assert computer["Recalibration"]["Interval"].raw == 86_400
    assert computer["Commit rules"]["Flags"].raw == 3
    assert computer["History"]["Entries"].raw == 3
    assert computer["Parameters"]["Refused"].raw == 0


def test_a_discarded_proposal_leaves_no_trace(bench):
    computer = bench.computer
    computer.set_rules(LOOSE, 1e-4, flags=0)
    computer.calibrate()
    assert computer.objections() == {"FIRST", "BY_HAND"}
    computer.command("DISCARD")
    computer.settle()
    assert computer.counter() == 0 and not computer["Keeper"]["Proposal present"].raw
    with pytest.raises(canopen.SdoAbortedError, match="0x08000024"):
        _ = computer["Active set"]["Sequence"].raw


def test_a_run_that_lost_power_goes_on(bench):
    computer = bench.computer
    computer.set_rules(LOOSE, 1e-4)  # the rules of the run are no part of it, but they are to be there when it ends
    computer.command("START")
    computer.wait(lambda: computer.state() == "WAIT_MOUNTING")
    number = computer["Progress"]["Mounting number"].raw
    computer.mount(number)
    computer.command("CONFIRM_MOUNTING", number)
    computer.wait(lambda: computer["Progress"]["Positions finished"].raw == 5)
    bench.power_cycle()
    assert computer.state() == "IDLE" and computer["Keeper"]["Resumable positions"].raw >= 5
    computer.command("RESUME")
    computer.wait(lambda: computer.state() != "IDLE")
    computer.finish_run()
    assert computer.counter() == 1
    assert computer["Active set"]["Flags"].raw & 0x20 and computer["Active set"]["Flags"].raw & 0x80
    assert [computer["Active set"][f"Temperature {end}"].raw for end in ("min", "max")] == [50, 50]  # 25 degrees C


def test_the_inhibit_ends_a_run(bench):
    computer = bench.computer
    computer.command("START")
    computer.wait(lambda: computer.state() == "WAIT_MOUNTING")
    computer["Host"]["Inhibit"].raw = 60
    computer.wait(lambda: computer.state() == "ABORT")
    assert refusal_of(computer.command, "START") == DEVICE_STATE
    assert 0 < computer["Host"]["Inhibit"].raw <= 60
    computer["Host"]["Inhibit"].raw = 0
    computer.command("START")


def test_parameters_are_forgotten_by_their_signature_alone(bench):
    computer = bench.computer
    store = computer["Store parameters"]["Save all parameters"]
    load = computer["Restore default parameters"]["Restore all default parameters"]
    before = computer["Recalibration"]["Pause"].raw
    assert store.raw == 1 and load.raw == 1
    computer["Recalibration"]["Pause"].raw = before + 100
    computer.unlock()
    for wrong in (0, signature("evas"), signature("load"), 0xFFFFFFFF):
        assert refusal_of(setattr, store, "raw", wrong) == STORE
    computer.save()
    assert refusal_of(setattr, load, "raw", signature("save")) == STORE
    bench.power_cycle()
    assert computer["Recalibration"]["Pause"].raw == before + 100
    assert refusal_of(setattr, load, "raw", signature("load")) == DEVICE_STATE
    computer.unlock()
    load.raw = signature("load")
    assert computer["Recalibration"]["Pause"].raw == before + 100
    bench.power_cycle()
    assert computer["Recalibration"]["Pause"].raw == before


def test_what_a_run_shows_position_by_position(bench):
    computer = bench.computer
    computer.calibrate()
    attitudes = set()
    for index in range(computer["Schedule"]["Positions"].raw):
        computer["Position"]["Position index"].raw = index
        assert computer["Position"]["Samples"].raw == computer["Configuration"]["Samples per position"].raw
        means = [computer["Position"][f"Mean {axis}"].raw for axis in "xyz"]
        assert all(abs(mean) < 3 for mean in means)
        attitudes.add((computer["Schedule"]["Mounting number"].raw, computer["Schedule"]["Table angle"].raw))
        assert computer["Schedule"]["Use"].raw == 0
    assert attitudes == {(mounting, 45.0 * step) for mounting in (1, 2) for step in range(9)}
    for name in ("alpha1", "alpha2_plus_alpha3", "alpha3_difference"):
        assert abs(computer["Stand seen"][name].raw) < 3 * computer["Stand seen"][f"u_{name}"].raw


def test_the_table_turns_between_runs(bench):
    computer = bench.computer
    progress = computer["Progress"]
    computer.command("HOME_AXIS")
    computer.wait(lambda: progress["Stand state"].raw == 4)
    computer["Command"]["Angle"].raw = 77.5
    computer.command("TURN_AXIS")
    computer.wait(lambda: progress["Stand state"].raw == 4)
    assert abs(progress["Actual angle"].raw - 77.5) < 0.01
    computer["Command"]["Angle"].raw = 1000.0
    assert refusal_of(computer.command, "TURN_AXIS") == VALUE
