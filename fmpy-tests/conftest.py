import pytest


@pytest.fixture(params=[2, 3], ids=["fmi2", "fmi3"])
def version(request) -> int:
    return request.param


@pytest.fixture(params=["CableRobotController", "CableRobotPlant"])
def model(request) -> str:
    return request.param
