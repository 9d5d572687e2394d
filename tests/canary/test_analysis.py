"""The static analysis of the long run rejects planted violations and accepts the same code without them."""
import re
import shutil

import pytest
from conftest import ROOT, run
from stages import PYTHON

REJECTED = {  # gate: what it must say
    "misra": "misra-c2012-11.3",
    "tidy": "[clang-analyzer-core.DivideZero",
    "analyzer": "[-Werror=analyzer-null-dereference]",
}


def analyse(gate, *files, root=ROOT):
    result = run(PYTHON, root / "tools/analyse.py", gate, *files)
    if result.returncode == 77:
        pytest.skip(result.stdout.strip())
    return result


@pytest.mark.parametrize("gate", REJECTED)
def test_rejects(gate):
    result = analyse(gate, f"tests/canary/analysis/{gate}.c")
    assert result.returncode == 1
    assert REJECTED[gate] in result.stdout, result.stdout


@pytest.mark.parametrize("gate", REJECTED)
def test_accepts(gate):
    result = analyse(gate, "tests/canary/analysis/clean.c")
    assert result.returncode == 0, result.stdout


def copy_tools(root):
    (root / "tools").mkdir()
    for tool in ("analyse.py", "misra_deviations.txt"):
        shutil.copy(ROOT / "tools" / tool, root / "tools")


def plant(gate, root):
    """A copy of the firmware and of what it is analysed with. Every room has the defect; the doors, which have
    no C files, have it in a header that a room includes. Returns the rooms."""
    copy_tools(root)
    shutil.copytree(ROOT / "firmware", root / "firmware")
    rooms = sorted(path for path in (root / "firmware").iterdir() if path.is_dir())
    for room in rooms:
        place = room / "tumble/canary.h" if room.name == "include" else room / "canary.c"
        shutil.copy(ROOT / f"tests/canary/analysis/{gate}.c", place)
    (root / "firmware/navcomp/includes_the_door.c").write_text('#include "tumble/canary.h"\n')
    return [room.name for room in rooms]


@pytest.mark.parametrize("gate", REJECTED)
def test_rejects_in_every_room(gate, tmp_path):
    rooms = plant(gate, tmp_path)
    result = analyse(gate, root=tmp_path)
    assert result.returncode == 1
    message = re.escape(REJECTED[gate])
    found = set(re.findall(rf"firmware/(\w+)/(?:tumble/)?canary\.[ch]:\d+:.*{message}", result.stdout))
    assert found == set(rooms) and "include" in found, result.stdout


def test_rejects_a_deviation_that_nothing_needs(tmp_path):
    copy_tools(tmp_path)
    room = tmp_path / "firmware/core"
    room.mkdir(parents=True)
    shutil.copy(ROOT / "tests/canary/analysis/clean.c", room)
    (tmp_path / "tools/misra_deviations.txt").write_text("misra-c2012-8.7\nmisra-c2012-11.3:firmware/core/clean.c\n")
    result = analyse("misra", root=tmp_path)
    assert result.returncode == 1
    assert re.findall(r"Unmatched suppression: (misra\S+)", result.stdout) == ["misra-c2012-11.3"], result.stdout


def test_a_missing_tool_is_a_skip_and_not_a_pass(tmp_path):
    result = run(PYTHON, "-S", "-c", f"import sys; sys.path.insert(0, {str(ROOT / 'tools')!r}); import analyse; "
                 "sys.exit(analyse.main(['tidy']))", PATH=str(tmp_path))
    assert (result.returncode, result.stdout) == (77, "clang-tidy is not installed\n")
