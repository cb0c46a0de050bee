//! Random arguments and what the arithmetic of the certificates makes of them, a line each, for `checker/check_arithmetic.py`:
//!
//!     cargo run --release --example arithmetic -- functions 10000000 1 | python checker/check_arithmetic.py
//!     cargo run --release --example arithmetic -- models 100000 1 | python checker/check_arithmetic.py
//!
//! `functions`: a function of the crate libm, its argument, its value. `models`: an operation on Taylor models, its operands, its result; a model is its
//! coefficients and its error. Numbers are the 16 hexadecimal digits of a double.

use std::env;
use std::io::{self, BufWriter, Write};

use cable_robot::reach::certificate::taylor::{Taylor, combination};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn main() -> io::Result<()> {
    let arguments: Vec<_> = env::args().skip(1).collect();
    let numbers: Option<Vec<u64>> = arguments.iter().skip(1).map(|text| text.parse().ok()).collect();
    let (Some("functions" | "models"), Some([count, seed])) =
        (arguments.first().map(String::as_str), numbers.as_deref())
    else {
        return Err(io::Error::other("expected functions or models, a count and a seed"));
    };
    let mut out = BufWriter::new(io::stdout().lock());
    let mut random = Pcg64::seed_from_u64(*seed);
    for k in 0..*count {
        if arguments[0] == "functions" {
            function(k, &mut random, &mut out)?;
        } else {
            model(k, &mut random, &mut out)?;
        }
    }
    out.flush()
}

/// Of any size, as likely small as large.
fn any_size(random: &mut Pcg64, least: f64, most: f64) -> f64 {
    let (least, most) = (libm::log(least), libm::log(most));
    libm::exp(least + random.random::<f64>() * (most - least))
}

fn function(k: u64, random: &mut Pcg64, out: &mut impl Write) -> io::Result<()> {
    let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
    // Times times gains; angles, also near the zeros of sine and cosine.
    let decay = if random.random::<bool>() {
        random.random::<f64>() * 745.0
    } else {
        any_size(random, 1e-300, 745.0)
    };
    let quarters = f64::from(random.random_range(-8..=8));
    let angle = match random.random_range(0..3) {
        0 => (random.random::<f64>() - 0.5) * 8.0 * std::f64::consts::PI,
        1 => sign * any_size(random, 1e-300, 1e6),
        _ => quarters * std::f64::consts::FRAC_PI_2 + sign * any_size(random, 1e-18, 1.0),
    };
    let growth = sign * any_size(random, 1e-300, 50.0);
    let (name, argument, value) = match k % 6 {
        0 => ("exp", -decay, libm::exp(-decay)),
        1 => ("expm1", -decay, libm::expm1(-decay)),
        2 => ("sin", angle, libm::sincos(angle).0),
        3 => ("cos", angle, libm::sincos(angle).1),
        4 => ("sinh", growth, libm::sinh(growth)),
        _ => ("cosh", growth, libm::cosh(growth)),
    };
    writeln!(out, "{name} {:016x} {:016x}", argument.to_bits(), value.to_bits())
}

/// Coefficients that fall from power to power or not, about one or about nothing, with an error or without.
fn random_model(random: &mut Pcg64) -> Taylor {
    let fall = random.random::<f64>();
    let size = any_size(random, 1e-6, 1e3);
    let mut number = Taylor::ZERO;
    let mut share = size;
    for coefficient in &mut number.coefficients {
        *coefficient = share * (random.random::<f64>() - 0.5);
        share *= fall;
    }
    if random.random::<bool>() {
        number.coefficients[0] += 2.0 * size;
    }
    if random.random::<bool>() { number.widened(size * any_size(random, 1e-18, 0.1)) } else { number }
}

fn model(k: u64, random: &mut Pcg64, out: &mut impl Write) -> io::Result<()> {
    let (a, b) = (random_model(random), random_model(random));
    let factor = (random.random::<f64>() - 0.5) * 4.0;
    let rate = if random.random_range(0..8) == 0 { 0.0 } else { any_size(random, 1e-12, 50.0) };
    let half = any_size(random, 1e-9, 2.0);
    let middle = half + random.random::<f64>() * 5.0;
    let mut say = |name: &str, numbers: &[f64], models: &[&Taylor]| {
        write!(out, "{name}")?;
        for number in
            numbers.iter().chain(models.iter().flat_map(|m| m.coefficients.iter().chain([&m.error])))
        {
            write!(out, " {:016x}", number.to_bits())?;
        }
        writeln!(out)
    };
    match k % 10 {
        0 => say("add", &[], &[&a, &b, &(a + b)]),
        1 => say("sub", &[], &[&a, &b, &(a - b)]),
        2 => say("mul", &[], &[&a, &b, &(a * b)]),
        3 => say("scale", &[factor], &[&a, &(a * factor)]),
        4 => say("combination", &[factor, rate], &[&a, &b, &combination([factor, rate], [&a, &b])]),
        5 => say("inverse", &[], &[&a, &a.inverse()]),
        6 => a.sqrt().map_or(Ok(()), |root| say("sqrt", &[], &[&a, &root])),
        7 => {
            let (sin, cos) = a.sin_cos();
            say("sin", &[], &[&a, &sin]).and_then(|()| say("cos", &[], &[&a, &cos]))
        }
        8 => say("decay", &[rate, middle, half], &[&Taylor::decay(rate, middle, half)]),
        _ => say("integrated", &[rate, middle, half], &[&Taylor::integrated_decay(rate, middle, half)]),
    }
}
