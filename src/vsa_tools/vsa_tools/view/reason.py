"""Why the live page has nothing to show, in words that say what to do."""

from collections.abc import Collection, Mapping

QUIET = ("WAITING", "SILENT")  # status words of a part from which nothing comes


def impedance_topic(part: str) -> str:
    """Where a part, joint or transmission, publishes its impedance.

    >>> impedance_topic("transmission_1")
    'transmission_1/impedance'
    """
    return "joint_impedance" if part == "joint" else f"{part}/impedance"


def why_no_data(
    space: str, domain: str, status: Mapping[str, str], ages: Mapping[str, float], published: Collection[str]
) -> list[str]:
    """One line for each quiet part of the joint at namespace `space`; empty where everything speaks.

    `status` and `ages` [s] by part ("joint", "transmission_1", ...); `published` are the topics below `space` that
    somebody publishes in ROS domain `domain`.
    """
    quiet = [part for part, word in status.items() if word in QUIET]
    if len(quiet) == len(status) and not published:
        return [
            f"nobody publishes below {space} in ROS domain {domain}: start the nodes (./vsa demo --view shows a "
            f"simulated joint), or compare ROS_DOMAIN_ID and the namespace"
        ]
    return [f"{part.replace('_', ' ')}: {_reason(space, part, ages[part], published)}" for part in quiet]


def _reason(space: str, part: str, age: float, published: Collection[str]) -> str:
    topic = impedance_topic(part)
    if topic not in published:
        return f"nobody publishes {space}/{topic}" + ("; its node has ended" if age < float("inf") else "")
    if part == "joint":
        return "its node is there and waits for both transmissions"
    missing = [leaf for leaf in ("force", "encoder") if f"{part}/{leaf}" not in published]
    if missing:
        return f"its estimator is there, but nobody publishes {space}/{part}/{missing[0]}; is the driver running?"
    since = f" for {age:.0f} s" if age < float("inf") else " yet"
    return f"its estimator and the driver are there, but no sample has come{since}; is the bus alive?"
