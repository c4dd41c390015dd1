"""Libraries that take long to load, each imported when one of its names is first used."""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any


class DeferredModule(ModuleType):
    """Stands for a module that is imported when an attribute of it is first read."""

    def __getattr__(self, name: str) -> Any:
        value = getattr(import_module(self.__name__), name)
        setattr(self, name, value)
        return value


if TYPE_CHECKING:
    import pandas as pd
    import pyarrow
    import tomlkit
    from pyarrow import compute
    from scipy import linalg, sparse
    from scipy.sparse import linalg as sparse_linalg
else:
    pd, pyarrow, tomlkit = map(DeferredModule, ("pandas", "pyarrow", "tomlkit"))
    compute = DeferredModule("pyarrow.compute")
    linalg, sparse, sparse_linalg = map(DeferredModule, ("scipy.linalg", "scipy.sparse", "scipy.sparse.linalg"))
# Its types leave open what an export gives.
trimesh: Any = DeferredModule("trimesh")
