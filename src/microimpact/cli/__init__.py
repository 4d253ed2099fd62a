"""The command ``microimpact``: impacts, capture velocities, measurements; results compared."""

from __future__ import annotations

import sys

import click

from microimpact.cli.contacts import (
    capture_command,
    export_command,
    materials_command,
    simulate_command,
)
from microimpact.cli.measured import calibrate_command, fit_command
from microimpact.report.commands import COMMANDS as RESULTS


def main() -> None:
    """Run the command; bad input ends with one line and exit code 2, a failure with 1."""
    try:
        commands.main(standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        sys.exit(error.exit_code)
    except click.ClickException as error:
        click.echo(f"microimpact: {error.format_message()}", err=True)
        sys.exit(error.exit_code)
    except click.Abort:
        sys.exit(130)
    except ModuleNotFoundError as error:
        extra = "plot" if error.name == "matplotlib" else "study"
        click.echo(f"microimpact: needs {error.name}: pip install 'microimpact[{extra}]'", err=True)
        sys.exit(2)
    except OSError as error:
        told = f"{error.filename}: {error.strerror}" if error.filename else error
        click.echo(f"microimpact: {told}", err=True)
        sys.exit(2)
    except (ValueError, TypeError) as error:
        click.echo(f"microimpact: {error}", err=True)
        sys.exit(2)
    except RuntimeError as error:
        # An integration that failed: no fault of the input.
        click.echo(f"microimpact: {error}", err=True)
        sys.exit(1)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="microimpact")
def commands() -> None:
    """Impact, rebound and capture of microparticles on surfaces.

    Pairs of particle and surface come from the declared tables (see 'microimpact materials'); every
    number can be replaced by an option. Input is refused with one line that says what is allowed.
    """


for _command in (
    simulate_command,
    capture_command,
    fit_command,
    calibrate_command,
    export_command,
    materials_command,
    *RESULTS,
):
    commands.add_command(_command)
