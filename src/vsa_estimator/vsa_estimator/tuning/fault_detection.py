"""Tuned constants of `vsa_estimator.fault_detection`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)
