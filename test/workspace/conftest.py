# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The emulated machine of the tests of this folder, made and set up once.

`./vsa test` runs pytest twice. Both runs use the machine in the folder $VSA_TEST_MACHINE, which `./vsa test` removes.
"""

import os
import shutil
import subprocess
from pathlib import Path

import emulated_machine
import pytest


@pytest.fixture(scope="session")
def machine(tmp_path_factory):
    """The machine before `./vsa setup`."""
    if not emulated_machine.HAS_WHEELS:
        pytest.skip("ROS 2 is installed: the tests of this environment are those of a real machine")
    shared = os.environ.get("VSA_TEST_MACHINE")
    folder = Path(shared or tmp_path_factory.mktemp("shared")) / "machine"
    complete = folder / "complete"
    try:
        if not complete.exists():
            shutil.rmtree(folder, ignore_errors=True)  # of an attempt that failed
            folder.mkdir()
            emulated_machine.build(folder)
            complete.touch()
        yield emulated_machine.machine_in(folder)
    except subprocess.CalledProcessError as error:
        reason = (error.stderr or b"").decode().strip().rpartition("\n")[2]
        pytest.skip(f"numpy {emulated_machine.NUMPY} cannot be downloaded: {reason}")
    finally:
        if not shared:
            shutil.rmtree(folder)


@pytest.fixture(scope="session")
def ready(machine):
    """The machine after `./vsa setup`."""
    result = machine.run("./vsa", "setup")
    assert result.returncode == 0, result.stdout
    return machine
