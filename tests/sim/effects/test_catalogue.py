"""Names, variants, channels: what `find` takes, and what it says when it cannot."""

import subprocess
import sys

import pytest

from sim.effects.catalogue import ORDER, compose, find, library
from stagecad.parameters.errors import InputError
from stagecad.parameters.units import unit_dimension


def test_the_library_is_listed_in_the_order_everyone_uses():
    names = [name for name in library() if name in ORDER]
    assert names == [name for name in ORDER if name in library()]


@pytest.mark.parametrize("effect", library().values(), ids=lambda effect: effect.name)
def test_a_declaration_is_whole(effect):
    for each in (effect, *effect.variants):
        assert each.meaning
        assert each.equation
        assert each.shows
        assert each.source
        assert each.level or each.factor or each.force or each.signal or each.memory or each.friction_state
        for parameter in each.parameters:
            assert parameter.meaning
            assert parameter.source
            assert parameter.low <= parameter.default <= parameter.high
            if "channel" not in parameter.unit:  # in the unit of whatever channel it acts on
                unit_dimension(parameter.unit)
    assert all(variant.name.startswith(f"{effect.name}:") for variant in effect.variants)


def test_find_takes_variants_channels_and_contact_effects():
    assert find("stribeck:free_exponent").parameter("exponent").fixed is False
    assert find("stribeck").parameter("exponent").fixed is True
    assert find("sensor_lag@position").name == "sensor_lag@position"
    assert find("contact.stribeck").values().velocity == find("stribeck").values().velocity


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
    with pytest.raises(InputError, match=message):
        find(name)


def test_a_core_replaces_the_one_before_it_with_its_level():
    model = compose(["coulomb", "stribeck", "lugre"], {"lugre.force": 2.0})
    assert model.names == ("stribeck", "lugre")
    assert model.parameters()["lugre.force"] == 2.0
    with pytest.raises(InputError, match="has no effect 'coulomb'"):
        compose(["coulomb", "lugre"], {"coulomb.force": 1.0})
    with pytest.raises(InputError, match="given twice"):
        compose(["viscous", "viscous"])
    with pytest.raises(InputError, match="no parameter 'coeficient'; did you mean 'coefficient'"):
        compose(["viscous"], {"viscous.coeficient": 1.0})


def test_importing_the_library_loads_nothing_heavy():
    code = (
        "import sys, sim; sim.library(); "
        "heavy = {'numba', 'scipy', 'pandas', 'matplotlib', 'cadquery'} & set(sys.modules); assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
