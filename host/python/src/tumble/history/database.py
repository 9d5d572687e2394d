"""The rows of a history in a database, through SQLAlchemy: a file of SQLite, which needs no server, or any URL.

A command is one transaction. A row is known by the SHA-256 of its document, so adding one again adds nothing. The
documents, compressed by zlib, are in a table of their own, which trends do not read.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.errors import BadInput, UsageError, needing, quoted
from tumble.history.calibrations import PARAMETERS, Row

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine, Table

VERSION = 1  # of these tables
NUMBERS = ("limit_g", "temperature_c", "gravity_m_s2", "u_norm_g", *PARAMETERS, *(f"u_{one}" for one in PARAMETERS))
TEXTS = ("serial", "type", "stand", "schedule", "estimator", "tumble", "sha256", "run_sha256")
COLUMNS = ("id", *TEXTS, "created_s", "passed", "believed", *NUMBERS, "covariance")
Columns = dict[str, "np.ndarray[Any, Any]"]
_AT_ONCE = 10_000  # rows of a statement
_ASKED = 500  # hashes of a question
_DRIVERS = {"postgresql": "psycopg"}  # where SQLAlchemy's first choice is an older one


class Database:
    """Of a file or URL, which the first rows make. Raises UsageError, NotInstalled."""

    def __init__(self, where: str):
        with needing("the history of blocks", "sqlalchemy", extra="history"):
            import sqlalchemy
        self.name = where
        url = _url(where)
        self._file = url.database if url.get_backend_name() == "sqlite" and url.database != ":memory:" else None
        self.name = self._file or url.render_as_string(hide_password=True)
        self._tables = _tables()
        try:
            self._engine: Engine = sqlalchemy.create_engine(url)
        except ImportError as error:
            raise UsageError(f"--db: {self.name} needs the Python package {error.name}") from None
        except sqlalchemy.exc.SQLAlchemyError as error:
            raise UsageError(f"--db: {quoted(error, 120)}") from None

    def close(self) -> None:
        """Leaves no connection open."""
        self._engine.dispose()

    def add(self, rows: Sequence[Row]) -> int:
        """Returns how many of them are new. All are added or none. Raises BadInput."""
        by_hash = {row["sha256"]: row for row in rows}
        with self._transaction(makes=True) as connection:
            for known in self._known(connection, list(by_hash)):
                by_hash.pop(known, None)
            new = list(by_hash.values())
            for at in range(0, len(new), _AT_ONCE):
                self._insert(connection, new[at : at + _AT_ONCE])
        return len(new)

    def read(self, serials: Iterable[str] = (), kind: str | None = None) -> Columns:
        """All columns, by block and time, as arrays; a number that is not there is NaN. `kind`: of the blocks of this
        type, which is that of their last calibrations. Raises BadInput."""
        from sqlalchemy import func, select

        table = self._tables["calibration"]
        query = select(*(table.c[name] for name in COLUMNS)).order_by(table.c.serial, table.c.created_s, table.c.id)
        if wanted := list(serials):
            query = query.where(table.c.serial.in_(wanted))
        if kind is not None:
            newest = table.c.created_s.desc(), table.c.id.desc()
            place = func.row_number().over(partition_by=table.c.serial, order_by=newest).label("place")
            of = select(table.c.serial, table.c.type, place).subquery()
            query = query.where(table.c.serial.in_(select(of.c.serial).where(of.c.place == 1, of.c.type == kind)))
        with self._transaction() as connection:
            rows = connection.execute(query).fetchall()
        return {name: _array(name, [row[place] for row in rows]) for place, name in enumerate(COLUMNS)}

    def document(self, sha256: str) -> bytes:
        """What was added, as it was. Raises BadInput."""
        import zlib

        from sqlalchemy import select

        table = self._tables["document"]
        with self._transaction() as connection:
            found = connection.execute(select(table.c.body).where(table.c.sha256 == sha256)).scalar()
        if found is None:
            raise BadInput(f"no document {quoted(sha256)}", self.name)
        return zlib.decompress(found)

    def _insert(self, connection: Connection, rows: Sequence[Row]) -> None:
        names = [name for name in COLUMNS if name != "id"]
        numbers = [{name: row.get(name) for name in names} for row in rows]
        connection.execute(self._tables["calibration"].insert(), numbers)
        if bodies := [{"sha256": row["sha256"], "body": row["document"]} for row in rows if row.get("document")]:
            connection.execute(self._tables["document"].insert(), bodies)

    def _known(self, connection: Connection, hashes: list[str]) -> Iterable[str]:
        """The hashes already stored; for more than 500, all stored hashes, since one scan is cheaper."""
        from sqlalchemy import select

        column = self._tables["calibration"].c.sha256
        query = select(column) if len(hashes) > _ASKED else select(column).where(column.in_(hashes))
        found: Iterable[str] = connection.execute(query).scalars()
        return found

    def _require_version(self, connection: Connection, makes: bool) -> None:
        """That these are our tables, of a version that we know. `makes` them where nothing is there."""
        from sqlalchemy import inspect, select

        table = self._tables["history"]
        there = inspect(connection).get_table_names()
        if "history" not in there:
            if not makes:
                raise BadInput("holds no history; tumble history add makes one", self.name)
            table.metadata.create_all(connection)
            connection.execute(table.insert(), [{"version": VERSION}])
        version = connection.execute(select(table.c.version)).scalar()
        if version != VERSION:
            raise BadInput(f"a history of version {version}; this tumble reads {VERSION}: use a newer one", self.name)

    @contextmanager
    def _transaction(self, makes: bool = False) -> Iterator[Connection]:
        from sqlalchemy.exc import IntegrityError, SQLAlchemyError

        if self._file and not makes and not os.path.exists(self._file):
            raise BadInput("no such history; tumble history add makes it", self._file)
        try:
            with self._engine.begin() as connection:
                self._require_version(connection, makes)
                yield connection
        except IntegrityError:
            raise BadInput("another program adds to it now; nothing was added: try again", self.name) from None
        except SQLAlchemyError as error:
            cause = " ".join(str(getattr(error, "orig", None) or error).split())
            raise BadInput(f"the database refuses: {quoted(cause, 120)}", self.name) from None
        except ImportError as error:
            raise UsageError(f"--db: {self.name} needs the Python package {error.name}") from None


def _url(where: str) -> Any:
    from sqlalchemy import make_url
    from sqlalchemy.exc import ArgumentError

    if not where:
        raise UsageError("--db: is empty: give the name of a file, such as history.db, or a URL")
    if "://" not in where:
        from sqlalchemy import URL

        return URL.create("sqlite", database=where)
    try:
        url = make_url(where)
    except (ArgumentError, ValueError):
        raise UsageError("--db: not the URL of a database, such as postgresql://USER@HOST/NAME") from None
    driver = _DRIVERS.get(url.drivername)
    return url if driver is None else url.set(drivername=f"{url.drivername}+{driver}")


def _tables() -> Mapping[str, Table]:
    from sqlalchemy import BigInteger, Boolean, Column, Float, Index, Integer, LargeBinary, MetaData, String, Table

    metadata = MetaData()
    serial_key = BigInteger().with_variant(Integer, "sqlite")
    hashes = {"sha256": {"unique": True, "nullable": False}}
    Table("history", metadata, Column("version", Integer, nullable=False))
    calibration = Table(
        "calibration",
        metadata,
        Column("id", serial_key, primary_key=True),
        *(Column(name, String(255), **hashes.get(name, {})) for name in TEXTS),
        Column("created_s", BigInteger, nullable=False),
        Column("passed", Boolean, nullable=False),
        Column("believed", Boolean, nullable=False),
        *(Column(name, Float(53)) for name in NUMBERS),
        Column("covariance", LargeBinary),
    )
    Index("of_block", calibration.c.serial, calibration.c.created_s)
    body = Column("body", LargeBinary, nullable=False)
    Table("document", metadata, Column("sha256", String(64), primary_key=True), body)
    tables: Mapping[str, Table] = metadata.tables
    return tables


def _array(name: str, values: list[Any]) -> Any:
    if name in NUMBERS:
        return np.array(values, dtype=float)
    kinds: dict[str, Any] = {"id": np.int64, "created_s": np.int64, "passed": bool, "believed": bool}
    return np.array(values, dtype=kinds.get(name, object))
