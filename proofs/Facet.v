(** G_i of docs/exact.md, (E1), with the sign of the tension of cable i. *)

Require Import Reals.
From CableRobot Require Import Geometry.
Open Scope R_scope.

(** G_i = (g - z'')(a/2 - n_i . P) - z n_i . P''; n_i is horizontal. *)
Definition facet (a g : R) (i : cable) (P P'' : vec) : R :=
  (g - z_of P'') * (a / 2 - dot (normal i) P) - z_of P * dot (normal i) P''.
