"""The errors that purcell raises on misuse; a numerical outcome is a value, never an exception."""


class PurcellError(Exception):
    """Base of every error that purcell raises on purpose."""


class PurcellWarning(UserWarning):
    """What was read or asked for and could be meant otherwise; the message says what was made of it."""


class ParameterError(PurcellError, ValueError):
    """A number or array that no swimmer, shape or motion can have."""


def refuse_types(**given: tuple[object, type]) -> None:
    """Refuse what is not of the type that is wanted.

    Args:
        given: What is given, and its type, by what it is called.

    Raises:
        ParameterError: One is of another type.
    """
    for name, (value, wanted) in given.items():
        if not isinstance(value, wanted):
            article = "an" if wanted.__name__[0] in "AEIOU" else "a"
            raise ParameterError(f"{name}: {article} {wanted.__name__} is wanted, found {value!r:.80}")


class PointError(ParameterError):
    """A point of a line that cannot be.

    Args:
        message: What is wrong.
        point: The point's index, from 0.
        wanted: What is wanted.
        found: What was found.
    """

    def __init__(self, message: str, point: int, wanted: str, found: str) -> None:
        super().__init__(message)
        self.point, self.wanted, self.found = point, wanted, found


class InputError(PurcellError, ValueError):
    """A file that does not say what purcell needs; the message names file, line and key."""


class UnknownNameError(PurcellError, LookupError):
    """A name that nothing answers to; the message proposes the nearest."""


class GaitError(PurcellError, ArithmeticError):
    """A stored gait whose free angles have no solution at the amplitude asked for."""


class MissingPackageError(PurcellError, ImportError):
    """An optional package that is not installed; the message says how to install it."""


class ResultsError(PurcellError, OSError):
    """Results that cannot be kept: a full disk, a folder that cannot be written to, workers that do not start."""


class StoppedError(PurcellError, RuntimeError):
    """Work that was interrupted; the message says what is done and how to go on."""
