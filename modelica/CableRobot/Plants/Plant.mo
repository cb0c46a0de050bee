within CableRobot.Plants;
model Plant "A platform on 6 cables, in plain equations"
  parameter Real anchor1[3](each unit = "m") = {0.2598076211353316, -0.45, 0.0} "Of cable 1, base frame";
  parameter Real anchor2[3](each unit = "m") = {0.2598076211353316, -0.45, 0.0} "Of cable 2, base frame";
  parameter Real anchor3[3](each unit = "m") = {0.2598076211353316, 0.45, 0.0} "Of cable 3, base frame";
  parameter Real anchor4[3](each unit = "m") = {0.2598076211353316, 0.45, 0.0} "Of cable 4, base frame";
  parameter Real anchor5[3](each unit = "m") = {-0.5196152422706632, 0.0, 0.0} "Of cable 5, base frame";
  parameter Real anchor6[3](each unit = "m") = {-0.5196152422706632, 0.0, 0.0} "Of cable 6, base frame";
  parameter Real attachment1[3](each unit = "m") = {-0.14433756729740646, -0.25, 0.0} "Of cable 1, platform's frame";
  parameter Real attachment2[3](each unit = "m") = {0.2886751345948129, 0.0, 0.0} "Of cable 2, platform's frame";
  parameter Real attachment3[3](each unit = "m") = {0.2886751345948129, 0.0, 0.0} "Of cable 3, platform's frame";
  parameter Real attachment4[3](each unit = "m") = {-0.14433756729740646, 0.25, 0.0} "Of cable 4, platform's frame";
  parameter Real attachment5[3](each unit = "m") = {-0.14433756729740646, 0.25, 0.0} "Of cable 5, platform's frame";
  parameter Real attachment6[3](each unit = "m") = {-0.14433756729740646, -0.25, 0.0} "Of cable 6, platform's frame";
  parameter Real mass(unit = "kg") = 6.0 "Mass of the platform";
  parameter Real inertia_xx(unit = "kg.m2") = 0.018;
  parameter Real inertia_yy(unit = "kg.m2") = 0.018;
  parameter Real inertia_zz(unit = "kg.m2") = 0.075;
  parameter Real inertia_xy(unit = "kg.m2") = 0.0;
  parameter Real inertia_xz(unit = "kg.m2") = 0.0;
  parameter Real inertia_yz(unit = "kg.m2") = 0.0;
  parameter Real gravity[3](each unit = "m/s2") = {0.0, 0.0, 9.81} "Gravitational acceleration, base frame";
  parameter Real initialPose[6] = {0.0, 0.0, 1.0, 0.0, 0.0, 0.0} "Where the platform hangs, at rest, at the start: m and rad";
  CableRobot.Interfaces.RealInput motorTension[6] "What the motors pull, N"
    annotation(Placement(transformation(extent = {{-140, -20}, {-100, 20}})));
  CableRobot.Interfaces.RealOutput encoderPose[6] "Pose of the platform: m and rad"
    annotation(Placement(transformation(extent = {{100, 50}, {120, 70}})));
  CableRobot.Interfaces.RealOutput cableLength[6] "m"
    annotation(Placement(transformation(extent = {{100, -10}, {120, 10}})));
  CableRobot.Interfaces.RealOutput measuredTension[6] "What the cables pull, N"
    annotation(Placement(transformation(extent = {{100, -70}, {120, -50}})));
  final parameter Real determinant = inertia_xx * (inertia_yy * inertia_zz - inertia_yz * inertia_yz) - inertia_xy * (inertia_xy * inertia_zz - inertia_yz * inertia_xz) + inertia_xz * (inertia_xy * inertia_yz - inertia_yy * inertia_xz) "Of the inertia tensor";
  final parameter Real inverse_xx = (inertia_yy * inertia_zz - inertia_yz * inertia_yz) / determinant "Its inverse";
  final parameter Real inverse_yy = (inertia_xx * inertia_zz - inertia_xz * inertia_xz) / determinant;
  final parameter Real inverse_zz = (inertia_xx * inertia_yy - inertia_xy * inertia_xy) / determinant;
  final parameter Real inverse_xy = (inertia_xz * inertia_yz - inertia_xy * inertia_zz) / determinant;
  final parameter Real inverse_xz = (inertia_xy * inertia_yz - inertia_xz * inertia_yy) / determinant;
  final parameter Real inverse_yz = (inertia_xy * inertia_xz - inertia_xx * inertia_yz) / determinant;
  Real x(unit = "m", start = initialPose[1], fixed = true) "Centre of mass";
  Real y(unit = "m", start = initialPose[2], fixed = true);
  Real z(unit = "m", start = initialPose[3], fixed = true);
  Real v_x(unit = "m/s", start = 0, fixed = true) "Its velocity";
  Real v_y(unit = "m/s", start = 0, fixed = true);
  Real v_z(unit = "m/s", start = 0, fixed = true);
  Real q_w(
    start = cos(initialPose[4] / 2) * cos(initialPose[5] / 2) * cos(initialPose[6] / 2) + sin(initialPose[4] / 2) * sin(initialPose[5] / 2) * sin(initialPose[6] / 2),
    fixed = true) "Quaternion from the platform's to the base frame";
  Real q_x(
    start = sin(initialPose[4] / 2) * cos(initialPose[5] / 2) * cos(initialPose[6] / 2) - cos(initialPose[4] / 2) * sin(initialPose[5] / 2) * sin(initialPose[6] / 2),
    fixed = true);
  Real q_y(
    start = cos(initialPose[4] / 2) * sin(initialPose[5] / 2) * cos(initialPose[6] / 2) + sin(initialPose[4] / 2) * cos(initialPose[5] / 2) * sin(initialPose[6] / 2),
    fixed = true);
  Real q_z(
    start = cos(initialPose[4] / 2) * cos(initialPose[5] / 2) * sin(initialPose[6] / 2) - sin(initialPose[4] / 2) * sin(initialPose[5] / 2) * cos(initialPose[6] / 2),
    fixed = true);
  Real w_x(unit = "rad/s", start = 0, fixed = true) "Angular velocity in the platform's frame";
  Real w_y(unit = "rad/s", start = 0, fixed = true);
  Real w_z(unit = "rad/s", start = 0, fixed = true);
  Real turn_x(unit = "N.m") "Torque on the turning platform, its frame";
  Real turn_y(unit = "N.m");
  Real turn_z(unit = "N.m");
  Real h_x(unit = "kg.m2/s") "Angular momentum in the platform's frame";
  Real h_y(unit = "kg.m2/s");
  Real h_z(unit = "kg.m2/s");
  Real norm "Squared length of the quaternion, divided out";
  Real r11;
  Real r12;
  Real r13;
  Real r21;
  Real r22;
  Real r23;
  Real r31;
  Real r32;
  Real r33;
  Real torque_x(unit = "N.m") "Of the cables, base frame";
  Real torque_y(unit = "N.m");
  Real torque_z(unit = "N.m");
  CableRobot.Plants.Cable cable1(
    anchor_x = anchor1[1], anchor_y = anchor1[2], anchor_z = anchor1[3],
    attachment_x = attachment1[1], attachment_y = attachment1[2], attachment_z = attachment1[3],
    motorTension = motorTension[1], x = x, y = y, z = z,
    r11 = r11, r12 = r12, r13 = r13, r21 = r21, r22 = r22, r23 = r23, r31 = r31, r32 = r32, r33 = r33);
  CableRobot.Plants.Cable cable2(
    anchor_x = anchor2[1], anchor_y = anchor2[2], anchor_z = anchor2[3],
    attachment_x = attachment2[1], attachment_y = attachment2[2], attachment_z = attachment2[3],
    motorTension = motorTension[2], x = x, y = y, z = z,
    r11 = r11, r12 = r12, r13 = r13, r21 = r21, r22 = r22, r23 = r23, r31 = r31, r32 = r32, r33 = r33);
  CableRobot.Plants.Cable cable3(
    anchor_x = anchor3[1], anchor_y = anchor3[2], anchor_z = anchor3[3],
    attachment_x = attachment3[1], attachment_y = attachment3[2], attachment_z = attachment3[3],
    motorTension = motorTension[3], x = x, y = y, z = z,
    r11 = r11, r12 = r12, r13 = r13, r21 = r21, r22 = r22, r23 = r23, r31 = r31, r32 = r32, r33 = r33);
  CableRobot.Plants.Cable cable4(
    anchor_x = anchor4[1], anchor_y = anchor4[2], anchor_z = anchor4[3],
    attachment_x = attachment4[1], attachment_y = attachment4[2], attachment_z = attachment4[3],
    motorTension = motorTension[4], x = x, y = y, z = z,
    r11 = r11, r12 = r12, r13 = r13, r21 = r21, r22 = r22, r23 = r23, r31 = r31, r32 = r32, r33 = r33);
  CableRobot.Plants.Cable cable5(
    anchor_x = anchor5[1], anchor_y = anchor5[2], anchor_z = anchor5[3],
    attachment_x = attachment5[1], attachment_y = attachment5[2], attachment_z = attachment5[3],
    motorTension = motorTension[5], x = x, y = y, z = z,
    r11 = r11, r12 = r12, r13 = r13, r21 = r21, r22 = r22, r23 = r23, r31 = r31, r32 = r32, r33 = r33);
  CableRobot.Plants.Cable cable6(
    anchor_x = anchor6[1], anchor_y = anchor6[2], anchor_z = anchor6[3],
    attachment_x = attachment6[1], attachment_y = attachment6[2], attachment_z = attachment6[3],
    motorTension = motorTension[6], x = x, y = y, z = z,
    r11 = r11, r12 = r12, r13 = r13, r21 = r21, r22 = r22, r23 = r23, r31 = r31, r32 = r32, r33 = r33);
equation
  norm = q_w * q_w + q_x * q_x + q_y * q_y + q_z * q_z;
  r11 = (q_w * q_w + q_x * q_x - q_y * q_y - q_z * q_z) / norm;
  r12 = 2 * (q_x * q_y - q_w * q_z) / norm;
  r13 = 2 * (q_x * q_z + q_w * q_y) / norm;
  r21 = 2 * (q_x * q_y + q_w * q_z) / norm;
  r22 = (q_w * q_w - q_x * q_x + q_y * q_y - q_z * q_z) / norm;
  r23 = 2 * (q_y * q_z - q_w * q_x) / norm;
  r31 = 2 * (q_x * q_z - q_w * q_y) / norm;
  r32 = 2 * (q_y * q_z + q_w * q_x) / norm;
  r33 = (q_w * q_w - q_x * q_x - q_y * q_y + q_z * q_z) / norm;
  der(x) = v_x;
  der(y) = v_y;
  der(z) = v_z;
  der(q_w) = 0.5 * (-q_x * w_x - q_y * w_y - q_z * w_z);
  der(q_x) = 0.5 * (q_w * w_x + q_y * w_z - q_z * w_y);
  der(q_y) = 0.5 * (q_w * w_y + q_z * w_x - q_x * w_z);
  der(q_z) = 0.5 * (q_w * w_z + q_x * w_y - q_y * w_x);
  mass * (der(v_x) - gravity[1]) = cable1.force_x + cable2.force_x + cable3.force_x + cable4.force_x + cable5.force_x + cable6.force_x;
  mass * (der(v_y) - gravity[2]) = cable1.force_y + cable2.force_y + cable3.force_y + cable4.force_y + cable5.force_y + cable6.force_y;
  mass * (der(v_z) - gravity[3]) = cable1.force_z + cable2.force_z + cable3.force_z + cable4.force_z + cable5.force_z + cable6.force_z;
  torque_x = cable1.torque_x + cable2.torque_x + cable3.torque_x + cable4.torque_x + cable5.torque_x + cable6.torque_x;
  torque_y = cable1.torque_y + cable2.torque_y + cable3.torque_y + cable4.torque_y + cable5.torque_y + cable6.torque_y;
  torque_z = cable1.torque_z + cable2.torque_z + cable3.torque_z + cable4.torque_z + cable5.torque_z + cable6.torque_z;
  // Euler's equations in the platform's frame, h the angular momentum, solved for the angular acceleration.
  h_x = inertia_xx * w_x + inertia_xy * w_y + inertia_xz * w_z;
  h_y = inertia_xy * w_x + inertia_yy * w_y + inertia_yz * w_z;
  h_z = inertia_xz * w_x + inertia_yz * w_y + inertia_zz * w_z;
  turn_x = r11 * torque_x + r21 * torque_y + r31 * torque_z - w_y * h_z + w_z * h_y;
  turn_y = r12 * torque_x + r22 * torque_y + r32 * torque_z - w_z * h_x + w_x * h_z;
  turn_z = r13 * torque_x + r23 * torque_y + r33 * torque_z - w_x * h_y + w_y * h_x;
  der(w_x) = inverse_xx * turn_x + inverse_xy * turn_y + inverse_xz * turn_z;
  der(w_y) = inverse_xy * turn_x + inverse_yy * turn_y + inverse_yz * turn_z;
  der(w_z) = inverse_xz * turn_x + inverse_yz * turn_y + inverse_zz * turn_z;
  encoderPose[1] = x;
  encoderPose[2] = y;
  encoderPose[3] = z;
  encoderPose[4] = atan2(r32, r33);
  encoderPose[5] = -asin(r31);
  encoderPose[6] = atan2(r21, r11);
  cableLength[1] = cable1.length;
  cableLength[2] = cable2.length;
  cableLength[3] = cable3.length;
  cableLength[4] = cable4.length;
  cableLength[5] = cable5.length;
  cableLength[6] = cable6.length;
  measuredTension[1] = cable1.pull;
  measuredTension[2] = cable2.pull;
  measuredTension[3] = cable3.pull;
  measuredTension[4] = cable4.pull;
  measuredTension[5] = cable5.pull;
  measuredTension[6] = cable6.pull;
  annotation(
    Documentation(info = "<html><p>Newton and Euler's equations of a rigid body with 13 states; the quaternion's length is divided out. No friction, no lag, no noise: the plant FMU has those.</p></html>"),
    Icon(
      coordinateSystem(extent = {{-100, -100}, {100, 100}}),
      graphics = {
        Rectangle(extent = {{-100, 100}, {100, -100}}, lineColor = {60, 60, 60}, fillColor = {255, 255, 255}, fillPattern = FillPattern.Solid),
        Line(points = {{-80, 80}, {-20, -30}, {0, 80}, {20, -30}, {80, 80}}, color = {0, 90, 160}, thickness = 1),
        Rectangle(extent = {{-30, -30}, {30, -50}}, lineColor = {60, 60, 60}, fillColor = {170, 170, 170}, fillPattern = FillPattern.Solid),
        Text(extent = {{-100, 140}, {100, 104}}, textString = "%name", textColor = {0, 0, 255})}));
end Plant;
