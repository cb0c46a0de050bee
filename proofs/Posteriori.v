(** The lemma of docs/proof.md: how far an approximate solution is from the exact one, known afterwards (a posteriori).

    It holds for any number n of equations and unknowns (there 6) and any number p of cables. *)

Require Import Reals Lra Lia.
From CableRobot Require Import Linear.
Open Scope R_scope.

(** max (x_0, ..., x_(n-1)) of numbers that are not negative; 0 of none. *)
Fixpoint largest (n : nat) (x : vector) : R :=
  match n with
  | O => 0
  | S k => Rmax (largest k x) (x k)
  end.

Lemma at_most_largest n x k : (k < n)%nat -> x k <= largest n x.
Proof.
  induction n as [|n IH]; intros Hk; simpl; [lia|].
  destruct (Nat.eq_dec k n) as [->|]; [apply Rmax_r|].
  eapply Rle_trans; [apply IH; lia|apply Rmax_l].
Qed.

Lemma largest_at_least_0 n x : 0 <= largest n x.
Proof. induction n as [|n IH]; simpl; [lra|]. eapply Rle_trans; [apply IH|apply Rmax_l]. Qed.

Lemma largest_at_most n x c : 0 <= c -> (forall k, (k < n)%nat -> x k <= c) -> largest n x <= c.
Proof.
  intros Hc. induction n as [|n IH]; intros H; simpl; [assumption|].
  apply Rmax_lub; [apply IH; intros; apply H; lia|apply H; lia].
Qed.

Section Defect.
  Variable n : nat.
  Variable A : matrix.

  (** D = 1 - A and rho = max_k sum_j |D_kj|, at least 0. *)
  Definition defect : matrix := fun k j => one k j - A k j.
  Definition row (k : nat) : R := sum n (fun j => Rabs (defect k j)).
  Definition rho : R := largest n row.

  Definition size (e : vector) : R := largest n (fun j => Rabs (e j)).

  Lemma defect_times e k : (k < n)%nat -> times n defect e k = e k - times n A e k.
  Proof.
    intros Hk. rewrite <- (times_one n e k Hk) at 1. unfold times, defect.
    rewrite <- sum_minus. apply sum_equal. intros j _. lra.
  Qed.

  Lemma abs_of_defect_times e k : Rabs (times n defect e k) <= row k * size e.
  Proof.
    unfold times, row. eapply Rle_trans; [apply abs_of_sum|].
    rewrite Rmult_comm, <- sum_scaled. apply sum_at_most. intros j Hj.
    rewrite Rabs_mult, Rmult_comm.
    apply Rmult_le_compat_r; [apply Rabs_pos|apply (at_most_largest n (fun i => Rabs (e i)) j Hj)].
  Qed.

  Hypothesis Hrho : rho < 1.

  (** e = r + D e, taken once: max |e| <= max |r| / (1 - rho). *)
  Lemma size_of_error e r : equal n (times n A e) r -> size e <= size r / (1 - rho).
  Proof.
    intros HA. assert (0 <= size e) by apply largest_at_least_0. assert (0 <= size r) by apply largest_at_least_0.
    assert (Hstep : size e <= size r + rho * size e).
    { apply largest_at_most.
      { assert (0 <= rho) by apply largest_at_least_0. nra. }
      intros k Hk. replace (e k) with (r k + times n defect e k) by (rewrite defect_times, (HA k Hk); lra || assumption).
      eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat.
      - apply (at_most_largest n (fun i => Rabs (r i)) k Hk).
      - eapply Rle_trans; [apply abs_of_defect_times|].
        apply Rmult_le_compat_r; [assumption|apply (at_most_largest n row k Hk)]. }
    apply (Rmult_le_reg_r (1 - rho)); [lra|]. unfold Rdiv. rewrite Rmult_assoc, Rinv_l by lra. lra.
  Qed.

  (** Taken twice. *)
  Lemma error e r k : (k < n)%nat -> equal n (times n A e) r ->
    Rabs (e k) <= Rabs (r k) + row k * size r / (1 - rho).
  Proof.
    intros Hk HA. replace (e k) with (r k + times n defect e k) by (rewrite defect_times, (HA k Hk); lra || assumption).
    eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat_l.
    eapply Rle_trans; [apply abs_of_defect_times|]. unfold Rdiv. rewrite Rmult_assoc. apply Rmult_le_compat_l.
    - unfold row. rewrite <- (sum_zero n (fun _ => 0)) by reflexivity. apply sum_at_most. intros. apply Rabs_pos.
    - apply size_of_error. assumption.
  Qed.

  Lemma injective_of_defect : injective n A.
  Proof.
    intros e HA k Hk. assert (Hsize : size e <= size (fun _ => 0) / (1 - rho)) by (apply size_of_error; exact HA).
    assert (H0 : size (fun _ => 0) = 0).
    { apply Rle_antisym; [|apply largest_at_least_0]. apply largest_at_most; [lra|]. intros. rewrite Rabs_R0. lra. }
    rewrite H0 in Hsize. unfold Rdiv in Hsize. rewrite Rmult_0_l in Hsize.
    assert (Rabs (e k) <= size e) by apply (at_most_largest n (fun i => Rabs (e i)) k Hk).
    destruct (Req_dec (e k) 0) as [|Hne]; [assumption|]. assert (0 < Rabs (e k)) by (apply Rabs_pos_lt; assumption). lra.
  Qed.
End Defect.

(** The lemma as docs/proof.md has it, n equations, p cables: A = C V B, b = C (w - V sigma), D = 1 - A, r = b - A y^. *)
Theorem lemma_a_posteriori (n p : nat) (C V B : matrix) (w sigma guess : vector) :
  let VB := product p V B in
  let rest := minus w (times p V sigma) in
  let A := product n C VB in
  let r := minus (times n C rest) (times n A guess) in
  let D := defect A in
  largest n (fun k => sum n (fun j => Rabs (D k j))) < 1 ->
  regular n A /\ regular n VB /\
  exists y, equal n (times n VB y) rest /\ (forall y', equal n (times n VB y') rest -> equal n y' y) /\
    forall k, (k < n)%nat ->
      Rabs (y k - guess k)
      <= Rabs (r k) + sum n (fun j => Rabs (D k j)) * largest n (fun j => Rabs (r j))
                      / (1 - largest n (fun k => sum n (fun j => Rabs (D k j)))).
Proof.
  intros VB rest A r D Hrho.
  assert (HA : injective n A) by exact (injective_of_defect n A Hrho).
  assert (HVB : injective n VB).
  { intros x Hx. apply HA. intros k Hk. unfold A. rewrite times_product. apply sum_zero.
    intros j Hj. rewrite (Hx j Hj). lra. }
  pose proof (injective_is_regular n VB HVB) as Hregular.
  split; [apply injective_is_regular; assumption|]. split; [assumption|].
  destruct (Hregular rest) as [y [Hy Honly]]. exists y. split; [assumption|]. split; [assumption|].
  intros k Hk. apply (error n A Hrho (minus y guess) r k Hk). intros l Hl. rewrite times_minus. unfold r, minus at 1.
  f_equal. unfold A. rewrite times_product. apply sum_equal. intros j Hj. rewrite (Hy j Hj). reflexivity.
Qed.

(** Then s = sigma + B y are force densities that do it: V s = w. *)
Theorem densities_of_solution (n p : nat) (V B : matrix) (w sigma y : vector) :
  equal n (times n (product p V B) y) (minus w (times p V sigma)) ->
  equal n (times p V (fun i => sigma i + times n B y i)) w.
Proof.
  intros H k Hk. rewrite times_plus, <- times_product, (H k Hk). unfold minus. lra.
Qed.
