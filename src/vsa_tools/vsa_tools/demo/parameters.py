# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameter file of a run: layers of parameters merged over those of paper_rig.yaml."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from ament_index_python.packages import get_package_share_directory
from vsa_common.config.configuration import build, flat, flatten, parameters, read_parameter_file
from vsa_simulator.rig.config import RigConfig, TransmissionConfig
from vsa_simulator.rig.transmission import (
    Transmission,
    damping,
    spring_deflection,
    spring_force,
    stiffness,
    transmission_from,
)
from vsa_tools.demo.start_values import perturbed

Tree = dict[str, Any]
Layer = Mapping[str, Mapping[str, Any]]  # parameters by bare node name
_PARAMETERS = "ros__parameters"


def paper_rig() -> Path:
    """The installed paper_rig.yaml."""
    return Path(get_package_share_directory("vsa_bringup"), "config", "paper_rig.yaml")


def merge(base: Mapping[str, Any], changes: Mapping[str, Any]) -> Tree:
    """`base` with the values of `changes`, section by section.

    >>> merge({"a": {"x": 1, "y": 2}}, {"a": {"y": 3}, "b": 4})
    {'a': {'x': 1, 'y': 3}, 'b': 4}
    """
    merged = dict(base)
    for name, value in changes.items():
        old = merged.get(name)
        merged[name] = merge(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return merged


def base_parameters() -> Layer:
    """The sections of paper_rig.yaml by bare node name."""
    return {key.rsplit("/", 1)[-1]: section[_PARAMETERS] for key, section in read_parameter_file(paper_rig()).items()}


def write_parameters(path: Path, *layers: Layer) -> None:
    """Write layers of parameters, later ones first in precedence, as one parameter file for nodes in any namespace.

    A node name with a leading / applies to that node only.
    """
    merged: Tree = {}
    for layer in layers:
        merged = merge(merged, layer)
    tree = {node if node.startswith("/") else f"/**/{node}": {_PARAMETERS: values} for node, values in merged.items()}
    path.write_text(yaml.dump(tree, Dumper=_Plain, sort_keys=False))


class _Plain(yaml.SafeDumper):
    """Writes no aliases: the parameter parser of ROS does not support them."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def perturbed_initial_values(rig: Mapping[str, Any], seed: int) -> dict[str, dict[str, Any]]:
    """`initial` of both estimators for the rig with parameters `rig`, perturbed at random by `seed`.

    Both rods start at rest, where the forces of the springs balance the external torque.
    """
    names = {parameter.name for parameter in parameters(RigConfig)}
    config = build(RigConfig, {name: value for name, value in flat(rig).items() if name in names})
    sides = (config.transmission_1, config.transmission_2)
    first, second = (transmission_from(side, config) for side in sides)
    force = spring_force(config.profile.centre, first)
    other = force + 2.0 * config.torque.constant / config.joint.radius
    rest = ((first, config.profile.centre, force), (second, spring_deflection(other, second), other))
    generator = np.random.default_rng(seed)
    return {
        f"estimator_{i}": {"initial": perturbed(_paper_law(side, p, x), rod_force, generator)}
        for i, (side, (p, x, rod_force)) in enumerate(zip(sides, rest, strict=True), 1)
    }


def _paper_law(config: TransmissionConfig, p: Transmission, deflection: float) -> dict[str, float]:
    """Coefficients of the paper's law with force, stiffness and damping of the rig at rest at `deflection` [m]."""
    values: dict[str, float] = flatten(config) | {"d1": damping(0.0, p)}
    if not p.exponential:
        values["force_offset"] = spring_force(deflection, p) - stiffness(deflection, p) / p.k2
    return values
