//! The bridge with its controller behind the values of an instance.

use super::{GivenError, controller_parameters, say};
use crate::error::Status;
use crate::log::{Category, Log};
use crate::models::node::{
    ENABLE, GOAL_POSE, HOME, MOTOR_TENSION, POSE, RESET, STATE, STATE_NUMBER, STATUS, STATUS_NUMBER,
};
use crate::node::Node;
use crate::values::Values;
use cable_robot::plan::{ControllerParameters, Status as ControllerStatus};
use cable_robot_fieldbus::bridge::Event;
use cable_robot_fieldbus::ls_bus::{ControllerNode, Wishes, longest_step};
use cable_robot_fieldbus::{Config, State};

/// The node, and what makes it again.
pub struct Controller {
    node: ControllerNode,
    parameters: ControllerParameters,
    /// Names of the buses.
    buses: Vec<String>,
}

impl Controller {
    /// Switched on.
    ///
    /// # Errors
    /// [`GivenError`] for a parameter of the fieldbus file that the controller does not have.
    pub fn new(config: Config) -> Result<Self, GivenError> {
        let parameters = controller_parameters(&config)?;
        let buses = config.buses.iter().map(|bus| bus.name.clone()).collect();
        Ok(Self { node: ControllerNode::new(config, parameters), parameters, buses })
    }
}

impl Node for Controller {
    fn reset(&mut self) {
        self.node = ControllerNode::new(self.node.config().clone(), self.parameters);
    }

    fn longest_step(&self) -> u64 {
        longest_step(self.node.config())
    }

    fn step(&mut self, until: u64, values: &mut Values, log: &Log) {
        let wishes = Wishes {
            enable: values.boolean(&ENABLE),
            home: values.boolean(&HOME),
            reset: values.boolean(&RESET),
            goal: values.pose(&GOAL_POSE),
        };
        self.node.step(until, &wishes);
        while let Some((time, event)) = self.node.take_event() {
            report(log, time, &event);
        }
        self.write(values);
    }

    fn write(&self, values: &mut Values) {
        let report = self.node.report();
        let state = f64::from(number(self.node.state()));
        let status = report.and_then(|report| report.controller).map(|outputs| outputs.status);
        let status = f64::from(status.unwrap_or(ControllerStatus::Disabled).number());
        values.write(&STATE, [state]);
        values.write(&STATE_NUMBER, [state]);
        values.write(&STATUS, [status]);
        values.write(&STATUS_NUMBER, [status]);
        let pose = report.map_or(self.node.config().home, |report| report.pose);
        values.write(&POSE, pose.0.iter().copied());
        if let Some(report) = report {
            values.write(&MOTOR_TENSION, report.tension);
        }
    }

    fn fault(&self) -> Option<String> {
        Some(self.node.report()?.fault?.to_string())
    }

    fn receive(&mut self, bus: usize, bytes: &[u8], now: u64, log: &Log) {
        let name = &self.buses[bus];
        self.node.receive(bus, bytes, now, &mut |notice| say(log, name, notice));
    }

    fn show(&mut self, bus: usize) -> bool {
        self.node.ports()[bus].show()
    }

    fn shown(&mut self, bus: usize) -> &[u8] {
        self.node.ports()[bus].shown()
    }

    fn forget_shown(&mut self, bus: usize) {
        self.node.ports()[bus].forget_shown();
    }
}

/// Of the enumeration in the table.
fn number(state: State) -> i32 {
    match state {
        State::Configuring => 1,
        State::Homing => 2,
        State::TakingUpSlack => 3,
        State::Ready => 4,
        State::Enabled => 5,
        State::Stopping => 6,
        State::Safe => 7,
        State::Lowering => 9,
        // The others are for other programs: one that makes a survey or jogs, one that is shut down, one that only looks on.
        State::Fault | State::Trying | State::Jogging | State::Off | State::Shadow => 8,
    }
}

fn report(log: &Log, time: u64, event: &Event) {
    let (category, text) = match event {
        Event::Fault(fault) => (Category::Warning, format!("fault: {fault}")),
        Event::Emergency(emergency) => (Category::Warning, emergency.to_string()),
        Event::Lost(count) => {
            (Category::Warning, format!("{count} emergency messages came at once and were lost"))
        }
        Event::Entered(state) => (Category::Events, format!("{state}")),
        // A node of an FMU makes no survey.
        Event::Placed(..)
        | Event::Pulled { .. }
        | Event::Jogged { .. }
        | Event::Zeroed(_)
        | Event::Weighed { .. }
        | Event::NotLifted
        | Event::WatchdogTried(_)
        | Event::WatchdogProved => return,
        Event::Stopped(cause) => (Category::Events, format!("the controller's tensions ended: {cause}")),
        Event::LetGo(cause) => (Category::Events, format!("the motors are off, on the stand: {cause}")),
    };
    if log.is_enabled(category) {
        log.send(Status::Ok, category, &format!("{:.3} s after the start: {text}", time as f64 * 1e-9));
    }
}
