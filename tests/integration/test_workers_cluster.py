"""The same work by a cluster of Dask's, a worker of which is killed; and over TLS."""

import os
import shutil
import signal
import subprocess
import threading
import time

import pytest
from conftest import EXAMPLES
from test_workers import COUNT, VALIDATE, Noted, done_by, same

pytestmark = [pytest.mark.python, pytest.mark.toolchain]
distributed = pytest.importorskip("distributed")

from tumble.workers.crews import Cluster  # noqa: E402

OPTIONS = {"threads_per_worker": 1, "dashboard_address": ":0", "silence_logs": "CRITICAL"}


@pytest.fixture(scope="module")
def cluster():
    """Two processes of one thread."""
    with distributed.LocalCluster(n_workers=2, **OPTIONS) as found:
        yield found


def test_a_cluster_gives_what_one_process_gives(cluster, tmp_path):
    job = Noted(tmp_path)
    assert same(done_by(None, job), done_by(Cluster(cluster.scheduler_address), job))
    assert {len(set(job.noted(number))) for number in range(COUNT)} == {2}


def test_what_a_killed_worker_had_is_done_again(cluster, tmp_path):
    alone, again = tmp_path / "alone", tmp_path / "again"
    alone.mkdir()
    again.mkdir()
    job = Noted(again, kills=5)
    assert same(done_by(None, Noted(alone)), done_by(Cluster(cluster.scheduler_address), job))
    assert len(job.noted(5)) == 2


def test_a_validation_by_the_command_line_with_a_worker_killed(cluster, tumble):
    """From outside, while it has something to do."""
    killed = []
    victim = threading.Thread(target=kill_one_at_work, args=(cluster, killed))
    victim.start()
    done = tumble(*VALIDATE, "--runs", "60000", "--cluster", cluster.scheduler_address, cwd=EXAMPLES)
    victim.join()
    assert len(killed) == 1
    plain = tumble(*VALIDATE, "--runs", "60000", cwd=EXAMPLES)
    assert (done.returncode, done.stdout, done.stderr) == (0, plain.stdout, "")


def kill_one_at_work(cluster, killed):
    until = time.monotonic() + 60
    while time.monotonic() < until:
        busy = [one.name for one in list(cluster.scheduler.workers.values()) if one.processing]
        if busy:
            killed.append(cluster.workers[busy[0]].pid)
            os.kill(killed[0], signal.SIGKILL)
            return
        time.sleep(0.01)


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl")
def test_tls_files_are_those_of_its_own_configuration(tumble, tmp_path):
    files = {"tls_ca_file": tmp_path / "cert.pem"}
    for role in ("scheduler", "worker", "client"):
        files |= {f"tls_{role}_cert": tmp_path / "cert.pem", f"tls_{role}_key": tmp_path / "key.pem"}
    make = "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=tumble -keyout key.pem -out cert.pem"
    subprocess.run(make.split(), cwd=tmp_path, check=True, capture_output=True)
    security = distributed.Security(**{name: str(file) for name, file in files.items()}, require_encryption=True)
    with distributed.LocalCluster(n_workers=1, **OPTIONS, security=security) as encrypted:
        address = encrypted.scheduler_address
        assert address.startswith("tls://")
        names = {"CA_FILE": "cert", "CLIENT__CERT": "cert", "CLIENT__KEY": "key"}
        told = {f"DASK_DISTRIBUTED__COMM__TLS__{name}": f"{tmp_path / file}.pem" for name, file in names.items()}
        with_files = tumble(*VALIDATE, "--cluster", address, cwd=EXAMPLES, **told)
        without = tumble(*VALIDATE, "--cluster", address, cwd=EXAMPLES)
    assert with_files.stdout == tumble(*VALIDATE, cwd=EXAMPLES).stdout
    assert (without.returncode, without.stderr.count("\n")) == (2, 1)


def test_nobody_answers(refused):
    line = refused("plan", "validate", "--cluster", "tcp://127.0.0.1:1", cwd=EXAMPLES)
    assert line.startswith("tumble: --cluster: 'tcp://127.0.0.1:1': no scheduler answers")
    assert "no scheduler answers" in refused("plan", "validate", "--cluster", "nonsense://x", cwd=EXAMPLES)
