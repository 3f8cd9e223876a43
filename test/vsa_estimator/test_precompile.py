# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Everything is compiled before the first sample: in a process of its own, where nothing is compiled yet."""

import subprocess
import sys
from pathlib import Path

import pytest
from vsa_common.accel import ACCELERATED

LIVE = """
import sys

from transmission_data import MULTISINE, TRANSMISSION_1, record, wrong_start
from vsa_estimator.estimator import Estimator


def compiled():
    mine = [vars(module) for name, module in list(sys.modules.items()) if name.startswith("vsa_estimator.")]
    return {name: len(one.signatures) for names in mine for name, one in names.items() if hasattr(one, "py_func")}


estimator = Estimator(wrong_start(TRANSMISSION_1))
before = compiled()
recording = record(TRANSMISSION_1, MULTISINE, 40.0, rate=500)
samples = zip(recording.stamp_ns.tolist(), recording.force.tolist(), recording.deflection.tolist())
for count, (stamp_ns, force, deflection) in enumerate(samples):
    estimator.add(stamp_ns, force + (2.0 if count > 15000 else 0.0), deflection - (3e-3 if count > 10000 else 0.0))
    if count % 500 == 0:
        estimator.predict_to(stamp_ns + 10**7)
        estimator.state()
assert len(before) > 20
print(*(name for name, kinds in compiled().items() if kinds != before[name]), estimator.state().reset_count)
"""


@pytest.mark.skipif(not ACCELERATED, reason="nothing is compiled without numba")
def test_no_sample_waits_for_the_compiler_even_when_a_sensor_fails():
    command = [sys.executable, "-c", LIVE]
    here = Path(__file__).parent
    run = subprocess.run(command, cwd=here, capture_output=True, text=True, timeout=200, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    assert run.stdout.split() == ["2"]
