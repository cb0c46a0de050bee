use cable_robot::robot::{Coordinates, Pose};
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::*;
use crate::config::Config;
use crate::config::tests::{AKD, eight, parse};

/// Blocks of ±1 mm, and placing by hand.
fn accuracies(config: &Config) -> [Accuracy; 2] {
    let rig = &config.rig;
    [Accuracy::of_placing(0.001, 0.002, rig), Accuracy::of_placing(0.003, 1f64.to_radians(), rig)]
}

/// A normal deviate: the sum of twelve uniform ones.
pub fn normal(random: &mut Pcg64Mcg) -> f64 {
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

pub fn placed_badly(pose: &Pose, accuracy: &Accuracy, random: &mut Pcg64Mcg) -> Pose {
    let mut draw = |size: f64| Vector3::from_fn(|_, _| size * normal(random));
    let position = pose.position() + draw(accuracy.position);
    Pose::from_parts(&position, &(Rotation3::from_scaled_axis(draw(accuracy.angle)) * pose.rotation()))
}

/// What a bridge reads if `truth` is true and the platform is placed with errors.
pub fn measure(truth: &World, poses: &[Pose], accuracy: &Accuracy, random: &mut Pcg64Mcg) -> Vec<Placement> {
    let truth = World { home: placed_badly(&truth.home, accuracy, random), ..*truth };
    let mut read = |pose: &Pose| {
        let mut lengthening = truth.lengthening(&placed_badly(pose, accuracy, random));
        lengthening.iter_mut().for_each(|length| *length += accuracy.length * normal(random));
        Placement { pose: *pose, lengthening }
    };
    poses.iter().map(&mut read).collect()
}

/// Whether a doubt is among the explanations.
fn is_named(verdict: &Verdict, doubt: &Doubt) -> bool {
    verdict.explanations.iter().any(|explanation| match (&explanation.quantities[..], doubt) {
        ([], Doubt::Mistake(true_one)) => explanation.mistake == Some(*true_one),
        ([fitted], Doubt::Quantity(true_one, _)) => {
            explanation.mistake.is_none() && fitted.quantity == *true_one
        }
        _ => false,
    })
}

fn truth(doubt: &Doubt, file: &World) -> World {
    match doubt {
        Doubt::Mistake(mistake) => mistake.truth(file),
        Doubt::Quantity(quantity, amount) => quantity.truth(file, *amount),
    }
}

#[test]
fn what_shows_is_found_and_named_and_right_files_are_not_blamed() {
    for (k, config) in [parse(AKD).unwrap(), eight()].into_iter().enumerate() {
        let file = World::of(&config);
        for accuracy in accuracies(&config) {
            let plan = Plan::new(&config, &accuracy);
            let mut random = Pcg64Mcg::seed_from_u64(k as u64);
            println!("{}: {} poses for {accuracy:?}", config.name, plan.poses.len());
            plan.poses.iter().for_each(|pose| println!("  {:.3?}", pose.0.as_slice()));
            for (quantity, least) in plan.quantities.iter().take(9) {
                let (unit, factor) = quantity.unit();
                println!("  {quantity}: {:.1} {unit}", factor * least);
            }
            plan.hidden().for_each(|doubt| println!("  does not show: {doubt}"));
            let mut judge = |truth: &World| {
                Verdict::new(&file, &measure(truth, &plan.poses, &accuracy, &mut random), &accuracy)
            };
            let blamed = (0..100).filter(|_| !judge(&file).is_good()).count();
            assert!(blamed <= 2, "right files blamed {blamed} times of 100");
            let (mut tried, mut found, mut named) = (0, 0, 0);
            for (doubt, _) in plan.doubts.iter().filter(|(_, shown)| *shown >= NEEDED) {
                let verdict = judge(&truth(doubt, &file));
                tried += 1;
                found += usize::from(!verdict.is_good());
                named += usize::from(is_named(&verdict, doubt));
            }
            println!(
                "  {blamed} of 100 right ones blamed; of {tried} wrong ones {found} found, {named} named"
            );
            assert!(
                found >= tried - 1 && named * 100 >= tried * 95,
                "of {tried} {found} found, {named} named"
            );
        }
    }
}

#[test]
fn a_move_straight_down_cannot_tell_a_mirrored_numbering() {
    let config = parse(AKD).unwrap();
    let file = World::of(&config);
    let accuracy = accuracies(&config)[0];
    let shown = |poses: Vec<Pose>| {
        let of = |(doubt, shown): &(Doubt, f64)| match doubt {
            Doubt::Mistake(Mistake::Numbered { is_reversed: true, .. }) => Some(*shown),
            _ => None,
        };
        Plan::at(&file, poses, &accuracy).doubts.iter().filter_map(of).fold(f64::INFINITY, f64::min)
    };
    assert!(shown(vec![Pose::at(0.0, 0.0, 0.8), Pose::at(0.0, 0.0, 0.9)]) < 1e-6);
    assert!(shown(vec![Pose(Coordinates::new(0.1, 0.05, 0.85, 0.0, 0.0, 0.05))]) > NEEDED);
}

#[test]
fn several_things_that_are_wrong_together_are_named_together() {
    let config = parse(AKD).unwrap();
    let file = World::of(&config);
    let accuracy = accuracies(&config)[0];
    let plan = Plan::new(&config, &accuracy);
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut judge = |truth: World| {
        let verdict = Verdict::new(&file, &measure(&truth, &plan.poses, &accuracy, &mut random), &accuracy);
        println!("{}", verdict.explanations[0]);
        assert!(verdict.is_explained && !verdict.is_good(), "{verdict:?}");
        verdict.explanations
    };
    let names = |explanation: &Explanation| {
        explanation.quantities.iter().map(|fitted| fitted.quantity).collect::<Vec<_>>()
    };
    let exchanged = Mistake::Exchanged(0, 1);
    let explained = judge(Quantity::Home(0).truth(&exchanged.truth(&file), 0.05));
    assert!(
        explained.iter().any(|e| e.mistake == Some(exchanged) && names(e) == [Quantity::Home(0)]),
        "{explained:?}"
    );
    let radius = Quantity::Winding(None);
    let explained = judge(Quantity::Home(1).truth(&radius.truth(&file, 0.2), 0.05));
    assert!(
        explained.iter().any(|e| e.mistake.is_none()
            && names(e).len() == 2
            && names(e).contains(&radius)
            && names(e).contains(&Quantity::Home(1))),
        "{explained:?}"
    );
}

/// An exchange and a sign of another cable: no quantity is either.
#[test]
fn two_mistakes_together_are_found_and_not_called_explained() {
    let config = parse(AKD).unwrap();
    let file = World::of(&config);
    let accuracy = accuracies(&config)[0];
    let plan = Plan::new(&config, &accuracy);
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let wrong = Mistake::Exchanged(0, 1).truth(&Mistake::Sign(Some(3)).truth(&file));
    let verdict = Verdict::new(&file, &measure(&wrong, &plan.poses, &accuracy, &mut random), &accuracy);
    assert!(!verdict.is_explained && !verdict.is_good(), "{verdict:?}");
}
