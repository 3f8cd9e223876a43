"""Tuned constants of `vsa_estimator.force_rate`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)
