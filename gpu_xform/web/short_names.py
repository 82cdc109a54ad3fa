"""Short names for all that the programs of pages declare: one name for one, the same in scripts, WGSL and data."""

import itertools
import string
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .scopes import BOTH, PROPERTY, SCRIPT_WORDS, VARIABLE, WGSL_WORDS, NamedText, read_script
from .tokens import join_script, split_script

TABLES = frozenset(("ROTATION_KEYS", "SIDE_KEYS", "SIDES"))  # data whose keys are no names of the program
_LETTERS = string.ascii_letters
_FIRST = string.ascii_uppercase + string.ascii_lowercase
_SECOND = string.ascii_letters + string.digits

SCRIPT = "script"  # the key of the scripts, which are one text
Scope = tuple[str, int]  # the key of a text, and the number of the scope in it


@dataclass(frozen=True)
class ShortNames:
    """New names by old ones.

    shared : of properties, and of what is declared outside functions
    local : of the variables of each scope
    """

    shared: Mapping[str, str]
    local: Mapping[Scope, Mapping[str, str]]

    def rename(self, key: str, text: NamedText) -> list[str]:
        """Return the tokens of a text with new names."""
        return _rename(text, self.shared, lambda scope: self.local.get((key, scope), {}))

    def rename_keys(self, data: Any) -> Any:
        """Return data, as JSON has it, with new names of its keys."""
        if isinstance(data, dict):
            return {
                self.shared.get(key, key): value if key in TABLES else self.rename_keys(value)
                for key, value in data.items()
            }
        return [self.rename_keys(item) for item in data] if isinstance(data, list) else data

    def rename_script(self, text: str) -> str:
        """Return a script of somebody else, which uses what a page has, with the names that the page gives to that."""
        named = read_script(split_script(text))
        by_role: dict[str | None, set[str]] = {VARIABLE: set(), BOTH: set()}
        for token, role in zip(named.tokens, named.roles, strict=True):
            by_role.setdefault(role, set()).add(token)
        own = {name: name for name in by_role[VARIABLE] - by_role[BOTH]}
        return join_script(_rename(named, self.shared, lambda _: own))


def _rename(text: NamedText, shared: Mapping[str, str], find_local: Callable[[int], Mapping[str, str]]) -> list[str]:
    renamed = []
    for token, role, scope in zip(text.tokens, text.roles, text.scopes, strict=True):
        if role is None:
            renamed.append(token)
        else:
            own = find_local(scope).get(token) if role is VARIABLE else None
            renamed.append(own or shared.get(token, token))
    return renamed


def choose_names(
    script: NamedText, wgsl: Mapping[str, NamedText], data_names: Collection[str], kept: Collection[str]
) -> ShortNames:
    """Return names for a program, the shortest for what it uses most.

    wgsl : by key
    data_names : the keys of data, which are properties
    kept : names that stay: properties of the browser, and what texts name
    """
    texts = {SCRIPT: script, **wgsl}
    local = {(key, scope): names for key, text in texts.items() for scope, names in _find_local(text).items()}
    properties = set(data_names).union(*(text.properties for text in texts.values()))
    fixed = {*kept, *SCRIPT_WORDS, *WGSL_WORDS}
    counts: Counter[str] = Counter()
    variables: dict[Scope, set[str]] = defaultdict(set)
    for group in ({SCRIPT: script}, wgsl):
        shared = set().union(*(text.shared for text in group.values()))
        declared = properties if SCRIPT in group else set().union(*(text.properties for text in group.values()))
        for key, text in group.items():
            for name, role, scope in zip(text.tokens, text.roles, text.scopes, strict=True):
                if role is None or (role is VARIABLE and name in local.get((key, scope), ())):
                    continue
                counts[name] += 1
                if role is not PROPERTY:
                    variables[key, scope].add(name)
                is_known = role is VARIABLE and (name in shared or name in text.local.get(scope, ()))
                if not is_known and (role is VARIABLE or name not in declared):
                    fixed.add(name)
    taken = fixed | {name for name in counts if len(name) < 3}
    names = sorted({name for name in counts if len(name) > 1} - fixed, key=lambda name: (-counts[name], name))
    pairs = (first + second for first in _FIRST for second in _SECOND if first + second not in taken)
    letters = (letter for letter in _LETTERS if letter not in taken)
    everywhere = set().union(*variables.values())
    chosen = {name: next(letters, "") for name in names if name not in everywhere}
    chosen = {name: chosen.get(name) or next(pairs) for name in names}
    spare = [next(pairs) for _ in range(max(map(len, local.values()), default=0))]
    return ShortNames(chosen, {scope: _name_local(local[scope], variables[scope], spare) for scope in local})


def _find_local(text: NamedText) -> dict[int, list[str]]:
    """Return, by scope, the variables that are nothing but that, in their order."""
    others: dict[int, set[str]] = defaultdict(set)
    found: dict[int, dict[str, None]] = defaultdict(dict)
    for name, role, scope in zip(text.tokens, text.roles, text.scopes, strict=True):
        if role is BOTH:
            others[scope].add(name)
        elif role is VARIABLE and name in text.local.get(scope, ()) and name not in text.shared:
            found[scope][name] = None
    return {scope: [name for name in names if name not in others[scope]] for scope, names in found.items()}


def _name_local(names: Sequence[str], others: Collection[str], spare: Sequence[str]) -> dict[str, str]:
    """Return names for the variables of a scope, which has `others` too; those of one letter stay."""
    letters = (letter for letter in _LETTERS if letter not in others and letter not in names)
    new = itertools.chain(letters, spare)
    return {name: name if len(name) == 1 else next(new) for name in names}
