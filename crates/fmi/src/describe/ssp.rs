//! SystemStructure.ssd of SSP 1.0 and 2.0: controller and plant, connected.

use std::io;

use super::Version;
use super::xml::{Xml, document, is, leaf, node};
use crate::models::{Interface, Scalar};
use crate::variables::{Causality, Kind};

const NAMESPACES: [(&str, &str); 3] = [
    ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
    ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
    ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
];

const CONTROLLER: &str = "controller";
const PLANT: &str = "plant";
/// What each reads of the other.
const OF_PLANT: [&str; 3] = ["encoderPose", "cableLength", "measuredTension"];
const OF_CONTROLLER: [&str; 1] = ["motorTension"];
/// What comes from outside, and to which of the two; what is shown outside, and of which.
const INPUTS: [(&str, &str); 3] =
    [(CONTROLLER, "goalPose"), (PLANT, "disturbanceForce"), (PLANT, "disturbanceTorque")];
const OUTPUTS: [(&str, &str); 5] = [
    (PLANT, "encoderPose"),
    (CONTROLLER, "motorTension"),
    (CONTROLLER, "atGoal"),
    (CONTROLLER, "statusNumber"),
    (CONTROLLER, "tensionMargin"),
];

/// Controller and plant as one system.
pub struct System<'a> {
    /// The controller's variables.
    pub controller: &'a Interface,
    /// The plant's.
    pub plant: &'a Interface,
    /// Of the FMUs in it. FMI 2 goes into SSP 1.0, FMI 3 into SSP 2.0.
    pub fmi: Version,
    /// Whether nothing comes from outside and nothing is shown there, for masters that know connections between components only: the goal is a parameter then.
    pub is_closed: bool,
    /// The step that masters are expected to take, s. One that steps both FMUs with what the other said a step before lets commands act that late.
    pub step: f64,
}

impl System<'_> {
    /// What connects the two FMUs, which lie in `resources/`.
    pub fn structure(&self) -> String {
        let mut root: Vec<_> = NAMESPACES.iter().map(|(name, value)| is(name, value)).collect();
        root.extend([is("name", "CableRobot"), is("version", self.version())]);
        document(|xml| {
            node(xml, "ssd:SystemStructureDescription", &root, |xml| {
                node(xml, "ssd:System", &[is("name", "CableRobot")], |xml| {
                    if !self.is_closed {
                        node(xml, "ssd:Connectors", &[], |xml| {
                            self.outside(xml, &INPUTS, "input")?;
                            self.outside(xml, &OUTPUTS, "output")
                        })?;
                    }
                    node(xml, "ssd:Elements", &[], |xml| {
                        self.component(xml, CONTROLLER)?;
                        self.component(xml, PLANT)
                    })?;
                    node(xml, "ssd:Connections", &[], |xml| self.connections(xml))
                })?;
                leaf(xml, "ssd:DefaultExperiment", &[is("startTime", 0), is("stopTime", 12)])
            })
        })
    }

    fn version(&self) -> &'static str {
        match self.fmi {
            Version::Fmi2 => "1.0",
            Version::Fmi3 => "2.0",
        }
    }

    /// The name of a number's type: that of the FMU's version.
    fn of_type(&self, kind: Kind) -> &'static str {
        self.fmi.type_name(kind)
    }

    fn of(&self, part: &str) -> &Interface {
        if part == PLANT { self.plant } else { self.controller }
    }

    /// Connectors of the system.
    fn outside(&self, xml: &mut Xml, places: &[(&str, &str)], kind: &str) -> io::Result<()> {
        for (part, row) in places {
            let interface = self.of(part);
            scalars(interface, row)
                .iter()
                .try_for_each(|scalar| self.connector(xml, interface, scalar, kind))?;
        }
        Ok(())
    }

    fn connector(&self, xml: &mut Xml, interface: &Interface, scalar: &Scalar, kind: &str) -> io::Result<()> {
        let of_type = match interface.kind(scalar.row) {
            // There as numbers, in variables of their own.
            Kind::Enumeration(_) | Kind::Clock => return Ok(()),
            kind => format!("ssc:{}", self.of_type(kind)),
        };
        node(xml, "ssd:Connector", &[is("name", scalar.name()), is("kind", kind)], |xml| {
            leaf(xml, &of_type, &[])
        })
    }

    fn component(&self, xml: &mut Xml, name: &str) -> io::Result<()> {
        let interface = self.of(name);
        let source = format!("resources/{}.fmu", interface.model().identifier());
        let attributes =
            [is("name", name), is("type", "application/x-fmu-sharedlibrary"), is("source", source)];
        node(xml, "ssd:Component", &attributes, |xml| {
            node(xml, "ssd:Connectors", &[], |xml| {
                interface.scalars().try_for_each(|scalar| match scalar.row.causality {
                    // Whether it is enabled stays as it starts: connections that start at 0 would let the platform fall.
                    Causality::Input if scalar.row.name != "enable" => {
                        self.connector(xml, interface, &scalar, "input")
                    }
                    Causality::Output => self.connector(xml, interface, &scalar, "output"),
                    _ => Ok(()),
                })
            })?;
            if name != CONTROLLER {
                return Ok(());
            }
            node(xml, "ssd:ParameterBindings", &[], |xml| {
                node(xml, "ssd:ParameterBinding", &[], |xml| {
                    node(xml, "ssd:ParameterValues", &[], |xml| self.parameters(xml))
                })
            })
        })
    }

    /// The controller's: commands act a step late, and where nothing comes from outside, the goal is where it starts.
    fn parameters(&self, xml: &mut Xml) -> io::Result<()> {
        let goal = if self.is_closed { scalars(self.controller, "goalPose") } else { vec![] };
        let goal = goal.iter().map(|scalar| (scalar.name(), self.controller.start().at(scalar.reference)));
        let values = [("commandDelay".to_owned(), self.step)].into_iter().chain(goal);
        let real = format!("ssv:{}", self.of_type(Kind::Float64));
        node(xml, "ssv:ParameterSet", &[is("version", self.version()), is("name", "start")], |xml| {
            node(xml, "ssv:Parameters", &[], |xml| {
                values.into_iter().try_for_each(|(name, value)| {
                    node(xml, "ssv:Parameter", &[is("name", name)], |xml| {
                        leaf(xml, &real, &[is("value", value)])
                    })
                })
            })
        })
    }

    fn connections(&self, xml: &mut Xml) -> io::Result<()> {
        for row in OF_PLANT {
            let scalars = scalars(self.plant, row);
            scalars.iter().try_for_each(|scalar| connection(xml, Some(PLANT), Some(CONTROLLER), scalar))?;
        }
        for row in OF_CONTROLLER {
            let scalars = scalars(self.controller, row);
            scalars.iter().try_for_each(|scalar| connection(xml, Some(CONTROLLER), Some(PLANT), scalar))?;
        }
        if self.is_closed {
            return Ok(());
        }
        for (part, row) in INPUTS {
            let scalars = scalars(self.of(part), row);
            scalars.iter().try_for_each(|scalar| connection(xml, None, Some(part), scalar))?;
        }
        for (part, row) in OUTPUTS {
            let scalars = scalars(self.of(part), row);
            scalars.iter().try_for_each(|scalar| connection(xml, Some(part), None, scalar))?;
        }
        Ok(())
    }
}

/// The scalars of a row.
fn scalars(interface: &Interface, row: &str) -> Vec<Scalar> {
    interface.scalars().filter(|scalar| scalar.row.name == row).collect()
}

fn connection(xml: &mut Xml, from: Option<&str>, to: Option<&str>, scalar: &Scalar) -> io::Result<()> {
    let name = scalar.name();
    let mut attributes = vec![];
    attributes.extend(from.map(|from| is("startElement", from)));
    attributes.push(is("startConnector", &name));
    attributes.extend(to.map(|to| is("endElement", to)));
    attributes.push(is("endConnector", &name));
    leaf(xml, "ssd:Connection", &attributes)
}
