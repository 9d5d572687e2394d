"""The ways in: programs of somebody else's (tests/consumers) build with Tumble as a dependency, and run."""

import json
import os
import re
import shutil
import subprocess
import sys

import pytest
from c_compiler import firmware_sources
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools"))
from footprint import image

VERSION = (ROOT / "VERSION").read_text().strip()
CONSUMERS = ROOT / "tests/consumers"
SAID = f"{VERSION} TUMBLE_OK\n"
SAID_BY_COMPUTER = f"{VERSION} TUMBLE_E_ARGUMENT\n"
TOOLCHAINS = {"its own": CONSUMERS / "bare_metal/toolchain.cmake", "ours": ROOT / "boards/mps2_an386/toolchain.cmake"}
QEMU = """qemu-system-arm -M mps2-an386 -display none -monitor none -serial none
          -semihosting-config enable=on,target=native -kernel""".split()
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}


def needs(*programs):
    missing = [program for program in programs if shutil.which(program) is None]
    return pytest.mark.skipif(bool(missing), reason=f"not installed: {', '.join(missing)}")


pytestmark = [pytest.mark.slow, pytest.mark.toolchain, needs("cmake", "cc", "ninja")]


def run(*command, code=0):
    """What a command says, both outputs, if it exits as it should."""
    done = subprocess.run([*map(str, command)], env=ENVIRONMENT, capture_output=True, text=True, timeout=300)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def configured(source, build, *options, code=0):
    return run("cmake", "-G", "Ninja", "-S", source, "-B", build, *options, code=code)


def built(source, build, *options, targets=("consumer",)):
    """What the compiler said."""
    configured(source, build, *options)
    return run("cmake", "--build", build, "--target", *targets)


def test_what_is_installed_is_found(tmp_path):
    """By CMake, in both spellings, and by pkg-config, wherever the prefix is moved to; another version is refused.
    Programs come along, and nothing of the wheel."""
    if not (ROOT / "build/host/build.ninja").exists():
        pytest.skip("build/host is not configured")
    run("cmake", "--install", ROOT / "build/host", "--prefix", tmp_path / "first")
    prefix = (tmp_path / "first").rename(tmp_path / "prefix")
    assert sorted(path.name for path in prefix.iterdir()) == ["bin", "include", "lib", "share"]
    assert run(prefix / "bin/tumble-stand", "--version") == f"tumble-stand {VERSION}\n"
    assert not list(prefix.rglob("*.so"))
    check_find_package(prefix, tmp_path)
    if shutil.which("pkg-config"):
        check_pkg_config(prefix, tmp_path / "plain")


def check_find_package(prefix, tmp_path):
    there = f"-DCMAKE_PREFIX_PATH={prefix}"
    consumer, build = CONSUMERS / "find_package", tmp_path / "build"
    built(consumer, build, there, targets=("consumer", "computer"))
    assert (run(build / "consumer"), run(build / "computer")) == (SAID, SAID_BY_COMPUTER)

    lower = tmp_path / "lower/CMakeLists.txt"
    lower.parent.mkdir()
    text = (consumer / "CMakeLists.txt").read_text()
    lower.write_text(text.replace("(Tumble ", "(tumble ").replace("..", str(CONSUMERS)))
    configured(lower.parent, tmp_path / "lower/build", there)
    for version in ("99.0", "0.1"):
        said = configured(consumer, tmp_path / version, there, f"-DWANTED={version}", code=1)
        assert f'compatible with requested version "{version}"' in re.sub(r"\s+", " ", said)


def check_pkg_config(prefix, program):
    """`tumble-core` brings neither the computer nor the headers of the rooms."""
    asked = ["env", f"PKG_CONFIG_PATH={prefix}/lib/pkgconfig", "pkg-config"]
    for package, source, said in (("tumble", "consumer.c", SAID), ("tumble", "computer.c", SAID_BY_COMPUTER),
                                  ("tumble-core", "consumer.c", SAID)):
        assert run(*asked, "--modversion", package).strip() == VERSION
        run(*asked, "--exists", f"{package} >= 99", code=1)
        flags = run(*asked, "--cflags", "--libs", package).split()
        assert ("-ltumble_navcomp" in flags, any("rooms" in flag for flag in flags)) == 2 * (package == "tumble",)
        run("cc", CONSUMERS / source, *flags, "-o", program)
        assert run(program) == said


def test_fetched(tmp_path):
    """Libraries alone: no target of a program or a test comes along."""
    built(CONSUMERS / "fetch_content", tmp_path)
    assert run(tmp_path / "consumer") == SAID
    targets = run("cmake", "--build", tmp_path, "--target", "help")
    assert "tumble_core:" in targets and "tumble-stand" not in targets and "conformance" not in targets


def test_firmware_alone_in_a_folder(tmp_path):
    """Without the rest of the repository. The consumer's warning stays a warning: none of ours applies to it."""
    shutil.copytree(ROOT / "firmware", tmp_path / "vendor")
    configured(tmp_path / "vendor", tmp_path / "top")
    assert (tmp_path / "top/tumble-core.pc").exists()  # by itself it installs, too
    said = built(CONSUMERS / "add_subdirectory", tmp_path / "build", f"-DTUMBLE_FIRMWARE={tmp_path / 'vendor'}",
                 "-DCMAKE_C_FLAGS=-Wall")
    assert "unused variable" in said
    assert run(tmp_path / "build/consumer") == SAID
    ours = re.search(r"-Wall .*-Werror", (ROOT / "cmake/flags.cmake").read_text())[0].split()
    assert "unused variable" in run("cc", *ours, f"-I{ROOT}/firmware/include", "-c", CONSUMERS / "consumer.c", "-o",
                                    tmp_path / "refused.o", code=1)


@pytest.mark.parametrize("beside", [False, True])
def test_the_licence_comes_along(beside, tmp_path):
    """Of a copy with it, within or beside; not that of somebody else, which stands beside a copy without."""
    vendor = shutil.copytree(ROOT / "firmware", tmp_path / "vendor/firmware")
    for name in ("LICENSE", "NOTICE"):
        shutil.copy(ROOT / name, vendor.parent if beside else vendor)
    if not beside:
        (vendor.parent / "LICENSE").write_text("mine\n")
        (vendor.parent / "NOTICE").write_text("mine\n")
    assert installed_licence(vendor, tmp_path / "with") == (ROOT / "LICENSE").read_bytes()
    if not beside:
        (vendor / "LICENSE").unlink()
        assert installed_licence(vendor, tmp_path / "without") is None


def installed_licence(source, build):
    configured(source, build)
    run("cmake", "--build", build)
    run("cmake", "--install", build, "--prefix", build / "prefix")
    path = build / "prefix/share/doc/tumble/LICENSE"
    assert path.exists() == path.with_name("NOTICE").exists()
    return path.read_bytes() if path.exists() else None


def test_a_library_that_exports_its_own_targets(tmp_path):
    """Its user finds both packages; without Tumble installed along with it CMake refuses the export."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/mine.c").write_text("#include <tumble/core.h>\nconst char *mine(void);\n"
                                          "const char *mine(void) { return tumble_status_name(TUMBLE_OK); }\n")
    (tmp_path / "mine/CMakeLists.txt").write_text(f"""
cmake_minimum_required(VERSION 3.22)
project(mine LANGUAGES C)
add_subdirectory({ROOT}/firmware tumble)
add_library(mine mine.c)
target_link_libraries(mine PUBLIC tumble::core)
install(TARGETS mine EXPORT mine)
install(EXPORT mine FILE mine-targets.cmake NAMESPACE mine:: DESTINATION lib/cmake/mine)
""")
    assert "tumble_core" in configured(tmp_path / "mine", tmp_path / "refused", code=1)
    built(tmp_path / "mine", tmp_path / "build", "-DTUMBLE_INSTALL=ON", targets=("all",))
    run("cmake", "--install", tmp_path / "build", "--prefix", tmp_path / "prefix")
    assert "tumble::core" in (tmp_path / "prefix/lib/cmake/mine/mine-targets.cmake").read_text()
    assert (tmp_path / "prefix/lib/cmake/tumble/tumble-config.cmake").exists()


@needs("arm-none-eabi-gcc", "arm-none-eabi-readelf", "qemu-system-arm")
def test_a_cortex_m4f_with_a_start_of_its_own(tmp_path):
    """Hard floats, and the same digits. Where CPACR is forgotten the first instruction of the unit is a fault."""
    project, forgetful = CONSUMERS / "cortex_m4f", tmp_path / "forgetful"
    toolchain = f"-DCMAKE_TOOLCHAIN_FILE={project / 'toolchain.cmake'}"
    built(project, tmp_path / "build", toolchain, "-DCMAKE_BUILD_TYPE=MinSizeRel")
    image, page = tmp_path / "build/consumer", (ROOT / "docs/embedding.md").read_text(encoding="utf-8")
    assert "Tag_ABI_VFP_args: VFP registers" in run("arm-none-eabi-readelf", "-A", image)
    assert run(*QEMU, image) == re.search(r"```text\n(K .*?)```", page, re.DOTALL)[1]

    forgetful.mkdir()
    for file in project.iterdir():
        text = file.read_text().replace("../../..", str(ROOT)).replace("(0xF << 20)", "0")
        (forgetful / file.name).write_text(text)
    built(forgetful, tmp_path / "without", toolchain, "-DCMAKE_BUILD_TYPE=MinSizeRel")
    lost = subprocess.run([*QEMU, tmp_path / "without/consumer"], env=ENVIRONMENT, capture_output=True, timeout=60)
    assert lost.returncode != 0 and b"Lockup" in lost.stderr


@needs("arm-none-eabi-gcc")
@pytest.mark.parametrize("toolchain", TOOLCHAINS)
def test_bare_metal(toolchain, tmp_path):
    """The page's program on a Cortex-M says what it says here; what it does not call is not in it."""
    built(CONSUMERS / "bare_metal", tmp_path, f"-DCMAKE_TOOLCHAIN_FILE={TOOLCHAINS[toolchain]}")
    symbols = run("arm-none-eabi-nm", tmp_path / "consumer")
    assert "tumble_estimate_refined" in symbols and "tumble_store_commit" in symbols
    assert not re.search("optimal|misfit|_seen|checkpoint|tumble_estimate_least", symbols)
    page = (ROOT / "docs/embedding.md").read_text(encoding="utf-8")
    if toolchain == "its own":
        told_kb = float(re.search(r"takes about ([0-9.]+) kB of Tumble's code", page)[1])
        assert told_kb == pytest.approx(code_bytes(tmp_path / "consumer.map") / 1000, rel=0.1)  # compilers differ
    if shutil.which("qemu-system-arm"):
        assert run(*QEMU, tmp_path / "consumer") == re.search(r"```text\n(K .*?)```", page, re.DOTALL)[1]


def code_bytes(linker_map):
    """What of an image is Tumble's, read-only or initialised."""
    text = re.sub(r"^( \S+)\n\s+(0x)", r"\1 \2", linker_map.read_text(), flags=re.MULTILINE)
    return sum(int(size, 16) for name, address, size, origin in image.SECTION.findall(text)
               if "libtumble_" in origin and name.startswith((".text", ".rodata", ".data")) and int(address, 16))


def test_a_board_outside_the_repository(tmp_path):
    """It runs a computer, whose first message is its boot-up; its port passes the suite, a bad one fails."""
    board, build = tmp_path / "a board", tmp_path / "build"
    shutil.copytree(CONSUMERS / "board", board)
    built(ROOT, build, f"-DTUMBLE_BOARD_DIR={board}", targets=("mine", "conforms", "loses"))
    assert run(build / "board/mine").splitlines()[0] == "701"
    verdicts = run(build / "board/conforms")
    assert (verdicts.count("passed "), verdicts.count("skipped "), verdicts.count("FAILED")) == (20, 2, 0)
    assert "FAILED   all 2048 identifiers: a frame does not arrive" in run(build / "board/loses", code=1)
    assert not (build / "host").exists()


def test_a_memory_alone(tmp_path):
    """The page's command: the memory that the example has passes, and fails where it takes a granule twice."""
    page = (ROOT / "docs/porting.md").read_text(encoding="utf-8").partition("### Your memory alone")[2]
    shown, command = re.search(r"```c\n(.*?)```.*?\$ (cc .*?) -o memory", page, re.DOTALL).groups()
    assert shown in (CONSUMERS / "memory.c").read_text(encoding="utf-8")
    good, check = "examples/embed_board.c", "if (flash[offset + i] != 0xFFU)"
    spoilt = tmp_path / "spoilt.c"
    spoilt.write_text((ROOT / good).read_text(encoding="utf-8").replace(check, "if (0)"), encoding="utf-8")
    for source, code in ((good, 0), (spoilt, 1)):
        run("sh", "-e", "-c", f"cd '{ROOT}'\n{command.replace(good, str(source))} -o '{tmp_path}/memory'")
        said = run(tmp_path / "memory", code=code)
        assert ("FAILED  nv: a granule is programmed once" in said) == (code == 1) and said.count("passed") == 8 - code


def test_without_a_build_system(tmp_path):
    """The page's commands, with the options that the libraries are compiled with."""
    page = (ROOT / "docs/embedding.md").read_text(encoding="utf-8")
    commands = re.search(r"```console\n(\$ options=.*?)```", page, re.DOTALL)[1].replace("$ ", "")
    cmake = (ROOT / "firmware/CMakeLists.txt").read_text()
    private = re.search(r"target_compile_options\(.*?PRIVATE(.*?)\)", cmake, re.DOTALL)[1]
    assert set(re.findall(r"-f[\w=-]+", re.sub("#.*", "", private))) <= set(commands.replace('"', " ").split())
    for folder in ("firmware", "tests"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    commands = commands.replace("find firmware", "find firmware/")  # here it is a link
    run("sh", "-e", "-c", f"cd '{tmp_path}'\n{commands}")
    assert (run(tmp_path / "consumer"), run(tmp_path / "computer")) == (SAID, SAID_BY_COMPUTER)


def sources_of(build):
    """What of the firmware a build compiles."""
    commands = json.loads((build / "compile_commands.json").read_text())
    files = (os.path.relpath(os.path.realpath(command["file"]), ROOT) for command in commands)
    return sorted(file for file in files if file.startswith("firmware/"))


def test_the_zephyr_module_as_far_as_that_goes_without_zephyr(tmp_path):
    """The files that it names are there, its options are those of its Kconfig, and it compiles all of the firmware."""
    module = (ROOT / "zephyr/module.yml").read_text()
    kconfig = re.search(r"kconfig: (\S+)", module)[1]
    assert (ROOT / re.search(r"cmake: (\S+)", module)[1] / "CMakeLists.txt").exists()
    options = set(re.findall(r"^config (\w+)$", (ROOT / kconfig).read_text(), re.MULTILINE))
    assert set(re.findall(r"CONFIG_(\w+)", (ROOT / "zephyr/CMakeLists.txt").read_text())) == options

    played, listed = CONSUMERS / "zephyr", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"
    configured(played, tmp_path / "off", listed)
    assert not (tmp_path / "off/compile_commands.json").exists() or sources_of(tmp_path / "off") == []
    configured(played, tmp_path / "core", listed, "-DCONFIG_TUMBLE=y")
    rooms = ("firmware/core/", "firmware/sets/")
    assert sources_of(tmp_path / "core") == [file for file in firmware_sources() if file.startswith(rooms)]
    both = ("-DCONFIG_TUMBLE=y", "-DCONFIG_TUMBLE_NAVCOMP=y")
    built(played, tmp_path / "all", listed, *both, targets=("consumer", "computer"))
    assert sources_of(tmp_path / "all") == firmware_sources()
    assert run(tmp_path / "all/computer") == SAID_BY_COMPUTER and run(tmp_path / "all/consumer").startswith("K  +")


def test_every_unit_test_has_the_label_of_a_room():
    build = ROOT / "build/sanitizers"
    if not (build / "tests/unit").exists():
        pytest.skip("build/sanitizers has no unit tests")
    tests = json.loads(run("ctest", "--test-dir", build, "--show-only=json-v1"))["tests"]
    labels = {test["name"]: [p["value"] for p in test["properties"] if p["name"] == "LABELS"] for test in tests}
    assert labels["test_store"] == [["sets"]] and labels["test_linux"] == [["board"]]
    rooms = {path.name for path in (ROOT / "firmware").iterdir()} | {"host", "board"}
    assert all(len(found) == 1 and set(found[0]) <= rooms for found in labels.values())
