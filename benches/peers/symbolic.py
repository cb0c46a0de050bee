"""The rig once more in CasADi, for the optima by ipopt."""

import casadi as ca


def rotation(angles):
    (cr, cp, cy), (sr, sp, sy) = ([f(angles[k]) for k in range(3)] for f in (ca.cos, ca.sin))
    return ca.vertcat(
        ca.horzcat(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        ca.horzcat(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        ca.horzcat(-sp, cp * sr, cp * cr),
    )


def omega(angles, rates):
    cp, cy, sp, sy = ca.cos(angles[1]), ca.cos(angles[2]), ca.sin(angles[1]), ca.sin(angles[2])
    return ca.vertcat(cy * cp * rates[0] - sy * rates[1], sy * cp * rates[0] + cy * rates[1], rates[2] - sp * rates[0])


def residual(rig):
    """(q, q', q'', tensions) -> what is lacking of the wrench, as a share of the weight."""
    q, v, a, u = ca.SX.sym("q", 6), ca.SX.sym("v", 6), ca.SX.sym("a", 6), ca.SX.sym("u", rig.cables)
    r = rotation(q[3:])
    inertia = r @ rig.inertia @ r.T
    turning = omega(q[3:], v[3:])
    alpha = ca.jtimes(turning, q[3:], v[3:]) + ca.jtimes(turning, v[3:], a[3:])
    force = rig.mass * a[:3] - ca.vertcat(0, 0, rig.weight)
    torque = inertia @ alpha + ca.cross(turning, inertia @ turning)
    for k in range(rig.cables):
        arm = r @ rig.arms[k]
        along = rig.anchors[k] - q[:3] - arm
        pull = u[k] * along / ca.norm_2(along)
        force, torque = force - pull, torque - ca.cross(arm, pull)
    lacking = ca.vertcat(force, torque / rig.radius) / rig.weight
    return ca.Function("residual", [q, v, a, u], [lacking])
