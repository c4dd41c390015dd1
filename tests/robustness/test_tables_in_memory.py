"""Tables of `from_dataframes` in every form of NumPy and pandas: the values are right, or one line says why not."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pyarrow
import pytest

from stagecad import Experiment, InputError, compare
from tests.refusals import refused
from workbench.operations.measurement.experiment import columns_of

TIME = np.arange(400) * 0.01
VELOCITY = 0.03 * np.sin(7.0 * TIME)
POSITION = np.cumsum(VELOCITY) * 0.01
FORCE = 2.0 * np.tanh(VELOCITY / 1e-4) + 5.0 * VELOCITY


def frame(**columns: Any) -> pd.DataFrame:
    given = {"time [s]": TIME, "position [m]": POSITION, "velocity [m/s]": VELOCITY, "friction_force [N]": FORCE}
    return pd.DataFrame(given | {{"time": "time [s]", "force": "friction_force [N]"}[k]: v for k, v in columns.items()})


def parts(data: Any) -> Any:
    return Experiment.from_dataframes({"a": data}, rig="velocity-drive", model=["coulomb"]).problem.records


def times(data: Any) -> np.ndarray:
    return np.concatenate([part.time for part in parts(data)])


@pytest.mark.parametrize("zone", [None, "UTC", "Europe/Paris"])
@pytest.mark.parametrize("label", ["time [s]", "time"])
def test_dates_and_durations_are_seconds_from_the_first_row(zone: str | None, label: str) -> None:
    durations, reference = pd.to_timedelta(TIME, unit="s"), times(frame())
    for given in (dates := pd.Timestamp("2024-03-31 01:30", tz=zone) + durations, pd.Series(durations)):
        data = frame().rename(columns={"time [s]": label})
        data[label] = given
        np.testing.assert_allclose(times(data), reference, atol=1e-9)
    for index in (durations, dates, pd.Index(TIME, name="time [s]")):
        data = frame().drop(columns="time [s]").set_index(index)
        np.testing.assert_allclose(times(data), reference, atol=1e-9)
    arrays = {**{key: values.to_numpy() for key, values in frame().items()}, "time [s]": durations.to_numpy()}
    np.testing.assert_allclose(times(arrays), reference, atol=1e-9)


def test_times_that_are_missing_or_too_close_are_named() -> None:
    given = pd.Series(pd.to_timedelta(TIME, unit="s"))
    given[7] = pd.NaT
    refused(r"a: column 'time \[s\]': row 8 has no time", parts, frame(time=given))
    given = TIME.copy()
    given[0], given[1] = 0.0, 1e-200
    refused(r"row 2, column 'time .*less than 1e-50 s after the row before", parts, frame(time=given))


def gaps(data: Any) -> np.ndarray:
    """Forces of a table, gaps as NaN."""
    return columns_of(data, "a")["friction_force [N]"]


class ArrowTable:
    """A table of another library, such as polars', of which nothing but Arrow's interface is known."""

    def __init__(self, data: pd.DataFrame) -> None:
        self.columns = list(data)
        self.__table = pyarrow.Table.from_pandas(data, preserve_index=False)

    columns: list[str] = []

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        return self.__table.__arrow_c_stream__(requested_schema)


class Dataset(dict[str, Any]):
    """As xarray's: a mapping of the variables without the coordinate, the unit as an attribute."""

    data_vars: Any = None
    units = {"time": "s", "position": "m", "velocity": "m/s", "friction_force": "N"}
    variables = {name: SimpleNamespace(attrs={"units": unit}) for name, unit in units.items()}

    def to_dataframe(self) -> pd.DataFrame:
        return frame().set_axis(list(self.units), axis=1).set_index("time")


@pytest.mark.parametrize("force", [np.arange(400.0), 1e-3 * np.arange(400) ** 2, np.maximum(np.arange(400.0), 100.0)])
def test_a_force_whose_differences_are_zero_is_compared(force: np.ndarray) -> None:
    experiment = Experiment.from_dataframes({"a": frame(force=force)}, rig="velocity-drive", model=["coulomb"])
    assert compare(experiment).to_json()


def test_masked_missing_and_other_libraries_values() -> None:
    wanted = FORCE.copy()
    wanted[20:30] = np.nan
    masked = np.ma.array(FORCE, mask=np.isnan(wanted))
    arrays = {key: values.to_numpy() for key, values in frame().items()} | {"friction_force [N]": masked}
    rows = [
        {key: None if key == "friction_force [N]" and 20 <= k < 30 else value for key, value in row.items()}
        for k, row in enumerate(frame().to_dict("records"))
    ]
    nullable = frame(force=pd.Series(wanted).astype("Float64"))
    for data in (arrays, nullable, nullable.convert_dtypes(), rows, frame(force=pd.array(wanted, dtype="Float64"))):
        np.testing.assert_array_equal(gaps(data), wanted)
    np.testing.assert_array_equal(gaps(frame(force=pd.Series(wanted).astype("double[pyarrow]"))), wanted)
    assert not np.allclose(times(arrays).size, 0)
    everything = {**arrays, "friction_force [N]": np.ma.array(FORCE, mask=True)}
    with pytest.raises(InputError):
        parts(everything)
    for table in (pyarrow.Table.from_pandas(frame()), ArrowTable(frame()), Dataset(friction_force=FORCE)):
        np.testing.assert_array_equal(gaps(table), FORCE)
        np.testing.assert_array_equal(times(table), times(frame()))
    np.testing.assert_array_equal(gaps(ArrowTable(nullable)), wanted)


@pytest.mark.parametrize("factor", [1e-300, 1e-200, 1e-100, 1e100, 1e155, 1e200, 1e306])
@pytest.mark.parametrize("label", ["time [s]", "position [m]", "velocity [m/s]", "friction_force [N]"])
def test_values_of_no_possible_size_are_refused(label: str, factor: float) -> None:
    with pytest.raises(InputError, match=r"in SI units; 1e-50 to 1e\+50 are possible") as caught:
        parts(frame().assign(**{label: frame()[label] * factor}))
    assert label in str(caught.value)


@pytest.mark.parametrize("factor", [1e-15, 1e15])
@pytest.mark.parametrize("label", ["time [s]", "position [m]", "velocity [m/s]", "friction_force [N]"])
def test_values_in_a_wrong_unit_are_compared(label: str, factor: float) -> None:
    given = frame().assign(**{label: frame()[label] * factor})
    assert compare(Experiment.from_dataframes({"a": given}, rig="velocity-drive", model=["coulomb"])).to_json()
