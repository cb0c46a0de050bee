//! The variables of a model for one rig: which there are, and how values become a running controller or plant.

use uuid::Uuid;

use super::robot::{parameters, rig, rig_with_limits};
use super::{Model, NodeKind, Running, controller, exchange, plant};
use crate::error::FmiError;
use crate::values::Values;
use crate::variables::{Causality, Kind, Row};
use cable_robot::plan::{ControllerParameters, PlannerKind};
use cable_robot::robot::{Rig, RigFile, RobotParameters};

/// A model's table of variables with the start values of a rig.
#[derive(Clone, Debug)]
pub struct Interface {
    model: Model,
    rows: Vec<&'static Row>,
    /// The rig, where its geometry is not the paper's parameters.
    rig: Option<Rig>,
    name: String,
    cables: usize,
    start: Values,
    /// Row and position of each value reference.
    places: Vec<Option<(usize, usize)>>,
    variant: Variant,
    /// Names of the buses of a node.
    buses: Vec<String>,
    token: String,
}

/// How importers are shown the variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// Scalars of all types.
    Scalars,
    /// Scalars, all of them real.
    Reals,
    /// What FMI 3 knows: arrays, and a clock.
    Full,
}

/// All of them.
pub const VARIANTS: [Variant; 3] = [Variant::Scalars, Variant::Reals, Variant::Full];

/// A scalar of the table.
#[derive(Clone, Copy, Debug)]
pub struct Scalar {
    /// Its row.
    pub row: &'static Row,
    /// Its place in the row, from 0.
    pub position: usize,
    /// Its value reference.
    pub reference: u32,
}

impl Scalar {
    /// Its full name.
    pub fn name(&self) -> String {
        self.row.scalar_name(self.position)
    }

    /// Numbers are finite always, integers whole, Booleans 0 or 1 (where reals stand for them); enumerations have an item for them. Ranges of parameters are
    /// checked by the model when initialisation ends, since they may be set in any order.
    ///
    /// # Errors
    /// [`FmiError::BadValue`] with what would be right.
    pub fn check(&self, value: f64) -> Result<(), FmiError> {
        match self.row.kind {
            Kind::Enumeration(kind) if kind.has(value) => Ok(()),
            Kind::Float64 if value.is_finite() => Ok(()),
            Kind::Int32 if f64::from(value as i32) == value => Ok(()),
            Kind::Boolean if value == 0.0 || value == 1.0 => Ok(()),
            _ => Err(FmiError::bad_value(self, value)),
        }
    }
}

impl Interface {
    /// The model with the parameters of Table I.
    pub(super) fn of_paper(model: Model) -> Self {
        let rows = match model {
            Model::Controller => controller::ROWS,
            Model::Plant => plant::ROWS,
            Model::PlantExchange => exchange::ROWS,
            Model::Node(kind) => kind.rows(),
        };
        let mut start = Values::zero(rows, 6);
        for row in rows {
            for position in 0..row.count(6) {
                start.put(row.reference(position), row.start_of(position).unwrap_or(0.0));
            }
        }
        Self::new(model, rows.to_vec(), None, "Oh and Agrawal".to_owned(), start, 6)
    }

    /// The model with a rig's cables as parameters, and the rig's numbers as start values.
    pub fn of_rig(model: Model, file: &RigFile) -> Self {
        let rows = match model {
            Model::Controller => controller::rows_of(&file.rig),
            Model::Plant => plant::rows_of(plant::ROWS),
            Model::PlantExchange => plant::rows_of(exchange::ROWS),
            Model::Node(kind) => kind.rows().to_vec(),
        };
        let cables = file.rig.cables.len();
        let mut start = Values::zero(&rows, cables);
        for row in &rows {
            for position in 0..row.count(cables) {
                start.put(row.reference(position), row.start_of(position).unwrap_or(0.0));
            }
        }
        match model {
            Model::Controller => {
                let of_rig = ControllerParameters::of(&file.rig);
                let planner = PlannerKind::Exact;
                let parameters =
                    ControllerParameters { lambda: file.lambda, eta: file.eta, planner, ..of_rig };
                controller::write_start(&parameters, &file.home, &mut start);
            }
            Model::Plant | Model::PlantExchange => plant::write_start(&file.rig, &file.home, &mut start),
            Model::Node(kind) => kind.write_start(&file.home, &mut start),
        }
        Self::new(model, rows, Some(file.rig), file.name.clone(), start, cables)
    }

    /// A node on buses of these names; `texts` are the files that it is made for.
    pub fn on_buses(kind: NodeKind, file: &RigFile, buses: Vec<String>, texts: [&str; 2]) -> Self {
        let node = Self::of_rig(Model::Node(kind), file);
        let table = format!("{} {buses:?} {texts:?}", node.token);
        let token = Uuid::new_v5(&Uuid::NAMESPACE_URL, table.as_bytes()).to_string();
        Self { buses, token, ..node }
    }

    /// Names of the buses of a node, in the order of its fieldbus file.
    pub fn buses(&self) -> &[String] {
        &self.buses
    }

    fn new(
        model: Model,
        rows: Vec<&'static Row>,
        rig: Option<Rig>,
        name: String,
        start: Values,
        cables: usize,
    ) -> Self {
        let mut places = vec![];
        for (k, row) in rows.iter().enumerate() {
            for position in 0..row.count(cables) {
                let reference = row.reference(position) as usize;
                places.resize(places.len().max(reference + 1), None);
                places[reference] = Some((k, position));
            }
        }
        let of_rig = rig.map(|rig| format!("{name} {rig:?} {start:?}")).unwrap_or_default();
        let table = format!("{} {} {rows:?}{of_rig}", model.identifier(), env!("CARGO_PKG_VERSION"));
        let token = Uuid::new_v5(&Uuid::NAMESPACE_URL, table.as_bytes()).to_string();
        let (variant, buses) = (Variant::Scalars, vec![]);
        Self { model, rows, rig, name, cables, start, places, variant, buses, token }
    }

    /// The same, shown to importers otherwise.
    #[must_use]
    pub fn shown_as(self, variant: Variant) -> Self {
        match variant {
            Variant::Scalars => self,
            Variant::Reals => self.with_reals_only(),
            Variant::Full => self.with_everything(),
        }
    }

    /// The same for importers that take every variable for a real: Booleans are 0 or 1, enumerations their numbers.
    fn with_reals_only(self) -> Self {
        let token = Uuid::new_v5(&Uuid::NAMESPACE_URL, format!("{} in reals", self.token).as_bytes());
        Self { variant: Variant::Reals, token: token.to_string(), ..self }
    }

    /// The same for importers that know all of FMI 3: one array for all scalars of a row, and the controller's planner has a clock. The plant for Model
    /// Exchange stays as it is.
    fn with_everything(mut self) -> Self {
        if matches!(self.model, Model::PlantExchange | Model::Node(_)) {
            return self;
        }
        if self.model == Model::Controller {
            self.rows.push(&controller::PLANNER_TICK);
        }
        let start = self.start.grown(&self.rows);
        let token = Uuid::new_v5(&Uuid::NAMESPACE_URL, format!("{} in full", self.token).as_bytes());
        let full = Self::new(self.model, self.rows, self.rig, self.name, start, self.cables);
        Self { variant: Variant::Full, token: token.to_string(), ..full }
    }

    /// How importers are shown the variables.
    pub fn variant(&self) -> Variant {
        self.variant
    }

    /// Whether importers know a scalar by its value reference: of an array they know the first.
    pub fn is_shown(&self, scalar: &Scalar) -> bool {
        self.variant != Variant::Full || scalar.position == 0
    }

    /// The type that importers are shown of a row.
    pub fn kind(&self, row: &Row) -> Kind {
        if self.variant == Variant::Reals { Kind::Float64 } else { row.kind }
    }

    /// Which model it is.
    pub fn model(&self) -> Model {
        self.model
    }

    /// The rig, where its geometry is not the paper's parameters.
    pub fn rig(&self) -> Option<&Rig> {
        self.rig.as_ref()
    }

    /// What people call the rig.
    pub fn rig_name(&self) -> &str {
        &self.name
    }

    /// Number of cables.
    pub fn cables(&self) -> usize {
        self.cables
    }

    /// The rows of the table.
    pub fn rows(&self) -> &[&'static Row] {
        &self.rows
    }

    /// The rows with this causality.
    pub fn rows_with(&self, causality: Causality) -> impl Iterator<Item = &'static Row> {
        self.rows.iter().copied().filter(move |row| row.causality == causality)
    }

    /// The scalars of a row.
    pub fn scalars_of(&self, row: &'static Row) -> impl Iterator<Item = Scalar> + use<> {
        scalars_of(row, self.cables)
    }

    /// The scalars of some rows.
    pub fn scalars_of_all<const N: usize>(
        &self,
        rows: [&'static Row; N],
    ) -> impl Iterator<Item = Scalar> + use<N> {
        let cables = self.cables;
        rows.into_iter().flat_map(move |row| scalars_of(row, cables))
    }

    /// Every scalar, in the order of the table.
    pub fn scalars(&self) -> impl Iterator<Item = Scalar> {
        self.rows.iter().flat_map(|row| self.scalars_of(row))
    }

    /// The scalar that a value reference belongs to.
    pub fn scalar(&self, reference: u32) -> Option<Scalar> {
        let (row, position) = (*self.places.get(reference as usize)?)?;
        Some(Scalar { row: self.rows[row], position, reference })
    }

    /// The scalar of this name.
    pub fn named(&self, name: &str) -> Option<Scalar> {
        self.scalars().find(|scalar| scalar.name() == name)
    }

    /// The start values; outputs are zero until they are calculated.
    pub fn start(&self) -> &Values {
        &self.start
    }

    /// Start value of a scalar; outputs have none.
    pub fn start_of(&self, scalar: &Scalar) -> Option<f64> {
        let of = scalar.row.causality;
        let has_one = matches!(of, Causality::Parameter | Causality::Structural | Causality::Input);
        has_one.then(|| self.start.at(scalar.reference))
    }

    /// The rows that an output depends on in Initialization Mode.
    pub fn dependencies(&self, row: &'static Row) -> impl Iterator<Item = &'static Row> {
        row.depends_on.iter().copied().filter(|known| self.rows.iter().any(|row| row.first == known.first))
    }

    /// GUID (FMI 2) and instantiation token (FMI 3): derived from the table and the rig, so that an XML and a library that do
    /// not belong together are told apart.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// One sentence for the XML.
    pub fn description(&self) -> String {
        match (self.model, self.rig) {
            (Model::Node(kind), _) => kind.description(&self.name),
            (Model::Controller, None) => {
                "Controller and planner of a six-cable suspended robot: set points from which no cable goes slack".to_owned()
            }
            (Model::Plant, None) => {
                "A rigid platform on six cables that pull and never push, with a rig's imperfections".to_owned()
            }
            (Model::PlantExchange, None) => {
                "A rigid platform on six cables that pull and never push, for the integrator of the importer".to_owned()
            }
            (Model::PlantExchange, Some(_)) => format!(
                "The platform of the cable robot {} on {} cables that pull and never push, for the integrator of the importer",
                self.name, self.cables
            ),
            (Model::Controller, Some(_)) => format!(
                "Controller and planner of the cable robot {} ({} cables): set points from which no cable goes slack",
                self.name, self.cables
            ),
            (Model::Plant, Some(_)) => format!(
                "The platform of the cable robot {} on {} cables that pull and never push, with a rig's imperfections",
                self.name, self.cables
            ),
        }
    }

    /// Starts the model with the parameters and inputs in `values`, and writes its first outputs there.
    ///
    /// # Errors
    /// [`FmiError::Parameter`] naming the first parameter that makes no sense.
    pub fn begin(&self, values: &mut Values, time: f64) -> Result<Running, FmiError> {
        let running = match self.model {
            Model::Controller => Running::Controller(controller::start(self, values, time)?),
            Model::Plant => Running::Plant(plant::start(self, values)?),
            Model::PlantExchange => Running::PlantExchange(exchange::start(self, values)?),
            Model::Node(_) => return Err(FmiError::State(NOT_ITSELF.to_owned())),
        };
        running.write_outputs(values);
        Ok(running)
    }

    /// What is allowed and yet deserves a warning.
    pub fn warning(&self, values: &Values) -> Option<String> {
        let [a, b, c] = match (&self.rig, self.model) {
            (None, _) => {
                let RobotParameters { i1, i2, i3, .. } = parameters(values);
                [i1, i2, i3]
            }
            (Some(known), Model::Node(_)) => principal(known),
            (Some(known), Model::Controller) => principal(&rig_with_limits(values, known)),
            (Some(known), Model::Plant | Model::PlantExchange) => principal(&rig(values, known)),
        };
        let largest = a.max(b).max(c);
        // With equality the body is flat: rounding does not make it impossible.
        if 2.0 * largest <= (a + b + c) * (1.0 + 1e-12) {
            return None;
        }
        let moments = match self.rig {
            None => format!("I1 = {a}, I2 = {b}, I3 = {c} kg.m2"),
            Some(_) => format!("principal moments of inertia of {a}, {b} and {c} kg.m2"),
        };
        Some(format!(
            "{moments} cannot belong to a rigid body: the largest exceeds the sum of the other two. Table I of the paper is \
             such a set; the equations accept it."
        ))
    }
}

/// Why a node is not started here.
const NOT_ITSELF: &str = "a node on buses is more than its values";

fn scalars_of(row: &'static Row, cables: usize) -> impl Iterator<Item = Scalar> {
    (0..row.count(cables)).map(move |position| Scalar { row, position, reference: row.reference(position) })
}

fn principal(rig: &Rig) -> [f64; 3] {
    rig.inertia.symmetric_eigenvalues().into()
}
