"""Load plugins, keep a registry of names, and know where every plugin comes from.

Built-in plugins come in through the same hooks as a stranger's: every module of the built-in packages is registered
with pluggy, and so is whatever a distribution names under `[project.entry-points.railsearch]`. One broken
external plugin is reported and left out; it does not take the program down.
"""

import dataclasses
import importlib
import importlib.metadata
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, cast

import pluggy

from railsearch import hookspecs
from railsearch.errors import PluginError
from railsearch.estimator_surrogate import estimator_surrogate
from railsearch.interfaces import Surrogate, TrackModel
from railsearch.parameters import make_parameters
from railsearch.wording import closest

BUILT_IN_PACKAGES = (
    "railsearch_plugins.track_models",
    "railsearch_plugins.surrogates",
    "railsearch_plugins.strategies",
    "railsearch_plugins.scalarisers",
    "railsearch_problems",
)
BUILT_IN_MODULES = ("railsearch.cli",)
KINDS = {
    "track-model": "railsearch_track_models",
    "surrogate": "railsearch_surrogates",
    "strategy": "railsearch_strategies",
    "scalariser": "railsearch_scalarisers",
    "problem": "railsearch_problems",
    "command": "railsearch_commands",
}
REQUIRED = {
    "track-model": ("Parameters", "metrics", "histories", "warm_up", "check", "simulate"),
    "surrogate": ("Parameters", "fit", "add", "predict", "gradient"),
    "strategy": ("Parameters", "capabilities", "ask", "tell"),
    "scalariser": ("Parameters", "ready", "prepare", "__call__"),
    "problem": ("make", "sections", "simulate"),
    "command": (),
}
# A name that ends so stands for a family of plugins, from which `FAMILY:x` takes the member x.
FAMILY = ":NAME"
FAMILY_REQUIRED = ("members", "member")


@dataclass(frozen=True)
class Provenance:
    """Where a plugin comes from."""

    module: str
    distribution: str
    version: str


@dataclass(frozen=True)
class Entry:
    """A registered plugin."""

    kind: str
    name: str
    plugin: Any
    provenance: Provenance

    @property
    def summary(self) -> str:
        """The first line of the plugin's docstring."""
        return (self.plugin.__doc__ or "").strip().split("\n")[0]

    @property
    def members(self) -> Sequence[str]:
        """The names that may replace NAME in the name of a family; none for a single plugin."""
        return tuple(self.plugin.members()) if self.name.endswith(FAMILY) else ()


class Registry:
    """Plugins by kind and name; the host through which plugins get one another."""

    def __init__(self, entries: Mapping[tuple[str, str], Entry], warnings: Iterable[str]) -> None:
        self._entries = dict(entries)
        self.warnings = tuple(warnings)

    def entries(self, kind: str | None = None) -> list[Entry]:
        """All entries, or those of one kind, by kind and name."""
        return sorted((e for e in self._entries.values() if kind in (None, e.kind)), key=lambda e: (e.kind, e.name))

    def entry(self, kind: str, name: str) -> Entry:
        """The entry of that kind and name. Raises PluginError, with the names there are, if it is unknown."""
        family = self._family(kind, name)
        if family is not None:
            return dataclasses.replace(family, name=name, plugin=family.plugin.member(name.partition(":")[2]))
        if (kind, name) in self._entries:
            return self._entries[kind, name]
        known = [entry.name for entry in self.entries(kind)]
        broken = f" Not loaded: {'; '.join(self.warnings)}" if self.warnings else ""
        raise PluginError(f"unknown {kind} '{name}'{closest(name, known)}; known: {', '.join(known) or 'none'}.{broken}")

    def called(self, name: str) -> list[Entry]:
        """The entries of that name, one of each kind that has it; members of families and families themselves as well."""
        families = [kind for kind in KINDS if self._family(kind, name) and (kind, name) not in self._entries]
        return [entry for entry in self.entries() if entry.name == name] + [self.entry(kind, name) for kind in families]

    def get(self, kind: str, name: str) -> Any:
        """The plugin of that kind and name. Raises PluginError if it is unknown."""
        return self.entry(kind, name).plugin

    def _family(self, kind: str, name: str) -> Entry | None:
        """The family `FAMILY:NAME` to which a name with a colon belongs."""
        return self._entries.get((kind, name.partition(":")[0] + FAMILY)) if ":" in name else None

    def extended(self, kind: str, name: str, plugin: Any) -> "Registry":
        """This registry and one plugin more, for a program of one's own. Raises PluginError if it is not of the kind."""
        found: list[Entry] = []
        _collector(kind, Provenance(plugin.__module__, "this program", ""), found)(name, plugin)
        entries = dict(self._entries)
        _add(entries, found[0])
        return Registry(entries, self.warnings)

    def track_model(self, name: str) -> TrackModel:
        """A new track model."""
        return cast(TrackModel, self.get("track-model", name)())

    def surrogate(self, name: str, dimension: int, settings: Mapping[str, object]) -> Surrogate:
        """A new surrogate for points of that dimension, registered or a scikit-learn regressor by its dotted name.

        Raises PluginError if it is unknown, InputError for settings that are not allowed.
        """
        if "." in name and ("surrogate", name) not in self._entries:
            return estimator_surrogate(name, dimension, settings)
        plugin = self.get("surrogate", name)
        return cast(Surrogate, plugin(dimension, make_parameters(plugin.Parameters, settings, f"surrogate {name}")))


def load_plugins() -> Registry:
    """Load built-in and installed plugins. Raises PluginError for a name that is taken twice."""
    manager = pluggy.PluginManager("railsearch")
    manager.add_hookspecs(hookspecs)
    warnings: list[str] = []
    origins: dict[str, Provenance] = {}
    version = importlib.metadata.version("railsearch")
    for module in _built_in_modules():
        _register(manager, module, module.__name__, Provenance(module.__name__, "railsearch", version), origins, warnings)
    for point, distribution in _entry_points():
        origin = Provenance(point.value, distribution.metadata["Name"], distribution.version)
        try:
            plugin = point.load()
        except Exception as error:  # noqa: BLE001 - a stranger's module may raise anything while it is imported
            warnings.append(_broken(origin, f"cannot be imported: {type(error).__name__}: {error}"))
            continue
        _register(manager, plugin, f"{origin.distribution}:{point.name}", origin, origins, warnings)
    return collect(manager, origins, warnings)


def collect(manager: pluggy.PluginManager, origins: Mapping[str, Provenance], warnings: list[str]) -> Registry:
    """Call every hook of every plugin and build the registry. Raises PluginError for a name that is taken twice."""
    entries: dict[tuple[str, str], Entry] = {}
    for kind, hook in KINDS.items():
        for implementation in getattr(manager.hook, hook).get_hookimpls():
            if not manager.has_plugin(implementation.plugin_name):
                continue
            origin = origins[implementation.plugin_name]
            found: list[Entry] = []
            try:
                implementation.function(_collector(kind, origin, found))
            except Exception as error:  # noqa: BLE001 - a stranger's hook may raise anything
                warnings.append(_broken(origin, f"fails in {hook}: {type(error).__name__}: {error}"))
                continue
            for entry in found:
                _add(entries, entry)
    return Registry(entries, warnings)


def _collector(kind: str, origin: Provenance, found: list[Entry]) -> Callable[[str, Any], None]:
    def register(name: str, plugin: Any) -> None:
        required = FAMILY_REQUIRED if name.endswith(FAMILY) else REQUIRED[kind]
        missing = [attribute for attribute in required if not hasattr(plugin, attribute)]
        if missing:
            raise PluginError(f"{kind} '{name}' lacks {', '.join(missing)}; see railsearch.interfaces")
        found.append(Entry(kind, name, plugin, origin))

    return register


def _add(entries: dict[tuple[str, str], Entry], entry: Entry) -> None:
    taken = entries.get((entry.kind, entry.name))
    if taken is not None:
        both = " and by ".join(f"{o.distribution} {o.version} ({o.module})" for o in (taken.provenance, entry.provenance))
        raise PluginError(
            f"the {entry.kind} name '{entry.name}' is registered twice, by {both}: "
            "uninstall one of them or rename its plugin"
        )
    entries[entry.kind, entry.name] = entry


def _register(
    manager: pluggy.PluginManager,
    plugin: object,
    name: str,
    origin: Provenance,
    origins: dict[str, Provenance],
    warnings: list[str],
) -> None:
    origins[name] = origin
    try:
        manager.register(plugin, name)
        manager.check_pending()
    except pluggy.PluginValidationError as error:
        if manager.has_plugin(name):
            manager.unregister(plugin)
        what, hooks = " ".join(str(error).split()), ", ".join(sorted(KINDS.values()))
        warnings.append(_broken(origin, f"has a hook that railsearch does not know ({what}); the hooks are {hooks}"))
    except ValueError:
        warnings.append(_broken(origin, "is named by two entry points; the first one counts"))


def _broken(origin: Provenance, what: str) -> str:
    distribution = origin.distribution
    return f"plugin {origin.module} of {distribution} {origin.version} {what}. Update or uninstall {distribution}"


def _built_in_modules() -> Iterator[ModuleType]:
    yield from map(importlib.import_module, BUILT_IN_MODULES)
    for name in BUILT_IN_PACKAGES:
        package = importlib.import_module(name)
        for info in pkgutil.iter_modules(package.__path__):
            yield importlib.import_module(f"{name}.{info.name}")


def _entry_points() -> Iterator[tuple[importlib.metadata.EntryPoint, importlib.metadata.Distribution]]:
    for point in importlib.metadata.entry_points(group="railsearch"):
        if point.dist is not None:
            yield point, point.dist
