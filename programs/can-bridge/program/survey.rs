//! `--survey`: which poses to place the platform at, what was measured there, and what that says of the files.

use std::path::Path;
use std::sync::Mutex;

use anyhow::Result;
use cable_robot::robot::{PerCable, Pose};
use cable_robot_fieldbus::bridge::{Event, Identity};
use cable_robot_fieldbus::commission::{
    self, Accuracy, Gains, NEEDED, Placement, Plan, Quantity, Verdict, Weighing, World,
};
use cable_robot_fieldbus::{Config, State};

use super::calibration::{self, Calibration, Numbers};
use super::commissioned::{self, Record, Step};
use super::terminal::say;

/// An encoder that moved by less did not move, m.
const NOTHING: f64 = 1e-4;

/// What a load cell may say of a slack cable, as a share of `limits.disagreement`, which is for friction as well.
const SHARE_AT_REST: f64 = 0.25;

/// What is asked for, and what was measured so far. Operator and journal have it in common, the loop knows nothing of it.
pub struct Survey {
    file: World,
    accuracy: Accuracy,
    plan: Plan,
    /// What a load cell may say of a slack cable, N.
    most_at_rest: f64,
    /// By how much load cells that were zeroed may be off together, kg.
    mass_accuracy: f64,
    numbers: Mutex<Numbers>,
    /// Steps that were passed, and the pull that waits for what a person saw.
    passed: Mutex<Vec<Step>>,
    pulled: Mutex<Option<usize>>,
}

impl Survey {
    /// For a platform that is placed with errors of these standard deviations, m and rad.
    pub fn new(config: &Config, (position, angle): (f64, f64)) -> Self {
        let accuracy = Accuracy::of_placing(position, angle, &config.rig);
        let up = -config.rig.gravity.normalize();
        let lift: f64 = config
            .rig
            .cables_at(&config.home)
            .direction
            .iter()
            .map(|direction| direction.dot(&up).abs())
            .sum();
        Self {
            file: World::of(config),
            plan: Plan::new(config, &accuracy),
            accuracy,
            most_at_rest: config.limits.disagreement,
            mass_accuracy: SHARE_AT_REST * config.limits.disagreement * lift / config.rig.gravity.norm(),
            numbers: Mutex::default(),
            passed: Mutex::new(vec![]),
            pulled: Mutex::new(None),
        }
    }

    /// Takes in what the bridge says, and says what is to be done; nothing where that is clear.
    pub fn follow(&self, event: &Event) -> Option<String> {
        match event {
            Event::Entered(State::Homing) => Some(self.open_steps()),
            Event::Entered(State::Ready) => Some(self.next()),
            Event::Placed(pose, lengthening) => Some(self.take(*pose, *lengthening)),
            Event::Zeroed(reading) => {
                self.measured(|numbers| numbers.zero = Some(*reading));
                Some(self.advice(reading))
            }
            Event::WatchdogProved => {
                self.pass(Step::Watchdog);
                None
            }
            Event::Weighed { mass, pose, reading, .. } => {
                self.measured(|numbers| numbers.weighings.push(Weighing { pose: *pose, reading: *reading }));
                Some(self.judge_weight(*mass))
            }
            Event::Pulled { cable, came_in, tension } => {
                self.measured(|numbers| _ = numbers.pulls.insert(*cable, (*tension, *came_in)));
                let is_right = farthest(came_in) == (*cable, true);
                *self.pulled.lock().ok()? = is_right.then_some(*cable);
                is_right.then(|| format!("yes (key y) if you saw cable {} come in, and no other", cable + 1))
            }
            _ => None,
        }
    }

    fn measured(&self, note: impl FnOnce(&mut Numbers)) {
        if let Ok(mut numbers) = self.numbers.lock() {
            note(&mut numbers);
        }
    }

    fn numbers(&self) -> Numbers {
        self.numbers.lock().map_or_else(|_| Numbers::default(), |numbers| numbers.clone())
    }

    /// Mass and load cells agree, or one of them is wrong.
    fn judge_weight(&self, mass: f64) -> String {
        let (believed, most) = (self.file.rig.mass, self.mass_accuracy);
        let is_right = (mass - believed).abs() <= most;
        let mut text = if is_right {
            format!(
                "the rig file says {believed} kg: right within the {most:.2} kg that load cells may be off by"
            )
        } else {
            format!(
                "THE RIG FILE SAYS {believed} kg, and load cells are off by {most:.2} kg at most: correct platform.mass, or the cells' scale"
            )
        };
        let Some(gains) = self.gains() else { return text };
        let wrong: Vec<_> = (0..gains.gain.len()).filter(|i| gains.is_blamed(*i)).map(|i| i + 1).collect();
        if is_right && wrong.is_empty() {
            self.pass(Step::Weigh);
        }
        text += &format!("; {}", calibration::gains_text(&gains));
        if is_right && !wrong.is_empty() {
            text += &format!("; THE LOAD CELLS OF CABLES {wrong:?} ARE WRONG: correct their scale");
        }
        text
    }

    /// What load cells say for a newton, from what was weighed.
    fn gains(&self) -> Option<Gains> {
        // Anything up to what zeroed cells may say of nothing.
        let noise = SHARE_AT_REST * self.most_at_rest / 3f64.sqrt();
        Gains::new(&self.file.rig, &self.numbers().weighings, noise)
    }

    /// A person saw what the last pull was to show.
    pub fn confirm(&self) -> String {
        match self.pulled.lock().ok().and_then(|mut pulled| pulled.take()) {
            Some(cable) => {
                self.pass(Step::Pull(cable));
                format!("motor and encoder of cable {} are its own; {}", cable + 1, self.open_steps())
            }
            None => "yes to what? no pull waits for it".to_owned(),
        }
    }

    /// Whether a person saw in this session that the motor of a cable (from 0) hauls its own cable in.
    pub fn knows(&self, cable: usize) -> bool {
        self.passed().contains(&Step::Pull(cable))
    }

    fn pass(&self, step: Step) {
        self.passed.lock().iter_mut().for_each(|passed| passed.push(step));
    }

    fn passed(&self) -> Vec<Step> {
        self.passed.lock().map_or(vec![], |passed| passed.clone())
    }

    fn open_steps(&self) -> String {
        let passed = self.passed();
        let open = Step::all(self.file.scale.len()).into_iter().filter(|step| !passed.contains(step));
        format!("not done in this session: {}", open.map(Step::name).collect::<Vec<_>>().join(", "))
    }

    /// The verdict, and the steps passed into the record. Whether the rig is commissioned now.
    pub fn conclude(&self, fieldbus: &Path, config: &Config, drives: &PerCable<Identity>) -> Result<bool> {
        let (text, is_good) = self.verdict();
        say(text);
        if is_good {
            self.pass(Step::Poses);
        }
        self.calibrate(fieldbus, config)?;
        let (mut record, passed) = (Record::read(fieldbus)?, self.passed());
        if !passed.is_empty() {
            record.note(&passed, config, drives);
            record.write(fieldbus)?;
            say(format_args!("can-bridge: {} written", commissioned::path(fieldbus).display()));
        }
        let missing = record.missing(config);
        if !missing.is_empty() {
            say(format_args!("can-bridge: still to be commissioned: {}", missing.join(", ")));
        }
        Ok(missing.is_empty())
    }

    /// Keeps the numbers that were measured, and offers what they tell.
    fn calibrate(&self, fieldbus: &Path, config: &Config) -> Result<()> {
        let numbers = self.numbers();
        let found = commission::Calibration::new(&self.file, &numbers.placements, &self.accuracy);
        let offer = found.as_ref().map_or(String::new(), |found| calibration::offer(&self.file, found));
        if !offer.is_empty() {
            say(offer);
        }
        let mut file = Calibration::read(fieldbus)?;
        file.note(&numbers, config, &self.accuracy, found.as_ref(), self.gains().as_ref());
        file.write(fieldbus)?;
        say(format_args!("can-bridge: {} written", calibration::path(fieldbus).display()));
        Ok(())
    }

    /// What to do about what load cells say of slack cables.
    fn advice(&self, reading: &PerCable<f64>) -> String {
        match reading.iter().position(|reading| reading.abs() > self.most_at_rest) {
            Some(i) => format!("is cable {} slack? its cell is off by more than limits.disagreement", i + 1),
            None => {
                let is_small = |reading: &f64| reading.abs() <= SHARE_AT_REST * self.most_at_rest;
                if reading.iter().all(is_small) {
                    self.pass(Step::Zero);
                    return "load cells are zero enough".to_owned();
                }
                "take these off each offset of the fieldbus file; then zero again".to_owned()
            }
        }
    }

    /// The pose that is asked for next.
    pub fn asked(&self) -> Option<Pose> {
        self.plan.poses.get(self.numbers().placements.len()).copied()
    }

    /// Takes in what was measured, and says what comes next.
    fn take(&self, pose: Pose, lengthening: PerCable<f64>) -> String {
        self.measured(|numbers| numbers.placements.push(Placement { pose, lengthening }));
        self.next()
    }

    /// What a person is to do.
    fn next(&self) -> String {
        match self.asked() {
            Some(pose) => format!("put the platform at {}, let it rest, then placed (key p)", at(&pose)),
            None => "every pose was measured: put the platform back on its stand at home and hold weigh (key m), or shutdown (key q) for the verdict".to_owned(),
        }
    }

    /// What `--check` prints.
    pub fn text(&self) -> String {
        let Accuracy { position, angle, length } = self.accuracy;
        let mut text = format!(
            "\nsurvey: the platform placed with standard deviations of {} m and {} rad, lengths read with {} m\n\
             place it at (x y z in m, yaw in degrees, level; home is read first)\n",
            position, angle, length
        );
        for (pose, number) in self.plan.poses.iter().zip(1..) {
            text += &format!("  {number}  {}\n", at(pose));
        }
        let (shown, all) = (self.plan.doubts.len() - self.plan.hidden().count(), self.plan.doubts.len());
        text += &format!(
            "of {all} mistakes looked for {shown} show there by {NEEDED} standard deviations or more\n"
        );
        if shown < all {
            text += "these do not:\n";
        }
        self.plan.hidden().for_each(|doubt| text += &format!("  {doubt}\n"));
        text += "the least that shows of each measure:\n";
        let of_end = |(quantity, _): &&(Quantity, f64)| {
            matches!(quantity, Quantity::Anchor(..) | Quantity::Attachment(..))
        };
        for (quantity, least) in self.plan.quantities.iter().filter(|entry| !of_end(entry)) {
            let (unit, factor) = quantity.unit();
            text += &format!("  {quantity}: {:.1} {unit}\n", factor * least);
        }
        let ends = self.plan.quantities.iter().filter(of_end).map(|(_, least)| 1e3 * least);
        let (least, most) =
            ends.fold((f64::INFINITY, 0.0), |(least, most), end| (end.min(least), end.max(most)));
        text + &format!("  an anchor or an attachment, along an axis: {least:.1} to {most:.1} mm\n")
    }

    /// What was found, and whether the files may be trusted: every pose was measured, and nothing else explains the lengths better.
    fn verdict(&self) -> (String, bool) {
        let measured = self.numbers().placements;
        let poses = self.plan.poses.len();
        if measured.len() < poses {
            return (format!("survey: not whole, {} of {poses} poses were measured", measured.len()), false);
        }
        let verdict = Verdict::new(&self.file, &measured, &self.accuracy);
        let residual = verdict.residual;
        if verdict.is_good() {
            let text = "survey: lengths and poses agree as the files say";
            return (format!("{text}: {residual:.2} standard deviations on average"), true);
        }
        let mut text =
            "survey: THE FILES ARE WRONG, or the platform was placed worse than was said\n".to_owned();
        text += if verdict.is_explained {
            "explained by\n"
        } else {
            "nothing looked for explains it alone; best does\n"
        };
        for explanation in &verdict.explanations {
            text += &format!("  {explanation}\n");
        }
        text += &format!("which leaves {residual:.2} standard deviations on average");
        (text, false)
    }
}

/// What load cells say of slack cables.
pub fn zeroed_text(reading: &PerCable<f64>) -> String {
    let cells: Vec<_> =
        (1..).zip(reading.iter()).map(|(cable, reading)| format!("{cable}: {reading:+.3}")).collect();
    format!("load cells with slack cables, N: {}", cells.join("  "))
}

/// What a motor's pull showed, and what a person is to see.
pub fn pulled_text(cable: usize, tension: f64, came_in: &PerCable<f64>) -> String {
    let millimetres = came_in.map(|way| 1e3 * way);
    let farthest =
        (0..came_in.len()).fold(0, |far, i| if came_in[i].abs() > came_in[far].abs() { i } else { far });
    let number = cable + 1;
    let shown = match (farthest == cable, millimetres[farthest]) {
        (_, way) if way.abs() < 0.1 => {
            "no encoder moved: the cable is taut, or the motor is stuck".to_owned()
        }
        (true, way) if way > 0.0 => format!("its encoder says that the cable came in by {way:.1} mm"),
        (true, way) => format!(
            "its encoder says that the cable went OUT by {:.1} mm: sign or winding sense is wrong",
            -way
        ),
        (false, way) => {
            format!("the encoder of cable {} says {way:+.1} mm, not its own: exchanged", farthest + 1)
        }
    };
    format!("the motor of cable {number} pulled {tension:.2} N: {shown}")
}

/// The cable whose encoder moved farthest, and whether it came in.
fn farthest(came_in: &PerCable<f64>) -> (usize, bool) {
    let farther = |far: usize, i: usize| if came_in[i].abs() > came_in[far].abs() { i } else { far };
    let farthest = (0..came_in.len()).fold(0, farther);
    (farthest, came_in[farthest] > NOTHING)
}

/// A pose for people, m and degrees.
pub fn at(pose: &Pose) -> String {
    let (position, [roll, pitch, yaw]) = (pose.position(), pose.angles().map(f64::to_degrees).into());
    let mut text = format!("{:.3} {:.3} {:.3}, yaw {:.1}", position.x, position.y, position.z, yaw + 0.0);
    if roll.abs() > 0.05 || pitch.abs() > 0.05 {
        text += &format!(", roll {roll:.1}, pitch {pitch:.1}");
    }
    text
}

/// Reads `POSITION,ANGLE`.
pub fn accuracy(text: &str) -> Result<(f64, f64), String> {
    let allowed = "expected two standard deviations greater than 0, m and rad, such as 0.003,0.02";
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [position, angle] if (1e-9..1e3).contains(&position) && (1e-9..1.0).contains(&angle) => {
            Ok((position, angle))
        }
        _ => Err(allowed.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::tests::config;

    #[test]
    fn a_survey_asks_for_its_poses_one_after_the_other_and_is_good_only_when_whole() {
        let survey = Survey::new(&config(), (0.001, 0.002));
        assert!(survey.text().contains("the least that shows"), "{}", survey.text());
        while let Some(pose) = survey.asked() {
            assert!(!survey.verdict().1 && survey.verdict().0.contains("not whole"));
            let said = survey.take(pose, survey.file.lengthening(&pose));
            assert!(said.contains("put the platform at") || said.contains("every pose"), "{said}");
        }
        assert!(survey.next().contains("verdict"));
        assert!(survey.verdict().1, "{}", survey.verdict().0);
        let one_more = Pose::at(0.0, 0.1, 0.9);
        survey.take(one_more, PerCable::filled(6, 0.05));
        let (text, is_good) = survey.verdict();
        assert!(!is_good && text.contains("THE FILES ARE WRONG"), "{text}");
    }

    #[test]
    fn a_load_cell_that_says_much_of_a_slack_cable_is_not_to_be_zeroed() {
        let survey = Survey::new(&config(), (0.001, 0.002));
        let mut reading = PerCable::filled(6, 0.2);
        assert!(survey.advice(&reading).contains("zero enough") && survey.passed() == [Step::Zero]);
        reading[1] = 1.0;
        assert!(survey.advice(&reading).contains("take these off"));
        reading[3] = -40.0;
        assert!(survey.advice(&reading).contains("is cable 4 slack?"));
    }

    #[test]
    fn what_a_pull_shows_is_said() {
        let mut came_in = PerCable::filled(6, 0.0);
        assert!(pulled_text(2, 3.0, &came_in).contains("no encoder moved"));
        came_in[2] = 0.006;
        assert!(pulled_text(2, 0.4, &came_in).contains("came in by 6.0 mm"));
        came_in[2] = -0.006;
        assert!(pulled_text(2, 0.4, &came_in).contains("went OUT by 6.0 mm"));
        came_in = PerCable::filled(6, 0.0);
        came_in[4] = 0.006;
        assert!(pulled_text(2, 0.4, &came_in).contains("encoder of cable 5"));
    }

    #[test]
    fn an_accuracy_is_two_lengths_that_make_sense() {
        assert_eq!(accuracy("0.003, 0.02"), Ok((0.003, 0.02)));
        for text in ["", "1", "0,1", "0.1,-1", "nan,0.1", "0.1,0.1,0.1", "0.1,inf"] {
            assert!(accuracy(text).unwrap_err().contains("such as 0.003,0.02"), "{text}");
        }
    }
}
