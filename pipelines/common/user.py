"""How scripts end: one message for what the user can mend, and the exit code for it."""
import sys

from files import UserError


def call(program, run, arguments):
    """The exit code of `run(arguments)`; an error of a file is one line, and no traceback."""
    try:
        return run(arguments)
    except UserError as error:
        message = str(error)
    except UnicodeDecodeError:
        message = "a file is no text in UTF-8"
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            return 0
        message = f"{error.filename}: {error.strerror}" if error.filename else str(error)
    except KeyboardInterrupt:
        return 130
    print(f"{program}: {message}", file=sys.stderr)
    return 3
