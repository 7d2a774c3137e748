"""FMUs that are not made by bgc: a C file of the tests, compiled and packed by hand."""

from __future__ import annotations

import subprocess
from pathlib import Path
from zipfile import ZipFile

SOURCES = Path(__file__).parent / "cprograms"
LAG = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Lag" guid="{lag}" description="A lag">
<CoSimulation modelIdentifier="lag"/>
<UnitDefinitions>
 <Unit name="kN"><BaseUnit kg="1" m="1" s="-2" factor="1000"/></Unit>
 <Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
 <Unit name="s"><BaseUnit s="1"/></Unit>
</UnitDefinitions>
<TypeDefinitions><SimpleType name="Force"><Real unit="kN"/></SimpleType></TypeDefinitions>
<DefaultExperiment stepSize="0.01"/>
<ModelVariables>
 <ScalarVariable name="gain" valueReference="1" causality="parameter" variability="fixed"
   description="Gain of the lag."><Real start="2" min="0" max="100"/></ScalarVariable>
 <ScalarVariable name="T" valueReference="2" causality="parameter" variability="tunable"
   ><Real unit="s" start="0.5"/></ScalarVariable>
 <ScalarVariable name="u" valueReference="3" causality="input"><Real declaredType="Force"
   start="0"/></ScalarVariable>
 <ScalarVariable name="is.on" valueReference="4" causality="input"><Boolean start="false"/>
 </ScalarVariable>
 <ScalarVariable name="x" valueReference="5" causality="output"><Real unit="kN"/></ScalarVariable>
 <ScalarVariable name="steps" valueReference="6" causality="output"><Integer/></ScalarVariable>
 <ScalarVariable name="warmth" valueReference="7" causality="local"
   ><Real unit="degC"/></ScalarVariable>
 <ScalarVariable name="odd" valueReference="5" causality="output"
   ><Real unit="furlong"/></ScalarVariable>
 <ScalarVariable name="label" valueReference="9" causality="output"><String/></ScalarVariable>
</ModelVariables>
</fmiModelDescription>
"""
WHOLE = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Enumeration")
LAGS = (
    """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Lags" instantiationToken="{lags}">
<CoSimulation modelIdentifier="lags"/>
<ModelVariables>
 <Float64 name="gain" valueReference="1" causality="parameter" variability="fixed" start="2 3">
  <Dimension start="2"/></Float64>
 <Float64 name="T" valueReference="2" causality="parameter" variability="tunable" start="0.5"/>
 <Float64 name="u" valueReference="3" causality="input" start="0 0"><Dimension start="2"/></Float64>
 <Boolean name="on" valueReference="5" causality="input" start="false"/>
 <Float64 name="x" valueReference="4" causality="output"><Dimension start="2"/></Float64>
 <Float32 name="rough" valueReference="6" causality="output"><Dimension start="2"/></Float32>
"""
    + "".join(
        f'<{kind} name="set{kind}" valueReference="{20 + k}" causality="input" start="0"/>'
        f'<{kind} name="get{kind}" valueReference="{40 + k}" causality="output"/>\n'
        for k, kind in enumerate(WHOLE)
    )
    + "</ModelVariables>\n</fmiModelDescription>\n"
)


def foreign_fmu(
    path: Path, version: int = 2, flags: tuple[str, ...] = (), description: str = ""
) -> Path:
    """Compile and pack `foreign_fmu2.c` or `foreign_fmu3.c`, for 64-bit Linux on x86."""
    name, folder = ("lag", "linux64") if version == 2 else ("lags", "x86_64-linux")
    made = path.with_suffix(".so")
    command = ["cc", "-std=c11", "-O1", "-fPIC", "-shared", *flags]
    subprocess.run([*command, SOURCES / f"foreign_fmu{version}.c", "-o", made, "-lm"], check=True)
    with ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description or (LAG if version == 2 else LAGS))
        archive.write(made, f"binaries/{folder}/{name}.so")
    return path
