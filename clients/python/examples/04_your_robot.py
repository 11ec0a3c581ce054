# SPDX-License-Identifier: Apache-2.0
"""An arm of three links in the plane y = 0, computed here a hundred times a second: the hand pushes
its tip, and it swings. 04_your_robot.py [SESSION]; start one with `hapticd configs/robot.toml`."""
import sys

import hapticd
import numpy as np

LENGTH = np.array([0.20, 0.15, 0.10])  # of the links [m]
MASS = np.array([0.5, 0.4, 0.3])  # at the end of each link [kg]
INERTIA = np.array([2e-4, 1e-4, 1e-4])  # of each link about its end [kg·m²]
REST = np.array([0.6, 0.7, 0.5])  # posture of the springs, each joint from the link before [rad]
SPRING = np.diag([12.0, 6.0, 3.0])  # [N·m/rad]
DAMPER = np.diag([0.3, 0.15, 0.08])  # [N·m·s/rad]


def points_and_jacobians(q):
    """Ends of the links (3, 3) [m], and of each the twist per joint (3, 6, 3)."""
    angle = np.cumsum(q)
    along = LENGTH[:, None] * np.stack([np.cos(angle), 0 * q, np.sin(angle)], axis=1)
    points = np.cumsum(along, axis=0)
    J = np.zeros((3, 6, 3))
    for end in range(3):
        for joint in range(end + 1):
            x, _, z = points[end] - (points[joint - 1] if joint else 0)
            J[end, :, joint] = -z, 0, x, 0, -1, 0
    return points, J


def mass_matrix(J):
    return sum(m * j[:3].T @ j[:3] + i * j[3:].T @ j[3:] for m, i, j in zip(MASS, INERTIA, J))


def acceleration(q, v, push):
    """Of the joints; what the mass matrix changes by is left out: the arm is slow."""
    J = points_and_jacobians(q)[1]
    return np.linalg.solve(mass_matrix(J), J[2].T @ push - SPRING @ (q - REST) - DAMPER @ v)


q, v = REST.copy(), np.zeros(3)
base = -points_and_jacobians(q)[0][2]  # so that the tip is at the origin of W at rest
with hapticd.connect(*sys.argv[1:2]) as session, session.give("robot") as robot:
    tip = robot.object("hand")
    for period in robot.every(0.01):
        push = robot.pushed(tip)
        n = max(1, round(push.span / 1e-3))
        for i in range(n):
            v += push.span / n * acceleration(q, v, push.at((i + 0.5) * push.span / n))
            q += push.span / n * v
        points, J = points_and_jacobians(q)
        J, M, to_joints = J[2], mass_matrix(J), np.linalg.pinv(J[2])
        V, A, turned = J @ v, J @ acceleration(q, v, np.zeros(6)), 0.5 * np.sum(q - REST)
        robot.move(tip, position=base + points[2], quaternion=(0, -np.sin(turned), 0, np.cos(turned)),
                   velocity=V[:3], angular_velocity=V[3:], acceleration=A[:3],
                   angular_acceleration=A[3:], mobility=J @ np.linalg.inv(M) @ J.T,
                   stiffness=to_joints.T @ SPRING @ to_joints,
                   damping=to_joints.T @ DAMPER @ to_joints)
        robot.publish()
        if period.index % 20 == 0:
            print("joints", np.degrees(q).round(1), "degrees   push", push.mean[:3].round(2), "N")
