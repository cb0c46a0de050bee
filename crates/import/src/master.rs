//! The co-simulation master: a set of instances, connected, stepped one after the other.

use super::{CosimError, Instance, Value, Variable};

/// Steps instances in the order given (Gauss-Seidel): before its step each one reads the newest values of what is
/// connected to it. The communication points are `start + k * step`, so that they do not drift.
pub struct Master {
    instances: Vec<Instance>,
    connections: Vec<Connection>,
    start: f64,
    step: f64,
    steps_done: u64,
}

struct Connection {
    from: (usize, Variable),
    to: (usize, Variable),
}

impl Master {
    /// Takes the instances in the order of their steps, connections as `("instance.output", "instance.input")`, and
    /// the communication step in s.
    ///
    /// # Errors
    /// [`CosimError::Setup`]: two instances of one name, an unknown instance, a step that is not positive;
    /// [`CosimError::UnknownVariable`].
    pub fn new(
        instances: Vec<Instance>,
        connections: &[(&str, &str)],
        step: f64,
    ) -> Result<Self, CosimError> {
        if !(step.is_finite() && step > 0.0) {
            return Err(CosimError::Setup(format!(
                "the step is {step} s; it must be finite and greater than 0"
            )));
        }
        for (i, instance) in instances.iter().enumerate() {
            if instances[..i].iter().any(|earlier| earlier.name() == instance.name()) {
                return Err(CosimError::Setup(format!("two instances are called {}", instance.name())));
            }
        }
        let mut master = Self { instances, connections: Vec::new(), start: 0.0, step, steps_done: 0 };
        for (from, to) in connections {
            let connection = Connection { from: master.resolve(from)?, to: master.resolve(to)? };
            master.connections.push(connection);
        }
        Ok(master)
    }

    /// Initialises all instances at time `start` (s). Within initialisation the connected values go round once for
    /// each instance, so that a chain of direct feedthrough settles whatever its order.
    ///
    /// # Errors
    /// The first that an instance reports.
    pub fn initialize(&mut self, start: f64, stop: Option<f64>) -> Result<(), CosimError> {
        (self.start, self.steps_done) = (start, 0);
        self.instances.iter().try_for_each(|instance| instance.enter_initialization(start, stop))?;
        for _ in 0..self.instances.len() {
            (0..self.instances.len()).try_for_each(|index| self.feed(index))?;
        }
        self.instances.iter().try_for_each(Instance::exit_initialization)
    }

    /// One communication step of every instance.
    ///
    /// # Errors
    /// The first that an instance reports.
    pub fn step(&mut self) -> Result<(), CosimError> {
        let time = self.time();
        for (index, instance) in self.instances.iter().enumerate() {
            self.feed(index)?;
            instance.do_step(time, self.step)?;
        }
        self.steps_done += 1;
        Ok(())
    }

    /// Ends the simulation; values can still be read.
    ///
    /// # Errors
    /// The first that an instance reports.
    pub fn terminate(&self) -> Result<(), CosimError> {
        self.instances.iter().try_for_each(Instance::terminate)
    }

    /// Time that all instances have reached, s.
    pub fn time(&self) -> f64 {
        self.start + self.steps_done as f64 * self.step
    }

    /// The instance of this name.
    ///
    /// # Errors
    /// [`CosimError::Setup`] with the names there are.
    pub fn instance(&self, name: &str) -> Result<&Instance, CosimError> {
        self.index(name).map(|index| &self.instances[index])
    }

    /// The value of `instance.variable`.
    ///
    /// # Errors
    /// An unknown name, or what the instance reports.
    pub fn get(&self, path: &str) -> Result<Value, CosimError> {
        self.read(&self.resolve(path)?)
    }

    /// Sets `instance.variable`; a connection into the same variable overwrites it in the next step.
    ///
    /// # Errors
    /// An unknown name, or what the instance reports.
    pub fn set(&self, path: &str, value: impl Into<Value>) -> Result<(), CosimError> {
        let (index, variable) = self.resolve(path)?;
        self.instances[index].set(&variable, value)
    }

    /// The instance and the variable that `instance.variable` names.
    pub(super) fn resolve(&self, path: &str) -> Result<(usize, Variable), CosimError> {
        let Some((instance, variable)) = path.split_once('.') else {
            return Err(CosimError::Setup(format!("\"{path}\" is not of the form instance.variable")));
        };
        let index = self.index(instance)?;
        Ok((index, self.instances[index].variable(variable)?.clone()))
    }

    /// Reads what [`resolve`](Self::resolve) found.
    pub(super) fn read(&self, (index, variable): &(usize, Variable)) -> Result<Value, CosimError> {
        self.instances[*index].get(variable)
    }

    fn index(&self, name: &str) -> Result<usize, CosimError> {
        self.instances.iter().position(|instance| instance.name() == name).ok_or_else(|| {
            let names: Vec<_> = self.instances.iter().map(Instance::name).collect();
            CosimError::Setup(format!("there is no instance {name}; there are: {}", names.join(", ")))
        })
    }

    /// Brings the newest values to the inputs of one instance.
    fn feed(&self, index: usize) -> Result<(), CosimError> {
        for Connection { from, to } in self.connections.iter().filter(|connection| connection.to.0 == index) {
            self.instances[index].set(&to.1, self.read(from)?)?;
        }
        Ok(())
    }
}
