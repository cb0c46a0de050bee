"""What a user gets to read when something is wrong, and what still works afterwards."""

import math

import pytest

from robot_fmu import STATUS, ClosedLoop, Slave, fmu_path


def refusal(slave: Slave, action) -> str:
    """The FMU's message for an action that it must refuse."""
    slave.messages.clear()
    with pytest.raises(Exception):
        action()
    assert slave.messages, "refused without a word"
    return slave.messages[-1][2]


@pytest.mark.parametrize(
    "name, value, allowed",
    [("m", -1.0, "greater than 0"), ("b", 0.9, "smaller than the base"), ("lambda", 0.0, "greater than 0"),
     ("eta", -3.0, "greater than 0"), ("g", 0.0, "greater than 0"),
     ("maxTension", -1.0, "greater than minTension"), ("minTension", 200.0, "greater than minTension"),
     ("bisectionSteps", 0, "from 1"), ("plannerPeriod", 0.0, "greater than 0")],
)
def test_a_parameter_that_makes_no_sense_is_named(version, name, value, allowed):
    with Slave(fmu_path(version, "CableRobotController")) as slave:
        slave[name] = value
        slave.enter_initialization()
        message = refusal(slave, slave.exit_initialization)
        assert name in message and allowed in message, message
        slave.fmu.reset()
        slave.initialize()
        slave.step(1e-3)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_none_is_refused_and_changes_nothing(version, model, bad):
    with Slave(fmu_path(version, model)) as slave:
        inputs = [v.name for v in slave.description.modelVariables if v.causality == "input" and v.type in ("Real", "Float64")]
        assert len(inputs) >= 12
        for name in inputs:
            slave.fmu.reset()
            slave.initialize()
            saved, before = slave.save(), slave.get(inputs)
            message = refusal(slave, lambda: slave.set([name], [bad]))
            assert name in message, message
            slave.restore(saved)
            assert (slave.get(inputs) == before).all()
            slave.step(1e-3)


def test_steps_that_are_none_are_refused(version, model):
    for h in (0.0, -1e-3, math.nan, math.inf):
        with Slave(fmu_path(version, model)) as slave:
            slave.initialize()
            assert "communicationStepSize" in refusal(slave, lambda: slave.step(h))


def test_a_step_from_another_time_is_refused_and_rounding_is_not(version, model):
    with Slave(fmu_path(version, model)) as slave:
        slave.initialize()
        slave.step(0.1)
        slave.step(0.2)
        slave.step(0.1, time=0.3)
        assert slave.time != 0.4 or 0.1 + 0.2 != 0.3
        assert "currentCommunicationPoint" in refusal(slave, lambda: slave.step(0.1, time=0.7))


def test_calls_out_of_order_are_refused_with_a_word(version, model):
    with Slave(fmu_path(version, model)) as slave:
        message = refusal(slave, lambda: slave.step(1e-3))
        assert "DoStep" in message and "nstantiated" in message, message


def test_a_goal_that_cannot_be_had_is_a_status(version):
    # Beside the workspace, above the base plane, in it, and where the wrench matrix is singular.
    for goal in ((0.5, 0.0, 1.0, 0, 0, 0), (0.0, 0.0, -0.5, 0, 0, 0), (0.0, 0.0, 0.0, 0, 0, 0), (0.0, 0.0, 1.0, 0, 0, math.pi / 2)):
        with ClosedLoop(version, goal=goal) as loop:
            for _ in range(100):
                loop.step()
            assert STATUS[loop.controller["status"]] == "GoalUnreachable"
            assert loop.slack() == []


def test_a_wrong_token_is_refused(version, model):
    slave = Slave(fmu_path(version, model))
    slave.close()
    slave.description.guid = "{00000000-0000-0000-0000-000000000000}"
    if slave.fmi3:
        slave.description.instantiationToken = slave.description.guid
    from fmpy import extract, instantiate_fmu

    with pytest.raises(Exception):
        instantiate_fmu(extract(slave.path), slave.description, fmi_type="CoSimulation")


def test_folders_with_spaces_and_umlauts(version, model, tmp_path):
    from fmpy import extract, instantiate_fmu, read_model_description

    folder = tmp_path / "Prüfstand Süd mit Leerzeichen"
    folder.mkdir()
    path = str(fmu_path(version, model))
    fmu = instantiate_fmu(extract(path, str(folder)), read_model_description(path), fmi_type="CoSimulation")
    fmu.freeInstance()


