"""What a tool sees of a packed FMU before it runs it."""

import zipfile

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from robot_fmu import Slave, cable_names, fmu_path, pose_names

CONTROLLER = {
    "input": pose_names("encoderPose") + cable_names("cableLength") + cable_names("measuredTension")
    + pose_names("goalPose") + ["enable"],
    "output": cable_names("motorTension") + pose_names("setPoint") + ["setPointIndex"] + pose_names("estimatedPose")
    + pose_names("estimatedVelocity") + ["steady", "atGoal", "tensionMargin", "status", "goalDistance", "fault",
       "faultValue", "faultLimit"] + [f"disturbance{kind}.{axis}" for kind in ("Force", "Torque") for axis in "xyz"]
    + ["estimatedMass", "statusNumber", "faultNumber", "parametersPending"] + pose_names("reference")
    + pose_names("referenceVelocity") + pose_names("referenceAcceleration"),
    "parameter": "a b m I1 I2 I3 g lambda eta plannerPeriod bisectionSteps minTension maxTension planner poseSource "
    "forceLoop positionTolerance angleTolerance holdCompensation commandDelay observerBound accuracy "
    "massTolerance encoderResolution disturbanceBound maxSpeed maxAngularRate maxCableSpeed maxTensionRate lift largestStep plannerNumber poseSourceNumber".split(),
}
PLANT = {
    "input": cable_names("motorTension") + [f"disturbance{kind}.{axis}" for kind in ("Force", "Torque") for axis in "xyz"],
    "output": pose_names("encoderPose") + [f"{kind}.{axis}" for kind in ("velocity", "angularVelocity") for axis in "xyz"]
    + cable_names("cableLength") + cable_names("measuredTension") + cable_names("slack"),
    "parameter": "a b m I1 I2 I3 g friction motorLag encoderResolution loadCellNoise noiseSeed".split()
    + pose_names("initialPose"),
}


def test_validates_without_findings(version, model):
    assert validate_fmu(str(fmu_path(version, model))) == []


def test_has_the_variables_of_the_contract(version, model):
    description = read_model_description(str(fmu_path(version, model)))
    contract = CONTROLLER if model == "CableRobotController" else PLANT
    for causality, names in contract.items():
        found = {v.name for v in description.modelVariables if v.causality == causality}
        assert found == set(names), causality


def test_value_references_are_the_same_in_both_versions(model):
    two, three = (
        {v.name: v.valueReference for v in read_model_description(str(fmu_path(version, model))).modelVariables}
        for version in (2, 3)
    )
    assert three.pop("time") is not None
    assert two == three


def test_ships_documentation_licence_and_icon_below_2_megabytes(version, model):
    path = fmu_path(version, model)
    assert path.stat().st_size < 2_000_000
    names = zipfile.ZipFile(path).namelist()
    assert "documentation/index.html" in names
    assert {f"documentation/licenses/{name}.txt" for name in ("license", "MIT", "Apache-2.0", "THIRD-PARTY")} <= set(names)
    assert ("model.png" if version == 2 else "terminalsAndIcons/icon.png") in names
    page = zipfile.ZipFile(path).read("documentation/index.html").decode()
    assert "<svg" in page and "fmpy" in page


def test_messages_come_in_declared_categories(version, model):
    text = zipfile.ZipFile(fmu_path(version, model)).read("modelDescription.xml").decode()
    with Slave(fmu_path(version, model), debug_logging=True) as slave:
        slave.initialize()
        with pytest.raises(Exception):
            slave.step(-1.0)
        assert slave.messages
        for _status, category, _message in slave.messages:
            assert f'<Category name="{category}"' in text
