# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""All laws of a transmission; the defaults are the paper's."""

from dataclasses import dataclass

from vsa_common.config.configuration import group
from vsa_simulator.laws.dampers import DamperConfig
from vsa_simulator.laws.friction import FrictionConfig
from vsa_simulator.laws.internal import HysteresisConfig, ViscoelasticConfig
from vsa_simulator.laws.springs import SpringConfig


@dataclass(frozen=True)
class ForceLaws:
    """Laws of spring, damper, friction, viscoelastic branch and hysteresis.

    >>> ForceLaws(spring=SpringConfig("quadratic"), viscoelastic=ViscoelasticConfig(share=0.2)).damper.kind
    'cubic'
    """

    spring: SpringConfig = group(SpringConfig)
    damper: DamperConfig = group(DamperConfig)
    friction: FrictionConfig = group(FrictionConfig)
    viscoelastic: ViscoelasticConfig = group(ViscoelasticConfig)
    hysteresis: HysteresisConfig = group(HysteresisConfig)
