"""An exported model as a co-simulation unit of FMI 2.0: its C source, its description, and a library where it is built.

Source: FMI for Model Exchange and Co-Simulation 2.0.4, sections 2 and 4.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import uuid
import zipfile
from pathlib import Path

from sim.export.files import ARGUMENTS, Exported, files_of
from stagecad.parameters.atomic import atomic_write_bytes
from stagecad.parameters.errors import InputError

INPUTS = ARGUMENTS[1:]
_UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s2", "load": "N", "temperature": "degC"}

_WRAPPER = """
/* Functions of FMI 2.0 for co-simulation. */
#include <stdlib.h>
#include <string.h>
typedef void *Component;
typedef double Real;
typedef unsigned int Ref;
typedef int Integer, Boolean, Status;
typedef const char *String;
enum { OK = 0, DISCARD = 2, ERROR = 3 };
#if defined(_WIN32)
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif
typedef struct { NAME_state state; Real values[6]; int started; } Instance;
API String fmi2GetTypesPlatform(void) { return "default"; }
API String fmi2GetVersion(void) { return "2.0"; }
API Status fmi2SetDebugLogging(Component c, Boolean on, size_t n, const String k[]) { return OK; }
API Component fmi2Instantiate(String name, int kind, String guid, String place, const void *callbacks, Boolean visible,
                              Boolean logging) {
  Instance *made = strcmp(guid, "GUID") == 0 ? calloc(1, sizeof(Instance)) : NULL;
  if (made) made->values[4] = 20.0;
  return made;
}
API void fmi2FreeInstance(Component c) { free(c); }
API Status fmi2SetupExperiment(Component c, Boolean d, Real t, Real start, Boolean s, Real stop) { return OK; }
API Status fmi2EnterInitializationMode(Component c) { return OK; }
API Status fmi2ExitInitializationMode(Component c) {
  Instance *i = c;
  NAME_start(&i->state, i->values[0], i->values[1]);
  i->values[5] = NAME_step(&i->state, 0.0, i->values[0], i->values[1], i->values[2], i->values[3], i->values[4]);
  return OK;
}
API Status fmi2Terminate(Component c) { return OK; }
API Status fmi2Reset(Component c) { memset(c, 0, sizeof(Instance)); ((Instance *)c)->values[4] = 20.0; return OK; }
API Status fmi2GetReal(Component c, const Ref refs[], size_t n, Real out[]) {
  for (size_t k = 0; k < n; k++) { if (refs[k] > 5) return ERROR; out[k] = ((Instance *)c)->values[refs[k]]; }
  return OK;
}
API Status fmi2SetReal(Component c, const Ref refs[], size_t n, const Real in[]) {
  for (size_t k = 0; k < n; k++) { if (refs[k] > 4) return ERROR; ((Instance *)c)->values[refs[k]] = in[k]; }
  return OK;
}
API Status fmi2DoStep(Component c, Real t, Real dt, Boolean keep) {
  Instance *i = c;
  i->values[5] = NAME_step(&i->state, dt, i->values[0], i->values[1], i->values[2], i->values[3], i->values[4]);
  return OK;
}
#define NOT_HERE(name, ...) API Status name(__VA_ARGS__) { return ERROR; }
NOT_HERE(fmi2GetInteger, Component c, const Ref r[], size_t n, Integer v[])
NOT_HERE(fmi2GetBoolean, Component c, const Ref r[], size_t n, Boolean v[])
NOT_HERE(fmi2GetString, Component c, const Ref r[], size_t n, String v[])
NOT_HERE(fmi2SetInteger, Component c, const Ref r[], size_t n, const Integer v[])
NOT_HERE(fmi2SetBoolean, Component c, const Ref r[], size_t n, const Boolean v[])
NOT_HERE(fmi2SetString, Component c, const Ref r[], size_t n, const String v[])
NOT_HERE(fmi2GetFMUstate, Component c, void **s)
NOT_HERE(fmi2SetFMUstate, Component c, void *s)
NOT_HERE(fmi2FreeFMUstate, Component c, void **s)
NOT_HERE(fmi2SerializedFMUstateSize, Component c, void *s, size_t *n)
NOT_HERE(fmi2SerializeFMUstate, Component c, void *s, char b[], size_t n)
NOT_HERE(fmi2DeSerializeFMUstate, Component c, const char b[], size_t n, void **s)
NOT_HERE(fmi2GetDirectionalDerivative, Component c, const Ref u[], size_t a, const Ref k[], size_t b, const Real d[],
         Real v[])
NOT_HERE(fmi2SetRealInputDerivatives, Component c, const Ref r[], size_t n, const Integer o[], const Real v[])
NOT_HERE(fmi2GetRealOutputDerivatives, Component c, const Ref r[], size_t n, const Integer o[], Real v[])
NOT_HERE(fmi2CancelStep, Component c)
NOT_HERE(fmi2GetStatus, Component c, int k, Status *v)
NOT_HERE(fmi2GetRealStatus, Component c, int k, Real *v)
NOT_HERE(fmi2GetIntegerStatus, Component c, int k, Integer *v)
NOT_HERE(fmi2GetBooleanStatus, Component c, int k, Boolean *v)
NOT_HERE(fmi2GetStringStatus, Component c, int k, String *v)
"""


def write_fmu(exported: Exported, folder: Path) -> Path:
    """Write NAME.fmu with sources, description, and the library built by the compiler of this machine."""
    name = exported.program.name
    files = files_of(exported, "c")
    guid = str(uuid.uuid5(uuid.NAMESPACE_OID, files[f"{name}.c"]))
    source = files[f"{name}.c"] + _WRAPPER.replace("NAME_", f"{name}_").replace('"GUID"', f'"{guid}"')
    library, place = _built(name, source, files[f"{name}.h"])
    target = folder / f"{name}.fmu"
    with tempfile.TemporaryDirectory() as scratch:
        packed = Path(scratch) / "packed.fmu"
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", _description(exported, guid))
            archive.writestr(f"sources/{name}.c", source)
            archive.writestr(f"sources/{name}.h", files[f"{name}.h"])
            archive.writestr(place, library)
        atomic_write_bytes(target, packed.read_bytes())
    return target


def _built(name: str, source: str, header: str) -> tuple[bytes, str]:
    """The shared library, and its place in the unit."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise InputError("--to fmu: needs a C compiler (cc, gcc or clang) on the path; --to c writes the sources")
    system, suffix = ("darwin64", "dylib") if sys.platform == "darwin" else ("linux64", "so")
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / f"{name}.c").write_text(source, encoding="utf-8")
        (Path(scratch) / f"{name}.h").write_text(header, encoding="utf-8")
        words = [compiler, "-std=c99", "-O2", "-shared", "-fPIC", f"{name}.c", "-o", f"{name}.{suffix}", "-lm"]
        done = subprocess.run(words, cwd=scratch, capture_output=True, text=True, check=False)
        if done.returncode:
            raise InputError(f"--to fmu: {compiler} fails: {done.stderr.strip().splitlines()[0]}")
        return (Path(scratch) / f"{name}.{suffix}").read_bytes(), f"binaries/{system}/{name}.{suffix}"


def _description(exported: Exported, guid: str) -> str:
    name = exported.program.name
    inputs = "\n".join(
        f'    <ScalarVariable name="{key}" valueReference="{k}" causality="input" variability="continuous">'
        f'<Real unit="{_UNITS[key]}" start="{20.0 if key == "temperature" else 0.0}"/></ScalarVariable>'
        for k, key in enumerate(INPUTS)
    )
    units = "".join(f'<Unit name="{unit}"/>' for unit in dict.fromkeys([*_UNITS.values()]))
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{guid}" generationTool="stagecad"
    description="fitted friction and forces of an axis" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true">
    <SourceFiles><File name="{name}.c"/></SourceFiles>
  </CoSimulation>
  <UnitDefinitions>{units}</UnitDefinitions>
  <DefaultExperiment startTime="0.0" stopTime="1.0" stepSize="0.001"/>
  <ModelVariables>
{inputs}
    <ScalarVariable name="force" valueReference="5" causality="output" variability="continuous" initial="calculated">\
<Real unit="N"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="6"/></Outputs>
    <InitialUnknowns><Unknown index="6"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
