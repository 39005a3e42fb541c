import sys
import types
from collections.abc import Callable
from typing import Any

import pytest

from railsearch import plugin_manager
from railsearch.errors import PluginError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Capabilities, NoParameters
from railsearch.plugin_manager import load_plugins


class Still:
    """A strategy that does nothing."""

    Parameters = NoParameters
    capabilities = Capabilities()

    def ask(self) -> None: ...
    def tell(self, evaluations: Any) -> None: ...


def module(**contents: Any) -> types.ModuleType:
    made = types.ModuleType("strange")
    for name, value in contents.items():
        setattr(made, name, value)
    return made


def registering(name: str, plugin: Any = Still) -> types.ModuleType:
    @hookimpl
    def railsearch_strategies(register: Callable[[str, Any], None]) -> None:
        register(name, plugin)

    return module(railsearch_strategies=railsearch_strategies)


def test_built_ins_come_in_by_the_hooks_with_their_origin() -> None:
    registry = load_plugins()
    assert registry.warnings == ()
    names = {(entry.kind, entry.name) for entry in registry.entries()}
    assert {
        ("strategy", "dycors"),
        ("track-model", "level-crossing"),
        ("problem", "level-crossing"),
        ("command", "run"),
    } <= names
    entry = registry.entry("strategy", "dycors")
    assert entry.provenance.distribution == "railsearch"
    assert entry.provenance.module == "railsearch_plugins.strategies.dycors"
    assert all(entry.summary for entry in registry.entries())


def test_a_stranger_registers_through_the_same_hook(install: Callable[..., None]) -> None:
    install(acme=lambda: registering("still"))
    entry = load_plugins().entry("strategy", "still")
    assert (entry.plugin, entry.provenance.distribution, entry.provenance.version) == (Still, "acme", "1.2")


def test_a_name_taken_twice_names_both_distributions(install: Callable[..., None]) -> None:
    install(acme=lambda: registering("dycors"))
    with pytest.raises(PluginError, match=r"'dycors' is registered twice, by railsearch .* and by acme 1.2 .*uninstall one"):
        load_plugins()


def test_an_unknown_name_is_answered_with_the_known_ones() -> None:
    with pytest.raises(PluginError, match=r"unknown strategy 'dycor', did you mean 'dycors'\?; known: .*random"):
        load_plugins().get("strategy", "dycor")


def broken_import() -> Any:
    raise ImportError("No module named 'torch'")


@hookimpl
def railsearch_strategys(register: Any) -> None: ...


@hookimpl
def railsearch_strategies(registrar: Any) -> None: ...


@hookimpl
def valid_hook(register: Any) -> None:
    register("half-a-plugin", object)


def failing_hook() -> types.ModuleType:
    @hookimpl
    def railsearch_strategies(register: Any) -> None:
        raise RuntimeError("licence expired")

    return module(railsearch_strategies=railsearch_strategies)


@pytest.mark.parametrize(
    ("load", "words"),
    [
        (broken_import, ("cannot be imported", "No module named 'torch'")),
        (
            lambda: module(railsearch_strategys=railsearch_strategys),
            ("hook that railsearch does not know", "railsearch_strategys"),
        ),
        (lambda: module(railsearch_commands=valid_hook, railsearch_strategies=railsearch_strategies), ("registrar",)),
        (failing_hook, ("fails in railsearch_strategies", "licence expired")),
        (lambda: registering("half", object), ("'half' lacks Parameters, capabilities, ask, tell",)),
    ],
)
def test_a_broken_plugin_is_named_and_the_rest_goes_on(
    install: Callable[..., None], load: Callable[[], Any], words: tuple[str, ...]
) -> None:
    install(acme=load, sound=lambda: registering("still"))
    registry = load_plugins()
    assert registry.get("strategy", "still") is Still
    assert registry.get("strategy", "dycors")
    assert "half-a-plugin" not in [entry.name for entry in registry.entries()]
    (warning,) = registry.warnings
    assert all(word in warning for word in ("acme 1.2", "Update or uninstall acme", *words)), warning
    with pytest.raises(PluginError, match=r"Not loaded: .*acme"):
        registry.get("strategy", "half")


def test_every_hook_has_a_kind_and_every_kind_a_built_in() -> None:
    hooks = [name for name in vars(plugin_manager.hookspecs) if name.startswith("railsearch_")]
    assert sorted(hooks) == sorted(plugin_manager.KINDS.values())
    assert {entry.kind for entry in load_plugins().entries()} == set(plugin_manager.KINDS)


def test_heavy_libraries_are_imported_only_where_used() -> None:
    import subprocess

    code = "import sys; from railsearch.plugin_manager import load_plugins; load_plugins(); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numba", "matplotlib", "sklearn", "torch", "pymoo.algorithms.moo.nsga2"} & set(loaded)
