use super::super::arc::MOST_ARCS;
use super::*;
use crate::control::tensions;
use crate::robot::{Coordinates, Pose, Rig};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const OPEN: TensionLimits = TensionLimits { min: 0.0, max: f64::INFINITY };

fn robot() -> RobotParameters {
    RobotParameters::default()
}

fn position(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

fn papers_move(limits: TensionLimits) -> Line {
    Line::new(&robot(), limits, &position(0.0, 0.0, 1.0), &position(0.15, 0.15, 1.0))
}

/// The least and the greatest tension at a place and an acceleration on the line, by the inverse dynamics of all six coordinates, N.
fn extremes(line: &Line, [s, v, a]: [f64; 3]) -> [f64; 2] {
    let rig = Rig::paper(&line.robot, OPEN);
    let along = |by: f64| {
        let by = line.direction * by;
        Coordinates::new(by.x, by.y, by.z, 0.0, 0.0, 0.0)
    };
    let point = line.point(s);
    let pose = Pose::at(point.x, point.y, point.z);
    let tension = tensions(&rig, &pose, &along(v), &along(a), 0.0).unwrap();
    [f64::min, f64::max].map(|pick| tension.into_iter().reduce(pick).unwrap())
}

/// A line with both ends where the robot can rest, and limits of the tensions.
fn any_line(rng: &mut Pcg64) -> Line {
    let robot = robot();
    let mut any = |low: f64, high: f64| rng.random_range(low..high);
    let mut end = || {
        loop {
            let point = position(any(-0.25, 0.25), any(-0.25, 0.25), any(0.4, 1.6));
            if FACET_NORMALS.iter().all(|n| n.dot(&point.xy()) < 0.22) {
                return point;
            }
        }
    };
    let (from, to) = (end(), end());
    let to = if from.z < 1.0 { position(to.x, to.y, from.z) } else { to };
    let min = [0.0, 0.5, any(0.0, 1.0)][(any(0.0, 3.0)) as usize];
    let max = [1e3, 40.0, any(30.0, 100.0)][(any(0.0, 3.0)) as usize];
    Line::new(&robot, TensionLimits { min, max }, &from, &to)
}

/// A line of a rig and with limits of any size, from some thousandths of the way between two places up to all of it.
fn any_size(rng: &mut Pcg64) -> Line {
    let mut any = |low: f64, high: f64| libm::exp(rng.random_range(libm::log(low)..libm::log(high)));
    let a = any(1e-3, 1e3);
    let robot =
        RobotParameters { a, b: any(0.01, 0.99) * a, m: any(1e-3, 1e4), g: any(0.1, 30.0), ..robot() };
    let (weight, height, inset) = (robot.m * robot.g, any(0.05, 20.0) * a, any(1e-4, 0.1) * a);
    let pick = |rng: &mut Pcg64, of: [f64; 3]| of[rng.random_range(0..3)];
    let min = [0.0, 1e-3, any(1e-4, 0.3)];
    let max = [1e3, any(0.17, 0.6), any(0.17, 100.0)];
    let limits = TensionLimits { min: pick(rng, min) * weight, max: pick(rng, max) * weight };
    let is_level = rng.random_bool(0.5);
    let mut place = || loop {
        let mut any = |size: f64| rng.random_range(-size..size);
        let z = if is_level { height } else { height * libm::exp(any(1.6)) };
        let point = position(any(0.6 * a), any(0.6 * a), z);
        if FACET_NORMALS.iter().all(|n| n.dot(&point.xy()) < 0.5 * a - inset) {
            return point;
        }
    };
    let (from, to) = (place(), place());
    let part = if rng.random_bool(0.5) { 1.0 } else { libm::exp(rng.random_range(-7.0..0.0)) };
    Line::new(&robot, limits, &from, &(from + (to - from) * part))
}

/// The same optimum by brute force: on a fine grid, with the limits themselves, found by halving of s''.
fn on_a_grid(line: &Line, cells: usize) -> Option<f64> {
    let rig = Rig::paper(&line.robot, OPEN);
    let h = line.length / cells as f64;
    let bounds = |s: f64| {
        let point = line.point(s);
        let pose = Pose::at(point.x, point.y, point.z);
        let of = |a: f64| {
            let by = line.direction * a;
            let by = Coordinates::new(by.x, by.y, by.z, 0.0, 0.0, 0.0);
            tensions(&rig, &pose, &Coordinates::zeros(), &by, 0.0).unwrap()
        };
        // Affine in the acceleration.
        let (rest, one) = (of(0.0), of(1.0));
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        for i in 0..SIX {
            let slope = one[i] - rest[i];
            for limit in [line.limits.min, line.limits.max] {
                let a = (limit - rest[i]) / slope;
                let is_above = (slope > 0.0) == (limit == line.limits.max);
                if a.is_finite() && is_above {
                    most = most.min(a);
                } else if a.is_finite() {
                    least = least.max(a);
                }
            }
        }
        (least < 0.0 && most > 0.0).then_some([least, most])
    };
    let cells: Vec<[f64; 2]> = (0..cells).map(|k| bounds((k as f64 + 0.5) * h)).collect::<Option<_>>()?;
    let mut up = vec![0.0];
    cells.iter().for_each(|[_, most]| up.push(up.last().unwrap() + most * h));
    let mut down = vec![0.0];
    cells.iter().rev().for_each(|[least, _]| down.push(down.last().unwrap() - least * h));
    down.reverse();
    let speed = |k: usize| (2.0 * f64::min(up[k], down[k])).sqrt();
    Some((0..cells.len()).map(|k| 2.0 * h / (speed(k) + speed(k + 1))).sum())
}

#[test]
fn the_papers_move_takes_what_the_bound_says() {
    for (min, expected) in [(0.0, 0.556150), (0.5, 0.569153)] {
        let time = papers_move(TensionLimits { min, ..OPEN }).fastest(0.0, f64::INFINITY).unwrap().duration;
        println!("u >= {min}: {time:.6} s");
        assert!((time - expected).abs() < 1.5e-6, "{time}");
    }
}

#[test]
fn every_tension_of_a_fastest_motion_and_of_its_stops_is_within_the_limits_and_no_motion_is_faster() {
    let mut rng = Pcg64::seed_from_u64(12);
    let (mut planned, mut slowest, mut nearest) = (0, 0.0f64, f64::INFINITY);
    for _ in 0..600 {
        let line = any_line(&mut rng);
        let TensionLimits { min, max } = line.limits;
        let Some(timing) = line.fastest(0.0, f64::INFINITY) else {
            // The chords cost a little.
            let narrower = Line { limits: line.limits.shrunk(0.02), ..line };
            assert_eq!(on_a_grid(&narrower, 200), None, "{line:?}");
            continue;
        };
        planned += 1;
        let mut check = |timing: &Timing, line: &Line| {
            for k in 0..400 {
                let t = timing.duration * f64::from(k) / 400.0;
                let [least, greatest] = extremes(line, timing.at(t));
                nearest = nearest.min(least - min);
                assert!(least > min - 1e-9 && greatest < max + 1e-9, "{line:?} {t}: {least} {greatest}");
            }
        };
        check(&timing, &line);
        assert!((timing.at(timing.duration * (1.0 - 1e-12))[0] - line.length).abs() < 1e-9);
        for _ in 0..5 {
            let [s, v, _] = timing.at(rng.random_range(0.0..timing.duration));
            let stop = line.stop(s, v).unwrap();
            assert!(stop.end <= line.length + 1e-12 && stop.at(stop.duration * 0.999999)[1] < 1e-4 * v);
            check(&stop, &line);
        }
        if planned % 5 == 0 {
            let best = on_a_grid(&line, 4000).unwrap();
            slowest = slowest.max(timing.duration / best - 1.0);
        }
    }
    println!("{planned} planned, at most {slowest:.2e} slower than the bound, tensions to {nearest:.1e} N");
    assert!(planned > 400 && slowest < 1e-3, "{planned} {slowest}");
}

/// With pieces of equal length lines far off or near the base took up to a fifth longer, and some were refused.
#[test]
fn a_line_of_any_size_takes_less_than_a_thousandth_longer_than_the_optimum() {
    let mut rng = Pcg64::seed_from_u64(5);
    let (mut planned, mut refused, mut slowest, mut arcs) = (0, 0, 0.0f64, 0);
    while planned < 200 {
        let line = any_size(&mut rng);
        let Some(best) = on_a_grid(&line, 1000) else { continue };
        let Some(timing) = line.fastest(0.0, f64::INFINITY) else {
            let spare = 1e-4 * line.robot.m * line.robot.g;
            assert_eq!(
                on_a_grid(&Line { limits: line.limits.shrunk(spare), ..line }, 1000),
                None,
                "{line:?}"
            );
            refused += 1;
            continue;
        };
        planned += 1;
        slowest = slowest.max(timing.duration / best - 1.0);
        arcs = arcs.max(timing.arcs().len());
    }
    println!("{planned} planned, {refused} refused, at most {slowest:.2e} slower, {arcs} arcs");
    assert!(slowest < 1e-3 && refused < 5, "{slowest} {refused}");
}

/// Pairs of cables pull alike there, and rounding alone says which of them binds.
#[test]
fn lines_along_an_axis_of_symmetry_have_room_for_their_arcs() {
    let mut arcs = vec![];
    for (min, max) in [(0.0, 1e3), (0.5, 40.0), (1.0, 20.0), (0.2, 15.0)] {
        for to in [position(0.2, 0.0, 1.0), position(-0.2, 0.0, 0.4), position(0.0, 0.2, 0.7)] {
            let line = Line::new(&robot(), TensionLimits { min, max }, &position(0.0, 0.0, 0.4), &to);
            let timing = line.fastest(0.0, f64::INFINITY);
            assert_eq!(timing.is_some(), on_a_grid(&line, 200).is_some(), "{line:?}");
            arcs.extend(timing.map(|timing| timing.arcs().len()));
        }
    }
    println!("{arcs:?} arcs");
    assert!(arcs.len() > 5 && arcs.iter().all(|arcs| *arcs < MOST_ARCS / 2), "{arcs:?}");
}

#[test]
fn a_limit_of_speed_is_kept_and_costs_time() {
    let line = papers_move(OPEN);
    let free = line.fastest(0.0, f64::INFINITY).unwrap();
    let slow = line.fastest(0.0, 0.2).unwrap();
    let greatest = (0..=1000).map(|k| slow.at(slow.duration * 1e-3 * f64::from(k))[1]).fold(0.0, f64::max);
    assert!((greatest - 0.2).abs() < 1e-12, "{greatest}");
    assert!(slow.duration > line.length / 0.2 && slow.duration > free.duration, "{slow:?}");
    assert_eq!(line.fastest(0.3, 0.2), None);
    assert_eq!(line.fastest(0.0, 1e9), Some(free));
}

#[test]
fn a_motion_goes_on_from_its_middle_and_is_refused_where_it_is_too_fast_to_stop() {
    let line = papers_move(TensionLimits { min: 0.5, max: 40.0 });
    let whole = line.fastest(0.0, f64::INFINITY).unwrap();
    let t = 0.3 * whole.duration;
    let [s, v, _] = whole.at(t);
    let rest = Line::new(&robot(), line.limits, &line.point(s), &line.point(line.length));
    let left = rest.fastest(v, f64::INFINITY).unwrap().duration;
    assert!((left + t - whole.duration).abs() < 1e-4, "{left} {t}");
    assert_eq!(rest.fastest(3.0, f64::INFINITY), None);
}

#[test]
fn what_cannot_be_rested_at_is_refused_and_no_way_takes_no_time() {
    let to = |x: f64, z: f64| Line::new(&robot(), OPEN, &position(0.0, 0.0, 1.0), &position(x, 0.0, z));
    assert_eq!(to(0.3, 1.0).fastest(0.0, f64::INFINITY), None);
    assert_eq!(to(0.0, -1.0).fastest(0.0, f64::INFINITY), None);
    assert_eq!(to(0.0, 1.0).fastest(0.0, f64::INFINITY).unwrap().duration, 0.0);
    let heavy = TensionLimits { min: 12.0, max: 40.0 };
    assert_eq!(papers_move(heavy).fastest(0.0, f64::INFINITY), None);
}
