# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The flight recorder writes the samples around an event."""

import numpy as np
import pytest
from vsa_common.config.configuration import ConfigurationError
from vsa_common.types import Status
from vsa_estimator.estimator import Estimator
from vsa_estimator.offline.flight_recorder import FlightRecorder
from vsa_estimator.offline.recordings import read_recordings
from vsa_estimator.settings import EstimatorConfig, FlightRecorderConfig

PERIOD_NS = 10_000_000


class Flight:
    """An estimator with a recorder beside it, as in the node."""

    def __init__(self, folder, samples=300, files=20):
        self.recorder = FlightRecorder(FlightRecorderConfig(str(folder), samples, 1.0, files), "transmission_1")
        self.estimator = Estimator(EstimatorConfig())
        self.folder = folder
        self.stamp_ns = 10**18
        self.noise = np.random.default_rng(1)

    def run(self, count):
        """Add samples at rest."""
        for _ in range(count):
            self.stamp_ns += PERIOD_NS
            force, deflection = self.noise.normal((30.0, 0.01), (0.017, 1e-5))
            self.sample(force, deflection)

    def sample(self, force, deflection):
        self.recorder.add(self.stamp_ns, force, deflection)
        self.recorder.watch(self.estimator.add(self.stamp_ns, force, deflection))

    def files(self):
        self.recorder.close()
        return sorted(self.folder.glob("*.csv"))


def test_samples_before_and_after_an_event_are_written_in_order_with_exact_stamps(tmp_path):
    flight = Flight(tmp_path)
    flight.run(1000)
    assert flight.files() == []
    event_ns = flight.stamp_ns
    flight.estimator.reset()
    flight.run(150)
    (path,) = flight.files()
    stamps = [line.split(",")[0] for line in path.read_text().splitlines()[1:]]
    wanted = range(event_ns + PERIOD_NS - 199 * PERIOD_NS, event_ns + PERIOD_NS + 10**9 + 1, PERIOD_NS)
    assert [int(stamp.replace(".", "")) for stamp in stamps] == list(wanted)
    (recording,) = read_recordings(path)
    assert len(recording) == 300


def test_no_sample_is_written_twice_and_one_event_is_one_file(tmp_path):
    flight = Flight(tmp_path)
    flight.run(50)
    for _ in range(3):
        flight.estimator.reset()
        flight.run(40)
    flight.run(200)
    flight.estimator.reset()
    flight.run(10)  # shorter than the time after an event: the shutdown writes it
    first, second = (read_recordings(path)[0].stamp_ns for path in flight.files())
    assert len(first) == 151
    assert second[0] > first[-1]
    assert second[-1] == pytest.approx(flight.stamp_ns, abs=200)


def test_a_change_to_degraded_is_an_event(tmp_path):
    flight = Flight(tmp_path)
    flight.run(20)
    estimate = flight.estimator.add(flight.stamp_ns + PERIOD_NS, 30.0, 0.01)
    flight.recorder.watch(estimate._replace(status=Status.DEGRADED))
    (path,) = flight.files()
    assert path.name.endswith("_DEGRADED.csv")


def test_the_oldest_files_are_deleted_and_those_of_others_kept(tmp_path):
    other = tmp_path / "transmission_2_1_reset_GAP.csv"
    other.write_text("")
    flight = Flight(tmp_path, files=2)
    written = set()
    for _ in range(4):
        flight.estimator.reset()
        flight.run(150)
        written |= set(flight.files())
    assert len(written) == 5
    assert set(flight.files()) == {other, *sorted(written - {other})[-2:]}


def test_a_folder_that_cannot_be_created_is_rejected_and_a_missing_one_is_reported(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigurationError, match=r"flight_recorder\.folder"):
        Flight(tmp_path / "file" / "below")
    flight = Flight(tmp_path / "gone")
    flight.run(5)
    (tmp_path / "gone").rmdir()
    flight.estimator.reset()
    flight.run(5)
    flight.recorder.close()
    assert "No such file or directory" in flight.recorder.failed
