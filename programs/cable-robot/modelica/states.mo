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
