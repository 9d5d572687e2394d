"""Files that are made to do harm: endless, cut anywhere, small and huge inside, of other types. One line, exit code 2,
within bounded memory and time. What may take much memory runs in a process of its own, in 2 GiB of address space."""

import gzip
import io
import resource
import struct
import subprocess
import sys
import zipfile
import zlib

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble as package
from tumble.files import disk

pytestmark = pytest.mark.python
MOST = 2 << 30
WITHIN_S = 120
NAMES = ("mounting", "position", "ux", "uy", "uz")
PIECE, PIECES = bytes(1 << 24), 144
ROWS = PIECES * len(PIECE) // 8  # of doubles: more than fit, in a file of some kilobytes or megabytes


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (MOST, MOST))


@pytest.fixture
def refused_within(tmp_path):
    """Run `tumble ...` on what it must refuse; returns the line."""

    def run(*arguments, stdin=subprocess.DEVNULL):
        before = sorted(tmp_path.rglob("*"))
        command = [sys.executable, "-m", "tumble", *map(str, arguments)]
        done = subprocess.run(command, stdin=stdin, text=True, cwd=tmp_path, capture_output=True, timeout=WITHIN_S,
                              preexec_fn=limit_memory)
        assert (done.returncode, done.stdout) == (2, ""), done.stderr
        assert done.stderr.count("\n") == 1 and "fault in tumble itself" not in done.stderr, done.stderr
        assert "not enough memory" not in done.stderr
        assert sorted(tmp_path.rglob("*")) == before
        return done.stderr

    return run


@pytest.fixture(scope="module")
def columns():
    rows = np.loadtxt(EXAMPLES / "paper_stand.csv", delimiter=",", skiprows=1)
    return {name: rows[:, place] for place, name in enumerate(NAMES)}


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("result") / "result.json"
    package.solve(str(EXAMPLES / "paper_stand.csv"), stand=str(EXAMPLES / "paper_stand.toml")).save(path)
    return path


# Without an end.


@pytest.mark.parametrize("arguments, said", [
    (("report", "RESULT", "--logo", "/dev/zero", "--out", "x.html"), "more than 2000000 bytes"),
    (("report", "RESULT", "--template", "/dev/zero", "--out", "x.html"), "more than 64 MiB"),
    (("report", "/dev/zero", "--out", "x.html"), "more than 64 MiB"),
    (("import", "LOG", "--dbc", "/dev/zero"), "more than 64 MiB"),
    (("import", "/dev/zero"), "not a text file"),
    (("solve", "RUN", "--stand", "/dev/zero"), "more than 64 MiB"),
    (("solve", "RUN", "--schedule", "/dev/zero"), "more than 64 MiB"),
    (("solve", "/dev/zero"), "not a text file"),
    (("apply", "RESULT", "/dev/zero"), "a line of more than 1 MiB"),
])  # fmt: skip
def test_files_without_an_end(arguments, said, result, refused_within, tmp_path):
    log = tmp_path / "bus.log"
    log.write_text("".join(f"({n / 100:.6f}) can0 683#0102030405060708\n" for n in range(100)))
    places = {"RESULT": result, "RUN": EXAMPLES / "paper_stand.csv", "LOG": log}
    assert said in refused_within(*(places.get(word, word) for word in arguments))


def test_a_pipe_without_an_end(refused_within):
    with open("/dev/zero", "rb") as zeros:
        assert "not a text file" in refused_within("solve", "-", stdin=zeros)


@pytest.mark.parametrize("byte", [b"1", b"\n"])
def test_what_gzip_has_made_small(byte, refused_within, tmp_path):
    (tmp_path / "run.csv.gz").write_bytes(64 * gzip.compress(byte * (8 << 20), 1))  # half a gigabyte
    assert "no header line within 16 MiB" in refused_within("solve", "run.csv.gz")


def test_a_line_without_an_end_below_the_header(refused_within, tmp_path):
    header = gzip.compress(b"mounting,position,ux,uy,uz\n1,1,")
    (tmp_path / "run.csv.gz").write_bytes(header + 64 * gzip.compress(b"1" * (8 << 20), 1))
    assert "a line of more than 1 MiB" in refused_within("solve", "run.csv.gz")


def test_what_is_decompressed_has_an_end(monkeypatch, tmp_path):
    monkeypatch.setattr(disk, "MOST_IN_ALL", 4 << 20)
    (tmp_path / "run.csv.gz").write_bytes(gzip.compress(b"1,1,0,0,1\n" * 500_000))
    with pytest.raises(package.BadInput, match=r"more than 0 GiB, decompressed"):
        list(disk.Incoming(str(tmp_path / "run.csv.gz")))


def test_the_limit_is_what_it_says(tmp_path):
    (tmp_path / "f").write_bytes(bytes(1000))
    assert len(disk.read_bytes(str(tmp_path / "f"), most=1000)) == 1000
    with pytest.raises(package.BadInput, match=r"more than 999 bytes"):
        disk.read_bytes(str(tmp_path / "f"), most=999)


# Tables of other kinds.


def write_parquet(path, columns):
    pa = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from pyarrow import parquet

    parquet.write_table(pa.table(columns), path)


def write_mat(path, columns):
    scipy_io = pytest.importorskip("scipy.io", reason="scipy is not installed")
    scipy_io.savemat(path, columns, do_compression=True)


def write_npz(path, columns):
    np.savez_compressed(path, **columns)


WRITERS = {".parquet": write_parquet, ".mat": write_mat, ".npz": write_npz}


@pytest.mark.parametrize("suffix", WRITERS)
def test_tables_cut_anywhere(suffix, columns, refused, tmp_path):
    WRITERS[suffix](tmp_path / f"whole{suffix}", columns)
    data = (tmp_path / f"whole{suffix}").read_bytes()
    run = tmp_path / f"run{suffix}"
    sizes = {0, 1, 4, 8, 127, 128, 136, *range(0, len(data), len(data) // 40), len(data) - 8, len(data) - 1}
    for size in sorted(sizes):
        run.write_bytes(data[:size])
        line = refused("solve", run)
        assert "fault in tumble itself" not in line, (size, line)


@pytest.mark.parametrize("suffix", WRITERS)
def test_tables_with_a_byte_changed(suffix, columns, tumble, tmp_path):
    """Whatever it is, it is refused, or it is read; nothing is a fault."""
    WRITERS[suffix](tmp_path / f"whole{suffix}", columns)
    data = bytearray((tmp_path / f"whole{suffix}").read_bytes())
    run = tmp_path / f"run{suffix}"
    for place in np.random.default_rng(1).integers(0, len(data), 40):
        data[place] ^= 0x55
        run.write_bytes(data)
        data[place] ^= 0x55
        done = tumble("solve", run)
        assert done.returncode in (0, 1, 2) and "fault in tumble itself" not in done.stderr, (place, done.stderr)
        assert done.returncode != 2 or (done.stdout == "" and done.stderr.count("\n") == 1)


def test_a_parquet_file_of_more_numbers_than_fit(refused_within, tmp_path):
    pa = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from pyarrow import parquet

    part = pa.table({"ux": np.ones(ROWS // 48)})
    with parquet.ParquetWriter(tmp_path / "run.parquet", part.schema) as writer:
        for _ in range(48):
            writer.write_table(part)
    assert (tmp_path / "run.parquet").stat().st_size < 10_000_000
    assert "run.parquet: needs more memory than such a file may" in refused_within("solve", "run.parquet")


def deflated(header, pieces, window=15):
    """A header and so many PIECEs, deflated. The compressor, told to forget, makes the same of each: it is asked once.
    What stands at the end of such a stream is left out, for nobody gets there."""
    packer = zlib.compressobj(9, zlib.DEFLATED, window)
    begin, again = (packer.compress(data) + packer.flush(zlib.Z_FULL_FLUSH) for data in (header, PIECE))
    return begin + pieces * again


def add_npz(path):
    """A column `other` of ROWS zeros."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (ROWS,)})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("other.npy", deflated(header.getvalue(), PIECES, -15))
        about = archive.getinfo("other.npy")
        about.compress_type, about.file_size = zipfile.ZIP_DEFLATED, len(header.getvalue()) + 8 * ROWS


def add_mat(path):
    """The same: an array of doubles, its sizes, its name, its numbers; and before each what it is and its length."""
    parts = struct.pack("<IIII IIii II8s II", 6, 8, 6, 0, 5, 8, 1, ROWS, 1, 5, b"other", 9, 8 * ROWS)
    packed = deflated(struct.pack("<II", 14, len(parts) + 8 * ROWS) + parts, PIECES)
    with open(path, "ab") as file:
        file.write(struct.pack("<II", 15, len(packed)) + packed)


@pytest.mark.parametrize(("suffix", "add"), [(".mat", add_mat), (".npz", add_npz)])
def test_a_table_that_decompresses_to_gigabytes(suffix, add, columns, refused_within, tmp_path):
    WRITERS[suffix](tmp_path / f"run{suffix}", columns)
    add(tmp_path / f"run{suffix}")
    assert f"run{suffix}: needs more memory than such a file may" in refused_within("solve", f"run{suffix}")


def test_an_hdf5_file_that_declares_more_numbers_than_fit(refused_within, tmp_path):
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    with h5py.File(tmp_path / "log.h5", "w") as file:
        for name in ("ax", "ay", "az"):
            file.create_dataset(name, (10 * ROWS,), dtype="f8", chunks=(1 << 20,))
    assert "log.h5: needs more memory than such a file may" in refused_within("import", "log.h5")


@pytest.mark.parametrize("column", ["text", "list", "struct", "binary", "null"])
def test_parquet_of_other_types(column, columns, refused, tmp_path):
    pa = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    rows = len(columns["ux"])
    others = {"text": pa.array(["a"] * rows), "list": pa.array([[1.0]] * rows), "struct": pa.array([{"a": 1}] * rows),
              "binary": pa.array([b"\xff"] * rows), "null": pa.nulls(rows)}
    write_parquet(tmp_path / "run.parquet", {**columns, "ux": others[column]})
    assert "column ux: n" in refused("solve", tmp_path / "run.parquet")  # not numbers, nan


@pytest.mark.parametrize("column", ["cell", "struct", "text", "complex", "cube"])
def test_mat_of_other_types(column, columns, refused, tmp_path):
    others = {"cell": np.array([[1], [2, 3]], dtype=object), "struct": {"a": 1}, "text": "abc",
              "complex": columns["ux"] * 1j, "cube": np.zeros((2, 3, 4))}
    write_mat(tmp_path / "run.mat", {**columns, "ux": others[column]})
    assert "ux" in refused("solve", tmp_path / "run.mat")


# CAN logs in MF4 and BLF.


def write_log(path):
    can = pytest.importorskip("can", reason="python-can is not installed")
    if path.suffix == ".mf4":
        pytest.importorskip("asammdf", reason="asammdf is not installed")
    with can.Logger(str(path)) as log:
        for number in range(2000):
            log.on_message_received(can.Message(timestamp=1e9 + number / 100, arbitration_id=0x683, channel=0,
                                                data=bytes(8), is_extended_id=False))


@pytest.mark.parametrize("suffix", [".mf4", ".blf"])
def test_logs_cut_anywhere(suffix, refused, tmp_path):
    write_log(tmp_path / f"whole{suffix}")
    data = (tmp_path / f"whole{suffix}").read_bytes()
    log = tmp_path / f"bus{suffix}"
    for size in sorted({0, 1, 8, 64, 100, *range(0, len(data), len(data) // 25), len(data) - 1}):
        log.write_bytes(data[:size])
        line = refused("import", log)
        assert "fault in tumble itself" not in line, (size, line)


def test_an_mf4_file_of_one_block_that_decompresses_to_gigabytes(refused_within, tmp_path):
    """Its compressed block is exchanged for one that holds zeros without an end."""
    write_log(tmp_path / "bus.mf4")
    data = (tmp_path / "bus.mf4").read_bytes()
    zeros = deflated(b"", 192)  # 3 GiB
    at = data.find(b"##DZ") if b"##DZ" in data else data.find(b"##DT")
    data += bytes(-len(data) % 8)
    data = data.replace(struct.pack("<Q", at), struct.pack("<Q", len(data)))  # whoever had a link to it
    block = b"##DZ" + bytes(4) + struct.pack("<QQ", 48 + len(zeros), 0)
    block += b"DT" + bytes([0, 0]) + struct.pack("<IQQ", 0, 3 << 30, len(zeros)) + zeros
    (tmp_path / "bus.mf4").write_bytes(data + block)
    assert "bus.mf4: " in refused_within("import", "bus.mf4")


# Pictures for a report.


def png(width, height):
    header = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(bytes(height * (width // 8 + 1)), 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in parts)


def svg(inside):
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9">{inside}</svg>'.encode()


NESTED = '<g id="a0"><rect width="1" height="1"/></g>' + "".join(
    f'<g id="a{level}">{10 * f"""<use href="#a{level - 1}"/>"""}</g>' for level in range(1, 9))
LOGOS = {
    "a hundred million pixels": (png(12000, 9000), "12000 x 9000 pixels; a logo may have 16 million"),
    "cut": (png(100, 100)[:60], "a PNG picture that is not whole"),
    "a JPEG that is cut": (b"\xff\xd8\xff\xe0" + bytes(100), "a JPEG picture that is not whole"),
    "a hundred million elements": (svg(f'<defs>{NESTED}</defs><use href="#a8"/>'), "draws more than 20000 elements"),
    "no XML": (svg("<g>"), "an SVG picture that cannot be read"),
    "deep": (svg(5000 * "<g>" + 5000 * "</g>"), "an SVG picture that cannot be read"),
}  # fmt: skip


@pytest.mark.parametrize("logo", LOGOS)
def test_logos(logo, result, refused_within, tmp_path):
    data, said = LOGOS[logo]
    (tmp_path / "logo").write_bytes(data)
    assert f"logo: {said}" in refused_within("report", result, "--logo", "logo", "--out", "x.html")


def test_a_logo_that_refers_to_itself_is_drawn_once(result, tumble, tmp_path):
    (tmp_path / "logo").write_bytes(svg('<g id="a"><use href="#a"/></g><use href="#a"/>'))
    assert tumble("report", result, "--logo", tmp_path / "logo", "--out", tmp_path / "x.html").returncode == 0
