"""`tumble history` on PostgreSQL: a server of the test's own, in a folder of its own, reached by a socket there."""

import getpass
import os
import shutil
import subprocess
import tempfile
import threading
from pathlib import Path

import pytest
from fleets import fleet, rows_of

from tumble.documents.base import written
from tumble.errors import BadInput
from tumble.history import History

pytestmark = [pytest.mark.python, pytest.mark.toolchain]


def programs():
    """The folder of initdb and pg_ctl: Debian does not put it on the path."""
    found = [*sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb")), Path(shutil.which("initdb") or "none")]
    return next((one.parent for one in reversed(found) if one.exists()), None)


@pytest.fixture(scope="module")
def server():
    """The URL of an empty database. The server refuses to be root's, so root has it run as postgres."""
    pytest.importorskip("psycopg")
    if (folder := programs()) is None:
        pytest.skip("not there: PostgreSQL (initdb)")
    is_root = os.geteuid() == 0
    owner = "postgres" if is_root else getpass.getuser()
    as_owner = ["setpriv", f"--reuid={owner}", f"--regid={owner}", "--init-groups", "--"] if is_root else []
    with tempfile.TemporaryDirectory(prefix="tumble-pg-") as place:  # short: the name of a socket has 107 characters
        if is_root:
            shutil.chown(place, owner, owner)

        def run(program, *arguments):
            command = [*as_owner, folder / program, "-D", f"{place}/data", *arguments]
            subprocess.run(command, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, timeout=120)

        run("initdb", "--no-sync", "-A", "trust", "-U", owner, "-E", "UTF8", "--no-locale")
        run("pg_ctl", "-w", "-l", f"{place}/log", "-o", f"-k {place} -c listen_addresses= -c fsync=off", "start")
        try:
            yield f"postgresql://{owner}@/postgres?host={place}"
        finally:
            run("pg_ctl", "-w", "-m", "immediate", "stop")


@pytest.fixture
def database(server):
    """A database of the test's own."""
    import psycopg

    with psycopg.connect(server, autocommit=True) as connection:
        connection.execute("DROP DATABASE IF EXISTS own")
        connection.execute("CREATE DATABASE own")
    return server.replace("/postgres?", "/own?")


def test_it_says_what_sqlite_says(database, tumble, tmp_path):
    """Of the same fleet, to the bit but for the name."""
    rows, told = rows_of(fleet(40, 6, 61, jumps=0.003, outliers=0.003).series), []
    for where in (database, tmp_path / "history.db"):
        with History(where) as history:
            with pytest.raises(BadInput, match=r"(holds no|no such) history; tumble history add makes (one|it)"):
                history.show()
            assert (history.add_rows(rows), history.add_rows(rows)) == (240, 0)
            found = [history.trend("B000003"), history.due(1e-4), history.show("B000001")]
        told.append([{**written(one), "history": ""} for one in found])
    assert told[0] == told[1]
    done = tumble("history", "show", "--db", database, "--serial", "B000007")
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "6 calibrations")


def test_documents_come_back_as_they_were(database, tmp_path):
    import json

    import numpy as np
    from blocks import NOMINAL_K
    from calibrations import result

    path = tmp_path / "r.json"
    told = result(NOMINAL_K, np.zeros(3), np.eye(12) * 1e-10, serial="A", created="2026-01-02T03:04:05Z")
    path.write_text(json.dumps(told))
    with History(database) as history:
        assert history.add(path) == 1
        assert history.document(history.show().calibrations[0].sha256) == path.read_bytes()


def test_two_who_add_at_once_add_all_once(database):
    """Whoever is late is told so, and finds what the other has added."""
    rows = rows_of(fleet(60, 6, 62).series)
    with History(database) as first:
        first.add_rows(rows[:1])
    said = []

    def add():
        with History(database) as history:
            for _ in range(2):
                try:
                    return said.append(history.add_rows(rows))
                except BadInput as error:
                    assert "another program adds to it now; nothing was added: try again" in str(error)

    threads = [threading.Thread(target=add) for _ in range(2)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert sorted(said) == [0, 359]
    with History(database) as history:
        assert len(history.columns()["id"]) == 360
