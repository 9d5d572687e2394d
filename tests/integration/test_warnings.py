"""Warnings: on stderr for people, in the document for programs, and none without a reason."""

import pytest
from conftest import EXAMPLES
from documents import valid

PAPER, STAND = EXAMPLES / "paper_stand.csv", EXAMPLES / "paper_stand.toml"
NO_UNIT = "the run file names no unit: outputs taken for volts (--unit V, or ux [V] in its header)"
UNCHECKED = "no more means than unknowns: nothing checks this run"


def told(stderr):
    return [line.removeprefix("tumble: warning: ") for line in stderr.splitlines()]


def document_of(done, kind="result"):
    result = valid(done.stdout, kind)
    assert result["warnings"] == told(done.stderr)
    return result


def test_a_document_has_what_stderr_says(tumble):
    result = document_of(tumble("solve", PAPER, "--json"))
    assert result["warnings"] == [NO_UNIT] and "unit" in result["assumes"]
    assert document_of(tumble("solve", PAPER, "--unit", "V", "--json"))["warnings"] == []


def test_a_declared_block_that_is_found_confirms_volts(tumble):
    """Nothing is left to warn of; what the result rests on is told as before."""
    done = tumble("solve", PAPER, "--stand", STAND, "--json")
    result = document_of(done)
    assert done.stderr == "" and "unit" in result["assumes"]
    assert tumble("solve", PAPER, "--stand", STAND).stderr == ""


def test_a_stand_without_a_block_confirms_nothing(tmp_path, tumble):
    path = tmp_path / "stand.toml"
    path.write_text(STAND.read_text().partition("[block]")[0])
    assert told(tumble("solve", PAPER, "--stand", path).stderr) == [NO_UNIT]


def test_another_block_confirms_nothing(tmp_path, tumble):
    """K is one and a half times the declared one: no mistake that has a name, and no confirmation."""
    path = tmp_path / "stand.toml"
    block = STAND.read_text().partition("[block.true]")[0]
    path.write_text(block.replace("scale_v_per_g = 2.0", "scale_v_per_g = 1.35"))
    found = told(tumble("solve", PAPER, "--stand", path).stderr)
    assert found[0] == NO_UNIT and found[1].startswith("K is not that of the declared block: ")


def four_positions(tmp_path, *, checks=0):
    """A run on as many means as there are unknowns, in volts; and so many positions that only check it."""
    kept = [(1, 1), (1, 3), (1, 6), (2, 1), *[(2, 5), (2, 7)][:checks]]
    schedule = tmp_path / "four.toml"
    mountings = "\n".join(
        f"[[mounting]]\nnumber = {number}\nmatrix = {matrix}"
        for number, matrix in ((1, "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"), (2, "[[-1, 0, 0], [0, 0, 1], [0, 1, 0]]"))
    )
    positions = "\n".join(
        f'[[position]]\nmounting = {m}\nposition = {p}\nangle_deg = {45 * (p - 1)}\nuse = "{use}"'
        for (m, p), use in zip(kept, ["fit"] * 4 + ["check"] * checks)
    )
    schedule.write_text(mountings + "\n" + positions + "\n")
    run, lines = tmp_path / "four.csv", PAPER.read_text().splitlines()
    names = lines[0].split(",")
    at = [names.index(name) for name in ("mounting", "position")]
    rows = [line for line in lines[1:] if tuple(int(line.split(",")[place]) for place in at) in kept]
    run.write_text("\n".join([lines[0].replace("ux", "ux [V]").replace("uy", "uy [V]").replace("uz", "uz [V]"), *rows]))
    return "--schedule", schedule, "--estimator", "least_squares", run


@pytest.mark.parametrize("stand", [(), ("--stand", STAND)])
def test_who_checks_nothing_is_told_so(stand, tmp_path, tumble):
    done = tumble("solve", *four_positions(tmp_path), *stand, "--json")
    result = document_of(done)
    assert UNCHECKED in result["warnings"]
    assert result["fit"] is None or result["fit"]["dof"] == 0


def test_a_check_position_is_a_check(tmp_path, tumble):
    done = tumble("solve", *four_positions(tmp_path, checks=1), "--json")
    assert UNCHECKED not in document_of(done)["warnings"]


def test_a_fixture_check_tells_it_of_its_runs(tmp_path, tumble):
    done = tumble("fixture", "check", "--stand", STAND, *four_positions(tmp_path), "--json")
    result = document_of(done, "fixture")
    assert [one.endswith(f"four.csv: {UNCHECKED}") for one in result["warnings"]] == [True]
    done = tumble("fixture", "check", "--stand", STAND, PAPER, "--json")
    assert document_of(done, "fixture")["warnings"] == []
