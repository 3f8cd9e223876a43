# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Sections of ROS parameter files, selected by the fully qualified name of a node as rcl does."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from vsa_common.config.configuration import flat, parameter_files, read_parameter_file

PARAMETERS = "ros__parameters"
OF_LAUNCH = "launch_params_"  # begin of the name of a file that launch_ros writes for its own parameters

_TOKENS = {"**": r"(?:/[^/]+)*", "*": r"/[^/]+"}


def sections(path: str | Path) -> dict[str, Mapping[str, Any]]:
    """Parameters (a tree) by the pattern of node names that they apply to, `/**/driver`, in the order of the file.

    Raises ConfigurationError naming the file if it is not a parameter file.
    """
    return dict(_sections(read_parameter_file(path), ""))


def applies(pattern: str, node: str) -> bool:
    """Whether a section applies to a node, `/vsa/driver`.

    >>> [applies(pattern, "/vsa/driver") for pattern in ("/**", "/**/driver", "/*/driver", "/vsa/driver", "/driver")]
    [True, True, True, True, False]
    """
    tokens = pattern.strip("/").split("/")
    return bool(re.fullmatch("".join(_TOKENS.get(token, "/" + re.escape(token)) for token in tokens), node))


def parameters_of(path: str | Path, node: str) -> dict[str, Any]:
    """Values of a file for a node by name, `bus.channel`, unchecked; a later section has precedence, as in rcl."""
    values: dict[str, Any] = {}
    for pattern, tree in sections(path).items():
        if applies(pattern, node):
            values |= flat(tree)
    return values


def files_without(arguments: Sequence[str], node: str) -> list[str]:
    """Parameter files among the ROS `arguments`, if none of them has a section for `node`; else an empty list.

    Files that launch_ros writes for parameters of its own do not count.
    """
    paths = [path for path in parameter_files(arguments) if not Path(path).name.startswith(OF_LAUNCH)]
    return [] if any(applies(pattern, node) for path in paths for pattern in sections(path)) else paths


def _sections(tree: Mapping[str, Any], space: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for key, value in tree.items():
        name = f"{space}/{str(key).strip('/')}"
        if isinstance(value, Mapping) and PARAMETERS in value:
            yield name, value[PARAMETERS] or {}
        elif isinstance(value, Mapping):
            yield from _sections(value, name)
