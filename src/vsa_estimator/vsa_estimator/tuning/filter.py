"""Tuned constants of `vsa_estimator.filter`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)
