"""Work in pieces: the same results whoever does them; a killed worker's are done again; what is done is kept."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import EXAMPLES
from simulated_bench import wait_until

from tumble.errors import BadInput, BenchFault
from tumble.workers.crews import Processes
from tumble.workers.over import Kept, Piece, Team, over
from tumble.world import campaigns

pytestmark = pytest.mark.python
COUNT = 12
VALIDATE = ("plan", "validate", "--estimator", "refined", "--runs", "9000", "--json")


class Noted:
    """A job that leaves numbers and words, and notes in a folder who has done what. `kills`: at this piece its process
    dies, so many `times`."""

    def __init__(self, folder, kills=None, times=1):
        self.folder, self.kills, self.times = str(folder), kills, times

    def __call__(self, number):
        with open(os.path.join(self.folder, f"{number}"), "a") as notes:
            notes.write(f"{os.getpid()}\n")
        if number == self.kills and len(self.noted(number)) <= self.times:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(0.002 * (number % 3))  # so that later ones are done earlier
        drawn = np.random.default_rng(number).standard_normal(3)
        return {"drawn": drawn, "counts": np.arange(number), "words": f"piece {number}"}

    def noted(self, number):
        with open(os.path.join(self.folder, f"{number}")) as notes:
            return notes.read().split()


def pieces():
    return (Piece(f"number {number}", number, 10) for number in range(COUNT))


def done_by(crew, job, kept=None, **options):
    with Team(crew, kept) as team:
        return list(over(pieces(), job, team, **options))


def same(one, other):
    return len(one) == len(other) and all(
        a.keys() == b.keys() and all(np.array_equal(a[name], b[name]) for name in a) for a, b in zip(one, other)
    )


def test_processes_give_what_this_one_gives_in_its_order(tmp_path):
    sizes = []
    job = Noted(tmp_path)
    assert same(done_by(None, job), done_by(Processes(2), job, progress=sizes.append))
    assert sizes == [10] * COUNT
    assert {len(set(job.noted(number))) for number in range(COUNT)} == {2}


def test_what_a_killed_process_had_is_done_again(tmp_path, capfd):
    alone = done_by(None, Noted(tmp_path))
    again = tmp_path / "again"
    again.mkdir()
    assert same(alone, done_by(Processes(2), Noted(again, kills=5)))
    told = capfd.readouterr().err.splitlines()
    assert "tumble: a worker process has died: number 5 was under way, and is done again alone" in told


class Together(Noted):
    """A job in which number 0 and number 1 each time wait for one another; the first time number 0 then kills its
    process."""

    def __call__(self, number):
        if number > 1:
            return {"times": np.array([1])}
        with open(os.path.join(self.folder, f"{number}"), "a") as notes:
            notes.write(f"{os.getpid()}\n")
        times, other = len(self.noted(number)), os.path.join(self.folder, f"{1 - number}")
        wait_until(lambda: os.path.exists(other) and len(self.noted(1 - number)) >= times)
        if times == 1:
            os.kill(os.getpid(), signal.SIGKILL) if number == 0 else time.sleep(3600)
        return {"times": np.array([times])}


def test_what_was_under_way_is_done_again_at_the_same_time(tmp_path):
    given = (2, 3, 0, 1)  # the first two, as an executor learns with a result which processes it has
    with Team(Processes(2)) as team:
        found = list(over((Piece(f"number {number}", number) for number in given), Together(tmp_path), team))
    assert [one["times"][0] for one in found] == [1, 1, 2, 2]


def never_ends(number):
    if number:
        time.sleep(3600)
    return {"words": "done"}


def test_an_interrupt_does_not_wait_for_what_is_under_way():
    with pytest.raises(KeyboardInterrupt), Team(Processes(2)) as team:
        for _ in over(pieces(), never_ends, team):
            raise KeyboardInterrupt


def test_a_seed_that_kills_its_process_ends_it_and_is_named():
    """The others of its piece are not to blame."""
    pieces = [campaigns.piece(0, 9), campaigns.piece(9, 9)]
    with pytest.raises(BenchFault, match=r"^seed 5: the process that does it dies, also alone$"):
        with Team(Processes(2)) as team:
            list(over(pieces, Fatal(5), team))


class Fatal:
    """A job that dies of one seed, as of a fault in C."""

    def __init__(self, seed):
        self.seed = seed

    def __call__(self, seeds):
        if self.seed in range(seeds[0], sum(seeds)):
            os.kill(os.getpid(), signal.SIGSEGV)
        return {"sum": np.array([sum(range(seeds[0], sum(seeds)))])}


def test_goes_on_from_what_is_kept(tmp_path):
    pytest.importorskip("pyarrow")
    file, job = str(tmp_path / "done.parquet"), Noted(tmp_path)
    with pytest.raises(KeyboardInterrupt), Team(kept=Kept(file, {"campaign": "test", "seed": 1})) as team:
        for number, _ in enumerate(over(pieces(), job, team)):
            if number == 4:
                raise KeyboardInterrupt
    sizes = []
    resumed = done_by(None, job, Kept(file, {"campaign": "test", "seed": 1}), progress=sizes.append)
    assert [len(job.noted(number)) for number in range(COUNT)] == [1] * COUNT
    assert sizes == [10] * COUNT
    assert same(resumed, done_by(None, job))
    done_by(None, job, Kept(file, {"campaign": "test", "seed": 1}))
    assert [len(job.noted(number)) for number in range(COUNT)] == [2] * COUNT


def test_what_is_kept_of_another_campaign_is_refused(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    file = str(tmp_path / "done.parquet")
    done_by(None, Noted(tmp_path), Kept(file, {"campaign": "test", "seed": 1}))
    with pytest.raises(BadInput, match="other inputs, options or version"):
        Kept(file, {"campaign": "test", "seed": 2})
    with pytest.raises(BadInput, match="of another campaign: 'test'"):
        Kept(file, {"campaign": "else", "seed": 1})
    parquet.write_table(parquet.read_table(file).replace_schema_metadata({}), file)
    with pytest.raises(BadInput, match="not a file of --resume"):
        Kept(file, {"campaign": "test", "seed": 1})
    with open(file, "w") as stream:
        stream.write("text")
    with pytest.raises(BadInput, match="not a Parquet file"):
        Kept(file, {"campaign": "test", "seed": 1})


def test_a_validation_is_the_same_by_two_workers_and_from_a_file(tumble, tmp_path):
    pytest.importorskip("pyarrow")
    file = str(tmp_path / "done.parquet")
    plain = tumble(*VALIDATE, cwd=EXAMPLES)
    kept = tumble(*VALIDATE, "--workers", "2", "--resume", file, cwd=EXAMPLES)
    again = tumble(*VALIDATE, "--resume", file, cwd=EXAMPLES)
    assert plain.returncode == 0 and plain.stdout == kept.stdout == again.stdout
    assert plain.stderr == kept.stderr == again.stderr == ""


def refuses(_):
    raise BadInput("no such thing", "a file", row=3)


def test_what_a_job_complains_of_comes_as_it_is():
    with pytest.raises(BadInput, match=r"^a file: row 3: no such thing$") as raised:
        done_by(Processes(2), refuses)
    assert raised.value.row == 3


@pytest.mark.parametrize(
    "arguments, complaint",
    [
        (["--workers", "0"], "--workers: '0' is not a whole number from 1 to 256"),
        (["--workers", "2", "--cluster", "tcp://here:1"], "--cluster: it has workers of its own"),
        (["--resume", "done.txt"], "--resume: 'done.txt' does not end in .parquet"),
    ],
)
def test_usage(refused, arguments, complaint):
    assert complaint in refused("plan", "validate", *arguments, cwd=EXAMPLES)


def test_nowhere_to_keep_what_is_done(refused):
    pytest.importorskip("pyarrow")
    said = refused("plan", "validate", "--resume", "nowhere/done.parquet", cwd=EXAMPLES)
    assert "nowhere/done.parquet: cannot be written" in said


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done(tmp_path):
    """The file comes after the first few seconds."""
    parquet = pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "done.parquet"
    many = ["plan", "validate", "--runs", "10000000", "--workers", "2", "--resume", str(file)]
    child = subprocess.Popen([sys.executable, "-m", "tumble", *many], stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 300
    while not file.exists() and time.monotonic() < until and child.poll() is None:
        time.sleep(0.1)
    child.send_signal(signal.SIGINT)
    assert (child.communicate(timeout=120)[1], child.returncode) == ("tumble: interrupted\n", 130)
    assert [one.name for one in tmp_path.iterdir()] == ["done.parquet"]
    assert parquet.read_table(file).num_rows > 0
