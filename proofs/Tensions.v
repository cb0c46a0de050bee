(** (E1) of docs/exact.md: the tensions of a platform that is moved without turning, from Newton's and Euler's equations. *)

Require Import Reals Lra.
From CableRobot Require Import Geometry WrenchMatrix Facet Inverse.
Open Scope R_scope.

Section Robot.
  Variables a b m g : R.
  Hypotheses (Ha : 0 < a) (Hb : 0 < b) (Hm : 0 < m).

  Lemma density_times_length P u i : z_of P <> 0 -> density a b P u i * length a b P i = u i.
  Proof. intros Hz. unfold density. field. pose proof (length_positive a b P i Hz). lra. Qed.

  Lemma tensions_of_wrench P u F T i : z_of P <> 0 -> wrench a b P u = (F, T) ->
    u i = cofactor a b P F T i / (6 * a * b * z_of P) * length a b P i.
  Proof.
    intros Hz H. injection H as HF HT. rewrite <- (density_times_length P u i Hz). f_equal.
    rewrite <- HF, <- HT, <- densities_of_wrench. field. repeat split; lra.
  Qed.

  Lemma wrench_of_tensions P u F T : z_of P <> 0 ->
    (forall i, u i = cofactor a b P F T i / (6 * a * b * z_of P) * length a b P i) -> wrench a b P u = (F, T).
  Proof.
    intros Hz H. unfold wrench.
    destruct (wrench_of_densities a b Ha Hb P F T (density a b P u) Hz) as [-> ->]; [|reflexivity].
    intros i. unfold density. rewrite H. field. pose proof (length_positive a b P i Hz). repeat split; lra.
  Qed.

  (** The wrench matrix is regular unless the platform is in the plane of the base, where no tensions lift it. *)
  Theorem regular_off_the_base P : wrench_matrix_regular a b P <-> z_of P <> 0.
  Proof.
    split.
    - intros Hregular Hz. destruct (Hregular down zero) as [u [Hu _]].
      assert (Hflat : forall i, z_of (along a b P i) = 0).
      { intros i. unfold along, minus. rewrite anchor_is, attachment_is. destruct i; simpl; rewrite Hz; ring. }
      apply (f_equal (fun w => z_of (fst w))) in Hu. unfold wrench, force, resultant, total, scale, down in Hu.
      cbn [fst z_of] in Hu. rewrite !Hflat in Hu. lra.
    - intros Hz F T. exists (fun i => cofactor a b P F T i / (6 * a * b * z_of P) * length a b P i). split.
      + apply wrench_of_tensions; auto.
      + intros u' Hu' i. apply tensions_of_wrench; assumption.
  Qed.

  Lemma cofactor_of_motion P P'' i :
    cofactor a b P (scale m (minus P'' (scale g down))) zero i = 2 * b * m * facet a g i P P''.
  Proof.
    unfold cofactor, facet, dot, scale, minus, down, zero. destruct i; simpl; field.
  Qed.

  (** (E1): the tensions that move the platform are these and no others. *)
  Theorem E1 P P'' u : z_of P <> 0 ->
    (balanced a b m g P P'' u <-> forall i, u i = m * length a b P i * facet a g i P P'' / (3 * a * z_of P)).
  Proof.
    intros Hz.
    assert (Hform : forall i, cofactor a b P (scale m (minus P'' (scale g down))) zero i / (6 * a * b * z_of P)
                              * length a b P i = m * length a b P i * facet a g i P P'' / (3 * a * z_of P)).
    { intros i. rewrite cofactor_of_motion. field. repeat split; lra. }
    split.
    - intros H i. rewrite <- Hform. apply tensions_of_wrench; assumption.
    - intros H. apply wrench_of_tensions; [assumption|]. intros i. rewrite Hform. apply H.
  Qed.

  (** Below the base u_i has the sign of G_i. *)
  Corollary taut_when_facet_positive P P'' u i : 0 < z_of P -> balanced a b m g P P'' u ->
    (0 < u i <-> 0 < facet a g i P P'').
  Proof.
    intros Hz H. rewrite (proj1 (E1 P P'' u ltac:(lra)) H i). pose proof (length_positive a b P i ltac:(lra)) as Hl.
    set (G := facet a g i P P'') in *. set (l := length a b P i) in *.
    replace (m * l * G / (3 * a * z_of P)) with (m * l / (3 * a * z_of P) * G) by (field; lra).
    assert (Hc : 0 < m * l / (3 * a * z_of P)).
    { apply Rdiv_lt_0_compat; repeat apply Rmult_lt_0_compat; lra. }
    split; intros HG.
    - apply (Rmult_lt_reg_l _ _ _ Hc). lra.
    - apply Rmult_lt_0_compat; assumption.
  Qed.

  (** The sum of the six G_i is 3 a (g - z''). *)
  Lemma sum_of_facets P P'' : total (fun i => facet a g i P P'') = 3 * a * (g - z_of P'').
  Proof. unfold total, facet, dot. simpl. field. Qed.
End Robot.
