"""What an argument may be. Where it is something else, a ValueError has its name, its value and the cure."""

import math
import reprlib


def wrong(name, value, cure):
    """The error of an argument."""
    return ValueError(f"{name}={' '.join(reprlib.repr(value).split())}: {cure}")


def number(name, value, cure="give a number", right=math.isfinite):
    """The value as a number that is right."""
    try:
        told = math.nan if isinstance(value, (str, bytes)) else float(value)
    except (TypeError, ValueError, OverflowError):
        told = math.nan
    if not (math.isfinite(told) and right(told)):
        raise wrong(name, value, cure)
    return told


def positive(name, value):
    """The value as a number above 0."""
    return number(name, value, "give a number above 0", lambda x: x > 0)


def not_negative(name, value, cure="give a number of 0 or more"):
    """The value as a number of 0 or more."""
    return number(name, value, cure, lambda x: x >= 0)


def whole(name, value, least, most, cure=None):
    """The value as a whole number from `least` to `most`."""
    number(name, value, cure or f"give a whole number from {least} to {most}", lambda x: x.is_integer() and least <= x <= most)
    return int(value)


def one_of(name, value, choices):
    """The value, which is one of these words."""
    if not isinstance(value, str) or value not in choices:
        raise wrong(name, value, f"choose {', '.join(choices[:-1])} or {choices[-1]}")
    return value


def pair(name, value, check=number):
    """The value as two numbers."""
    try:
        low, high = () if isinstance(value, (str, bytes)) else value
    except (TypeError, ValueError):
        raise wrong(name, value, "give (low, high)") from None
    return check(name, low), check(name, high)


def maybe(check, name, value, *more):
    """None, or the value as the check has it."""
    return None if value is None else check(name, value, *more)
