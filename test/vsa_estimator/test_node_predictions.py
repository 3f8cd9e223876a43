# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Samples that arrive after a published prediction: stamps increase, and each estimate is counted."""

import os
import time

import pytest
import rclpy
from vsa_common.types import Status
from vsa_estimator.node import EstimatorNode

pytestmark = pytest.mark.live

DOMAIN = 20 + (os.getpid() + 70) % 80
MS = 1_000_000


@pytest.fixture
def node(monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    rclpy.init(domain_id=DOMAIN)
    node = EstimatorNode(transmission="transmission_1")
    node.autostart()
    yield node
    node.close()
    node.destroy_node()
    rclpy.try_shutdown()


def test_an_estimate_overtaken_by_a_prediction_is_counted_and_not_published(node, monkeypatch):
    published = []
    monkeypatch.setattr(node, "on_estimate", published.append)
    begin = time.time_ns() - 1000 * MS
    for k in range(100):
        node.process(begin + k * MS, 30.0, 0.01)
    last = begin + 99 * MS
    node.predict_silence(80 * MS)
    for late in (20, 60, 100):
        node.process(last + late * MS, 30.0, 0.01)
    stamps = [estimate.stamp_ns for estimate in published]
    assert stamps == sorted(set(stamps))
    assert stamps[-1] == last + 100 * MS
    assert [estimate.stamp_ns for estimate in published if estimate.status is Status.STALE] == [
        last + ahead * MS for ahead in (50, 60, 70, 80)
    ]
    [(_, _, values)] = node.health().values()
    assert values["samples_fused"] == 103
    assert values["estimates_overtaken"] == 2
