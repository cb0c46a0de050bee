(** The wrench matrix of the paper's geometry, the platform level: force and torque of tensions, and its inverse. *)

Require Import Reals Lra.
From CableRobot Require Import Geometry.
Open Scope R_scope.

Section Robot.
  (** Half the sides of the triangles (m), mass (kg), gravity (m/s^2). *)
  Variables a b m g : R.

  (** Force and torque about the centre of force densities q_i = u_i/l_i, the platform at P. *)
  Definition force (P : vec) (q : cable -> R) : vec := resultant (fun i => scale (q i) (along a b P i)).
  Definition torque (P : vec) (q : cable -> R) : vec :=
    resultant (fun i => cross (attachment b i) (scale (q i) (along a b P i))).

  Definition density (P : vec) (u : cable -> R) (i : cable) : R := u i / length a b P i.

  (** The wrench matrix W at P takes tensions to force and torque; it is regular if each wrench has exactly one solution. *)
  Definition wrench (P : vec) (u : cable -> R) : vec * vec := (force P (density P u), torque P (density P u)).
  Definition wrench_matrix_regular (P : vec) : Prop :=
    forall F T, exists u, wrench P u = (F, T) /\ forall u', wrench P u' = (F, T) -> forall i, u' i = u i.

  (** Newton's and Euler's equations without rotation: W u is m (P'' - g z) and no torque. *)
  Definition balanced (P P'' : vec) (u : cable -> R) : Prop :=
    wrench P u = (scale m (minus P'' (scale g down)), zero).

  (** * The inverse of the wrench matrix *)

  Definition sign (i : cable) : R := match i with c1 | c3 | c5 => 1 | _ => -1 end.
  Definition lever_x (i : cable) : R :=
    match i with c1 | c4 => a + b | c2 | c3 => a - 2 * b | c5 | c6 => b - 2 * a end.
  Definition lever_y (i : cable) : R :=
    match i with c1 => b - a | c2 => - a | c3 => a | c4 => a - b | c5 => - b | c6 => b end.

  (** 6 a b z times the density of cable i that, with the others', gives force F and torque T. *)
  Definition cofactor (P F T : vec) (i : cable) : R :=
    - 2 * b * (z_of P * dot (normal i) (Vec (x_of F) (y_of F) 0) + (a / 2 - dot (normal i) P) * z_of F)
    + sign i * ((sqrt 3 * x_of P / 2 + lever_x i) * x_of T
                + sqrt 3 * (y_of P / 2 + lever_y i) * y_of T + sqrt 3 * z_of P / 2 * z_of T).

  (** Cofactors times columns: of the column of cable j, 6 a b z if i = j, else 0. *)
  Definition unit (i j : cable) : R :=
    match i, j with
    | c1, c1 | c2, c2 | c3, c3 | c4, c4 | c5, c5 | c6, c6 => 1
    | _, _ => 0
    end.

  Lemma cofactor_of_column P i j :
    cofactor P (along a b P j) (cross (attachment b j) (along a b P j)) i = 6 * a * b * z_of P * unit i j.
  Proof.
    pose proof sqrt_3_squared as Hs. unfold cofactor, along, minus, cross, dot, sign, lever_x, lever_y.
    rewrite anchor_is, attachment_is.
    destruct i, j; simpl; generalize dependent (sqrt 3); intros s Hs; field [Hs].
  Qed.
End Robot.
