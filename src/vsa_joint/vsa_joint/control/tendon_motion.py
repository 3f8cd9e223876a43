# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Motion of both transmissions while the co-contraction changes: one torque balance, two unequal dampers.

At rest the force determines each deflection. In motion the dampers bear a part of the force; with unequal dampers one
transmission leads the other. Motors that follow this motion exert no torque on the joint. The lead is distributed over
both transmissions so that the stiffness of the joint does not change.
"""

from vsa_joint.control.springs import Spring, Springs
from vsa_joint.control.stiffness_range import partner_force
from vsa_joint.geometry import Joint, TendonPath
from vsa_joint.tuning import LEAD_BISECTIONS, MAX_LEAD, MIN_STIFFNESS_SLOPE

Pair = tuple[float, float]  # transmission_1, transmission_2


class CoContractionMotion:
    """Deflections and forces of both transmissions; one `step` per control period."""

    def __init__(self, joint: Joint) -> None:
        self._joint = joint
        self._force = 0.0  # N
        self._lead = 0.0  # m, of transmission_1

    def start(self, force: float) -> None:
        """Reset to rest at `force` of transmission_1 [N]."""
        self._force, self._lead = force, 0.0

    def step(self, force: float, springs: Springs, dt: float) -> tuple[Pair, Pair]:
        """Deflections [m] and forces [N] after `dt` [s] for an elastic force of transmission_1 that is then `force`."""
        before, self._force = self._at_rest(self._force, springs), force
        at_rest = self._at_rest(force, springs)
        speeds = [(position - last) / dt for position, last in zip(at_rest, before, strict=True)]
        (first, second), (path_1, path_2) = springs, self._joint.paths
        slope_1 = _stiffness_slope(first, at_rest[0], path_1)
        slope_2 = _stiffness_slope(second, at_rest[1], path_2)
        share_1, share_2 = slope_2 / (slope_1 + slope_2), slope_1 / (slope_1 + slope_2)
        last_lead = self._lead

        def moved(lead: float) -> tuple[Pair, Pair]:
            rate = (lead - last_lead) / dt
            deflections = at_rest[0] + share_1 * lead, at_rest[1] - share_2 * lead
            force_1 = first.force(deflections[0]) + first.damper(speeds[0] + share_1 * rate)
            force_2 = second.force(deflections[1]) + second.damper(speeds[1] - share_2 * rate)
            return deflections, (force_1, force_2)

        low, high = -MAX_LEAD, MAX_LEAD
        for _ in range(LEAD_BISECTIONS):
            self._lead = 0.5 * (low + high)
            force_1, force_2 = moved(self._lead)[1]
            if path_1.radius * force_1 < path_2.radius * force_2:
                low = self._lead
            else:
                high = self._lead
        return moved(self._lead)

    def _at_rest(self, force: float, springs: Springs) -> Pair:
        """Deflections at rest [m]."""
        first, second = springs
        return first.deflection(force), second.deflection(partner_force(force, 0.0, self._joint))


def _stiffness_slope(spring: Spring, deflection: float, path: TendonPath) -> float:
    """Derivative of the joint stiffness by the deflection of one transmission [N/rad]."""
    stiffness, series = spring.stiffness_at(deflection), 4.0 * path.tendon_stiffness
    return (
        max(spring.slope_at(deflection), MIN_STIFFNESS_SLOPE)
        * stiffness
        * (path.radius * series / (stiffness + series)) ** 2
    )
