"""Write the example runs anew: what blocks of known coefficients give on stands of known quality.

    python examples/generate.py [FOLDER]        (default: the folder of this script)

Each run is made from a stand file ([stand]: how good the stand is; [block.true]: the block), a schedule and a seed,
listed in RUNS. The errors of the stand are drawn once as a real stand has them: alpha1 and alpha2 for the run, alpha3
for each mounting, alpha4 for each position; then the noise of each sample. What was drawn is written beside the run as
NAME.truth.json. Outputs are rounded to 1e-7 V. The same seed gives the same bytes.

The script uses nothing but Python's own library; the seeds are the numbers 1 to 8 in order, not chosen for their
results. Geometry: h horizontal across the axis, n along the axis, v up at table angle 0; the specific force is

    f = (cos t sin p,  sin t,  cos t cos p),     t = tilt + alpha1,  p = phi + alpha2 + alpha4

a yaw alpha3 of the block on the platform turns h towards n, and the mounting's matrix takes (h, n, v) to (x, y, z). The
axis of a stand is level, tilt 0, but where it is inclined: then to about 0, 45 and -45 degrees, by hand and off by what
INCLINED says, and the block, which stays bolted on, keeps its alpha3.
"""

import json
import math
import random
import sys
from pathlib import Path

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

EXAMPLES = Path(__file__).resolve().parent

# name of the run, stand file, schedule (a file, or a name of BUILT_IN), seed
RUNS = (
    ("paper_stand", "paper_stand.toml", "paper", 1),
    ("angle_stand", "angle_stand.toml", "paper", 2),
    ("lab_stand", "lab_stand.toml", "paper", 3),
    ("six_faces", "paper_stand.toml", "six_faces.toml", 4),
    ("with_checks", "paper_stand.toml", "with_checks.toml", 5),
    ("diagonal_stand", "diagonal_stand.toml", "diagonal", 6),
    ("three_mountings_stand", "three_mountings_stand.toml", "three_mountings", 7),
    ("inclined_stand", "inclined_stand.toml", "inclined", 8),
)

MATRICES = {  # the paper's two mountings, and the third
    1: ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    2: ((-1, 0, 0), (0, 0, 1), (0, 1, 0)),
    3: ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
}
INCLINED = {"tilt": {1: 0.0, 2: 45.0, 3: -45.0}, "off_rad": 5e-3, "zero_rad": 1e-3}  # deg; standard deviations
NINE, FOUR = [45.0 * turn for turn in range(9)], [45.0, 135.0, 225.0, 315.0]
BUILT_IN = {  # mountings, angles in each
    "paper": (2, NINE),
    "three_mountings": (3, NINE),
    "diagonal": (3, FOUR),
    "inclined": (3, NINE),
}

UNITS_TOLD = ("diagonal", "three_mountings", "inclined")  # in the header; of the older runs scripts know it


def load(name: str) -> dict:
    """A TOML file of this folder."""
    return tomllib.loads((EXAMPLES / name).read_text(encoding="utf-8"))


def read_schedule(name: str) -> tuple[dict, list[tuple[int, int, float]]]:
    """Matrices by mounting, and (mounting, position, table angle in degrees) in the order of measuring."""
    if name in BUILT_IN:
        mountings, angles = range(1, BUILT_IN[name][0] + 1), BUILT_IN[name][1]
        positions = [(mounting, number, angle) for mounting in mountings for number, angle in enumerate(angles, 1)]
        return {one: MATRICES[1 if name == "inclined" else one] for one in mountings}, positions
    schedule = load(name)
    matrices = {mounting["number"]: mounting["matrix"] for mounting in schedule["mounting"]}
    return matrices, [(row["mounting"], row["position"], row["angle_deg"]) for row in schedule["position"]]


def draw_errors(stand: dict, matrices: dict, positions: list, rng: random.Random, inclined: bool) -> dict:
    """The errors of the stand in one run, in radians. The stand files declare standard deviations."""
    if inclined:
        level, zero, yaw = (rng.gauss(0.0, stand[key]) for key in ("axis_tilt_rad", "level_rad", "remount_rad"))
        off, turned = ([rng.gauss(0.0, INCLINED[key]) for _ in matrices] for key in ("off_rad", "zero_rad"))
        return {
            "alpha1_rad": [level + one for one in off],
            "alpha2_rad": [zero, *(zero + one for one in turned[1:])],
            "alpha3_rad": [yaw for _ in matrices],
            "alpha4_rad": [rng.gauss(0.0, stand["angle_rad"]) for _ in positions],
        }
    return {
        "alpha1_rad": rng.gauss(0.0, stand["axis_tilt_rad"]),
        "alpha2_rad": rng.gauss(0.0, stand["level_rad"]),
        "alpha3_rad": [rng.gauss(0.0, stand["remount_rad"]) for _ in matrices],
        "alpha4_rad": [rng.gauss(0.0, stand["angle_rad"]) for _ in positions],
    }


def specific_force(matrix, angle_deg: float, t: float, alpha2: float, alpha3: float, alpha4: float) -> list[float]:
    """What the block feels, in g, on its axes x, y, z, where the axis is at `t` to the level."""
    p = math.radians(angle_deg) + alpha2 + alpha4
    h, n, v = math.cos(t) * math.sin(p), math.sin(t), math.cos(t) * math.cos(p)
    h, n = h * math.cos(alpha3) + n * math.sin(alpha3), n * math.cos(alpha3) - h * math.sin(alpha3)
    return [row[0] * h + row[1] * n + row[2] * v for row in matrix]


def generate(stand_name: str, schedule_name: str, seed: int) -> tuple[str, str]:
    """One run: the text of the run file and of its truth."""
    stand_file = load(stand_name)
    stand, block = stand_file["stand"], stand_file["block"]["true"]
    matrices, positions = read_schedule(schedule_name)
    rng = random.Random(seed)
    inclined = schedule_name == "inclined"
    errors = draw_errors(stand, matrices, positions, rng, inclined)
    by_mounting = {"alpha3_rad": dict(zip(matrices, errors["alpha3_rad"]))}
    for key in ("alpha1_rad", "alpha2_rad"):
        by_mounting[key] = dict(zip(matrices, errors[key] if inclined else [errors[key]] * len(matrices)))
    tilts = {one: math.radians(INCLINED["tilt"][one]) if inclined else 0.0 for one in matrices}
    unit = " [V]" if schedule_name in UNITS_TOLD else ""
    lines = ["mounting,position," + ",".join(f"{name}{unit}" for name in ("ux", "uy", "uz"))]
    for (mounting, position, angle_deg), alpha4 in zip(positions, errors["alpha4_rad"]):
        alpha1, alpha2, alpha3 = (by_mounting[key][mounting] for key in ("alpha1_rad", "alpha2_rad", "alpha3_rad"))
        a = specific_force(matrices[mounting], angle_deg, tilts[mounting] + alpha1, alpha2, alpha3, alpha4)
        outputs = [u0 + row[0] * a[0] + row[1] * a[1] + row[2] * a[2] for row, u0 in zip(block["K"], block["U0"])]
        for _ in range(stand["samples"]):
            noisy = ",".join(f"{u + rng.gauss(0.0, stand['noise_v']):.7f}" for u in outputs)
            lines.append(f"{mounting},{position},{noisy}")
    truth = {"seed": seed, "K": block["K"], "U0": block["U0"], **errors}
    return "\n".join(lines) + "\n", json.dumps(truth, indent=1) + "\n"


def main(folder: Path) -> None:
    """Write all runs into a folder."""
    for name, stand, schedule, seed in RUNS:
        run, truth = generate(stand, schedule, seed)
        (folder / f"{name}.csv").write_text(run, encoding="utf-8", newline="\n")
        (folder / f"{name}.truth.json").write_text(truth, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else EXAMPLES)
