//! Saved states: what an instance is, and how that becomes bytes which another process takes up bit for bit.
//!
//! The bytes: `CABLEROB`, format (u32), token of the model (36 characters), length of the payload (u64), payload
//! (postcard of [`Snapshot`]), CRC-32 of all before. Numbers are little endian.

use serde::{Deserialize, Serialize};

use super::error::FmiError;
use super::lifecycle::State;
use super::models::{Interface, Model, Running, Use, Variant};
use super::values::Values;

/// All that an instance is, except for where its messages go.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    model: Model,
    pub(super) state: State,
    pub(super) stop: Option<f64>,
    pub(super) values: Values,
    /// The controller or plant. None before its first start, and when values were set since.
    pub(super) running: Option<Running>,
}

/// Value reference of the time in both models.
const TIME: u32 = 0;

impl Snapshot {
    /// As instantiated.
    pub fn new(interface: &Interface) -> Self {
        Self {
            model: interface.model(),
            state: State::Instantiated,
            stop: None,
            values: interface.start().clone(),
            running: None,
        }
    }

    /// Whose state it is.
    pub fn model(&self) -> Model {
        self.model
    }

    /// Time reached, s.
    pub fn time(&self) -> f64 {
        self.values.at(TIME)
    }

    pub(super) fn set_time(&mut self, time: f64) {
        self.values.put(TIME, time);
    }

    /// Starts the model with the values as they are.
    pub(super) fn start(&mut self, interface: &Interface) -> Result<(), FmiError> {
        let time = self.time();
        self.running = Some(interface.begin(&mut self.values, time)?);
        Ok(())
    }

    /// The state as bytes, for an instance with this interface.
    ///
    /// # Errors
    /// None that is known: a snapshot is plain data.
    pub fn to_bytes(&self, interface: &Interface) -> Result<Vec<u8>, FmiError> {
        let payload = postcard::to_stdvec(self).map_err(|error| FmiError::State(error.to_string()))?;
        let mut bytes = header(interface, FORMAT);
        bytes.extend((payload.len() as u64).to_le_bytes());
        bytes.extend(payload);
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        Ok(bytes)
    }

    /// The state that [`Snapshot::to_bytes`] wrote, for an instance with this interface.
    ///
    /// # Errors
    /// [`FmiError::State`] for bytes that are damaged, of another model, or of another version.
    pub fn from_bytes(interface: &Interface, bytes: &[u8]) -> Result<Self, FmiError> {
        let payload = payload(interface, bytes).map_err(FmiError::State)?;
        let snapshot: Self =
            postcard::from_bytes(payload).map_err(|error| FmiError::State(error.to_string()))?;
        snapshot.check(interface)?;
        Ok(snapshot)
    }

    /// Guards against bytes that were made, not saved, and against states of another rig: every value as where it is set, and a memory that a run with these
    /// values can have left.
    ///
    /// # Errors
    /// [`FmiError::State`] with the first that cannot be.
    pub(super) fn check(&self, interface: &Interface) -> Result<(), FmiError> {
        let unusable = |error| match error {
            FmiError::State(_) => error,
            other => FmiError::State(other.to_string()),
        };
        let steps = matches!(self.state, State::StepMode | State::EventMode | State::ContinuousTimeMode);
        let belongs = self.model == interface.model()
            && self.values.fits(interface)
            && self.stop.is_none_or(f64::is_finite)
            && self.state_belongs_to_use(interface)
            && (self.running.is_some() || !steps);
        if !belongs {
            return Err(FmiError::State("its parts contradict each other".to_owned()));
        }
        self.values.check(interface).map_err(unusable)?;
        match &self.running {
            Some(running) => running.check(interface, &self.values, self.time()).map_err(unusable),
            None => Ok(()),
        }
    }

    fn state_belongs_to_use(&self, interface: &Interface) -> bool {
        match self.state {
            State::StepMode => self.model.usage() == Use::CoSimulation,
            State::EventMode if interface.variant() == Variant::Full => true,
            State::EventMode | State::ContinuousTimeMode => self.model.usage() == Use::ModelExchange,
            // Only nodes on buses have it, whose states are not saved.
            State::Configuration => false,
            _ => true,
        }
    }
}

const MAGIC: &[u8; 8] = b"CABLEROB";
/// Counts up when the payload changes its shape.
const FORMAT: u32 = 8;
const TOKEN_AT: usize = 12;
const LENGTH_AT: usize = TOKEN_AT + 36;
const PAYLOAD_AT: usize = LENGTH_AT + 8;
const CHECKSUM_LENGTH: usize = 4;

fn header(interface: &Interface, format: u32) -> Vec<u8> {
    [MAGIC, &format.to_le_bytes()[..], interface.token().as_bytes()].concat()
}

/// The payload, if all that is around it is right.
fn payload<'a>(interface: &Interface, bytes: &'a [u8]) -> Result<&'a [u8], String> {
    if bytes.len() < PAYLOAD_AT + CHECKSUM_LENGTH {
        return Err(format!("{} bytes are fewer than any state has", bytes.len()));
    }
    if &bytes[..MAGIC.len()] != MAGIC {
        return Err("it was not saved by cable-robot".to_owned());
    }
    if bytes[MAGIC.len()..TOKEN_AT] != FORMAT.to_le_bytes() {
        return Err(format!("its format is not {FORMAT}, the one of this version"));
    }
    if &bytes[TOKEN_AT..LENGTH_AT] != interface.token().as_bytes() {
        let token = String::from_utf8_lossy(&bytes[TOKEN_AT..LENGTH_AT]);
        return Err(format!(
            "it belongs to the token {token:?}, {} has {}",
            interface.model().identifier(),
            interface.token()
        ));
    }
    let (body, checksum) = bytes.split_at(bytes.len() - CHECKSUM_LENGTH);
    let payload = &body[PAYLOAD_AT..];
    if body[LENGTH_AT..PAYLOAD_AT] != (payload.len() as u64).to_le_bytes() {
        return Err(format!("its payload is cut or extended to {} bytes", payload.len()));
    }
    if checksum != crc32fast::hash(body).to_le_bytes() {
        return Err("its checksum is wrong, it was damaged".to_owned());
    }
    Ok(payload)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plant() -> Interface {
        Model::Plant.interface()
    }

    #[test]
    fn a_round_trip_gives_the_same_state() {
        for interface in crate::models::MODELS.map(Model::interface) {
            let snapshot = Snapshot::new(&interface);
            let bytes = snapshot.to_bytes(&interface).unwrap();
            assert_eq!(Snapshot::from_bytes(&interface, &bytes), Ok(snapshot));
        }
    }

    #[test]
    fn every_flipped_bit_and_every_cut_is_refused() {
        let plant = plant();
        let bytes = Snapshot::new(&plant).to_bytes(&plant).unwrap();
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(Snapshot::from_bytes(&plant, &damaged).is_err(), "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert!(Snapshot::from_bytes(&plant, &bytes[..length]).is_err(), "length {length}");
        }
    }

    #[test]
    fn a_state_of_the_other_model_or_format_is_refused() {
        let (plant, controller) = (plant(), Model::Controller.interface());
        let bytes = Snapshot::new(&plant).to_bytes(&plant).unwrap();
        let message = Snapshot::from_bytes(&controller, &bytes).unwrap_err().to_string();
        assert!(message.contains(plant.token()) && message.contains(controller.token()), "{message}");

        let mut newer = bytes[..bytes.len() - CHECKSUM_LENGTH].to_vec();
        newer[MAGIC.len()] += 1;
        newer.extend(crc32fast::hash(&newer).to_le_bytes());
        assert!(Snapshot::from_bytes(&plant, &newer).unwrap_err().to_string().contains("format"));
    }

    #[test]
    fn a_state_that_contradicts_itself_is_refused() {
        let plant = plant();
        let never_started = Snapshot { state: State::StepMode, ..Snapshot::new(&plant) };
        assert!(Snapshot::from_bytes(&plant, &never_started.to_bytes(&plant).unwrap()).is_err());

        let mut not_finite = Snapshot::new(&plant);
        not_finite.values.put(1, f64::NAN);
        assert!(Snapshot::from_bytes(&plant, &not_finite.to_bytes(&plant).unwrap()).is_err());
    }
    /// An instance that took it up refused every call but a reset; the state itself could not be freed.
    #[test]
    fn a_state_in_configuration_mode_is_refused() {
        for interface in crate::models::MODELS.map(Model::interface) {
            let configured = Snapshot { state: State::Configuration, ..Snapshot::new(&interface) };
            let said = Snapshot::from_bytes(&interface, &configured.to_bytes(&interface).unwrap());
            assert!(said.unwrap_err().to_string().contains("its parts contradict each other"));
        }
    }
}
