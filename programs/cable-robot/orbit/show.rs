//! What is said of an orbit.

use std::fmt::Write;

use cable_robot::plan::extremes::{TensionAt, extremes_of_orbit};
use cable_robot::plan::orbit::{Orbit, Part, Proof, Refusal, reach_of_p};
use cable_robot::reach::Verdict;
use cable_robot::robot::{LEAST_CABLES, Rig, Shape};
use cable_robot_report::facts::limits;
use serde_json::{Value, json};

use super::Answer;
use crate::command::{metres, number};

pub fn as_text(answer: &Answer, rig: &Rig) -> String {
    let Answer { orbit, outside, found, instead } = answer;
    let whole = orbit.trajectory();
    let [x, y, z] = [0, 1, 2].map(|k| number(orbit.centre.0[k]));
    let mut text = format!("{orbit}\n");
    let _ = writeln!(
        text,
        "about ({x}, {y}, {z}), a turn in {:.3} s, {:.3} s from rest to rest",
        orbit.period(),
        whole.end()
    );
    match found {
        Ok(proof) => text += &proved(proof, rig),
        Err(refusal) => {
            let _ = writeln!(text, "not proved: {refusal}");
            text += &advice(orbit, instead.as_ref());
        }
    }
    if outside.margin < 0.0 {
        let _ = writeln!(
            text,
            "outside the static workspace for {:.3} s, up to {} m, where a tension at rest would be {:.3} N beyond its limit",
            outside.time,
            metres(outside.farthest).trim(),
            -outside.margin
        );
    } else {
        text += "inside the static workspace all the time\n";
    }
    if let Some([p, most]) = closed_form(orbit, rig) {
        let _ =
            writeln!(text, "closed form (O4): p is at most {p:.4} m from the middle, taut below {most:.4} m");
    }
    if let Some(found) = extremes_of_orbit(rig, &whole) {
        let TensionAt { cable, tension, time, .. } = found.smallest;
        let _ =
            writeln!(text, "smallest tension on the way: {tension:.3} N in cable {cable} after {time:.3} s");
    }
    text
}

fn proved(proof: &Proof, rig: &Rig) -> String {
    let tensions =
        if rig.cables.len() == LEAST_CABLES { "every tension" } else { "at all times there are tensions" };
    format!(
        "proved: {tensions} between {:.3} and {:.3} N (limits {}, {:.3} N kept from them) on start, turns and stop, and on stops begun on the way\n\
         from any instant on the robot can be at rest within {:.3} s\n",
        proof.least,
        proof.greatest,
        limits(rig),
        proof.kept,
        proof.longest_to_rest
    )
}

fn advice(orbit: &Orbit, instead: Option<&Orbit>) -> String {
    match instead {
        None => "nothing smaller was found that is proved\n".to_owned(),
        Some(other) if other.figure != orbit.figure => {
            let radius = other.figure.radius();
            format!("  proved with the same rate and start: a radius of {radius:.4} m\n")
        }
        Some(other) => format!("  proved with a start of {:.3} s\n", other.start),
    }
}

/// (O4) and a/2 of the paper's robot about the middle, m.
fn closed_form(orbit: &Orbit, rig: &Rig) -> Option<[f64; 2]> {
    let shape = Shape::of(rig).ok()?;
    let centre = shape.to_paper(&orbit.centre);
    let is_middle = centre.0.fixed_rows::<2>(0).amax() < 1e-9 && centre.angles().amax() < 1e-9;
    is_middle.then(|| [reach_of_p(orbit, centre.0[2], shape.robot.g), 0.5 * shape.robot.a])
}

pub fn as_json(answer: &Answer, rig: &Rig) -> Value {
    let Answer { orbit, outside, found, instead } = answer;
    let whole = orbit.trajectory();
    let smallest = extremes_of_orbit(rig, &whole).map(|found| {
        let TensionAt { cable, tension, time, .. } = found.smallest;
        json!({ "cable": cable, "tension": tension, "time": time })
    });
    json!({
        "centre": orbit.centre.0.as_slice(),
        "shape": orbit.figure,
        "rate": orbit.rate,
        "period": orbit.period(),
        "turns": orbit.turns,
        "start": orbit.start,
        "duration": whole.end(),
        "proved": found.is_ok(),
        "proof": found.as_ref().ok().map(|proof| json!({
            "least": proof.least,
            "greatest": proof.greatest,
            "kept": proof.kept,
            "longestToRest": proof.longest_to_rest,
        })),
        "refusal": found.as_ref().err().map(refusal),
        "instead": instead.map(|other| json!({ "radius": other.figure.radius(), "start": other.start })),
        "outside": { "time": outside.time, "farthest": outside.farthest, "margin": outside.margin },
        "smallestTension": smallest,
    })
}

fn refusal(refusal: &Refusal) -> Value {
    let (part, begun) = match refusal.part {
        Part::Start => ("start", None),
        Part::Full => ("full", None),
        Part::Stop(begun) => ("stop", Some(begun)),
    };
    let (cable, time, tension) = match refusal.verdict {
        Verdict::NotAdmissible { cable, time, tension } => (Some(cable), Some(time), Some(tension)),
        Verdict::NoDistribution { time, .. } | Verdict::Undecided { time, .. } => (None, Some(time), None),
        Verdict::Admissible { .. } => (None, None, None),
    };
    json!({
        "part": part,
        "stopBegun": begun,
        "cable": cable,
        "time": time,
        "tension": tension,
        "inWords": refusal.to_string(),
    })
}
