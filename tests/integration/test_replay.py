"""`tumble replay`: a recorded log through the firmware again, on this machine. On the board: test_zcu102.py."""

import json

import numpy as np
import pytest
from simulated_bench import scenario

from tumble.documents.bench import written
from tumble.world import in_process, replay
from tumble.world.border import Border

MENDED = {"operator__mend_s": 2, "operator__mends": 3}
HALVES = "id=1667 mask=2031"  # 683h and 693h
RUNS = {
    "as it is": {},
    "another estimator": {"procedure__estimator": "least_squares", "procedure__samples": 77},
    "the main loop never sleeps": {"firmware__loop_us": 0},
    "the main loop is slow": {"firmware__loop_us": 5000},
    "lost": {"fault": f"frame_drop time=5 duration=20 {HALVES} probability=0.002 count=100000"},
    "corrupted": {"fault": f"frame_corrupt time=5 duration=20 {HALVES} probability=0.002 count=100000"},
    "twice": {"fault": f"frame_duplicate time=5 duration=20 {HALVES} probability=0.01 count=100000"},
    "reordered": {"fault": f"frame_reorder time=5 duration=20 {HALVES} probability=0.01 count=100000"},
    "repeated for noise": {"fault": "noisy at=1.3 phase=average duration=0.2 channels=xy value=0.1"},
    "drive fault, mended": {**MENDED, "fault": "drive_fault at=1.5 phase=move delay=0.1 value=30001"},
    "drive without power": {**MENDED, "fault": "drive_power_cycle at=2.2 phase=average delay=0.1 duration=1"},
    "drive silent": {**MENDED, "fault": "drive_silent at=2.2 phase=move delay=0.1 duration=2"},
    "block without power": {**MENDED, "fault": "block_power_cycle at=1.7 phase=average delay=0.1 duration=1"},
    "wrong mounting": {**MENDED, "operator__wrong_mounting": 2, "operator__mounted_instead": 1},
}


def recorded(folder, seed=1, **keys):
    """(document of a run, its scenario); its folder is run."""
    path = scenario(folder, **keys)
    world = Border(seed, path.read_text().splitlines(), None)
    in_process.Run(world, lambda event: None).to_its_end()
    (folder / "run").mkdir()
    found = written(in_process.write(world, folder / "run"))
    assert found["exit"] == 0
    return found, path


def played(log, path):
    """The firmware when it has heard all of it."""
    return replay.played(replay.read(str(log)), str(path))


def replayed(log, path):
    """What it has found then."""
    return written(played(log, path).document())


@pytest.mark.parametrize("run", RUNS)
def test_the_same_bits_again(run, tmp_path):
    found, path = recorded(tmp_path, **RUNS[run])
    again = replayed(tmp_path / "run/bus.log", path)
    for name in ("exit", "K", "U0", "means", "closure_g", "verification", "state"):
        assert again[name] == found[name], name
    for name in ("samples_received", "samples_lost", "samples_averaged", "frames_wrong_crc", "retries", "faults"):
        assert again["counters"][name] == found["counters"][name], name
    assert again["counters"]["commands_refused_in_replay"] == 0


def test_the_samples_again(tmp_path):
    """run.csv of a replay: so a board that cannot write files has one."""
    _, path = recorded(tmp_path)
    (tmp_path / "again").mkdir()
    in_process.write(played(tmp_path / "run/bus.log", path), tmp_path / "again")
    for name in ("run.csv", "bus.log"):
        assert (tmp_path / "run" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_one_changed_bit_shows(tmp_path):
    """Canary: the lowest bit of one averaged sample, its checksum made good."""
    found, path = recorded(tmp_path)
    lines = (tmp_path / "run/bus.log").read_text().splitlines()
    samples = [at for at, line in enumerate(lines) if " 683#" in line]
    for at in samples[len(samples) // 2 :: 50]:
        head, data = lines[at].split("#")
        changed = bytearray.fromhex(data)
        changed[0] ^= 1
        changed[7] = crc8(bytes([0x83]) + changed[:7])
        (tmp_path / "changed.log").write_text("\n".join([*lines[:at], f"{head}#{changed.hex()}", *lines[at + 1 :]]))
        again = replayed(tmp_path / "changed.log", path)
        if again["K"] != found["K"]:
            assert np.abs(np.array(again["K"]) - found["K"]).max() < 1e-6
            return
    pytest.fail("no sample that was changed went into a mean")


def crc8(data):
    """docs/bus."""
    crc = 0xFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x2F if crc & 0x80 else 0)) & 0xFF
    return crc ^ 0xFF


def test_what_was_there_before_node_1_it_does_not_hear(tmp_path):
    """As candump has it that was started long before, with other times and frames that no node of ours knows."""
    found, path = recorded(tmp_path)
    lines = (tmp_path / "run/bus.log").read_text().splitlines()
    before = [f"({1000 + i / 10:017.6f}) vcan0 702#7F" for i in range(100)]
    after = [f"({1700000000 + float(line[1:18]):.6f}) vcan0 {line.split()[2]}" for line in lines]
    foreign = ["(1700000004.500000) vcan0 12345678#0011", "(1700000004.600000) vcan0 123#R", ""]
    foreign += ["(1700000004.700000) vcan0 123##100", "(1700000003.000000) vcan0 7AA#"]
    after[2000:2000] = foreign
    (tmp_path / "candump.log").write_text("\n".join(before + after) + "\n")
    again = replayed(tmp_path / "candump.log", path)
    assert again["K"] == found["K"] and again["U0"] == found["U0"]


@pytest.mark.parametrize(
    "line", ["garbage", "(1.5) can0 123#00", "(0000000001.000000) can0 800#00", "(0000000001.000000) can0 123#0",
             "(0000000001.000000) can0 123#112233445566778899", "(0000000001.000000) can0 123#0g",
             "(-000000001.000000) can0 123#00", "(0000000001.000000) 123#00", "(0000000001.000000 can0 123#00",
             "(0000000001.000000) can0 #00", "(0000000001.000000) can0 12#00", "(0000000001.0000001) can0 123#00"]
)
def test_a_wrong_line_is_named(line, tumble, tmp_path):
    good = "(0000000000.000100) can0 702#00\n"
    (tmp_path / "bus.log").write_text(good + line + "\n" + good)
    ended = tumble("replay", "bus.log", cwd=tmp_path)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.startswith("tumble: bus.log:2: is not a line of candump -L") and ended.stderr.count("\n") == 1


def test_other_bad_input(tumble, tmp_path):
    for name, text in {
        "empty.log": b"\n", "bad.txt": b"no.such.key = 1\n", "short.log": b"(0000000000.000100) can0 702#00\n",
        "k.txt": b"block.k = 1 0 0 0 1 0 0 0 1\n", "binary.txt": b"\n\0\xff\0", "my.toml": b"[stand]\n",
        "hand.txt": b"firmware.stand = operator\n", "run/bus.log": b"",
    }.items():  # fmt: skip
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(text)
    before = sorted(tmp_path.rglob("*"))
    for arguments, code, says in (
        (["none.log"], 2, "none.log: No such file or directory"),
        (["empty.log"], 2, "empty.log: holds no frames"),
        (["run"], 2, "tumble: run: a folder, not a file; the log of a run folder is its bus.log\n"),
        (["short.log", "--scenario", "bad.txt"], 2, "bad.txt:1: no such key: no.such.key"),
        (["short.log", "--scenario", "k.txt"], 2, "tumble: k.txt: block.k and block.u0 go together"),
        (["short.log", "--scenario", "binary.txt"], 2, "tumble: binary.txt:2: neither a comment nor key = value"),
        (["short.log", "--scenario", "my.toml"], 2, "my.toml: looks like a stand file; a scenario file is wanted"),
        (["short.log", "--scenario", "none.txt"], 2, "none.txt: No such file or directory"),
        (["short.log", "--firmware", "toaster"], 2, "invalid choice"),
        (["short.log"], 3, "short.log: the firmware comes to no result in this log"),
        ([], 2, "BUS.log"),
        (["--commissioning", "out", "--scenario", "hand.txt"], 2, "tumble: the board zcu102 cannot do this run"),
        (["--commissioning", "out", "short.log"], 2, "--commissioning: takes no BUS.log"),
        (["--commissioning", "empty.log", "--scenario", "empty.log"], 2, "is an input of this command"),
        (["--recording", "short.log", "short.log"], 2, "is an input of this command"),
        (["--recording", "out", "empty.log"], 2, "empty.log: holds no frames"),
    ):
        ended = tumble("replay", *arguments, cwd=tmp_path)
        assert (ended.returncode, ended.stdout) == (code, ""), arguments
        assert says in ended.stderr and ended.stderr.count("\n") == 1, ended.stderr
        assert sorted(tmp_path.rglob("*")) == before


def test_a_run_folder_has_its_scenario_beside_its_log(tumble, tmp_path):
    """Without it the numbers would be others: three channels of another noise, another number of samples."""
    options = ["--seed", 3, "--samples", 60, "--estimator", "averaged", "--limit", "1e-3", "--json"]
    ended = tumble("bench", "--out", "run", *options, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    result = json.loads(ended.stdout)
    ended = tumble("replay", "run/bus.log", "--json", cwd=tmp_path)
    again = json.loads(ended.stdout)
    assert (ended.returncode, again["schema"], again["firmware"]) == (0, "tumble.replay/1", "host")
    assert (again["K"], again["U0"], again["pass"]) == (result["K"], result["U0"], True)
    assert again["counters"]["averaged"] == 18 * 60
    text = tumble("replay", "run/bus.log", cwd=tmp_path).stdout
    assert "passes the gravity check" in text and all(bits in text for bits in again["bits"])


def test_what_a_board_is_given(tumble, tmp_path):
    """What it makes of it: test_zcu102.py."""
    _, path = recorded(tmp_path, procedure__samples=77)
    log = tmp_path / "run/bus.log"
    given = {
        ("--commissioning", "out", "--scenario", path): replay.commissioning(str(path)),
        ("--commissioning", "out"): replay.commissioning(None),
        ("--recording", "out", log, "--scenario", path): replay.recording(replay.read(str(log)), str(path)),
    }
    for options, expected in given.items():
        ended = tumble("replay", *options, cwd=tmp_path)
        assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")
        assert (tmp_path / "out").read_bytes() == expected
    assert len(set(given.values())) == 3
