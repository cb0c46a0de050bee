//! A piece of a motion along a line with s'' = a + β (s - s₀): in closed form, and what a row of them makes.

use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};

use crate::reach::certificate::part::{Part, along};
use crate::reach::certificate::section::Section;
use crate::robot::memory::are_finite;

/// Intervals of a way on the grid; a line that would have more in closed form is planned there.
pub const MOST_ARCS: usize = 64;

/// From the position `s` (m) with the speed `v` (m/s) on: s'' = `a` + `beta` (s(t) - `s`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arc {
    /// When it begins, s after the start of the motion.
    pub begin: f64,
    /// m.
    pub s: f64,
    /// m/s.
    pub v: f64,
    /// m/s².
    pub a: f64,
    /// 1/s².
    pub beta: f64,
}

/// Position, speed and acceleration on the line: m, m/s, m/s².
pub type Along = [f64; 3];

impl Arc {
    /// `t` seconds after its beginning.
    pub fn at(&self, t: f64) -> Along {
        along([self.s, self.v, self.a], self.beta, t)
    }

    /// The same from `t` seconds after its beginning on, along a section of a way.
    pub fn part(&self, section: &Section, t: f64) -> Part {
        let [s, v, a] = self.at(t);
        Part { section: *section, s, v, a, beta: self.beta, jerk: 0.0 }
    }

    /// How long it takes to go `ds` (m) farther, where it has the speed `v1` (m/s, 0 or greater). Neither a nor the speed change sign on the way.
    pub fn time(&self, ds: f64, v1: f64) -> f64 {
        let (v0, a0, r) = (self.v, self.a, self.beta.abs().sqrt());
        if ds <= 0.0 {
            return 0.0;
        }
        let a1 = a0 + self.beta * ds;
        // Without the difference of two speeds that are nearly the same.
        let dv = (2.0 * a0 + self.beta * ds) * ds / (v0 + v1);
        let da = self.beta * ds;
        if r * (v0 + v1) <= TINY * a0.abs().max(a1.abs()) {
            2.0 * ds / (v0 + v1)
        } else if self.beta < 0.0 {
            libm::atan2(r * (a0 * dv - da * v0), a0 * a1 + r * r * v0 * v1) / r
        } else if a0 >= 0.0 {
            // ln[(a₁ + r v₁)/(a₀ + r v₀)]/r
            libm::log1p((da + r * dv) / (a0 + r * v0)) / r
        } else {
            // Braking, where that cancels: ln[(a₀ - r v₀)/(a₁ - r v₁)]/r
            libm::log1p((r * dv - da) / (a1 - r * v1)) / r
        }
    }
}

/// Below this β is none: 2 ds/(v₀ + v₁) is right to its square.
const TINY: f64 = 1e-9;

/// A motion to rest along a line: arcs, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    arcs: ArrayVec<Arc, MOST_ARCS>,
    /// Where it ends, m.
    pub end: f64,
    /// When, s after its start.
    pub duration: f64,
}

impl Timing {
    /// Whether a run can have left this.
    pub(super) fn is_sound(&self) -> bool {
        self.arcs.iter().all(|arc| are_finite(&[arc.begin, arc.s, arc.v, arc.a, arc.beta]))
            && self.end.is_finite()
            && self.duration.is_finite()
    }

    /// At rest at `s`.
    pub(super) fn begun_at(s: f64) -> Self {
        Self { end: s, ..Self::default() }
    }

    /// Adds the arc from the end so far, with the speed `v` (m/s), on to `to` (m), where it has the speed `v1`. Where there is no room for it the end stays where it is.
    pub(super) fn push(&mut self, v: f64, [a, beta]: [f64; 2], to: f64, v1: f64) {
        if self.is_full() {
            return;
        }
        let arc = Arc { begin: self.duration, s: self.end, v, a, beta };
        let time = arc.time(to - self.end, v1);
        self.end = to;
        // Rounding may leave an arc without speed.
        if time.is_finite() {
            self.arcs.push(arc);
            self.duration += time;
        }
    }

    /// Adds the arc with the speed `v` (m/s) and s'' = `a` (m/s²) from the end so far, for so many seconds.
    pub(super) fn push_for(&mut self, v: f64, a: f64, time: f64) {
        let arc = Arc { begin: self.duration, s: self.end, v, a, beta: 0.0 };
        if self.arcs.try_push(arc).is_ok() {
            self.end += (v + 0.5 * a * time) * time;
            self.duration += time;
        }
    }

    /// The most that s'' changes by, rest before and after included, m/s².
    pub(super) fn change(&self) -> f64 {
        let ends = self.spans().flat_map(|(arc, duration)| [arc.a, arc.at(duration)[2]]);
        let [least, greatest] =
            ends.fold([0.0, 0.0], |[least, greatest], a: f64| [a.min(least), a.max(greatest)]);
        greatest - least
    }

    /// Its beginning, as far as `t` seconds.
    pub(super) fn until(&self, t: f64) -> Self {
        let arcs = self.arcs.iter().filter(|arc| arc.begin < t).copied().collect();
        Self { arcs, end: self.at(t)[0], duration: t }
    }

    /// The same motion, so many times as slow.
    pub(super) fn slowed(mut self, times: f64) -> Self {
        for Arc { begin, v, a, beta, .. } in &mut self.arcs {
            (*begin, *v) = (*begin * times, *v / times);
            (*a, *beta) = (*a / (times * times), *beta / (times * times));
        }
        self.duration *= times;
        self
    }

    /// The same from the same speed on, so many times as far and as long.
    pub(super) fn stretched(mut self, times: f64) -> Self {
        let start = self.start();
        for Arc { begin, s, a, beta, .. } in &mut self.arcs {
            (*begin, *s) = (*begin * times, start + (*s - start) * times);
            (*a, *beta) = (*a / times, *beta / (times * times));
        }
        (self.end, self.duration) = (start + (self.end - start) * times, self.duration * times);
        self
    }

    /// And then another; `None` where there is no room for its arcs.
    pub(super) fn followed_by(mut self, other: &Self) -> Option<Self> {
        for arc in &other.arcs {
            self.arcs.try_push(Arc { begin: self.duration + arc.begin, ..*arc }).ok()?;
        }
        Some(Self { end: other.end, duration: self.duration + other.duration, ..self })
    }

    /// Where it begins, m.
    pub(super) fn start(&self) -> f64 {
        self.arcs.first().map_or(self.end, |arc| arc.s)
    }

    /// Whether there is no room for an arc.
    pub(super) fn is_full(&self) -> bool {
        self.arcs.is_full()
    }

    /// The same motion with all of s divided by a number.
    pub(super) fn over(mut self, by: f64) -> Self {
        for arc in &mut self.arcs {
            (arc.s, arc.v, arc.a) = (arc.s / by, arc.v / by, arc.a / by);
        }
        self.end /= by;
        self
    }

    /// The arcs.
    pub fn arcs(&self) -> &[Arc] {
        &self.arcs
    }

    /// The arcs, each with how long it takes, s.
    pub fn spans(&self) -> impl Iterator<Item = (&Arc, f64)> {
        let ends = self.arcs.iter().skip(1).map(|next| next.begin).chain([self.duration]);
        self.arcs.iter().zip(ends).map(|(arc, end)| (arc, end - arc.begin))
    }

    /// Where the motion is `t` seconds after its start: at rest at its end from then on.
    pub fn at(&self, t: f64) -> Along {
        match self.arcs.iter().rfind(|arc| arc.begin <= t) {
            Some(arc) if t < self.duration => arc.at(t - arc.begin),
            Some(_) => [self.end, 0.0, 0.0],
            None => self.arcs.first().map_or([self.end, 0.0, 0.0], |first| first.at(0.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// s'' = a + β (s - s₀) integrated by Runge and Kutta's method.
    fn integrated(arc: &Arc, time: f64) -> [f64; 2] {
        let acceleration = |s: f64| arc.a + arc.beta * (s - arc.s);
        let (mut s, mut v, h) = (arc.s, arc.v, time / 2000.0);
        for _ in 0..2000 {
            let (k1, l1) = (v, acceleration(s));
            let (k2, l2) = (v + 0.5 * h * l1, acceleration(s + 0.5 * h * k1));
            let (k3, l3) = (v + 0.5 * h * l2, acceleration(s + 0.5 * h * k2));
            let (k4, l4) = (v + h * l3, acceleration(s + h * k3));
            s += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        }
        [s, v]
    }

    #[test]
    fn an_arc_is_the_solution_of_its_equation_and_takes_the_time_it_says() {
        for beta in [-40.0, -2.0, -1e-7, 0.0, 1e-7, 3.0, 40.0] {
            // Speeding up from rest and in motion, and braking.
            for (v, a, time) in [(0.0, 2.0, 0.2), (0.5, 2.0, 0.2), (0.7, -3.0, 0.1), (1.0, -0.1, 0.2)] {
                let arc = Arc { begin: 0.0, s: 0.3, v, a, beta };
                let [s, v1, a1] = arc.at(time);
                let [expected, speed] = integrated(&arc, time);
                assert!((s - expected).abs() < 1e-12 && (v1 - speed).abs() < 1e-12, "{arc:?}");
                assert!((a1 - (a + beta * (s - 0.3))).abs() < 1e-12);
                if a * a1 > 0.0 && v1 > 0.0 {
                    assert!((arc.time(s - 0.3, v1) - time).abs() < 1e-9 * time, "{arc:?}");
                }
            }
        }
    }

    #[test]
    fn a_row_of_arcs_is_at_rest_after_its_end() {
        let mut timing = Timing::begun_at(0.0);
        timing.push(0.0, [2.0, 0.0], 1.0, 2.0);
        timing.push(2.0, [-2.0, 0.0], 2.0, 0.0);
        assert!((timing.duration - 2.0).abs() < 1e-15);
        assert_eq!(timing.at(0.5), [0.25, 1.0, 2.0]);
        assert_eq!(timing.at(1.5)[1], 1.0);
        assert_eq!(timing.at(2.0), [2.0, 0.0, 0.0]);
        assert_eq!(timing.at(9.0), [2.0, 0.0, 0.0]);
    }

    #[test]
    fn a_row_without_room_ends_where_its_arcs_do() {
        let mut timing = Timing::begun_at(0.0);
        for k in 0..=MOST_ARCS {
            timing.push(1.0, [0.0, 0.0], (k + 1) as f64, 1.0);
        }
        assert_eq!((timing.end, timing.duration), (MOST_ARCS as f64, MOST_ARCS as f64));
    }
}
