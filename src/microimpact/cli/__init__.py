"""The command ``microimpact``: impacts, capture velocities, measurements."""

from __future__ import annotations

import sys
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec

import click

from microimpact.cli.contacts import (
    capture_command,
    export_command,
    materials_command,
    simulate_command,
)
from microimpact.cli.measured import calibrate_command, fit_command, reduce_command
from microimpact.cli.output import echo
from microimpact.cli.reference import reference_command, verify_command
from microimpact.core.extras import missing


def main() -> None:
    """Run the command ``microimpact``."""
    run(commands)


def run(group: click.Group) -> None:
    """Run a group of commands; bad input ends with one line and exit code 2, a failure with 1."""
    try:
        group.main(standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        sys.exit(error.exit_code)
    except click.ClickException as error:
        echo(f"microimpact: {error.format_message()}", err=True)
        sys.exit(error.exit_code)
    except click.Abort:
        sys.exit(130)
    except ModuleNotFoundError as error:
        echo(f"microimpact: {missing(error)}", err=True)
        sys.exit(2)
    except OSError as error:
        message = f"{error.filename}: {error.strerror}" if error.filename else error
        echo(f"microimpact: {message}", err=True)
        sys.exit(2)
    except (ValueError, TypeError) as error:
        echo(f"microimpact: {error}", err=True)
        sys.exit(2)
    except RuntimeError as error:
        # An integration that failed: no fault of the input.
        echo(f"microimpact: {error}", err=True)
        sys.exit(1)


class _Extensible(click.Group):
    """Own commands, and those that other packages register as entry points."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted({*super().list_commands(ctx), *_registered()})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        command = super().get_command(ctx, cmd_name)
        if command is None and cmd_name in (registered := _registered()):
            command = registered[cmd_name].load()
        return command


def _registered() -> dict[str, EntryPoint]:
    """Entry points of commands whose packages are here."""
    points = entry_points(group="microimpact.commands")
    return {point.name: point for point in points if find_spec(point.module.partition(".")[0])}


@click.group(
    cls=_Extensible,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="microimpact")
def commands() -> None:
    """Impact, rebound and capture of microparticles on surfaces.

    Pairs of particle and surface come from the declared tables (see 'microimpact materials'); every
    number can be replaced by an option. Input is refused with one line that says what is allowed.
    """


@click.command("warm-up", short_help="Compile the models once.")
def warm_up_command() -> None:
    """Compile the models once, in about half a minute, so that no later command has to."""
    from microimpact.lab.warm import main as compile_all

    compile_all()


for _command in (
    simulate_command,
    capture_command,
    reduce_command,
    fit_command,
    calibrate_command,
    export_command,
    materials_command,
    reference_command,
    verify_command,
    warm_up_command,
):
    commands.add_command(_command)
