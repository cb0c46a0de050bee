//! What may fail in the middle of a move in simulated time, and what must come of it.

use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters};
use cable_robot::sim::{ControllerModel, ModelError};
use cable_robot_fieldbus::bridge::{Cause, Fault, TransportError};
use cable_robot_fieldbus::canopen::Emergency;
use cable_robot_fieldbus::cia402::DriveState;
use cable_robot_fieldbus::frame::{Frame, FrameKind, error_class};
use cable_robot_fieldbus::simulated::Bench;
use cable_robot_fieldbus::{LibraryController, OperatorCommand};

/// Cycles of a silence that are bridged (`lost_cycles`), one that is the fault, and one that is on its way.
const SILENCE: u32 = 4 + 1 + 1;

/// Something that fails 0.4 s into the paper's move, and what must come of it.
#[derive(Clone, Copy)]
pub struct Failure {
    pub name: &'static str,
    /// What goes wrong, in the words of `rig-sim`; may be empty.
    pub words: &'static str,
    /// What goes wrong elsewhere, once and then in every cycle.
    pub once: fn(&mut Bench),
    pub every_cycle: fn(&mut Bench),
    /// Cycles after which the controller's tensions must have ended.
    pub cycles: u32,
    pub cause: fn(&Cause) -> bool,
}

const NOTHING: Failure = Failure {
    name: "",
    words: "",
    once: |_| {},
    every_cycle: |_| {},
    cycles: 1,
    cause: |cause| matches!(cause, Cause::Fault(_)),
};

pub static FAILURES: [Failure; 34] = [
    Failure {
        name: "20 % of the frames lost",
        words: "lose 20%",
        cycles: 1000,
        cause: |cause| {
            use Fault::*;
            let silent = |fault: &Fault| {
                matches!(fault, EncoderSilent { .. } | LoadCellSilent { .. } | HeartbeatLost { .. })
            };
            matches!(cause, Cause::Fault(fault) if silent(fault))
        },
        ..NOTHING
    },
    Failure {
        name: "stale encoder",
        words: "drive 3 frozen",
        cycles: SILENCE + 1,
        cause: |cause| matches!(cause, Cause::Fault(Fault::EncoderFrozen { cable: 3 })),
        ..NOTHING
    },
    Failure {
        name: "encoder silent",
        words: "drive 3 silent",
        cycles: SILENCE,
        cause: |cause| matches!(cause, Cause::Fault(Fault::EncoderSilent { cable: 3 })),
        ..NOTHING
    },
    Failure {
        name: "encoder out of range",
        words: "drive 3 jumps 20000",
        cycles: 2,
        cause: |cause| matches!(cause, Cause::Fault(Fault::EncoderJump { cable: 3, .. })),
        ..NOTHING
    },
    Failure {
        name: "load cell says NaN",
        words: "cell 4 says nan",
        cycles: SILENCE,
        cause: |cause| matches!(cause, Cause::Fault(Fault::LoadCellAbsurd { cable: 4, tension }) if tension.is_nan()),
        ..NOTHING
    },
    Failure {
        name: "load cell out of range",
        words: "cell 4 says 100000",
        cycles: SILENCE,
        cause: |cause| matches!(cause, Cause::Fault(Fault::LoadCellAbsurd { cable: 4, .. })),
        ..NOTHING
    },
    Failure {
        name: "load cell silent",
        words: "cell 4 silent",
        cycles: SILENCE,
        cause: |cause| matches!(cause, Cause::Fault(Fault::LoadCellSilent { cable: 4 })),
        ..NOTHING
    },
    Failure {
        name: "load cell stuck",
        words: "cell 4 stuck",
        cycles: 100,
        cause: |cause| {
            matches!(
                cause,
                Cause::Fault(Fault::LoadCellStuck { cable: 4 } | Fault::LoadCellDisagrees { cable: 4, .. })
            )
        },
        ..NOTHING
    },
    Failure {
        name: "load cell absurd",
        words: "cell 4 says 100",
        cycles: 25 + 2,
        cause: |cause| {
            matches!(
                cause,
                Cause::Fault(Fault::LoadCellStuck { cable: 4 } | Fault::LoadCellDisagrees { cable: 4, .. })
            )
        },
        ..NOTHING
    },
    Failure {
        name: "drive fault with EMCY",
        words: "drive 5 emcy 0x2310",
        cycles: 1,
        cause: |cause| matches!(cause, Cause::Fault(Fault::Emergency(message)) if (message.node, message.code) == (5, 0x2310)),
        ..NOTHING
    },
    Failure {
        name: "drive fault without EMCY",
        words: "drive 5 fault",
        cycles: 2,
        cause: |cause| matches!(cause, Cause::Fault(Fault::DriveFault { node: 5, state: DriveState::Fault })),
        ..NOTHING
    },
    Failure {
        name: "drive reboots",
        words: "drive 1 reboot",
        cycles: SILENCE,
        cause: |cause| {
            matches!(cause, Cause::Fault(Fault::EncoderSilent { cable: 1 } | Fault::Rebooted { node: 1 }))
        },
        ..NOTHING
    },
    Failure {
        name: "one torque frame lost, one way",
        words: "lose 0x203",
        cycles: 100 / 4 + 2,
        cause: |cause| {
            matches!(
                cause,
                Cause::Fault(
                    Fault::TorqueNotFollowed { cable: 3, .. }
                        | Fault::Emergency(Emergency { node: 3, code: 0x8250, .. })
                )
            )
        },
        ..NOTHING
    },
    Failure {
        name: "drive leaves its mode",
        words: "drive 2 mode 8",
        cycles: SILENCE,
        cause: |cause| {
            matches!(
                cause,
                Cause::Fault(
                    Fault::TorqueNotFollowed { cable: 2, .. } | Fault::ModeLeft { node: 2, found: 8 }
                )
            )
        },
        ..NOTHING
    },
    Failure {
        name: "drive does not follow (status bit 12)",
        words: "drive 5 ignores-torque",
        cycles: SILENCE,
        cause: |cause| of_drive_5(cause),
        ..NOTHING
    },
    Failure {
        name: "drive limits itself (status bit 11)",
        words: "drive 5 limited",
        cycles: SILENCE,
        cause: |cause| of_drive_5(cause),
        ..NOTHING
    },
    Failure { name: "drive stopped by somebody", words: "drive 2 stopped", cycles: SILENCE, ..NOTHING },
    Failure {
        name: "heartbeat loss",
        words: "drive 6 no-heartbeat",
        cycles: 100 / 4 + 1,
        cause: |cause| matches!(cause, Cause::Fault(Fault::HeartbeatLost { node: 6 })),
        ..NOTHING
    },
    Failure {
        name: "bus-off report",
        once: |bench| {
            let report = Frame::new(FrameKind::Error, error_class::BUS_OFF, &[0; 8]);
            report.into_iter().for_each(|frame| bench.inject(0, frame));
        },
        cause: |cause| matches!(cause, Cause::Fault(Fault::BusOff { bus: 0 })),
        ..NOTHING
    },
    Failure {
        name: "ENOBUFS, nothing sent any more",
        words: "cut",
        every_cycle: |bench| bench.bridge.on_transport_error(0, TransportError::NoRoom),
        cycles: SILENCE,
        cause: |cause| {
            matches!(
                cause,
                Cause::Fault(
                    Fault::Transport { error: TransportError::NoRoom, .. } | Fault::EncoderSilent { .. }
                )
            )
        },
        ..NOTHING
    },
    Failure {
        name: "link down",
        words: "cut",
        every_cycle: |bench| bench.bridge.on_transport_error(0, TransportError::Down),
        cause: |cause| matches!(cause, Cause::Fault(Fault::Transport { error: TransportError::Down, .. })),
        ..NOTHING
    },
    Failure {
        name: "link removed",
        words: "cut",
        every_cycle: |bench| bench.bridge.on_transport_error(0, TransportError::Gone),
        cause: |cause| matches!(cause, Cause::Fault(Fault::Transport { error: TransportError::Gone, .. })),
        ..NOTHING
    },
    Failure {
        name: "cable cut",
        words: "cut",
        cycles: SILENCE,
        cause: |cause| matches!(cause, Cause::Fault(Fault::EncoderSilent { .. })),
        ..NOTHING
    },
    Failure {
        name: "controller fails",
        once: |bench| go_wrong(bench, |_| Err("fmi3Error".into())),
        cause: |cause| matches!(cause, Cause::Fault(Fault::ControllerFailed)),
        ..NOTHING
    },
    Failure {
        name: "controller answers NaN",
        once: |bench| go_wrong(bench, |outputs| Ok(pulling(outputs, f64::NAN))),
        cause: |cause| matches!(cause, Cause::Fault(Fault::ControllerOutput { cable: 2, tension }) if tension.is_nan()),
        ..NOTHING
    },
    Failure {
        name: "controller asks for 1000 N",
        once: |bench| go_wrong(bench, |outputs| Ok(pulling(outputs, 1e3))),
        cause: |cause| matches!(cause, Cause::Fault(Fault::ControllerOutput { cable: 2, .. })),
        ..NOTHING
    },
    Failure {
        name: "controller overrun, 24 ms",
        once: |bench| _ = bench.cycle_at(bench.now + 6 * bench.bridge.config().period),
        cause: |cause| matches!(cause, Cause::Fault(Fault::Overrun { .. })),
        ..NOTHING
    },
    Failure {
        name: "clock goes back by 10 ms",
        once: |bench| _ = bench.cycle_at(bench.now - 10_000_000),
        cause: |cause| matches!(cause, Cause::Fault(Fault::ClockBackwards { .. })),
        ..NOTHING
    },
    Failure {
        name: "operator lets go",
        once: |bench| {
            bench.is_pressed = false;
            _ = bench.bridge.operator(OperatorCommand::Release, bench.now);
        },
        cause: |cause| *cause == Cause::Released,
        ..NOTHING
    },
    Failure {
        name: "operator's enable not given again",
        once: |bench| bench.is_pressed = false,
        cycles: 500 / 4 + 1,
        cause: |cause| *cause == Cause::EnableExpired,
        ..NOTHING
    },
    Failure {
        name: "shutdown (SIGTERM)",
        once: |bench| _ = bench.bridge.operator(OperatorCommand::Shutdown, bench.now),
        cause: |cause| *cause == Cause::Shutdown,
        ..NOTHING
    },
    Failure {
        name: "operator wants it down, or the input ends",
        once: |bench| {
            bench.is_pressed = false;
            _ = bench.bridge.operator(OperatorCommand::Lower, bench.now);
        },
        cause: |cause| *cause == Cause::Lower,
        ..NOTHING
    },
    Failure {
        name: "reset while it hangs",
        once: |bench| {
            bench.is_pressed = false;
            _ = bench.bridge.operator(OperatorCommand::Reset, bench.now);
        },
        cause: |cause| *cause == Cause::Reset,
        ..NOTHING
    },
    Failure {
        name: "two encoders out of range",
        once: |bench| {
            for cable in [2, 5] {
                _ = bench.suffer(&format!("drive {cable} jumps 20000"));
            }
        },
        cycles: 2,
        cause: |cause| matches!(cause, Cause::Fault(Fault::EncoderJump { .. })),
        ..NOTHING
    },
];

fn of_drive_5(cause: &Cause) -> bool {
    matches!(
        cause,
        Cause::Fault(Fault::TorqueNotFollowed { cable: 5, .. } | Fault::DriveDisobeys { node: 5, .. })
    )
}

/// A controller that is well and then is not.
struct Failing {
    controller: LibraryController,
    answer: fn(ControllerOutputs) -> Result<ControllerOutputs, ModelError>,
}

impl ControllerModel for Failing {
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        self.controller.start(inputs)
    }

    fn step(
        &mut self,
        time: f64,
        h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        (self.answer)(self.controller.step(time, h, inputs)?)
    }
}

fn go_wrong(bench: &mut Bench, answer: fn(ControllerOutputs) -> Result<ControllerOutputs, ModelError>) {
    let controller = LibraryController::new(ControllerParameters::default());
    bench.controller = Box::new(Failing { controller, answer });
}

fn pulling(mut outputs: ControllerOutputs, tension: f64) -> ControllerOutputs {
    outputs.motor_tension[1] = tension;
    outputs
}
