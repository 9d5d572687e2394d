"""The comparison of the core with its witness can fail: planted defects on either side end in exit 3 and no result."""

import ast
from dataclasses import replace

import numpy as np
import pytest
from blocks import random_block, write_run
from conftest import EXAMPLES, ROOT

from tumble import core
from tumble.cli.main import main
from tumble.errors import Disagreement
from tumble.model import Geometry, built_in, coefficients
from tumble.solving import computation, solution
from tumble.solving.computation import compute

SOURCES = ROOT / "host/python/src/tumble"


def solve_with_defect(capsys, tmp_path, *options):
    """Exit code, stdout, stderr of a solve in this process; asserts that no result file is left."""
    out = tmp_path / "result.json"
    code = main(["solve", str(EXAMPLES / "paper_stand.csv"), "--unit", "V", "--json", "--out", str(out), *options])
    captured = capsys.readouterr()
    assert out.exists() == (code == 0)
    assert len(list(tmp_path.iterdir())) == (code == 0)
    return code, captured.out, captured.err


def plant(monkeypatch, module, name, spoil):
    """Let a function's result be spoilt."""
    sound = getattr(module, name)
    monkeypatch.setattr(module, name, lambda *arguments: spoil(sound(*arguments)))


def shifted(index, by):
    """Spoil one array of a tuple: its first element is off by `by`."""

    def spoil(arrays):
        arrays = [np.array(array) for array in arrays]
        arrays[index].flat[0] += by
        return tuple(arrays)

    return spoil


def moved(index, by):
    """Of the unknowns, one shifted by so much."""
    return lambda numbers: numbers + by * (np.arange(len(numbers)) == index)


def test_without_a_defect_they_agree(capsys, tmp_path):
    code, out, err = solve_with_defect(capsys, tmp_path)
    assert (code, err) == (0, "") and out


LARGEST_K = 2.00392  # of the example

DEFECTS = {
    "K of numpy": (computation, "unknowns", moved(0, 1.1e-12 * LARGEST_K), "K differs"),
    "U0 of numpy": (computation, "unknowns", moved(9, 1.1e-12 * LARGEST_K), "U0 differs"),
    "K of the core": (core, "estimate", shifted(0, 1.1e-12 * LARGEST_K), "K differs"),
    "U0 of the core": (core, "estimate", shifted(1, 1.1e-12 * LARGEST_K), "U0 differs"),
    "gravity errors": (coefficients, "gravity_errors", lambda errors: errors * 1.00001, "delta_g differs"),
    "scales": (coefficients, "intrinsic", shifted(0, 1e-10), "intrinsic scale differs"),
    "angles": (coefficients, "intrinsic", shifted(1, 1e-10), "intrinsic angle_rad differs"),
    "biases": (coefficients, "intrinsic", shifted(2, 1e-10), "intrinsic bias_g differs"),
    "residuals": (coefficients, "residual_rms", lambda rms: rms + 1e-10, "residual_rms differs"),
    "no residuals": (coefficients, "residual_rms", lambda rms: None, "only one of them gives residual_rms"),
    "closure": (coefficients, "closure", lambda difference: difference + 1e-16, "closure of mounting 1 differs"),
    "no closure": (coefficients, "closure", lambda difference: None, "only one of them gives closure of mounting 1"),
    "a NaN": (computation, "unknowns", moved(0, np.nan), "K differs"),
}


@pytest.mark.parametrize("case", DEFECTS)
def test_planted_defects_end_in_exit_3(case, monkeypatch, capsys, tmp_path):
    module, name, spoil, message = DEFECTS[case]
    plant(monkeypatch, module, name, spoil)
    code, out, err = solve_with_defect(capsys, tmp_path)
    assert (code, out) == (3, "")
    assert err.count("\n") == 1 and message in err and "no result is given" in err


def test_what_is_within_the_limit_passes(monkeypatch, capsys, tmp_path):
    plant(monkeypatch, computation, "unknowns", moved(0, 0.9e-12 * LARGEST_K))
    assert solve_with_defect(capsys, tmp_path)[0] == 0


def test_a_defect_in_the_paper_schedule_is_seen(monkeypatch, capsys, tmp_path):
    """The witness has its own idea of the default schedule: one angle a millionth of a degree off is a disagreement."""
    right = built_in("paper")
    wrong = [replace(p, angle_deg=p.angle_deg + 1e-6) if p.label == "2.4" else p for p in right.positions]
    monkeypatch.setattr(solution, "built_in", lambda _: replace(right, positions=tuple(wrong)))
    code, out, err = solve_with_defect(capsys, tmp_path, "--estimator", "least_squares")
    assert (code, out) == (3, "") and "K differs" in err


def test_a_fault_in_the_program_is_no_verdict(monkeypatch, capsys, tmp_path):
    """Exit 1 means that limits failed; an unforeseen exception must not look like it."""
    monkeypatch.setattr(solution, "pooled_noise", lambda *_: 1 / 0)
    code, out, err = solve_with_defect(capsys, tmp_path)
    assert (code, out) == (3, "")
    assert err.count("\n") == 1 and "fault in tumble itself: ZeroDivisionError" in err


def test_outputs_with_a_large_offset_are_not_a_disagreement(tumble, tmp_path):
    """Where the outputs' own last bit is coarser than 1e-12 of K, nobody can agree better."""
    rng, paper = np.random.default_rng(61), built_in("paper")
    for ratio in (1e2, 1e4, 1e6):
        k, _ = random_block(rng)
        means = Geometry(paper).outputs(k, ratio * np.abs(k).max() * np.ones(3))
        run = write_run(tmp_path / "run.csv", paper, means)
        assert tumble("solve", run).returncode in (0, 1)


def test_the_limit_scales_with_the_coefficients():
    paper, rng = core.CoreSchedule(built_in("paper")), np.random.default_rng(62)
    for scale in (1e-6, 1.0, 1e9):
        k = scale * (2 * np.eye(3) + 0.02 * rng.normal(size=(3, 3)))
        means = Geometry(paper.data).outputs(k, scale * 0.1 * np.ones(3))
        found = compute(paper, means, np.ones(18, dtype=bool), "refined", 1e-3)
        computation.compare(found, paper.data, means, means, found.gravity.delta_g)
        off = replace(found, k=found.k + np.diag([0, 0, 3e-12 * scale]))
        with pytest.raises(Disagreement):
            computation.compare(off, paper.data, means, means, found.gravity.delta_g)


def imports_of(path):
    """Names of modules that a file imports, anywhere in it."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in (
            "__import__",
            "import_module",
        ):
            found.add("dynamic import")
    return found


def closure_of(roots):
    """All modules of the package that some files import, directly or by others."""
    seen, queue = set(), list(roots)
    while queue:
        path = queue.pop()
        for name in imports_of(path):
            seen.add(name)
            for candidate in (
                SOURCES.parent / (name.replace(".", "/") + ".py"),
                SOURCES.parent / name.replace(".", "/") / "__init__.py",
            ):
                if candidate.exists() and candidate not in seen:
                    seen.add(candidate)
                    queue.append(candidate)
    return {name for name in seen if isinstance(name, str)}


def test_the_model_knows_nothing_of_the_core():
    imported = closure_of(SOURCES.glob("model/*.py"))
    assert not {name for name in imported if {"core", "_tumble_core", "_tumble_world"} & set(name.split("."))}
    assert "dynamic import" not in imported
    assert imported & {"numpy"}


def test_the_core_knows_nothing_of_the_model():
    imported = closure_of(SOURCES.glob("core/*.py"))
    assert not {name for name in imported if name.startswith("tumble.model")}
    assert "dynamic import" not in imported
    assert "_tumble_core" in imported
