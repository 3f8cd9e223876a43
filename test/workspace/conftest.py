# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The emulated machine of the tests of this folder, made and set up once."""

import shutil
import subprocess

import emulated_machine
import pytest


@pytest.fixture(scope="session")
def machine(tmp_path_factory):
    """The machine before `./vsa setup`."""
    if not emulated_machine.HAS_WHEELS:
        pytest.skip("ROS 2 is installed: the tests of this environment are those of a real machine")
    folder = tmp_path_factory.mktemp("machine")
    try:
        yield emulated_machine.build(folder)
    except subprocess.CalledProcessError as error:
        reason = (error.stderr or b"").decode().strip().rpartition("\n")[2]
        pytest.skip(f"numpy {emulated_machine.NUMPY} cannot be downloaded: {reason}")
    finally:
        shutil.rmtree(folder)


@pytest.fixture(scope="session")
def ready(machine):
    """The machine after `./vsa setup`."""
    result = machine.run("./vsa", "setup")
    assert result.returncode == 0, result.stdout
    return machine
