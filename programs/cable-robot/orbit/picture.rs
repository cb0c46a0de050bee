//! The picture of an orbit: its path over the static workspace, and the tensions in time.

use cable_robot::control::tensions;
use cable_robot::robot::Rig;

use super::Answer;
use crate::command::figure::chart::{Axis, BLACK, COLOURS, Chart, GREY, Look, Note, Panel, Series, Side};
use crate::command::plane::square;

/// Points of a curve of tensions.
const DRAWN: usize = 801;

pub fn chart(rig: &Rig, answer: &Answer) -> Chart {
    Chart {
        size: [1000, 476],
        columns: 2,
        panels: vec![plane(answer), in_time(rig, answer)],
        caption: vec![],
    }
}

/// Where it is outside the static workspace the path is red.
fn plane(answer: &Answer) -> Panel {
    let outside = &answer.outside;
    let border: Vec<[f64; 2]> = outside.border.iter().map(|corner| [corner.x, corner.y]).collect();
    let path: Vec<_> = outside.path.iter().map(|(_, pose, rests)| ([pose.0[0], pose.0[1]], *rests)).collect();
    let mut series = vec![Series::new("static workspace", Look::Region, GREY, border.clone()).in_key()];
    for (k, piece) in path.chunk_by(|a, b| a.1 == b.1).enumerate() {
        let points = piece.iter().map(|(point, _)| *point).collect();
        let piece = match piece[0].1 {
            true => Series::new("inside", Look::Line, BLACK, points),
            false => Series::new("outside", Look::Line, COLOURS[4], points),
        };
        series.push(if k < 2 { piece.in_key() } else { piece });
    }
    let points = || border.iter().chain(path.iter().map(|(point, _)| point));
    let [x, y] = square(points().copied());
    let (x, y) = (Axis::new("x (m)", x, 2), Axis::new("y (m)", y, 2));
    Panel { title: "path".to_owned(), x, y, series, notes: vec![] }
}

/// The tensions that the motion asks for.
fn in_time(rig: &Rig, answer: &Answer) -> Panel {
    let trajectory = answer.orbit.trajectory();
    let mut curves = vec![vec![]; rig.cables.len()];
    for k in 0..DRAWN {
        let time = trajectory.end() * k as f64 / (DRAWN - 1) as f64;
        let led = trajectory.at(time);
        let tension = tensions(rig, &led.pose, &led.rates, &led.accelerations, 0.0);
        for (i, tension) in tension.into_iter().flatten().enumerate() {
            curves[i].push([time, tension]);
        }
    }
    let all = || curves.iter().flatten().map(|[_, tension]| *tension);
    let (least, greatest) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
    let mut panel = Panel::over_time("tensions", "tension (N)", trajectory.end(), 1.05 * greatest, 0);
    panel.y.range = 1.05 * least..1.05 * greatest;
    for (i, points) in curves.into_iter().enumerate() {
        let (colour, name) = (COLOURS[i % COLOURS.len()], format!("u{}", i + 1));
        if let Some(top) = points.iter().max_by(|a, b| a[1].total_cmp(&b[1])) {
            panel.notes.push(Note::new(*top, Side::Above, colour, name.as_str()));
        }
        panel.series.push(Series::new(name, Look::Line, colour, points));
    }
    panel
}
