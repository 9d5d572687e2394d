"""A navigation computer and a simulated stand for the tests of scripts that use them (docs/client.md).

    plugin         fixtures of pytest
    rigs           a stand and a node that wait for a script
    virtual_bus    the bus of python-can behind them that needs no CAN and has its own time

Nothing here is loaded by the rest of the package.
"""
