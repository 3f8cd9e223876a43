# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Services of the estimator: reset, and coefficients to and from a parameter file."""

from collections.abc import Callable
from datetime import datetime, timezone
from pathlib import Path

from rclpy.parameter import Parameter
from rclpy.service import Service
from std_srvs.srv import Trigger
from vsa_common.config.configuration import ConfigurationError, flatten
from vsa_common.ros.node import SuiteNode
from vsa_common.types import Status
from vsa_estimator.offline.coefficient_file import coefficients_of_state, read_posterior, update_file
from vsa_estimator.output.estimate import State
from vsa_estimator.settings import NodeConfig
from vsa_msgs.srv import LoadCoefficients, SaveCoefficients


class EstimatorServices:
    """`~/reset`, `~/save_coefficients` and `~/load_coefficients` of an estimator node."""

    def __init__(self, node: SuiteNode[NodeConfig], state: Callable[[], State], reset: Callable[[], None]) -> None:
        """`state` is that of the estimator; `reset` starts it again from the node's parameters."""
        self._node, self._state, self._reset = node, state, reset
        self._services: list[Service] = [
            node.create_service(Trigger, "~/reset", self._on_reset),
            node.create_service(SaveCoefficients, "~/save_coefficients", self._on_save),
            node.create_service(LoadCoefficients, "~/load_coefficients", self._on_load),
        ]

    def close(self) -> None:
        """Destroy the services."""
        for service in self._services:
            self._node.destroy_service(service)

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._reset()
        response.success = True
        return response

    def _on_save(
        self, request: SaveCoefficients.Request, response: SaveCoefficients.Response
    ) -> SaveCoefficients.Response:
        try:
            path, state = self._path(request.file), self._state()
            if not state.ln_stiffness_reference_valid or state.status is not Status.VALID:
                raise ConfigurationError(f"status {state.status.name}: {state.reason or 'not converged'}")
            now = datetime.now(timezone.utc).isoformat(timespec="seconds")
            name = self._node.get_fully_qualified_name()
            update_file(path, name, coefficients_of_state(state), f"{self._node.config.transmission}, {now}")
        except (ConfigurationError, OSError) as error:
            response.message = " ".join(str(error).split())
            return response
        response.success, response.message = True, str(path)
        self._node.get_logger().info(f"coefficients saved to {path}")
        return response

    def _on_load(
        self, request: LoadCoefficients.Request, response: LoadCoefficients.Response
    ) -> LoadCoefficients.Response:
        try:
            path = self._path(request.file)
            posterior = read_posterior(path, self._node.get_name())
            changes = {f"initial.posterior.{name}": value for name, value in flatten(posterior).items()}
            result = self._node.set_parameters_atomically(
                [Parameter(name, value=list(v) if isinstance(v, tuple) else v) for name, v in changes.items()]
            )
            if not result.successful:
                raise ConfigurationError(result.reason)
        except (ConfigurationError, OSError) as error:
            response.message = " ".join(str(error).split())
            return response
        self._reset()
        response.success, response.message = True, f"{', '.join(posterior.names)} from {path}"
        self._node.get_logger().info(f"coefficients loaded: {response.message}")
        return response

    def _path(self, file: str) -> Path:
        """Path of the request, or of the parameter. Raises ConfigurationError without either."""
        if self._node.config.formulation != "force":
            raise ConfigurationError("only formulation force has coefficients to save or load")
        name = file or self._node.config.coefficients_file
        if not name:
            raise ConfigurationError("no file: neither in the call nor in the parameter coefficients_file")
        return Path(name).expanduser().absolute()
