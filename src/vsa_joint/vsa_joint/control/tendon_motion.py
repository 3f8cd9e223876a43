"""How both rods move while the springs are wound up or let down together: one torque balance, two unequal dampers.

At rest the force of the springs gives each rod its place. On the way the dampers take their share, and where they are
unequal one rod leads the other until the springs make up for it; how fast it can is the dampers' affair, too. Motors
that follow each rod on that way leave the joint where it is. Both deviate so that the joint's stiffness stays.
"""

from vsa_joint.control.springs import Spring, Springs, partner_force
from vsa_joint.impedance.reflection import Joint, TendonPath

BISECTIONS = 40
FURTHEST = 0.01  # m, that a rod may lead

Pair = tuple[float, float]


class Rods:
    """Deflections and forces of both rods, one `step` each period."""

    def __init__(self, joint: Joint) -> None:
        self._joint = joint
        self._force = 0.0
        self._lead = 0.0  # m

    def start(self, force: float) -> None:
        """Both stand where `force` of transmission_1's spring holds them [N]."""
        self._force, self._lead = force, 0.0

    def step(self, force: float, springs: Springs, dt: float) -> tuple[Pair, Pair]:
        """Deflections [m] and rod forces [N] after `dt`, when the springs shall bear `force` at rest by then."""
        before, self._force = self._places(self._force, springs), force
        places = self._places(force, springs)
        speeds = [(place - last) / dt for place, last in zip(places, before, strict=True)]
        (first, second), (route_1, route_2) = springs, self._joint.routes
        growth_1 = _growth(first, first.stiffness_at(places[0]), route_1)
        growth_2 = _growth(second, second.stiffness_at(places[1]), route_2)
        part_1, part_2 = growth_2 / (growth_1 + growth_2), growth_1 / (growth_1 + growth_2)
        last = self._lead

        def moved(lead: float) -> tuple[Pair, Pair]:
            rate = (lead - last) / dt
            deflections = places[0] + part_1 * lead, places[1] - part_2 * lead
            force_1 = first.force(deflections[0]) + first.damper(speeds[0] + part_1 * rate)
            force_2 = second.force(deflections[1]) + second.damper(speeds[1] - part_2 * rate)
            return deflections, (force_1, force_2)

        low, high = -FURTHEST, FURTHEST
        for _ in range(BISECTIONS):
            self._lead = 0.5 * (low + high)
            force_1, force_2 = moved(self._lead)[1]
            if route_1.radius * force_1 < route_2.radius * force_2:
                low = self._lead
            else:
                high = self._lead
        return moved(self._lead)

    def _places(self, force: float, springs: Springs) -> Pair:
        first, second = springs
        return first.deflection(force), second.deflection(partner_force(force, 0.0, self._joint))


def _growth(spring: Spring, stiffness: float, route: TendonPath) -> float:
    """Of the joint's stiffness with a rod's deflection [N/rad]."""
    series = 4.0 * route.tendon_stiffness
    return spring.k2 * stiffness * (route.radius * series / (stiffness + series)) ** 2
