"""`tumble` from a checkout: like `python -m tumble`, but the working directory is not searched for modules."""

import runpy

runpy.run_module("tumble", run_name="__main__", alter_sys=True)
