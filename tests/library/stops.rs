//! Robots that are found in motion, and robots whose pose is lost in motion.

use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters, PlannerKind, Status};
use cable_robot::robot::{Coordinates, Pose};
use cable_robot::sim::{ClosedLoop, PlantParameters};

struct Run {
    joined: ClosedLoop,
    step: f64,
    /// For how long a cable was slack, s.
    slack: f64,
}

impl Run {
    fn new(planner: PlannerKind, gain: f64, step: f64, rates: &Coordinates) -> Self {
        let parameters = ControllerParameters { planner, lambda: gain, eta: gain, ..Default::default() };
        let joined = ClosedLoop::new(parameters, PlantParameters::default(), Pose::default()).unwrap();
        Self { joined: joined.moving(rates), step, slack: 0.0 }
    }

    /// One step with what `see` makes of the inputs.
    fn advance(&mut self, goal: Pose, see: impl Fn(&mut ControllerInputs)) {
        self.joined.goal = goal;
        let moment = self.joined.step_seeing(self.step, see).unwrap();
        self.slack += self.step * f64::from(moment.plant.slack != [false; 6]);
    }

    fn time(&self) -> f64 {
        self.joined.moment().time
    }

    fn pose(&self) -> Pose {
        self.joined.moment().plant.encoder_pose
    }

    fn outputs(&self) -> &ControllerOutputs {
        self.joined.controller.outputs()
    }

    fn speed(&self) -> f64 {
        self.joined.moment().plant.velocity.norm()
    }
}

/// A start at 0.3 m/s was taken for one at rest: AtGoal in the first step, 63 ms of slack.
#[test]
fn a_robot_that_starts_in_motion_is_brought_to_rest() {
    for planner in PlannerKind::ALL {
        for (gain, step) in [(3.0, 1e-3), (8.0, 1e-3), (8.0, 4e-3)] {
            for (x, y, z) in [(0.3, 0.0, 0.0), (0.0, -0.3, 0.0), (0.15, 0.2, -0.15)] {
                let rates = Coordinates::new(x, y, z, 0.0, 0.0, 0.0);
                let mut run = Run::new(planner, gain, step, &rates);
                // Elsewhere, so that a motion is begun that presumes rest.
                let is_fast = planner == PlannerKind::MinimumTime;
                let goal = if is_fast { Pose::at(0.1, 0.05, 1.0) } else { Pose::default() };
                let mut first_at_goal = None;
                while run.time() < 6.0 {
                    run.advance(goal, |_| ());
                    if run.outputs().at_goal && first_at_goal.is_none() && run.time() > 0.01 {
                        first_at_goal = Some(run.time());
                    }
                }
                let outputs = run.outputs();
                println!(
                    "{planner:?}, gains {gain}, {step} s, ({x}, {y}, {z}) m/s: slack for {:.3} s, first at the goal after {first_at_goal:?} s, {:?}",
                    run.slack, outputs.status
                );
                assert_eq!(run.slack, 0.0);
                assert!(first_at_goal.is_none_or(|time| time > 0.1), "{first_at_goal:?}");
                assert!(planner == PlannerKind::Bounded || outputs.status == Status::AtGoal, "{outputs:?}");
                assert!(run.speed() < 2e-3);
            }
        }
    }
}

/// After a fault in motion gravity was held at the last good pose: the robot went on at the speed that it had.
#[test]
fn a_robot_whose_pose_is_lost_in_motion_brakes() {
    for (planner, gain) in [(PlannerKind::Exact, 3.0), (PlannerKind::Exact, 8.0), (PlannerKind::Bounded, 3.0)]
    {
        let mut run = Run::new(planner, gain, 1e-3, &Coordinates::zeros());
        let goal = Pose::at(0.12, 0.08, 0.9);
        let goal = if planner == PlannerKind::Bounded { Pose::at(0.12, 0.08, 1.0) } else { goal };
        while run.time() < 1.0 / gain {
            run.advance(goal, |_| ());
        }
        let before = run.speed();
        let at = run.pose();
        while run.time() < 1.0 / gain + 8.0 / gain {
            run.advance(goal, |seen| seen.encoder_pose = Pose::at(0.4, 0.0, 1.0));
        }
        let way = (run.pose().position() - at.position()).norm();
        println!(
            "{planner:?}, gains {gain}: {before:.3} m/s, {:.4} m/s left, {way:.4} m farther, slack for {} s",
            run.speed(),
            run.slack
        );
        assert_eq!(run.outputs().status, Status::SensorFault);
        assert!(
            run.slack == 0.0 && before > 0.05 && run.speed() < 0.1 * before,
            "{} of {before} m/s",
            run.speed()
        );
    }
}
