"""Error model of the imaging system, against its frames and against theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import stats
from tests.microimpact.lab.ptis.imaging_cases import (
    INSTRUMENT,
    generator,
    impacts,
    modelled_events,
    setup_for,
)

from microimpact.lab.ptis import errors
from microimpact.lab.ptis.experiment import photographed
from microimpact.lab.ptis.exposure import CAPTURED, MEASURED, OFF_SHEET
from microimpact.lab.ptis.system import Systematics, draw_systematics, event_generator

EXACT = Systematics()


@dataclass(frozen=True)
class One:
    """What the model tells of one event."""

    velocities: np.ndarray
    covariance: np.ndarray
    dashes: np.ndarray


def theory(events, setup, rng, shared):
    """What the model tells of every event that is measured; else why it is not."""
    draws = [event_generator(rng, i) for i in range(len(events))]
    fates, found = errors.theory(events, setup, shared, draws)
    measured = zip(found.velocities, found.covariance, found.dashes, strict=True)
    return [One(*next(measured)) if fate == MEASURED else fate for fate in fates]


@pytest.mark.parametrize(("speed", "angle"), [(1.66, 60.0), (0.45, 45.0), (0.45, 20.0)])
def test_expected_velocities_are_the_true_ones(speed, angle):
    events, setup = impacts(speed, angle, 20), setup_for(speed, angle)
    found = [t for t in theory(events, setup, generator(), EXACT) if isinstance(t, One)]
    assert len(found) > 6
    # The centroid of a dash under gravity lies off its middle by the same for all of a leg:
    # g / 24 f^2 / 4 shifts the contact, hardly the velocity.
    for one in found:
        assert one.velocities == pytest.approx(events.in_plane.velocities[0], rel=2e-4)


def test_jitter_alone_gives_the_textbook_error_of_a_slope():
    setup = setup_for(1.66, 60.0)
    found = next(
        t for t in theory(impacts(1.66, 60.0, 8), setup, generator(), EXACT) if isinstance(t, One)
    )
    n = found.dashes[0]
    along = found.velocities[0] / np.linalg.norm(found.velocities[0])
    sd = np.sqrt(along @ found.covariance[0] @ along)
    # Positions off by v * jitter / f, n (n^2 - 1) / 12 = sum of (k - mean)^2; noise adds a little.
    jitter = 0.002 * 1.66 / np.sqrt(n * (n**2 - 1) / 12)
    assert jitter < sd < 1.5 * jitter


@pytest.mark.parametrize(("speed", "angle", "seed"), [(1.66, 75.0, 1), (1.05, 45.0, 2)])
def test_frames_scatter_about_the_model_as_it_says(speed, angle, seed):
    n = 70
    events, setup = impacts(speed, angle, n, seed=seed), setup_for(speed, angle)
    rng = generator(seed)
    errors = draw_systematics(INSTRUMENT, rng)
    model = theory(events, setup, rng, errors)
    seen = photographed(events, setup, errors, rng).reduced(setup)
    agree = [
        (fate == MEASURED) == isinstance(t, One) for fate, t in zip(seen.fates, model, strict=True)
    ]
    assert np.mean(agree) > 0.94
    z = []
    for event, found in zip(seen.measured.event, seen.measured.velocities, strict=True):
        one = model[event]
        if isinstance(one, One):
            root = np.linalg.cholesky(one.covariance)
            z.append(np.linalg.solve(root, (found - one.velocities)[..., None])[..., 0])
    z = np.array(z)
    assert len(z) > 35
    # Four components: each scatters by 1 and about 0, as a normal variable.
    assert np.all(np.abs(z.mean(axis=0)) < 4.0 / np.sqrt(len(z)))
    assert np.all((z.std(axis=0) > 0.75) & (z.std(axis=0) < 1.35))
    assert stats.kstest(z.ravel(), stats.norm.cdf).pvalue > 1e-3


def test_modelled_events_scatter_as_their_covariance_says():
    n = 300
    events, setup = impacts(1.66, 60.0, n), setup_for(1.66, 60.0)
    drawn = modelled_events(events, setup)
    model = theory(events, setup, generator(1), EXACT)
    assert tuple(f == MEASURED for f in drawn.fates) == tuple(isinstance(t, One) for t in model)
    z = []
    for event, found in zip(drawn.measured.event, drawn.measured.velocities, strict=True):
        root = np.linalg.cholesky(model[event].covariance)
        off = (found - model[event].velocities)[..., None]
        z.append(np.linalg.solve(root, off).ravel())
    z = np.array(z)
    assert np.cov(z.T) == pytest.approx(np.eye(4), abs=5 / np.sqrt(len(z)))


def test_losses_by_geometry():
    n, setup = 10, setup_for(1.66, 60.0)
    captured = impacts(1.66, 60.0, n, captured=np.ones(n, dtype=bool))
    assert modelled_events(captured, setup).fates == (CAPTURED,) * n
    aside = impacts(1.66, 60.0, n, side=0.8)
    assert modelled_events(aside, setup).fates == (OFF_SHEET,) * n
    # Rebounds too slow to keep their dashes apart, and tracks upon each other.
    touching = impacts(1.66, 60.0, n, restitution=0.2, kept=0.3)
    assert MEASURED not in modelled_events(touching, setup).fates
    assert MEASURED not in modelled_events(impacts(1.66, 88.5, n), setup_for(1.66, 88.5)).fates
