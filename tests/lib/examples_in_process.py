"""Commands on the examples, one after the other in this process: what they leave, by the name of the command's file."""

import contextlib
import io
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
HAND_HELD = ["--schedule", "six_faces", "--order", "any", "--signs=+++", "--repeats", "first", "--unit", "m/s^2",
             "--rate", "102.4"]


def run(*arguments):
    """The exit code of a command, what it prints and what it says."""
    from tumble.cli.main import main

    out, errors = io.TextIOWrapper(io.BytesIO(), encoding="utf-8"), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        code = main([str(argument) for argument in arguments])
        out.flush()
    return code, out.buffer.getvalue().decode(), errors.getvalue()


def run_all(folder):
    """Solve, save, apply, import, export, plan and judge; all files go into the folder, and twice, so that they replace
    what is there. Then a simulated calibration. Every command must end with 0. The name of the folder is taken out of
    what is found."""
    Path(folder).mkdir()
    result, data = f"{folder}/result.json", f"{folder}/data.csv"
    Path(data).write_text("t,ux,uy,uz\n0,0.1,0.2,2.0\n1,2.0,0.1,0.0\n", encoding="utf-8")
    stand = ("--stand", EXAMPLES / "paper_stand.toml")
    commands = [
        ("solve", EXAMPLES / "paper_stand.csv", *stand, "--out", result),
        ("solve", EXAMPLES / "paper_stand.csv", *stand, "--json"),
        ("apply", result, data, "--uncertainty", "--out", f"{folder}/calibrated.csv"),
        ("import", EXAMPLES / "hand_held_session.csv", *HAND_HELD, "--out", f"{folder}/run.csv"),
        ("export", result, "--format", "c", "--out", f"{folder}/result.h"),
        ("export", result, "--format", "csv", "--out", f"{folder}/result.csv"),
        ("plan", "budget", *stand),
        ("fixture", "check", *stand, EXAMPLES / "paper_stand.csv"),
    ]
    said = {}
    for _ in range(2):
        for number, command in enumerate(commands):
            code, out, errors = run(*command)
            assert code == 0, (command, code, out, errors)
            said[f"{number} {command[0]}"] = out.replace(folder, "")
    code, said["bench"], errors = run("bench", "--seed", 2, "--no-report", "--out", f"{folder}/bench")
    assert code == 0, errors
    for path in sorted(path for path in Path(folder).rglob("*") if path.is_file()):
        said[path.relative_to(folder).as_posix()] = path.read_bytes().replace(folder.encode(), b"")
    return said
