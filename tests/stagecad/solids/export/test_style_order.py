"""The order of the colours in a STEP file does not depend on the run that wrote it."""

import re

from stagecad.solids.export.step_stl_glb import PRESENTATION, ordered_styles

HEAD = "ISO-10303-21;\nDATA;\n#1 = SHAPE('one');\n#2 = SHAPE('two');\n#3 = CONTEXT();\n#4 = CONTEXT();\n"
TAIL = "ENDSEC;\nEND-ISO-10303-21;\n"
ONE_FIRST = f"""#5 = {PRESENTATION}('',(
    #6),#3);
#6 = STYLED_ITEM('color',(#7),#1);
#7 = COLOUR_RGB('',0.1,0.2,0.3);
#8 = {PRESENTATION}('',(#9),#4);
#9 = STYLED_ITEM('color',(#7),#2);
"""
TWO_FIRST = f"""#5 = {PRESENTATION}('',(#6),#4);
#6 = STYLED_ITEM('color',(#7),#2);
#7 = COLOUR_RGB('',0.1,0.2,0.3);
#8 = {PRESENTATION}('',(
    #9),#3);
#9 = STYLED_ITEM('color',(#7),#1);
"""


def test_two_orders_of_the_same_colours_give_the_same_text() -> None:
    one, two = (ordered_styles(HEAD + styles + TAIL) for styles in (ONE_FIRST, TWO_FIRST))
    assert one == two
    assert one == HEAD + re.sub(r"\n\s+", "", ONE_FIRST) + TAIL


def test_a_file_without_colours_is_left_alone() -> None:
    assert ordered_styles(HEAD + TAIL) == HEAD + TAIL
