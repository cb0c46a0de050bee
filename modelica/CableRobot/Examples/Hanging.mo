within CableRobot.Examples;
model Hanging "The plant alone: tensions that are not quite those of rest"
  CableRobot.Plants.Plant plant(initialPose = {0.05, -0.03, 1, 0.1, -0.05, 0.2});
  parameter Real tension[6](each unit = "N") = {12, 9, 11, 10.5, 10, 11.5} "What the motors pull";
equation
  plant.motorTension[1] = tension[1];
  plant.motorTension[2] = tension[2];
  plant.motorTension[3] = tension[3];
  plant.motorTension[4] = tension[4];
  plant.motorTension[5] = tension[5];
  plant.motorTension[6] = tension[6];
  annotation(experiment(StartTime = 0, StopTime = 1, Interval = 0.001, Tolerance = 1e-10));
end Hanging;
