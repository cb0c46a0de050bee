from fmpy import simulate_fmu

# The motors pull what holds the weight at (0, 0, 1), and something pushes to the side.
# fmpy's CVode integrates.
result = simulate_fmu(
    "CableRobotPlantME.fmu",
    stop_time=1.0,
    output_interval=0.001,
    relative_tolerance=1e-8,
    start_values={"disturbanceForce.x": 0.5},
    output=["encoderPose.x", "encoderPose.z", "measuredTension[1]", "slack[1]"],
)
print(result[::100])
