"""Names of effects, and a user's own: it works in under 20 lines, and each mistake has one clear line."""

import pickle

import numpy as np
import pytest

from sim.effects.catalogue import ORDER, compose, find, library
from sim.effects.custom import load_all_custom, load_custom
from sim.effects.effect import Axis, Effect, Parameter
from sim.integration import drive
from sim.integration.simulate import SimulationError, simulate
from stagecad.parameters.errors import InputError
from stagecad.parameters.units import unit_dimension
from tests.process_state import python
from tests.refusals import refused

CUBIC = '''"""A spring that stiffens."""
from sim import Effect, Parameter


def force(axis, p):
    return p.strength * axis.position**3


effect = Effect(
    name="cubic_spring",
    meaning="spring that stiffens with the cube of the position",
    force=force,
    parameters=[Parameter("strength", "N/m^3", 1e3, 0.0, 1e9, "stiffening", "assumed")],
)
'''
HEAD = "from sim import Effect, Parameter\nimport numpy as np\n"
FORCE = "'m', force=lambda a, p: a.velocity"


def write(folder, text, name="mine.py"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def one(law="lambda a, p: p.c * a.velocity", parameter='Parameter("c", "N*s/m", 1.0, 0.0, 9.0, "m", "s")', name="mine"):
    return f"{HEAD}effect = Effect({name!r}, 'm', force={law}, parameters=[{parameter}])\n"


def test_a_users_effect_fits_in_twenty_lines_takes_its_place_and_simulates(tmp_path):
    assert len(CUBIC.splitlines()) < 20
    custom = load_custom(write(tmp_path, CUBIC))
    assert [effect.name for effect in custom] == ["cubic_spring"]
    model = compose(["cubic_spring"], {"cubic_spring.strength": 2e3}, custom)
    time = np.linspace(0.0, 1.0, 101)
    run = simulate(model, drive.force([0.0, 1.0], [0.0, 0.0]), time, position=0.3, tolerance=1e-11)
    # Energy of a frictionless oscillator: m v^2/2 + strength x^4/4.
    assert np.allclose(0.5 * run.velocity**2 + 500.0 * run.position**4, 500.0 * 0.3**4, rtol=1e-8)
    custom = load_custom(write(tmp_path, CUBIC))
    assert compose(["viscous", "cubic_spring"], {}, custom).names == ("viscous", "cubic_spring")
    refused("did you mean 'cubic_spring'", find, "cubic_sprin", custom)
    load_custom(write(tmp_path, CUBIC))
    assert "cubic_spring" not in library()


@pytest.mark.parametrize("low", [1e-5, 0.0])
def test_a_parameter_without_a_role_is_a_shape_where_the_law_is_not_linear_in_it(tmp_path, low):
    """Tustin, IEEE Trans. 61 (1947) 143: at speed zero the law has no value, and no search may begin there."""
    names = {"rise": "1.0, 0.0, 9.0", "zero": "0.0, -9.0, 9.0", "speed": f"0.01, {low}, 1.0"}
    parameters = ", ".join(f"Parameter({name!r}, '1', {bounds}, 'm', 's')" for name, bounds in names.items())
    law = "lambda a, p: p.rise * np.exp(-abs(a.velocity) / p.speed) + p.zero"
    (effect,) = load_custom(write(tmp_path, one(law, parameters)))
    assert [p.role for p in effect.parameters] == ["amplitude", "amplitude", "shape"]


def test_a_constant_may_be_written_as_one_number(tmp_path):
    custom = load_custom(write(tmp_path, one("lambda a, p: p.c", 'Parameter("c", "N", 1.0, 0.0, 9.0, "m", "s")')))
    assert custom[0].force(Axis(*[np.ones(5)] * 10), custom[0].values()).shape == (5,)


BROKEN = {
    "def force(axis, p:\n    return 1\n": r"mine\.py, line 1: not valid Python: ",
    "x = 1\n": r"mine\.py: declares no effect",
    "import no_such_module_here\n": r"mine\.py, line 1: ModuleNotFoundError: ",
    "from sim import Efect\n": r"mine\.py, line 1: ImportError: ",
    HEAD + "effect = Effect('mine', 'm', parameters=[1 / 0])\n": r"mine\.py, line 3: ZeroDivisionError",
    HEAD + "effect = Effect('mine')\n": r"mine\.py, line 3: TypeError: ",
    HEAD + "effect = Effect('mine', 'm', forces=1)\n": r"mine\.py, line 3: TypeError: .*forces",
    HEAD + "effect = Effect('mine', 'm')\n": r"effect 'mine': has no law",
    HEAD + "effect = Effect('mine', 'm', force=3.0)\n": r"force: must be a function",
    f"{HEAD}effect = Effect('mine', {FORCE}, parameters=['c'])\n": r"must hold Parameter",
    f"{HEAD}effect = Effect('mine', {FORCE}, acts_on='frction')\n": r"did you mean 'friction'",
    f"{HEAD}effect = Effect('mine', {FORCE}, slopes={{'force.speed': len}})\n": r"no slope 'force\.speed'",
    f"{HEAD}a = Effect('mine', {FORCE})\nb = Effect('mine', {FORCE})\n": r"effect 'mine': the file declares it twice",
    one(name="stribeck"): r"effect 'stribeck': a built-in effect has that name",
    one(name="My Effect"): r"the name must be lower-case",
    one(parameter='Parameter("c", "furlong", 1.0, 0.0, 9.0, "m", "s")'): r"parameter 'c': unit: .*furlong",
    one(parameter='Parameter("c", "N", 10.0, 0.0, 9.0, "m", "s")'): r"start 10 is outside its bounds 0 to 9",
    one(parameter='Parameter("c", "N", "1 N", 0.0, 9.0, "m", "s")'): r"must be numbers in N",
    one(parameter='Parameter("c", "N", float("inf"), 0.0, float("inf"), "m", "s")'): r"not a finite number",
    one(parameter='Parameter("C c", "N", 1.0, 0.0, 9.0, "m", "s")'): r"parameter 'C c': the name must be lower-case",
    one("lambda a, p: p.d * a.velocity"): r"force.*: AttributeError: .*'d'",
    one("lambda a, p: a.speed"): r"force.*AttributeError: .*'speed'",
    one("lambda a: a.velocity"): r"force.*TypeError: ",
    one("lambda a, p: np.diff(np.atleast_1d(a.velocity))"): r"shape \(6,\) for a record of 7 rows; must be \(7,\)",
    one("lambda a, p: np.atleast_1d(a.velocity)"): r"gives shape \(1,\) at one instant; must be one number",
    one("lambda a, p: 'much'"): r"gives str; must give numbers",
    one("lambda a, p: None"): r"force: gives None; must give numbers",
    one("lambda a, p: np.sqrt(a.velocity + 0j)"): r"force: gives complex numbers; must give real ones",
    one("lambda a, p: p.c * np.random.normal(size=np.shape(a.time))"): r"gives other numbers for the same arguments",
    one("lambda a, p: np.add(a.velocity, p.c, out=a.velocity)"): r"gives other numbers for the same arguments",
    one(parameter='Parameter("c", None, 1.0, 0.0, 9.0, "m", "s")'): r"parameter 'c': unit: must be text such as 'N/m'",
    one("lambda a, p: a.velocity / (p.c - 1)"): r"force.*(is not finite at the parameters' defaults|ZeroDivisionError)",
    one("lambda a, p: np.log(-p.c) + a.velocity"): r"force: is not finite at the parameters' defaults",
    HEAD + "effect = Effect('mine', 'm', signal=lambda s, h, p: s[1:])\n": r"signal: gives shape \(6,\)",
}


@pytest.mark.parametrize("text", BROKEN, ids=range(len(BROKEN)))
def test_a_mistake_has_one_line_that_says_where_and_what(tmp_path, text):
    with pytest.raises(InputError, match=BROKEN[text]) as caught:
        load_custom(write(tmp_path, text))
    assert "mine.py" in str(caught.value) and "\n" not in str(caught.value)


def test_missing_files_and_names_declared_twice_are_named(tmp_path):
    write(tmp_path, CUBIC, "cubic.py")
    refused(r"cubik\.py: no such file; did you mean 'cubic\.py'", load_custom, tmp_path / "cubik.py")
    first, second = write(tmp_path, CUBIC, "one.py"), write(tmp_path, CUBIC, "two.py")
    refused(r"two\.py: effect 'cubic_spring' is already declared in .*one\.py", load_all_custom, [first, second])


FAILING = """def force(axis, p):
    if {}:
        raise RuntimeError({!r})
    return 0.0 * axis.velocity
effect = Effect('cable', 'm', force=force)
"""


def test_a_law_that_fails_is_named_with_its_time_or_line(tmp_path):
    text = HEAD + FAILING.format("np.ndim(axis.time) == 0 and axis.time > 0.3", "the cable broke")
    model = compose(["cable"], custom=load_custom(write(tmp_path, text)))
    with pytest.raises(SimulationError, match=r"cable stopped at t = 0\.[23].*RuntimeError: the cable broke"):
        simulate(model, drive.force([0.0, 1.0], [0.1, 0.1]), np.linspace(0.0, 1.0, 11))
    (effect,) = load_custom(write(tmp_path, HEAD + FAILING.format("np.size(axis.time) > 100", "too long")))
    column = np.zeros(200)
    with pytest.raises(InputError, match=r"mine\.py: effect 'cable': force, line \d+: RuntimeError: too long"):
        effect.force(Axis(*[column] * len(Axis._fields)), effect.values())


def test_the_library_has_one_order_and_finds_variants_and_channels():
    names = [name for name in library() if name in ORDER]
    assert names == [name for name in ORDER if name in library()]
    assert find("stribeck:free_exponent").parameter("exponent").fixed is False
    assert find("stribeck").parameter("exponent").fixed is True
    assert find("sensor_lag@position").name == "sensor_lag@position"
    assert find("contact.stribeck").values().velocity == find("stribeck").values().velocity


@pytest.mark.parametrize("effect", library().values(), ids=lambda effect: effect.name)
def test_a_declaration_is_whole(effect):
    for each in (effect, *effect.variants):
        assert each.meaning and each.equation and each.shows and each.source
        assert each.level or each.factor or each.force or each.signal or each.memory or each.friction_state
        for parameter in each.parameters:
            assert parameter.meaning and parameter.source and parameter.low <= parameter.default <= parameter.high
            if "channel" not in parameter.unit:  # in the unit of whatever channel it acts on
                unit_dimension(parameter.unit)
    assert all(variant.name.startswith(f"{effect.name}:") for variant in effect.variants)
    # A constant force is the same against every coordinate.
    assert effect.coordinates or effect.name == "constant_bias"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("stribek", r"no effect 'stribek'; did you mean 'stribeck'"),
        ("stribeck:free_expo", r"'stribeck' has no variant 'free_expo'; did you mean 'free_exponent'"),
        ("viscous:cubic", r"'viscous' has no variant 'cubic'; it has none"),
        ("viscous@position", r"only a sensor effect takes '@channel'"),
        ("sensor_lag@posision", r"no channel 'posision'; did you mean 'position'"),
        ("contact.sensor_lag", r"not in the contact of tip and stage"),
    ],
)
def test_a_wrong_name_names_the_nearest(name, message):
    refused(message, find, name)


def test_a_core_replaces_the_one_before_it_with_its_level():
    model = compose(["coulomb", "stribeck", "lugre"], {"lugre.force": 2.0})
    assert model.names == ("stribeck", "lugre") and model.parameters()["lugre.force"] == 2.0
    refused("has no effect 'coulomb'", compose, ["coulomb", "lugre"], {"coulomb.force": 1.0})
    refused("given twice", compose, ["viscous", "viscous"])
    refused("no parameter 'coeficient'; did you mean 'coefficient'", compose, ["viscous"], {"viscous.coeficient": 1.0})


def test_importing_the_library_loads_nothing_heavy():
    heavy = "{'numba', 'scipy', 'pandas', 'matplotlib', 'cadquery'}"
    python("-c", f"import sys, sim; sim.library(); heavy = {heavy} & set(sys.modules); assert not heavy, heavy")


def cubic(axis, p):
    return p.strength * axis.position**3


def test_a_pickled_effect_needs_no_file_and_one_of_a_module_its_module(tmp_path):
    file, pickled = write(tmp_path, one()), tmp_path / "effect.pickle"
    (effect,) = load_custom(file)
    pickled.write_bytes(pickle.dumps(effect))
    file.unlink()
    axis = Axis(*np.ones((10, 3)))
    assert np.array_equal(pickle.loads(pickled.read_bytes()).force(axis, effect.values(c=3.0)), 3.0 * axis.velocity)
    text = "import pickle, sys; e = pickle.load(open(sys.argv[1], 'rb')); print(e.name, e.parameters[0].unit)"
    assert python("-c", text, pickled).stdout.split() == ["mine", "N*s/m"]
    strength = Parameter("strength", "N/m^3", 1.0, 0.0, 9.0, "stiffening", "assumed")
    (checked,) = load_all_custom([Effect("stiff", "m", force=cubic, parameters=(strength,))])
    again = pickle.loads(pickle.dumps(checked))
    assert np.array_equal(again.force(axis, checked.values(strength=2.0)), 2.0 * axis.position**3)
