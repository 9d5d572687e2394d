"""A board that lives in a folder of its own, outside the repository: -DTUMBLE_BOARD_DIR builds it."""

import shutil
import subprocess

import pytest
from conftest import ROOT

pytestmark = pytest.mark.toolchain

LISTS = """
add_executable(mine main.c)
target_link_libraries(mine PRIVATE tumble_navcomp)
"""
# Nobody else is on its bus: what it sends first is its own boot-up message, 701h.
MAIN = """
#include "navcomp/standard.h"
#include "tumble/navcomp.h"

#include <stdio.h>

static tumble_status_t send(void *context, const tumble_can_frame_t *frame)
{
    (void)context;
    printf("%03X\\n", frame->id);
    return TUMBLE_OK;
}

static tumble_status_t receive(void *context, tumble_can_frame_t *frame)
{
    (void)context;
    (void)frame;
    return TUMBLE_E_PORT_EMPTY;
}

static uint64_t now_us(void *context)
{
    return ++*(uint64_t *)context;
}

int main(void)
{
    static uint64_t time_us;
    static tumble_drive402_t drive;
    static tumble_navcomp_t navcomp;
    static tumble_navcomp_config_t config;
    static const tumble_port_t port = {.context = &time_us, .now_us = now_us, .can_send = send, .can_receive = receive};
    config = tumble_standard_navcomp;
    config.port = &port;
    config.stand_memory = &drive;
    config.stand_bytes = sizeof drive;
    if (tumble_navcomp_init(&navcomp, &config) != TUMBLE_OK) {
        return 1;
    }
    tumble_navcomp_step(&navcomp);
    return 0;
}
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cmake") is None, reason="CMake is not installed")
def test_it_is_built_and_runs(tmp_path):
    board, build = tmp_path / "a board", tmp_path / "build"
    board.mkdir()
    (board / "CMakeLists.txt").write_text(LISTS)
    (board / "main.c").write_text(MAIN)
    subprocess.run(["cmake", "-S", ROOT, "-B", build, f"-DTUMBLE_BOARD_DIR={board}"], check=True, capture_output=True)
    subprocess.run(["cmake", "--build", build, "--target", "mine", "-j2"], check=True, capture_output=True)
    said = subprocess.run([build / "board/mine"], check=True, capture_output=True, text=True).stdout
    assert said.splitlines()[0] == "701"
    assert not (build / "host").exists()
