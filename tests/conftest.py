# SPDX-License-Identifier: GPL-2.0-or-later
"""Fixtures and settings of all tests; functions that several share are in `made_up` and `children`."""

import gc
import os
import shutil
import signal
import sys
from pathlib import Path

HERE = Path(__file__).parent
CACHES = Path(os.environ.get("JUMP_TEST_CACHES") or HERE.parent / ".pytest_cache" / "caches")
MADE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lammps-jump" / "kernels"
"""Where `make` compiled."""
for variable, folder in (("XDG_CACHE_HOME", "xdg"), ("MPLCONFIGDIR", "matplotlib")):
    os.environ[variable] = str(CACHES / folder)
    (CACHES / folder).mkdir(parents=True, exist_ok=True)
os.environ.pop("LAMMPS_JUMP_CACHE", None)
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else every process compiles the program, every worker the tests
sys.dont_write_bytecode = False
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does: waiting threads cost processor time
os.environ["LAMMPS_JUMP_THREADS"] = "1"  # the workers of the tests are as many as the cores
# engines run in processes of their own, which find the hook on their path
os.environ["PYTHONPATH"] = os.pathsep.join([str(HERE / "hook"), *filter(None, [os.environ.get("PYTHONPATH")])])

import budget  # noqa: E402
import fault_table  # noqa: E402
import pytest  # noqa: E402

from lammps_jump.engines.interrupts import SIGNALS  # noqa: E402


def take_compiled(caches: Path) -> None:
    """Begin empty caches with what `make` compiled: entries are named by all that they were made from, and checked."""
    kernels = caches / "xdg" / "lammps-jump" / "kernels"
    if MADE.is_dir() and MADE != kernels and not kernels.exists():
        shutil.copytree(MADE, kernels, ignore=shutil.ignore_patterns("objects"))


def register_profiles():
    """Examples of hypothesis are the same each time; ``--hypothesis-profile=random``, as in `make check`, wins."""
    from hypothesis import settings  # 1.4 s of processor time, which the process that only hands out tests need not

    # what finds nothing once finds nothing again: `make check` tries many more, others each time
    settings.register_profile("same_each_time", deadline=None, derandomize=True, max_examples=15)
    settings.register_profile("random", deadline=None, print_blob=True)
    return settings


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config):
    """Count processor time, and register the profiles before hypothesis loads the one that was asked for."""
    config.pluginmanager.register(budget.Budget(config, CACHES))
    if not hasattr(config, "workerinput"):
        take_compiled(CACHES)
    if config.getoption("--hypothesis-profile"):
        register_profiles()


def pytest_collection(session):
    """Load the profile of the default run, in a process that runs tests."""
    gc.disable()  # while the modules are imported it finds nothing, and takes a quarter of the processor time
    if not session.config.getoption("--hypothesis-profile"):
        register_profiles().load_profile("same_each_time")
        from hypothesis.internal.conjecture import providers

        if hasattr(providers, "_get_local_constants"):
            # each worker would parse all modules, 3 s, and any new constant in one of them would change the examples
            providers._get_local_constants = lambda: providers._local_constants


@pytest.fixture(scope="session", autouse=True)
def remembered():
    """What many tests make alike is made once: the command line, trees of YAML, piles of discs, texts of the C++."""
    import typer.main  # not in the process that only hands out tests

    from lammps_jump.case import packing, text
    from lammps_jump.compiling.product import Product
    from lammps_jump.core import CORE
    from lammps_jump.engines.plugin import PLUGIN

    commands, trees, piles, sources = {}, {}, {}, {}
    get_command, compose, piled, included = typer.main.get_command, text._compose, packing.piled, Product.included

    def command_of(app):
        if id(app) not in commands:
            commands[id(app)] = app, get_command(app)  # the app too, that no other gets its number
        return commands[id(app)][1]

    def tree_of(words, file):
        if words not in trees:
            tree = compose(words, file)
            if len(words) > 20_000:
                return tree
            trees[words] = tree
        return trees[words]

    def pile_of(diameters, x, y, largest):
        key = tuple(diameters), tuple(x), tuple(y), largest
        if key not in piles:
            piles[key] = piled(*key)
        return piles[key].copy()

    def included_in(product, unit):
        if product not in (CORE, PLUGIN):  # those of a test, whose files change
            return included(product, unit)
        if (product.name, unit) not in sources:
            sources[product.name, unit] = included(product, unit)
        return dict(sources[product.name, unit])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Product, "included", included_in)
        patch.setattr(typer.main, "get_command", command_of)
        patch.setattr(text, "_compose", tree_of)
        patch.setattr(packing, "piled", pile_of)
        yield


@pytest.fixture(scope="session")
def _kept_workers():
    """Pools hand on the workers that they have done with, to a pool of the same folder and environment."""
    from lammps_jump.sweeps import pool  # as above

    kept, start = [], pool.Worker

    def here():
        variables = {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}
        return os.getcwd(), variables

    def take(*modules):
        found = next((one for one in kept if one[0] == here() and one[1].process.poll() is None), None)
        if found is None:
            worker = start(*modules)
            worker.begun_in = here()
            return worker
        kept.remove(found)
        return found[1]

    def close(self):
        kept.extend((worker.begun_in, worker) for worker in self._idle)
        self._idle.clear()

    yield take, close
    for _, worker in kept:
        worker.end(kill=True)


@pytest.fixture(scope="module")
def kept_workers(_kept_workers):
    """For the tests of a module: a worker of a pool costs more to start than most calls."""
    take, close = _kept_workers
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lammps_jump.sweeps.pool.Worker", take)
        patch.setattr("lammps_jump.sweeps.pool.Pool.close", close)
        yield


def _blank_pictures():
    """One small picture for every figure: drawing takes longer than a short run; `tests/analysis` looks at drawings."""
    from made_up import blank_figures, on_the_spot  # 2.6 s, as above

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lammps_jump.analysis.pipeline.draw_figures", blank_figures)
        patch.setattr("lammps_jump.analysis.pipeline.aside", on_the_spot)
        yield


blank_pictures = pytest.fixture(_blank_pictures, scope="module", name="blank_pictures")
blank_pictures_here = pytest.fixture(_blank_pictures, name="blank_pictures_here")
"""The same for one test of a module."""


@pytest.fixture
def tried(record_property):
    """Says how many faults a test has tried; see `fault_table`."""
    return lambda times: record_property("times", times)


def pytest_collection_finish(session):
    """From here on only what tests make is looked at for garbage."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)  # as the command line does
    gc.enable()


def pytest_collection_modifyitems(items):
    """Let the report of a test tell its kind of fault."""
    for item in items:
        if mark := item.get_closest_marker("fault"):
            assert mark.args[0] in fault_table.KINDS
            item.user_properties.append(("fault", mark.args[0]))


def pytest_runtest_logreport(report):
    """Count the faults of a test that passed."""
    if report.when == "call" and report.passed:
        fault_table.count(report.user_properties)


def pytest_terminal_summary(terminalreporter, config):
    """Say how to run what the default run leaves out."""
    if "not long" in config.option.markexpr:
        terminalreporter.write_line("left out: long tests (make check), those in Chromium (make browser)")


def pytest_sessionfinish(session, exitstatus):
    """Write the table where a form was asked for by name."""
    if fault_table.FORM and exitstatus == 0 and not hasattr(session.config, "workerinput"):
        fault_table.write_table()


@pytest.fixture
def ctrl_c_heard():
    """Ctrl-C raises a KeyboardInterrupt and no signal is ignored, as in the background of a shell or under nohup."""
    before = {number: signal.signal(number, signal.SIG_DFL) for number in SIGNALS}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(scope="session")
def plugin():
    """Path of the compiled plugin; skips where there is none."""
    from made_up import plugin_or_skip  # 2.6 s, as above

    return plugin_or_skip()


@pytest.fixture(scope="session")
def lammps():
    """LAMMPS' Python class; skips where it cannot be loaded."""
    from lammps_jump.engines.lammps.loader import load_lammps  # 0.2 s
    from lammps_jump.errors import SetupError

    try:
        return load_lammps().lammps
    except SetupError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def compiled_core():
    """The library of the core; skips where there is none."""
    from lammps_jump.core import core, why_absent  # as above

    return core() or pytest.skip(f"no core here: {why_absent()}")
