"""tools/fixture over Modbus: tumble-gateway as it is, before a node that the test plays. What is seen directly on the
played table (as over CAN) must be seen through 2152h, the registers and the settings as well."""

import signal
import subprocess
import sys
import threading

import pytest
from conftest import EXAMPLES, ROOT
from fixture_node import PlayedNode
from fixture_table import LIMITS, PlayedTable, limits, read_limits
from simulated_bench import wait_until
from validation import report, session
from validation.judge import Figure, Verdict
from validation.limits import CHECKS
from validation.samples import StandFault, open_link

from tumble.client import CommunicationError, Refused
from tumble.client.link import read_map
from tumble.core import CoreSchedule, paper_schedule
from tumble.files.run_file import read_run

pytest.importorskip("pymodbus", reason="pymodbus is not installed")
pytestmark = [pytest.mark.slow, pytest.mark.python, pytest.mark.real_time]
HOME, TURN, ABORT = 12, 13, 2
QUICK = {"table__samples": 40, "table__homings": 4, "table__backlash_angles": 3, "table__approach_deg": 5}
MODBUS_S = {"link__latency_s": 1, "settling__settling_s": 0.4}
DATA = ("level", "remounting", "support")


def kept(name):
    """A recorded run, as the node keeps one: {keyword of PlayedNode}."""
    schedule = CoreSchedule(paper_schedule()).data
    return {"run": read_run(str(EXAMPLES / f"{name}.csv"), schedule), "schedule": schedule}


@pytest.fixture
def played(start):
    """(node, link) of a gateway that reads its node every 50 ms."""
    links = []

    def begin(*options, **node):
        gateway = start(*(options or ["--allow-commands"]))
        player = PlayedNode(gateway, **node)
        links.append(open_link(f"modbus:127.0.0.1:{gateway.port}"))
        return player, links[-1]

    yield begin
    for link in links:
        link.close()


def checked(folder, link, names, runs=(), **keys):
    """The outcomes of some checks."""
    asked = read_limits(str(limits(folder, **{**QUICK, **MODBUS_S, **keys})))
    heard = getattr(link, "sampler", None)  # of a table that is seen directly
    with session.opened(link, asked, list(map(str, runs)), None, heard) as context:
        return [session.run(name, context) for name in names]


def require_the_same(direct, over_modbus):
    """Figures as fine as registers let them be, and the same verdicts."""
    assert [one.verdict for one in over_modbus] == [one.verdict for one in direct], report.table(over_modbus)
    for a, b in zip(direct, over_modbus):
        assert [line.name for line in a.lines] == [line.name for line in b.lines]
        for here, there in zip(a.lines, b.lines):
            if isinstance(here, Figure):
                assert there.value == pytest.approx(here.value, rel=1e-3, abs=2e-5 if here.unit == "deg" else 1e-7)
                assert there.u == pytest.approx(here.u, rel=1e-2, abs=1e-9), there


def test_objects_are_read_by_the_same_names_as_over_can(played):
    node, link = played()
    assert (link.read("State"), link.read("Identity object: Product code")) == (0, 0x54420001)
    assert link.read("K: K_xx") is None and not link.has("Weather")
    for entry, value in [(1, -1.98765432109), *((entry, 0.0) for entry in range(2, 10))]:
        node.put(0x2020, entry, [value])
    node.gateway.tell("boot")
    link.fresh()
    assert link.read("K: K_xx") == pytest.approx(-1.98765432109, abs=0.51e-8)  # the scaled one, not the f32
    assert link.step("K: K_xx", -1.98) == 1e-8 and link.step("Measurement at rest: Standard deviation x", 3e-4) < 1e-10
    with pytest.raises(Refused, match="no such object"):
        link.read("Weather")
    with pytest.raises(Refused, match="it is read only"):
        link.write("K: K_xx", 1.0)


def test_a_setting_is_written_read_back_and_refused(played):
    node, link = played()
    link.write("Position: Position index", 35)
    link.fresh()
    assert link.read("Position: Position index") == 35
    with pytest.raises(Refused, match="value out of range"):
        link.write("Position: Position index", 1.5)
    node.gateway.tell("refuse 08000022")
    with pytest.raises(Refused, match=r"Samples wanted was refused: the state does not allow it \(0800 0022h\)"):
        link.write("Measurement at rest: Samples wanted", 40)


def test_a_setting_that_was_staged_and_not_executed_does_not_go_in_a_commands_place(played):
    """As when a script is interrupted between the two: what stops the table must stop the table."""
    node, link = played()
    holding, measured = link._map.holding, len(node.measured)
    for name, words in [("Unlock key 1", [0x4F50, 0x454E]), ("Setting", [111, *holding["Value"].pack(40)])]:
        link._answer(link._client.write_registers, holding[name].at, words)
    link.command(ABORT)
    assert node.commands == [ABORT] and len(node.measured) == measured


def test_a_command_that_is_under_way_is_waited_for_and_the_table_stopped(played):
    """As when a script is interrupted before it has its result."""
    node, link = played()
    node.gateway.tell("hold 1")
    for name, words in [("Unlock key 1", [0x4F50, 0x454E]), ("Command object", [0, 0, 0, 0, HOME, 1])]:
        link._answer(link._client.write_registers, link._map.holding[name].at, words)
    threading.Timer(0.1, node.gateway.tell, ["hold 0"]).start()
    link.command(ABORT)
    assert node.commands == [HOME, ABORT]


def test_what_selects_a_position_stands_before_what_it_selects():
    """A snapshot that has the new index has all else of the new position: the gateway reads upwards."""
    found = read_map().input
    chosen = {name: rows for name, rows in found.items()
              if name.startswith(("Position: ", "Schedule: ")) and not name.endswith(": valid")}
    assert min(chosen, key=lambda name: chosen[name][0].at) == "Position: Position index" and len(chosen) == 13
    assert {"Progress: Stand state", "Progress: Actual angle", "Measurement at rest: Samples taken"} <= set(found)


def test_a_good_fixture_is_supported_over_modbus_as_it_is_over_can(played, tmp_path):
    node, link = played(table=PlayedTable(seed=2), **kept("paper_stand"))
    found = checked(tmp_path, link, CHECKS)
    print(report.table(found))
    assert report.sentence(found, 3e-4).startswith("This fixture does support a calibration to 3e-4 g: ")
    untimed = [name for name in CHECKS if name not in ("link", "settling")]
    direct = checked(tmp_path, PlayedTable(seed=2), untimed, [EXAMPLES / "paper_stand.csv"])
    require_the_same(direct, [one for one in found if one.check in untimed])
    assert node.commands[0] == HOME and len(node.measured) == 9 + 4 + 2 * 3 + 1


@pytest.mark.parametrize(
    ("name", "faults", "said"),
    [
        ("homing", {"home_deg": 0.2}, "homing repeatability"),
        ("positions", {"alpha4_rad": 1e-3}, "set angle, std dev"),
        ("positions", {"read_back_deg": 0.02}, "read-back, worst"),
        ("backlash", {"backlash_deg": 0.1}, "backlash"),
        ("closure", {"slip_deg": 0.3}, "closure of a turn"),
        ("noise", {"noise_v": 2e-3}, "noise of a sample"),
    ],
)
def test_each_fault_that_can_finds_is_found_over_modbus(played, tmp_path, name, faults, said):
    _node, link = played(table=PlayedTable(seed=3, **faults))
    [found], [direct] = checked(tmp_path, link, [name]), checked(tmp_path, PlayedTable(seed=3, **faults), [name])
    require_the_same([direct], [found])
    assert [line.name for line in found.lines if line.verdict == Verdict.FAILS] == [said], report.table([found])


def test_a_tilted_stand_is_found_by_the_run_that_the_node_keeps(played, tmp_path):
    """A file of that run says the same."""
    _node, link = played(**kept("lab_stand"))
    keys = {"level__axis_tilt_rad": 1e-5, "level__level_yaw_rad": 1e-5, "remounting__yaw_change_rad": 1e-5,
            "limit_g": 1e-5}
    found = checked(tmp_path, link, DATA, **keys)
    assert {one.verdict for one in found} == {Verdict.FAILS}, report.table(found)
    require_the_same(checked(tmp_path, PlayedTable(), DATA, [EXAMPLES / "lab_stand.csv"], **keys), found)


def test_both_samplers_see_the_same(played, tmp_path):
    """Means and scatter through 2152h against what the node has taken, and what can be seen at all."""
    node, link = played()
    asked = read_limits(str(limits(tmp_path)))
    with session.opened(link, asked, [], None) as context:
        found = [context.instrument.sampler.mean(count) for count in (2, 40, 40, 65535)]
        step = context.instrument.sampler.v_per_count
    assert [one.samples for one in found] == [one.samples for one in node.measured] == [2, 40, 40, 65535]
    for mean, taken in zip(found, node.measured):
        assert mean.value == pytest.approx(taken.value, abs=0.51e-8)
        assert mean.scatter == pytest.approx(taken.scatter, rel=1e-6)
        assert mean.u == pytest.approx(taken.u, rel=1e-3)
    assert step == 1.192e-6  # of the example's limits


def test_no_block_is_quieter_than_its_converter_and_the_registers_let_it_be_seen(played, tmp_path):
    node, _link = played(table=PlayedTable(noise_v=0.0))
    for given, least in [("1e-4", 1e-4), ("1e-12", 1e-8)]:
        link = open_link(f"modbus:127.0.0.1:{node.gateway.port}")
        [outcome] = checked(tmp_path, link, ["noise"], table__converter_step_v=given)
        [figure] = outcome.lines
        assert figure.value == figure.resolves == pytest.approx(least / 12.0**0.5, rel=1e-9)


def test_without_memory_gravity_cannot_tell(played, tmp_path):
    """The encoder's figures stay; noise and closure come from a run, if there is one."""
    _node, link = played(memory=False)
    names = ("homing", "positions", "backlash", "closure", "noise", "level")
    found = dict(zip(names, checked(tmp_path, link, names, [EXAMPLES / "paper_stand.csv"])))
    assert {name for name in names if found[name].verdict != Verdict.MEETS} == {"homing", "positions", "backlash"}
    assert found["positions"].lines[0].verdict == Verdict.MEETS
    lines = [line for one in found.values() for line in one.lines if isinstance(line, Figure)]
    assert all("no means over Modbus: it has no memory" in line.note for line in lines if line.value is None)


def test_without_memory_there_is_no_run_either(played, tmp_path):
    _node, link = played(memory=False)
    found = checked(tmp_path, link, ["closure", *DATA])
    assert {one.verdict for one in found} == {Verdict.CANNOT_TELL}
    assert all(line.note for one in found for line in one.lines)


def test_a_block_that_sends_nothing_and_a_measurement_that_is_given_up(played):
    node, link = played(stuck=True, spoils=7)
    sampler = session.Instrument(link, read_limits(str(LIMITS)).table, None).sampler
    with pytest.raises(CommunicationError, match=r"sends no samples \(0 of 40 came, 7 were spoilt\)"):
        sampler.mean(40)
    node.measure = lambda count: type(node).measure(node, 0)  # as when it is reset meanwhile
    with pytest.raises(StandFault, match="has given up a measurement at rest"):
        sampler.mean(40)


def test_a_wrong_identity_fails(played, tmp_path):
    _node, link = played(serial=7)
    path = limits(tmp_path, **MODBUS_S)
    path.write_text(path.read_text().replace("vendor_id = 0", "vendor_id = 0\nserial_number = 8"))
    with session.opened(link, read_limits(str(path)), [], None) as context:
        identity = session.run("link", context)
    failed = [line for line in identity.lines if line.verdict == Verdict.FAILS]
    assert [(line.name, line.found) for line in failed] == [("serial number", "0x7")]


def test_a_command_that_the_node_refuses_is_a_fault_of_the_stand(played, tmp_path):
    node, link = played()
    node.gateway.tell("refuse 08000022")
    with session.opened(link, read_limits(str(limits(tmp_path))), [], None) as context:
        with pytest.raises(StandFault, match=r"homing: .* the state does not allow it \(0800 0022h\)"):
            context.instrument.home()


def test_a_silent_node_and_a_gateway_that_takes_no_commands(played):
    node, link = played("--unlock", 60)
    with pytest.raises(CommunicationError, match="exception 1: it takes no commands unless started with --allow-comm"):
        link.command(HOME)
    node.gateway.tell("silent 1")
    with pytest.raises(CommunicationError, match="the gateway says: the node is silent"):
        for _ in range(1000):
            link.fresh()


def test_an_interruption_stops_the_table(played, tmp_path):
    """In the middle of whatever is asked of the gateway: most of the time that is the next snapshot's number."""
    node, _link = played()
    asked = limits(tmp_path, table__rest_s=0)
    arguments = [sys.executable, "-B", ROOT / "tools/fixture/launch.py", f"modbus:127.0.0.1:{node.gateway.port}"]
    running = subprocess.Popen([*arguments, "positions", "--limits", asked], stderr=subprocess.PIPE, text=True)
    wait_until(lambda: TURN in node.commands)
    running.send_signal(signal.SIGINT)
    errors = running.communicate(timeout=20)[1]
    assert (running.returncode, errors) == (130, "validate: interrupted; the table was told to stop\n")
    assert node.commands[-1] == ABORT


def test_a_gateway_that_has_just_been_started(played):
    """Its node answers soon, and is waited for."""
    node, link = played()
    node.gateway.tell("silent 1")
    wait_until(lambda: link._own("Link state") == 2)
    threading.Timer(0.5, node.gateway.tell, ["silent 0"]).start()
    again = open_link(f"modbus:127.0.0.1:{node.gateway.port}")
    assert again.read("State") == 0
    again.close()


def test_a_serial_line(serve, far_end, tmp_path):
    """modbus-rtu over a pair of pseudo terminals, which have no parity."""
    pytest.importorskip("serial", reason="pyserial is not installed")
    gateway = serve("--allow-commands", parity="N")
    node = PlayedNode(gateway)
    link = open_link(f"modbus-rtu:{far_end},19200,N")
    with session.opened(link, read_limits(str(limits(tmp_path, link__latency_s=1))), [], None) as context:
        assert session.run("link", context).verdict == Verdict.MEETS
        context.instrument.turn(45.0)
        assert context.instrument.angle() == 45.0
        assert session.run("noise", context).verdict == Verdict.MEETS
    assert node.commands == [HOME, TURN]
