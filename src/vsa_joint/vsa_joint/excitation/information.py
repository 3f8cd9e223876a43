# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Fisher information of the coefficients of a transmission from a motion, with noise on force and encoder.

The encoder's noise acts on the residual of the force through the impedance G = K + s D + s^2 M: its density is
S(w) = S_F + |G(i w)|^2 S_x (errors in variables: R. Pintelon, J. Schoukens, "System Identification: A Frequency Domain
Approach", 2nd ed., Wiley 2012, ch. 8). S = |b0 + b1 s + b2 s^2|^2 at s = i w, so that the derivatives g of the force
by the coefficients, filtered by 1 / (b0 + b1 s + b2 s^2), have white unit noise: h. The information is the sum of
h h^T over the samples. Stiffness and damping of the filter are their means over the motion.
"""

import numpy as np
from vsa_common.types import Array
from vsa_joint.excitation.model import Motion, TransmissionModel


def information(model: TransmissionModel, motion: Motion, step: float, sample_rate: float) -> Array:
    """Information on COEFFICIENTS, (..., 7, 7), of a motion from rest, (..., steps).

    `step` [s] is that of the motion, `sample_rate` [Hz] that of the sensors.
    """
    whitened = whiten(model.gradients(motion), whitening_filter(model, motion), step)
    return sample_rate * step * (np.swapaxes(whitened, -1, -2) @ whitened)


def whitening_filter(model: TransmissionModel, motion: Motion) -> Array:
    """Coefficients b0, b1, b2 of the residual's noise, (..., 3), for one sample [N, N s, N s^2]."""
    stiffness = model.stiffness(motion.deflection).mean(axis=-1)
    damping = model.damping(motion.velocity).mean(axis=-1)
    noise = model.deflection_noise_std
    b0 = np.hypot(model.force_noise_std, stiffness * noise)
    b2 = np.broadcast_to(model.inertia * noise, b0.shape)
    b1 = np.sqrt(np.maximum(noise**2 * (damping**2 - 2.0 * stiffness * model.inertia) + 2.0 * b0 * b2, 0.0))
    return np.stack([b0, b1, b2], axis=-1)


def whiten(gradients: Array, filter_: Array, step: float) -> Array:
    """Gradients, (..., steps, n), filtered by 1 / (b0 + b1 s + b2 s^2), (..., 3); constant before the first step."""
    count = gradients.shape[-2]
    s = 2j * np.pi * np.fft.rfftfreq(2 * count, step)
    b0, b1, b2 = (filter_[..., i, None, None] for i in range(3))
    first = gradients[..., :1, :]
    lines = np.fft.rfft(gradients - first, 2 * count, axis=-2) / (b0 + s[:, None] * (b1 + s[:, None] * b2))
    return np.asarray(first / b0 + np.fft.irfft(lines, 2 * count, axis=-2)[..., :count, :])


def wanted_covariance(information: Array, wanted: tuple[int, ...]) -> Array:
    """Covariance of the wanted coefficients, (..., n, n), from the information on all of them, (..., 7, 7)."""
    scale = np.sqrt(np.diagonal(information, axis1=-2, axis2=-1))
    outer = scale[..., :, None] * scale[..., None, :]
    covariance = np.linalg.inv(information / outer) / outer
    return np.asarray(covariance[..., np.array(wanted)[:, None], wanted])
