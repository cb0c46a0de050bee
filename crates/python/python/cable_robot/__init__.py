"""Cable-suspended robots whose cables never go slack.

    import cable_robot
    rig = cable_robot.Rig.load("rigs/eight.toml")        # or Rig.paper()
    rig.workspace().plot()
    plan = cable_robot.plan(rig, rig.home, (0.5, 0.3, 1.8))
    run = cable_robot.simulate(rig, rig.home, (0.5, 0.3, 1.8), duration=8)

SI units, angles in rad. A pose is x, y, z or x, y, z, roll, pitch, yaw of the centre of mass in the base frame of the rig file, with
R = Rz(yaw) Ry(pitch) Rx(roll). Arrays are numpy's. What makes no sense raises `ValueError`, which names the field, its value and what would be
right; a file that cannot be read raises `OSError`. What is proved, measured or refused: docs/limits.md of the project.
"""

from ._answers import Certificate, Plan, certify, plan
from ._rig import Cable, Rig, Tensions, Workspace
from ._run import Run, scenario, simulate
from ._fmus import fmu

__all__ = ["Cable", "Certificate", "Plan", "Rig", "Run", "Tensions", "Workspace", "certify", "fmu", "plan", "scenario", "simulate"]
