"""The files of an exported model: Python, C, MATLAB, Modelica, and a table of steady sliding."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sim.export.languages import C, Language, Matlab, Modelica, locals_of
from sim.export.program import ForceFunction, Program

ARGUMENTS = ("dt", "position", "velocity", "acceleration", "load", "temperature")
SIGNS = (
    "The force opposes the motion: it is positive where it acts against positive velocity.",
    "mass * acceleration = drive force - force. SI units; on a rotary axis rad for m, N*m for N, kg*m^2 for kg.",
    "Call start once, then step once per sample: dt is the time since the sample before.",
    "load (N) and temperature (degC) matter only to effects that depend on them.",
)


@dataclass(frozen=True)
class Exported:
    """What is written.

    Args:
        program: the step.
        mass: kg; zero where it is not known.
        about: lines on the origin of the model.
    """

    program: Program
    mass: float
    about: tuple[str, ...]

    @property
    def comments(self) -> list[str]:
        """Lines at the head of each file."""
        left = [f"Left out: {line}." for line in self.program.left_out]
        states = [f"state {k}: {meaning}" for k, meaning in enumerate(self.program.states)]
        return [*self.about, "", *SIGNS, *left, "", *states]

    @property
    def tree(self) -> list[ast.FunctionDef]:
        """The functions of the program."""
        return [node for node in ast.parse(self.program.source).body if isinstance(node, ast.FunctionDef)]

    def check(self) -> tuple[list[list[float]], list[float]]:
        """Inputs of a self-test, rows of `ARGUMENTS`, and the force that the program gives, N."""
        time = np.arange(60) * 1e-3
        position = 2e-4 * np.sin(2 * np.pi * 18.0 * time) * time / time[-1]
        velocity = np.gradient(position, time)
        acceleration = np.gradient(velocity, time)
        load, temperature = 10.0 + np.cos(40.0 * time), 20.0 + 50.0 * time
        force = ForceFunction(self.program.source)(time, position, velocity, load, temperature)
        steps = np.diff(time, prepend=time[0])
        return np.column_stack([steps, position, velocity, acceleration, load, temperature]).tolist(), force.tolist()


def files_of(exported: Exported, language: str) -> dict[str, str]:
    """Text by file name."""
    makers = {"python": _python, "c": _c, "matlab": _matlab, "modelica": _modelica, "table": _table}
    return makers[language](exported)


def _python(exported: Exported) -> dict[str, str]:
    name, (rows, force) = exported.program.name, exported.check()
    head = "\n".join(exported.comments)
    test = f"""
def feedforward(s, dt, position, velocity, acceleration, load, temperature):
    return MASS * acceleration + step(s, dt, position, velocity, acceleration, load, temperature)


def self_test():
    rows = {rows!r}
    expected = {force!r}
    state = start(rows[0][1], rows[0][2])
    for row, force in zip(rows, expected):
        assert abs(step(state, *row) - force) <= 1e-9 * (1.0 + abs(force)), row


if __name__ == "__main__":
    self_test()
    print("self-test passed")
"""
    source = exported.program.source.replace("import math\n", f"import math\n\nMASS = {exported.mass!r}  # kg\n", 1)
    return {f"{name}.py": f'"""{head}\n"""\n\n{source}\n{test}'}


def _commented(lines: Sequence[str], sign: str) -> str:
    return "\n".join(f"{sign} {line}".rstrip() for line in lines)


_C_ARGUMENTS = ", ".join(f"double {argument}" for argument in ARGUMENTS)


def _c(exported: Exported) -> dict[str, str]:
    program, printer = exported.program, C()
    name = program.name
    constants = "\n".join(
        f"static const double {key} = {value!r}; /* {program.comments.get(key, '')} */"
        for key, value in program.parameters.items()
    )
    functions = [printer.function(node) for node in exported.tree if node.name not in ("start", "step")]
    step = next(node for node in exported.tree if node.name == "step")
    locals_ = ", ".join(f"{local} = 0.0" for local in _plain_locals(step))
    body = "\n".join(printer.block(step.body, "  "))
    starts = "\n".join(f"  state->s[{k}] = {start};" for k, start in enumerate(program.starts))
    unused = " ".join(f"(void){argument};" for argument in ARGUMENTS)
    source = f"""#include "{name}.h"

#include <math.h>

{constants}
static const double mass_of_{name} = {exported.mass!r}; /* kg */

{chr(10).join(functions)}

void {name}_start({name}_state *state, double position, double velocity) {{
  (void)velocity;
{starts}
}}

double {name}_step({name}_state *state, {_C_ARGUMENTS}) {{
  double *s = state->s;
  double {locals_};
  {unused}
{body}
}}

double {name}_feedforward({name}_state *state, {_C_ARGUMENTS}) {{
  return mass_of_{name} * acceleration + {name}_step(state, {", ".join(ARGUMENTS)});
}}
"""
    return {f"{name}.h": _c_header(exported), f"{name}.c": source + _c_test(exported)}


def _c_header(exported: Exported) -> str:
    name = exported.program.name
    return f"""/*
{_commented(exported.comments, " *")}
 */
#ifndef {name.upper()}_H
#define {name.upper()}_H
#define {name.upper()}_STATES {len(exported.program.states)}

typedef struct {{
  double s[{name.upper()}_STATES];
}} {name}_state;

void {name}_start({name}_state *state, double position, double velocity);
double {name}_step({name}_state *state, {_C_ARGUMENTS});
/* Drive force of a desired motion: mass * acceleration + force. */
double {name}_feedforward({name}_state *state, {_C_ARGUMENTS});

#endif
"""


def _c_test(exported: Exported) -> str:
    name, (rows, force) = exported.program.name, exported.check()
    table = ",\n".join("    {" + ", ".join(map(repr, (*row, f))) + "}" for row, f in zip(rows, force))
    return f"""
#ifdef {name.upper()}_SELF_TEST
#include <stdio.h>
int main(void) {{
  static const double rows[][7] = {{
{table}}};
  {name}_state state;
  {name}_start(&state, rows[0][1], rows[0][2]);
  for (unsigned k = 0; k < sizeof rows / sizeof rows[0]; k++) {{
    const double *r = rows[k];
    double force = {name}_step(&state, r[0], r[1], r[2], r[3], r[4], r[5]);
    if (!(fabs(force - r[6]) <= 1e-9 * (1.0 + fabs(r[6])))) {{
      printf("row %u: %.17g, expected %.17g\\n", k, force, r[6]);
      return 1;
    }}
  }}
  printf("self-test passed\\n");
  return 0;
}}
#endif
"""


def _plain_locals(step: ast.FunctionDef) -> list[str]:
    return [local for local in locals_of(step) if local != "s"]


def _matlab(exported: Exported) -> dict[str, str]:
    program, name = exported.program, exported.program.name
    rows, force = exported.check()
    printer: Language = Matlab()
    constants = "\n".join(
        f"  {key} = {value!r}; % {program.comments.get(key, '')}" for key, value in program.parameters.items()
    )
    functions = [printer.function(node) for node in exported.tree if node.name not in ("start", "step")]
    step = next(node for node in exported.tree if node.name == "step")
    body = "\n".join(line for line in printer.block(step.body, "  ")).replace("out0 =", "force =")
    starts = "; ".join(program.starts)
    table = "; ".join(" ".join(map(repr, (*row, f))) for row, f in zip(rows, force))
    return {
        f"{name}.m": f"""function [s, force] = {name}(s, dt, position, velocity, acceleration, load, temperature)
{_commented(exported.comments, "%")}
% s = {name}([], 0, position, velocity) is the state at the first sample; {name}('test') runs the self-test.
  if ischar(s)
    self_test();
    force = 0;
    return
  end
  if isempty(s)
    s = [{starts}];
    force = 0;
    return
  end
{constants}
{body}
end

function value = choose(test, one, other)
  if test
    value = one();
  else
    value = other();
  end
end

{chr(10).join(functions)}

function self_test()
  rows = [{table}];
  s = {name}([], 0, rows(1, 2), rows(1, 3));
  for k = 1:size(rows, 1)
    [s, force] = {name}(s, rows(k, 1), rows(k, 2), rows(k, 3), rows(k, 4), rows(k, 5), rows(k, 6));
    assert(abs(force - rows(k, 7)) <= 1e-9 * (1 + abs(rows(k, 7))))
  end
  disp('self-test passed')
end
"""
    }


_MODELICA_HELPERS = tuple(
    f"function {name}_of\n  input Real x;\n  output Real y;\nalgorithm\n  y := {law};\nend {name}_of;"
    for name, law in (("log1p", "log(1 + x)"), ("expm1", "exp(x) - 1"))
)


def _modelica(exported: Exported) -> dict[str, str]:
    program, name = exported.program, exported.program.name
    printer = Modelica()
    values = "\n".join(
        f'  parameter Real {key} = {value!r} "{program.comments.get(key, "")}";'
        for key, value in program.parameters.items()
    )
    functions = [printer.function(node) for node in exported.tree if node.name not in ("start", "step")]
    step = next(node for node in exported.tree if node.name == "step")
    names = [local for local in _plain_locals(step) if local not in ARGUMENTS]
    changed = [a for a in ("position", "velocity") if a in _assigned(step)]
    inputs = "\n".join(f"  input Real {a}{'_in' if a in changed else ''};" for a in ARGUMENTS)
    keys = "\n".join(f"  input Real {key};" for key in program.parameters)
    copies = "\n".join(["  s := s_in;", *(f"  {a} := {a}_in;" for a in changed)])
    body = "\n".join(printer.block(step.body, "  "))
    count = len(program.states)
    locals_ = ", ".join([*changed, *names])
    arguments = ", ".join(
        ["pre(s)", "period", "position", "velocity", "acceleration", "load", "temperature", *program.parameters]
    )
    starts = ", ".join(program.starts)
    return {
        f"{name}.mo": f"""model {name} "fitted friction and forces of an axis"
{_commented(exported.comments, "  //")}
  parameter Real period(unit = "s") = 1e-3 "of the samples";
{values}
  input Real position, velocity, acceleration, load, temperature;
  discrete output Real force(start = 0, fixed = true) "opposes positive motion";
protected
  discrete Real s[{count}];
{_indented([*_MODELICA_HELPERS, *functions])}
  function step_of
  input Real s_in[{count}];
{inputs}
{keys}
  output Real s[{count}];
  output Real out0;
protected
  Real {locals_};
algorithm
{copies}
{body}
  end step_of;
initial algorithm
  s := {{{starts}}};
algorithm
  when sample(0, period) then
    (s, force) := step_of({arguments});
  end when;
end {name};
"""
    }


def _assigned(function: ast.FunctionDef) -> set[str]:
    return {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def _indented(functions: Sequence[str]) -> str:
    return "\n".join("  " + line for function in functions for line in function.splitlines())


def _table(exported: Exported) -> dict[str, str]:
    """Force over velocity in steady sliding from rest at position zero, both directions."""
    force = ForceFunction(exported.program.source)
    speeds = np.geomspace(1e-6, 1.0, 61)
    rows = []
    for side in (-1.0, 1.0):
        for speed in speeds[:: int(side)] if side > 0 else speeds[::-1]:
            time = np.linspace(0.0, 0.02 / speed, 400)
            rows.append((side * speed, float(force(time, side * speed * time, np.full(400, side * speed))[-1])))
    lines = [f"{velocity:.9g},{value:.9g}" for velocity, value in sorted(rows)]
    head = _commented(exported.comments, "#")
    return {f"{exported.program.name}.csv": f"{head}\nvelocity [m/s],force [N]\n" + "\n".join(lines) + "\n"}
