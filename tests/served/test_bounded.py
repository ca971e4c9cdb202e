# SPDX-License-Identifier: GPL-2.0-or-later
"""Work for a page in a process of its own: its bounds, each with its sentence, and what is left as out of date."""

import os
import threading
import time
from functools import partial

import pytest

from lammps_jump.case.text import read_text
from lammps_jump.errors import CaseError, SetupError
from lammps_jump.served import children
from lammps_jump.served.children import Bounded, OutOfDate, PageWork


@pytest.fixture(scope="module", autouse=True)
def light():
    """Processes that load little, for these tests alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(children, "LOADED", "lammps_jump.served.children")
        patch.setattr(children, "_spare", [])
        yield
        children._end_spare()


def asked(call, *given, seconds=600, page=""):
    return PageWork(partial(call, *given), seconds, "do it elsewhere", page)


def test_what_a_call_returns_or_raises_comes_back():
    work = Bounded()
    assert work.run(asked(divmod, 7, 2)) == (3, 1)
    with pytest.raises(CaseError, match=r"^absent: no such case file"):
        work.run(asked(read_text, "absent"))
    with pytest.raises(RuntimeError, match="ZeroDivisionError: "):
        work.run(asked(divmod, 7, 0))
    assert work.run(asked(divmod, 7, 2)) == (3, 1)


@pytest.mark.parametrize(
    ("call", "given", "seconds", "told"),
    [
        (time.sleep, 600, 0.01, "this took longer than 0.01 s and was left; do it elsewhere"),
        (bytearray, 10**10, 600, "this takes more than 4 GB of memory and was left; do it elsewhere"),
        (os._exit, 3, 600, "the process that worked on this ended; do it elsewhere"),
    ],
)
def test_bounds_are_told_and_the_next_call_is_served(call, given, seconds, told):
    work = Bounded()
    with pytest.raises(SetupError, match=f"^{told}$"):
        work.run(asked(call, given, seconds=seconds))
    assert work.run(asked(divmod, 7, 2)) == (3, 1)


def in_thread(work, found, *given, **options):
    """Do some work in a thread, and wait until it is known; its outcome comes into `found`."""

    def run():
        try:
            found.append(work.run(asked(*given, **options)))
        except Exception as error:
            found.append(type(error))

    thread = threading.Thread(target=run)
    thread.start()
    while options["page"] not in work._newest:
        pass
    return thread


def test_older_work_of_the_same_page_is_left():
    work, found = Bounded(), []
    first = in_thread(work, found, time.sleep, 600, page="one")
    assert work.run(asked(divmod, 7, 2, page="one")) == (3, 1)
    first.join()
    assert found == [OutOfDate] and not work._newest


def test_pages_wait_for_each_other():
    """What another page asks for is not left, and what stands alone neither."""
    work, found = Bounded(), []
    first = in_thread(work, found, time.sleep, 0.05, page="one")
    assert work.run(asked(divmod, 7, 2, page="two")) == (3, 1)
    assert work.run(asked(divmod, 8, 3)) == (2, 2)
    first.join()
    assert found == [None] and not work._newest


def test_what_is_at_work_ends_with_the_pages():
    work, found = Bounded(), []
    first = in_thread(work, found, time.sleep, 600, page="one")
    while work._at_work is None:
        pass
    work.close()
    first.join()
    assert found == [SetupError]
