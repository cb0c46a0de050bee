from fmpy import simulate_fmu

result = simulate_fmu(
    "CableRobotPlant.fmu",
    stop_time=1.0,
    output_interval=0.001,
    start_values={"disturbanceForce.x": 0.5},  # the motors hold the weight, and something pushes
    output=["encoderPose.x", "encoderPose.z", "measuredTension[1]", "slack[1]"],
)
print(result[::100])
