"""Six faces of which one is missing, and a second sensor in the same file: the message says which, and what to do."""

import numpy as np
import pytest

pytestmark = pytest.mark.python

FACES = [(axis, sign) for axis in range(3) for sign in (1, -1)]
FACE_OPTIONS = ("--schedule", "hand_laid", "--order", "any")
RATE_HZ = 50


def recorded(faces, scale=9.81, bias=(0.3, -0.2, 0.1), seed=5):
    """Time and outputs of a sensor laid on these faces, for 2 s each, and carried for 1 s before."""
    rng, parts, before = np.random.default_rng(seed), [], np.array([0.0, 0.0, 0.5])
    for axis, sign in faces:
        force = sign * np.eye(3)[axis] + rng.normal(0, 2e-3, 3)
        way = np.linspace(0, 1, RATE_HZ)[:, None]
        parts += [before + way * (force - before) + rng.normal(0, 0.1, (RATE_HZ, 3)), np.tile(force, (2 * RATE_HZ, 1))]
        before = force
    felt = np.concatenate(parts)
    return np.arange(len(felt)) / RATE_HZ, scale * (felt + rng.normal(0, 1e-3, felt.shape)) + bias


def written(path, header, time, *outputs):
    np.savetxt(path, np.column_stack([time, *outputs]), "%.5f", delimiter=",", header=header, comments="")
    return path


@pytest.mark.parametrize("missing", range(6))
@pytest.mark.parametrize("signs", ["+++", "-+-"])
def test_the_missing_face_is_named(missing, signs, refused, tmp_path):
    faces = [face for place, face in enumerate(FACES) if place != missing]
    time, outputs = recorded(faces)
    flipped = np.array([{"+": 1, "-": -1}[one] for one in signs])
    file = written(tmp_path / "five.csv", "time [s],ax [m/s^2],ay [m/s^2],az [m/s^2]", time, outputs * flipped)
    axis, sign = FACES[missing]
    face = f"{'xyz'[axis]} {'up' if sign > 0 else 'down'}"
    line = refused("import", file, *FACE_OPTIONS, f"--signs={signs}").splitlines()[-1]
    assert line == (
        f"tumble: {file}: 5 rests, but none with {face}: scale and bias need all six "
        "faces; lay the sensor on that face too, or check whether --still, --drift or --min-rest hide it"
    )


def test_of_few_faces_none_is_named(refused, tmp_path):
    time, outputs = recorded(FACES[:3])
    file = written(tmp_path / "three.csv", "time [s],ax,ay,az", time, outputs)
    assert "3 rests do not show scale and bias of every channel" in refused("import", file, *FACE_OPTIONS)


@pytest.mark.parametrize(
    ("header", "second"),
    [
        ("time [s],ax,ay,az,ax2,ay2,az2", "ux=ax2,uy=ay2,uz=az2"),
        ("time [s],ax [m/s^2],ay [m/s^2],az [m/s^2],a2x [m/s^2],a2y [m/s^2],a2z [m/s^2]", "ux=a2x,uy=a2y,uz=a2z"),
        ("time [s],ax,ay,az,gx,gy,gz", None),
        ("time [s],ax,ay,az,ax2,ay2,temp2", None),
    ],
)
def test_a_second_sensor_is_told_and_read(header, second, tumble, tmp_path):
    time, outputs = recorded(FACES)
    other = 2 * outputs[:, [1, 2, 0]]
    file = written(tmp_path / "two.csv", header, time, outputs, other)
    told = " ".join(tumble("import", file, *FACE_OPTIONS, "--signs=+++").stdout.split())
    assert ("another sensor?" in told) == (second is not None)
    if second is not None:
        assert f"- another sensor? --columns {second} " in told
        words = ("--columns", second, "--signs=+++", "--unit", "m/s^2", "--out", tmp_path / "run.csv")
        done = tumble("import", file, *FACE_OPTIONS, *words)
        assert done.returncode == 0, done.stderr
        means = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=2)[:, 2:5]
        assert np.abs(means).max() == pytest.approx(2 * 9.81, rel=0.05)
