(** (E2) of docs/exact.md: the motion of one coordinate under the law, and what f and phi are. *)

Require Import Reals Lra.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

(** Between two times the slope is somewhere the mean slope. *)
Lemma mean_slope (h h' : R -> R) s t : s < t -> (forall c, s <= c <= t -> is_derive h c (h' c)) ->
  exists c, s < c < t /\ h t - h s = h' c * (t - s).
Proof.
  intros Hst H. destruct (MVT_cor2 h h' s t Hst) as [c [Hc Hin]].
  - intros c Hc. apply is_derive_Reals, H, Hc.
  - exists c. split; assumption.
Qed.

Lemma constant_of_no_slope (h : R -> R) : (forall t, 0 <= t -> is_derive h t 0) -> forall t, 0 <= t -> h t = h 0.
Proof.
  intros H t [Ht|<-]; [|reflexivity].
  destruct (mean_slope h (fun _ => 0) 0 t Ht) as [c [_ Hc]]; [intros; apply H; tauto|lra].
Qed.

Section Gains.
  (** The gains lambda and eta. *)
  Variables l e : R.
  Hypotheses (Hl : 0 < l) (He : 0 < e).

  Definition S : R := l + e.
  Definition w2 : R := l * e.

  Definition phi (t : R) : R :=
    if Req_EM_T l e then t * exp (- (l * t)) else (exp (- (l * t)) - exp (- (e * t))) / (e - l).
  Definition f (t : R) : R := exp (- (l * t)) + l * phi t.

  (** Their derivatives, (E2). *)
  Definition phi' (t : R) : R := f t - S * phi t.
  Definition f' (t : R) : R := - w2 * phi t.
  Definition phi'' (t : R) : R := - S * f t + (S * S - w2) * phi t.
  Definition f'' (t : R) : R := - w2 * f t + w2 * S * phi t.

  Lemma other_exponential t : exp (- (e * t)) = exp (- (l * t)) - (e - l) * phi t.
  Proof. unfold phi. destruct (Req_EM_T l e) as [<-|]; [ring|field; lra]. Qed.

  Lemma slope_of_phi t : is_derive phi t (phi' t).
  Proof.
    unfold phi', f, S, phi. destruct (Req_EM_T l e) as [<-|]; auto_derive; trivial; [ring|field; lra].
  Qed.

  Lemma slope_of_f t : is_derive f t (f' t).
  Proof.
    unfold f', f, w2, phi. destruct (Req_EM_T l e) as [<-|]; auto_derive; trivial; [ring|field; lra].
  Qed.

  Theorem E2 t : is_derive phi t (phi' t) /\ is_derive f t (f' t) /\ is_derive phi' t (phi'' t) /\ is_derive f' t (f'' t).
  Proof.
    pose proof (slope_of_phi t) as Hphi. pose proof (slope_of_f t) as Hf. split; [assumption|]. split; [assumption|]. split.
    - replace (phi'' t) with (f' t - S * phi' t) by (unfold phi'', f', phi'; ring).
      apply (is_derive_minus f (fun s => S * phi s)); [assumption|]. apply is_derive_scal. assumption.
    - replace (f'' t) with (- w2 * phi' t) by (unfold f'', phi'; ring).
      apply (is_derive_scal phi t (- w2)). assumption.
  Qed.

  Lemma at_0 : f 0 = 1 /\ phi 0 = 0.
  Proof.
    assert (Hphi : phi 0 = 0).
    { unfold phi. destruct (Req_EM_T l e); [ring|]. rewrite !Rmult_0_r. field. lra. }
    split; [|assumption]. unfold f. rewrite Hphi, !Rmult_0_r, Ropp_0, exp_0. ring.
  Qed.

  (** * The motion of a coordinate, and no other *)

  Definition coordinate (x0 v0 xd t : R) : R := xd + (x0 - xd) * f t + v0 * phi t.
  Definition velocity (x0 v0 xd t : R) : R := (x0 - xd) * f' t + v0 * phi' t.
  Definition acceleration (x0 v0 xd t : R) : R := (x0 - xd) * f'' t + v0 * phi'' t.

  (** x is a motion under the law x'' = -(lambda + eta) x' - lambda eta (x - xd) from x0 with the velocity v0, for t >= 0. *)
  Definition under_the_law (x0 v0 xd : R) (x x' x'' : R -> R) : Prop :=
    x 0 = x0 /\ x' 0 = v0 /\
    forall t, 0 <= t -> is_derive x t (x' t) /\ is_derive x' t (x'' t) /\ x'' t = - S * x' t - w2 * (x t - xd).

  Theorem coordinate_under_the_law x0 v0 xd :
    under_the_law x0 v0 xd (coordinate x0 v0 xd) (velocity x0 v0 xd) (acceleration x0 v0 xd).
  Proof.
    destruct at_0 as [Hf0 Hphi0]. unfold under_the_law, coordinate, velocity, acceleration.
    split; [rewrite Hf0, Hphi0; ring|]. split; [unfold f', phi'; rewrite Hf0, Hphi0; ring|].
    intros t _. destruct (E2 t) as [Hphi [Hf [Hphi' Hf']]]. split; [|split].
    - replace ((x0 - xd) * f' t + v0 * phi' t) with (0 + (x0 - xd) * f' t + v0 * phi' t) by ring.
      apply (is_derive_plus (fun s => xd + (x0 - xd) * f s) (fun s => v0 * phi s)).
      + apply (is_derive_plus (fun _ => xd) (fun s => (x0 - xd) * f s)); [apply @is_derive_const|].
        apply is_derive_scal. assumption.
      + apply is_derive_scal. assumption.
    - apply (is_derive_plus (fun s => (x0 - xd) * f' s) (fun s => v0 * phi' s)); apply is_derive_scal; assumption.
    - unfold f'', phi'', f', phi'. ring.
  Qed.

  (** e' + lambda e dies away with eta, e with lambda: from rest at 0 nothing comes. *)
  Lemma nothing_from_nothing y y' y'' : under_the_law 0 0 0 y y' y'' -> forall t, 0 <= t -> y t = 0.
  Proof.
    intros [Hy0 [Hy'0 H]].
    assert (Hsum : forall t, 0 <= t -> (y' t + l * y t) * exp (e * t) = 0).
    { intros t Ht. transitivity ((y' 0 + l * y 0) * exp (e * 0)); [|rewrite Hy0, Hy'0; ring].
      apply (constant_of_no_slope (fun s => (y' s + l * y s) * exp (e * s))); [|assumption].
      intros s Hs. destruct (H s Hs) as [Hy [Hy' Hlaw]].
      replace 0 with ((y'' s + l * y' s) * exp (e * s) + (y' s + l * y s) * (e * exp (e * s)))
        by (rewrite Hlaw; unfold S, w2; ring).
      apply (is_derive_mult (fun s => y' s + l * y s) (fun s => exp (e * s))); [| |intros; apply Rmult_comm].
      - apply (is_derive_plus y' (fun s => l * y s)); [|apply is_derive_scal]; assumption.
      - auto_derive; trivial. ring. }
    intros t Ht. apply (Rmult_eq_reg_r (exp (l * t))); [|apply Rgt_not_eq, exp_pos]. rewrite Rmult_0_l.
    transitivity (y 0 * exp (l * 0)); [|rewrite Hy0; ring].
    apply (constant_of_no_slope (fun s => y s * exp (l * s))); [|assumption].
    intros s Hs. destruct (H s Hs) as [Hy _].
    replace 0 with (y' s * exp (l * s) + y s * (l * exp (l * s))).
    - apply (is_derive_mult y (fun s => exp (l * s))); [assumption| |intros; apply Rmult_comm].
      auto_derive; trivial. ring.
    - transitivity ((y' s + l * y s) * exp (l * s)); [ring|].
      assert (y' s + l * y s = 0) as ->; [|ring].
      apply (Rmult_eq_reg_r (exp (e * s))); [|apply Rgt_not_eq, exp_pos]. rewrite (Hsum s Hs). ring.
  Qed.

  Theorem no_other_motion x0 v0 xd x x' x'' : under_the_law x0 v0 xd x x' x'' ->
    forall t, 0 <= t -> x t = coordinate x0 v0 xd t.
  Proof.
    intros [Hx0 [Hx'0 Hx]] t Ht. destruct (coordinate_under_the_law x0 v0 xd) as [Hc0 [Hc'0 Hc]].
    cut (x t - coordinate x0 v0 xd t = 0); [lra|].
    apply (nothing_from_nothing (fun s => x s - coordinate x0 v0 xd s) (fun s => x' s - velocity x0 v0 xd s)
             (fun s => x'' s - acceleration x0 v0 xd s)); [|assumption].
    split; [rewrite Hx0, Hc0; ring|]. split; [rewrite Hx'0, Hc'0; ring|].
    intros s Hs. destruct (Hx s Hs) as [H1 [H2 H3]]. destruct (Hc s Hs) as [K1 [K2 K3]]. split; [|split].
    - apply (is_derive_minus x (coordinate x0 v0 xd)); assumption.
    - apply (is_derive_minus x' (velocity x0 v0 xd)); assumption.
    - rewrite H3, K3. ring.
  Qed.

  (** * Signs *)

  (** Abel: the Wronskian. *)
  Lemma wronskian t : f t * phi' t - f' t * phi t = exp (- (S * t)).
  Proof.
    replace (- (S * t)) with (- (l * t) + - (e * t)) by (unfold S; ring). rewrite exp_plus, other_exponential.
    unfold phi', f', f, S, w2. ring.
  Qed.

  Lemma phi_not_negative t : 0 <= t -> 0 <= phi t.
  Proof.
    intros Ht. pose proof (exp_pos (- (l * t))). unfold phi. destruct (Req_EM_T l e) as [|Hne]; [nra|].
    assert (Horder : forall p q, p < q -> exp (- (q * t)) <= exp (- (p * t))).
    { intros p q Hpq. destruct Ht as [Ht|<-]; [left; apply exp_increasing; nra|rewrite !Rmult_0_r; lra]. }
    destruct (Rdichotomy _ _ Hne) as [H0|H0]; pose proof (Horder _ _ H0).
    - apply Rmult_le_pos; [lra|]. left. apply Rinv_0_lt_compat. lra.
    - replace ((exp (- (l * t)) - exp (- (e * t))) / (e - l)) with ((exp (- (e * t)) - exp (- (l * t))) / (l - e))
        by (field; lra).
      apply Rmult_le_pos; [lra|]. left. apply Rinv_0_lt_compat. lra.
  Qed.

  Lemma f_positive t : 0 <= t -> 0 < f t.
  Proof. intros Ht. pose proof (phi_not_negative t Ht). pose proof (exp_pos (- (l * t))). unfold f. nra. Qed.

  Lemma f_at_most_1 t : 0 <= t -> f t <= 1.
  Proof.
    destruct at_0 as [Hf0 _]. intros [Ht|<-]; [|lra].
    destruct (mean_slope f f' 0 t Ht) as [c [Hc Hslope]]; [intros; apply slope_of_f|].
    assert (f' c <= 0); [|nra]. unfold f', w2. pose proof (phi_not_negative c ltac:(lra)).
    assert (0 < l * e) by (apply Rmult_lt_0_compat; assumption). nra.
  Qed.
End Gains.
