# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Sections of ROS parameter files, selected by the fully qualified name of a node as rcl does."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from vsa_common.config.configuration import ConfigurationError, flat, parameter_files, read_parameter_file

PARAMETERS = "ros__parameters"
OF_LAUNCH = "launch_params_"  # begin of the name of a file that launch_ros writes for its own parameters

_TOKENS = {"**": r"(?:/[^/]+)*", "*": r"/[^/]+"}


class _NoSection(ValueError):
    """A value that is neither a section nor a namespace."""


def sections(path: str | Path) -> dict[str, Mapping[str, Any]]:
    """Parameters (a tree) by the pattern of node names that they apply to, `/**/driver`, in the order of the file.

    Raises ConfigurationError naming the file if it is not a parameter file.
    """
    try:
        return dict(_sections(read_parameter_file(path), ""))
    except _NoSection as error:
        raise ConfigurationError(f"{path}: {error} has no ros__parameters") from error


def applies(pattern: str, node: str) -> bool:
    """Whether a section applies to a node, `/vsa/driver`.

    >>> [applies(pattern, "/vsa/driver") for pattern in ("/**", "/**/driver", "/*/driver", "/vsa/driver", "/driver")]
    [True, True, True, True, False]
    """
    tokens = pattern.strip("/").split("/")
    return bool(re.fullmatch("".join(_TOKENS.get(token, "/" + re.escape(token)) for token in tokens), node))


def sections_of(path: str | Path, node: str) -> dict[str, dict[str, Any]]:
    """Flat values of the sections for a node by their patterns; `node` is /vsa/driver, or driver in any namespace.

    Raises ConfigurationError for a name without namespace that the file has in several ones.
    """
    every = {pattern: flat(tree) for pattern, tree in sections(path).items()}
    if "/" not in node:
        spaces = {space for space, _, name in (p.rpartition("/") for p in every) if name == node and "*" not in space}
        if len(spaces) > 1:
            shown = " and ".join(sorted(space or "/" for space in spaces))
            raise ConfigurationError(f"{path}: {node} is in the namespaces {shown}; one is expected")
        if not spaces:
            return {p: section for p, section in every.items() if _is_wildcard(p) or p.rpartition("/")[2] == node}
        node = f"{spaces.pop()}/{node}"
    return {pattern: section for pattern, section in every.items() if applies(pattern, node)}


def parameters_of(path: str | Path, node: str) -> dict[str, Any]:
    """Values of a file for a node by name, `bus.channel`, unchecked; a later section has precedence, as in rcl."""
    return {name: value for section in sections_of(path, node).values() for name, value in section.items()}


def shared_names(found: Mapping[str, Mapping[str, Any]]) -> set[str]:
    """Parameters that sections, by their patterns, give for nodes of any name (`/**`) and for none in particular."""
    own = {name for pattern, section in found.items() if not _is_wildcard(pattern) for name in section}
    return {name for pattern, section in found.items() if _is_wildcard(pattern) for name in section} - own


def files_without(arguments: Sequence[str], node: str) -> list[str]:
    """Parameter files among the ROS `arguments`, if none of them has a section for `node`; else an empty list.

    Files that launch_ros writes for parameters of its own do not count.
    """
    paths = [path for path in parameter_files(arguments) if not Path(path).name.startswith(OF_LAUNCH)]
    return [] if any(applies(pattern, node) for path in paths for pattern in sections(path)) else paths


def _is_wildcard(pattern: str) -> bool:
    return pattern.rpartition("/")[2] in ("*", "**")


def _sections(tree: Mapping[str, Any], space: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Pattern and parameters of each section. Raises _NoSection with the name of another value, as rcl does."""
    for key, value in tree.items():
        name = f"{space}/{str(key).strip('/')}"
        if not isinstance(value, Mapping):
            raise _NoSection(name)
        if PARAMETERS not in value:
            yield from _sections(value, name)
        elif isinstance(value[PARAMETERS] or {}, Mapping):
            yield name, value[PARAMETERS] or {}
        else:
            raise _NoSection(name)
