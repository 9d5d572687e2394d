"""docs/client.md as it is printed, at every pace; and what the pytest plugin says and costs."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from paced_scripts import ALONE, MARKER, PAGE, SCRIPT, TEST, calibrate
from simulated_bench import scenario
from uml_kernels import inside

from tumble import client
from tumble.testing.rigs import FAST
from tumble.testing.virtual_bus import VirtualBus, time_of

pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("canopen", reason="python-canopen is not installed")
pytestmark = pytest.mark.python

PLUGIN = ["-p", "tumble.testing.plugin", "-p", "no:cacheprovider"]

OTHERS = f"""
import pytest
from tumble import client

@pytest.mark.tumble(operator="never")
def test_a_block_that_nobody_mounts(tumble_node):
    with client.connect(tumble_node.link) as node:
        node.start()
        node.wait("WAIT_MOUNTING")
        node.confirm()  # it lies as mounting 1 has it, as the page says
        node.wait("WAIT_MOUNTING")
        assert (node.mounting, node.status.finished) == (2, 9)
        node.confirm()
        with pytest.raises(client.RunFailed, match="WRONG_MOUNTING|SWAPPED_CHANNELS"):
            node.wait("DONE")
    assert tumble_node.end()["reason"] in ("TUMBLE_REASON_WRONG_MOUNTING", "TUMBLE_REASON_SWAPPED_CHANNELS")

{MARKER.strip().replace("never", "on-confirm")}
def test_a_fault(tumble_client):
    tumble_client.start()
    tumble_client.wait("WAIT_MOUNTING", timeout=60)
    tumble_client.confirm()
    tumble_client.wait("FAULT", timeout=60)

def test_a_stand_that_cannot_be_killed(tumble_stand):
    with pytest.raises(ValueError, match="a fault of the scenario"):
        tumble_stand.kill()

@pytest.mark.tumble(operator="nobody")
def test_no_operator(tumble_stand):
    pass

@pytest.mark.tumble("never")
def test_no_name(tumble_stand):
    pass

@pytest.mark.tumble(scenario="none.txt")
def test_no_scenario(tumble_stand):
    pass

@pytest.mark.tumble(no__key=1)
def test_no_key(tumble_stand):
    pass

@pytest.mark.tumble(memory=True)
def test_a_memory(tumble_client):
    assert tumble_client.has("Keeper: Verdict") and tumble_client.status.calibration_counter == 0
"""
WRONG = (
    r"tumble\('never'\): an argument needs its name, such as operator=\n",
    r"\nnone\.txt: the scenario cannot be read: No such file or directory\n",
    r"tumble\(operator=\): 'nobody' is not by-itself, on-confirm, never\n",
    r"tumble-scenario\.txt:\d+: no such key: no\.key\n",  # after as many lines as the rig writes of its own
)


@pytest.fixture
def written(tmp_path):
    """The page's two files."""
    (tmp_path / "calibrate.py").write_text(SCRIPT)
    (tmp_path / "test_calibrate.py").write_text(TEST)
    return tmp_path


def ran(folder, *arguments, plugin=PLUGIN):
    """pytest there, as a user runs it."""
    command = [sys.executable, "-m", "pytest", *plugin, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, env=dict(os.environ))


def test_the_page_as_it_is_printed(written):
    assert "pytest test_calibrate.py\n" in PAGE and len(TEST.splitlines()) <= 10
    done = ran(written, "test_calibrate.py")
    assert done.returncode == 0 and " 1 passed in " in done.stdout, done.stdout


@pytest.mark.toolchain
def test_markers_and_what_is_wrong_with_them(written):
    """Exactly these fail, each with one line and no traceback."""
    (written / "test_others.py").write_text(OTHERS)
    done = ran(written, "test_others.py", "-rE")
    assert done.returncode == 1 and " 4 passed, 4 errors in " in done.stdout, done.stdout
    for said in WRONG:
        assert re.search(said, done.stdout), done.stdout
    assert "Traceback" not in done.stdout and "rigs.py" not in done.stdout


def test_the_bus_without_pytest(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(ALONE, "page", "exec"), {})
    assert re.fullmatch(r"True 4\d s of virtual time\n", capsys.readouterr().out)
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == ["bench.json", "bus.log", "run.csv"]


@pytest.mark.toolchain
@pytest.mark.parametrize("given, code, says", [
    ("nix", 4, "ERROR: --tumble-bus: 'nix' is not virtual, uml, or can: and the name of an interface\n"),
    ("can:", 4, "ERROR: --tumble-bus: 'can:' is not virtual, uml, or can: and the name of an interface\n"),
    ("can:nocan0", 1, "tumble-stand does not start: "),
])
def test_what_is_no_bus(written, given, code, says):
    done = ran(written, "test_calibrate.py", f"--tumble-bus={given}")
    assert done.returncode == code and says in done.stdout + done.stderr, done.stdout


@pytest.mark.toolchain
def test_without_user_mode_linux_it_says_what_to_install(written):
    program = "from tumble.world import uml; uml._KERNEL = 'linux.that.is.not.there'; import pytest, sys; "
    program += f"sys.exit(pytest.main([*{PLUGIN}, '--tumble-bus=uml', 'test_calibrate.py']))"
    done = subprocess.run([sys.executable, "-c", program], cwd=written, capture_output=True, text=True, timeout=60)
    assert done.returncode == 77, done.stdout
    assert "--tumble-bus=uml: user-mode Linux is not there: no linux.that.is.not.there" in done.stdout + done.stderr


@inside
@pytest.mark.slow
@pytest.mark.toolchain
@pytest.mark.real_time
def test_the_page_in_user_mode_linux(written):
    """The ini file says so; a person who takes no time."""
    (written / "pytest.ini").write_text("[pytest]\ntumble_bus = uml\n")
    (written / "test_calibrate.py").write_text(TEST.replace("sleep(30)", "sleep(0)"))
    done = ran(written, "test_calibrate.py")
    assert done.returncode == 0 and " 1 passed in " in done.stdout, done.stdout


def test_it_loads_nothing_unless_it_is_used():
    """Beside what pytest itself has loaded."""
    program = "import pytest, sys; before = {*sys.modules}; import tumble.testing.plugin; "
    program += "print(sorted({*sys.modules} - before))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    loaded = eval(done.stdout)
    assert loaded == ["tumble", "tumble._version", "tumble.errors", "tumble.testing", "tumble.testing.plugin"]


PACES_S = [0.0, *(0.001 * 1.9**power for power in range(19))]  # to 104 s


@pytest.mark.parametrize("pace_s", [pytest.param(pace, marks=[] if number in (0, 16) else pytest.mark.full)
                                    for number, pace in enumerate(PACES_S)])
def test_the_script_works_at_any_pace(pace_s, tmp_path):
    """From at once to a person who thinks about every call for more than a minute; the warm-up does not matter."""
    path = scenario(tmp_path, **{name.replace(".", "__"): value for name, value in FAST.items()})
    with VirtualBus(path, seed=11) as bus, time_of(bus), client.connect(bus) as node:
        result = calibrate(node, pace_s)
        truth = bus.end()["truth"]
    assert result.passed and np.abs(result.K - truth["K"]).max() < 3e-3 and np.abs(result.U0 - truth["U0"]).max() < 3e-3


def test_the_paces_are_twenty_from_at_once_to_a_persons():
    assert len(PACES_S) == 20 and PACES_S[0] == 0 and 60 < PACES_S[-1] < 120
