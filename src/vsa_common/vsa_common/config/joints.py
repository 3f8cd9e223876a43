# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Joints of a process: the namespaces in its parameter files, one for each joint."""

from collections.abc import Sequence

from vsa_common.config.configuration import parameter_files
from vsa_common.config.sections import sections

DEFAULT = "vsa"


def joints(arguments: Sequence[str], node: str = "driver") -> list[str]:
    """Namespaces in which a parameter file of the ROS `arguments` names `node`, in the order of the files.

    `/left/driver` and `/right/driver` are two joints; common values belong under `/**/driver`. A file without
    namespaces describes one joint, `vsa`. `-r __ns:=/left` selects one of several.
    Raises ConfigurationError for a file that cannot be read.
    """
    if any("__ns:=" in argument for argument in arguments):
        return [DEFAULT]  # ROS replaces the namespace
    found: dict[str, None] = {}
    for path in parameter_files(arguments):
        for pattern in sections(path):
            namespace, _, name = pattern.strip("/").rpartition("/")
            if name == node and namespace and "*" not in namespace:
                found[namespace] = None
    return list(found) or [DEFAULT]
