(** The paper's geometry: six cables between two equilateral triangles, the platform level (zero orientation).

    Base frame, origin at the centre of the base, z down. The tables are those of src/robot/triangles.rs. *)

Require Import Reals Lra.
Open Scope R_scope.

Record vec := Vec { x_of : R; y_of : R; z_of : R }.

Definition plus (v w : vec) : vec := Vec (x_of v + x_of w) (y_of v + y_of w) (z_of v + z_of w).
Definition minus (v w : vec) : vec := Vec (x_of v - x_of w) (y_of v - y_of w) (z_of v - z_of w).
Definition scale (c : R) (v : vec) : vec := Vec (c * x_of v) (c * y_of v) (c * z_of v).
Definition dot (v w : vec) : R := x_of v * x_of w + y_of v * y_of w + z_of v * z_of w.
Definition cross (v w : vec) : vec :=
  Vec (y_of v * z_of w - z_of v * y_of w) (z_of v * x_of w - x_of v * z_of w) (x_of v * y_of w - y_of v * x_of w).
Definition zero : vec := Vec 0 0 0.
Definition down : vec := Vec 0 0 1.

Inductive cable := c1 | c2 | c3 | c4 | c5 | c6.

Definition total (x : cable -> R) : R := x c1 + x c2 + x c3 + x c4 + x c5 + x c6.
Definition resultant (v : cable -> vec) : vec :=
  Vec (total (fun i => x_of (v i))) (total (fun i => y_of (v i))) (total (fun i => z_of (v i))).

(** Cosine and sine of the azimuths of the vertices. Base: 300, 300, 60, 60, 180, 180 degrees. *)
Definition base_azimuth (i : cable) : vec :=
  match i with
  | c1 | c2 => Vec (1 / 2) (- (sqrt 3 / 2)) 0
  | c3 | c4 => Vec (1 / 2) (sqrt 3 / 2) 0
  | c5 | c6 => Vec (-1) 0 0
  end.

(** Platform: 240, 0, 0, 120, 120, 240 degrees. *)
Definition platform_azimuth (i : cable) : vec :=
  match i with
  | c1 | c6 => Vec (- (1 / 2)) (- (sqrt 3 / 2)) 0
  | c2 | c3 => Vec 1 0 0
  | c4 | c5 => Vec (- (1 / 2)) (sqrt 3 / 2) 0
  end.

(** Outward normals n_i of the facets of the static workspace: 150, 90, -90, 210, 30, -30 degrees. *)
Definition normal (i : cable) : vec :=
  match i with
  | c1 => Vec (- (sqrt 3 / 2)) (1 / 2) 0
  | c2 => Vec 0 1 0
  | c3 => Vec 0 (-1) 0
  | c4 => Vec (- (sqrt 3 / 2)) (- (1 / 2)) 0
  | c5 => Vec (sqrt 3 / 2) (1 / 2) 0
  | c6 => Vec (sqrt 3 / 2) (- (1 / 2)) 0
  end.

(** Anchors A_i and attachments b_i: triangles of sides 2 a and 2 b, whose circumscribed circles have radii 2 a/sqrt 3 and 2 b/sqrt 3. *)
Definition anchor (a : R) (i : cable) : vec := scale (2 * a / sqrt 3) (base_azimuth i).
Definition attachment (b : R) (i : cable) : vec := scale (2 * b / sqrt 3) (platform_azimuth i).

(** From the attachment of cable i to its anchor, A_i - P - b_i, and its length l_i. *)
Definition along (a b : R) (P : vec) (i : cable) : vec := minus (minus (anchor a i) P) (attachment b i).
Definition length (a b : R) (P : vec) (i : cable) : R := sqrt (dot (along a b P i) (along a b P i)).

(** * Coordinates of the vertices *)

Lemma sqrt_3_positive : 0 < sqrt 3.
Proof. apply sqrt_lt_R0. lra. Qed.

Lemma sqrt_3_squared : sqrt 3 * sqrt 3 = 3.
Proof. apply sqrt_sqrt. lra. Qed.

Lemma over_sqrt_3 c : c / sqrt 3 = c * sqrt 3 / 3.
Proof. pose proof sqrt_3_positive. rewrite <- sqrt_3_squared at 3. field. lra. Qed.

Lemma anchor_is a i : anchor a i =
  match i with
  | c1 | c2 => Vec (a * sqrt 3 / 3) (- a) 0
  | c3 | c4 => Vec (a * sqrt 3 / 3) a 0
  | c5 | c6 => Vec (- 2 * a * sqrt 3 / 3) 0 0
  end.
Proof.
  pose proof sqrt_3_squared as Hs. unfold anchor, scale. rewrite over_sqrt_3.
  destruct i; simpl; f_equal; field [Hs].
Qed.

Lemma attachment_is b i : attachment b i =
  match i with
  | c1 | c6 => Vec (- b * sqrt 3 / 3) (- b) 0
  | c2 | c3 => Vec (2 * b * sqrt 3 / 3) 0 0
  | c4 | c5 => Vec (- b * sqrt 3 / 3) b 0
  end.
Proof.
  pose proof sqrt_3_squared as Hs. unfold attachment, scale. rewrite over_sqrt_3.
  destruct i; simpl; f_equal; field [Hs].
Qed.

Definition distance (v w : vec) : R := sqrt (dot (minus v w) (minus v w)).

(** The triangles are equilateral, of sides 2 a and 2 b. *)
Lemma triangles_are_equilateral a b : 0 <= a -> 0 <= b ->
  distance (anchor a c1) (anchor a c3) = 2 * a /\
  distance (anchor a c3) (anchor a c5) = 2 * a /\
  distance (anchor a c5) (anchor a c1) = 2 * a /\
  distance (attachment b c1) (attachment b c3) = 2 * b /\
  distance (attachment b c3) (attachment b c5) = 2 * b /\
  distance (attachment b c5) (attachment b c1) = 2 * b.
Proof.
  intros Ha Hb. unfold distance, dot, minus.
  assert (Hroot : forall x c, 0 <= c -> x = c * c -> sqrt x = c) by (intros x c Hc ->; apply sqrt_square; exact Hc).
  pose proof sqrt_3_squared as Hs.
  repeat split; apply Hroot; try lra; rewrite ?anchor_is, ?attachment_is; simpl; field [Hs].
Qed.

(** No cable is shorter than the platform is below the base. *)
Lemma length_at_least_z a b P i : Rabs (z_of P) <= length a b P i.
Proof.
  unfold length. rewrite <- sqrt_Rsqr_abs. apply sqrt_le_1_alt. unfold dot, Rsqr.
  replace (z_of (along a b P i)) with (- z_of P)
    by (unfold along, minus; rewrite anchor_is, attachment_is; destruct i; simpl; ring).
  nra.
Qed.

Lemma length_positive a b P i : z_of P <> 0 -> 0 < length a b P i.
Proof.
  intros Hz. pose proof (length_at_least_z a b P i). pose proof (Rabs_pos_lt _ Hz). lra.
Qed.
