//! Whether tensions keep their limits on a piece of a motion of the paper's robot without a turn: by Bernstein's polynomials, with nothing of the planner's proofs.
//!
//! Where position P and acceleration P'' are polynomials of τ in [0, 1], so are z, l² and, (E1) of docs/exact.md,
//!
//! ```text
//! G = (g - z'')(a/2 - n·P) - z n·P''.    u = m l G/(3 a z) ≥ u_min > 0  ⇔  G > 0 and G² l² - c² z² ≥ 0,  c = 3 a u_min/m.
//! ```
//!
//! A polynomial is positive where its Bernstein coefficients are; where they are not all, the piece is halved. Multiplied out without cancelling, the polynomial has degree 6 on
//! an arc of a line (in s), 8 on one of constant acceleration (in t), 20 on one of a bent way and 32 on one of a spline.

use cable_robot::plan::minimum_time::Arc;
use cable_robot::reach::certificate::section::Section;
use cable_robot::robot::triangles::{FACET_NORMALS, SIX, ends};
use cable_robot::robot::{RobotParameters, TensionLimits};

/// Times that a piece is halved.
const HALVINGS: u32 = 12;

/// With the coefficients of Bernstein times binomial ones: a product is a convolution.
#[derive(Clone, Debug)]
struct Polynomial(Vec<f64>);

/// A piece of a motion in the paper's frame: x, y, z in m and m/s².
#[derive(Clone)]
pub struct Piece {
    position: [Polynomial; 3],
    acceleration: [Polynomial; 3],
}

/// In order of what counts more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    Kept,
    Undecided,
    Broken,
}

impl Piece {
    /// An arc of a straight line, τ along s: s'' is a straight line of s. `section` is in the paper's frame, s in m.
    pub fn of_line(section: &Section, arc: &Arc, duration: f64) -> Self {
        let [end, _, a] = arc.at(duration);
        Self::along(section, &Polynomial::straight(arc.s, end), None, &Polynomial::straight(arc.a, a))
    }

    /// An arc of constant s'', τ along t.
    pub fn of_constant_acceleration(section: &Section, arc: &Arc, duration: f64) -> Self {
        let gain = arc.a * duration;
        let (middle, end) = (arc.s + 0.5 * arc.v * duration, arc.s + (arc.v + 0.5 * gain) * duration);
        let s = Polynomial(vec![arc.s, 2.0 * middle, end]);
        Self::along(
            section,
            &s,
            Some(&Polynomial::straight(arc.v, arc.v + gain)),
            &Polynomial::constant(arc.a),
        )
    }

    /// q'' = q_s s'' + q_ss s'²; on a straight way the last is none.
    fn along(
        section: &Section,
        s: &Polynomial,
        rate: Option<&Polynomial>,
        acceleration: &Polynomial,
    ) -> Self {
        let sigma = s.plus(&Polynomial::constant(-section.begin));
        let constant = Polynomial::constant;
        let of = |k: usize| section.coefficients.map(|coordinates| coordinates[k]);
        let position = |k: usize| {
            let [a, b, c, d] = of(k);
            let inner = constant(d).times(&sigma).plus(&constant(c)).times(&sigma).plus(&constant(b));
            inner.times(&sigma).plus(&constant(a))
        };
        let accelerated = |k: usize| {
            let [_, b, c, d] = of(k);
            let slope =
                constant(3.0 * d).times(&sigma).plus(&constant(2.0 * c)).times(&sigma).plus(&constant(b));
            let bend = constant(6.0 * d).times(&sigma).plus(&constant(2.0 * c));
            let of_speed = rate.map_or(constant(0.0), |rate| bend.times(rate).times(rate));
            slope.times(acceleration).plus(&of_speed)
        };
        Self { position: std::array::from_fn(position), acceleration: std::array::from_fn(accelerated) }
    }

    /// Whether every tension keeps the limits all over the piece.
    pub fn verdict(&self, robot: &RobotParameters, limits: &TensionLimits) -> Verdict {
        let of = |i: usize| self.verdict_of(robot, limits, i, HALVINGS);
        (0..SIX).map(of).max().unwrap_or(Verdict::Undecided)
    }

    fn verdict_of(&self, robot: &RobotParameters, limits: &TensionLimits, i: usize, left: u32) -> Verdict {
        let g = self.g(robot, i);
        let square = g.times(&g).times(&self.length_squared(robot, i));
        let z_squared = self.position[2].times(&self.position[2]);
        // G² l² - c² z².
        let over = |u: f64| {
            let c = 3.0 * robot.a * u / robot.m;
            square.plus(&z_squared.scaled(-c * c))
        };
        let (lower, upper) = (over(limits.min), over(limits.max.min(f64::MAX.sqrt())));
        let is_above = if limits.min > 0.0 {
            g.is_positive() && lower.is_positive()
        } else {
            self.is_above(robot, limits.min, i, &g)
        };
        let is_below = limits.max == f64::INFINITY || upper.scaled(-1.0).is_positive();
        let is_outside_at = |end: usize| {
            let [g, lower, upper] = [&g, &lower, &upper].map(|polynomial| polynomial.at_end(end));
            let is_below = if limits.min > 0.0 { g <= 0.0 || lower < 0.0 } else { g < 0.0 && lower > 0.0 };
            is_below || (limits.max.is_finite() && g > 0.0 && upper > 0.0)
        };
        if is_above && is_below {
            Verdict::Kept
        } else if is_outside_at(0) || is_outside_at(1) {
            Verdict::Broken
        } else if left == 0 {
            Verdict::Undecided
        } else {
            let halves = self.halves();
            halves
                .iter()
                .map(|half| half.verdict_of(robot, limits, i, left - 1))
                .max()
                .unwrap_or(Verdict::Undecided)
        }
    }

    /// Whether u ≥ `least`, which is 0 or negative: G ≥ c z/l, with the least z and the greatest l of the piece.
    fn is_above(&self, robot: &RobotParameters, least: f64, i: usize, g: &Polynomial) -> bool {
        let pick = |p: &Polynomial, pick: fn(f64, f64) -> f64| p.coefficients().into_iter().reduce(pick);
        let lowest = pick(&self.position[2], f64::min).unwrap_or(0.0).max(0.0);
        let longest = pick(&self.length_squared(robot, i), f64::max).unwrap_or(f64::INFINITY).sqrt();
        let c = 3.0 * robot.a * least / robot.m;
        g.plus(&Polynomial::constant(-c * lowest / longest)).is_positive()
    }

    fn g(&self, robot: &RobotParameters, i: usize) -> Polynomial {
        let (n, [x, y, z], [ax, ay, az]) = (FACET_NORMALS[i], &self.position, &self.acceleration);
        let across = |x: &Polynomial, y: &Polynomial| x.scaled(n.x).plus(&y.scaled(n.y));
        let fall = az.scaled(-1.0).plus(&Polynomial::constant(robot.g));
        let inside = across(x, y).scaled(-1.0).plus(&Polynomial::constant(0.5 * robot.a));
        fall.times(&inside).plus(&z.times(&across(ax, ay)).scaled(-1.0))
    }

    fn length_squared(&self, robot: &RobotParameters, i: usize) -> Polynomial {
        let (anchor, attachment) = ends(robot.a, robot.b)[i];
        let off = attachment - anchor;
        let square = |k: usize| {
            let way = self.position[k].plus(&Polynomial::constant(off[k]));
            way.times(&way)
        };
        square(0).plus(&square(1)).plus(&square(2))
    }

    fn halves(&self) -> [Self; 2] {
        let position = self.position.each_ref().map(Polynomial::halves);
        let acceleration = self.acceleration.each_ref().map(Polynomial::halves);
        [0, 1].map(|half| Self {
            position: position.each_ref().map(|halves| halves[half].clone()),
            acceleration: acceleration.each_ref().map(|halves| halves[half].clone()),
        })
    }
}

impl Polynomial {
    fn constant(value: f64) -> Self {
        Self(vec![value])
    }

    fn straight(from: f64, to: f64) -> Self {
        Self(vec![from, to])
    }

    fn times(&self, other: &Self) -> Self {
        if self.0 == [0.0] || other.0 == [0.0] {
            return Self::constant(0.0);
        }
        let mut product = vec![0.0; self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        Self(product)
    }

    /// The one of smaller degree is raised to the other's: times ((1 - τ) + τ).
    fn plus(&self, other: &Self) -> Self {
        let (mut sum, larger) =
            if self.0.len() < other.0.len() { (self.clone(), other) } else { (other.clone(), self) };
        while sum.0.len() < larger.0.len() {
            sum.0.push(0.0);
            (1..sum.0.len()).rev().for_each(|k| sum.0[k] += sum.0[k - 1]);
        }
        sum.0.iter_mut().zip(&larger.0).for_each(|(a, b)| *a += b);
        sum
    }

    fn scaled(&self, by: f64) -> Self {
        Self(self.0.iter().map(|c| c * by).collect())
    }

    fn is_positive(&self) -> bool {
        self.0.iter().all(|c| *c > 0.0)
    }

    /// The value at τ = 0 or 1.
    fn at_end(&self, end: usize) -> f64 {
        self.0[end * (self.0.len() - 1)]
    }

    /// Binomial coefficients of its degree.
    fn binomials(&self) -> Vec<f64> {
        let degree = self.0.len() - 1;
        let row = (0..=degree).scan(1.0, |next, k| {
            let this = *next;
            *next *= (degree - k) as f64 / (k + 1) as f64;
            Some(this)
        });
        row.collect()
    }

    /// Bernstein's: its values are between the least and the greatest of them.
    fn coefficients(&self) -> Vec<f64> {
        self.0.iter().zip(self.binomials()).map(|(c, binomial)| c / binomial).collect()
    }

    /// By de Casteljau.
    fn halves(&self) -> [Self; 2] {
        let (degree, binomials) = (self.0.len() - 1, self.binomials());
        let mut row = self.coefficients();
        let (mut left, mut right) = (vec![0.0; degree + 1], vec![0.0; degree + 1]);
        for k in 0..=degree {
            left[k] = row[0] * binomials[k];
            right[degree - k] = row[degree - k] * binomials[degree - k];
            (0..degree - k).for_each(|j| row[j] = 0.5 * (row[j] + row[j + 1]));
        }
        [Self(left), Self(right)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cable_robot::control::tensions;
    use cable_robot::robot::{Coordinates, Rig};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn value(polynomial: &Polynomial, t: f64) -> f64 {
        let degree = polynomial.0.len() as i32 - 1;
        let terms = polynomial.0.iter().zip(0..);
        terms.map(|(c, k)| c * t.powi(k) * (1.0 - t).powi(degree - k)).sum()
    }

    #[test]
    fn sums_products_and_halves_are_those_of_the_values() {
        let (p, q) = (Polynomial(vec![1.0, -3.0, 0.5]), Polynomial(vec![2.0, 0.3, -4.0, 1.5, 0.2]));
        for t in [0.0, 0.2, 0.7, 1.0] {
            let (at_p, at_q) = (value(&p, t), value(&q, t));
            assert!((value(&p.times(&q), t) - at_p * at_q).abs() < 1e-13);
            assert!((value(&p.plus(&q), t) - at_p - at_q).abs() < 1e-13);
            let [left, right] = q.halves();
            assert!((value(&left, 2.0 * t.min(0.5)) - value(&q, t.min(0.5))).abs() < 1e-13);
            assert!((value(&right, (2.0 * t - 1.0).max(0.0)) - value(&q, t.max(0.5))).abs() < 1e-13);
        }
    }

    /// Limits a little outside of the tensions' extremes on a piece, and a little inside: bent ways, cubics, lines with s'' that grows along them.
    #[test]
    fn what_samples_say_of_a_limit_the_polynomials_say() {
        let robot = RobotParameters::default();
        let rig = Rig::paper(&robot, TensionLimits::default());
        let mut rng = Pcg64::seed_from_u64(3);
        let mut looked_at = 0;
        for case in 0..300 {
            let mut any = |size: f64| {
                let by = Coordinates::from_fn(|k, _| if k < 3 { rng.random_range(-size..size) } else { 0.0 });
                if case % 3 < 2 {
                    by
                } else {
                    by.component_mul(&Coordinates::new(1.0, 1.0, 0.0, 0.0, 0.0, 0.0))
                }
            };
            let (from, way) = (any(0.1) + Coordinates::z(), any(0.2));
            let mut section = Section::straight(&cable_robot::robot::Pose(from), &way);
            if case % 3 > 0 {
                section.coefficients[2] = any(0.2);
                section.coefficients[3] = any(0.2);
            }
            let beta = if case % 3 == 0 { rng.random_range(-3.0..3.0) } else { 0.0 };
            let (v, a) = (rng.random_range(0.0..1.0), rng.random_range(-2.0..4.0));
            let (arc, duration) = (Arc { begin: 0.0, s: 0.1, v, a, beta }, 0.2);
            let piece = if case % 3 == 0 {
                Piece::of_line(&section, &arc, duration)
            } else {
                Piece::of_constant_acceleration(&section, &arc, duration)
            };
            let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
            for k in 0..=400 {
                let [s, v, a] = arc.at(duration * f64::from(k) / 400.0);
                let (slope, bend) = (section.slope(s), section.bend(s));
                let u = tensions(&rig, &section.pose(s), &(slope * v), &(slope * a + bend * (v * v)), 0.0)
                    .unwrap();
                u.iter().for_each(|u| (least, greatest) = (least.min(*u), greatest.max(*u)));
            }
            let verdict = |min: f64, max: f64| piece.verdict(&robot, &TensionLimits { min, max });
            let off = 1e-3 * (greatest - least) + 1e-6;
            // Squares do not know the sign of a limit, and none is below 0; no arc of a motion turns back.
            if least < off || arc.at(duration)[1] < 0.0 {
                continue;
            }
            looked_at += 1;
            assert_eq!(verdict(least - off, greatest + off), Verdict::Kept, "{case}");
            assert_eq!(verdict(least + off, greatest + off), Verdict::Broken, "{case}");
            assert_eq!(verdict(least - off, greatest - off), Verdict::Broken, "{case}");
            assert_eq!(verdict(least - off, f64::INFINITY), Verdict::Kept, "{case}");
        }
        assert!(looked_at > 100, "{looked_at}");
    }
}
