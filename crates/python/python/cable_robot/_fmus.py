"""The FMUs of the paper's rig."""

from pathlib import Path

FOLDER = Path(__file__).with_name("fmus")


def fmu(name: str, version: int = 3) -> Path:
    """The path of an FMU of the paper's rig: name "Controller" or "Plant" (and "PlantExchange", for Model Exchange), FMI version 2 or 3.

    FMUs of other rigs are packed by the command `cable-robot fmu --rig FILE --output FOLDER`.
    """
    folder = FOLDER / f"fmi{version}"
    path = folder / f"CableRobot{name}.fmu"
    if not path.is_file():
        there = ", ".join(sorted(file.stem.removeprefix("CableRobot") for file in folder.glob("*.fmu")))
        right = f"one of {there}" if there else "version 2 or 3"
        raise ValueError(f"fmu({name!r}, version={version!r}): there is none; {right} would be right")
    return path
