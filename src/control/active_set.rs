//! The point nearest to the origin that keeps to half-spaces: a quadratic programme, by a dual active set method.
//!
//! Goldfarb and Idnani (1983) for the Hessian 1: from the unconstrained optimum on, the row that is violated most is brought to its bound;
//! rows whose multiplier would turn negative on the way are let go. Each pass raises the dual value, so no active set comes twice and the
//! method ends. It allocates nothing, and is bounded by a fixed number of passes.

/// Unknowns that a programme may have.
pub const MOST_UNKNOWNS: usize = 16;
/// Normals that a programme may have.
pub const MOST_NORMALS: usize = 64;
/// Rows that may be active at once: hard ones are independent, soft ones at most one for each unknown.
const MOST_ACTIVE: usize = 2 * MOST_UNKNOWNS - 6;
/// Passes before giving up; twenty are many.
const MOST_PASSES: usize = 400;
/// Corrections for rounding; they end by themselves but for the last place.
const MOST_REFINEMENTS: usize = 3;
/// A row counts as a combination of active ones if what it adds to them is below this share of the largest normal's square.
const DEPENDENT: f64 = 1e-11;

/// A point or a direction.
pub type Point = [f64; MOST_UNKNOWNS];

/// `sign` normal·x ≤ bound. A soft row may be exceeded by s at the price s²/(2 `compliance`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Which of the normals.
    pub normal: usize,
    /// 1 or -1.
    pub sign: f64,
    /// Not less than minus infinity; a row with an infinite bound is no row.
    pub bound: f64,
    /// 0 for a row that must be kept.
    pub compliance: f64,
}

/// What is known of a programme.
#[allow(clippy::large_enum_variant, reason = "boxing would allocate in every step")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// The nearest point.
    Nearest(Point),
    /// Rows that no point keeps: with their multipliers, all 0 or more, their normals add up to nothing and their bounds to less.
    Contradiction(Multipliers),
    /// The passes did not suffice.
    Unfinished,
}

/// Multipliers of rows, by their index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multipliers {
    count: usize,
    rows: [(usize, f64); MOST_ACTIVE],
}

impl Multipliers {
    /// (row, multiplier).
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        self.rows.into_iter().take(self.count)
    }
}

/// The rows at their bounds, with the Cholesky factor of their Gram matrix G + C (C: compliances).
struct Active {
    count: usize,
    row: [usize; MOST_ACTIVE],
    multiplier: [f64; MOST_ACTIVE],
    /// Lower triangle, row by row.
    factor: [[f64; MOST_ACTIVE]; MOST_ACTIVE],
}

/// A programme: minimise |x|²/2 subject to rows.
pub struct Programme<'a> {
    /// Unknowns in use.
    pub unknowns: usize,
    /// Dimension of what the normals span: no more hard rows can be at their bounds at once.
    pub rank: usize,
    /// Normals of the rows, at most [`MOST_NORMALS`].
    pub normals: &'a [Point],
    /// The rows.
    pub rows: &'a [Row],
    /// By how much a row may be exceeded for rounding.
    pub tolerance: f64,
}

impl Programme<'_> {
    /// Solves it.
    pub fn solve(&self) -> Outcome {
        let mut x = [0.0; MOST_UNKNOWNS];
        let mut active = Active::none();
        // The row that is being brought to its bound, and its multiplier so far.
        let mut entering: Option<(usize, f64)> = None;
        let mut refinements_left = MOST_REFINEMENTS;
        for _ in 0..MOST_PASSES {
            let Some((row, multiplier)) = entering.or_else(|| self.most_violated(&x, &active)) else {
                if refinements_left == 0 || !self.refine(&mut x, &mut active) {
                    let is_finite = x.iter().all(|value| value.is_finite());
                    return if is_finite { Outcome::Nearest(x) } else { Outcome::Unfinished };
                }
                refinements_left -= 1;
                continue;
            };
            let step = self.step(&active, row);
            let excess = self.value(row, &x) - self.rows[row].compliance * multiplier - self.rows[row].bound;
            let full = if step.is_dependent { f64::INFINITY } else { (excess / step.decrease).max(0.0) };
            let (blocking, partial) = active.first_to_leave(&step);
            if full == f64::INFINITY && partial == f64::INFINITY {
                return Outcome::Contradiction(active.contradiction(row, &step));
            }
            let length = full.min(partial);
            for k in 0..self.unknowns {
                x[k] -= length * step.direction[k];
            }
            for j in 0..active.count {
                active.multiplier[j] -= length * step.exchange[j];
            }
            if full <= partial {
                if active.count == MOST_ACTIVE {
                    return Outcome::Unfinished;
                }
                active.append(row, multiplier + length, &step);
                entering = None;
            } else {
                entering = Some((row, multiplier + length));
                active.remove(blocking, self);
            }
        }
        Outcome::Unfinished
    }

    /// Brings the active rows back to their bounds, from which rounding took them. Whether there was anything to do.
    fn refine(&self, x: &mut Point, active: &mut Active) -> bool {
        let mut change = [0.0; MOST_ACTIVE];
        let mut worst: f64 = 0.0;
        for j in 0..active.count {
            let row = active.row[j];
            change[j] =
                self.value(row, x) - self.rows[row].compliance * active.multiplier[j] - self.rows[row].bound;
            worst = worst.max(change[j].abs());
        }
        if worst <= self.tolerance {
            return false;
        }
        active.solve_lower(&mut change);
        active.solve_upper(&mut change);
        for j in 0..active.count {
            active.multiplier[j] += change[j];
            self.add(x, active.row[j], -change[j]);
        }
        true
    }

    /// sign normal·x.
    fn value(&self, row: usize, x: &Point) -> f64 {
        let Row { normal, sign, .. } = self.rows[row];
        sign * self.dot(&self.normals[normal], x)
    }

    fn dot(&self, a: &Point, b: &Point) -> f64 {
        (0..self.unknowns).map(|k| a[k] * b[k]).sum()
    }

    fn largest_square(&self) -> f64 {
        self.normals.iter().map(|normal| self.dot(normal, normal)).fold(0.0, f64::max)
    }

    /// Scalar product of two rows' normals, signs included.
    fn product(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (&self.rows[a], &self.rows[b]);
        a.sign * b.sign * self.dot(&self.normals[a.normal], &self.normals[b.normal])
    }

    fn most_violated(&self, x: &Point, active: &Active) -> Option<(usize, f64)> {
        let mut along = [0.0; MOST_NORMALS];
        for (along, normal) in along.iter_mut().zip(self.normals) {
            *along = self.dot(normal, x);
        }
        let mut worst = (None, self.tolerance);
        for (k, row) in self.rows.iter().enumerate() {
            let excess = row.sign * along[row.normal] - row.bound;
            if excess > worst.1 && !active.row[..active.count].contains(&k) {
                worst = (Some((k, 0.0)), excess);
            }
        }
        worst.0
    }

    /// What a unit of the multiplier of `row` does while the active rows stay at their bounds.
    fn step(&self, active: &Active, row: usize) -> Step {
        let mut step = Step {
            direction: [0.0; MOST_UNKNOWNS],
            exchange: [0.0; MOST_ACTIVE],
            reduced: [0.0; MOST_ACTIVE],
            decrease: 0.0,
            is_dependent: false,
        };
        let count = active.count;
        for j in 0..count {
            step.reduced[j] = self.product(active.row[j], row);
        }
        active.solve_lower(&mut step.reduced);
        step.exchange[..count].copy_from_slice(&step.reduced[..count]);
        active.solve_upper(&mut step.exchange);
        let own = self.product(row, row) + self.rows[row].compliance;
        step.decrease = own - step.reduced[..count].iter().map(|y| y * y).sum::<f64>();
        let hard = |row: usize| self.rows[row].compliance == 0.0;
        let hard_ones = active.row[..count].iter().filter(|row| hard(**row)).count();
        step.is_dependent =
            step.decrease <= DEPENDENT * self.largest_square() || (hard(row) && hard_ones >= self.rank);
        self.add(&mut step.direction, row, 1.0);
        for j in 0..count {
            self.add(&mut step.direction, active.row[j], -step.exchange[j]);
        }
        step
    }

    fn add(&self, sum: &mut Point, row: usize, factor: f64) {
        let Row { normal, sign, .. } = self.rows[row];
        let factor = sign * factor;
        for k in 0..self.unknowns {
            sum[k] += factor * self.normals[normal][k];
        }
    }
}

struct Step {
    /// x moves by minus this.
    direction: Point,
    /// The active rows' multipliers fall by this.
    exchange: [f64; MOST_ACTIVE],
    /// L⁻¹ g.
    reduced: [f64; MOST_ACTIVE],
    /// By how much the row's excess falls.
    decrease: f64,
    /// Whether that is nothing but rounding.
    is_dependent: bool,
}

impl Active {
    fn none() -> Self {
        Self {
            count: 0,
            row: [0; MOST_ACTIVE],
            multiplier: [0.0; MOST_ACTIVE],
            factor: [[0.0; MOST_ACTIVE]; MOST_ACTIVE],
        }
    }

    fn solve_lower(&self, right: &mut [f64; MOST_ACTIVE]) {
        for i in 0..self.count {
            let known: f64 = (0..i).map(|j| self.factor[i][j] * right[j]).sum();
            right[i] = (right[i] - known) / self.factor[i][i];
        }
    }

    fn solve_upper(&self, right: &mut [f64; MOST_ACTIVE]) {
        for i in (0..self.count).rev() {
            let known: f64 = (i + 1..self.count).map(|j| self.factor[j][i] * right[j]).sum();
            right[i] = (right[i] - known) / self.factor[i][i];
        }
    }

    /// Position of the active row whose multiplier reaches zero first, and how far that is.
    fn first_to_leave(&self, step: &Step) -> (usize, f64) {
        let mut first = (0, f64::INFINITY);
        for j in 0..self.count {
            let until = self.multiplier[j].max(0.0) / step.exchange[j];
            if step.exchange[j] > 0.0 && until < first.1 {
                first = (j, until);
            }
        }
        first
    }

    fn append(&mut self, row: usize, multiplier: f64, step: &Step) {
        let k = self.count;
        self.row[k] = row;
        self.multiplier[k] = multiplier;
        self.factor[k][..k].copy_from_slice(&step.reduced[..k]);
        self.factor[k][k] = step.decrease.sqrt();
        self.count += 1;
    }

    /// Lets go the row at `position`; the factor's rows below it are made anew.
    fn remove(&mut self, position: usize, programme: &Programme) {
        let (rows, multipliers, count) = (self.row, self.multiplier, self.count);
        self.count = position;
        for j in position + 1..count {
            let mut step = programme.step(self, rows[j]);
            step.decrease = step.decrease.max(f64::MIN_POSITIVE);
            self.append(rows[j], multipliers[j], &step);
        }
    }

    /// `row` and the active ones, whose normals it is made of: Σ exchange = -multiplier.
    fn contradiction(&self, row: usize, step: &Step) -> Multipliers {
        let mut found = Multipliers { count: self.count + 1, rows: [(row, 1.0); MOST_ACTIVE] };
        for j in 0..self.count {
            found.rows[j + 1] = (self.row[j], (-step.exchange[j]).max(0.0));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Random half-spaces in `unknowns` dimensions, about every second of which holds the origin.
    fn random(
        rng: &mut rand_pcg::Pcg64,
        unknowns: usize,
        count: usize,
        soft: bool,
    ) -> (Vec<Point>, Vec<Row>) {
        let normals: Vec<Point> = (0..count)
            .map(|_| std::array::from_fn(|k| if k < unknowns { rng.random_range(-1.0..1.0) } else { 0.0 }))
            .collect();
        let rows = (0..count)
            .map(|normal| Row {
                normal,
                sign: if rng.random_range(0..2) == 0 { 1.0 } else { -1.0 },
                bound: rng.random_range(-0.6..1.0),
                compliance: if soft && normal % 2 == 0 {
                    10f64.powf(rng.random_range(-2.0..0.0))
                } else {
                    0.0
                },
            })
            .collect();
        (normals, rows)
    }

    /// Solves the same by coordinate ascent on the dual (slow and simple): multipliers of all rows, if it ends.
    fn by_coordinate_ascent(programme: &Programme) -> Option<Vec<f64>> {
        let count = programme.rows.len();
        let mut multiplier = vec![0.0_f64; count];
        for _ in 0..20_000 {
            let mut most: f64 = 0.0;
            for i in 0..count {
                let own = programme.product(i, i) + programme.rows[i].compliance;
                let pull: f64 = (0..count).map(|j| programme.product(i, j) * multiplier[j]).sum();
                let slope = -pull - programme.rows[i].compliance * multiplier[i] - programme.rows[i].bound;
                let next = (multiplier[i] + slope / own).max(0.0);
                most = most.max((next - multiplier[i]).abs());
                multiplier[i] = next;
            }
            if most < 1e-13 {
                return Some(multiplier);
            }
        }
        None
    }

    #[test]
    fn is_the_optimum_of_a_slow_and_simple_method() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1983);
        let mut compared = 0;
        for case in 0..300 {
            let unknowns = 1 + case % 5;
            let (normals, rows) = random(&mut rng, unknowns, 3 + case % 6, case % 2 == 0);
            let programme =
                Programme { unknowns, rank: unknowns, normals: &normals, rows: &rows, tolerance: 1e-13 };
            let Outcome::Nearest(x) = programme.solve() else { continue };
            let multiplier = by_coordinate_ascent(&programme);
            let Some(multiplier) = multiplier else { continue };
            for k in 0..unknowns {
                let expected: f64 =
                    (0..rows.len()).map(|i| -multiplier[i] * rows[i].sign * normals[rows[i].normal][k]).sum();
                assert!((x[k] - expected).abs() < 1e-6, "{case}: {} is not {expected}", x[k]);
            }
            compared += 1;
        }
        assert!(compared > 150, "{compared}");
    }

    #[test]
    fn what_has_no_solution_is_shown_to_have_none() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1984);
        let (mut contradictions, mut solved) = (0, 0);
        for case in 0..3000 {
            let unknowns = 1 + case % 5;
            let (normals, rows) = random(&mut rng, unknowns, 4 + case % 16, false);
            let programme =
                Programme { unknowns, rank: unknowns, normals: &normals, rows: &rows, tolerance: 1e-12 };
            match programme.solve() {
                Outcome::Nearest(x) => {
                    solved += 1;
                    assert!((0..rows.len()).all(|i| programme.value(i, &x) <= rows[i].bound + 1e-9));
                }
                Outcome::Contradiction(multipliers) => {
                    contradictions += 1;
                    let mut sum = [0.0; MOST_UNKNOWNS];
                    multipliers.iter().for_each(|(row, factor)| programme.add(&mut sum, row, factor));
                    let bound: f64 = multipliers.iter().map(|(row, factor)| factor * rows[row].bound).sum();
                    assert!(sum.iter().all(|s| s.abs() < 1e-8) && bound < 0.0, "{case}: {sum:?} {bound}");
                    assert!(multipliers.iter().all(|(_, factor)| factor >= 0.0));
                }
                Outcome::Unfinished => panic!("{case} was not finished"),
            }
        }
        assert!(contradictions > 300 && solved > 300, "{contradictions} {solved}");
    }
}
