"""The EDS files as the tools of others take them: dcfchk, dcfgen, python-canopen, CANopenEditor's rules. That they say
what the firmware's dictionaries hold, with sets and without: test_canopen_interop.py, test_canopen_access.py."""

import struct

import pytest
from data_sheets import EDS, MASTER, NODES, canopen_faults, dcfchk, dcfgen, editor_faults, lely
from eds_reader import read

pytestmark = pytest.mark.python
NETWORKS = {"with sets": ("navcomp", "drive", "block"), "without sets": ("navcomp_without_sets", "drive", "block")}


@pytest.mark.toolchain
@pytest.mark.parametrize("name", NODES)
def test_dcfchk_has_nothing_to_remark(name):
    assert dcfchk(EDS[name], NODES[name]) == ""


@pytest.mark.toolchain
@pytest.mark.parametrize("network", NETWORKS)
def test_dcfgen_makes_a_master_of_them(network, tmp_path):
    """Which hears every PDO that the nodes send; and its file is good."""
    master, said = dcfgen(tmp_path, {name: (EDS[name], NODES[name]) for name in NETWORKS[network]})
    assert said == "" and dcfchk(master, MASTER) == ""
    shown = lely("dcfchk", "-p", "-n", MASTER, master).stdout.splitlines()
    heard = [line for line in shown if "mapped to TPDO" in line]
    sent = [(3, 1), (4, 1), (5, 1), (1, 2)] if network == "with sets" else [(3, 1), (5, 1), (1, 2)]
    assert heard == [f"RPDO {number} mapped to TPDO {pdo} on node {node}" for number, (pdo, node) in enumerate(sent, 1)]


@pytest.mark.parametrize("name", NODES)
def test_python_canopen_loads_them_without_a_word(name):
    assert canopen_faults(EDS[name], NODES[name]) == []


@pytest.mark.parametrize("name", NODES)
def test_they_keep_the_rules_of_canopeneditor(name):
    assert editor_faults(EDS[name]) == []


def test_reals_are_the_bits_that_cia_306_asks_for():
    text = EDS["block"].read_text()
    value = text.partition("[2004sub2]")[2].partition("DefaultValue=0x")[2].split("\n")[0]
    assert struct.unpack(">d", bytes.fromhex(value)) == (10.0,)


def test_the_two_of_the_computer_differ_by_what_its_memory_brings():
    """Every entry of the smaller one is in the larger one; what is more there are whole objects of the keeper."""
    large, small = (set(read(EDS[name])) for name in ("navcomp", "navcomp_without_sets"))
    assert small < large
    further = {entry.index for entry in large - small}
    assert {0x1010, 0x2120, 0x2170} <= further and not further & {entry.index for entry in small}


def test_the_two_of_the_computer_are_one_product_and_have_order_codes_of_their_own():
    told = [dict(line.split("=") for line in EDS[name].read_text().splitlines()
                 if line.startswith(("VendorNumber", "ProductNumber", "RevisionNumber", "OrderCode")))
            for name in ("navcomp", "navcomp_without_sets")]
    assert [one.pop("OrderCode") for one in told] == ["navcomp", "navcomp_without_sets"] and told[0] == told[1]
