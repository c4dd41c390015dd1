"""Work shared with a forked process: the same answers, whatever becomes of it."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from sim.effect import Effect
from sim.library import find
from sysid.side_by_side import elsewhere, processors, side_by_side


def test_answers_come_in_the_order_of_the_items() -> None:
    assert side_by_side(lambda n: n * n, list(range(11))) == [n * n for n in range(11)]
    assert side_by_side(lambda n: n, []) == []


def test_what_begins_is_told_here_once_and_in_order() -> None:
    told: list[int] = []
    side_by_side(lambda n: n, list(range(7)), begun=told.append)
    assert told == list(range(7))


@pytest.mark.skipif(processors() == 1, reason="nothing to share with")
def test_half_of_the_work_is_done_in_another_process() -> None:
    here = os.getpid()
    done = side_by_side(lambda n: (os.getpid(), elsewhere(), processors()), [0, 1])
    assert done[0] == (here, False, processors())
    # Who works for another has nobody else work.
    assert (done[1][0] != here, *done[1][1:]) == (True, True, 1)


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
        raise ValueError(effect.name)

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
