"""The object table's generator: its files are up to date, it notices what is not, and refuses mistakes in one line."""

import re
import shutil
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from io import StringIO
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
GENERATE = ROOT / "tools" / "objects" / "generate"
PRODUCTS = (
    "firmware/navcomp/objects.h", "firmware/navcomp/objects.c", "docs/eds/tumble_navcomp.eds",
    "docs/eds/tumble_navcomp_without_sets.eds",
    "firmware/navcomp/keeper_objects.h", "firmware/navcomp/keeper_objects.c",
    "host/simulation/drive_objects.h", "host/simulation/drive_objects.c", "docs/eds/tumble_drive.eds",
    "host/simulation/block_objects.h", "host/simulation/block_objects.c", "docs/eds/tumble_block.eds",
    "docs/bus/tumble.dbc", "docs/canopen.md",
    "host/gateway/register_map.h", "host/gateway/registers.c", "docs/modbus.md", "docs/modbus.csv",
    "host/programs/remedies.c", "firmware/include/tumble/version.h", "host/python/src/tumble/_version.py",
    "host/python/src/tumble/firmware_tables.py", "host/python/src/tumble/client/tables.py",
)  # fmt: skip
READ = [path.relative_to(ROOT).as_posix()
        for path in (ROOT / "docs/operations.md", ROOT / "docs/porting.md", *(ROOT / "firmware").rglob("*.h"),
                     *(ROOT / "firmware/procedure").glob("*.c"), ROOT / "firmware/navcomp/standard.c",
                     ROOT / "docs/bus/block.dbc")]


def process(*arguments):
    return subprocess.run([sys.executable, GENERATE, *arguments], text=True, capture_output=True)


@cache
def program():
    """The generator, loaded once, and what forgets the headers that it has read."""
    searched = [*sys.path]
    loader = SourceFileLoader("generate", str(GENERATE))
    module = module_from_spec(spec_from_loader("generate", loader))
    loader.exec_module(module)
    sys.path[:] = searched
    return module.main, module.headers_of.cache_clear


def generate(*arguments):
    """As a process of its own would: that one takes most of its time to begin."""
    main, forget = program()
    forget()
    out, err = StringIO(), StringIO()
    with redirect_stdout(out), redirect_stderr(err), pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", [str(GENERATE), *map(str, arguments)])
        try:
            code = main()
        except SystemExit as end:
            code = end.code
    return subprocess.CompletedProcess(arguments, code, out.getvalue(), err.getvalue())


@pytest.fixture
def tables(tmp_path):
    """A copy of the tables, to be spoilt."""
    folder = tmp_path / "tables"
    folder.mkdir()
    for table in GENERATE.parent.glob("*.toml"):
        shutil.copy(table, folder)
    return folder


@pytest.fixture
def tree(tmp_path):
    """A source tree with the products and what the generator reads."""
    for name in {"VERSION", *PRODUCTS, *READ}:
        (tmp_path / "tree" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / "tree" / name)
    return tmp_path / "tree"


def change(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert text.count(old) >= 1, f"{old!r} is not in {path.name}"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


@pytest.mark.parametrize("run", [generate, process])
def test_what_is_checked_in_is_what_the_tables_say(run):
    done = run("--check")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_a_change_of_a_table_is_noticed(tables):
    """The canary of the gate: nobody ran the generator after this."""
    change(tables / "drive.toml", "value = 2000\n", "value = 2001\n")
    done = generate("--check", "--tables", tables)
    assert done.returncode == 1
    named = re.findall(r"generate: (\S+) is not what the tables say", done.stderr)
    assert named == ["host/simulation/drive_objects.c", "docs/eds/tumble_drive.eds", "docs/canopen.md"]


def test_a_change_of_the_extension_is_noticed(tables):
    """And its canary: the keeper's own tables, the node's EDS file and the page are stale, the first table is not."""
    change(tables / "keeper.toml", 'low = "TUMBLE_SETS_MIN_PAUSE_S",', "low = 61,")
    done = generate("--check", "--tables", tables)
    assert done.returncode == 1
    named = re.findall(r"generate: (\S+) is not what the tables say", done.stderr)
    assert named == ["firmware/navcomp/keeper_objects.c", "docs/eds/tumble_navcomp.eds", "docs/canopen.md"]


def test_what_is_saved_follows_from_the_tables(tree, tables):
    change(tables / "keeper.toml", "saved = true\n", "")
    assert generate("--tables", tables, "--root", tree).returncode == 0
    saved = (tree / "firmware/navcomp/keeper_objects.c").read_text().split("tumble_keeper_saved[")[1]
    assert "0x2122U" not in saved and "0x2123U" in saved


def compiles(tree):
    """Whether the extension's table is C; and what the compiler says."""
    command = [
        "cc",
        "-std=c11",
        "-fsyntax-only",
        f"-I{tree}/firmware",
        f"-I{ROOT}/firmware",
        f"-I{ROOT}/firmware/include",
    ]
    done = subprocess.run([*command, tree / "firmware/navcomp/keeper_objects.c"], text=True, capture_output=True)
    return done.returncode == 0, done.stderr


def test_the_compiler_takes_the_tables(tree):
    assert compiles(tree) == (True, "")


@pytest.mark.parametrize(
    "old, new, where",
    [
        ('member = "judged"', 'member = "committed"', "2130h:1"),
        ('type = "u8", member = "origin"', 'type = "u16", member = "origin"', "2100h:3"),
        ('"coefficients.k_v_per_g[{i}][{j}]"', '"coefficients.k_v_per_g[{j}][{i}]"', "2104h:1"),
        ('    { vector = "U0_", member = "per_month[{n}]", first = 9, unit = "V/month" },\n', "", "2163h:1"),
    ],
    ids=["out of order", "another size", "an element left out", "not the whole array"],
)
def test_the_compiler_finds_a_table_that_disagrees_with_its_struct(tables, tree, old, new, where):
    change(tables / "keeper.toml", old, new)
    assert generate("--tables", tables, "--root", tree).returncode == 0
    done, said = compiles(tree)
    assert not done and f'static assertion failed: "{where}"' in said


@pytest.mark.parametrize("product", PRODUCTS)
def test_a_change_of_a_product_by_hand_is_noticed(tree, product):
    with (tree / product).open("a", encoding="utf-8") as file:
        file.write("\n")
    done = generate("--check", "--root", tree)
    assert done.returncode == 1
    assert done.stderr.splitlines() == [f"generate: {product} is not what the tables say; run tools/objects/generate"]


@pytest.mark.parametrize(("name", "old", "new"), [
    ("docs/porting.md", "| `profile.window_counts` |", "| `profile.window` |"),
    ("firmware/stand/drive402/profile_fields.h", "6098h; 0: not written", "6098h; 0: no homing"),
])  # fmt: skip
def test_the_table_of_a_drive_s_profile_is_that_of_its_fields(tree, name, old, new):
    change(tree / name, old, new)
    done = generate("--check", "--root", tree)
    told = "generate: docs/porting.md is not what the tables say; run tools/objects/generate"
    assert (done.returncode, done.stderr.splitlines()) == (1, [told])
    change(tree / "docs/porting.md", "<!-- End of the table. -->", "")
    done = generate("--check", "--root", tree)
    assert (done.returncode, done.stderr) == (2, "generate: docs/porting.md: the marks of its table are missing\n")


def test_a_missing_product_is_noticed_and_written(tree):
    (tree / "docs/eds/tumble_block.eds").unlink()
    assert generate("--check", "--root", tree).returncode == 1
    assert not (tree / "docs/eds/tumble_block.eds").exists()
    assert generate("--root", tree).stdout == "docs/eds/tumble_block.eds\n"
    for name in PRODUCTS:
        assert (tree / name).read_bytes() == (ROOT / name).read_bytes()
    assert generate("--root", tree).stdout == ""


def test_a_change_of_a_remedy_is_noticed_and_goes_into_c(tree, tables):
    """Without the marks of the page; what C would take for the end of its text stays within it."""
    change(tables / "remedies.toml", "brake, obstacle, current limit.",
           'see [b](bus/README.md#x), `k`, \\"\\\\r\\".')
    done = generate("--check", "--root", tree, "--tables", tables)
    named = re.findall(r"generate: (\S+) is not what the tables say", done.stderr)
    assert done.returncode == 1 and "host/programs/remedies.c" in named
    assert generate("--root", tree, "--tables", tables).returncode == 0
    written = (tree / "host/programs/remedies.c").read_text()
    assert '[TUMBLE_REASON_STALL] = "The axis does not follow: see docs/bus/README.md, k, \\"\\\\r\\".",\n' in written


REMEDIES = {  # what of remedies.toml or the page is changed, into what, and what is said
    "none": ("remedies.toml", 'STALL = "', 'STALLS = "',
             "remedies.toml: does not say what to do: TUMBLE_REASON_STALL"),
    "empty": ("remedies.toml", 'NO_SAMPLES = "The block has a heartbeat but sends no samples."', 'NO_SAMPLES = ""',
              "remedies.toml: does not say what to do: TUMBLE_REASON_NO_SAMPLES"),
    "of no reason": ("remedies.toml", 'STALL = "', 'MOON = "x"\nSTALL = "',
                     "remedies.toml: [TUMBLE_REASON] is not the list of firmware/procedure/states.h, in its order"),
    "no marks": ("docs/operations.md", "<!-- TUMBLE_REASON:", "<!-- TUMBLE:",
                 "docs/operations.md: the marks of the table of TUMBLE_REASON are missing"),
}  # fmt: skip


@pytest.mark.parametrize("file, old, new, said", REMEDIES.values(), ids=REMEDIES)
def test_a_reason_without_a_remedy_is_one_line_and_exit_2(tree, tables, file, old, new, said):
    change((tables if file.endswith(".toml") else tree) / file, old, new)
    done = generate("--check", "--root", tree, "--tables", tables)
    assert (done.returncode, done.stderr) == (2, f"generate: {said}\n")


def test_a_renumbered_list_makes_the_page_stale(tree):
    change(tree / "firmware/navcomp/commands.h", "X(TUMBLE_COMMAND_NONE", "X(TUMBLE_COMMAND_NO")
    done = generate("--check", "--root", tree)
    assert done.returncode == 1 and "docs/canopen.md" in done.stderr


DRAWN = "host/python/src/tumble/firmware_tables.py"


@pytest.mark.parametrize("file, old, new, row", [
    ("procedure_states.c", ".done = TO(MOVE)", ".done = TO(SETTLE)", '("HOME", "SETTLE", "done", "")'),
    ("procedure_states.c", "nothing is left to measure", "all is there", '("NEXT", "SOLVE", "other", "all is there")'),
    ("procedure_states.c", "COMMAND_CONFIRM,", "COMMAND_CONFIRM | COMMAND_START,",
     '("WAIT_MOUNTING", "PREFLIGHT", "START", "")'),
    ("procedure.c", "? TUMBLE_STATE_PREFLIGHT : TUMBLE_STATE_NEXT", "? TUMBLE_STATE_PREFLIGHT : TUMBLE_STATE_HOME",
     '("WAIT_MOUNTING", "HOME", "CONFIRM", "")'),
    ("procedure_states.c", "    procedure->solved = true;", "    (void)fail_to_solve(procedure, TUMBLE_OK);",
     '("PROPOSE", "FAULT", "fault", "")'),
    ("states.h", '"homing the table"', '"looking for zero"', '"HOME": "looking for zero"'),
])  # fmt: skip
def test_a_changed_way_of_a_run_is_noticed_and_drawn(tree, file, old, new, row):
    change(tree / "firmware/procedure" / file, old, new)
    assert f"generate: {DRAWN} is not what the tables say" in generate("--check", "--root", tree).stderr
    assert generate("--root", tree).returncode == 0
    assert f"    {row},\n" in (tree / DRAWN).read_text() and row not in (ROOT / DRAWN).read_text()


@pytest.mark.parametrize("file, old, new, message", [
    ("states.h", "X(TUMBLE_STATE_IDLE", "X(TUMBLE_STATE_ASLEEP",
     "firmware/procedure/procedure_states.c: its rows are not the states of firmware/procedure/states.h"),
    ("procedure_states.c", ".other = TO(SETTLE), /* another attempt */", ".other = TO(SETTLE),",
     "firmware/procedure/procedure_states.c: SETTLE: no comment says when .other is taken"),
    ("procedure_states.c", "TO(HOME)", "TO(SAFETY)",
     "firmware/procedure/procedure_states.c: WAIT_MOUNTING leads to SAFETY, which is no state"),
    ("procedure.c", "go_to(procedure, TUMBLE_STATE_ABORT);", "go_to(procedure, state);",
     "firmware/procedure/procedure.c: tumble_procedure_give_up goes where this program cannot read"),
    ("procedure.c", "allows(procedure, COMMAND_CONFIRM)", "true",
     "firmware/procedure/procedure.c: COMMAND_CONFIRM leads nowhere"),
])  # fmt: skip
def test_a_run_that_cannot_be_read_is_one_line_and_exit_2(tree, file, old, new, message):
    change(tree / "firmware/procedure" / file, old, new)
    done = generate("--check", "--root", tree)
    assert (done.returncode, done.stderr) == (2, f"generate: {message}\n")


def test_a_constant_changed_in_its_header_alone_is_noticed(tree):
    """The canary of what is read from the headers: a sum, a product, a name of an enum."""
    for name, old, new, product in (
        ("firmware/include/tumble/core.h", "POSITIONS 36", "POSITIONS 40", "firmware/navcomp/keeper_objects.c"),
        ("firmware/include/tumble/core.h", "INT64_C(1) << 20", "INT64_C(1) << 19", "firmware/navcomp/objects.c"),
        (
            "firmware/include/tumble/core.h",
            "    ONE(AVERAGED",
            "    ONE(NEW, new) \\\n    ONE(AVERAGED",
            "docs/canopen.md",
        ),
    ):
        before = (tree / name).read_text(encoding="utf-8")
        change(tree / name, old, new)
        done = generate("--check", "--root", tree)
        assert done.returncode == 1 and f"generate: {product} is not what the tables say" in done.stderr
        (tree / name).write_text(before, encoding="utf-8")


@pytest.mark.parametrize("header, old, new, message", [
    ("procedure/procedure.h", "    uint8_t retries; ", "    uint8_t tries;\n    uint8_t retries; ",
     "tumble_procedure_config_t: tries has no row in TUMBLE_PROCEDURE_FIELDS"),
    ("include/tumble/core.h", "    uint16_t max_lost; ", "    uint16_t least_lost;\n    uint16_t max_lost; ",
     "tumble_averaging_config_t: least_lost has no row in TUMBLE_AVERAGING_FIELDS"),
    ("stand/drive402/drive402.h", "    int8_t homing_method;", "    int8_t homing_method, way;",
     "tumble_drive_profile_t: homing_method, way is not one member a line"),
    ("procedure/config_fields.h", "X(U8, retries,", "X(U16, retries,",
     "TUMBLE_PROCEDURE_FIELDS: retries is uint8_t, not U16"),
])  # fmt: skip
def test_a_member_without_its_row_is_one_line_and_exit_2(tree, header, old, new, message):
    """The canary of the tables of fields."""
    change(tree / "firmware" / header, old, new)
    done = generate("--check", "--root", tree)
    assert (done.returncode, done.stderr) == (2, f"generate: {message}\n")


MISTAKES = [
    ("drive.toml", "index = 0x6007\n", "index = 0x6040\n", "drive.toml: object 6040h is there twice"),
    ("drive.toml", "index = 0x6007\n", "index = 0x16007\n", "drive.toml: object 16007h: index is out of range"),
    ("drive.toml", 'type = "i16"', 'type = "i15"', "drive.toml: object 6007h:0: type is not one of"),
    ("drive.toml", 'access = "rw"', 'access = "rx"', "drive.toml: object 6007h:0: access is not one of"),
    ("drive.toml", "value = 1\n", "value = 4\n", "drive.toml: object 6007h:0: its value is outside its limits"),
    ("drive.toml", "high = 3\n", "", "drive.toml: object 6007h:0: needs both low and high"),
    ("drive.toml", "low = 0\n", "low = 40000\n", "drive.toml: object 6007h:0: low is above high"),
    ("drive.toml", "high = 3\n", "high = 32768\n", "drive.toml: object 6007h:0: 32768 is not INTEGER16"),
    ("drive.toml", "high = 3\n", "hihg = 3\n", "drive.toml: object 6007h: unknown key hihg"),
    ("drive.toml", 'name = "Controlword"', 'name = "Statusword"', "drive.toml: the name Statusword is there twice"),
    ("drive.toml", 'name = "Controlword"', 'name = "-"', "drive.toml: the name '-' is no identifier of C"),
    ("drive.toml", 'name = "Controlword"', 'name = "Control */ word"', "would end or begin a comment of C"),
    ("drive.toml", 'name = "Controlword"', 'name = "statusword."', "drive.toml: the names "),
    ("keeper.toml", 'home = "computed"', 'home = "computed"\nvalue = 1', "object 1010h: unknown key value"),
    ("keeper.toml", '{ name = "Save all parameters" }', '{ name = "Save", value = 1 }', "a computed value has no"),
    ("drive.toml", "map = [0x6040_00]", "map = [0x6041_00]", "drive.toml: receive PDO 1: may not map 6041h:0"),
    ("drive.toml", "map = [0x6040_00]", "map = [0x6042_00]", "drive.toml: receive PDO 1: maps 6042h:0, which does not"),
    ("drive.toml", "type = 255\n", "type = 1\n", "drive.toml: [[receive_pdo]]: type is neither 254 nor 255"),
    ("drive.toml", "id = 2\n", "id = 128\n", "drive.toml: [node]: id is not within 1 to 127"),
    ("drive.toml", "serial = 2\n", "", "drive.toml: [node]: lacks serial"),
    ("drive.toml", 'home = "value"', 'home = "heaven"', "drive.toml: object 6502h:0: home is not one of"),
    ("drive.toml", "value = 0x21\n", "", "drive.toml: object 6502h:0: home value without a value"),
    ("drive.toml", "index = 0x6007\n", 'index = "6007"\n', "drive.toml: an object: index has a value of"),
    ("drive.toml", "index = 0x6007\n", "", "drive.toml: an object: needs index and name"),
    ("drive.toml", "low = 0\n", 'low = "0"\n', "drive.toml: object 6007h: low has a value of the wrong type"),
    ("drive.toml", "consumers = [[1, 500]]", "consumers = [1]", "drive.toml: [node]: a consumer is not [node, mill"),
    ("drive.toml", "map = [0x6040_00]", 'map = ["6040"]', "drive.toml: [[receive_pdo]]: maps what is not a number"),
    ("block.toml", '{ name = "Bits", type', "{ type", "block.toml: object 2004h:1: needs a name"),
    ("drive.toml", "[[object]]", "[[object]", "drive.toml: "),
    ("common.toml", '"$device_type"', '"$divice_type"', "object 1000h:0: no setting divice_type in [node]"),
    ("block.toml", "size = 32\n", "size = 65\n", "block.toml: object 2005h:0: its size is not within 1 to 64 bytes"),
    ("block.toml", 'value = ""\n', f'value = "{33 * "x"}"\n', "block.toml: object 2005h:0: its text is too long"),
    ("block.toml", "size = 32\n", 'size = 32\nmap = "transmit"\n', "block.toml: object 2005h:0: cannot be mapped"),
    ("navcomp.toml", "map = [0x2000_00, 0x2001_00, 0x2003_01,", "map = [0x2003_07, 0x2003_07, 0x2000_00,", "8 bytes"),
    ("keeper.toml", "index = 0x2121\n", "index = 0x2050\n", "navcomp.toml: object 2050h is there twice"),
    ("keeper.toml", 'prefix = "tumble_keeper"\n', "", "keeper.toml: [extension]: lacks prefix"),
    ("keeper.toml", "[extension]", "[node]", "keeper.toml: unknown key node"),
    ("keeper.toml", "like = 0x2104", "like = 0x2990", "is like none"),
    ("keeper.toml", "map = [0x2120_02,", "map = [0x2120_01,", "transmit PDO 4: may not map 2120h:1"),
    ("keeper.toml", 'home = "computed"', 'home = "variable"', "an extension has no variables of its own"),
    ("keeper.toml", 'source = "trend"\n', "", "object 2163h:1: a computed value, and no other, has a source"),
    ("keeper.toml", 'source = "trend"\n', 'source = "trends"\n', "2163h:1: its source trends is not in [sources]"),
    ("keeper.toml", 'trend_u = "', 'nothing = "of nobody"\ntrend_u = "', "no value comes from the source nothing"),
    (
        "keeper.toml",
        'low = "TUMBLE_SETS_MIN_PAUSE_S",',
        "low = -1,",
        "keeper.toml: object 2122h:3: -1 is not UNSIGNED32",
    ),
    ("keeper.toml", "TUMBLE_SETS_MIN_PAUSE_S", "TUMBLE_SETS_MIN_PAUS_S", "no header of firmware/ has the constant TUM"),
    ("keeper.toml", "TUMBLE_MAX_POSITIONS - 1", "TUMBLE_MAX_POSITIONS -", "cannot be calculated"),
    ("navcomp.toml", '"firmware/procedure/states.h"', '"firmware/procedure/stakes.h"', "No such file"),
    ("navcomp.toml", 'TUMBLE_STATE = "firmware', 'TUMBLE_STOAT = "firmware', "no list TUMBLE_STOAT_LIST"),
]


@pytest.mark.parametrize("table, old, new, message", MISTAKES, ids=[f"{row[0]}-{row[2]!r:.40}" for row in MISTAKES])
def test_a_mistake_is_one_line_and_exit_2(tables, tree, table, old, new, message):
    before = {name: (tree / name).read_bytes() for name in PRODUCTS}
    change(tables / table, old, new)
    done = generate("--tables", tables, "--root", tree)
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1 and done.stderr.startswith("generate: "), done.stderr
    assert message in done.stderr
    assert {name: (tree / name).read_bytes() for name in PRODUCTS} == before


def test_bad_usage_is_exit_2():
    assert process("--chek").returncode == 2


def test_a_mistake_ends_the_process_so(tables):
    change(tables / "drive.toml", "index = 0x6007\n", "")
    done = process("--check", "--tables", tables)
    assert (done.returncode, done.stdout) == (2, "") and done.stderr.startswith("generate: drive.toml: ")
