"""Systems, and importers of others that are quick to install; `cargo interop` tries all."""

import ctypes
import itertools
import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pyssp_standard
import pytest
from lxml import etree

from robot_fmu import Slave, cable_names, fmu_path, packed, pose_names

HERE = Path(__file__).resolve().parent
SCHEMAS = Path(pyssp_standard.__file__).parent / "resources"
STEP = 1e-3
COUPLED = pose_names("encoderPose") + cable_names("cableLength") + cable_names("measuredTension")


def require_tbb():
    """Of ecospy. A user may lack it, continuous integration may not."""
    try:
        ctypes.CDLL("libtbb.so.12")
    except OSError:
        if "CI" not in os.environ:
            pytest.skip("ecospy needs Debian's libtbb12")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return packed(tmp_path_factory.mktemp("systems"), "--ssp", rig="paper")


@pytest.mark.parametrize("tool", ["fmpy_now", "ecos", "cosim", "toolbox"])
def test_what_a_tool_could_do_it_still_can(folder, tool):
    """The table of docs/interop.md."""
    if tool == "ecos":
        require_tbb()
    done = subprocess.run([sys.executable, HERE / "interop" / f"{tool}.py"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) in json.loads((HERE / "interop/expected.json").read_text())


@pytest.mark.parametrize("system, schemas", [("CableRobot", "."), ("CableRobotClosed", "."), ("CableRobotFMI3", "ssp2")])
def test_a_system_fits_the_schema_of_its_version(folder, system, schemas):
    names = {"ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues"}
    with zipfile.ZipFile(folder / f"{system}.ssp") as archive:
        document = etree.fromstring(archive.read("SystemStructure.ssd"))
    for part, name in [(document, "Description"), (document.find(".//ssv:ParameterSet", names), "ParameterValues")]:
        schema = etree.XMLSchema(etree.parse(SCHEMAS / schemas / f"SystemStructure{name}.xsd"))
        assert schema.validate(etree.ElementTree(part)), schema.error_log


def test_terminals_fit_the_schema(model):
    with zipfile.ZipFile(fmu_path(3, model)) as archive:
        document = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    schema = etree.XMLSchema(etree.parse(SCHEMAS / "fmi30" / "fmi3TerminalsAndIcons.xsd"))
    assert schema.validate(document), schema.error_log
    assert [terminal.get("name") for terminal in document[0]] == ["motors", "sensors"]


def stepped_by_hand(folder, steps):
    """The pose of the plant after these steps (time and length) of both FMUs, each with what the other said before the step."""
    controller, plant = (Slave(folder / f"fmi2/CableRobot{model}.fmu") for model in ("Controller", "Plant"))
    with controller, plant:
        controller["commandDelay"] = STEP
        controller.set(pose_names("goalPose"), [0.15, 0.15, 1.0, 0.0, 0.0, 0.0])
        controller.initialize()
        plant.initialize()
        for time, length in steps:
            seen, pull = plant.get(COUPLED), controller.get(cable_names("motorTension"))
            controller.set(COUPLED, seen)
            plant.set(cable_names("motorTension"), pull)
            for slave in (controller, plant):
                slave.step(length, time)
        return list(plant.get(pose_names("encoderPose")))


def edited(folder, name, what, to):
    """The closed system with other numbers in its parameter set."""
    path = folder / name
    with zipfile.ZipFile(folder / "CableRobotClosed.ssp") as source, zipfile.ZipFile(path, "w") as target:
        for entry in source.namelist():
            content = source.read(entry)
            if entry == "SystemStructure.ssd":
                content, count = re.subn(what, to, content)
                assert count > 0
            target.writestr(entry, content)
    return str(path)


@pytest.fixture(scope="module")
def system(folder):
    """The closed system with another goal."""
    return edited(folder, "Edited.ssp", rb'(name="goalPose\.[xy]">\s*<ssv:Real value=)"0"', rb'\1"0.15"')


ECOS = """
from ecospy import EcosLib, EcosSimulation
EcosLib.set_log_level("debug")
with EcosSimulation(step_size=1e-3, ssp_path="{path}") as simulation:
    simulation.init(parameter_set="start")
"""
LIBCOSIM = """
from libcosimpy.CosimExecution import CosimExecution
CosimExecution.from_ssp_file("{path}", 1_000_000).step()
"""


@pytest.mark.parametrize("script", [ECOS, LIBCOSIM], ids=["ecospy", "libcosimpy"])
def test_a_wrong_parameter_in_a_system_is_named(folder, script):
    if script == ECOS:
        require_tbb()
    path = edited(folder, "Wrong.ssp", rb'(name="commandDelay">\s*<ssv:Real value=)"0.001"', rb'\1"-1"')
    done = subprocess.run([sys.executable, "-c", script.format(path=path)], capture_output=True, text=True)
    assert "commandDelay = -1 is not allowed" in done.stdout + done.stderr


def test_ecos_steps_the_closed_system_as_by_hand_bit_for_bit(folder, system):
    require_tbb()
    from ecospy import EcosSimulation

    with EcosSimulation(step_size=STEP, ssp_path=system) as simulation:
        # It takes the parameter set that it is told the name of.
        assert simulation.init(parameter_set="start")
        simulation.step(1000)
        found = [simulation.get_real(f"plant::{name}") for name in pose_names("encoderPose")]
    # It adds up the time.
    times = itertools.accumulate([0.0] + [STEP] * 999)
    assert found == stepped_by_hand(folder, [(time, STEP) for time in times])


def test_libcosim_steps_the_closed_system_as_by_hand_bit_for_bit(folder, system):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(system, 1_000_000)
    plant = execution.slave_index_from_instance_name("plant")
    references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(plant)}
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    assert execution.simulate_until(1_000_000_000)
    found = observer.last_real_values(plant, [references[name] for name in pose_names("encoderPose")])
    # It counts nanoseconds, and steps from instant to instant.
    points = [k * 1e6 / 1e9 for k in range(1001)]
    assert found == stepped_by_hand(folder, [(time, end - time) for time, end in itertools.pairwise(points)])
