//! Fig. 2: the largest normalised acceleration Z_M over the damping ratio.

use cable_robot::control::{Gains, Response};

use super::Made;
use super::chart::{Axis, COLOURS, Chart, Look, Note, Panel, Series, Side};

/// Damping ratios of which the response is shown.
const SHOWN: [f64; 4] = [1.0, 1.2, 1.5, 2.0];
/// Largest damping ratio and largest ω_n t in the picture.
const XI: f64 = 3.0;
const TIME: f64 = 6.0;
const SAMPLES: u32 = 160;

/// Left, x_s over time with its greatest value marked; right, that value over ξ.
pub fn figure_2() -> Made {
    let mut response = Panel {
        title: "x_s".to_owned(),
        x: Axis::new("ωₙ t", 0.0..TIME, 0),
        y: Axis::new("x_s = ẍ / ωₙ² (x₀ − x_d)", -1.0..0.2, 1),
        series: vec![],
        notes: vec![],
    };
    let mut peaks = vec![];
    for (xi, colour) in SHOWN.into_iter().zip(COLOURS) {
        let name = format!("ξ {xi}");
        response.series.push(Series::new(name, Look::Line, colour, x_s(xi)).in_key());
        peaks.push([peak_time(xi), gains(xi).z_m()]);
    }
    response.notes.push(Note::new(peaks[0], Side::Above, COLOURS[4], "Z_M"));
    response.series.push(Series::new("Z_M", Look::Dots, COLOURS[4], peaks));
    let over_xi = along(1.0, XI).map(|xi| [xi, gains(xi).z_m()]).collect();
    let shown: Vec<_> = SHOWN.iter().map(|xi| [*xi, gains(*xi).z_m()]).collect();
    let note = |at: &[f64; 2]| Note::new(*at, Side::Right, COLOURS[4], format!("{:.5}", at[1]));
    let z_m = Panel {
        title: "Z_M".to_owned(),
        x: Axis::new("damping ratio ξ", 1.0..XI, 1),
        y: Axis::new("Z_M = max x_s", 0.0..0.15, 2),
        notes: shown.iter().map(note).collect(),
        series: vec![
            Series::new("closed form", Look::Line, COLOURS[0], over_xi),
            Series::new("marked", Look::Dots, COLOURS[4], shown),
        ],
    };
    let values: Vec<_> = SHOWN.iter().map(|xi| format!("Z_M({xi}) = {:.5}", gains(*xi).z_m())).collect();
    let sampled = SHOWN.iter().map(|xi| {
        let highest = x_s(*xi).iter().fold(f64::MIN, |highest, [_, value]| highest.max(*value));
        (gains(*xi).z_m() - highest).abs()
    });
    Made {
        chart: Chart { size: [980, 380], columns: 2, panels: vec![response, z_m], caption: vec![] },
        findings: vec![
            values.join(", "),
            format!(
                "the highest sample of each response lies below Z_M by at most {:.5}",
                sampled.fold(0.0, f64::max)
            ),
        ],
    }
}

/// With ω_n = 1.
fn gains(xi: f64) -> Gains {
    Gains::from_damping(1.0, xi).unwrap_or(Gains { lambda: 1.0, eta: 1.0 })
}

/// x_s of Eq. (14), the acceleration of the normalised step error.
fn x_s(xi: f64) -> Vec<[f64; 2]> {
    along(0.0, TIME).map(|t| [t, Response::at(&gains(xi), t).step_error()[2]]).collect()
}

/// ω_n t = 2 acosh(ξ)/√(ξ² − 1), which is 2 at ξ = 1.
fn peak_time(xi: f64) -> f64 {
    if xi == 1.0 { 2.0 } else { 2.0 * xi.acosh() / (xi * xi - 1.0).sqrt() }
}

fn along(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..=SAMPLES).map(move |k| from + (to - from) * f64::from(k) / f64::from(SAMPLES))
}
