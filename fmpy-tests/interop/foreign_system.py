"""Whether ecospy and libcosimpy refuse a system that shows something outside also when the FMU in it is somebody else's: the one named as argument, of
FMI 2 with an output y. They take the same system without that."""

import sys
import tempfile
import zipfile
from pathlib import Path

from ecospy import EcosSimulation
from libcosimpy.CosimExecution import CosimExecution

STRUCTURE = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="Foreign">
  <ssd:System name="Foreign">
    {outside}
    <ssd:Elements>
      <ssd:Component name="part" type="application/x-fmu-sharedlibrary" source="resources/part.fmu">
        <ssd:Connectors><ssd:Connector name="y" kind="output"><ssc:Real/></ssd:Connector></ssd:Connectors>
      </ssd:Component>
    </ssd:Elements>
    <ssd:Connections>{connection}</ssd:Connections>
  </ssd:System>
</ssd:SystemStructureDescription>
"""
OUTSIDE = '<ssd:Connectors><ssd:Connector name="y" kind="output"><ssc:Real/></ssd:Connector></ssd:Connectors>'
CONNECTION = '<ssd:Connection startElement="part" startConnector="y" endConnector="y"/>'


def takes(tool, path):
    try:
        if tool == "ecospy":
            return EcosSimulation(step_size=0.01, ssp_path=path).init()
        return CosimExecution.from_ssp_file(path, 10_000_000).step()
    except Exception:
        return False


found = {}
with tempfile.TemporaryDirectory() as folder:
    for name, texts in {"open": (OUTSIDE, CONNECTION), "closed": ("", "")}.items():
        path = str(Path(folder) / f"{name}.ssp")
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("SystemStructure.ssd", STRUCTURE.format(outside=texts[0], connection=texts[1]))
            archive.write(sys.argv[1], "resources/part.fmu")
        for tool in ("ecospy", "libcosimpy"):
            found[tool, name] = bool(takes(tool, path))
assert found == {(tool, name): name == "closed" for tool in ("ecospy", "libcosimpy") for name in ("open", "closed")}, found
