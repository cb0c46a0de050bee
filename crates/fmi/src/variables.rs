//! What a variable of an FMU is. One table of [`Row`]s per model (`models/`) is the only place where a name, a unit or
//! a start value stands; value references, both XML files, the documentation and every check follow from it.

/// One variable of the table. A shape other than [`Shape::Scalar`] stands for several scalars: importers know scalars, so scalars are what
/// both FMI versions show. Their value references are consecutive, but for those of the seventh cable and beyond.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Value reference of the first scalar. Never changed once released, never used again for something else.
    pub first: u32,
    /// Shape [`Shape::Cables`]: value reference for the seventh cable, which has places for ten cables behind it.
    pub seventh: u32,
    /// Name as in the contract, without the suffixes of the shape.
    pub name: &'static str,
    /// How many scalars, and how they are called.
    pub shape: Shape,
    /// Type of each scalar.
    pub kind: Kind,
    /// Who gives the value.
    pub causality: Causality,
    /// When the value may change.
    pub variability: Variability,
    /// Unit of each scalar; poses and their rates have units of their own, see [`Row::unit_of`].
    pub unit: Option<&'static Unit>,
    /// Start values: none (calculated), one for all scalars, or one each.
    pub start: &'static [f64],
    /// Least value that makes sense.
    pub min: Option<f64>,
    /// Greatest value that makes sense.
    pub max: Option<f64>,
    /// A typical magnitude.
    pub nominal: Option<f64>,
    /// One sentence for the reader.
    pub description: &'static str,
    /// Outputs and what is local: the rows that influence the value in Initialization Mode. In a step of co-simulation no output depends directly
    /// on an input, since outputs change in a step only.
    pub depends_on: &'static [&'static Row],
    /// The row of states whose derivatives with respect to time these are.
    pub derivative_of: Option<&'static Row>,
}

/// How a row unfolds into scalars.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One scalar with the row's own name.
    Scalar,
    /// `.x .y .z`
    Vector,
    /// `.x .y .z .roll .pitch .yaw` in m and rad.
    Pose,
    /// The rates of a pose, in m/s and rad/s.
    PoseRate,
    /// Their accelerations, in m/s² and rad/s².
    PoseAcceleration,
    /// `[1]`, `[2]` and so on, one a cable.
    Cables,
    /// `[1].x`, `[1].y`, `[1].z`, `[2].x` and so on.
    CableVectors,
    /// `.xx .yy .zz .xy .xz .yz`: a symmetric tensor.
    Tensor,
    /// `.w .x .y .z`
    Quaternion,
}

/// Type of a scalar. Every one of them is stored exactly in an `f64`.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// FMI 3 Float64, FMI 2 Real.
    Float64,
    /// FMI 3 Int32, FMI 2 Integer.
    Int32,
    /// Stored as 0 or 1.
    Boolean,
    /// FMI 3's Clock, triggered; stored as 1 where it ticks.
    Clock,
    /// Text, of nodes on buses; it is not among the values.
    String,
    /// Numbers with names; FMI 3 reads them as Int64, FMI 2 as Integer.
    Enumeration(&'static Enumeration),
}

/// An enumeration type.
#[derive(Debug)]
pub struct Enumeration {
    /// Name of the type.
    pub name: &'static str,
    /// What is enumerated.
    pub description: &'static str,
    /// Number of the first item.
    pub first: i32,
    /// Name and meaning.
    pub items: &'static [(&'static str, &'static str)],
}

/// Who gives the value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// The time.
    Independent,
    /// The user, before the run.
    Parameter,
    /// The user, in Configuration Mode.
    Structural,
    /// The rest of the simulation.
    Input,
    /// This model.
    Output,
    /// This model, for the importer's integrator.
    Local,
}

/// When the value may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Not after initialisation.
    Fixed,
    /// Between two steps.
    Tunable,
    /// In jumps.
    Discrete,
    /// At any time.
    Continuous,
}

/// Least value of what must be greater than 0: FMI knows bounds only that are allowed themselves.
pub const ABOVE_ZERO: f64 = f64::MIN_POSITIVE;

/// A unit as exponents of SI base units.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// As written in the XML.
    pub name: &'static str,
    /// Exponents of the base units that are not zero.
    pub base: &'static [(&'static str, i32)],
    /// What it is the unit of.
    pub quantity: &'static str,
    /// What a person rather reads, and what one unit is in it.
    pub display: Option<(&'static str, f64)>,
}

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Units in use.
pub mod units {
    use super::{DEGREES, Unit};

    const fn unit(quantity: &'static str, name: &'static str, base: &'static [(&'static str, i32)]) -> Unit {
        Unit { name, base, quantity, display: None }
    }

    /// Time.
    pub const SECOND: Unit = unit("Time", "s", &[("s", 1)]);
    /// Rate.
    pub const PER_SECOND: Unit = unit("Rate", "1/s", &[("s", -1)]);
    /// Length.
    pub const METRE: Unit = unit("Length", "m", &[("m", 1)]);
    /// Speed.
    pub const METRE_PER_SECOND: Unit = unit("Velocity", "m/s", &[("m", 1), ("s", -1)]);
    /// Acceleration.
    pub const METRE_PER_SECOND2: Unit = unit("Acceleration", "m/s2", &[("m", 1), ("s", -2)]);
    /// Rate of a force.
    pub const NEWTON_PER_SECOND: Unit = unit("ForceRate", "N/s", &[("kg", 1), ("m", 1), ("s", -3)]);
    /// Angle.
    pub const RADIAN: Unit = Unit { display: Some(("deg", DEGREES)), ..unit("Angle", "rad", &[("rad", 1)]) };
    /// Angular speed.
    pub const RADIAN_PER_SECOND: Unit = Unit {
        display: Some(("deg/s", DEGREES)),
        ..unit("AngularVelocity", "rad/s", &[("s", -1), ("rad", 1)])
    };
    /// Angular acceleration.
    pub const RADIAN_PER_SECOND2: Unit = unit("AngularAcceleration", "rad/s2", &[("s", -2), ("rad", 1)]);
    /// Mass.
    pub const KILOGRAM: Unit = unit("Mass", "kg", &[("kg", 1)]);
    /// Moment of inertia.
    pub const KILOGRAM_METRE2: Unit = unit("MomentOfInertia", "kg.m2", &[("kg", 1), ("m", 2)]);
    /// Force.
    pub const NEWTON: Unit = unit("Force", "N", &[("kg", 1), ("m", 1), ("s", -2)]);
    /// Torque.
    pub const NEWTON_METRE: Unit = unit("Torque", "N.m", &[("kg", 1), ("m", 2), ("s", -2)]);
}

/// A real parameter, fixed once the simulation runs.
pub const fn parameter(
    first: u32,
    name: &'static str,
    unit: &'static Unit,
    start: &'static [f64],
    description: &'static str,
) -> Row {
    Row {
        causality: Causality::Parameter,
        variability: Variability::Fixed,
        start,
        ..output(first, name, Shape::Scalar, Some(unit), &[], description)
    }
}

/// A parameter without unit, fixed once the simulation runs.
pub const fn setting(
    first: u32,
    name: &'static str,
    kind: Kind,
    start: &'static [f64],
    description: &'static str,
) -> Row {
    Row {
        kind,
        causality: Causality::Parameter,
        variability: Variability::Fixed,
        start,
        ..output(first, name, Shape::Scalar, None, &[], description)
    }
}

/// A real input.
pub const fn input(
    first: u32,
    name: &'static str,
    shape: Shape,
    unit: Option<&'static Unit>,
    start: &'static [f64],
    description: &'static str,
) -> Row {
    Row { causality: Causality::Input, start, ..output(first, name, shape, unit, &[], description) }
}

/// A real output.
pub const fn output(
    first: u32,
    name: &'static str,
    shape: Shape,
    unit: Option<&'static Unit>,
    depends_on: &'static [&'static Row],
    description: &'static str,
) -> Row {
    Row {
        first,
        seventh: 0,
        name,
        shape,
        kind: Kind::Float64,
        causality: Causality::Output,
        variability: Variability::Continuous,
        unit,
        start: &[],
        min: None,
        max: None,
        nominal: None,
        description,
        depends_on,
        derivative_of: None,
    }
}

/// What an integrator sees of a model beside its outputs.
pub const fn local(
    first: u32,
    name: &'static str,
    shape: Shape,
    unit: Option<&'static Unit>,
    depends_on: &'static [&'static Row],
    description: &'static str,
) -> Row {
    Row { causality: Causality::Local, ..output(first, name, shape, unit, depends_on, description) }
}

impl Row {
    /// How many scalars it stands for, with so many cables.
    pub fn count(&self, cables: usize) -> usize {
        match self.shape {
            Shape::Scalar => 1,
            Shape::Vector => 3,
            Shape::Quaternion => 4,
            Shape::Pose | Shape::PoseRate | Shape::PoseAcceleration | Shape::Tensor => 6,
            Shape::Cables => cables,
            Shape::CableVectors => 3 * cables,
        }
    }

    /// Its dimensions as an array; none of a scalar.
    pub fn dimensions(&self, cables: usize) -> Vec<usize> {
        match self.shape {
            Shape::Scalar => vec![],
            Shape::CableVectors => vec![cables, 3],
            _ => vec![self.count(cables)],
        }
    }

    /// Value reference of its scalar at `position`, counted from 0.
    pub fn reference(&self, position: usize) -> u32 {
        match self.shape {
            Shape::Cables if position >= 6 => self.seventh + position as u32 - 6,
            _ => self.first + position as u32,
        }
    }

    /// Full name of the scalar at `position`.
    pub fn scalar_name(&self, position: usize) -> String {
        if let Some(state) = self.derivative_of {
            return format!("der({})", state.scalar_name(position));
        }
        let components = match self.shape {
            Shape::Scalar => return self.name.to_owned(),
            Shape::Cables => return format!("{}[{}]", self.name, position + 1),
            Shape::CableVectors => {
                let axis = ["x", "y", "z"][position % 3];
                return format!("{}[{}].{axis}", self.name, position / 3 + 1);
            }
            Shape::Vector => &["x", "y", "z"][..],
            Shape::Pose | Shape::PoseRate | Shape::PoseAcceleration => {
                &["x", "y", "z", "roll", "pitch", "yaw"]
            }
            Shape::Tensor => &["xx", "yy", "zz", "xy", "xz", "yz"],
            Shape::Quaternion => &["w", "x", "y", "z"],
        };
        format!("{}.{}", self.name, components[position])
    }

    /// The start value of the table for the scalar at `position`; outputs have none.
    pub fn start_of(&self, position: usize) -> Option<f64> {
        match self.start {
            [one] => Some(*one),
            each => each.get(position).copied(),
        }
    }

    /// Unit of the scalar at `position`.
    pub fn unit_of(&self, position: usize) -> Option<&'static Unit> {
        match (self.shape, position >= 3) {
            (Shape::Pose, false) => Some(&units::METRE),
            (Shape::Pose, true) => Some(&units::RADIAN),
            (Shape::PoseRate, false) => Some(&units::METRE_PER_SECOND),
            (Shape::PoseRate, true) => Some(&units::RADIAN_PER_SECOND),
            (Shape::PoseAcceleration, false) => Some(&units::METRE_PER_SECOND2),
            (Shape::PoseAcceleration, true) => Some(&units::RADIAN_PER_SECOND2),
            _ => self.unit,
        }
    }

    /// `exact` where a start value is the value, `calculated` for outputs and what is local; inputs and time have none in the XML.
    pub fn initial(&self) -> Option<&'static str> {
        match self.causality {
            Causality::Parameter | Causality::Structural => Some("exact"),
            Causality::Output | Causality::Local => Some("calculated"),
            Causality::Input | Causality::Independent => None,
        }
    }
}

impl Enumeration {
    /// Numbers, names and meanings.
    pub fn numbered(&self) -> impl Iterator<Item = (i32, &'static str, &'static str)> {
        (self.first..).zip(self.items).map(|(number, (name, meaning))| (number, *name, *meaning))
    }

    /// Numbers of the first and the last item.
    pub fn bounds(&self) -> [f64; 2] {
        [f64::from(self.first), f64::from(self.first) + self.items.len() as f64 - 1.0]
    }

    /// Whether an item has this number.
    pub fn has(&self, number: f64) -> bool {
        self.numbered().any(|(known, ..)| f64::from(known) == number)
    }
}

impl Kind {
    /// The type's name in FMI 3.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Float64 => "Float64",
            Kind::Int32 => "Int32",
            Kind::Boolean => "Boolean",
            Kind::Clock => "Clock",
            Kind::String => "String",
            Kind::Enumeration(_) => "Enumeration",
        }
    }
}

impl Causality {
    /// As in the XML.
    pub fn name(self) -> &'static str {
        match self {
            Causality::Independent => "independent",
            Causality::Parameter => "parameter",
            Causality::Structural => "structuralParameter",
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Local => "local",
        }
    }
}

impl Variability {
    /// As in the XML.
    pub fn name(self) -> &'static str {
        match self {
            Variability::Fixed => "fixed",
            Variability::Tunable => "tunable",
            Variability::Discrete => "discrete",
            Variability::Continuous => "continuous",
        }
    }
}
