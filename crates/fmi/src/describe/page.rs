//! documentation/index.html: one page that needs nothing from elsewhere.

use quick_xml::escape::escape;

use super::{Version, drawing, xml};
use crate::log::CATEGORIES;
use crate::models::node::{LONGEST_STEP, of_bus};
use crate::models::{Interface, Model, Scalar, Use};
use crate::variables::{ABOVE_ZERO, Causality, Row};
use cable_robot::robot::Rig;

const STYLE: &str = include_str!("page.css");

/// The page of a model.
pub fn render(interface: &Interface, version: Version) -> String {
    let model = interface.model();
    let name = model.identifier();
    let parts = [
        format!("<h1>{name}</h1>\n<p>{}.</p>", escape(interface.description())),
        interface.rig().map_or_else(frame, |rig| frame_of(interface, rig)),
        first_steps(interface),
        variables(interface, version),
        statuses(interface),
        if interface.buses().is_empty() { behaviour(model) } else { buses(interface) },
        logging(),
        limits(model),
    ];
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width\">\n<title>{name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{}\n</body>\n</html>\n",
        parts.join("\n")
    )
}

fn frame() -> String {
    format!(
        "<h2>Frame</h2>\n<p>The origin is the centre of the base, x and y lie in its plane, <strong>z points down</strong>: \
         z = 1 is one metre below the base. Units are SI, angles are in rad (shown in degrees by tools that know display \
         units). The orientation is R = Rz(yaw) Ry(pitch) Rx(roll). Cables are numbered 1 to 6 as drawn. Cables pull and \
         never push.</p>\n{}",
        drawing::robot()
    )
}

fn frame_of(interface: &Interface, rig: &Rig) -> String {
    let down = match rig.gravity {
        g if g.x == 0.0 && g.y == 0.0 && g.z > 0.0 => "<strong>z points down</strong>".to_owned(),
        g if g.x == 0.0 && g.y == 0.0 && g.z < 0.0 => "<strong>z points up</strong>".to_owned(),
        g => format!("gravity is ({}, {}, {}) m/s²", g.x, g.y, g.z),
    };
    let pulleys = match rig.cables.iter().any(|cable| cable.pulley.is_some()) {
        true => {
            " Cables that run over a swivelling pulley leave it at a moving point; their length includes the arc on it."
        }
        false => "",
    };
    format!(
        "<h2>Frame</h2>\n<p>Poses are those of the centre of mass in the frame of the rig's file: {down}. Units are SI, angles are \
         in rad (shown in degrees by tools that know display units). The orientation is R = Rz(yaw) Ry(pitch) Rx(roll). The {} cables are \
         numbered as in the file. Cables pull and never push.{pulleys}</p>",
        interface.cables()
    )
}

/// The script is about the paper's rig.
fn first_steps(interface: &Interface) -> String {
    if interface.rig().is_some() {
        return String::new();
    }
    let script = match interface.model() {
        Model::Controller => include_str!("controller.py"),
        Model::Plant => include_str!("plant.py"),
        Model::PlantExchange => include_str!("plant_exchange.py"),
        Model::Node(_) => return String::new(),
    };
    format!(
        "<h2>First steps in Python</h2>\n<p>With <code>pip install fmpy</code>:</p>\n<pre>{}</pre>",
        escape(script)
    )
}

fn variables(interface: &Interface, version: Version) -> String {
    let (inputs, outputs) = match interface.model().usage() {
        Use::CoSimulation | Use::CoSimulationWithEvents | Use::OnBuses => {
            ("Held during a step.", "Known from Initialization Mode on; they change when a step ends.")
        }
        Use::ModelExchange => {
            ("Functions of time, which may jump at events.", "Known from Initialization Mode on.")
        }
    };
    let parameters = match interface.model() {
        Model::Controller => {
            "Checked when initialisation ends, and fixed from then on, but for gains, limits and tolerances (variability tunable): those may change between two steps, and act as soon as the motion under way is proved to go on with them (parametersPending). A length, a mass or a gain must be greater than 0."
        }
        Model::Plant | Model::PlantExchange | Model::Node(_) => {
            "Checked when initialisation ends, and fixed from then on."
        }
    };
    let local = "States, their derivatives and the event indicators, for the integrator.";
    [
        ("Structural parameters", Causality::Structural, "To be set in Configuration Mode."),
        ("Parameters", Causality::Parameter, parameters),
        ("Inputs", Causality::Input, inputs),
        ("Outputs", Causality::Output, outputs),
        ("Local variables", Causality::Local, local),
    ]
    .map(|(title, causality, text)| {
        let rows: String = interface.rows_with(causality).map(|row| table_row(interface, version, row)).collect();
        if rows.is_empty() {
            return String::new();
        }
        format!(
            "<h2>{title}</h2>\n<p>{text}</p>\n<div class=\"wide\"><table>\n<tr><th>Name</th><th>Type</th><th>Unit</th>\
             <th>Start</th><th>Range</th><th>Reference</th><th>Meaning</th></tr>\n{rows}</table></div>"
        )
    })
    .into_iter()
    .filter(|table| !table.is_empty())
    .collect::<Vec<_>>()
    .join("\n")
}

fn table_row(interface: &Interface, version: Version, row: &'static Row) -> String {
    let shown = interface.scalars_of(row).filter(|scalar| interface.is_shown(scalar));
    let references: Vec<u32> = shown.map(|scalar| scalar.reference).collect();
    let runs = references.chunk_by(|a, b| a + 1 == *b).map(|run| match run {
        [one] => one.to_string(),
        _ => format!("{} to {}", run[0], run[run.len() - 1]),
    });
    let span = runs.collect::<Vec<_>>().join(", ");
    let range = match (row.min, row.max) {
        (Some(ABOVE_ZERO), Some(max)) => format!("above 0, to {max}"),
        (Some(ABOVE_ZERO), None) => "above 0".to_owned(),
        (Some(min), Some(max)) => format!("{min} to {max}"),
        (Some(min), None) => format!("from {min}"),
        (None, Some(max)) => format!("up to {max}"),
        (None, None) => String::new(),
    };
    let name = match row.derivative_of {
        Some(state) => format!("der({})", state.name),
        None => row.name.to_owned(),
    };
    let name = escape(&name);
    let suffix = |scalar: Scalar| match row.derivative_of {
        Some(state) => state.scalar_name(scalar.position)[state.name.len()..].to_owned(),
        None => scalar.name()[row.name.len()..].to_owned(),
    };
    let suffixes = interface.scalars_of(row).map(suffix).collect::<Vec<_>>().join(" ");
    format!(
        "<tr><td><code>{name}</code> <small>{suffixes}</small></td><td>{}</td><td>{}</td><td>{}</td><td>{range}</td>\
         <td>{span}</td><td>{}</td></tr>\n",
        version.type_name(interface.kind(row)),
        units(interface, row),
        start(interface, row),
        escape(row.description)
    )
}

fn units(interface: &Interface, row: &'static Row) -> String {
    let mut names: Vec<&str> =
        interface.scalars_of(row).filter_map(|s| row.unit_of(s.position)).map(|unit| unit.name).collect();
    names.dedup();
    names.join(", ")
}

/// Start values that are all the same are shown once.
fn start(interface: &Interface, row: &'static Row) -> String {
    let mut values: Vec<f64> = interface.scalars_of(row).filter_map(|s| interface.start_of(&s)).collect();
    if values.iter().all(|value| *value == values[0]) {
        values.truncate(1);
    }
    let rounded = values.into_iter().map(|value| (value * 1e4).round() / 1e4);
    rounded.map(|value| xml::number(interface.kind(row), value)).collect::<Vec<_>>().join(", ")
}

fn statuses(interface: &Interface) -> String {
    let list = |kind: &&crate::variables::Enumeration| {
        let items: String = kind
            .numbered()
            .map(|(value, name, text)| {
                format!("<tr><td>{value}</td><td><code>{name}</code></td><td>{}</td></tr>\n", escape(text))
            })
            .collect();
        format!("<h3>{}</h3>\n<p>{}.</p>\n<table>\n{items}</table>", kind.name, escape(kind.description))
    };
    let kinds: Vec<String> = xml::enumerations(interface).iter().map(list).collect();
    if kinds.is_empty() { String::new() } else { format!("<h2>Enumerations</h2>\n{}", kinds.join("\n")) }
}

fn behaviour(model: Model) -> String {
    let own = match model {
        Model::Controller => {
            "The controller samples its inputs at the start of a step and answers for the whole of it: step the controller \
             first, hand its <code>motorTension</code> to the plant, then step the plant. Velocities are estimated from the \
             measured poses; steps of 1 ms are meant."
        }
        Model::Plant => {
            "The integrator controls its own error, so that results do not depend on the step size as long as the inputs \
             are held. The tolerance of the experiment is not used."
        }
        Model::Node(_) => "",
        Model::PlantExchange => {
            "The importer integrates the 13 states. Each cable has one event indicator, <code>pull</code>: where it changes its sign the cable \
             goes slack or taut, and until the importer has found that instant the equations go on as before, so that they are smooth between \
             events. The one bend that no event marks is that of a command through zero while friction holds the cable. Directional derivatives of \
             derivatives, outputs and event indicators with respect to states and inputs are exact. The motors have no lag, encoders and load cells \
             no imperfections: those are the co-simulation plant's."
        }
    };
    let steps = match model.usage() {
        Use::CoSimulation | Use::CoSimulationWithEvents | Use::OnBuses => {
            "Steps may vary in size. The start of a step is compared with the end of the last one with a tolerance, so that 0.1 + 0.2 counts as 0.3. "
        }
        Use::ModelExchange => "",
    };
    format!(
        "<h2>Behaviour</h2>\n<p>{own}</p>\n<p>{steps}A number that is not finite is refused, and so is a \
         parameter out of range; the message names the variable, its value and what is allowed. After an error reset the \
         instance or give it back a saved state: values are as they were before the call that failed. Saved states can be \
         serialised and continue bit for bit in another process, in either version of FMI. Several instances may run in \
         one process, each in its own thread if you like. The default inertia, the paper's Table I, is not one of a rigid \
         body (I1 + I2 &lt; I3); a warning says so and the equations accept it.</p>"
    )
}

/// What there is beside the table on buses.
fn buses(interface: &Interface) -> String {
    let row = |(bus, name): (usize, &String)| {
        let cells = of_bus(bus)
            .map(|(reference, what)| format!("<td><code>{}.{what}</code> {reference}</td>", escape(name)));
        format!("<tr>{}</tr>\n", cells.concat())
    };
    let rows: String = interface.buses().iter().enumerate().map(row).collect();
    format!(
        "<h2>Buses</h2>\n<p>FMI-LS-BUS 1.0.0, network abstraction, CAN. What is received in an event is taken in when its discrete states are updated; \
         what a step sends waits for its end, where Tx_Clock ticks. A step may have the length of {} cycles; cycles at their times need a step that divides the period. \
         What is no operation is answered with Format Error, and a warning says why.</p>\n<table>\n{rows}</table>",
        LONGEST_STEP
    )
}

fn logging() -> String {
    let rows: String = CATEGORIES
        .map(|category| {
            let name = category.name().to_string_lossy();
            format!("<tr><td><code>{name}</code></td><td>{}</td></tr>\n", escape(category.description()))
        })
        .concat();
    format!(
        "<h2>Logging</h2>\n<p>A call that does not return OK always says why, even with logging off. Warnings and events are sent with \
         <code>loggingOn</code>, or by category with <code>SetDebugLogging</code>.</p>\n<table>\n{rows}</table>"
    )
}

fn limits(model: Model) -> String {
    if model.usage() == Use::OnBuses {
        return "<h2>Not tried</h2>\n<p>The FMU is tried with an importer of this project's own, on FMPy, and in no other. Saved states and \
                derivatives are not supported, as modelDescription.xml says.</p>"
            .to_owned();
    }
    let lacking = match model.usage() {
        Use::CoSimulation | Use::CoSimulationWithEvents | Use::OnBuses => {
            "Event Mode, directional derivatives and derivatives of inputs and outputs are not supported"
        }
        Use::ModelExchange => "Adjoint derivatives are not supported",
    };
    format!(
        "<h2>Not tried</h2>\n<p>The FMUs are tried in FMPy, ecospy, libcosimpy, fmu-manipulation-toolbox, pathsim-fmi, cofmupy and gemseo-fmu on \
         Linux. They were <strong>not</strong> tried with Dymola, Simulink or OpenModelica. {lacking}, as modelDescription.xml says.</p>"
    )
}
