(** Theorems 1 and 2 of docs/exact.md: the exact reachable domain of a translation, and that it is convex. *)

Require Import Reals Lra.
From Coquelicot Require Import Coquelicot.
From CableRobot Require Import Geometry WrenchMatrix Facet Tensions Motion Curve.
Open Scope R_scope.

Section Domain.
  (** Half sides of the triangles, mass, gravity, gains. *)
  Variables a b m g l e : R.
  Hypotheses (Ha : 0 < a) (Hb : 0 < b) (Hm : 0 < m) (Hg : 0 < g) (Hl : 0 < l) (He : 0 < e).

  (** All cables are taut: the wrench matrix is regular, and the tensions that make the platform move so are positive. *)
  Definition taut (P P'' : vec) : Prop :=
    wrench_matrix_regular a b P /\ exists u, balanced a b m g P P'' u /\ forall i, 0 < u i.

  (** xd is admissible from P0 with the velocity v0: all cables are taut on the way and at rest at its end. *)
  Definition admissible (P0 v0 xd : vec) : Prop :=
    (forall t, 0 <= t -> taut (position l e P0 v0 xd t) (push l e P0 v0 xd t)) /\ taut xd zero.

  Lemma taut_below_the_base P P'' : 0 < z_of P -> (taut P P'' <-> forall i, 0 < facet a g i P P'').
  Proof.
    intros Hz. split.
    - intros [_ [u [Hu Hpositive]]] i. apply (taut_when_facet_positive a b m g Ha Hb Hm P P'' u i Hz Hu), Hpositive.
    - intros H. split; [apply (regular_off_the_base a b Ha Hb); lra|].
      exists (fun i => m * length a b P i * facet a g i P P'' / (3 * a * z_of P)).
      assert (Hbalanced : balanced a b m g P P'' (fun i => m * length a b P i * facet a g i P P'' / (3 * a * z_of P))).
      { apply E1; try assumption; [lra|reflexivity]. }
      split; [assumption|]. intros i.
      apply (taut_when_facet_positive a b m g Ha Hb Hm P P'' _ i Hz Hbalanced), H.
  Qed.

  Lemma taut_off_the_base P P'' : taut P P'' -> z_of P <> 0.
  Proof. intros [H _]. apply (regular_off_the_base a b Ha Hb). assumption. Qed.

  (** Above the base cables only push: at rest they are taut below it only, because the sum of the G_i is 3 a g. *)
  Lemma rest_is_below_the_base P : taut P zero -> 0 < z_of P.
  Proof.
    intros H. pose proof (taut_off_the_base P zero H) as Hz. destruct (Rtotal_order 0 (z_of P)) as [|[H0|H0]];
      [assumption|symmetry in H0; contradiction|exfalso].
    destruct H as [_ [u [Hu Hpositive]]].
    assert (HG : forall i, facet a g i P zero < 0).
    { intros i. pose proof (Hpositive i) as Hi. rewrite (proj1 (E1 a b m g Ha Hb P zero u Hz) Hu i) in Hi.
      set (G := facet a g i P zero) in *. pose proof (length_positive a b P i Hz) as Hlength.
      set (s := length a b P i) in *.
      replace (m * s * G / (3 * a * z_of P)) with (m * s / (3 * a * - z_of P) * - G) in Hi by (field; lra).
      assert (Hc : 0 < m * s / (3 * a * - z_of P)).
      { apply Rdiv_lt_0_compat; repeat apply Rmult_lt_0_compat; lra. }
      nra. }
    pose proof (sum_of_facets a g P zero) as Hsum. unfold total in Hsum. simpl z_of in Hsum.
    pose proof (HG c1). pose proof (HG c2). pose proof (HG c3). pose proof (HG c4). pose proof (HG c5). pose proof (HG c6).
    assert (0 < a * g) by (apply Rmult_lt_0_compat; assumption). lra.
  Qed.

  (** On the way the platform cannot pass through the base, where the matrix is singular, and its end is below it. *)
  Lemma admissible_stays_below P0 v0 xd : admissible P0 v0 xd ->
    forall t, 0 <= t -> 0 < z_of (position l e P0 v0 xd t).
  Proof.
    intros [Hway Hrest] t Ht. pose proof (rest_is_below_the_base xd Hrest) as Hend.
    assert (Hnever : forall s, 0 <= s -> z_of (position l e P0 v0 xd s) <> 0).
    { intros s Hs. apply (taut_off_the_base _ _ (Hway s Hs)). }
    set (z := curve l e (z_of xd) (z_of P0 - z_of xd) (z_of v0) 0).
    assert (Hz : forall s, z_of (position l e P0 v0 xd s) = z s) by (intros; apply height_is_a_curve).
    rewrite Hz. destruct (Rlt_dec 0 (z t)) as [|Hnot]; [assumption|exfalso].
    assert (Hbelow : z t < 0).
    { pose proof (Hnever t Ht) as H. rewrite Hz in H. lra. }
    destruct (curve_tends l e Hl He (z_of xd) (z_of P0 - z_of xd) (z_of v0) 0 (z_of xd / 2)) as [T [HT Hlate]]; [lra|].
    assert (Hlast : 0 < z (Rmax T t + 1)).
    { specialize (Hlate (Rmax T t + 1)). fold z in Hlate. pose proof (Rmax_l T t).
      specialize (Hlate ltac:(lra)). apply Rabs_le_between in Hlate. lra. }
    destruct (IVT z t (Rmax T t + 1)) as [s [Hs Hzero]]; try assumption.
    - intros s. apply curve_continuous. assumption.
    - pose proof (Rmax_r T t). lra.
    - apply (Hnever s); [lra|]. rewrite Hz. assumption.
  Qed.

  Lemma admissible_is P0 v0 xd : admissible P0 v0 xd <->
    (forall t, 0 <= t -> 0 < z_of (position l e P0 v0 xd t)) /\ 0 < z_of xd /\
    (forall i, (forall t, 0 <= t -> 0 < facet a g i (position l e P0 v0 xd t) (push l e P0 v0 xd t)) /\
               0 < facet a g i xd zero).
  Proof.
    split.
    - intros H. pose proof (admissible_stays_below P0 v0 xd H) as Hz. destruct H as [Hway Hrest].
      pose proof (rest_is_below_the_base xd Hrest) as Hend. split; [assumption|]. split; [assumption|]. intros i. split.
      + intros t Ht. apply (taut_below_the_base _ _ (Hz t Ht)), Hway, Ht.
      + apply (taut_below_the_base _ _ Hend), Hrest.
    - intros [Hz [Hend H]]. split.
      + intros t Ht. apply taut_below_the_base; [apply Hz, Ht|]. intros i. apply H, Ht.
      + apply taut_below_the_base; [assumption|]. intros i. apply H.
  Qed.

  Lemma facet_at_rest i xd : facet a g i xd zero = a_ a g xd i.
  Proof. unfold facet, a_, h, dot, zero. simpl. ring. Qed.

  (** Theorem 1. `least i` is the minimum of the curve (E3) of cable i over [0, infinity], `lowest` that of z: both exist
      (curve_has_minimum, height_has_minimum), and the value at infinity is the limit (curve_tends). *)
  Theorem theorem_1 P0 v0 xd (least : cable -> R) (lowest : R) :
    (forall i, minimum (curve l e (a_ a g xd i) (b_ l e a g P0 v0 xd i) (c_ l e a g P0 v0 xd i) (d_ l e P0 v0 xd i))
                 (a_ a g xd i) (least i)) ->
    minimum (fun t => z_of (position l e P0 v0 xd t)) (z_of xd) lowest ->
    (admissible P0 v0 xd <-> (forall i, 0 < least i) /\ 0 < lowest).
  Proof.
    intros Hleast Hlowest. rewrite admissible_is, (minimum_positive _ _ _ Hlowest).
    assert (Hcable : forall i, 0 < least i <->
      (forall t, 0 <= t -> 0 < facet a g i (position l e P0 v0 xd t) (push l e P0 v0 xd t)) /\ 0 < facet a g i xd zero).
    { intros i. rewrite (minimum_positive _ _ _ (Hleast i)), facet_at_rest.
      split; intros [H1 H2]; (split; [|assumption]); intros t Ht; specialize (H1 t Ht); rewrite E3 in *; assumption. }
    split.
    - intros [Hz [Hend H]]. split; [intros i; apply Hcable, H|split; assumption].
    - intros [H [Hz Hend]]. split; [assumption|]. split; [assumption|]. intros i. apply Hcable, H.
  Qed.

  Lemma height_has_minimum P0 v0 xd :
    exists lowest, minimum (fun t => z_of (position l e P0 v0 xd t)) (z_of xd) lowest.
  Proof.
    destruct (curve_has_minimum l e Hl He (z_of xd) (z_of P0 - z_of xd) (z_of v0) 0) as [lowest [H1 [H2 H3]]].
    exists lowest. split; [|split; [assumption|]].
    - intros t Ht. rewrite height_is_a_curve. apply H1, Ht.
    - destruct H3 as [[t [Ht <-]]|H3]; [left; exists t; split; [assumption|apply height_is_a_curve]|right; assumption].
  Qed.

  (** * Convexity *)

  Definition between (c : R) (x y : vec) : vec := plus (scale c x) (scale (1 - c) y).

  Lemma height_is_affine P0 v0 c x y t : z_of (position l e P0 v0 (between c x y) t)
    = c * z_of (position l e P0 v0 x t) + (1 - c) * z_of (position l e P0 v0 y t).
  Proof. unfold position, coordinate, between, plus, scale. simpl. ring. Qed.

  (** G(t) is affine in xd: what is quadratic in it cancels. *)
  Lemma facet_is_affine i P0 v0 c x y t :
    facet a g i (position l e P0 v0 (between c x y) t) (push l e P0 v0 (between c x y) t)
    = c * facet a g i (position l e P0 v0 x t) (push l e P0 v0 x t)
      + (1 - c) * facet a g i (position l e P0 v0 y t) (push l e P0 v0 y t).
  Proof.
    unfold facet, dot, position, push, coordinate, acceleration, between, plus, scale.
    destruct i; simpl; ring.
  Qed.

  Lemma facet_at_rest_is_affine i c x y :
    facet a g i (between c x y) zero = c * facet a g i x zero + (1 - c) * facet a g i y zero.
  Proof. unfold facet, dot, zero, between, plus, scale. destruct i; simpl; ring. Qed.

  Lemma mean_positive c p q : 0 <= c <= 1 -> 0 < p -> 0 < q -> 0 < c * p + (1 - c) * q.
  Proof. intros Hc Hp Hq. destruct (Rle_dec p q); nra. Qed.

  (** Theorem 2. From any state the admissible set points form a convex set. *)
  Theorem theorem_2 P0 v0 x y c : 0 <= c <= 1 ->
    admissible P0 v0 x -> admissible P0 v0 y -> admissible P0 v0 (between c x y).
  Proof.
    intros Hc. rewrite !admissible_is. intros [Hx [Hx' Gx]] [Hy [Hy' Gy]]. split; [|split].
    - intros t Ht. rewrite height_is_affine. apply mean_positive; auto.
    - unfold between, plus, scale. simpl. apply mean_positive; assumption.
    - intros i. destruct (Gx i) as [G1 G2], (Gy i) as [G3 G4]. split.
      + intros t Ht. rewrite facet_is_affine. apply mean_positive; auto.
      + rewrite facet_at_rest_is_affine. apply mean_positive; assumption.
  Qed.
End Domain.
