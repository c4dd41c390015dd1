"""Work shared with a forked process: the same answers, whatever becomes of it."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest

from sim.effects.catalogue import find
from sim.library.effect import Effect
from sysid.signals.side_by_side import elsewhere, processors, side_by_side


def test_answers_come_in_the_order_of_the_items() -> None:
    assert side_by_side(lambda n: n * n, list(range(11))) == [n * n for n in range(11)]
    assert side_by_side(lambda n: n, []) == []


def test_what_begins_is_told_here_once_and_in_order() -> None:
    told: list[int] = []
    side_by_side(lambda n: n, list(range(7)), begun=told.append)
    assert told == list(range(7))


@pytest.mark.skipif(processors() == 1, reason="nothing to share with")
def test_whoever_is_free_takes_the_next_piece() -> None:
    here = os.getpid()

    def work(seconds: float) -> tuple[int, bool, int]:
        time.sleep(seconds)
        return os.getpid(), elsewhere(), processors()

    done = side_by_side(work, [0.5, *[0.02] * 5])
    # Whoever has the long piece has no other.
    assert done.count(done[0]) == 1
    assert {entry[0] == here for entry in done} == {True, False}
    # Who works for another has nobody else work.
    assert all(entry[1:] == ((False, processors()) if entry[0] == here else (True, 1)) for entry in done)


def test_every_piece_is_done_once(tmp_path: Path) -> None:
    def work(n: int) -> int:
        with (tmp_path / str(n)).open("a") as file:
            file.write("x")
        return n

    assert side_by_side(work, list(range(300))) == list(range(300))
    assert {file.read_text() for file in tmp_path.iterdir()} == {"x"}


def test_what_is_shared_comes_back_as_itself() -> None:
    effects = [find("stribeck"), find("coulomb")]
    answers = side_by_side(lambda effect: {"of": (effect, effect.name)}, effects, effects)
    assert all(answer["of"][0] is effect for answer, effect in zip(answers, effects, strict=True))


def test_an_answer_that_cannot_be_sent_is_worked_out_here() -> None:
    answers = side_by_side(lambda n: lambda: n + 1, [1, 2, 3])
    assert [answer() for answer in answers] == [2, 3, 4]


def test_a_process_that_dies_is_done_without() -> None:
    def work(n: int) -> int:
        if elsewhere():
            os.kill(os.getpid(), signal.SIGKILL)
        return -n

    assert side_by_side(work, [1, 2, 3]) == [-1, -2, -3]


def test_an_error_is_the_callers(capfd: pytest.CaptureFixture[str]) -> None:
    def work(effect: Effect) -> float:
        if effect.name == "coulomb":
            raise ValueError(effect.name)
        return 1.0

    with pytest.raises(ValueError, match="coulomb"):
        side_by_side(work, [find("coulomb"), find("viscous")])
    with pytest.raises(KeyboardInterrupt):
        side_by_side(lambda n: (_ for _ in ()).throw(KeyboardInterrupt) if n == 0 else n, [0, 1])
    assert capfd.readouterr() == ("", "")


def test_a_thread_shares_with_nobody() -> None:
    found: list[int] = []
    thread = threading.Thread(target=lambda: found.append(processors()))
    thread.start()
    thread.join()
    assert found == [1]
