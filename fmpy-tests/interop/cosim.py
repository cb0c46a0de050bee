"""libcosimpy: DNV's and SINTEF's master, with the FMI Library below it."""

from common import AT_GOAL, DELAY, DURATION, GOAL, POSE, STEP, TO_CONTROLLER, TO_PLANT, Table, check_arrival, fmu
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

NANOSECONDS = 1_000_000_000
log_output_level(CosimLogLevel.ERROR)
table = Table("libcosimpy")


def variables(execution, slave):
    return {variable.name.decode(): variable.reference for variable in execution.slave_variables(slave)}


def last(execution, seconds, slave, references, numbers=()):
    """Reals and integers of a slave after so long."""
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    assert execution.simulate_until(round(seconds * NANOSECONDS))
    return observer.last_real_values(slave, references), observer.last_integer_values(slave, list(numbers))


execution = CosimExecution.from_step_size(round(STEP * NANOSECONDS))
with table.cell("reads", 2):
    slaves = [CosimLocalSlave(fmu(2, model), model.lower()) for model in ("Controller", "Plant")]
    # Added to an execution, a file that it cannot read ends the process.
    assert all(slave.ptr() for slave in slaves), "the file cannot be read"
    controller, plant = (execution.add_local_slave(slave) for slave in slaves)
    of_controller, of_plant = variables(execution, controller), variables(execution, plant)
for name in TO_CONTROLLER:
    execution.connect_real_variables(plant, of_plant[name], controller, of_controller[name])
for name in TO_PLANT:
    execution.connect_real_variables(controller, of_controller[name], plant, of_plant[name])
for name, value in (GOAL | DELAY).items():
    execution.real_initial_value(controller, of_controller[name], value)
with table.cell("steps", 2):
    assert execution.step()
with table.cell("closes the loop", 2):
    references = [of_plant[f"encoderPose.{name}"] for name in POSE]
    check_arrival(last(execution, DURATION, plant, references)[0])
    _, [status] = last(execution, DURATION + STEP, controller, [], [of_controller["statusNumber"]])
    assert status == AT_GOAL
# It knows FMI 1 and 2, and SSP 1.0.
for row in ("reads", "steps", "closes the loop", "system", "system, closed"):
    table.unavailable(row, 3)
table.unavailable("saves a state")
table.unavailable("Model Exchange")
for row, name in [("system", "CableRobot"), ("system, closed", "CableRobotClosed")]:
    with table.cell(row, 2):
        execution = CosimExecution.from_ssp_file(f"{name}.ssp", round(STEP * NANOSECONDS))
        plant = execution.slave_index_from_instance_name("plant")
        z = variables(execution, plant)["encoderPose.z"]
        assert abs(last(execution, 0.1, plant, [z])[0][0] - 1.0) < 1e-6
table.print()
