# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Figure of a designed spring: force, stiffness, cam with roller, motion of the follower."""

from typing import Any

import numpy as np
from vsa_common.figures import JOINT, MEASURED, SIDE_1, SIDE_2, TRUTH, panels
from vsa_tools.design.cam import Cam, Follower
from vsa_tools.design.spring import ExponentialSpring, Specification


def draw_design(wanted: Specification, spring: ExponentialSpring, follower: Follower, cam: Cam) -> Any:
    """A figure of four panels: force, stiffness, cam and follower."""
    figure, ((force, profile), (stiffness, motion)) = panels(2, 2, height=6.4, width=9.0)
    _draw_force(force, wanted, spring, follower, cam)
    _draw_stiffness(stiffness, spring, cam)
    _draw_profile(profile, follower, cam)
    _draw_motion(motion, cam)
    return figure


def _draw_force(axes: Any, wanted: Specification, spring: ExponentialSpring, follower: Follower, cam: Cam) -> None:
    axes.set_title("Force")
    x_mm = 1e3 * cam.deflection
    axes.plot(x_mm, spring.force(cam.deflection), color=SIDE_1, label="law, eq. (2)")
    if follower.friction:
        axes.plot(x_mm, cam.unloading_force, color=SIDE_2, label="unloading")
    corners = np.array([[wanted.rest_length, wanted.min_force], [wanted.max_deflection, wanted.max_force]])
    axes.plot(1e3 * corners[:, 0], corners[:, 1], "o", color=TRUTH, markersize=5, label="specification")
    axes.set(xlabel="deflection [mm]", ylabel="force [N]", ylim=(0.0, None))
    axes.legend()


def _draw_stiffness(axes: Any, spring: ExponentialSpring, cam: Cam) -> None:
    axes.set_title("Stiffness grows with force, eq. (3)")
    axes.plot(spring.force(cam.deflection), 1e-3 * spring.stiffness(cam.deflection), color=SIDE_1)
    axes.set(xlabel="force [N]", ylabel="stiffness [N/mm]")


def _draw_profile(axes: Any, follower: Follower, cam: Cam) -> None:
    axes.set_title("Cam and roller")
    cut_x, cut_y = 1e3 * cam.cut_x, 1e3 * cam.cut_y
    floor = cut_y.min() - 3.0
    axes.fill_between(cut_x, floor, cut_y, color="#dfe5ea", linewidth=0.0)
    axes.plot(cut_x, cut_y, color=TRUTH, label="cut surface")
    axes.plot(1e3 * cam.deflection, 1e3 * cam.lift, "--", color=SIDE_2, linewidth=0.9, label="roller's centre")
    for fraction in (0.0, 0.5, 1.0):
        i = round(fraction * (len(cam.deflection) - 1))
        turn = np.linspace(0.0, 2.0 * np.pi, 73)
        x, y = 1e3 * cam.deflection[i], 1e3 * cam.lift[i]
        radius = 1e3 * follower.roller_radius
        axes.plot(x + radius * np.cos(turn), y + radius * np.sin(turn), color=MEASURED, linewidth=0.8)
        axes.plot([x], [y], ".", color=SIDE_2, markersize=4)
    axes.set(xlabel="along the rod [mm]", ylabel="across [mm]", aspect="equal")
    axes.legend(loc="upper left")


def _draw_motion(axes: Any, cam: Cam) -> None:
    axes.set_title("Follower")
    x_mm = 1e3 * cam.deflection
    axes.plot(x_mm, 1e3 * cam.lift, color=SIDE_2)
    axes.set(xlabel="deflection [mm]")
    axes.set_ylabel("lift [mm]", color=SIDE_2)
    angle = axes.twinx()
    angle.grid(False)
    angle.spines["right"].set_visible(True)
    angle.plot(x_mm, np.degrees(np.arctan(cam.slope)), color=JOINT)
    angle.set_ylabel("contact angle [deg]", color=JOINT)
