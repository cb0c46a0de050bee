(** Sums, vectors and square systems over the reals, of any size.

    A vector of size n is a function of which the values below n count; so is a matrix. *)

Require Import Reals Lra Lia.
Open Scope R_scope.

Definition vector := nat -> R.
Definition matrix := nat -> nat -> R.

(** x_0 + ... + x_(n-1) *)
Fixpoint sum (n : nat) (x : vector) : R :=
  match n with
  | O => 0
  | S k => sum k x + x k
  end.

(** M x, the columns of M being n; M N, the columns of M (rows of N) being n. *)
Definition times (n : nat) (M : matrix) (x : vector) : vector := fun k => sum n (fun j => M k j * x j).
Definition product (n : nat) (M N : matrix) : matrix := fun k j => sum n (fun i => M k i * N i j).
Definition one : matrix := fun k j => if Nat.eqb k j then 1 else 0.
Definition minus (x y : vector) : vector := fun k => x k - y k.
Definition equal (n : nat) (x y : vector) : Prop := forall k, (k < n)%nat -> x k = y k.

(** M x = w has exactly one solution, whatever w is. *)
Definition regular (n : nat) (M : matrix) : Prop :=
  forall w, exists x, equal n (times n M x) w /\ forall x', equal n (times n M x') w -> equal n x' x.

(** M x = 0 for x = 0 only. *)
Definition injective (n : nat) (M : matrix) : Prop :=
  forall x, (forall k, (k < n)%nat -> times n M x k = 0) -> forall k, (k < n)%nat -> x k = 0.

(** * Sums *)

Lemma sum_equal n x y : equal n x y -> sum n x = sum n y.
Proof.
  induction n as [|n IH]; intros H; simpl; [reflexivity|].
  rewrite IH, (H n) by (try lia; intros k Hk; apply H; lia). reflexivity.
Qed.

Lemma sum_zero n x : (forall k, (k < n)%nat -> x k = 0) -> sum n x = 0.
Proof. induction n as [|n IH]; intros H; simpl; [reflexivity|]. rewrite IH, H by auto. lra. Qed.

Lemma sum_plus n x y : sum n (fun k => x k + y k) = sum n x + sum n y.
Proof. induction n as [|n IH]; simpl; [lra|]. rewrite IH. lra. Qed.

Lemma sum_scaled n c x : sum n (fun k => c * x k) = c * sum n x.
Proof. induction n as [|n IH]; simpl; [lra|]. rewrite IH. lra. Qed.

Lemma sum_minus n x y : sum n (fun k => x k - y k) = sum n x - sum n y.
Proof. induction n as [|n IH]; simpl; [lra|]. rewrite IH. lra. Qed.

Lemma sum_at_most n x y : (forall k, (k < n)%nat -> x k <= y k) -> sum n x <= sum n y.
Proof.
  induction n as [|n IH]; intros H; simpl; [lra|].
  assert (sum n x <= sum n y) by (apply IH; intros; apply H; lia).
  assert (x n <= y n) by (apply H; lia). lra.
Qed.

Lemma abs_of_sum n x : Rabs (sum n x) <= sum n (fun k => Rabs (x k)).
Proof.
  induction n as [|n IH]; simpl; [rewrite Rabs_R0; lra|].
  eapply Rle_trans; [apply Rabs_triang|lra].
Qed.

Lemma sum_exchanged n m (M : matrix) :
  sum n (fun k => sum m (fun j => M k j)) = sum m (fun j => sum n (fun k => M k j)).
Proof.
  induction n as [|n IH]; simpl; [symmetry; apply sum_zero; reflexivity|].
  rewrite IH. symmetry. apply sum_plus.
Qed.

(** * Products *)

Lemma times_plus n M x y k : times n M (fun j => x j + y j) k = times n M x k + times n M y k.
Proof. unfold times. rewrite <- sum_plus. apply sum_equal. intros j _. lra. Qed.

Lemma times_minus n M x y k : times n M (minus x y) k = times n M x k - times n M y k.
Proof. unfold times, minus. rewrite <- sum_minus. apply sum_equal. intros j _. lra. Qed.

Lemma times_one n x k : (k < n)%nat -> times n one x k = x k.
Proof.
  unfold times, one. induction n as [|n IH]; intros Hk; simpl; [lia|].
  destruct (Nat.eqb_spec k n) as [->|Hne].
  - rewrite sum_zero; [lra|]. intros j Hj. destruct (Nat.eqb_spec n j); [lia|lra].
  - rewrite IH by lia. lra.
Qed.

Lemma times_product n m M N x k : times m (product n M N) x k = times n M (times m N x) k.
Proof.
  unfold times, product.
  transitivity (sum m (fun j => sum n (fun i => M k i * N i j * x j))).
  - apply sum_equal. intros j _. rewrite Rmult_comm, <- sum_scaled. apply sum_equal. intros i _. lra.
  - rewrite sum_exchanged. apply sum_equal. intros i _. rewrite <- sum_scaled. apply sum_equal. intros j _. lra.
Qed.

(** * A square matrix that is injective is regular *)

(** Either a column of m rows is zero, or some entry is not. *)
Lemma zero_or_not m (x : vector) :
  (forall k, (k < m)%nat -> x k = 0) \/ (exists i, (i < m)%nat /\ x i <> 0).
Proof.
  induction m as [|m [IH|[i [Hi Hx]]]]; [left; lia| |right; exists i; split; [lia|assumption]].
  destruct (Req_dec (x m) 0) as [H0|H0]; [left|right; exists m; split; [lia|assumption]].
  intros k Hk. destruct (Nat.eq_dec k m) as [->|]; [assumption|apply IH; lia].
Qed.

(** The row k of those that are left without row i. *)
Definition without (i k : nat) : nat := if Nat.ltb k i then k else S k.

(** Fewer equations than unknowns have a solution that is not zero (Gauss' elimination of the last unknown). *)
Lemma underdetermined m : forall n (M : matrix), (m < n)%nat ->
  exists x, (exists j, (j < n)%nat /\ x j <> 0) /\ (forall k, (k < m)%nat -> sum n (fun j => M k j * x j) = 0).
Proof.
  induction m as [|m IH]; intros n M Hn.
  { exists (fun _ => 1). split; [exists O; split; [lia|lra]|lia]. }
  destruct n as [|n]; [lia|].
  destruct (zero_or_not (S m) (fun k => M k n)) as [Hzero|[i [Hi Hpivot]]].
  - exists (fun j => if Nat.eqb j n then 1 else 0). split.
    + exists n. rewrite Nat.eqb_refl. split; [lia|lra].
    + intros k Hk. simpl. rewrite Nat.eqb_refl, (Hzero k Hk), sum_zero; [lra|].
      intros j Hj. destruct (Nat.eqb_spec j n); [lia|lra].
  - destruct (IH n (fun k j => M (without i k) j - M (without i k) n / M i n * M i j)) as [x [[j [Hj Hx]] Hsolves]];
      [lia|].
    set (last := - sum n (fun j => M i j * x j) / M i n).
    exists (fun j => if Nat.ltb j n then x j else last).
    assert (Hsum : forall k, sum (S n) (fun j => M k j * (if Nat.ltb j n then x j else last))
                             = sum n (fun j => M k j * x j) + M k n * last).
    { intros k. simpl. rewrite Nat.ltb_irrefl. f_equal. apply sum_equal. intros l Hl.
      destruct (Nat.ltb_spec l n); [reflexivity|lia]. }
    split.
    + exists j. destruct (Nat.ltb_spec j n); [split; [lia|assumption]|lia].
    + intros k Hk. rewrite Hsum. destruct (Nat.eq_dec k i) as [->|Hne]; [unfold last; field; assumption|].
      assert (Hrow : exists l, (l < m)%nat /\ without i l = k).
      { unfold without. destruct (Nat.ltb_spec k i).
        - exists k. destruct (Nat.ltb_spec k i); split; lia.
        - exists (pred k). destruct (Nat.ltb_spec (pred k) i); split; lia. }
      destruct Hrow as [l [Hl <-]]. specialize (Hsolves l Hl). simpl in Hsolves.
      rewrite (sum_equal n _ (fun j => M (without i l) j * x j
                                       - M (without i l) n / M i n * (M i j * x j))) in Hsolves
        by (intros ? _; ring).
      rewrite sum_minus, sum_scaled in Hsolves. unfold last.
      replace (sum n (fun j => M (without i l) j * x j))
        with (M (without i l) n / M i n * sum n (fun j => M i j * x j)) by lra.
      field. assumption.
Qed.

Lemma injective_is_regular n M : injective n M -> regular n M.
Proof.
  intros Hinjective w.
  destruct (underdetermined n (S n) (fun k j => if Nat.ltb j n then M k j else w k)) as [x [[j [Hj Hx]] Hsolves]];
    [lia|].
  assert (Hrow : forall k, (k < n)%nat -> times n M x k + w k * x n = 0).
  { intros k Hk. rewrite <- (Hsolves k Hk). simpl. rewrite Nat.ltb_irrefl. f_equal. unfold times.
    apply sum_equal. intros l Hl. destruct (Nat.ltb_spec l n); [reflexivity|lia]. }
  assert (Hlast : x n <> 0).
  { intros H0. apply Hx. destruct (Nat.eq_dec j n) as [->|]; [assumption|].
    apply Hinjective; [|lia]. intros k Hk. specialize (Hrow k Hk). rewrite H0 in Hrow. lra. }
  exists (fun k => - / x n * x k). split.
  - intros k Hk. unfold times.
    rewrite (sum_equal n _ (fun j => - / x n * (M k j * x j))) by (intros ? _; ring).
    rewrite sum_scaled. fold (times n M x k). specialize (Hrow k Hk).
    replace (times n M x k) with (- (w k * x n)) by lra. field. assumption.
  - intros x' Hx' k Hk. set (solution := fun k => - / x n * x k).
    cut (minus x' solution k = 0); [unfold minus, solution; lra|].
    apply Hinjective; [|assumption]. intros l Hl. rewrite times_minus, (Hx' l Hl). unfold times, solution.
    rewrite (sum_equal n _ (fun j => - / x n * (M l j * x j))) by (intros ? _; ring).
    rewrite sum_scaled. fold (times n M x l). specialize (Hrow l Hl).
    replace (times n M x l) with (- (w l * x n)) by lra. field. assumption.
Qed.
