(** Theorem 3 of docs/exact.md: when every pair of points of the static workspace is one admissible step. *)

Require Import Reals Lra.
From Coquelicot Require Import Coquelicot.
From CableRobot Require Import Geometry WrenchMatrix Facet Tensions Motion Curve Domain.
Open Scope R_scope.

Section OneStep.
  Variables a b m g l e : R.
  Hypotheses (Ha : 0 < a) (Hb : 0 < b) (Hm : 0 < m) (Hg : 0 < g) (Hl : 0 < l) (He : 0 < e).

  (** S phi = f - phi', and where phi is largest phi' = 0. *)
  Lemma S_phi_at_most_1 t : 0 <= t -> S l e * phi l e t <= 1.
  Proof.
    intros Ht. assert (HS : 0 < S l e) by (unfold S; lra).
    destruct (curve_has_minimum l e Hl He 0 0 (-1) 0) as [least [Hall [Hend Hone]]].
    assert (Hcurve : forall s, curve l e 0 0 (-1) 0 s = - phi l e s) by (intros; unfold curve; ring).
    pose proof (Hall t Ht) as Hat. rewrite Hcurve in Hat.
    assert (Hlargest : S l e * phi l e t <= S l e * - least) by (apply Rmult_le_compat_l; lra).
    destruct Hone as [[r [Hr Hleast]]|<-]; [|lra]. rewrite Hcurve in Hleast.
    destruct Hr as [Hr|<-]; [|rewrite (proj2 (at_0 l e)) in Hleast; rewrite <- Hleast in Hlargest; lra].
    assert (Hslope : phi' l e r = 0).
    { pose (derivable := exist _ (phi' l e r) (proj1 (is_derive_Reals _ _ _) (slope_of_phi l e He r))
                         : derivable_pt (phi l e) r).
      change (derive_pt (phi l e) r derivable = 0). apply (deriv_maximum (phi l e) 0 (r + 1)); [lra|lra|].
      intros s Hs _. pose proof (Hall s ltac:(lra)) as H. rewrite Hcurve in H. lra. }
    pose proof (f_at_most_1 l e Hl He r ltac:(lra)). unfold phi' in Hslope.
    replace (- least) with (phi l e r) in Hlargest by lra. lra.
  Qed.

  (** psi = f + (z/g) f'' *)
  Definition psi (z t : R) : R := f l e t + z / g * f'' l e t.

  Theorem psi_between_0_and_1 z t : 0 < z -> w2 l e * z / g <= 1 -> 0 <= t -> 0 <= psi z t <= 1.
  Proof.
    intros Hz Hk Ht. set (k := w2 l e * z / g) in *.
    assert (Hk0 : 0 < k).
    { unfold k, w2. apply Rdiv_lt_0_compat; [repeat apply Rmult_lt_0_compat|]; assumption. }
    assert (Hpsi : psi z t = f l e t - k * phi' l e t).
    { unfold psi, k, f'', phi'. field. lra. }
    pose proof (f_positive l e Hl t Ht). pose proof (f_at_most_1 l e Hl He t Ht).
    pose proof (phi_not_negative l e t Ht). pose proof (S_phi_at_most_1 t Ht).
    assert (0 <= S l e * phi l e t) by (apply Rmult_le_pos; [unfold S; lra|assumption]).
    rewrite Hpsi. unfold phi'. set (sphi := S l e * phi l e t) in *. set (ft := f l e t) in *.
    split; [nra|]. destruct (Rle_dec 0 (ft - sphi)); nra.
  Qed.

  (** At rest at P all cables are taut: P is in the static workspace, (16). *)
  Definition in_static_workspace (P : vec) : Prop := taut a b m g P zero.

  Lemma static_workspace P : 0 < z_of P -> (in_static_workspace P <-> forall i, dot (normal i) P < a / 2).
  Proof.
    intros Hz. unfold in_static_workspace. rewrite (taut_below_the_base a b m g Ha Hb Hm P zero Hz).
    assert (H : forall i, facet a g i P zero = g * (a / 2 - dot (normal i) P)).
    { intros i. unfold facet, dot, zero. simpl. ring. }
    split; intros H1 i; specialize (H1 i); [rewrite H in H1|rewrite H]; nra.
  Qed.

  (** At constant height, from rest, p = xd (1 - psi) + x0 psi is what must be inside the facets. *)
  Lemma facet_at_constant_height i x0 xd t : z_of x0 = z_of xd ->
    facet a g i (position l e x0 zero xd t) (push l e x0 zero xd t)
    = g * ((1 - psi (z_of xd) t) * (a / 2 - dot (normal i) xd) + psi (z_of xd) t * (a / 2 - dot (normal i) x0)).
  Proof.
    intros Hz. unfold facet, dot, position, push, coordinate, acceleration, psi, zero. simpl. rewrite Hz.
    destruct i; simpl; field; lra.
  Qed.

  (** Theorem 3. *)
  Theorem theorem_3 x0 xd : z_of x0 = z_of xd -> w2 l e * z_of xd / g <= 1 ->
    in_static_workspace x0 -> in_static_workspace xd -> admissible a b m g l e x0 zero xd.
  Proof.
    intros Hlevel Hk H0 Hd. unfold in_static_workspace in *.
    pose proof (rest_is_below_the_base a b m g Ha Hb Hm Hg xd Hd) as Hz.
    assert (Hz0 : 0 < z_of x0) by lra.
    pose proof (proj1 (static_workspace x0 Hz0) H0) as N0. pose proof (proj1 (static_workspace xd Hz) Hd) as Nd.
    apply admissible_is; try assumption. split; [|split; [assumption|]].
    - intros t Ht. unfold position, coordinate, zero. simpl. rewrite Hlevel. lra.
    - intros i. split.
      + intros t Ht. rewrite facet_at_constant_height by assumption. apply Rmult_lt_0_compat; [assumption|].
        pose proof (psi_between_0_and_1 (z_of xd) t Hz Hk Ht). specialize (N0 i). specialize (Nd i).
        set (p := psi (z_of xd) t) in *. replace p with (1 - (1 - p)) at 2 by ring.
        apply mean_positive; lra.
      + apply (taut_below_the_base a b m g Ha Hb Hm xd zero Hz). assumption.
  Qed.
End OneStep.
