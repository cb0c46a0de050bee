(** What each theorem rests on. `proofs/check` compares the answers with the axioms that Coq's reals bring. *)

From CableRobot Require Import Posteriori Tensions Motion Curve Domain OneStep.

Print Assumptions lemma_a_posteriori.
Print Assumptions densities_of_solution.
Print Assumptions regular_off_the_base.
Print Assumptions E1.
Print Assumptions taut_when_facet_positive.
Print Assumptions E2.
Print Assumptions coordinate_under_the_law.
Print Assumptions no_other_motion.
Print Assumptions before_E3.
Print Assumptions E3.
Print Assumptions curve_tends.
Print Assumptions curve_has_minimum.
Print Assumptions height_has_minimum.
Print Assumptions theorem_1.
Print Assumptions theorem_2.
Print Assumptions psi_between_0_and_1.
Print Assumptions static_workspace.
Print Assumptions theorem_3.
