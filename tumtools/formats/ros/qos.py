# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Quality of service of topics, as rosbag2 keeps it beside them.

Up to version 8 of its metadata, rosbag2 keeps a YAML text with the numbers of `rmw/types.h`, which is all
that Humble's parser reads; from version 9 on it keeps words. There is one profile for each publisher.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

_FOREVER: Final = "\n    sec: 9223372036\n    nsec: 854775807\n"
"""RMW_DURATION_INFINITE."""

_PROFILE: Final = (
    "- history: {history}\n  depth: {depth}\n  reliability: {reliability}\n  durability: {durability}\n"
    f"  deadline:{_FOREVER}  lifespan:{_FOREVER}"
    f"  liveliness: {{liveliness}}\n  liveliness_lease_duration:{_FOREVER}"
    "  avoid_ros_namespace_conventions: false"
)
_NUMBERS: Final = {"history": "1", "reliability": "1", "liveliness": "1"}
_WORDS: Final = {"history": "keep_last", "reliability": "reliable", "liveliness": "automatic"}

_POLICIES: Final = {
    "reliability": ("system_default", "reliable", "best_effort", "unknown", "best_available"),
    "durability": ("system_default", "transient_local", "volatile", "unknown", "best_available"),
    "history": ("system_default", "keep_last", "keep_all", "unknown"),
    "liveliness": (
        "system_default", "automatic", "manual_by_node", "manual_by_topic", "unknown", "best_available",
    ),
}  # fmt: skip
"""Words of each policy, at the places that their numbers say."""
_DURATIONS: Final = ("deadline", "lifespan", "liveliness_lease_duration")
_SILENT: Final = frozenset({"system_default", "unknown", "false", "null", "~", ""})
"""Values that say nothing."""
_NO_LIMIT_S: Final = 0x7FFF_FFFF
"""Seconds from which on a duration is without end: each middleware of Foxy wrote another one."""
_MAX_LETTERS: Final = 1 << 16
"""A text that is longer is not looked at; a profile has about 400."""
_MAX_DIGITS: Final = 20
_SHOWN_LETTERS: Final = 40
_SHOWN_OF_PROFILE: Final = 200
_NOT_READ: Final = "profiles that cannot be read"


def qos_profile(*, latched: bool, words: bool = False) -> str:
    """Return the profile of a reliable topic, as YAML.

    Args:
        latched: Late subscribers get the last message (transient local).
        words: Write words instead of numbers.

    """
    number, word = ("1", "transient_local") if latched else ("2", "volatile")
    fields = _WORDS if words else _NUMBERS
    return _PROFILE.format(depth=1 if latched else 10, durability=word if words else number, **fields)


def is_latched(profiles: str) -> bool:
    """Tell whether a profile, as numbers or words, is transient local."""
    lines = [line.strip() for line in profiles.splitlines()]
    return "durability: 1" in lines or "durability: transient_local" in lines


def beyond_ours(texts: Iterable[str], *, latched: bool) -> tuple[str, ...]:
    """Return what profiles say that the one we write does not, a text for each profile that differs.

    Args:
        texts: YAML, each with any number of profiles, as numbers or words; other texts do no harm.
        latched: Which of the profiles that we write they are held against.

    """
    ours = [qos_profile(latched=latched, words=words) for words in (False, True)]
    others = [text for text in dict.fromkeys(texts) if text and text not in ours]
    if not others:
        return ()
    (known,) = _profiles(ours[0])
    left = [[one for one in said if one not in known] for text in others for said in _profiles(text)]
    return tuple(dict.fromkeys(", ".join(said)[:_SHOWN_OF_PROFILE] for said in left if said))


def _profiles(text: str) -> list[list[str]]:
    """Return what each profile of a text says."""
    import yaml  # noqa: PLC0415 - only for what we have not written

    from tumtools.formats import safe_yaml  # noqa: PLC0415 - likewise

    if len(text) > _MAX_LETTERS:
        return [[_NOT_READ]]
    try:
        found = safe_yaml.load_texts(text)
    except (yaml.YAMLError, RecursionError):
        return [[_NOT_READ]]
    if found is None or (isinstance(found, str) and found in _SILENT):
        return []
    if not isinstance(found, list):
        return [[_NOT_READ]]
    return [list(_said(profile)) if isinstance(profile, dict) else [_NOT_READ] for profile in found]


def _said(profile: dict[str, object]) -> Iterator[str]:
    """Yield what a profile says, whatever its spelling and order."""
    history = _word("history", profile.get("history"))
    for key in (*_POLICIES, *sorted(profile.keys() - _POLICIES.keys())):
        value = profile.get(key)
        if value is None or (isinstance(value, str) and value.lower() in _SILENT):
            continue
        if key in _POLICIES:
            word = _word(key, value)
            if word not in _SILENT:
                yield word if word in _POLICIES[key] else f"{key} {word}"
        elif key == "depth":
            # Of a history that is not known the depth is none, and one that keeps all has none.
            if value != "0" and history not in {"unknown", "keep_all"}:
                yield f"depth {_shown(value)}"
        elif key in _DURATIONS:
            yield from _limit(key, value)
        else:
            yield f"{key} {_shown(value)}"


def _word(key: str, value: object) -> str:
    """Return the word of a policy, which may come as a number."""
    number, words = _number(value), _POLICIES[key]
    return words[number] if number is not None and number < len(words) else _shown(value)


def _limit(key: str, value: object) -> Iterator[str]:
    """Yield a duration, if it is one that has an end: 0 stands for none."""
    seconds, rest = (
        _number(value.get(unit)) if isinstance(value, dict) else None for unit in ("sec", "nsec")
    )
    if seconds is None or rest is None:
        yield f"{key} {_shown(value)}"
    elif (seconds or rest) and seconds < _NO_LIMIT_S:
        yield f"{key} {seconds + rest / NANOSECONDS_PER_SECOND:g} s"


def _number(value: object) -> int | None:
    if not isinstance(value, str) or len(value) > _MAX_DIGITS:
        return None
    return int(value) if value.isascii() and value.isdigit() else None


def _shown(value: object) -> str:
    # What is no text may be a list of lists of lists that are the same, and endless when printed.
    return value.lower()[:_SHOWN_LETTERS] if isinstance(value, str) else "that cannot be read"
