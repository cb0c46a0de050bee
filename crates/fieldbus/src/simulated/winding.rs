//! How much cable a winch has paid out: as much as the straight line is long, or more, and then it turns freely.

/// Mass of a free-running motor and drum, felt at the cable, as a share of the platform's.
pub(super) const MASS: f64 = 0.01;

/// The cable of one winch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Winding {
    /// m, from anchor to attachment.
    pub paid_out: f64,
    /// m/s, while it is slack.
    speed: f64,
    is_slack: bool,
}

impl Winding {
    /// Taut, with this length (m).
    pub fn taut(length: f64) -> Self {
        Self { paid_out: length, speed: 0.0, is_slack: false }
    }

    /// At rest with more than the straight line takes (m).
    pub fn slack(length: f64) -> Self {
        Self { is_slack: true, ..Self::taut(length) }
    }

    /// What the platform feels if the motor is to pull `pull`, N.
    pub fn tension(&self, pull: f64) -> f64 {
        if self.is_slack { 0.0 } else { pull.max(0.0) }
    }

    /// `h` seconds of this pull (N, below 0 outwards), against friction (N), with so much mass felt at the cable (kg).
    pub fn turn(&mut self, pull: f64, straight: f64, friction: f64, mass: f64, h: f64) {
        if !self.is_slack && pull >= 0.0 {
            return *self = Self::taut(straight);
        }
        let speed = self.speed - h * pull / mass;
        self.speed = speed.signum() * (speed.abs() - h * friction / mass).max(0.0);
        self.paid_out += h * self.speed;
        self.is_slack = true;
        if self.paid_out <= straight {
            *self = Self::taut(straight);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slack_cable_pulls_nothing_until_its_winch_has_taken_it_in() {
        let mut winding = Winding::slack(1.012);
        let mut steps = 0;
        while winding.is_slack {
            assert_eq!(winding.tension(0.5), 0.0);
            winding.turn(0.5, 1.0, 0.2, 0.06, 1e-3);
            steps += 1;
        }
        // 5 m/s² over 12 mm.
        assert!((68..=70).contains(&steps), "{steps}");
        assert_eq!(winding.tension(0.5), 0.5);
        winding.turn(0.5, 0.9, 0.2, 0.06, 1e-3);
        assert_eq!((winding.paid_out, winding.is_slack), (0.9, false), "hauled in");
    }

    #[test]
    fn a_torque_the_wrong_way_pays_out_and_a_small_one_does_not() {
        let mut winding = Winding::taut(1.0);
        (0..100).for_each(|_| winding.turn(-0.1, 1.0, 0.2, 0.06, 1e-3));
        assert!(!winding.is_slack && winding.paid_out == 1.0);
        (0..100).for_each(|_| winding.turn(-0.5, 1.0, 0.2, 0.06, 1e-3));
        assert!(winding.paid_out > 1.02 && winding.tension(3.0) == 0.0, "{winding:?}");
    }
}
