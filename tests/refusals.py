"""Input that is refused."""

from collections.abc import Callable

import pytest

from stagecad.parameters.errors import InputError


def refused(message: str, call: Callable[..., object], *arguments: object, **settings: object) -> None:
    """A call with these arguments is refused in one line that has this pattern."""
    with pytest.raises(InputError, match=message) as caught:
        call(*arguments, **settings)
    assert "\n" not in str(caught.value)
