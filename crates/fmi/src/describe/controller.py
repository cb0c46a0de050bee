from fmpy import simulate_fmu

# The measured pose stays at its start, (0, 0, 1); the planner makes its first step towards the goal.
result = simulate_fmu(
    "CableRobotController.fmu",
    stop_time=0.2,
    output_interval=0.001,
    start_values={"goalPose.x": 0.15, "goalPose.y": 0.15},
    output=["setPoint.x", "setPoint.y", "motorTension[5]", "tensionMargin"],
)
print(result[::50])
