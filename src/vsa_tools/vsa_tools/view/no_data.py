# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Reasons for missing data on the live page, with the next step to take."""

from collections.abc import Collection, Mapping

NO_DATA = ("WAITING", "SILENT")  # status labels of a source without messages


def impedance_topic(source: str) -> str:
    """Topic of the impedance of a source, joint or transmission.

    >>> impedance_topic("transmission_1")
    'transmission_1/impedance'
    """
    return "joint_impedance" if source == "joint" else f"{source}/impedance"


def no_data_reasons(
    namespace: str, domain: str, status: Mapping[str, str], ages: Mapping[str, float], published: Collection[str]
) -> list[str]:
    """One line for each source without data of the joint at `namespace`; empty where all sources have data.

    `status` and `ages` [s] by source ("joint", "transmission_1", ...); `published` are the topics below `namespace`
    that have a publisher in ROS domain `domain`.
    """
    sources = [source for source, label in status.items() if label in NO_DATA]
    if len(sources) == len(status) and not published:
        return [
            f"no publisher below {namespace} in ROS domain {domain}: start the nodes (./vsa demo --view shows a "
            f"simulated joint), or compare ROS_DOMAIN_ID and the namespace"
        ]
    return [f"{one.replace('_', ' ')}: {_reason(namespace, one, ages[one], published)}" for one in sources]


def _reason(namespace: str, source: str, age: float, published: Collection[str]) -> str:
    topic = impedance_topic(source)
    if topic not in published:
        return f"no publisher of {namespace}/{topic}" + ("; its node has ended" if age < float("inf") else "")
    if source == "joint":
        return "its node is active and waits for both transmissions"
    missing = [leaf for leaf in ("force", "encoder") if f"{source}/{leaf}" not in published]
    if missing:
        return f"its estimator is active, but no publisher of {namespace}/{source}/{missing[0]}; is the driver running?"
    since = f" for {age:.0f} s" if age < float("inf") else " yet"
    return f"its estimator and the driver are active, but no sample has arrived{since}; is the bus connected?"
