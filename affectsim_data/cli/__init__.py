"""The `affectsim` command."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable

import tyro

from affectsim_data.cli.acquiring import acquire
from affectsim_data.cli.building import build
from affectsim_data.cli.cards import card
from affectsim_data.cli.describing import info
from affectsim_data.cli.evaluating import evaluate, report
from affectsim_data.cli.predicting import predict
from affectsim_data.cli.showing import demo, doctor, inspect
from affectsim_data.cli.transfers import download, plan, upload
from affectsim_data.cli.validating import validate

__all__ = ["main"]

_COMMANDS: dict[str, Callable[..., int]] = {
    "doctor": doctor,
    "demo": demo,
    "build": build,
    "validate": validate,
    "info": info,
    "card": card,
    "plan": plan,
    "download": download,
    "upload": upload,
    "inspect": inspect,
    "acquire": acquire,
    "predict": predict,
    "evaluate": evaluate,
    "report": report,
}


def main(arguments: list[str] | None = None) -> int:
    """Runs a command; errors a user can mend are one line, not a traceback.

    Args:
        arguments: Command line without the program name; that of the process if not given.
    """
    from affectsim_data.errors import ForkedContextError, RendererUnavailableError

    expected = (
        *(ValueError, KeyError, OSError, ImportError),
        *(RendererUnavailableError, ForkedContextError),
    )
    try:
        status: int = tyro.extras.subcommand_cli_from_dict(
            _COMMANDS,
            prog="affectsim",
            description="Replayable affective episodes, seen as you ask.",
            args=arguments,
        )
        return status
    except BrokenPipeError:  # whoever read our output has had enough: `affectsim info | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except expected as error:
        if os.environ.get("AFFECTSIM_TRACEBACK"):
            raise
        message = error.args[0] if isinstance(error, KeyError) and error.args else error
        print(f"affectsim: {message}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("affectsim: interrupted; nothing half-written is left", file=sys.stderr)
        return 130
