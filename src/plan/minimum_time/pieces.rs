//! The pieces that a line is cut into, and the straight bounds of s'' on each. Derived in docs/minimum-time.md.

use arrayvec::ArrayVec;
use nalgebra::Vector3;

use super::envelope::Ray;
use crate::robot::triangles::{FACET_NORMALS, SIX, ends};
use crate::robot::{RobotParameters, TensionLimits};

/// Pieces of a line at first, and at most.
const FIRST: usize = 4;
pub const MOST_PIECES: usize = 24;
/// A piece is halved where its chords take more than this share of W, as it is where the piece ends.
const SHARE: f64 = 2e-4;
/// Simpson's rule: weights at both ends and in the middle.
const SIMPSON: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];

/// Upwards, s'' itself, and downwards, -s''.
const SIDES: [usize; 2] = [0, 1];

/// The limits of the tensions along a line.
pub struct Limits {
    cables: [Cable; SIX],
    /// Those that bound s'', and those that bound -s''.
    sides: [ArrayVec<Limit, SIX>; 2],
    /// Those that s'' does not change: y ≥ 0.
    still: ArrayVec<Limit, { 2 * SIX }>,
}

/// w = z/l of a cable along the line.
#[derive(Clone, Copy, Debug)]
struct Cable {
    /// Where the line is nearest to where the cable would have no length, m,
    foot: f64,
    /// its height there, m,
    height: f64,
    /// the square of the distance, m²,
    square: f64,
    /// and z'.
    climb: f64,
}

/// s'', or -s'', is at most y = `rest` + `slope` s + `c` w, m/s².
struct Limit {
    cable: usize,
    rest: f64,
    slope: f64,
    c: f64,
}

/// A place of the line with w of each cable there, and the greatest s'' and -s'' that the limits leave, m/s².
#[derive(Clone, Copy)]
struct Place {
    s: f64,
    w: [f64; SIX],
    most: [f64; 2],
}

/// Between two places.
pub struct Piece {
    places: [Place; 3],
    /// Bounds of s'' and of -s'' on it, from its start on: the least of them.
    pub rays: [ArrayVec<Ray, SIX>; 2],
    /// What W, m²/s², gains on it on either side with the limits themselves,
    gain: [f64; 2],
    /// and what it loses by the chords; infinite where they leave nothing.
    loss: [f64; 2],
}

impl Cable {
    fn w(&self, s: f64) -> f64 {
        let x = s - self.foot;
        (self.height + self.climb * x) / (self.square + x * x).sqrt()
    }

    /// By how much w is above its chord on a piece at most, and by how much below: h²/8 max ∓w'', with w'' = (2 z x² - 3 z' p² x - z p²)/l⁵, x from the foot, z
    /// and p there. A polynomial is between the least and the greatest of its Bernstein coefficients.
    fn off(&self, start: f64, end: f64) -> [f64; 2] {
        let Self { foot, height, square, climb } = *self;
        let [x, y] = [start - foot, end - foot];
        let bend = |x: f64, y: f64| 2.0 * height * x * y - square * (1.5 * climb * (x + y) + height);
        let bends = [bend(x, x), bend(x, y), bend(y, y)];
        let nearest = if x > 0.0 { x } else { y.min(0.0) };
        let shortest = square + nearest * nearest;
        let by = 0.125 * (y - x) * (y - x) / (shortest * shortest * shortest.sqrt());
        let [least, greatest] = [f64::min, f64::max].map(|pick| bends.into_iter().fold(0.0, pick));
        [-least * by, greatest * by]
    }
}

impl Limit {
    fn at(&self, s: f64, w: &[f64; SIX]) -> f64 {
        self.rest + self.slope * s + self.c * w[self.cable]
    }

    /// Its chord on a piece, on the safe side.
    fn chord(&self, [start, end]: [&Place; 2], off: &[[f64; 2]; SIX]) -> Ray {
        let [above, below] = off[self.cable];
        let off = if self.c < 0.0 { -self.c * above } else { self.c * below };
        let [at_start, at_end] = [start, end].map(|place| self.at(place.s, &place.w) - off);
        Ray { s: start.s, value: at_start, slope: (at_end - at_start) / (end.s - start.s) }
    }
}

impl Limits {
    /// On the line from a place on in a direction of length 1.
    pub fn new(
        robot: &RobotParameters,
        limits: &TensionLimits,
        from: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> Self {
        let RobotParameters { a, b, m, g, .. } = *robot;
        let ends = ends(a, b);
        let cables = ends.map(|(anchor, attachment)| {
            let way = anchor - attachment - from;
            let foot = way.dot(direction);
            let square = (way - direction * foot).norm_squared();
            Cable { foot, height: from.z + direction.z * foot, square, climb: direction.z }
        });
        let mut found = Self { cables, sides: Default::default(), still: ArrayVec::new() };
        let [least, greatest] = [limits.min, limits.max].map(|u| 3.0 * a * u / m);
        for cable in 0..SIX {
            // G = g (h - ν s) - κ s'', and c w is G at the limit.
            let normal = FACET_NORMALS[cable];
            let (h, nu) = (0.5 * a - normal.dot(&from.xy()), normal.dot(&direction.xy()));
            let kappa = direction.z * h + from.z * nu;
            let by = if kappa == 0.0 { 1.0 } else { 1.0 / kappa.abs() };
            let (rest, slope) = (g * h * by, -g * nu * by);
            let lower = Limit { cable, rest, slope, c: -least * by };
            let upper = Limit { cable, rest: -rest, slope: -slope, c: greatest * by };
            let upper = upper.c.is_finite().then_some(upper);
            if kappa == 0.0 {
                found.still.extend([Some(lower), upper].into_iter().flatten());
                continue;
            }
            let side = usize::from(kappa < 0.0);
            found.sides[side].push(lower);
            found.sides[1 - side].extend(upper);
        }
        found
    }

    /// The pieces of a line of this length: halved where their chords cost most, until they cost little. `None` where s'' may not be 0 or nothing bounds it.
    pub fn pieces(&self, length: f64) -> Option<ArrayVec<Piece, MOST_PIECES>> {
        if self.sides.iter().any(|limits| limits.is_empty()) {
            return None;
        }
        let mut pieces = ArrayVec::new();
        let mut start = self.place(0.0)?;
        for k in 1..=FIRST {
            let end = self.place(length * k as f64 / FIRST as f64)?;
            pieces.push(self.piece(start, end)?);
            start = end;
        }
        while !pieces.is_full()
            && let Some(k) = worst(&pieces)
        {
            let Piece { places: [start, middle, end], .. } = pieces[k];
            pieces[k] = self.piece(start, middle)?;
            pieces.insert(k + 1, self.piece(middle, end)?);
        }
        pieces.iter().all(|piece| piece.loss.iter().all(|loss| loss.is_finite())).then_some(pieces)
    }

    /// `None` where s'' may not be 0.
    fn place(&self, s: f64) -> Option<Place> {
        let w = self.cables.map(|cable| cable.w(s));
        let least =
            |limits: &[Limit]| limits.iter().map(|limit| limit.at(s, &w)).fold(f64::INFINITY, f64::min);
        let most = SIDES.map(|side| least(&self.sides[side]));
        (most[0] > 0.0 && most[1] > 0.0 && least(&self.still) >= 0.0).then_some(Place { s, w, most })
    }

    fn piece(&self, start: Place, end: Place) -> Option<Piece> {
        let middle = self.place(0.5 * (start.s + end.s))?;
        let off = self.cables.map(|cable| cable.off(start.s, end.s));
        let chords =
            |limits: &[Limit]| limits.iter().map(|limit| limit.chord([&start, &end], &off)).collect();
        let rays: [ArrayVec<Ray, SIX>; 2] = SIDES.map(|side| chords(&self.sides[side]));
        let still = self.still.iter().map(|limit| limit.chord([&start, &end], &off));
        let is_still = still.into_iter().all(|ray| ray.value >= 0.0 && ray.at(end.s) >= 0.0);
        let (places, h) = ([start, middle, end], end.s - start.s);
        let (mut gain, mut loss) = ([0.0; 2], [0.0; 2]);
        for side in SIDES {
            for (place, weight) in places.iter().zip(SIMPSON) {
                let kept = rays[side].iter().map(|ray| ray.at(place.s)).fold(f64::INFINITY, f64::min);
                let most = place.most[side];
                gain[side] += weight * h * most;
                loss[side] += if kept > 0.0 && is_still { weight * h * (most - kept) } else { f64::INFINITY };
            }
        }
        Some(Piece { places, rays, gain, loss })
    }
}

impl Piece {
    /// Where it ends, m.
    pub fn end(&self) -> f64 {
        self.places[2].s
    }
}

/// The piece whose chords take the greatest share of W; `None` where all take little. Those of s'' count up to the switch only, those of -s'' from there on.
fn worst(pieces: &[Piece]) -> Option<usize> {
    let (mut up, mut down) = (0.0, pieces.iter().map(|piece| piece.gain[1]).sum::<f64>());
    let (mut most, mut found) = (SHARE, None);
    for (k, Piece { gain, loss, .. }) in pieces.iter().enumerate() {
        let (faster, slower) = (up + gain[0], down - gain[1]);
        let mut share = 0.0;
        if up < down || loss[0] == f64::INFINITY {
            share = loss[0] / faster;
        }
        if slower < faster || loss[1] == f64::INFINITY {
            share = f64::max(share, loss[1] / down);
        }
        if share > most {
            (most, found) = (share, Some(k));
        }
        (up, down) = (faster, slower);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn w_is_no_farther_from_its_chord_than_is_said() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
        for _ in 0..2000 {
            let mut any = |low: f64, high: f64| rng.random_range(low..high);
            let height = any(-2.0, 2.0);
            let square = height * height + any(0.0, 1.0);
            let cable = Cable { foot: any(-3.0, 3.0), height, square, climb: any(-1.0, 1.0) };
            let start = any(-3.0, 3.0);
            let end = start + any(0.0, 1.0);
            let [above, below] = cable.off(start, end);
            let (mut most, mut least) = (0.0f64, 0.0f64);
            for k in 0..=100 {
                let share = f64::from(k) / 100.0;
                let chord = (1.0 - share) * cable.w(start) + share * cable.w(end);
                let off = cable.w(start + share * (end - start)) - chord;
                (most, least) = (most.max(off), least.min(off));
            }
            assert!(most <= above + 1e-14 && -least <= below + 1e-14, "{cable:?} {start} {end}");
            // And on a short piece on which w bends one way it is about as far.
            if above.min(below) == 0.0 && end - start < 0.05 * square.sqrt() {
                assert!(most.max(-least) >= 0.4 * above.max(below) - 1e-14, "{cable:?} {start} {end}");
            }
        }
    }
}
