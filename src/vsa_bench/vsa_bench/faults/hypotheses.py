# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Hypotheses of the fault isolation, and which of them a fault text of the estimator names."""

import re

FORCE_OFFSET, FORCE_STUCK, FORCE_NOISY = "force bias or drift", "force stuck", "force noisy"
ENCODER_STEP, ENCODER_STUCK, ENCODER_NOISY = "encoder step", "encoder stuck", "encoder noisy"
STAMPS_LATE, SATURATION = "stamps late", "saturation"
TRANSMISSION_CHANGED, MODEL_INADEQUATE = "transmission changed", "model inadequate"
NOT_ISOLATED, OTHER = "not isolated", "other"  # a text that names several hypotheses, or none of them
NOT_DETECTED = "not detected"

# The first pattern that occurs in a text decides.
_PATTERNS = {
    NOT_ISOLATED: r"inconsistent|consistency check",
    STAMPS_LATE: r"burst|\blate\b|delayed|stamps",
    SATURATION: r"saturat|at its limit",
    FORCE_NOISY: r"force.*nois",
    ENCODER_NOISY: r"encoder.*nois",
    FORCE_STUCK: r"force.*stuck",
    ENCODER_STUCK: r"encoder.*stuck",
    ENCODER_STEP: r"encoder.*(step|offset|shift)",
    TRANSMISSION_CHANGED: r"transmission.*chang|chang.*transmission",
    FORCE_OFFSET: r"force.*(bias|drift|offset|shift)",
    MODEL_INADEQUATE: r"model",
}
COLUMNS = (
    FORCE_OFFSET, FORCE_STUCK, FORCE_NOISY, ENCODER_STEP, ENCODER_STUCK, ENCODER_NOISY, STAMPS_LATE, SATURATION,
    TRANSMISSION_CHANGED, MODEL_INADEQUATE, OTHER, NOT_ISOLATED, NOT_DETECTED,
)  # fmt: skip


def hypothesis(text: str) -> str:
    """The hypothesis that a fault text names.

    >>> hypothesis("encoder step of +1.00 mm")
    'encoder step'
    """
    return next((name for name, pattern in _PATTERNS.items() if re.search(pattern, text)), OTHER)
