"""Corrections and additions to the STEP text (ISO 10303-21) of the kernel's writer."""

from __future__ import annotations

import re

_LIMIT = re.compile(r"(#\d+ = )MEASURE_WITH_UNIT\((-?[\d.E+-]+),\s*(#\d+)\)")


def typed_limits(text: str) -> str:
    """Limits of plus-minus tolerances with the type of their value.

    OCCT 7.9 writes a bare number. `value_component` is a select type, whose values need the name of their type (section
    11.1.8).
    """
    return _LIMIT.sub(r"\1LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(\2),\3)", text)


def directed_distances(text: str) -> str:
    """Distances with a direction of their own, with the name and the placement that readers need.

    OCCT 7.9 writes an empty name, and a placement without a second direction, which its own reader rejects.
    """
    number = _last_number(text)
    added: list[str] = []

    def completed(found: re.Match[str]) -> str:
        nonlocal number
        number += 1
        direction = re.search(rf"{found[2]} = DIRECTION\('',\(([^)]*)\)\)", text)
        if direction is None:
            raise ValueError(f"the STEP file has no direction {found[2]}")
        x, y, z = (float(part) for part in direction[1].split(","))
        # Normal to it: the axis with the smallest component, made orthogonal.
        side = min(range(3), key=lambda k: abs((x, y, z)[k]))
        square = [(1.0 if k == side else 0.0) - (x, y, z)[side] * (x, y, z)[k] for k in range(3)]
        size = sum(part * part for part in square) ** 0.5
        added.append(f"#{number} = DIRECTION('',({','.join(_real(part / size) for part in square)}));\n")
        return f"{found[1]}{found[2]},#{number})"

    text = re.sub(r"(AXIS2_PLACEMENT_3D\('orientation',#\d+,)(#\d+),\$\)", completed, text)
    text = text.replace("DIMENSIONAL_LOCATION('',", "DIMENSIONAL_LOCATION('linear distance',")
    end = text.rindex("ENDSEC;")
    return text[:end] + "".join(added) + text[end:]


def with_properties(text: str, properties: dict[str, str]) -> str:
    """The file of one product with named texts as user-defined attributes.

    Entities and names follow the recommended practice of the CAx Implementor Forum.
    """
    product = re.search(r"(#\d+) = PRODUCT_DEFINITION\(", text)
    context = re.search(r"ADVANCED_BREP_SHAPE_REPRESENTATION\('[^']*',\([^)]*\),(#\d+)\)", text)
    # Readers based on OCCT take the last text of a product as its material.
    material = re.search(r"^#\d+ = REPRESENTATION\('material name'", text, flags=re.MULTILINE)
    if product is None or context is None or material is None:
        raise ValueError("the STEP file has no product with a shape and a material")
    number = _last_number(text)
    lines = []
    for name, value in properties.items():
        general, association, definition, link, representation, item = (f"#{number + k}" for k in range(1, 7))
        number += 6
        lines += [
            f"{general} = GENERAL_PROPERTY('',{_string(name)},$);",
            f"{association} = GENERAL_PROPERTY_ASSOCIATION('user defined attribute','',{general},{definition});",
            f"{definition} = PROPERTY_DEFINITION({_string(name)},'',{product[1]});",
            f"{link} = PROPERTY_DEFINITION_REPRESENTATION({definition},{representation});",
            f"{representation} = REPRESENTATION('',({item}),{context[1]});",
            f"{item} = DESCRIPTIVE_REPRESENTATION_ITEM({_string(name)},{_string(value)});",
        ]
    place = material.start()
    return text[:place] + "".join(f"{line}\n" for line in lines) + text[place:]


def _last_number(text: str) -> int:
    return max(int(number) for number in re.findall(r"^#(\d+) =", text, flags=re.MULTILINE))


def _real(value: float) -> str:
    """A real number with a decimal point (section 6.4.2)."""
    shown = f"{value + 0.0:.15G}"
    return shown if "." in shown else shown.replace("E", ".E") if "E" in shown else f"{shown}."


def _string(text: str) -> str:
    """A string with quotes doubled and characters outside ASCII as UCS-2 (section 6.4.3)."""

    def wide(found: re.Match[str]) -> str:
        return f"\\X2\\{found[0].encode('utf-16-be').hex().upper()}\\X0\\"

    return "'" + re.sub(r"[^ -~]+", wide, text.replace("\\", "\\\\").replace("'", "''")) + "'"
