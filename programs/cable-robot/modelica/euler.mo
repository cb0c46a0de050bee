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
