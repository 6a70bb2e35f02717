"""Forward kinematics of the Raven-II's arms for rows of joints, as the robot's own program has them
(raven2 include/raven/r2_kinematics.h: modified DH parameters; shoulder, elbow and insertion, then the tool)."""

import numpy as np


def link(alpha, a, theta, d):
    """RotX(alpha) TransX(a) RotZ(theta) TransZ(d), for arrays of theta and d."""
    theta, d = np.broadcast_arrays(np.asarray(theta, float), np.asarray(d, float))
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    out = np.zeros(theta.shape + (4, 4))
    out[..., 0, :] = np.stack([ct, -st, 0 * ct, a + 0 * ct], -1)
    out[..., 1, :] = np.stack([ca * st, ca * ct, -sa + 0 * ct, -sa * d], -1)
    out[..., 2, :] = np.stack([sa * st, sa * ct, ca + 0 * ct, ca * d], -1)
    out[..., 3, 3] = 1.0
    return out


def forward(arm, j, d4, lw):
    """Tool frame in the arm's base frame; arm 0 gold, 1 green; j: rows of 7 joints [rad; m], grasp1 and grasp2 last;
    d4, lw [m] of the tool."""
    r = np.radians
    gold = arm == 0
    chain = [link(0 if gold else np.pi, 0, j[:, 0] + r(205 if gold else 25), 0),
             link(r(75), 0, j[:, 1] + (np.pi if gold else 0), 0),
             link(r(128 if gold else 52), 0, np.full(len(j), r(90 if gold else -90)), j[:, 2]),
             link(0, 0, j[:, 3], d4),
             link(r(90), 0, j[:, 4] - r(90), 0),
             link(r(90), lw, (j[:, 6] - j[:, 5]) / 2, 0)]
    pose = chain[0]
    for step in chain[1:]:
        pose = pose @ step
    return pose
