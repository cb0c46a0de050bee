//! How far the mathematics of the crate libm, which the domain computes with, are from those of the platform.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Numbers between two numbers, counted from one to the other.
fn ulps(a: f64, b: f64) -> u64 {
    let order = |x: f64| {
        let bits = x.to_bits() as i64;
        if bits < 0 { i64::MIN - bits } else { bits }
    };
    if a == b { 0 } else { order(a).abs_diff(order(b)) }
}

type Function = fn(f64) -> f64;

#[test]
fn libm_is_within_three_units_in_the_last_place_of_the_platforms() {
    let functions: [(&str, [f64; 2], Function, Function); 9] = [
        ("sin", [-10.0, 10.0], libm::sin, f64::sin),
        ("cos", [-10.0, 10.0], libm::cos, f64::cos),
        ("tan", [-1.5, 1.5], libm::tan, f64::tan),
        ("asin", [-1.0, 1.0], libm::asin, f64::asin),
        ("exp", [-40.0, 40.0], libm::exp, f64::exp),
        ("expm1", [-10.0, 10.0], libm::expm1, f64::exp_m1),
        ("log", [1e-9, 10.0], libm::log, f64::ln),
        ("log1p", [-0.9, 10.0], libm::log1p, f64::ln_1p),
        ("tanh", [-5.0, 5.0], libm::tanh, f64::tanh),
    ];
    let mut rng = Pcg64::seed_from_u64(60);
    for (name, [least, greatest], ours, theirs) in functions {
        let mut arguments = (0..200_000).map(|_| rng.random_range(least..greatest));
        let most = arguments.by_ref().map(|x: f64| ulps(ours(x), theirs(x))).max().unwrap();
        println!("{name}: at most {most}");
        assert!(most <= 3, "{name}: {most}");
    }
    let mut pair = |least: f64, greatest: f64| {
        [rng.random_range(-1.0..1.0), rng.random_range(least..greatest)] as [f64; 2]
    };
    let of_atan2 = (0..200_000).map(|_| pair(-1.0, 1.0)).map(|[y, x]| ulps(libm::atan2(y, x), y.atan2(x)));
    let of_atan2 = of_atan2.max().unwrap();
    let of_pow = (0..200_000).map(|_| pair(0.0, 10.0)).map(|[y, x]| ulps(libm::pow(x, y), x.powf(y)));
    let of_pow = of_pow.max().unwrap();
    println!("atan2: at most {of_atan2}\npow: at most {of_pow}");
    assert!(of_atan2 <= 3 && of_pow <= 3, "{of_atan2} {of_pow}");
}
