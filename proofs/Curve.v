(** (E3) of docs/exact.md: G along the closed loop is a + b f + c phi + d exp(-St), and has a minimum over [0, infinity]. *)

Require Import Reals Lra Classical.
From Coquelicot Require Import Coquelicot.
From CableRobot Require Import Geometry Facet Motion.
Open Scope R_scope.

(** * The end: f, phi and exp(-St) die away *)

Definition tends (h : R -> R) (end_ : R) : Prop :=
  forall eps, 0 < eps -> exists T, 0 <= T /\ forall t, T <= t -> Rabs (h t - end_) <= eps.

Lemma tends_equal h h' c : (forall t, h t = h' t) -> tends h c -> tends h' c.
Proof. intros H Ht eps Heps. destruct (Ht eps Heps) as [T [HT Hh]]. exists T. split; [assumption|]. intros. rewrite <- H. auto. Qed.

Lemma tends_plus h k c d : tends h c -> tends k d -> tends (fun t => h t + k t) (c + d).
Proof.
  intros Hh Hk eps Heps. destruct (Hh (eps / 2)) as [T [HT H]]; [lra|]. destruct (Hk (eps / 2)) as [U [HU K]]; [lra|].
  exists (Rmax T U). split; [eapply Rle_trans; [exact HT|apply Rmax_l]|]. intros t Ht.
  replace (h t + k t - (c + d)) with ((h t - c) + (k t - d)) by ring. eapply Rle_trans; [apply Rabs_triang|].
  assert (T <= t) by (eapply Rle_trans; [apply Rmax_l|exact Ht]).
  assert (U <= t) by (eapply Rle_trans; [apply Rmax_r|exact Ht]).
  specialize (H t ltac:(assumption)). specialize (K t ltac:(assumption)). lra.
Qed.

Lemma tends_constant c : tends (fun _ => c) c.
Proof. intros eps Heps. exists 0. split; [lra|]. intros. rewrite Rminus_eq_0, Rabs_R0. lra. Qed.

Lemma tends_scaled h c k : tends h c -> tends (fun t => k * h t) (k * c).
Proof.
  intros H eps Heps. pose proof (Rabs_pos k). destruct (H (eps / (Rabs k + 1))) as [T [HT Hh]].
  { apply Rdiv_lt_0_compat; lra. }
  exists T. split; [assumption|]. intros t Ht. replace (k * h t - k * c) with (k * (h t - c)) by ring.
  rewrite Rabs_mult. specialize (Hh t Ht). pose proof (Rabs_pos (h t - c)).
  apply Rle_trans with (Rabs k * (eps / (Rabs k + 1))); [apply Rmult_le_compat_l; assumption|].
  apply (Rmult_le_reg_r (Rabs k + 1)); [lra|].
  replace (Rabs k * (eps / (Rabs k + 1)) * (Rabs k + 1)) with (Rabs k * eps) by (field; lra). nra.
Qed.

Lemma exponential_dies p : 0 < p -> tends (fun t => exp (- (p * t))) 0.
Proof.
  intros Hp eps Heps. exists (/ (p * eps)).
  assert (Hpos : 0 < / (p * eps)) by (apply Rinv_0_lt_compat, Rmult_lt_0_compat; assumption).
  split; [lra|]. intros t Ht. rewrite Rminus_0_r, Rabs_right by (left; apply exp_pos).
  rewrite exp_Ropp. apply (Rmult_le_reg_r (exp (p * t))); [apply exp_pos|].
  rewrite Rinv_l by (apply Rgt_not_eq, exp_pos).
  assert (Hexp : 1 + p * t < exp (p * t)) by (apply exp_ineq1; apply Rgt_not_eq, Rmult_lt_0_compat; lra).
  assert (Hone : 1 <= eps * (p * t)).
  { replace 1 with (p * eps * / (p * eps)) by (field; split; lra). replace (eps * (p * t)) with (p * eps * t) by ring.
    apply Rmult_le_compat_l; [|exact Ht]. left. apply Rmult_lt_0_compat; assumption. }
  nra.
Qed.

(** t exp(-pt) <= 2/p exp(-pt/2). *)
Lemma time_times_exponential_dies p : 0 < p -> tends (fun t => t * exp (- (p * t))) 0.
Proof.
  intros Hp eps Heps. destruct (exponential_dies (p / 2) ltac:(lra) (eps * (p / 2))) as [T [HT H]].
  { apply Rmult_lt_0_compat; lra. }
  exists T. split; [assumption|]. intros t Ht. specialize (H t Ht). rewrite Rminus_0_r in *.
  set (q := exp (- (p / 2 * t))) in *. assert (Hq : 0 < q) by apply exp_pos.
  replace (exp (- (p * t))) with (q * q) by (unfold q; rewrite <- exp_plus; f_equal; field).
  rewrite Rabs_right in H by lra. rewrite Rabs_right by (apply Rle_ge; repeat apply Rmult_le_pos; lra).
  assert (Hle : p / 2 * t * q <= 1).
  { unfold q. rewrite exp_Ropp. apply (Rmult_le_reg_r (exp (p / 2 * t))); [apply exp_pos|].
    rewrite Rmult_assoc, Rinv_l by (apply Rgt_not_eq, exp_pos).
    pose proof (exp_ineq1_le (p / 2 * t)). lra. }
  apply (Rmult_le_reg_l (p / 2)); [lra|]. replace (p / 2 * (t * (q * q))) with (p / 2 * t * q * q) by ring.
  apply Rle_trans with (1 * q); [apply Rmult_le_compat_r; lra|lra].
Qed.

Lemma phi_dies l e : 0 < l -> 0 < e -> tends (phi l e) 0.
Proof.
  intros Hl He. destruct (Req_dec l e) as [<-|Hne].
  - apply (tends_equal (fun t => t * exp (- (l * t)))); [|apply time_times_exponential_dies; assumption].
    intros t. unfold phi. destruct (Req_EM_T l l); [reflexivity|contradiction].
  - replace 0 with (/ (e - l) * 0 + - / (e - l) * 0) by ring.
    apply (tends_equal (fun t => / (e - l) * exp (- (l * t)) + - / (e - l) * exp (- (e * t)))).
    + intros t. unfold phi. destruct (Req_EM_T l e); [contradiction|field; lra].
    + apply tends_plus; apply tends_scaled, exponential_dies; assumption.
Qed.

Lemma f_dies l e : 0 < l -> 0 < e -> tends (f l e) 0.
Proof.
  intros Hl He. replace 0 with (0 + l * 0) by ring. apply tends_plus; [apply exponential_dies; assumption|].
  apply tends_scaled, phi_dies; assumption.
Qed.

(** * Minima over [0, infinity] *)

Definition minimum (h : R -> R) (end_ least : R) : Prop :=
  (forall t, 0 <= t -> least <= h t) /\ least <= end_ /\ ((exists t, 0 <= t /\ h t = least) \/ end_ = least).

Lemma minimum_exists h end_ : (forall t, continuity_pt h t) -> tends h end_ -> exists least, minimum h end_ least.
Proof.
  intros Hcontinuous Htends.
  destruct (classic (exists s, 0 <= s /\ h s < end_)) as [[s [Hs Hbelow]]|Hnone].
  - destruct (Htends ((end_ - h s) / 2)) as [T [HT Hlate]]; [lra|].
    assert (HsM : s <= Rmax T s) by apply Rmax_r.
    destruct (continuity_ab_min h 0 (Rmax T s)) as [r [Hleast Hr]]; [lra|intros; apply Hcontinuous|].
    exists (h r). assert (h r <= h s) by (apply Hleast; lra). split; [|split; [lra|left; exists r; split; [lra|reflexivity]]].
    intros t Ht. destruct (Rle_dec t (Rmax T s)) as [Hin|Hout]; [apply Hleast; lra|].
    assert (T <= t) by (pose proof (Rmax_l T s); lra).
    specialize (Hlate t ltac:(assumption)). apply Rabs_le_between in Hlate. lra.
  - exists end_. split; [|split; [lra|right; reflexivity]].
    intros t Ht. destruct (Rle_dec end_ (h t)) as [|Hnot]; [assumption|]. exfalso. apply Hnone. exists t. split; lra.
Qed.

Lemma minimum_positive h end_ least : minimum h end_ least ->
  (0 < least <-> (forall t, 0 <= t -> 0 < h t) /\ 0 < end_).
Proof.
  intros [Hall [Hend Hone]]. split.
  - intros H. split; [|lra]. intros t Ht. specialize (Hall t Ht). lra.
  - intros [H1 H2]. destruct Hone as [[t [Ht <-]]|<-]; auto.
Qed.

(** * The curves *)

Section Loop.
  Variables l e : R.
  Hypotheses (Hl : 0 < l) (He : 0 < e).

  Definition curve (A B C D t : R) : R := A + B * f l e t + C * phi l e t + D * exp (- (S l e * t)).

  Lemma curve_continuous A B C D t : continuity_pt (curve A B C D) t.
  Proof.
    apply derivable_continuous_pt. exists (B * f' l e t + C * phi' l e t + D * (- S l e * exp (- (S l e * t)))).
    apply is_derive_Reals. unfold curve.
    replace (B * f' l e t + C * phi' l e t + D * (- S l e * exp (- (S l e * t))))
      with (0 + B * f' l e t + C * phi' l e t + D * (- S l e * exp (- (S l e * t)))) by ring.
    apply (is_derive_plus (fun s => A + B * f l e s + C * phi l e s) (fun s => D * exp (- (S l e * s)))).
    - apply (is_derive_plus (fun s => A + B * f l e s) (fun s => C * phi l e s)).
      + apply (is_derive_plus (fun _ => A) (fun s => B * f l e s)); [apply @is_derive_const|].
        apply is_derive_scal, slope_of_f. assumption.
      + apply is_derive_scal, slope_of_phi. assumption.
    - apply is_derive_scal. auto_derive; trivial. ring.
  Qed.

  Lemma curve_tends A B C D : tends (curve A B C D) A.
  Proof.
    replace A with (A + B * 0 + C * 0 + D * 0) at 2 by ring. unfold curve.
    repeat apply tends_plus; try apply tends_scaled; [apply tends_constant|apply f_dies|apply phi_dies|]; try assumption.
    apply exponential_dies. unfold S. lra.
  Qed.

  Theorem curve_has_minimum A B C D : exists least, minimum (curve A B C D) A least.
  Proof. apply minimum_exists; [intros; apply curve_continuous|apply curve_tends]. Qed.

  (** The motion of the platform from P0 with the velocity v0 to the set point xd, and its acceleration. *)
  Definition position (P0 v0 xd : vec) (t : R) : vec :=
    Vec (coordinate l e (x_of P0) (x_of v0) (x_of xd) t) (coordinate l e (y_of P0) (y_of v0) (y_of xd) t)
        (coordinate l e (z_of P0) (z_of v0) (z_of xd) t).
  Definition push (P0 v0 xd : vec) (t : R) : vec :=
    Vec (acceleration l e (x_of P0) (x_of v0) (x_of xd) t) (acceleration l e (y_of P0) (y_of v0) (y_of xd) t)
        (acceleration l e (z_of P0) (z_of v0) (z_of xd) t).

  Variables a g : R.
  Variables P0 v0 xd : vec.

  Definition h (i : cable) : R := a / 2 - dot (normal i) xd.
  Definition alpha (i : cable) : R := dot (normal i) (Geometry.minus P0 xd).
  Definition beta (i : cable) : R := dot (normal i) v0.
  Definition gamma : R := z_of P0 - z_of xd.
  Definition delta : R := z_of v0.

  (** The coefficients a, b, c, d of (E3), as `ExactDomain::facet` of src/reach/exact.rs computes them. *)
  Definition kappa_1 (i : cable) : R := h i * gamma + z_of xd * alpha i.
  Definition kappa_2 (i : cable) : R := h i * delta + z_of xd * beta i.
  Definition a_ (i : cable) : R := g * h i.
  Definition b_ (i : cable) : R := - g * alpha i + w2 l e * kappa_1 i + S l e * kappa_2 i.
  Definition c_ (i : cable) : R :=
    - g * beta i - w2 l e * S l e * kappa_1 i - (S l e * S l e - w2 l e) * kappa_2 i.
  Definition d_ (i : cable) : R := (gamma * beta i - delta * alpha i) * S l e.

  (** The line before (E3): all products of f and phi cancel but the last bracket, *)
  Theorem before_E3 i t :
    facet a g i (position P0 v0 xd t) (push P0 v0 xd t)
    = g * h i - g * (alpha i * f l e t + beta i * phi l e t) - (h i * gamma + z_of xd * alpha i) * f'' l e t
      - (h i * delta + z_of xd * beta i) * phi'' l e t
      + (gamma * beta i - delta * alpha i) * (f'' l e t * phi l e t - f l e t * phi'' l e t).
  Proof.
    unfold facet, h, alpha, beta, gamma, delta, dot, position, push, coordinate, acceleration.
    destruct i; simpl; ring.
  Qed.

  (** which is minus the derivative of the Wronskian (Abel). *)
  Lemma last_bracket t : f'' l e t * phi l e t - f l e t * phi'' l e t = S l e * exp (- (S l e * t)).
  Proof. rewrite <- (wronskian l e He t). unfold f'', phi'', phi', f', S, w2. ring. Qed.

  Theorem E3 i t : facet a g i (position P0 v0 xd t) (push P0 v0 xd t) = curve (a_ i) (b_ i) (c_ i) (d_ i) t.
  Proof.
    rewrite before_E3, last_bracket. unfold curve, a_, b_, c_, d_, kappa_1, kappa_2, f'', phi''. ring.
  Qed.

  Lemma height_is_a_curve t :
    z_of (position P0 v0 xd t) = curve (z_of xd) (z_of P0 - z_of xd) (z_of v0) 0 t.
  Proof. unfold position, curve, coordinate. simpl. ring. Qed.

  (** From rest, and at constant height with z' = 0, d = 0. *)
  Lemma no_d i : v0 = zero \/ (gamma = 0 /\ delta = 0) -> d_ i = 0.
  Proof.
    unfold d_. intros [H|[-> ->]]; [|ring]. unfold beta, delta. rewrite H. unfold dot, zero. destruct i; simpl; ring.
  Qed.
End Loop.
