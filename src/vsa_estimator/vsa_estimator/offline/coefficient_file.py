# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameter files with the coefficients of transmissions and their covariance, for the next start of an estimator."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from vsa_common.config.configuration import ConfigurationError, node_values, parameters, read_parameter_file
from vsa_common.types import Array
from vsa_estimator.output.estimate import State
from vsa_estimator.settings import NodeConfig, Posterior

HEADER = "# Coefficients with covariance, start values of the estimator: --params-file, or ~/load_coefficients.\n"
UNITS = {
    "ln_stiffness_reference": "1", "k2": "1/m", "d1": "N s/m", "d2": "N s^3/m^3", "inertia": "kg",
    "force_offset": "N", "coulomb_friction": "N",
}  # fmt: skip
EXPONENTIAL_KNOTS = 2  # of the exponential law in EstimatorState; another law has more
_PREFIX = "initial.posterior."


@dataclass(frozen=True)
class NamedCoefficients:
    """Coefficients of one transmission, SI, with covariance; ln_stiffness_reference is that at deflection_reference."""

    names: tuple[str, ...]
    values: tuple[float, ...]
    covariance: Array  # (n, n)
    deflection_reference: float  # [m]

    def std(self, name: str) -> float:
        """Standard deviation of one coefficient."""
        index = self.names.index(name)
        return float(np.sqrt(self.covariance[index, index]))


def coefficients_of_state(state: State | Any) -> NamedCoefficients:
    """Coefficients of the estimator's state, or of an EstimatorState message.

    Raises ConfigurationError where another law than the exponential one is published, which has none.
    """
    if len(state.elastic_deflection) > EXPONENTIAL_KNOTS:
        raise ConfigurationError(f"the law is not exponential ({state.elastic_law}) and has no coefficients")
    names = tuple(UNITS)
    covariance = np.reshape(state.coefficient_covariance, (len(names), len(names)))
    values = tuple(float(getattr(state, name)) for name in names)
    return NamedCoefficients(names, values, covariance, float(state.deflection_reference))


def posterior_parameters(coefficients: NamedCoefficients) -> dict[str, Any]:
    """The estimator's parameters initial.posterior.*, without that prefix."""
    return {
        "names": list(coefficients.names),
        "values": [float(value) for value in coefficients.values],
        "covariance": [float(value) for value in np.ravel(coefficients.covariance)],
        "deflection_reference": float(coefficients.deflection_reference),
    }


def update_file(path: Path, node: str, coefficients: NamedCoefficients, remark: str) -> None:
    """Write or replace the section of `node` ("/vsa/estimator_1") in a file of coefficients; other sections stay.

    Raises ConfigurationError for a file of another kind, OSError where it cannot be written.
    """
    sections: dict[str, Any] = {}
    if path.exists():
        if not path.read_text().startswith(HEADER):
            raise ConfigurationError(f"{path} exists and has no coefficients; it is not replaced")
        sections = read_parameter_file(path)
    sections[node] = {"ros__parameters": {"initial": {"posterior": posterior_parameters(coefficients)}}}
    write_file(path, sections, [*_lines(path, node), *described(node, coefficients, remark)])


def write_file(path: Path, sections: Mapping[str, Any], remarks: Sequence[str]) -> None:
    """Write a file of coefficients with one comment line for each remark; a reader sees the old file or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f"{path.name}.part")
    comments = "".join(f"# {line}\n" for line in remarks)
    partial.write_text(HEADER + comments + yaml.safe_dump(dict(sections), sort_keys=False, default_flow_style=None))
    partial.replace(path)


def described(node: str, coefficients: NamedCoefficients, remark: str) -> list[str]:
    """Lines for a reader: remark, and each coefficient with standard deviation and unit."""
    lines = [f"{node}: {remark}"]
    for name, value in zip(coefficients.names, coefficients.values, strict=True):
        lines.append(f"{node}: {name} = {value:.6g} +- {coefficients.std(name):.2g} {UNITS.get(name, '')}".rstrip())
    return lines


def read_posterior(path: Path, node: str) -> Posterior:
    """Coefficients of `node` (its bare name) from a parameter file; other parameters of the file are not read.

    Raises ConfigurationError where the file has none.
    """
    declared = {parameter.name: parameter for parameter in parameters(NodeConfig)}
    values = node_values(path, node, NodeConfig)
    own = {name: declared[name].check(value) for name, value in values.items() if name in declared}
    found = {name.removeprefix(_PREFIX): value for name, value in own.items() if name.startswith(_PREFIX)}
    posterior = Posterior(**found)
    if not posterior:
        raise ConfigurationError(f"{path}: no initial.posterior for {node}")
    return posterior


def _lines(path: Path, node: str) -> list[str]:
    """Comment lines of a file on other nodes than `node`."""
    if not path.exists():
        return []
    lines = [line[2:] for line in path.read_text().removeprefix(HEADER).splitlines() if line.startswith("# ")]
    return [line for line in lines if not line.startswith(f"{node}: ")]
