"""A sensor that nobody can mount, from its recording to a verdict: `hand_laid` and `any_pose` against imucal.

    tools/benchmark hand_laid [--recordings N]

Twelve recordings (or N) of simulated sensors, in m/s^2 at 100 Hz: 3 s on each of six faces laid to 3 mrad, then 3 s in
each of twelve poses between, turned by hand in between, whose zeros drift by 1 mg. Each goes by `tumble import` and
`tumble solve` to a verdict, once by its faces and once by all poses. imucal takes the six faces, cut out by truth. The
error is that of |a| after calibration, the worst over all attitudes, in mg. Needs imucal (pip install imucal), or exit
77.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import tumble
from tumble.model.geometry import built_in, ideal_force

RATE, REST, TURN, G = 100, 300, 60, 9.81
NOISE_G, TILT, DRIFT_G = 2e-3, 3e-3, 1e-3
EXIT_SKIPPED = 77


def main(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", type=int, default=12)
    count = parser.parse_args(words).recordings
    try:
        import imucal  # noqa: F401, looked for before anything is simulated
    except ImportError:
        print("hand_laid: imucal is not installed", file=sys.stderr)
        return EXIT_SKIPPED
    print("recording  hand_laid        any_pose         imucal")
    passed, errors = 0, []
    for seed in range(1, count + 1):
        with tempfile.TemporaryDirectory() as folder:
            block, faces, outputs = recording(np.random.default_rng(seed), Path(folder) / "log.csv")
            laid, said_laid = by_commands(Path(folder), "hand_laid")
            posed, said_posed = by_commands(Path(folder), "any_pose")
        passed += (said_laid == "PASS") + (said_posed == "PASS")
        errors.append([worst(block, one) for one in (laid, posed, by_imucal(outputs[faces]))])
        verdicts = said_laid, said_posed, ""
        told = "  ".join(f"{error:8.2f} mg {verdict:4}" for error, verdict in zip(errors[-1], verdicts))
        print(f"{seed:9}{told}")
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    print(f"rms      {'      '.join(f'{one:8.2f} mg' for one in rms)}")
    print(f"{passed} of {2 * count} verdicts are PASS; imucal / hand_laid {rms[2] / rms[0]:.2f}, "
          f"imucal / any_pose {rms[2] / rms[1]:.2f}")  # fmt: skip
    return 0


def recording(rng, path):
    """A sensor (K, U0 in m/s^2), the rows of its faces (6, samples), and all outputs (rows, 3), which are written."""
    k = G * (np.eye(3) + 0.02 * rng.standard_normal((3, 3)) * (0.5 + np.eye(3)))
    u0 = 0.3 * rng.standard_normal(3)
    faces = ideal_force(built_in("hand_laid"))
    between = rng.standard_normal((12, 3))
    poses = np.concatenate([faces + TILT * np.cross(rng.standard_normal((6, 3)), faces), between])
    poses /= np.linalg.norm(poses, axis=1)[:, None]
    noise = [(np.repeat(one[None], REST, axis=0), np.tile(10.0 * rng.standard_normal(3), (TURN, 1))) for one in poses]
    felt = np.concatenate([part for rest, turn in noise for part in (rest, turn * rng.standard_normal((TURN, 3)))])
    drift = DRIFT_G * np.linspace(-0.5, 0.5, len(felt))[:, None] * rng.standard_normal(3)
    outputs = (felt + drift + NOISE_G * rng.standard_normal(felt.shape)) @ k.T + u0
    time = np.arange(len(felt)) / RATE
    rows = [f"{t:.2f},{x:.5f},{y:.5f},{z:.5f}" for t, (x, y, z) in zip(time, outputs)]
    path.write_text("\n".join(["time [s],ax [m/s^2],ay [m/s^2],az [m/s^2]", *rows]) + "\n")
    starts = (REST + TURN) * np.arange(6)
    return (k, u0), starts[:, None] + np.arange(REST), outputs


def by_commands(folder, schedule):
    """The result of the two commands that a user types, and its verdict."""
    run, result = folder / f"{schedule}.csv", folder / f"{schedule}.json"
    how = ["--leave-out", ",".join(map(str, range(7, 19)))] if schedule == "hand_laid" else []
    commands = (
        ["import", folder / "log.csv", "--schedule", schedule, "--out", run, *how],
        ["solve", run, "--schedule", schedule, "--out", result],
    )
    for words in commands:
        done = subprocess.run([sys.executable, "-m", "tumble", *words], capture_output=True, text=True, check=False)
        if done.returncode > 1:
            raise SystemExit(f"hand_laid: {done.stderr}")
    found = tumble.load(result)
    return (found.K, found.U0), "PASS" if found.passed else "FAIL"


def by_imucal(faces):
    """Of the six faces by Ferraris' way; its gyroscope sees turns of none."""
    import pandas
    from imucal import FerrarisCalibration, ferraris_regions_from_df

    columns = ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
    names = [f"{axis}_{side}" for axis in "xyz" for side in "pa"]
    still = [pandas.DataFrame(np.hstack([one, np.zeros_like(one)]), columns=columns) for one in faces]
    turns = [still[0].assign(**{f"gyr_{axis}": 1.0}) for axis in "xyz"]
    table = pandas.concat([*still, *turns], keys=[*names, "x_rot", "y_rot", "z_rot"])
    regions = ferraris_regions_from_df(table.droplevel(1).rename_axis("part"))
    found = FerrarisCalibration().compute(regions, RATE, from_acc_unit="m/s^2", from_gyr_unit="deg/s")
    return found.K_a @ found.R_a * G, found.b_a


def worst(true, found):
    """The error of |a| in mg, over attitudes all round."""
    n = np.random.default_rng(0).standard_normal((4000, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    a = np.linalg.solve(found[0], (n @ true[0].T + true[1] - found[1]).T)
    return 1e3 * float(np.abs(np.linalg.norm(a, axis=0) - 1.0).max())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
