"""Tables of the model file as objects: what all classes of `tegula.parts` have in common."""

from __future__ import annotations

import dataclasses
import functools
import types
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self, Union, dataclass_transform, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

Number = float | np.floating[Any] | np.integer[Any]
"""Number, of Python or NumPy."""
Integer = int | np.integer[Any]
"""Whole number, of Python or NumPy."""
Numbers = Sequence[Number] | NDArray[Any]
"""List or array of numbers."""
Integers = Sequence[Integer] | NDArray[Any]
"""List or array of whole numbers."""
Rows = Sequence[Numbers] | NDArray[Any]
"""Lists of numbers, or an array with a row for each of them."""
IntegerRows = Sequence[Integers] | NDArray[Any]
"""Lists of whole numbers, or an array with a row for each of them."""
Keys = Mapping[str, Any]
"""Dictionary with the keys of a table, in place of an object."""

_SIMPLE = frozenset([str, int, float, bool, type(None), np.ndarray])
"""Types of values in which there are no objects."""


def _similar(name: str, names: Sequence[str]) -> str:
    """Question after the name that may have been meant."""
    import difflib

    near = difflib.get_close_matches(name, names, 1)
    return f" (did you mean {near[0]!r}?)" if near else ""


def plain(value: Any, above: tuple[int, ...] = ()) -> Any:
    """A value with dictionaries in place of the objects in it; what has none is given back as it is."""
    if type(value) in _SIMPLE or id(value) in above:
        # What contains itself is refused at its place by the compiled part.
        return value
    if isinstance(value, (list, tuple)) and _SIMPLE.issuperset(map(type, value)):
        return value
    above = (*above, id(value))
    if isinstance(value, Part):
        return {key: plain(inner, above) for key, inner in value._given()}
    if isinstance(value, Mapping):
        table = {key: plain(inner, above) for key, inner in value.items()}
        return value if isinstance(value, dict) and all(table[key] is value[key] for key in table) else table
    if isinstance(value, (list, tuple)):
        items = [plain(inner, above) for inner in value]
        return value if all(new is old for new, old in zip(items, value)) else items
    return value


def _equal(one: Any, other: Any) -> bool:
    """Whether two values have equal keys, numbers and texts; lists, tuples and arrays of equal numbers are equal."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_equal(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(map(_equal, one, other))
    return bool(one == other)


@dataclass_transform(kw_only_default=True)
class Part:
    """A table of the model file; its attributes are the keys, and those that are None are not given.

    Keys that are words of Python have an underscore behind them: `from_`, `continue_`. Values are checked by `tegula.Model`.
    """

    _type: ClassVar[str | None] = None
    """Value of the key `type`; None in tables without it."""

    __hash__ = None  # type: ignore[assignment]

    def __init_subclass__(cls, *, type: str | None = None) -> None:
        super().__init_subclass__()
        cls._type = type
        dataclasses.dataclass(kw_only=True, repr=False, eq=False)(cls)
        cls.__init__ = _checked(cls, cls.__init__)  # type: ignore[method-assign]

    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: object) -> None:
            names = _names(type(self))
            if name not in names:
                raise AttributeError(f"{type(self).__name__} has no key {name!r}{_similar(name, names)}; its keys are: {', '.join(names)}")
            object.__setattr__(self, name, value)

    def as_dict(self) -> dict[str, Any]:
        """Dictionary with the given keys of the model file, in which tables are dictionaries, too."""
        table: dict[str, Any] = plain(self)
        return table

    @classmethod
    def from_dict(cls, keys: Mapping[str, Any]) -> Self:
        """Object of a dictionary with the keys of the model file, such as `tegula.Model.keys()`; tables in it become objects, too.

        Args:
            keys: Keys of the table, without `type` or with that of the class.

        Raises:
            TypeError: a key is unknown, or a required one is missing.
            ValueError: there is no table of a `type`.
        """
        made: Self = _read_part(keys, [cls], "")
        return made

    def _given(self) -> list[tuple[str, Any]]:
        """Keys of the model file with their values, without those that are not given."""
        values = [(name.rstrip("_"), getattr(self, name)) for name in _names(type(self))]
        kind = [] if self._type is None else [("type", self._type)]
        return kind + [(key, value) for key, value in values if value is not None]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return _equal(plain(self), plain(other))

    def __repr__(self) -> str:
        values = [(name, getattr(self, name)) for name in _names(type(self))]
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in values if value is not None)})"


def _names(cls: type[Part]) -> list[str]:
    """Names of the attributes of a class."""
    return [field.name for field in dataclasses.fields(cls)]  # type: ignore[arg-type]


def _checked(cls: type[Part], init: Callable[..., None]) -> Callable[..., None]:
    """The constructor of a class, with messages that tell its keys."""
    fields = dataclasses.fields(cls)  # type: ignore[arg-type]
    names = [field.name for field in fields]
    required = [field.name for field in fields if field.default is dataclasses.MISSING]

    @functools.wraps(init)
    def checked(self: Part, *values: Any, **keys: Any) -> None:
        if values:
            raise TypeError(f"{cls.__name__} takes its keys by their names, as {cls.__name__}({names[0] if names else ''}=…)")
        for key in keys:
            if key not in names:
                advice = f"its keys are: {', '.join(names)}" if names else "it has no keys"
                raise TypeError(f"{cls.__name__} has no key {key!r}{_similar(key, names)}; {advice}")
        missing = [name for name in required if keys.get(name) is None]
        if missing:
            raise TypeError(f"{cls.__name__} needs {', '.join(f'`{name}`' for name in missing)}")
        init(self, **keys)

    return checked


def _read_part(keys: Mapping[str, Any], classes: Sequence[type[Any]], place: str) -> Any:
    """Object of a dictionary, of the class with its `type`."""
    where = f"{place}: " if place else ""
    cls = classes[0]
    if any(c._type is not None for c in classes):
        kinds = {c._type: c for c in classes}
        kind = keys.get("type", cls._type if len(classes) == 1 else None)
        if kind not in kinds:
            raise ValueError(f"{where}the type {kind!r} is unknown{_similar(str(kind), list(kinds))}; there are: {', '.join(kinds)}")
        cls = kinds[kind]
        keys = {key: value for key, value in keys.items() if key != "type"}
    hints = get_type_hints(cls)
    values = {}
    for key, value in keys.items():
        name = f"{key}_" if f"{key}_" in hints else key
        values[name] = _read(value, hints.get(name, Any), f"{place}.{key}" if place else key)
    try:
        return cls(**values)
    except TypeError as error:
        raise TypeError(f"{where}{error}") from None


def _read(value: Any, hint: Any, place: str) -> Any:
    """Value of an attribute with objects in place of dictionaries, where its annotation has classes of objects."""
    options = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    if isinstance(value, Mapping):
        classes = [option for option in options if isinstance(option, type) and issubclass(option, Part)]
        if classes:
            return _read_part(value, classes, place)
        inner = [get_args(option)[1] for option in options if get_origin(option) is Mapping]
        return {key: _read(item, inner[0], f"{place}.{key}") for key, item in value.items()} if inner else value
    if isinstance(value, (list, tuple)):
        inner = [get_args(option)[0] for option in options if get_origin(option) is Sequence]
        if inner and any(isinstance(item, Mapping) for item in value):
            return [_read(item, inner[0], f"{place}[{i}]") for i, item in enumerate(value)]
    return value
