(** The wrench matrix as a square matrix of numbers, which is injective, so regular, off the plane of the base. *)

Require Import Reals Lra Lia.
From CableRobot Require Import Linear Geometry WrenchMatrix.
Open Scope R_scope.

Section Robot.
  Variables a b : R.
  Hypotheses (Ha : 0 < a) (Hb : 0 < b).

  (** The cofactors give densities from force and torque: they are linear in both. *)
  Lemma densities_of_wrench P q i : 6 * a * b * z_of P * q i = cofactor a b P (force a b P q) (torque a b P q) i.
  Proof.
    transitivity (total (fun j => q j * cofactor a b P (along a b P j) (cross (attachment b j) (along a b P j)) i)).
    - unfold total. rewrite !cofactor_of_column. destruct i; simpl; ring.
    - unfold cofactor, force, torque, resultant, total. generalize (along a b P). generalize (attachment b).
      generalize (normal i). intros n at_ v. unfold cross, scale, dot. cbn [x_of y_of z_of]. unfold Rdiv. ring.
  Qed.

  (** The numbers of force and torque, and the matrix of the columns (A_i - P - b_i, b_i x (A_i - P - b_i)). *)
  Definition entry (F T : vec) (k : nat) : R :=
    match k with
    | 0 => x_of F | 1 => y_of F | 2 => z_of F | 3 => x_of T | 4 => y_of T | _ => z_of T
    end%nat.

  Definition numbered (j : nat) : cable :=
    match j with 0 => c1 | 1 => c2 | 2 => c3 | 3 => c4 | 4 => c5 | _ => c6 end%nat.
  Definition number (i : cable) : nat :=
    match i with c1 => 0 | c2 => 1 | c3 => 2 | c4 => 3 | c5 => 4 | c6 => 5 end%nat.

  Definition columns (P : vec) : matrix := fun k j =>
    entry (along a b P (numbered j)) (cross (attachment b (numbered j)) (along a b P (numbered j))) k.

  Definition densities (x : vector) (i : cable) : R := x (number i).

  Lemma columns_times P x k :
    times 6 (columns P) x k = entry (force a b P (densities x)) (torque a b P (densities x)) k.
  Proof.
    unfold times, columns, force, torque, resultant, total, densities. generalize (along a b P). generalize (attachment b).
    intros at_ v. cbn [sum numbered number]. unfold cross, scale.
    do 5 (destruct k as [|k]; [cbn; ring|]). cbn. ring.
  Qed.

  Lemma same_entries F T F' T' : equal 6 (entry F T) (entry F' T') -> F = F' /\ T = T'.
  Proof.
    intros H. destruct F, T, F', T'.
    pose proof (H 0%nat ltac:(lia)). pose proof (H 1%nat ltac:(lia)). pose proof (H 2%nat ltac:(lia)).
    pose proof (H 3%nat ltac:(lia)). pose proof (H 4%nat ltac:(lia)). pose proof (H 5%nat ltac:(lia)).
    cbn in *. subst. split; reflexivity.
  Qed.

  Lemma denominator P : z_of P <> 0 -> 6 * a * b * z_of P <> 0.
  Proof. intros Hz. repeat apply Rmult_integral_contrapositive_currified; lra. Qed.

  Lemma columns_injective P : z_of P <> 0 -> injective 6 (columns P).
  Proof.
    intros Hz x Hx. destruct (same_entries (force a b P (densities x)) (torque a b P (densities x)) zero zero) as [HF HT].
    { intros k Hk. rewrite <- columns_times, (Hx k Hk). do 5 (destruct k as [|k]; [reflexivity|]). reflexivity. }
    assert (Hnone : forall i, densities x i = 0).
    { intros i. apply (Rmult_eq_reg_l (6 * a * b * z_of P)); [|apply denominator; assumption].
      rewrite densities_of_wrench, HF, HT. unfold cofactor, dot, zero. cbn. ring. }
    intros k Hk. transitivity (densities x (numbered k)); [|apply Hnone].
    unfold densities. f_equal. do 6 (destruct k as [|k]; [reflexivity|]). lia.
  Qed.

  Lemma wrench_of_densities P F T q : z_of P <> 0 ->
    (forall i, q i = cofactor a b P F T i / (6 * a * b * z_of P)) -> force a b P q = F /\ torque a b P q = T.
  Proof.
    intros Hz Hq. destruct (injective_is_regular 6 (columns P) (columns_injective P Hz) (entry F T)) as [x [Hx _]].
    destruct (same_entries (force a b P (densities x)) (torque a b P (densities x)) F T) as [HF HT].
    { intros k Hk. rewrite <- columns_times. apply Hx, Hk. }
    assert (Hsame : forall i, q i = densities x i).
    { intros i. rewrite Hq, <- HF, <- HT, <- densities_of_wrench. field. repeat split; lra. }
    rewrite <- HF, <- HT. unfold force, torque, resultant, total. rewrite !Hsame. split; reflexivity.
  Qed.
End Robot.
