"""The platform on its cables in MuJoCo: a plant that shares no line with ours."""

import mujoco
import numpy as np

import python_robot


class Plant:
    """A rigid body on spatial tendons, each with a motor that pulls and cannot push; z down, as in the rig files."""

    def __init__(self, anchors, attachments, mass, inertia, position, substep=2.5e-4):
        tendons = range(len(anchors))
        sites = lambda name, ends: "".join(f'<site name="{name}{i}" pos="{" ".join(map(repr, map(float, ends[i])))}"/>' for i in tendons)
        xx, yy, zz = np.diag(inertia)
        off = f"{inertia[0, 1]} {inertia[0, 2]} {inertia[1, 2]}"
        self.model = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <compiler boundmass="0" boundinertia="0"/>
  <option gravity="0 0 {python_robot.G}" timestep="{substep}" integrator="RK4"><flag contact="disable"/></option>
  <worldbody>
    {sites("anchor", anchors)}
    <body name="platform" pos="{' '.join(map(repr, map(float, position)))}">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass}" fullinertia="{xx} {yy} {zz} {off}"/>
      {sites("attachment", attachments)}
    </body>
  </worldbody>
  <tendon>{"".join(f'<spatial name="cable{i}"><site site="anchor{i}"/><site site="attachment{i}"/></spatial>' for i in tendons)}</tendon>
  <actuator>{"".join(f'<motor tendon="cable{i}"/>' for i in tendons)}</actuator>
</mujoco>""")
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)

    @property
    def position(self):
        return self.data.qpos[:3].copy()

    def pose(self):
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, self.data.qpos[3:7])
        return np.concatenate([self.position, python_robot.euler_angles(rotation.reshape(3, 3))])

    def lengths(self):
        return self.data.ten_length.copy()

    def step(self, tensions, h):
        # A tendon's motor pushes its ends apart.
        self.data.ctrl[:] = -np.maximum(tensions, 0.0)
        for _ in range(round(h / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)
